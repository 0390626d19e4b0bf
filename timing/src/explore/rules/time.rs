//! The passage of time.

use super::Rules;
use super::layout::EdfTimes;
use super::status::{flag, thread};
use crate::explore::state::{State, TaskStatus};
use crate::scn::semantics::TickRule;
use crate::system::{FOREVER, TaskId, Ticks};

impl Rules<'_> {
    /// Returns true if the timer of a task runs.
    #[inline]
    pub(super) fn counts(&self, s: &State, task: usize) -> bool {
        let starts = match self.points.ticks {
            _ if self.layout.thread_of(s, task) == thread::ENDED => false,
            TickRule::Component => true,
            TickRule::Task => self.layout.thread_of(s, task) != thread::OFF,
        };
        starts && self.is_periodic(task)
    }

    /// Returns the time in base units for which no action can become possible, except by ends that can wait
    /// and by ticks that are skipped.
    pub(in crate::explore) fn next_moment_without_ticks(
        &self,
        s: &State,
        can_be_deferred: &dyn Fn(usize) -> bool,
        is_skipped: &dyn Fn(usize) -> bool,
    ) -> Option<Ticks> {
        let l = &self.layout;
        let mut least = FOREVER;
        let running = self.running(s);
        if self.may_swap(s, running) {
            least = 1;
        }
        let ticks = |task: &usize| self.counts(s, *task) && !is_skipped(*task);
        for task in (0..l.tasks).filter(ticks) {
            least = least.min(l.timer(s, task));
        }
        let executing = l.executing(s);
        for executor in executing.filter(|&executor| self.executes_on(s, running, executor)) {
            let (a, b) = l.window(s, executor);
            least = least.min(if can_be_deferred(executor) { b } else { a.max(1) });
        }
        (least != FOREVER).then_some(least)
    }

    /// Lets time pass.
    pub(super) fn pass_time(&self, s: &mut State, time: Ticks) {
        let l = &self.layout;
        for task in 0..l.tasks {
            if self.counts(s, task) {
                l.set_timer(s, task, l.timer(s, task) - time);
            }
            self.pass_deadline(s, task, time);
            if let Some(clock) = l.response[task]
                && self.job(s, task) != TaskStatus::Idle
            {
                s.t[clock] += time;
                if let Some(kept) = l.kept(task)
                    && l.has(s, task, flag::TICK)
                    && self.in_cycle(s, task)
                {
                    s.t[kept] += time;
                }
            }
        }
        if !self.preempts() {
            l.elapse(s, time);
            return;
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

    /// Lets time pass in the times that decide about cores under EDF.
    fn pass_deadline(&self, s: &mut State, task: usize, time: Ticks) {
        let l = &self.layout;
        let waits = || l.thread_of(s, task) == thread::WAITING;
        match (l.edf, self.system.tasks[TaskId::from(task)].period) {
            (Some(EdfTimes::Slack(base)), _) if waits() && s.t[base + task] != FOREVER => {
                s.t[base + task] = s.t[base + task].saturating_sub(time);
            }
            (Some(EdfTimes::Ages { tick, kept }), Some(period)) => {
                // Deadlines that are this long past need not be distinguished.
                let most = period.saturating_mul(16);
                let (waits, pending) = (waits(), l.has(s, task, flag::TICK));
                for (place, counts) in [(tick + task, waits), (kept + task, pending)] {
                    if counts {
                        s.t[place] = (s.t[place] + time).min(most);
                    }
                }
            }
            _ => {}
        }
    }
}
