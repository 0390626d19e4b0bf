//! The passage of time.

use super::Servers;
use super::layout::{flag, thread};
use crate::explore::rules::Rules;
use crate::explore::state::{State, TaskStatus};
use crate::scn::semantics::TickRule;
use crate::system::{FOREVER, Ticks};

impl Servers<'_> {
    /// Returns true if the timer of a task runs.
    fn counts(&self, s: &State, task: usize) -> bool {
        let starts = match self.semantics.ticks {
            _ if self.layout.thread_of(s, task) == thread::ENDED => false,
            TickRule::Component => true,
            TickRule::Task => self.layout.thread_of(s, task) != thread::OFF,
        };
        starts && self.is_periodic(task)
    }

    /// Returns the time in base units for which no action can become possible, except by ends that can wait.
    pub(super) fn until_next(
        &self,
        s: &State,
        can_be_deferred: &dyn Fn(usize) -> bool,
    ) -> Option<Ticks> {
        let l = &self.layout;
        let mut least = FOREVER;
        let running = self.running(s);
        if self.may_swap(s, running) {
            least = 1;
        }
        for task in (0..l.tasks).filter(|&task| self.counts(s, task)) {
            least = least.min(l.timer(s, task));
        }
        for executor in l
            .executing(s)
            .filter(|&executor| self.executes_on(s, running, executor))
        {
            let (a, b) = l.window(s, executor);
            least = least.min(if can_be_deferred(executor) {
                b
            } else {
                a.max(1)
            });
        }
        (least != FOREVER).then_some(least)
    }

    /// Lets time pass.
    pub(super) fn pass_time(&self, s: &mut State, time: Ticks) {
        let l = &self.layout;
        for (task, entry) in self.system.tasks.iter().enumerate() {
            if self.counts(s, task) {
                l.set_timer(s, task, l.timer(s, task) - time);
            }
            let job = self.job(s, task);
            let tick = l.has(s, task, flag::TICK);
            if let (Some(base), Some(period)) = (l.ages, entry.period) {
                // Deadlines that are this long past need not be distinguished.
                let most = period.saturating_mul(16);
                let waits = l.thread_of(s, task) == thread::WAITING;
                let mut grow = |at: usize| s.t[at] = (s.t[at] + time).min(most);
                if waits {
                    grow(base + task);
                }
                if tick {
                    grow(base + l.tasks + task);
                }
            }
            if let (Some(clock), Some(kept)) = (l.response[task], l.kept(task))
                && job != TaskStatus::Idle
            {
                s.t[clock] += time;
                if tick && self.in_cycle(s, task) {
                    s.t[kept] += time;
                }
            }
        }
        let running = self.running(s);
        let stays: Vec<_> = (l.executing(s))
            .filter(|&executor| !self.executes_on(s, running, executor))
            .map(|executor| (executor, l.window(s, executor)))
            .collect();
        for &(executor, _) in &stays {
            l.set_window(s, executor, (0, FOREVER));
        }
        l.elapse(s, time);
        for (executor, window) in stays {
            l.set_window(s, executor, window);
        }
    }
}
