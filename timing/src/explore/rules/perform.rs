//! The effects of actions, except those of passes, jobs and the control task.

use super::layout::EdfTimes;
use super::points::Cycle;
use super::status::{control, flag, thread};
use super::{Action, Rules};
use crate::explore::state::{State, phase};
use crate::system::{ClientAction, ClientId, FOREVER, Policy, TaskId};

impl Rules<'_> {
    /// Performs an action that is enabled.
    pub(super) fn perform(&self, s: &mut State, action: Action) {
        let l = &self.layout;
        match action {
            Action::Proceed { client, next } => self.client_to(s, client, next),
            Action::Tick { task } => self.tick(s, task),
            Action::Release { task } => match self.points.cycle {
                Cycle::Passes => self.release(s, task),
                Cycle::Jobs => self.release_job(s, task),
            },
            Action::Grant { task } => {
                l.core_queue_remove(s, task);
                match l.edf {
                    Some(EdfTimes::Ages { tick: base, .. } | EdfTimes::Slack(base)) => {
                        s.t[base + task] = 0;
                    }
                    None => {}
                }
                l.raise(s, task, flag::CORE);
                match self.points.cycle {
                    Cycle::Passes => self.begin_pass(s, task, true),
                    Cycle::Jobs => self.run_job(s, task),
                }
            }
            Action::Begin { task } => {
                let first = l.thread_of(s, task) == thread::IDLE;
                if first {
                    self.take_flag(s, task);
                }
                self.begin_pass(s, task, first);
            }
            Action::Ticket { executor } => self.take_ticket(s, executor),
            Action::Acquire { executor } => self.execute(s, executor),
            Action::Finish { executor, outcome } => {
                l.set_window(s, executor, (0, 0));
                if let Some(client) = l.client_of_executor(executor) {
                    self.client_to(s, client, outcome);
                } else if executor >= l.threads {
                    l.set_phase(s, executor, phase::REST);
                    self.finish_control(s, (executor - l.threads).into(), outcome);
                } else if self.points.cycle == Cycle::Jobs {
                    self.finish_state(s, executor, outcome);
                } else {
                    l.set_phase(s, executor, phase::REST);
                    self.finish_codel(s, executor, outcome);
                }
            }
            Action::Wake { task } => {
                l.lower(s, task, flag::WAKE);
                self.free_core(s, task);
                let component = self.system.tasks[TaskId::from(task)].component;
                for &other in &self.system.components[component].tasks {
                    if other != TaskId::from(task) {
                        self.make_runnable(s, usize::from(other));
                    }
                }
            }
            Action::Ready { executor } => l.core_queue_push(s, executor),
            Action::Preempt { executor, by } => self.preempt(s, executor, by),
            Action::Signal { component } => {
                l.set_signal(s, component, 0);
                self.examine_all(s, component);
            }
            Action::Request { client, next } => self.request(s, client, next),
            Action::Mark { .. } => {}
            Action::Reply { component } => self.reply(s, component),
            Action::Shut { component } => self.shutdown_step(s, component),
        }
    }

    /// Raises the flag of a task at a tick of the clock. Several ticks while the task is busy count as one.
    fn tick(&self, s: &mut State, task: usize) {
        let l = &self.layout;
        l.set_timer(s, task, self.system.tasks[TaskId::from(task)].period.unwrap_or(0));
        if self.waits_to_begin(s, task) && !l.has(s, task, flag::FIRST) {
            l.raise(s, task, flag::LATE);
        }
        l.raise(s, task, flag::TICK);
    }

    /// Clears the flag of a task.
    fn take_flag(&self, s: &mut State, task: usize) {
        let l = &self.layout;
        if self.is_periodic(task) {
            l.lower(s, task, flag::TICK | flag::LATE);
        }
        if let Some(EdfTimes::Ages { tick, kept }) = l.edf {
            // The kept tick is the tick of this cycle.
            s.t[tick + task] = s.t[kept + task];
            s.t[kept + task] = 0;
        }
    }

    /// Releases a task: it clears its flag and asks for a core. (An aperiodic task is still runnable when it
    /// gets the core.)
    fn release(&self, s: &mut State, task: usize) {
        let l = &self.layout;
        self.take_flag(s, task);
        l.set_thread(s, task, thread::WAITING);
        self.queue_for_core(s, task);
    }

    /// Adds a task to the queue for cores.
    pub(super) fn queue_for_core(&self, s: &mut State, task: usize) {
        let l = &self.layout;
        let queue = l.core_queue(s);
        let deadline = self.system.tasks[TaskId::from(task)].period.unwrap_or(FOREVER);
        let position = match (l.edf, self.system.platform.policy) {
            (Some(EdfTimes::Slack(base)), _) => {
                queue.partition_point(|&other| s.t[base + other as usize] <= deadline)
            }
            // The order of waiting tasks is irrelevant if any of them may be next.
            (_, Policy::Any) => queue.partition_point(|&other| (other as usize) < task),
            _ => queue.len(),
        };
        l.core_queue_insert(s, position, task);
        if let Some(EdfTimes::Slack(base)) = l.edf {
            s.t[base + task] = deadline;
        }
    }

    /// Frees the core of a thread that has neither a pass nor a wake-up left in its cycle.
    pub(super) fn free_core(&self, s: &mut State, task: usize) {
        let l = &self.layout;
        if l.thread_of(s, task) == thread::IDLE && !l.has(s, task, flag::WAKE) {
            l.lower(s, task, flag::CORE);
        }
    }

    /// Makes the paused automata of an aperiodic task runnable. (Those of a periodic task are resumed by
    /// ticks only.)
    pub(super) fn make_runnable(&self, s: &mut State, task: usize) {
        if self.points.cycle == Cycle::Passes && !self.is_periodic(task) {
            self.layout.raise(s, task, flag::RUNNABLE);
        }
    }

    fn take_ticket(&self, s: &mut State, executor: usize) {
        let l = &self.layout;
        let Some(component) = self.component_of(executor) else {
            return;
        };
        if executor < l.threads {
            l.set_thread(s, executor, thread::QUEUED);
        } else {
            l.set_control(s, component, control::QUEUED);
        }
        l.set_phase(s, executor, phase::LOCKING);
        l.lock_queue_push(s, component, executor);
    }

    /// Lets an executor take the locks of its codel and execute the codel.
    pub(super) fn execute(&self, s: &mut State, executor: usize) {
        let l = &self.layout;
        let (Some(component), Some(codel)) = (self.component_of(executor), self.codel(s, executor))
        else {
            return;
        };
        l.lock_queue_remove(s, component, executor);
        if executor >= l.threads {
            l.set_control(s, component, control::EXECUTING);
        } else if self.points.cycle == Cycle::Passes {
            l.set_thread(s, executor, thread::EXECUTING);
        }
        let codel = &self.system.codels[codel];
        let flag = l.phase(s, executor) & phase::ASYNC;
        l.set_phase(s, executor, phase::EXECUTING | flag);
        l.set_window(s, executor, (codel.lower, codel.upper));
    }

    pub(super) fn client_to(&self, s: &mut State, client: ClientId, position: usize) {
        let l = &self.layout;
        let executor = l.client_executor(client);
        l.set_position(s, client, position as u16);
        l.set_phase(s, executor, phase::REST);
        if let Some(step) = self.system.clients[client].steps.get(position)
            && let ClientAction::Delay(lower, upper) = step.action
        {
            l.set_phase(s, executor, phase::EXECUTING);
            l.set_window(s, executor, (lower, upper));
        }
    }
}
