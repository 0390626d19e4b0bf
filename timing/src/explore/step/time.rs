//! How time passes.

use super::Stepper;
use crate::explore::state::{State, TaskStatus, phase};
use crate::system::{FOREVER, Ticks};

impl Stepper<'_> {
    /// How long nothing needs to be looked at after a state without urgent actions: until the next
    /// moment at which something may happen, or, for executors whose end `can_wait`, has to. `None`:
    /// forever.
    pub(crate) fn next_moment(&self, s: &State, can_wait: &dyn Fn(usize) -> bool) -> Option<Ticks> {
        let l = &self.layout;
        let mut least = FOREVER;
        for (task, it) in self.system.tasks.iter().enumerate() {
            if let Some(period) = it.period
                && l.started(s, task)
            {
                least = least.min(period + it.delay - l.timer(s, task));
            }
        }
        for executor in l.executing(s) {
            let (a, b) = l.window(s, executor);
            least = least.min(if can_wait(executor) { b } else { a.max(1) });
        }
        (least != FOREVER).then_some(least)
    }

    /// Lets time pass, at most [`Stepper::next_moment`].
    pub(crate) fn elapse(&self, s: &mut State, time: Ticks) {
        let l = &self.layout;
        for (task, it) in self.system.tasks.iter().enumerate() {
            if it.period.is_some() && l.started(s, task) {
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
        for executor in 0..l.executors() {
            if l.phase(s, executor) & phase::EXECUTING != 0 {
                let (a, b) = l.window(s, executor);
                let b = if b == FOREVER { b } else { b - time };
                l.set_window(s, executor, (a.saturating_sub(time), b));
            }
        }
        for (i, clock) in l.observer_clock.iter().enumerate() {
            if let Some(clock) = *clock
                && l.open(s, i) != 0
            {
                s.t[clock] += time;
            }
        }
    }
}
