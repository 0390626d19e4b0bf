//! The possible actions in a state: clients that proceed, tasks that ask for a core, grants, and the rest, in
//! this order.

use super::Published;
use super::layout::{control, tracker};
use crate::explore::rules::{Action, Enabled};
use crate::explore::state::{State, TaskStatus, phase};
use crate::system::{ClientAction, LockOrder, Policy, Yield};

impl Published<'_> {
    /// Lists the actions of a state.
    pub(super) fn list_enabled(&self, s: &State, out: &mut Enabled) {
        out.actions.clear();
        out.urgent = true;
        out.committed = true;
        out.forced = false;
        self.proceeding_clients(s, &mut out.actions);
        if !out.actions.is_empty() {
            return;
        }
        for task in 0..self.layout.tasks {
            if self.asks_for_core(s, task) {
                out.actions.push(Action::Release { task });
            }
        }
        if !out.actions.is_empty() {
            return;
        }
        self.decisions(s, &mut out.actions);
        if !out.actions.is_empty() {
            return;
        }
        out.committed = false;
        self.ordinary(s, out);
    }

    fn proceeding_clients(&self, s: &State, out: &mut Vec<Action>) {
        let l = &self.layout;
        for (k, client) in self.system.clients.iter().enumerate() {
            let position = l.position(s, k) as usize;
            let next = if position > client.done() {
                &client.first
            } else if position == client.done() {
                continue;
            } else {
                let step = &client.steps[position];
                let satisfied = match &step.action {
                    ClientAction::AwaitAccepted => l.outstanding(s, k) == 0,
                    &ClientAction::AwaitEnded(t) => l.tracker(s, k, t) == tracker::NONE,
                    // (These rules do not record the outcome of requests: such scenarios are refused.)
                    ClientAction::Send { .. }
                    | ClientAction::Delay(..)
                    | ClientAction::AwaitAny
                    | ClientAction::AwaitOutcome(..) => false,
                };
                if !satisfied {
                    continue;
                }
                &step.next
            };
            out.extend(next.iter().map(|&next| Action::Proceed { client: k, next }));
        }
    }

    /// Returns true if a task is released now (section 4, with the rule for idle ticks).
    fn asks_for_core(&self, s: &State, task: usize) -> bool {
        let l = &self.layout;
        if l.status(s, task) != TaskStatus::Idle {
            return false;
        }
        let definition = &self.system.tasks[task];
        if definition.period.is_some() {
            l.pending(s, task)
                && (!definition.keep_idle_tick || self.next_turn(s, task, 0).is_some())
        } else {
            self.next_turn(s, task, 0).is_some()
        }
    }

    fn decisions(&self, s: &State, out: &mut Vec<Action>) {
        let queue = self.layout.queue(s);
        if queue.is_empty() || !self.core_free(s) {
            return;
        }
        match self.system.platform.policy {
            Policy::Fifo | Policy::Edf => out.push(Action::Grant {
                task: queue[0] as usize,
            }),
            // Only the servers have preemptive policies.
            Policy::Any | Policy::Priority | Policy::Fair => {
                out.extend(queue.iter().map(|&task| Action::Grant {
                    task: task as usize,
                }));
            }
        }
    }

    fn core_free(&self, s: &State) -> bool {
        let Some(cores) = self.system.platform.cores else {
            return true;
        };
        let busy = (0..self.layout.tasks)
            .filter(|&t| {
                self.layout.status(s, t) == TaskStatus::Running && self.system.needs_core(t)
            })
            .count();
        busy < cores as usize
    }

    fn ordinary(&self, s: &State, out: &mut Enabled) {
        let l = &self.layout;
        let mut urgent = false;
        for (task, entry) in self.system.tasks.iter().enumerate() {
            if let Some(period) = entry.period
                && l.started(s, task)
                && l.timer(s, task) == period + entry.delay
            {
                out.actions.push(Action::Tick { task });
                urgent = true;
            }
        }
        for (executor, &phase) in l.phases(s).iter().enumerate() {
            match phase & !phase::ASYNC {
                phase::LOCKING if self.can_acquire(s, executor) => {
                    out.actions.push(Action::Acquire { executor });
                    urgent = true;
                }
                phase::EXECUTING => {
                    let (a, b) = l.window(s, executor);
                    if a == 0 {
                        self.outcomes(s, executor, &mut out.actions);
                        out.forced |= b == 0;
                    }
                }
                _ => {}
            }
        }
        for component in 0..l.components {
            if l.control(s, component) == control::READY && l.signal(s, component) != 0 {
                out.actions.push(Action::Signal { component });
                urgent = true;
            }
        }
        for (k, client) in self.system.clients.iter().enumerate() {
            let Some(step) = client.steps.get(l.position(s, k) as usize) else {
                continue;
            };
            let ClientAction::Send { service, .. } = step.action else {
                continue;
            };
            let component = self.system.services[service].component;
            if l.outstanding(s, k) == 0
                && l.control(s, component) == control::READY
                && l.signal(s, component) == 0
            {
                out.actions.extend(
                    step.next
                        .iter()
                        .map(|&next| Action::Request { client: k, next }),
                );
                urgent = true;
            }
        }
        out.urgent = urgent;
    }

    /// Adds the possible ends of an executing codel.
    fn outcomes(&self, s: &State, executor: usize, out: &mut Vec<Action>) {
        let l = &self.layout;
        let mut push = |outcome| out.push(Action::Finish { executor, outcome });
        if executor < l.automata {
            let machine = self.system.machine_of(executor);
            let yields = &machine.states[l.at(s, executor) as usize].yields;
            let mut any = false;
            for (outcome, transition) in yields.iter().enumerate() {
                if self.within_limit(s, executor, transition) {
                    push(outcome);
                    any = true;
                }
            }
            if !any && machine.rounds {
                for (outcome, transition) in yields.iter().enumerate() {
                    if *transition != Yield::Next(l.at(s, executor) as usize) {
                        push(outcome);
                    }
                }
            }
        } else if executor < l.automata + l.components {
            push(0);
            if l.control(s, executor - l.automata) == control::VALIDATE {
                push(1);
            }
        } else {
            let client = executor - l.automata - l.components;
            let step = &self.system.clients[client].steps[l.position(s, client) as usize];
            for &next in &step.next {
                push(next);
            }
        }
    }

    pub(super) fn within_limit(&self, s: &State, automaton: usize, transition: &Yield) -> bool {
        match (
            transition,
            self.layout.visits[automaton],
            self.system.machine_of(automaton).loop_limit,
        ) {
            (&Yield::Next(state), Some(base), Some(limit)) => s.d[base + state] < limit,
            _ => true,
        }
    }

    /// Returns true if a codel that waits for its locks can take them.
    pub(crate) fn can_acquire(&self, s: &State, executor: usize) -> bool {
        let Some(codel) = self.codel(s, executor) else {
            return false;
        };
        let conflicts = &self.system.codels[codel].conflicts;
        let l = &self.layout;
        for other in l.executing(s) {
            if other != executor
                && self
                    .codel(s, other)
                    .is_some_and(|codel| conflicts.contains(codel))
            {
                return false;
            }
        }
        if self.system.platform.locks == LockOrder::Fifo {
            for &other in l.lock_queue(s) {
                if other as usize == executor {
                    break;
                }
                if self
                    .codel(s, other as usize)
                    .is_some_and(|codel| conflicts.contains(codel))
                {
                    return false;
                }
            }
        }
        true
    }
}
