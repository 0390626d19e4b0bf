//! The values of predicates, and the ages of obligations.

use dotgen_timing::scn::ast::{Path, Pred};

use super::Interpreter;
use super::model::{Machine, System};
use super::state::{Control, Doing, First, Phase, State, Status, Who, machine};

/// A predicate on states.
#[derive(Debug, Clone)]
pub(crate) enum Predicate {
    Is(Fact),
    Leave(Fact),
    Not(Box<Predicate>),
    And(Box<Predicate>, Box<Predicate>),
    Or(Box<Predicate>, Box<Predicate>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum At {
    Lock,
    Exec,
    Either,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TaskIs {
    Idle,
    Waiting,
    Running,
    Active,
    /// A period before its next tick.
    Tick,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ActivityIs {
    Waiting,
    Run,
    Stop,
    Void,
    Active,
}

/// A fact about one component, or client.
#[derive(Debug, Clone)]
pub(crate) enum Fact {
    Task(usize, usize, TaskIs),
    /// A state of the permanent activity of a task, or of an activity.
    State(usize, Owner, usize, At),
    Activity(usize, usize, ActivityIs),
    /// The control task is at one of these codels of a service.
    Control(usize, usize, Vec<usize>, At),
    Busy(usize),
    /// A client is at one of these nodes.
    Client(usize, Vec<usize>),
}

/// The owner of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Owner {
    Task(usize),
    Service(usize),
}

pub(crate) fn predicate(system: &System, written: &Pred) -> Predicate {
    let both = |a: &Pred, b: &Pred| {
        let both = [a, b].map(|operand| Box::new(predicate(system, operand)));
        let [a, b] = both;
        (a, b)
    };
    match written {
        Pred::Atom(path) => match fact(system, path) {
            (fact, true) => Predicate::Is(fact),
            (fact, false) => Predicate::Not(Box::new(Predicate::Is(fact))),
        },
        Pred::Leave(path) => Predicate::Leave(fact(system, path).0),
        Pred::Comparison(_) => unreachable!("not generated"),
        Pred::Not(negated) => Predicate::Not(Box::new(predicate(system, negated))),
        Pred::And(a, b) => {
            let (a, b) = both(a, b);
            Predicate::And(a, b)
        }
        Pred::Or(a, b) => {
            let (a, b) = both(a, b);
            Predicate::Or(a, b)
        }
    }
}

/// Returns a fact, and whether the fact or its negation is meant.
fn fact(system: &System, path: &Path) -> (Fact, bool) {
    let names: Vec<&str> = path.names.iter().map(|name| name.value.as_str()).collect();
    if let Some(k) = system.clients.iter().position(|client| client.name == names[0]) {
        let client = &system.clients[k];
        let nodes = match names.get(1) {
            None => vec![client.end()],
            Some(&label) => (0..client.nodes.len())
                .filter(|&node| client.nodes[node].label.as_deref() == Some(label))
                .collect(),
        };
        return (Fact::Client(k, nodes), true);
    }
    let c = system.component(names[0]);
    let component = &system.components[c];
    let Some(&second) = names.get(1) else {
        return (Fact::Busy(c), true);
    };
    let word = |from: usize| names.get(from).copied().unwrap_or_default();
    let state = |machine: &Machine| {
        let name = word(2);
        machine.states.iter().position(|state| state.name == name)
    };
    let at = |word: &str| match word {
        "lock" | "waiting" => At::Lock,
        "exec" | "running" => At::Exec,
        _ => At::Either,
    };
    let task = component.tasks.iter().position(|task| task.name == second);
    let service = component.services.iter().position(|service| service.name == second);
    if let Some(t) = task {
        if let Some(state) = state(&component.tasks[t].machine) {
            return (Fact::State(c, Owner::Task(t), state, at(word(3))), true);
        }
        let is = match word(2) {
            "idle" => TaskIs::Idle,
            "waiting" => TaskIs::Waiting,
            "running" => TaskIs::Running,
            "tick" => TaskIs::Tick,
            _ => TaskIs::Active,
        };
        return (Fact::Task(c, t, is), true);
    }
    let Some(s) = service else {
        return (Fact::Busy(c), second != "idle");
    };
    let model = &component.services[s];
    let named = |name: &str| {
        let mut all = 0..model.control.len();
        all.find(|&codel| model.control[codel].name.as_deref() == Some(name))
    };
    if let Some(codel) = named(word(2)) {
        return (Fact::Control(c, s, vec![codel], at(word(3))), true);
    }
    let Some((_, machine)) = &model.activity else {
        let all = (0..model.control.len()).collect();
        return (Fact::Control(c, s, all, at(word(2))), true);
    };
    // `stop` and similar words are states if the machine has them and a status follows. As the last name such
    // a word is a status.
    let status = match word(2) {
        "waiting" => Some(ActivityIs::Waiting),
        "run" | "running" => Some(ActivityIs::Run),
        "stop" if names.len() == 3 && state(machine).is_none() => Some(ActivityIs::Stop),
        "void" | "idle" => Some(ActivityIs::Void),
        "" => Some(ActivityIs::Active),
        _ => None,
    };
    match (status, state(machine)) {
        (Some(status), _) => (Fact::Activity(c, s, status), true),
        (None, Some(state)) => (Fact::State(c, Owner::Service(s), state, at(word(3))), true),
        (None, None) => panic!("what is {}?", path.text()),
    }
}

impl Interpreter<'_> {
    /// Updates obligations. Every time the trigger becomes true an obligation begins, which proceeds from
    /// response to response.
    pub(super) fn watch(&self, before: Option<&State>, now: &mut State) {
        for (i, (trigger, responses)) in self.within.iter().enumerate() {
            let value = |predicate: &Predicate| self.holds(before, now, predicate);
            let mut open = now.obligations[i].clone();
            let was = before.is_some_and(|before| self.holds(Some(before), before, trigger));
            if value(trigger) && !was {
                open.insert((0, 0));
            }
            let moved = open.into_iter().map(|(mut stage, age)| {
                while responses.get(stage).is_some_and(value) {
                    stage += 1;
                }
                (stage, age)
            });
            now.obligations[i] = moved.filter(|at| at.0 < responses.len()).collect();
        }
        self.remember(before, now);
    }

    pub(super) fn holds(&self, before: Option<&State>, now: &State, predicate: &Predicate) -> bool {
        match predicate {
            Predicate::Is(fact) => self.fact(now, fact),
            Predicate::Leave(fact) => {
                before.is_some_and(|before| self.fact(before, fact)) && !self.fact(now, fact)
            }
            Predicate::Not(predicate) => !self.holds(before, now, predicate),
            Predicate::And(a, b) => self.holds(before, now, a) && self.holds(before, now, b),
            Predicate::Or(a, b) => self.holds(before, now, a) || self.holds(before, now, b),
        }
    }

    fn fact(&self, s: &State, fact: &Fact) -> bool {
        let doing = |c: usize, who: Who, at: At| match s.doing(c, who) {
            None => false,
            Some(Doing::Executing(_)) => at != At::Lock,
            Some(_) => at != At::Exec,
        };
        match fact {
            &Fact::Task(c, t, is) => {
                let phase = &s.components[c].tasks[t].phase;
                match is {
                    TaskIs::Idle => *phase == Phase::Idle,
                    TaskIs::Waiting => *phase == Phase::WaitingForCore,
                    TaskIs::Running => !matches!(phase, Phase::Idle | Phase::WaitingForCore),
                    TaskIs::Active => *phase != Phase::Idle,
                    TaskIs::Tick => {
                        let task = &s.components[c].tasks[t];
                        task.timer.is_some()
                            && task.timer == self.system.components[c].tasks[t].period
                    }
                }
            }
            &Fact::State(c, owner, state, at) => s.everybody(c).any(|who| {
                let Some(t) = who.task() else { return false };
                let task = &s.components[c].tasks[t];
                let Phase::Pass(slots, turn, _) = &task.phase else {
                    return false;
                };
                let Some(slot) = slots.get(*turn).and_then(|&slot| task.slots[slot].as_ref())
                else {
                    return false;
                };
                let same = match owner {
                    Owner::Task(of) => of == t && slot.service.is_none(),
                    Owner::Service(of) => slot.service == Some(of),
                };
                let has = machine(self.system, c, t, slot).states.len() > slot.at;
                same && has && slot.at == state && doing(c, who, at)
            }),
            &Fact::Activity(c, service, is) => {
                let slots = s.components[c].tasks.iter().flat_map(|task| &task.slots);
                let all = slots.flatten().filter(|slot| slot.service == Some(service));
                let mut all = all.map(|slot| slot.status);
                match is {
                    ActivityIs::Void => all.next().is_none(),
                    ActivityIs::Active => all.next().is_some(),
                    ActivityIs::Waiting => {
                        all.any(|status| matches!(status, Status::Asked | Status::Init(_)))
                    }
                    ActivityIs::Run => all.any(|status| status == Status::Run),
                    ActivityIs::Stop => all.any(|status| status == Status::Stop),
                }
            }
            Fact::Control(c, service, codels, at) => match &s.components[*c].control {
                Control::Codel(request, codel, _) => {
                    request.service == *service
                        && codels.contains(codel)
                        && doing(*c, Who::Control, *at)
                }
                _ => false,
            },
            &Fact::Busy(c) => s.components[c].control != Control::Ready,
            Fact::Client(k, nodes) => s.clients[*k].at.is_some_and(|node| nodes.contains(&node)),
        }
    }
}

impl First {
    /// Returns true if jobs of the task are measured.
    pub(super) fn is_over(self) -> bool {
        self == First::Over
    }
}
