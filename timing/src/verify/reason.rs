//! Why a job is late: what it waited for, since when, and who had it meanwhile.

use num_rational::Ratio;

use super::Group;
use super::units::to_f64;
use crate::explore::{Moment, MomentKind, Run};
use crate::report::{Awaited, Delay, Holder, TaskId};
use crate::system::TimedSystem;

/// Somebody waits: for the locks of a codel, or for a core.
struct Wait {
    codel: Option<usize>,
    from: u64,
}

/// Somebody has a core, or executes a codel and so has its locks.
struct Possession {
    codel: Option<usize>,
    by: String,
    from: u64,
    until: u64,
}

impl Group<'_> {
    /// The waits of the last job of a task in a run, each with those who kept it waiting.
    pub(super) fn reason(&self, run: &Run, task: Option<TaskId>) -> Vec<Delay> {
        let Some(task) = task.and_then(|it| self.built.tasks.get(&it)) else {
            return Vec::new();
        };
        let system = &self.built.system;
        let followed = Followed::new(system, &run.moments(system), *task, run.end);
        let factor = system.unit / self.unit;
        let time = |at: u64| to_f64(factor * Ratio::from_integer(i128::from(at)));
        let path = |codel: usize| system.codels[codel].path.clone();
        let delay = |(wait, until): &(Wait, u64)| {
            let has = |it: &&Possession| match (wait.codel, it.codel) {
                (Some(own), Some(other)) => system.codels[own].conflicts.contains(other),
                (None, None) => true,
                _ => false,
            };
            // Who had it when the wait began counts, and whoever took it after that, also for no time.
            let meanwhile = |it: &&Possession| it.from < *until && it.until > wait.from;
            let held = followed.possessions.iter().filter(has).filter(meanwhile);
            let held = held.map(|it| Holder {
                codel: it.codel.map(path),
                by: it.by.clone(),
                from: time(it.from),
                until: time(it.until),
            });
            Delay {
                awaited: match wait.codel {
                    Some(_) => Awaited::Lock,
                    None => Awaited::Core,
                },
                codel: wait.codel.map(path),
                from: time(wait.from),
                until: time(*until),
                held: held.collect(),
            }
        };
        followed.waits.iter().map(delay).collect()
    }
}

/// What a run says about waiting and having.
struct Followed {
    /// Of the last job of the task, those that took time, with their ends.
    waits: Vec<(Wait, u64)>,
    /// Of everybody.
    possessions: Vec<Possession>,
}

impl Followed {
    fn new(system: &TimedSystem, moments: &[Moment], task: usize, end: u64) -> Self {
        let mut out = Followed {
            waits: Vec::new(),
            possessions: Vec::new(),
        };
        let mut waiting: Option<Wait> = None;
        for it in moments {
            let own = it.task == Some(task);
            // Who executes: a task, or the control task of a component.
            let by = match it.task {
                Some(task) => system.task_path(task),
                None => it.component.clone(),
            };
            match it.kind {
                MomentKind::Release if own => {
                    out.waits.clear();
                    waiting = system.needs_core(task).then_some(Wait {
                        codel: None,
                        from: it.time,
                    });
                }
                // Once for each who was faster.
                MomentKind::Wait
                    if own && waiting.as_ref().is_some_and(|wait| wait.codel == it.codel) => {}
                MomentKind::Wait if own => {
                    waiting = Some(Wait {
                        codel: it.codel,
                        from: it.time,
                    });
                }
                MomentKind::Begin | MomentKind::Grant => {
                    if own && let Some(wait) = waiting.take() {
                        out.waits.push((wait, it.time));
                    }
                    out.possessions.push(Possession {
                        codel: it.codel,
                        by,
                        from: it.time,
                        until: end,
                    });
                }
                MomentKind::End | MomentKind::Complete => {
                    let mut all = out.possessions.iter_mut().rev();
                    let had = all.find(|had| had.codel == it.codel && had.by == by);
                    had.into_iter().for_each(|had| had.until = it.time);
                }
                _ => {}
            }
        }
        out.waits.extend(waiting.map(|it| (it, end)));
        out.waits.retain(|(wait, until)| *until > wait.from);
        out
    }
}
