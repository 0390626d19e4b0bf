//! The possible actions in a state: clients that proceed, tasks that ask for a core, grants, and the rest, in
//! this order.

use super::layout::EdfTimes;
use super::points::{Cycle, Handling};
use super::status::{control, flag, slot, thread, tracker};
use super::{Action, Enabled, Rules};
use crate::explore::state::{State, phase};
use crate::scn::semantics::{LockRule, TickRule};
use crate::system::{ClientAction, ClientId, ComponentId, Policy, TaskId, Yield};

impl Rules<'_> {
    /// Lists the actions of the best rank present.
    pub(super) fn list_enabled(&self, s: &State, out: &mut Enabled) {
        out.actions.clear();
        out.urgent = true;
        out.committed = true;
        out.forced = false;
        self.proceeding_clients(s, out);
        if !out.actions.is_empty() {
            return;
        }
        let preempts = self.preempts();
        if !preempts {
            self.list_releases(s, out);
            if !out.actions.is_empty() {
                return;
            }
            self.list_grants(s, out);
            if !out.actions.is_empty() {
                return;
            }
        }
        if preempts {
            self.becomes_ready(s, out);
            if !out.actions.is_empty() {
                return;
            }
        }
        out.committed = false;
        out.urgent = false;
        self.ordinary(s, out);
        if preempts {
            self.without_core(s, out);
        }
    }

    /// Lists the tasks that begin a cycle and wait for a core first; with jobs, all tasks that begin one.
    fn list_releases(&self, s: &State, out: &mut Enabled) {
        for task in 0..self.layout.tasks {
            let is_released = match self.points.cycle {
                Cycle::Jobs => self.is_released(s, task),
                Cycle::Passes => self.begins(s, task) && self.asks_for_core(s, task),
            };
            if is_released {
                out.actions.push(Action::Release { task });
            }
        }
    }

    /// Removes the actions of threads without a core.
    fn without_core(&self, s: &State, out: &mut Enabled) {
        let l = &self.layout;
        let running = self.running(s);
        let has_core = |executor: usize| running >> executor & 1 == 1;
        out.actions.retain(|action| match *action {
            Action::Begin { task } | Action::Wake { task } => has_core(task),
            Action::Ticket { executor } | Action::Acquire { executor } => has_core(executor),
            Action::Finish { executor, .. } => {
                let threads = l.tasks + l.components;
                executor >= threads || has_core(executor) || l.window(s, executor).1 == 0
            }
            Action::Signal { component } | Action::Reply { component } => {
                has_core(l.control_executor(component))
            }
            Action::Request { client, .. } => {
                let steps = &self.system.clients[client].steps;
                match steps[l.position(s, client) as usize].action {
                    ClientAction::Send { service, .. } => {
                        let component = self.system.services[service].component;
                        has_core(l.control_executor(component))
                    }
                    _ => true,
                }
            }
            _ => true,
        });
        let takes_time = |action: &Action| matches!(action, Action::Finish { .. });
        out.urgent = !out.actions.iter().all(takes_time);
        self.swaps(s, running, out);
    }

    fn proceeding_clients(&self, s: &State, out: &mut Enabled) {
        let l = &self.layout;
        for (k, client) in self.system.clients.iter_enumerated() {
            let position = l.position(s, k) as usize;
            let next = if position > client.done() {
                &client.first
            } else if position == client.done() {
                continue;
            } else {
                let step = &client.steps[position];
                let satisfied = match step.action {
                    ClientAction::AwaitAccepted => l.outstanding(s, k) == 0,
                    ClientAction::AwaitEnded(t) => {
                        matches!(l.tracker(s, k, t), tracker::NONE | tracker::FAILED)
                    }
                    ClientAction::AwaitOutcome(t, success) => self.has_outcome(s, k, t, success),
                    ClientAction::AwaitAny => {
                        // The client proceeds to a step that has nothing to wait for.
                        let steps = &client.steps;
                        let over = |next: &&usize| match steps.get(**next).map(|step| &step.action)
                        {
                            Some(&ClientAction::AwaitOutcome(t, success)) => {
                                self.has_outcome(s, k, t, success)
                            }
                            _ => false,
                        };
                        let next = step.next.iter().filter(over);
                        out.actions.extend(next.map(|&next| Action::Proceed { client: k, next }));
                        false
                    }
                    ClientAction::Send { .. } | ClientAction::Delay(..) => false,
                };
                if !satisfied {
                    continue;
                }
                &step.next
            };
            let proceed = |&next: &usize| Action::Proceed { client: k, next };
            out.actions.extend(next.iter().map(proceed));
        }
    }

    /// Returns true if a tracked request has ended with this outcome.
    fn has_outcome(&self, s: &State, client: ClientId, tracker: usize, success: bool) -> bool {
        let wanted = if success { tracker::NONE } else { tracker::FAILED };
        self.layout.tracker(s, client, tracker) == wanted
    }

    /// Returns true if the next action of a task's thread is to begin a cycle.
    pub(super) fn begins(&self, s: &State, task: usize) -> bool {
        let l = &self.layout;
        let wanted = if self.is_periodic(task) { flag::TICK } else { flag::RUNNABLE };
        l.thread_of(s, task) == thread::IDLE
            && l.has(s, task, wanted)
            && !l.has(s, task, flag::WAKE)
    }

    /// Returns true if a cycle needs a core: unless no codel could run in it.
    pub(super) fn asks_for_core(&self, s: &State, task: usize) -> bool {
        let l = &self.layout;
        // A task with a timer of its own starts without a core.
        let start_up = self.points.ticks == TickRule::Task && l.has(s, task, flag::FIRST);
        let could_run = |&slot: &usize| {
            let mode = l.mode(s, slot);
            match mode & slot::STATUS {
                slot::INIT => mode & (slot::START | slot::MARK) != 0,
                slot::RUN | slot::STOP => true,
                _ => false,
            }
        };
        self.system.needs_core(TaskId::from(task))
            && !self.preempts()
            && !start_up
            && l.slots(task).iter().any(could_run)
    }

    fn list_grants(&self, s: &State, out: &mut Enabled) {
        let l = &self.layout;
        let queue = l.core_queue(s);
        if queue.is_empty() || !self.core_free(s) {
            return;
        }
        let grant = |task: u16| Action::Grant { task: task as usize };
        match (self.system.platform.policy, l.edf) {
            (Policy::Any, _) => out.actions.extend(queue.iter().map(|&task| grant(task))),
            (_, Some(EdfTimes::Ages { tick, .. })) => {
                let deadline = |task: usize| {
                    let period = self.system.tasks[TaskId::from(task)].period;
                    let left = |period| i64::from(period) - i64::from(s.t[tick + task]);
                    period.map_or(i64::MAX, left)
                };
                let first = queue.iter().min_by_key(|&&task| deadline(task as usize));
                out.actions.extend(first.map(|&task| grant(task)));
            }
            _ => out.actions.push(grant(queue[0])),
        }
    }

    fn core_free(&self, s: &State) -> bool {
        let Some(cores) = self.system.platform.cores else {
            return true;
        };
        let l = &self.layout;
        let busy = (0..l.tasks).filter(|&task| l.has(s, task, flag::CORE));
        busy.count() < cores as usize
    }

    fn ordinary(&self, s: &State, out: &mut Enabled) {
        let l = &self.layout;
        for task in 0..l.tasks {
            if l.timer(s, task) == 0 && self.counts(s, task) {
                out.actions.push(Action::Tick { task });
            }
            if self.points.cycle == Cycle::Jobs {
                continue;
            }
            let thread = l.thread_of(s, task);
            if l.has(s, task, flag::WAKE) {
                out.actions.push(Action::Wake { task });
            } else if thread == thread::AGAIN || self.begins(s, task) {
                out.actions.push(Action::Begin { task });
            }
            if thread == thread::TICKET {
                out.actions.push(Action::Ticket { executor: task });
            }
        }
        self.list_acquisitions(s, out);
        let before = out.actions.len();
        for (executor, &phase) in l.phases(s).iter().enumerate() {
            if phase & phase::EXECUTING != 0 {
                let (a, b) = l.window(s, executor);
                if a == 0 {
                    self.outcomes(s, executor, out);
                    out.forced |= b == 0;
                }
            }
        }
        let ends = out.actions.len() - before;
        for component in self.system.components.keys() {
            self.list_component(s, component, out);
        }
        self.requests(s, out);
        // All actions but ends must happen before time passes.
        out.urgent = out.actions.len() > ends;
    }

    #[inline]
    fn list_component(&self, s: &State, component: ComponentId, out: &mut Enabled) {
        let l = &self.layout;
        let executor = l.control_executor(component);
        match l.control(s, component) {
            control::TICKET => out.actions.push(Action::Ticket { executor }),
            control::REST => out.actions.push(Action::Reply { component }),
            control::READY if l.signal(s, component) != 0 => {
                out.actions.push(Action::Signal { component });
            }
            _ => {}
        }
        if l.shutdown[component].is_some() && self.can_shut_down(s, component) {
            out.actions.push(Action::Shut { component });
        }
    }

    /// Lists the executors that can take their locks.
    fn list_acquisitions(&self, s: &State, out: &mut Enabled) {
        let l = &self.layout;
        if self.points.locks == LockRule::Free {
            for (executor, &phase) in l.phases(s).iter().enumerate() {
                if phase & phase::LOCKING != 0 && self.is_free(s, executor) {
                    out.actions.push(Action::Acquire { executor });
                }
            }
            return;
        }
        // With jobs all components share one queue.
        let queues = match self.points.cycle {
            Cycle::Jobs => 1,
            Cycle::Passes => l.components,
        };
        for component in self.system.components.keys().take(queues) {
            let queue = l.lock_queue(s, component);
            let most = match self.points.locks {
                LockRule::Queue => 1,
                _ => queue.len(),
            };
            for &executor in queue.iter().take(most) {
                let executor = executor as usize;
                if self.may_leave(s, executor) {
                    out.actions.push(Action::Acquire { executor });
                }
            }
        }
    }

    /// Returns true if an executor that waits for locks can take them.
    pub(crate) fn may_leave(&self, s: &State, executor: usize) -> bool {
        let Some(component) = self.component_of(executor) else {
            return false;
        };
        let queue = self.layout.lock_queue(s, component);
        let mut ahead =
            (queue.iter()).map(|&other| other as usize).take_while(|&other| other != executor);
        let turn = match self.points.locks {
            LockRule::Queue => ahead.next().is_none(),
            LockRule::Fifo => {
                let codel = self.codel(s, executor).map(|codel| &self.system.codels[codel]);
                !codel.is_some_and(|codel| ahead.any(|other| self.blocks(s, codel, other)))
            }
            LockRule::Free => true,
        };
        turn && self.is_free(s, executor)
    }

    /// Returns true if no executing codel blocks the codel of an executor.
    #[inline]
    fn is_free(&self, s: &State, executor: usize) -> bool {
        let Some(codel) = self.codel(s, executor) else {
            return true;
        };
        let codel = &self.system.codels[codel];
        !(self.layout.executing(s)).any(|other| other != executor && self.blocks(s, codel, other))
    }

    fn requests(&self, s: &State, out: &mut Enabled) {
        let l = &self.layout;
        for (k, client) in self.system.clients.iter_enumerated() {
            let Some(step) = client.steps.get(l.position(s, k) as usize) else {
                continue;
            };
            let ClientAction::Send { service, .. } = step.action else {
                continue;
            };
            let component = self.system.services[service].component;
            // A control task that handles messages at once reports ended activities first.
            let reports = self.points.handling == Handling::AtOnce && l.signal(s, component) != 0;
            if l.outstanding(s, k) == 0 && l.control(s, component) == control::READY && !reports {
                let request = |&next: &usize| Action::Request { client: k, next };
                out.actions.extend(step.next.iter().map(request));
            }
        }
    }

    /// Adds the possible ends of an executing codel or a delay.
    fn outcomes(&self, s: &State, executor: usize, out: &mut Enabled) {
        let l = &self.layout;
        let mut push = |outcome| out.actions.push(Action::Finish { executor, outcome });
        if executor < l.threads {
            let Some(slot) = self.slot_of(s, executor) else {
                return;
            };
            let (Some(machine), Some(state)) = (self.machine(s, slot), self.machine_state(s, slot))
            else {
                return;
            };
            let mut any = false;
            for (outcome, transition) in state.yields.iter().enumerate() {
                if self.within_limit(s, slot, transition) {
                    push(outcome);
                    any = true;
                }
            }
            if !any && machine.rounds {
                for (outcome, transition) in state.yields.iter().enumerate() {
                    if *transition != Yield::Next(l.at(s, slot) as usize) {
                        push(outcome);
                    }
                }
            }
            if self.system.codels[state.codel].throws && self.tells_throwing(s, slot, &state.yields)
            {
                push(state.yields.len());
            }
        } else if executor < l.threads + l.components {
            let component = ComponentId::from(executor - l.threads);
            push(0);
            let throws = || {
                let codel = self.codel(s, executor).map(|codel| &self.system.codels[codel]);
                self.points.handling == Handling::InSteps && codel.is_some_and(|codel| codel.throws)
            };
            if self.validates(s, component) || throws() {
                push(1);
            }
        } else if let Some(client) = l.client_of_executor(executor) {
            let step = &self.system.clients[client].steps[l.position(s, client) as usize];
            step.next.iter().for_each(|&next| push(next));
        }
    }

    /// Returns true if an exception makes a difference: not if the activity may end as well and no client
    /// depends on the outcome. With jobs an exception is an ordinary end.
    fn tells_throwing(&self, s: &State, slot: usize, yields: &[Yield]) -> bool {
        if self.points.cycle == Cycle::Jobs {
            return false;
        }
        let outcomes = || self.layout.outcomes.iter().flatten().any(|outcome| *outcome);
        match self.service(s, slot) {
            Some(service) => {
                !yields.contains(&Yield::End)
                    || self.layout.success[service].is_some()
                    || outcomes()
            }
            None => true,
        }
    }

    pub(super) fn within_limit(&self, s: &State, slot: usize, transition: &Yield) -> bool {
        let limit = self.machine(s, slot).and_then(|machine| machine.loop_limit);
        match (transition, limit) {
            (&Yield::Next(state), Some(limit)) => s.d[self.layout.visits[slot].0 + state] < limit,
            _ => true,
        }
    }
}
