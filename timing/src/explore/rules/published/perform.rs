//! The effects of actions, except those of a task's cycle and of the control task.

use super::Published;
use crate::explore::rules::Action;
use crate::explore::state::{State, phase};
use crate::system::ClientAction;

impl Published<'_> {
    /// Performs an action that is enabled.
    pub(super) fn perform(&self, s: &mut State, action: Action) {
        let l = &self.layout;
        match action {
            Action::Proceed { client, next } => self.client_to(s, client, next),
            Action::Release { task } => self.release(s, task),
            Action::Grant { task } => {
                let at = l.queue(s).iter().position(|&queue| queue as usize == task);
                l.queue_remove(s, at.expect("a granted task waits"));
                l.set_slack(s, task, 0);
                self.run(s, task);
            }
            Action::Tick { task } => {
                l.set_timer(s, task, self.system.tasks[task].delay);
                l.set_pending(s, task, true);
            }
            Action::Acquire { executor } => {
                l.lock_queue_remove(s, executor);
                self.execute(s, executor);
            }
            Action::Finish { executor, outcome } => {
                l.set_window(s, executor, (0, 0));
                if executor < l.automata {
                    self.finish_state(s, executor, outcome);
                } else if executor < l.automata + l.components {
                    self.finish_control(s, executor - l.automata, outcome);
                } else {
                    self.client_to(s, executor - l.automata - l.components, outcome);
                }
            }
            Action::Signal { component } => {
                l.set_signal(s, component, 0);
                self.finish_message(s, component);
            }
            Action::Request { client, next } => self.request(s, client, next),
            // Never enabled: actions of other rules.
            Action::Begin { .. }
            | Action::Preempt { .. }
            | Action::Ready { .. }
            | Action::Ticket { .. }
            | Action::Wake { .. }
            | Action::Shut { .. }
            | Action::Mark { .. }
            | Action::Reply { .. } => {}
        }
    }

    pub(super) fn client_to(&self, s: &mut State, client: usize, position: usize) {
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

    /// Begins the present codel of an executor.
    pub(super) fn execute(&self, s: &mut State, executor: usize) {
        let l = &self.layout;
        let codel = self.codel(s, executor).expect("only codels are executed");
        let codel = &self.system.codels[codel];
        l.set_window(s, executor, (codel.lower, codel.upper));
        if executor < l.automata {
            let flag = l.phase(s, executor) & phase::ASYNC;
            l.set_phase(s, executor, phase::EXECUTING | flag);
        } else {
            l.set_phase(s, executor, phase::EXECUTING);
        }
    }
}
