//! What the last job of a task in a run did, codel by codel.

use super::rules::{Action, Rules, Work};
use super::run::{Run, advance};
use super::state::{Clocks, State, TaskStatus};
use crate::system::{CodelId, TaskId, Ticks, TimedSystem};

/// The last job of a task in a run, up to the end of the run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct LastJob {
    /// Time of its tick or wake-up, in base units.
    pub(crate) from: u64,
    /// Time at which it could begin, in base units: later than its tick if the job before had not ended.
    pub(crate) begun: u64,
    /// End of the run in base units.
    pub(crate) until: u64,
    /// The codels that it executed, in order of their first execution.
    pub(crate) works: Vec<JobWork>,
}

/// The executions of one codel in a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct JobWork {
    pub(crate) codel: CodelId,
    /// Number of executions, the last of which may not have ended.
    pub(crate) times: u32,
    /// Time with a core, in base units.
    pub(crate) executed: u64,
    /// Time without a core, because other threads had it, in base units.
    pub(crate) preempted: u64,
}

impl Run {
    /// Returns the last job of a task; `None` if the task has no measured job at the end of the run.
    /// `deadline`: the run ends at the deadline of the job, one period after its tick.
    pub(crate) fn last_job(
        &self,
        system: &TimedSystem,
        task: TaskId,
        deadline: bool,
    ) -> Option<LastJob> {
        let period = system.tasks[task].period.filter(|_| deadline);
        let task = usize::from(task);
        let clocks = Clocks { response: vec![true; system.tasks.len()], ..Clocks::default() };
        let rules = Rules::new(system).with_clocks(&clocks);
        let clock = rules.frame().response[task]?;
        let mut s = rules.initial();
        let mut works: Vec<JobWork> = Vec::new();
        let (mut now, mut begun) = (0, 0);
        let mut open: Vec<Option<CodelId>> = vec![None; rules.frame().executors()];
        for step in self.steps.iter().map(Some).chain([None]) {
            let time = step.map_or(self.end, |&(time, _)| time);
            if time > now {
                let passed = time - now;
                // A start-up may last longer than the first tick, and needs no core.
                let id = TaskId::from(task);
                let is_starting = rules.job(&s, task) == TaskStatus::Waiting
                    && rules.awaits_start_up(&s, id) == Some(id);
                for (executor, open) in open.iter_mut().enumerate().filter(|_| !is_starting) {
                    let Some(codel) = codel_of(&rules, &s, executor, task) else { continue };
                    let known = *open == Some(codel);
                    let place = works.iter().position(|work| work.codel == codel);
                    let place = place.unwrap_or_else(|| {
                        works.push(JobWork { codel, times: 0, executed: 0, preempted: 0 });
                        works.len() - 1
                    });
                    let work = &mut works[place];
                    work.times += u32::from(!known);
                    if rules.progresses(&s, executor) {
                        work.executed += passed;
                    } else {
                        work.preempted += passed;
                    }
                    *open = Some(codel);
                }
                advance(&rules, &mut s, Ticks::try_from(passed).unwrap_or(Ticks::MAX));
                now = time;
            }
            let Some(&(_, action)) = step else { break };
            let clock_before = s.t[clock];
            let was = rules.job(&s, task);
            rules.apply(&mut s, action);
            // A kept tick begins the next job at once, with a smaller value of its clock.
            let begins = was == TaskStatus::Idle || s.t[clock] < clock_before;
            if rules.job(&s, task) != TaskStatus::Idle && begins {
                works.clear();
                begun = now;
            }
            if let Action::Finish { executor, .. } = action {
                open[executor] = None;
            }
        }
        let at_end = rules.job(&s, task) != TaskStatus::Idle;
        let measured = u64::from(s.t[clock].max(period.unwrap_or(0)));
        let from = self.end.saturating_sub(measured);
        at_end.then(|| LastJob { from, begun: begun.max(from), until: self.end, works })
    }
}

/// The codel of a task that an executor executes. Executors are tasks, or with jobs their activities.
fn codel_of(rules: &Rules, s: &State, executor: usize, of: usize) -> Option<CodelId> {
    match rules.work(s, executor)? {
        Work::State { codel, task, .. } if task == of => {
            rules.frame().is_executing(s, executor).then_some(codel)
        }
        _ => None,
    }
}
