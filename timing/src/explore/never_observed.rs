//! Jobs and atoms that occur in no run of a system: a proof about them is vacuous.

use super::reductions::Orbits;
use super::rules::Rules;
use super::state::{State, TaskStatus};
use super::watch::Watch;
use crate::property::{Atom, Predicate};

/// The tasks without a job, and the atoms that never hold, among the subjects of a [`Watch`].
#[derive(Debug, Clone, Default)]
pub struct NeverObserved {
    jobs: Vec<TaskWithoutJob>,
    /// Each atom, and the atoms into which exchanges of symmetric parts turn it.
    atoms: Vec<(Atom, Vec<Atom>)>,
}

/// A task without any released job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TaskWithoutJob {
    task: usize,
    /// Task whose start-up the task awaits in the run that comes furthest; `None` if the start-up is over.
    pub start_up: Option<usize>,
}

impl NeverObserved {
    /// Returns all subjects, before any state is known.
    pub(super) fn of(watch: &Watch, orbits: &Orbits) -> NeverObserved {
        let responses = watch.response.iter().map(|it| &it.task);
        let tasks = watch.schedulable.iter().chain(&watch.overdue);
        let mut jobs: Vec<TaskWithoutJob> = Vec::new();
        for &task in tasks.chain(responses) {
            if jobs.iter().all(|it| it.task != task) {
                let start_up = Some(0);
                jobs.push(TaskWithoutJob { task, start_up });
            }
        }
        NeverObserved {
            jobs,
            ..NeverObserved::of_predicates(&watch.reach, orbits)
        }
    }

    /// Returns the atoms of predicates.
    pub(super) fn of_predicates(predicates: &[Predicate], orbits: &Orbits) -> NeverObserved {
        let mut out = NeverObserved::default();
        for it in predicates {
            it.atoms(&mut |atom| {
                if out.atoms.iter().all(|it| it.0 != *atom) {
                    out.atoms.push((atom.clone(), orbits.of_atom(atom)));
                }
            });
        }
        out
    }

    /// Removes the subjects that occur in a state.
    pub(super) fn look<R: Rules>(&mut self, rules: &R, s: &State, orbits: &Orbits) {
        let has_job = |&task: &usize| rules.job(s, task) != TaskStatus::Idle;
        self.jobs
            .retain(|it| !orbits.of_task(it.task).iter().any(has_job));
        for it in &mut self.jobs {
            let now = rules.awaits_start_up(s, it.task);
            // Tasks are started in order, so the later one counts.
            it.start_up = it.start_up.zip(now).map(|(one, other)| one.max(other));
        }
        self.atoms.retain(|(atom, alike)| {
            !rules.atom(s, atom) && !alike.iter().any(|it| rules.atom(s, it))
        });
    }

    /// Returns the reason why a task has no job; `None` if the task has a job.
    pub fn job(&self, task: usize) -> Option<TaskWithoutJob> {
        self.jobs.iter().copied().find(|it| it.task == task)
    }

    /// Returns true if an atom never holds.
    pub fn has(&self, atom: &Atom) -> bool {
        self.atoms.iter().any(|it| it.0 == *atom)
    }
}
