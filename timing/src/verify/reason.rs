//! The causes of a late job: the resources it waited for, since when, and their holders.

use super::group::Group;
use crate::explore::{Moment, MomentKind, Run};
use crate::report::{Awaited, CheckReport, Delay, Holder, JobExecutions, LateJob};
use crate::system::indexed::DeclaredTask;
use crate::system::{CodelId, TaskId, ThreadName, TimedSystem};

/// A wait for the locks of a codel, or for a core.
struct Wait {
    codel: Option<CodelId>,
    from: u64,
}

/// The possession of a core, or of the locks of a codel.
struct Possession {
    codel: Option<CodelId>,
    by: ThreadName,
    from: u64,
    until: u64,
}

impl Group<'_> {
    /// Returns the job of a task that has not ended when a run ends.
    pub(super) fn late_job(&self, run: &Run, check: &CheckReport) -> Option<LateJob> {
        let system = &self.built.system;
        let task = *self.built.tasks.get(&check.id.task?)?;
        let job = run.last_job(system, task, check.kind.is_deadline())?;
        let executed = job.works.iter().map(|work| JobExecutions {
            codel: system.codels[work.codel].path.clone(),
            times: work.times,
            time: self.at(work.executed),
            preempted: self.at(work.preempted),
        });
        Some(LateJob {
            from: self.at(job.from),
            begun: self.at(job.begun),
            until: self.at(job.until),
            executed: executed.collect(),
        })
    }

    /// Returns the waits of the last job of a task in a run, each with the holders of the resource.
    pub(super) fn reason(&self, run: &Run, task: Option<DeclaredTask>) -> Vec<Delay> {
        let Some(task) = task.and_then(|task| self.built.tasks.get(&task)) else {
            return Vec::new();
        };
        let system = &self.built.system;
        let followed = Intervals::new(system, &run.moments(system), *task, run.end);
        let path = |codel: CodelId| system.codels[codel].path.clone();
        let delay = |(wait, until): &(Wait, u64)| {
            let has = |possession: &&Possession| match (wait.codel, possession.codel) {
                (Some(own), Some(other)) => system.codels[own].conflicts.contains(other),
                (None, None) => true,
                _ => false,
            };
            // Counts the holder at the beginning of the wait, and each later holder, even if it held the
            // resource for no time.
            let meanwhile =
                |possession: &&Possession| possession.from < *until && possession.until > wait.from;
            let held = followed.possessions.iter().filter(has).filter(meanwhile);
            let held = held.map(|possession| Holder {
                codel: possession.codel.map(path),
                by: possession.by.clone(),
                from: self.at(possession.from),
                until: self.at(possession.until),
            });
            Delay {
                awaited: match wait.codel {
                    Some(_) => Awaited::Lock,
                    None => Awaited::Core,
                },
                codel: wait.codel.map(path),
                from: self.at(wait.from),
                until: self.at(*until),
                held: held.collect(),
            }
        };
        followed.waits.iter().map(delay).collect()
    }
}

/// The waits and possessions of a run.
struct Intervals {
    /// Waits of the last job of the task that took time, each with its end.
    waits: Vec<(Wait, u64)>,
    /// Possessions of all threads.
    possessions: Vec<Possession>,
}

impl Intervals {
    fn new(system: &TimedSystem, moments: &[Moment], task: TaskId, end: u64) -> Self {
        let mut out = Intervals { waits: Vec::new(), possessions: Vec::new() };
        let mut waiting: Option<Wait> = None;
        for moment in moments {
            let own = moment.task == Some(task);
            // The thread: a task, or the control task of a component.
            let by = match moment.task {
                Some(task) => system.task_name(task),
                None => ThreadName::of_component(&moment.component),
            };
            match moment.kind {
                MomentKind::Release if own => {
                    out.waits.clear();
                    waiting =
                        system.needs_core(task).then_some(Wait { codel: None, from: moment.time });
                }
                // The event occurs once for each holder; only the first one counts.
                MomentKind::Wait
                    if own && waiting.as_ref().is_some_and(|wait| wait.codel == moment.codel) => {}
                MomentKind::Wait if own => {
                    waiting = Some(Wait { codel: moment.codel, from: moment.time });
                }
                MomentKind::Begin | MomentKind::Grant => {
                    if own && let Some(wait) = waiting.take() {
                        out.waits.push((wait, moment.time));
                    }
                    out.possessions.push(Possession {
                        codel: moment.codel,
                        by,
                        from: moment.time,
                        until: end,
                    });
                }
                MomentKind::End | MomentKind::Complete => {
                    let mut all = out.possessions.iter_mut().rev();
                    if let Some(had) = all.find(|had| had.codel == moment.codel && had.by == by) {
                        had.until = moment.time;
                    }
                }
                _ => {}
            }
        }
        out.waits.extend(waiting.map(|wait| (wait, end)));
        out.waits.retain(|(wait, until)| *until > wait.from);
        out
    }
}
