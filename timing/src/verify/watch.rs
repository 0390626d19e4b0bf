//! The watch list of the explorer, from the checks.

use super::bounds::ResponseBounds;
use super::checks::{Single, What};
use super::group::Group;
use crate::explore::{ResponseTime, Watch, Within};
use crate::property::{Monitor, Predicate, resolve};
use crate::scn::ast::{Pattern, Pred};
use crate::system::TaskId;

impl Group<'_> {
    /// Returns true if a check is only about events from ticks on, so that steps between ticks can be
    /// postponed.
    pub(super) fn is_about_ticks(&self, check: &Single) -> bool {
        match check.what {
            What::Schedulable(_) | What::NoOverdue(_) => true,
            What::Response(response, _) => {
                let task = self.built.tasks[&response];
                self.built.system.tasks[task].period.is_some()
            }
            _ => false,
        }
    }

    /// Returns the monitor of a pattern; `None` if a name was reported as unknown.
    pub(super) fn monitor(&self, pattern: &Pattern) -> Option<Monitor> {
        let predicates = pattern.predicates.iter();
        let predicates = predicates.map(|pred| resolve::resolve(self.names, self.built, pred).ok());
        Some(Monitor {
            kind: pattern.kind,
            predicates: predicates.collect::<Option<_>>()?,
            time: self.ticks_up(pattern.time),
        })
    }

    /// Returns the watch list for these checks, and the place of each answer.
    pub(super) fn watch(
        &self,
        checks: &[Single],
        part: impl Iterator<Item = usize>,
        analysed: &ResponseBounds,
    ) -> (Watch, Vec<(usize, usize)>) {
        let mut watch = Watch::default();
        let mut places = Vec::new();
        let predicate = |pred: &Pred| resolve::resolve(self.names, self.built, pred).ok();
        for i in part {
            let mut task = |list: fn(&mut Watch) -> &mut Vec<TaskId>, of| {
                let task = self.built.tasks[&of];
                let list = list(&mut watch);
                list.iter().position(|&other| other == task).unwrap_or_else(|| {
                    list.push(task);
                    list.len() - 1
                })
            };
            let place = match checks[i].what {
                What::Schedulable(pair) => task(|watch| &mut watch.schedulable, pair),
                What::NoOverdue(overdue) => task(|watch| &mut watch.overdue, overdue),
                What::Response(task, bound) => {
                    let response_time = ResponseTime {
                        task: self.built.tasks[&task],
                        limit: self.ticks(bound),
                        most: analysed.response(&checks[i]),
                    };
                    let same = watch.response.iter().position(|other| *other == response_time);
                    same.unwrap_or_else(|| {
                        watch.response.push(response_time);
                        watch.response.len() - 1
                    })
                }
                What::Within(p, list, bound) => {
                    let responses: Option<Vec<Predicate>> = list.iter().map(predicate).collect();
                    let (Some(trigger), Some(responses)) = (predicate(p), responses) else {
                        continue;
                    };
                    watch.within.push(Within { trigger, responses, limit: self.ticks(bound) });
                    watch.within.len() - 1
                }
                What::Always(p) => {
                    let Some(p) = predicate(p) else { continue };
                    watch.reach.push(Predicate::Not(Box::new(p)));
                    watch.reach.len() - 1
                }
                What::Reachable(p) => {
                    let Some(p) = predicate(p) else { continue };
                    watch.reach.push(p);
                    watch.reach.len() - 1
                }
                What::Pattern(pattern) => {
                    let Some(monitor) = self.monitor(pattern) else { continue };
                    watch.reach.push(Predicate::violated(watch.monitors.len()));
                    watch.monitors.push(monitor);
                    watch.reach.len() - 1
                }
                What::Deadlock => {
                    watch.deadlock = true;
                    0
                }
                // Liveness is checked after the search.
                _ => 0,
            };
            places.push((i, place));
        }
        (watch, places)
    }
}
