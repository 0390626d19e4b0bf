//! What no run of a system has: a proof about it says nothing.

use super::reductions::Orbits;
use super::rules::Rules;
use super::state::{State, TaskStatus};
use super::watch::Watch;
use crate::property::{Atom, Predicate};

/// Of what a [`Watch`] asks about, the tasks without a job and the atoms that never hold.
#[derive(Debug, Clone, Default)]
pub struct Absent {
    jobs: Vec<NoJob>,
    atoms: Vec<Atom>,
}

/// A task of which no job is ever released.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoJob {
    task: usize,
    /// The task whose start-up it waits for in the run that comes furthest; `None` if that is over.
    pub start_up: Option<usize>,
}

impl Absent {
    /// Everything, before any state is known.
    pub(super) fn of(watch: &Watch) -> Absent {
        let responses = watch.response.iter().map(|it| &it.task);
        let tasks = watch.schedulable.iter().chain(&watch.overdue);
        let mut jobs: Vec<NoJob> = Vec::new();
        for &task in tasks.chain(responses) {
            if jobs.iter().all(|it| it.task != task) {
                let start_up = Some(0);
                jobs.push(NoJob { task, start_up });
            }
        }
        Absent {
            jobs,
            ..Absent::of_predicates(&watch.reach)
        }
    }

    /// The atoms of predicates.
    pub(super) fn of_predicates(predicates: &[Predicate]) -> Absent {
        let mut out = Absent::default();
        for it in predicates {
            it.atoms(&mut |atom| {
                if !out.atoms.contains(atom) {
                    out.atoms.push(atom.clone());
                }
            });
        }
        out
    }

    /// Removes what a state has.
    pub(super) fn look<R: Rules>(&mut self, rules: &R, s: &State, orbits: &Orbits) {
        let has_job = |&task: &usize| rules.job(s, task) != TaskStatus::Idle;
        self.jobs
            .retain(|it| !orbits.of_task(it.task).iter().any(has_job));
        for it in &mut self.jobs {
            let now = rules.awaits_start_up(s, it.task);
            // Tasks are started in order.
            it.start_up = it.start_up.zip(now).map(|(one, other)| one.max(other));
        }
        self.atoms.retain(|it| !rules.atom(s, it));
    }

    /// Whether a task has no job, and why.
    pub fn job(&self, task: usize) -> Option<NoJob> {
        self.jobs.iter().copied().find(|it| it.task == task)
    }

    /// Whether an atom never holds.
    pub fn has(&self, atom: &Atom) -> bool {
        self.atoms.contains(atom)
    }
}
