//! Bounds on the time for which a task waits for a core.

use std::cmp::Reverse;

use super::demand::{Demand, Jobs, Kind, SplitWork, longest_wait};
use super::{Analysis, Window};
use crate::system::loops::can_pause;
use crate::system::{AutomatonId, Policy, ServiceId, TaskId, Ticks, Yield};
use typed_index_collections::TiSlice;

/// The longest times for which jobs of a task hold their core.
#[derive(Debug, Clone, Copy)]
pub(super) struct Held {
    pub(super) longest: Option<u64>,
    /// The times of the jobs, split.
    pub(super) split: Option<SplitWork>,
}

impl Analysis<'_> {
    /// Returns the longest time, in base units, for which a job can wait for a core, given the longest times
    /// for which jobs of all tasks hold theirs.
    pub(super) fn core_wait(
        &self,
        window: &Window,
        task: TaskId,
        held: &TiSlice<TaskId, Held>,
    ) -> Option<u64> {
        let ways = [false, true].map(|split| self.core_wait_with(window, task, held, split));
        ways.into_iter().flatten().min()
    }

    /// See [`Analysis::core_wait`]. `split`: jobs count with their [split work](SplitWork).
    fn core_wait_with(
        &self,
        window: &Window,
        task: TaskId,
        held: &TiSlice<TaskId, Held>,
        split: bool,
    ) -> Option<u64> {
        let system = self.system;
        let Some(cores) = system.platform.cores else {
            return Some(0);
        };
        if !system.needs_core(task) {
            return Some(0);
        }
        let others = system.tasks.keys().filter(|&index| index != task && system.needs_core(index));
        let mut demand = Demand::default();
        // Number of other tasks that may hold a core for ever, and of those that do so even after a single
        // grant.
        let (mut kept, mut held_for_ever) = (0, 0);
        // Under FIFO every other task has at most one earlier job.
        let mut ahead = Vec::new();
        let by_deadline =
            system.tasks[task].period.filter(|_| system.platform.policy == Policy::Edf);
        // Under EDF a job with a later deadline has a core before, or goes after.
        let mut later = Vec::new();
        for other in others {
            let Held { longest, split: split_work } = held[other];
            let work = longest.filter(|_| !self.may_be_endless(other));
            let jobs = work.and_then(|work| {
                self.jobs(other, work, 0)
                    .map(|jobs| jobs.with(split_work.filter(|_| split)))
                    .map(|jobs| self.in_phase(task, other, jobs, 0))
                    .or_else(|| self.jobs_of_requests(window, other, work))
            });
            match work {
                Some(work) => ahead.push(jobs.as_ref().map_or(work, |jobs| jobs.carried(work))),
                None => held_for_ever += 1,
            }
            match jobs {
                Some(job)
                    if by_deadline.is_some_and(|period| self.is_later(other, &job, period)) =>
                {
                    later.extend(work);
                }
                Some(job) => demand.jobs.extend((job.work + job.once > 0).then_some(job)),
                None => kept += 1,
            }
        }
        let cores = u64::from(cores);
        let left = |taken: u64| cores.checked_sub(taken).filter(|&left| left > 0);
        if let Some(period) = by_deadline {
            for job in &mut demand.jobs {
                job.released = period.checked_sub(job.period).map(u64::from);
            }
            later.sort_unstable_by_key(|&work| Reverse(work));
            later.truncate(left(kept).unwrap_or(0) as usize);
            demand.jobs.extend(later.into_iter().map(Jobs::once));
        }
        let busy = left(kept).and_then(|left| demand.longest_busy(left));
        let queue = left(held_for_ever).and_then(|left| longest_wait(left, ahead));
        match system.platform.policy {
            Policy::Fifo => busy.into_iter().chain(queue).min(),
            Policy::Edf | Policy::Any | Policy::Priority | Policy::Fair => busy,
        }
    }

    /// Returns the jobs of an aperiodic task in a window, if only requests cause them: one for each, and one
    /// for each interruption.
    fn jobs_of_requests(&self, window: &Window, task: TaskId, work: u64) -> Option<Jobs> {
        let system = self.system;
        if system.tasks[task].permanent.is_some() || system.runs_apart(task) {
            return None;
        }
        let of_service = |(service, &requests): (ServiceId, &Option<u32>)| {
            let slots = system.services[service].slots.iter();
            let mut own = slots.filter(|&&slot| system.automata[slot].task == task);
            let (Some(&slot), true) = (own.next(), requests != Some(0)) else {
                return Some(0);
            };
            let machine = system.machine_of(slot);
            let yields = machine.states.iter().flat_map(|state| &state.yields);
            let parts = 1 + u64::from(machine.stop.is_some());
            let is_one_job = yields.clone().all(|to| !matches!(to, Yield::Pause(_)));
            requests.filter(|_| is_one_job).map(|requests| u64::from(requests) * parts)
        };
        let count = window.requests.iter_enumerated().map(of_service).sum::<Option<u64>>()?;
        Some(Jobs::once(work.checked_mul(count)?))
    }

    /// Returns true if a task may execute a codel, other than in its start-up, while a job of another task
    /// has its core.
    pub(super) fn may_work_beside(&self, task: TaskId, other: TaskId) -> bool {
        let system = self.system;
        let needs_core = |task| system.needs_core(task) && !system.runs_apart(task);
        system.platform.cores != Some(1) || !needs_core(task) || !needs_core(other)
    }

    /// Returns true if the unfinished jobs of a task have a later deadline than a job with this period that
    /// is released.
    fn is_later(&self, task: TaskId, jobs: &Jobs, period: Ticks) -> bool {
        match (self.system.tasks[task].period, jobs.kind) {
            _ if self.system.runs_apart(task) => false,
            (None, _) => true,
            (Some(own), Kind::Punctual(response) | Kind::InPhase { response, .. }) => {
                u64::from(own) > u64::from(period) + response
            }
            _ => false,
        }
    }

    /// Returns true if no job of a periodic task can be under way while a job of this task has its core: all
    /// other cores are taken for ever before the first tick of any periodic task, and no codel runs without a
    /// core.
    pub(super) fn alone(&self, task: TaskId) -> bool {
        let system = self.system;
        let Some(cores) = system.platform.cores else {
            return false;
        };
        let on_cores = system.tasks.keys().filter(|&task| system.needs_core(task));
        let (periodic, endless): (Vec<TaskId>, Vec<TaskId>) =
            on_cores.partition(|&task| system.tasks[task].period.is_some());
        let first_tick = periodic.iter().map(|&index| self.first_tick(index)).min();
        let at_once = |&task: &TaskId| {
            let asks = self.started[task];
            self.always_endless(task) && asks.is_some_and(|number| Some(number) < first_tick)
        };
        periodic.contains(&task)
            && !periodic.iter().any(|&task| system.runs_apart(task))
            && endless.len() + 1 == cores as usize
            && endless.iter().all(at_once)
    }

    /// Returns true if a cycle of an aperiodic task can last for ever.
    fn may_be_endless(&self, task: TaskId) -> bool {
        let task = &self.system.tasks[task];
        task.period.is_none()
            && task.permanent.is_some_and(|a| {
                let machine = self.system.machine_of(a);
                (0..machine.states.len()).any(|state| !can_pause(machine, state))
            })
    }

    /// Returns true if the first cycle of a task always lasts for ever.
    fn always_endless(&self, task: TaskId) -> bool {
        let endless = |a: AutomatonId| self.system.machine_of(a).is_endless();
        let permanent = self.system.tasks[task].permanent;
        permanent.is_some_and(endless) && !self.system.runs_apart(task)
    }
}
