//! The possible steps.

use dotgen_timing::scn::ast::Policy;
use dotgen_timing::scn::semantics::LockRule;

use super::Interpreter;
use super::model::{Action, Outcome};
use super::state::{Control, Doing, First, Phase, State, Status, Tracked, Who};

/// An atomic step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    /// A client proceeds to a node.
    Proceed(usize, usize),
    /// A control task takes the request of a client, which proceeds to a node.
    Request(usize, usize),
    Tick(usize, usize),
    /// A task asks for a core, or finds no work.
    Ask(usize, usize),
    Grant(usize, usize),
    /// Under preemption, a thread that has become ready is listed.
    Queue((usize, Who)),
    /// A ready thread takes a free core, or that of another thread.
    Give((usize, Who)),
    Swap((usize, Who), (usize, Who)),
    /// Beginning of a pass.
    Begin(usize, usize),
    Ticket(usize, Who),
    Leave(usize, Who),
    /// End of a codel of a machine.
    End(usize, usize, Outcome),
    /// End of a codel of the control task, and whether the request continues.
    Handled(usize, bool),
    /// A task wakes the others.
    Wake(usize, usize),
    /// The rest of the handling of a request.
    Rest(usize),
    /// Ended activities are reported.
    Report(usize),
    /// A killed component proceeds with its shutdown.
    Die(usize),
}

