//! The possible actions.

use dotgen_timing::explore::Action;
use dotgen_timing::scn::semantics::LockRule;
use dotgen_timing::system::{
    AutomatonId, ClientAction, ClientId, ComponentId, FOREVER, Policy, TaskId, Yield,
};

use super::Brute;
use super::state::{Doing, Mode, State, Status, Step, Tracked};

impl Brute<'_> {
    /// Returns the possible actions, and whether one of them must happen before time passes.
    pub(super) fn actions(&self, s: &State) -> (Vec<Action>, bool) {
        let sys = self.system;
        let mut out = Vec::new();
        for (k, client) in s.clients.iter_enumerated() {
            let definition = &sys.clients[k];
            let over = |t: usize| client.tracked[t] == Tracked::Over;
            match client.at {
                None => out.extend(
                    definition.first.iter().map(|&next| Action::Proceed { client: k, next }),
                ),
                Some(at) if at < definition.steps.len() => {
                    let ready = match definition.steps[at].action {
                        ClientAction::AwaitAccepted => !client.outstanding,
                        ClientAction::AwaitEnded(t) => over(t),
                        ClientAction::AwaitAny | ClientAction::AwaitOutcome(..) => {
                            unreachable!("the published models do not know how requests end")
                        }
                        _ => false,
                    };
                    if ready {
                        let next = &definition.steps[at].next;
                        out.extend(next.iter().map(|&next| Action::Proceed { client: k, next }));
                    }
                }
                Some(_) => {}
            }
        }
        if !out.is_empty() {
            return (out, true);
        }
        for (t, task) in s.tasks.iter().enumerate() {
            let definition = &sys.tasks[TaskId::from(t)];
            let wants = match definition.period {
                Some(_) => task.tick && (!definition.keep_idle_tick || self.something_to_do(s, t)),
                None => self.something_to_do(s, t),
            };
            if task.status == Status::Idle && wants {
                out.push(Action::Release { task: t });
            }
        }
        if !out.is_empty() {
            return (out, true);
        }
        let busy = (0..s.tasks.len())
            .filter(|&t| s.tasks[t].status == Status::Running && sys.needs_core(TaskId::from(t)))
            .count();
        if !s.queue.is_empty() && busy < sys.platform.cores.unwrap() as usize {
            match sys.platform.policy {
                Policy::Fifo => out.push(Action::Grant { task: s.queue[0] }),
                // The other policies belong to other rules.
                Policy::Any | Policy::Priority | Policy::Fair => {
                    out.extend(s.queue.iter().map(|&task| Action::Grant { task }));
                }
                Policy::Edf => {
                    // The queue is in order of release; the first least deadline wins.
                    let deadline = |t: usize| match sys.tasks[TaskId::from(t)].period {
                        Some(p) => i64::from(p) - i64::from(s.tasks[t].age),
                        None => i64::MAX,
                    };
                    let task = *s.queue.iter().min_by_key(|&&t| deadline(t)).unwrap();
                    out.push(Action::Grant { task });
                }
            }
            return (out, true);
        }
        let mut urgent = false;
        for (t, task) in s.tasks.iter().enumerate() {
            if let (Some(timer), Some(period)) = (task.timer, sys.tasks[TaskId::from(t)].period)
                && timer == period + sys.tasks[TaskId::from(t)].delay
            {
                out.push(Action::Tick { task: t });
                urgent = true;
            }
        }
        for e in 0..self.executors(s) {
            match self.doing(s, e) {
                Doing::Locking if self.locks_free(s, e) => {
                    out.push(Action::Acquire { executor: e });
                    urgent = true;
                }
                Doing::Executing(elapsed) => {
                    let (a, b) = self.bounds(s, e);
                    if elapsed >= a {
                        for outcome in self.outcomes(s, e) {
                            out.push(Action::Finish { executor: e, outcome });
                        }
                    }
                    urgent |= elapsed == b && b != FOREVER;
                }
                _ => {}
            }
        }
        for (c, control) in s.controls.iter_enumerated() {
            if control.step == Step::Ready && control.signal {
                out.push(Action::Signal { component: c });
                urgent = true;
            }
        }
        for (k, client) in s.clients.iter_enumerated() {
            let Some(step) = client.at.and_then(|at| sys.clients[k].steps.get(at)) else {
                continue;
            };
            if let ClientAction::Send { service, .. } = step.action {
                let control = &s.controls[sys.services[service].component];
                if control.step == Step::Ready && !control.signal && !client.outstanding {
                    out.extend(step.next.iter().map(|&next| Action::Request { client: k, next }));
                    urgent = true;
                }
            }
        }
        (out, urgent)
    }

    fn outcomes(&self, s: &State, e: usize) -> Vec<usize> {
        let (na, nc) = (s.automata.len(), s.controls.len());
        if e < na {
            let a = AutomatonId::from(e);
            let machine = self.system.machine_of(a);
            let automaton = &s.automata[a];
            let yields = &machine.states[automaton.at].yields;
            let fresh = |y: &Yield| match (y, machine.loop_limit) {
                (&Yield::Next(to), Some(limit)) => automaton.visits[to] < limit,
                _ => true,
            };
            let mut out: Vec<usize> = (0..yields.len()).filter(|&i| fresh(&yields[i])).collect();
            if out.is_empty() && machine.rounds {
                out =
                    (0..yields.len()).filter(|&i| yields[i] != Yield::Next(automaton.at)).collect();
            }
            out
        } else if e < na + nc {
            match s.controls[ComponentId::from(e - na)].step {
                Step::Validate(..) => vec![0, 1],
                _ => vec![0],
            }
        } else {
            let k = ClientId::from(e - na - nc);
            self.system.clients[k].steps[s.clients[k].at.unwrap()].next.clone()
        }
    }

    fn locks_free(&self, s: &State, e: usize) -> bool {
        let mine = &self.system.codels[self.codel(s, e)].conflicts;
        let n = s.automata.len() + s.controls.len();
        for other in 0..n {
            if other != e
                && matches!(self.doing(s, other), Doing::Executing(_))
                && mine.contains(self.codel(s, other))
            {
                return false;
            }
        }
        if self.system.platform.semantics.locks == LockRule::Fifo {
            let place = s.lock_queue.iter().position(|&lock_queue| lock_queue == e).unwrap();
            if s.lock_queue[..place]
                .iter()
                .any(|&lock_queue| mine.contains(self.codel(s, lock_queue)))
            {
                return false;
            }
        }
        true
    }

    fn something_to_do(&self, s: &State, t: usize) -> bool {
        self.order(t).iter().any(|&a| self.can_run(s, a))
    }

    pub(super) fn can_run(&self, s: &State, a: AutomatonId) -> bool {
        s.automata[a].doing == Doing::Nothing
            && matches!(s.automata[a].mode, Mode::Normal | Mode::Run | Mode::Stop)
    }

    /// Returns the automata of a task in the order of turns.
    pub(super) fn order(&self, t: usize) -> Vec<AutomatonId> {
        let task = &self.system.tasks[TaskId::from(t)];
        task.permanent.iter().chain(&task.slots).copied().collect()
    }
}
