//! Jobs and atoms that occur in no run of a system: a proof about them is vacuous.

use super::reductions::Orbits;
use super::rules::Rules;
use super::state::{State, TaskStatus};
use super::watch::Watch;
use crate::property::{Atom, Predicate};
use crate::system::TaskId;

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
    task: TaskId,
    /// Task whose start-up the task awaits in the run that comes furthest; `None` if the start-up is over.
    pub start_up: Option<TaskId>,
}

impl NeverObserved {
    /// Returns all subjects, before any state is known.
    pub(super) fn of(watch: &Watch, orbits: &Orbits) -> NeverObserved {
        let responses = watch.response.iter().map(|response| &response.task);
        let tasks = watch.schedulable.iter().chain(&watch.overdue);
        let mut jobs: Vec<TaskWithoutJob> = Vec::new();
        for &task in tasks.chain(responses) {
            if jobs.iter().all(|job| job.task != task) {
                let start_up = Some(TaskId::default());
                jobs.push(TaskWithoutJob { task, start_up });
            }
        }
        let monitored = watch.monitors.iter().flat_map(|monitor| &monitor.predicates);
        let predicates: Vec<Predicate> = watch.reach.iter().chain(monitored).cloned().collect();
        NeverObserved { jobs, ..NeverObserved::of_predicates(&predicates, orbits) }
    }

    /// Returns the atoms of predicates.
    pub(super) fn of_predicates(predicates: &[Predicate], orbits: &Orbits) -> NeverObserved {
        let mut out = NeverObserved::default();
        for predicate in predicates {
            predicate.atoms(&mut |atom| {
                if out.atoms.iter().all(|candidate| candidate.0 != *atom) {
                    out.atoms.push((atom.clone(), orbits.of_atom(atom)));
                }
            });
        }
        out
    }

    /// Removes the subjects that occur in a state.
    pub(super) fn look<R: Rules>(&mut self, rules: &R, s: &State, orbits: &Orbits) {
        let has_job = |&task: &usize| rules.job(s, task) != TaskStatus::Idle;
        self.jobs.retain(|job| !orbits.of_task(usize::from(job.task)).iter().any(has_job));
        for job in &mut self.jobs {
            let now = rules.awaits_start_up(s, job.task);
            // Tasks are started in order, so the later one counts.
            job.start_up = job.start_up.zip(now).map(|(one, other)| one.max(other));
        }
        self.atoms.retain(|(atom, alike)| {
            !rules.atom(s, atom) && !alike.iter().any(|atom| rules.atom(s, atom))
        });
    }

    /// Returns the reason why a task has no job; `None` if the task has a job.
    pub fn job(&self, task: TaskId) -> Option<TaskWithoutJob> {
        self.jobs.iter().copied().find(|job| job.task == task)
    }

    /// Returns true if an atom never holds.
    pub fn has(&self, atom: &Atom) -> bool {
        self.atoms.iter().any(|candidate| candidate.0 == *atom)
    }
}