impl Interpreter<'_> {
    /// Returns the possible steps, and whether one of them must happen before time passes.
    pub(super) fn possible(&self, s: &State) -> (Vec<Step>, bool) {
        let mut out = Vec::new();
        self.clients(s, &mut out);
        if !out.is_empty() {
            return (out, true);
        }
        let tasks = || {
            let all = s.components.iter().enumerate();
            all.flat_map(|(c, component)| (0..component.tasks.len()).map(move |t| (c, t)))
        };
        // Cores: first insertions into the queue, then decisions, then all other steps.
        out.extend(
            tasks()
                .filter(|&(c, t)| self.asks_for_core(s, c, t) && self.wants(s, c, t))
                .filter(|&(c, t)| self.could_run(s, c, t))
                .map(|(c, t)| Step::Ask(c, t)),
        );
        if out.is_empty() {
            if self.preempts() { self.gives(s, &mut out) } else { self.grants(s, &mut out) }
        }
        if !out.is_empty() {
            return (out, true);
        }
        let mut urgent = false;
        for (c, t) in tasks() {
            let task = &s.components[c].tasks[t];
            if task.timer == Some(0) {
                out.push(Step::Tick(c, t));
            }
            if task.wake {
                out.push(Step::Wake(c, t));
            } else if task.phase == Phase::Between
                || (!self.asks_for_core(s, c, t) && self.wants(s, c, t))
            {
                out.push(Step::Begin(c, t));
            } else if self.wants(s, c, t) && !self.could_run(s, c, t) {
                // A wake-up inserts nothing into the queue when it is consumed: the step is like any other,
                // and a request may be handled before it.
                out.push(Step::Ask(c, t));
            }
        }
        for (c, component) in s.components.iter().enumerate() {
            match component.control {
                Control::Rest(..) => out.push(Step::Rest(c)),
                Control::Ready if component.signal => out.push(Step::Report(c)),
                _ => {}
            }
            if self.dies(s, c) {
                out.push(Step::Die(c));
            }
            for who in s.everybody(c) {
                if s.doing(c, who) == Some(Doing::Nothing) {
                    out.push(Step::Ticket(c, who));
                }
            }
            let waiting = component.tickets.iter();
            let leaving = waiting.filter(|&&who| self.may_leave(s, c, who));
            out.extend(leaving.map(|&who| Step::Leave(c, who)));
        }
        for (k, entry) in s.clients.iter().enumerate() {
            let client = &self.system.clients[k];
            let Some(at) = entry.at else { continue };
            if let Action::Send(c, _) = client.nodes[at].action
                && s.components[c].control == Control::Ready
                && !entry.outstanding
            {
                let next = client.reach(&client.nodes[at].next);
                out.extend(next.into_iter().map(|next| Step::Request(k, next)));
            }
        }
        if self.preempts() {
            out.retain(|&step| {
                self.thread(s, step).is_none_or(|(c, who)| self.has_core(s, c, who))
            });
        }
        urgent |= !out.is_empty();
        for (c, component) in self.system.components.iter().enumerate() {
            for who in s.everybody(c) {
                let Some(Doing::Executing(elapsed)) = s.doing(c, who) else {
                    continue;
                };
                let codel = s.codel(self.system, c, who).expect("it executes one");
                let codel = &component.codels[codel];
                urgent |= elapsed == codel.upper;
                // A codel at its end does end, whichever thread takes its core at that moment.
                if elapsed >= codel.lower && (self.has_core(s, c, who) || elapsed == codel.upper) {
                    self.ends(s, c, who, &mut out);
                }
            }
        }
        for (k, entry) in s.clients.iter().enumerate() {
            if let Some((lower, upper)) = s.delay(self.system, k) {
                let client = &self.system.clients[k];
                urgent |= entry.clock == upper;
                if entry.clock >= lower {
                    let next = client.reach(&client.nodes[entry.at.unwrap_or(0)].next);
                    out.extend(next.into_iter().map(|next| Step::Proceed(k, next)));
                }
            }
        }
        self.swaps(s, &mut out);
        (out, urgent)
    }

    /// Returns the component that a client addresses.
    pub(super) fn asked(&self, s: &State, k: usize) -> Option<usize> {
        match self.system.clients[k].nodes[s.clients[k].at?].action {
            Action::Send(c, _) => Some(c),
            _ => None,
        }
    }

    fn clients(&self, s: &State, out: &mut Vec<Step>) {
        for (k, entry) in s.clients.iter().enumerate() {
            let client = &self.system.clients[k];
            let next = match entry.at {
                None => client.reach(&client.first),
                Some(at) => {
                    // Outcome of a request. Without a request, the outcome counts as success.
                    let end = |of: Option<(usize, usize)>| {
                        let mut asked = entry.tracked.iter().rev();
                        match asked.find(|&&(d, s, _)| of.is_none_or(|of| of == (d, s))) {
                            None => Some(true),
                            Some(&(.., Tracked::Over(succeeded))) => Some(succeeded),
                            Some(_) => None,
                        }
                    };
                    let over = match client.nodes[at].action {
                        Action::AwaitAccepted => !entry.outstanding,
                        Action::AwaitEnded(of) => end(of).is_some(),
                        Action::Either => {
                            for &node in &client.nodes[at].next {
                                if let Action::AwaitOutcome(of, succeeds) =
                                    client.nodes[node].action
                                    && end(of) == Some(succeeds)
                                {
                                    let next = client.reach(&client.nodes[node].next);
                                    out.extend(next.into_iter().map(|next| Step::Proceed(k, next)));
                                }
                            }
                            false
                        }
                        _ => false,
                    };
                    if over { client.reach(&client.nodes[at].next) } else { continue }
                }
            };
            out.extend(next.into_iter().map(|next| Step::Proceed(k, next)));
        }
    }

    /// Returns true if an idle task has a reason to begin a cycle.
    pub(super) fn wants(&self, s: &State, c: usize, t: usize) -> bool {
        let task = &s.components[c].tasks[t];
        let woken = match self.system.components[c].tasks[t].period {
            Some(_) => task.flag.is_some(),
            None => task.runnable,
        };
        woken
            && !task.gone
            && task.phase == Phase::Idle
            && task.first != First::NotStarted
            && !task.wake
    }

    /// Returns true if a cycle of a task could execute any codel.
    pub(super) fn could_run(&self, s: &State, c: usize, t: usize) -> bool {
        let slots = s.components[c].tasks[t].slots.iter().flatten();
        slots.into_iter().any(|slot| match slot.status {
            Status::Init(released) => released || slot.mark,
            Status::Run | Status::Stop => true,
            Status::Asked => slot.mark,
            Status::Ended(_) => false,
        })
    }

    fn grants(&self, s: &State, out: &mut Vec<Step>) {
        let Some(cores) = self.cores else { return };
        let tasks = s.components.iter().flat_map(|component| &component.tasks);
        let busy = tasks.filter(|task| task.on_core).count();
        if busy >= cores || s.queue.is_empty() {
            return;
        }
        let deadline = |&(c, t): &(usize, usize)| {
            let period = self.system.components[c].tasks[t].period;
            let since = s.components[c].tasks[t].job;
            match (period, since) {
                (Some(period), Some(since)) => i64::from(period) - i64::from(since.tick),
                _ => i64::MAX,
            }
        };
        let grant = |&(c, t): &(usize, usize)| Step::Grant(c, t);
        match self.system.policy {
            Policy::Fifo => out.extend(s.queue.first().map(grant)),
            Policy::Any => out.extend(s.queue.iter().map(grant)),
            // The first of several equal deadlines.
            Policy::Edf => {
                out.extend(s.queue.iter().min_by_key(|queue| deadline(queue)).map(grant));
            }
            Policy::Priority | Policy::Fair => unreachable!("cores are not granted for a cycle"),
        }
    }

    /// Returns true if a thread with a ticket may execute its codel now.
    pub(super) fn may_leave(&self, s: &State, c: usize, who: Who) -> bool {
        let codel = |c: usize, who: Who| {
            let at = s.codel(self.system, c, who);
            at.map(|codel| &self.system.components[c].codels[codel])
        };
        let Some(own) = codel(c, who) else {
            return false;
        };
        let waits_for = |d: usize, thread: Who| {
            codel(d, thread).is_some_and(|codel| {
                if d == c {
                    own.waits_for.contains(&codel.executed)
                } else {
                    own.ports.iter().any(|port| codel.ports.contains(port))
                }
            })
        };
        let mut ahead = s.components[c].tickets.iter().take_while(|ticket| **ticket != who);
        let turn = match self.system.semantics.locks {
            LockRule::Queue => ahead.next().is_none(),
            LockRule::Fifo => !ahead.any(|&ticket| waits_for(c, ticket)),
            LockRule::Free => true,
        };
        let others =
            (0..s.components.len()).flat_map(|d| s.everybody(d).map(move |thread| (d, thread)));
        let mut others = others.filter(|other| *other != (c, who));
        turn && others.all(|(d, other)| {
            let executing = matches!(s.doing(d, other), Some(Doing::Executing(_)));
            !executing || !waits_for(d, other)
        })
    }

    fn ends(&self, s: &State, c: usize, who: Who, out: &mut Vec<Step>) {
        match who {
            Who::Control => {
                let Control::Codel(request, at, _) = s.components[c].control else {
                    return;
                };
                let service = &self.system.components[c].services[request.service];
                out.push(Step::Handled(c, true));
                if service.control[at].can_fail {
                    out.push(Step::Handled(c, false));
                }
            }
            Who::Task(t) => {
                let task = &s.components[c].tasks[t];
                let Phase::Pass(slots, at, _) = &task.phase else {
                    return;
                };
                let Some(slot) = &task.slots[slots[*at]] else {
                    return;
                };
                let machine = super::state::machine(self.system, c, t, slot);
                let outcomes = machine.states[slot.at].outcomes.iter();
                out.extend(outcomes.map(|&outcome| Step::End(c, t, outcome)));
            }
        }
    }
}
