//! The passage of time.

use super::Published;
use crate::explore::state::{State, TaskStatus};
use crate::system::{FOREVER, Ticks};

impl Published<'_> {
    /// Returns the time after a state without urgent actions for which no state needs to be examined, in base
    /// units: until the next moment at which an action may become possible or, for executors whose end
    /// `can_be_deferred`, must happen. `None`: for ever.
    pub(super) fn until_next(
        &self,
        s: &State,
        can_be_deferred: &dyn Fn(usize) -> bool,
    ) -> Option<Ticks> {
        let l = &self.layout;
        let mut least = FOREVER;
        for (task, entry) in self.system.tasks.iter().enumerate() {
            if let Some(period) = entry.period
                && l.started(s, task)
            {
                least = least.min(period + entry.delay - l.timer(s, task));
            }
        }
        for executor in l.executing(s) {
            let (a, b) = l.window(s, executor);
            least = least.min(if can_be_deferred(executor) {
                b
            } else {
                a.max(1)
            });
        }
        (least != FOREVER).then_some(least)
    }

    /// Lets time pass, at most [`Published::until_next`].
    pub(super) fn pass(&self, s: &mut State, time: Ticks) {
        let l = &self.layout;
        for (task, entry) in self.system.tasks.iter().enumerate() {
            if entry.period.is_some() && l.started(s, task) {
                l.set_timer(s, task, l.timer(s, task) + time);
            }
            let status = l.status(s, task);
            if l.has_slack() && status == TaskStatus::Waiting && l.slack(s, task) != FOREVER {
                l.set_slack(s, task, l.slack(s, task).saturating_sub(time));
            }
            if let Some(clock) = l.response[task]
                && status != TaskStatus::Idle
            {
                s.t[clock] += time;
            }
        }
        l.elapse(s, time);
    }
}
