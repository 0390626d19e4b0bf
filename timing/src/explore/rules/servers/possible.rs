//! The possible actions in a state.

use super::layout::{control, flag, slot, thread, tracker};
use super::{Action, Enabled, Servers};
use crate::explore::state::{State, phase};
use crate::scn::semantics::{LockRule, TickRule};
use crate::system::{ClientAction, Policy, Yield};

impl Servers<'_> {
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
        if self.system.platform.cores.is_some() && !preempts {
            for task in 0..self.layout.tasks {
                if self.begins(s, task) && self.asks_for_core(s, task) {
                    out.actions.push(Action::Release { task });
                }
            }
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
        for (k, client) in self.system.clients.iter().enumerate() {
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
                        out.actions
                            .extend(next.map(|&next| Action::Proceed { client: k, next }));
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
    fn has_outcome(&self, s: &State, client: usize, tracker: usize, success: bool) -> bool {
        let wanted = match success {
            true => tracker::NONE,
            false => tracker::FAILED,
        };
        self.layout.tracker(s, client, tracker) == wanted
    }

    /// Returns true if the next action of a task's thread is to begin a cycle.
    pub(super) fn begins(&self, s: &State, task: usize) -> bool {
        let l = &self.layout;
        let wanted = match self.is_periodic(task) {
            true => flag::TICK,
            false => flag::RUNNABLE,
        };
        l.thread_of(s, task) == thread::IDLE
            && l.has(s, task, wanted)
            && !l.has(s, task, flag::WAKE)
    }

    /// Returns true if a cycle needs a core: unless no codel could run in it.
    pub(super) fn asks_for_core(&self, s: &State, task: usize) -> bool {
        let l = &self.layout;
        // A task with a timer of its own starts without a core.
        let start_up = self.semantics.ticks == TickRule::Task && l.has(s, task, flag::FIRST);
        let could_run = |path: usize| {
            let mode = l.mode(s, path);
            match mode & slot::STATUS {
                slot::INIT => mode & (slot::START | slot::MARK) != 0,
                slot::RUN | slot::STOP => true,
                _ => false,
            }
        };
        self.system.needs_core(task)
            && !self.preempts()
            && !start_up
            && l.slots(task).any(could_run)
    }

    fn list_grants(&self, s: &State, out: &mut Enabled) {
        let l = &self.layout;
        let queue = l.core_queue(s);
        if queue.is_empty() || !self.core_free(s) {
            return;
        }
        let grant = |task: u16| Action::Grant {
            task: task as usize,
        };
        match self.system.platform.policy {
            Policy::Any => out.actions.extend(queue.iter().map(|&queue| grant(queue))),
            Policy::Edf => {
                let deadline = |task: usize| {
                    let age = l.ages.map_or(0, |base| s.t[base + task]);
                    let period = self.system.tasks[task].period;
                    period.map_or(i64::MAX, |period| i64::from(period) - i64::from(age))
                };
                let first = queue.iter().min_by_key(|&&queue| deadline(queue as usize));
                out.actions.extend(first.map(|&queue| grant(queue)));
            }
            Policy::Fifo => out.actions.push(grant(queue[0])),
            // Preemptive policies grant cores in another way.
            Policy::Priority | Policy::Fair => {}
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
        for (task, entry) in self.system.tasks.iter().enumerate() {
            let ticks = match self.semantics.ticks {
                _ if l.thread_of(s, task) == thread::ENDED => false,
                TickRule::Component => true,
                TickRule::Task => l.thread_of(s, task) != thread::OFF,
            };
            if entry.period.is_some() && ticks && l.timer(s, task) == 0 {
                out.actions.push(Action::Tick { task });
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
        for component in 0..l.components {
            self.list_component(s, component, out);
        }
        self.requests(s, out);
        // All actions so far must happen before time passes.
        out.urgent = !out.actions.is_empty();
        for (executor, &phase) in l.phases(s).iter().enumerate() {
            if phase == phase::EXECUTING {
                let (a, b) = l.window(s, executor);
                if a == 0 {
                    self.outcomes(s, executor, out);
                    out.forced |= b == 0;
                }
            }
        }
    }

    fn list_component(&self, s: &State, component: usize, out: &mut Enabled) {
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
        if self.can_shut_down(s, component) {
            out.actions.push(Action::Shut { component });
        }
        match self.semantics.locks {
            LockRule::Queue => {
                let head = l
                    .lock_queue(s, component)
                    .first()
                    .map(|&lock_queue| lock_queue as usize);
                let head = head.filter(|&head| self.is_free(s, head));
                let acquire = head.map(|executor| Action::Acquire { executor });
                out.actions.extend(acquire);
            }
            LockRule::Fifo => {
                for &executor in l.lock_queue(s, component) {
                    let executor = executor as usize;
                    if self.may_leave(s, executor) {
                        out.actions.push(Action::Acquire { executor });
                    }
                }
            }
            LockRule::Free => {
                let tasks = self.system.components[component].tasks.iter().copied();
                for executor in tasks.chain([executor]) {
                    if l.phase(s, executor) == phase::LOCKING && self.is_free(s, executor) {
                        out.actions.push(Action::Acquire { executor });
                    }
                }
            }
        }
    }

    /// Returns true if an executor in the lock queue may leave it.
    pub(super) fn may_leave(&self, s: &State, executor: usize) -> bool {
        let Some(component) = self.component_of(executor) else {
            return false;
        };
        let queue = self.layout.lock_queue(s, component);
        let mut ahead = (queue.iter())
            .map(|&queue| queue as usize)
            .take_while(|&queue| queue != executor);
        let turn = match self.semantics.locks {
            LockRule::Queue => ahead.next().is_none(),
            LockRule::Fifo => {
                let codel = self
                    .codel(s, executor)
                    .map(|codel| &self.system.codels[codel]);
                !codel.is_some_and(|codel| ahead.any(|queue| self.blocks(s, codel, queue)))
            }
            LockRule::Free => true,
        };
        turn && self.is_free(s, executor)
    }

    /// Returns true if no executing codel blocks the codel of an executor.
    fn is_free(&self, s: &State, executor: usize) -> bool {
        let Some(codel) = self.codel(s, executor) else {
            return true;
        };
        let codel = &self.system.codels[codel];
        !(self.layout.executing(s)).any(|other| other != executor && self.blocks(s, codel, other))
    }

    fn requests(&self, s: &State, out: &mut Enabled) {
        let l = &self.layout;
        for (k, client) in self.system.clients.iter().enumerate() {
            let Some(step) = client.steps.get(l.position(s, k) as usize) else {
                continue;
            };
            let ClientAction::Send { service, .. } = step.action else {
                continue;
            };
            let component = self.system.services[service].component;
            if l.outstanding(s, k) == 0 && l.control(s, component) == control::READY {
                let request = |&next: &usize| Action::Request { client: k, next };
                out.actions.extend(step.next.iter().map(request));
            }
        }
    }

    /// Adds the possible ends of an executing codel or a delay.
    fn outcomes(&self, s: &State, executor: usize, out: &mut Enabled) {
        let l = &self.layout;
        let mut push = |outcome| out.actions.push(Action::Finish { executor, outcome });
        if executor < l.tasks {
            let slot = l.turn(s, executor);
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
        } else if executor < l.tasks + l.components {
            let component = executor - l.tasks;
            push(0);
            let service = l
                .handled(s, component)
                .map(|service| &self.system.services[service]);
            let validates = service.is_some_and(|service| service.validate.is_some())
                && l.codel_number(s, component) == 0;
            let codel = self
                .codel(s, executor)
                .map(|codel| &self.system.codels[codel]);
            if validates || codel.is_some_and(|codel| codel.throws) {
                push(1);
            }
        } else {
            let client = executor - l.tasks - l.components;
            let step = &self.system.clients[client].steps[l.position(s, client) as usize];
            step.next.iter().for_each(|&next| push(next));
        }
    }

    /// Returns true if an exception makes a difference: not if the activity may end as well and no client
    /// depends on the outcome.
    fn tells_throwing(&self, s: &State, slot: usize, yields: &[Yield]) -> bool {
        let outcomes = || {
            self.layout
                .outcomes
                .iter()
                .flatten()
                .any(|outcome| *outcome)
        };
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
