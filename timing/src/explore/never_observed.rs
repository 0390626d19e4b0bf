//! Jobs and atoms that occur in no run of a system: a proof about them is vacuous.

use super::rules::Rules;
use super::state::{State, TaskStatus};
use super::watch::Watch;
use crate::property::Atom;
use crate::system::TaskId;

/// The tasks without a job, and the atoms that never hold, among the subjects of a [`Watch`].
#[derive(Debug, Clone, Default)]
pub struct NeverObserved {
    jobs: Vec<TaskWithoutJob>,
    atoms: Vec<Atom>,
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
    pub(super) fn of(watch: &Watch) -> NeverObserved {
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
        let mut atoms = Vec::new();
        for predicate in watch.reach.iter().chain(monitored) {
            predicate.atoms(&mut |atom| {
                if !atoms.contains(atom) {
                    atoms.push(atom.clone());
                }
            });
        }
        NeverObserved { jobs, atoms }
    }

    /// Removes the subjects that occur in a state.
    pub(super) fn look(&mut self, rules: &Rules, s: &State) {
        self.jobs.retain(|job| rules.job(s, usize::from(job.task)) == TaskStatus::Idle);
        for job in &mut self.jobs {
            let now = rules.awaits_start_up(s, job.task);
            // Tasks are started in order, so the later one counts.
            job.start_up = job.start_up.zip(now).map(|(one, other)| one.max(other));
        }
        self.atoms.retain(|atom| !rules.atom(s, atom));
    }

    /// Returns the reason why a task has no job; `None` if the task has a job.
    pub fn job(&self, task: TaskId) -> Option<TaskWithoutJob> {
        self.jobs.iter().copied().find(|job| job.task == task)
    }

    /// Returns true if an atom never holds.
    pub fn has(&self, atom: &Atom) -> bool {
        self.atoms.contains(atom)
    }
}
