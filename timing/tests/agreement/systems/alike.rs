//! Random systems of symmetric, or nearly symmetric, parts.

use dotgen_timing::property::{Atom, Predicate};
use dotgen_timing::system::{
    Automaton, AutomatonId, Client, ClientAction, ClientStep, Codel, CodelId, CodelSet, Component,
    ComponentId, Machine, MachineId, Policy, Service, ServiceId, State, Task, TaskId, TimedSystem,
};
use typed_index_collections::TiVec;

use super::{Dice, automaton, client, empty, machine, predicate, service};

/// Returns a system of two or three copies of a component, or of its contents, with pairs of predicates;
/// sometimes the copies differ.
pub(crate) fn alike(dice: &mut Dice) -> (TimedSystem, Vec<(Predicate, Predicate)>) {
    let one = part(dice);
    let copies = 2 + usize::from(dice.in_ten(4));
    let together = dice.in_ten(5);
    let mut system = TimedSystem {
        components: TiVec::new(),
        tasks: TiVec::new(),
        machines: TiVec::new(),
        automata: TiVec::new(),
        codels: TiVec::new(),
        services: TiVec::new(),
        clients: TiVec::new(),
        ..one.clone()
    };
    for copy in 0..copies {
        Copier { one: &one, copy, together }.add_to(&mut system);
    }
    between(&mut system, dice, (&one, copies, together));
    if dice.in_ten(2) && !system.codels.is_empty() {
        let codel = CodelId::from(dice.below(system.codels.len() as u32) as usize);
        system.codels[codel].upper = system.codels[codel].upper.saturating_add(1);
    }
    let mut asked = Vec::new();
    for _ in 0..dice.below(3) {
        let everywhere = |dice: &mut Dice| {
            let predicate = predicate(&one, dice);
            if dice.in_ten(3) {
                return predicate;
            }
            let and = dice.in_ten(3);
            (1..copies).fold(predicate.clone(), |all, copy| {
                let other = Box::new(renamed(&predicate, &one, copy));
                if and {
                    Predicate::And(Box::new(all), other)
                } else {
                    Predicate::Or(other, Box::new(all))
                }
            })
        };
        asked.push((everywhere(dice), everywhere(dice)));
    }
    (system, asked)
}

/// Returns a component with a task, at most two services and at most one client.
fn part(dice: &mut Dice) -> TimedSystem {
    let mut system = empty(dice);
    system.platform.policy = dice.pick(&[Policy::Fifo, Policy::Edf, Policy::Any]);
    system.components.push(Component {
        name: "c".to_owned(),
        tasks: vec![TaskId::default()],
        services: Vec::new(),
    });
    let permanent = dice.in_ten(5).then(|| {
        let machine = machine(&mut system, dice, ComponentId::from(0), "c.t".to_owned());
        automaton(&mut system, 0, machine, None)
    });
    system.tasks.push(Task {
        places: 16,
        priority: None,
        affinity: None,
        name: "t".to_owned(),
        component: ComponentId::from(0),
        period: dice.in_ten(6).then(|| 3 + dice.below(4)),
        delay: 0,
        keep_idle_tick: dice.in_ten(2),
        permanent,
        slots: Vec::new(),
        src: None,
    });
    for v in 0..dice.below(3) as usize {
        service(&mut system, dice, v);
    }
    if !system.services.is_empty() && dice.in_ten(8) {
        let client = client(&system, dice, 0);
        system.clients.push(client);
    }
    system
}

/// Adds equal exclusions and interruptions between the copies.
fn between(
    system: &mut TimedSystem,
    dice: &mut Dice,
    (one, copies, together): (&TimedSystem, usize, bool),
) {
    let codels = one.codels.len();
    let pairs = |n: usize| (0..n).flat_map(move |a| (0..n).map(move |b| (a, b)));
    for (c, d) in pairs(codels) {
        let (inside, across) = (dice.in_ten(2), dice.in_ten(2));
        for (a, b) in pairs(copies) {
            let (x, y) = (a * codels + c, b * codels + d);
            if x != y && ((a == b && inside) || (a != b && across)) {
                system.exclude(x.into(), y.into());
            }
        }
    }
    let services = one.services.len();
    for (v, w) in pairs(services) {
        let (inside, across) = (dice.in_ten(3), together && dice.in_ten(3));
        for (a, b) in pairs(copies) {
            if (a == b && inside) || (a != b && across) {
                let (v, w) = (a * services + v, b * services + w);
                system.services[ServiceId::from(v)].interrupts.push(w.into());
            }
        }
    }
}

/// Returns the index of a part in a copy, after this many parts of other copies.
fn shifted<I: From<usize> + Into<usize>>(id: I, by: usize) -> I {
    I::from(by + id.into())
}

/// Returns the indices of parts in a copy.
fn all<I: Copy>(list: &[I], name: impl Fn(I) -> I) -> Vec<I> {
    list.iter().map(|&id| name(id)).collect()
}

/// Adds one copy of a part to a system.
struct Copier<'o> {
    one: &'o TimedSystem,
    copy: usize,
    together: bool,
}

impl Copier<'_> {
    fn component(&self) -> ComponentId {
        ComponentId::from(if self.together { 0 } else { self.copy })
    }

    fn add_to(&self, system: &mut TimedSystem) {
        let (one, copy) = (self.one, self.copy);
        let task = |index: usize| copy * one.tasks.len() + index;
        let machine = |id: MachineId| shifted(id, copy * one.machines.len());
        let automaton = |id: AutomatonId| shifted(id, copy * one.automata.len());
        let codel = |id: CodelId| shifted(id, copy * one.codels.len());
        let service = |id: ServiceId| shifted(id, copy * one.services.len());
        if system.components.next_key() <= self.component() {
            system.components.push(Component {
                name: format!("c{copy}"),
                tasks: Vec::new(),
                services: Vec::new(),
            });
        }
        let component = &mut system.components[self.component()];
        component.tasks.extend((0..one.tasks.len()).map(task).map(TaskId::from));
        component.services.extend(one.services.keys().map(service));
        system.tasks.extend(one.tasks.iter().map(|task| Task {
            component: self.component(),
            permanent: task.permanent.map(automaton),
            slots: all(&task.slots, automaton),
            ..task.clone()
        }));
        system.machines.extend(one.machines.iter().map(|machine| {
            Machine {
                states: (machine.states.iter())
                    .map(|state| State { codel: codel(state.codel), ..state.clone() })
                    .collect(),
                ..machine.clone()
            }
        }));
        system.automata.extend(one.automata.iter().map(|automaton| Automaton {
            task: TaskId::from(task(usize::from(automaton.task))),
            machine: machine(automaton.machine),
            service: automaton.service.map(service),
        }));
        system.codels.extend(one.codels.iter().map(|codel| Codel {
            component: self.component(),
            conflicts: CodelSet::default(),
            ..codel.clone()
        }));
        system.services.extend(one.services.iter().map(|service| Service {
            component: self.component(),
            validate: service.validate.map(codel),
            simple: all(&service.simple, codel),
            slots: all(&service.slots, automaton),
            ..service.clone()
        }));
        system.clients.extend(one.clients.iter().map(|client| {
            Client {
                steps: (client.steps.iter())
                    .map(|step| ClientStep {
                        action: match step.action.clone() {
                            ClientAction::Send { service: index, trackers, accepted, aborts } => {
                                ClientAction::Send {
                                    service: service(index),
                                    trackers,
                                    accepted,
                                    aborts,
                                }
                            }
                            other => other,
                        },
                        ..step.clone()
                    })
                    .collect(),
                ..client.clone()
            }
        }));
    }
}

fn renamed(predicate: &Predicate, one: &TimedSystem, copy: usize) -> Predicate {
    let atom = |atom: &Atom| match atom.clone() {
        Atom::Task(task, state) => {
            Atom::Task(TaskId::from(copy * one.tasks.len() + usize::from(task)), state)
        }
        Atom::State { machine, state, phase } => {
            Atom::State { machine: shifted(machine, copy * one.machines.len()), state, phase }
        }
        other => other,
    };
    let other = |predicate: &Predicate| Box::new(renamed(predicate, one, copy));
    match predicate {
        Predicate::Atom(proposition) => Predicate::Atom(atom(proposition)),
        Predicate::Leave(proposition) => Predicate::Leave(atom(proposition)),
        Predicate::Not(predicate) => Predicate::Not(other(predicate)),
        Predicate::And(a, b) => Predicate::And(other(a), other(b)),
        Predicate::Or(a, b) => Predicate::Or(other(a), other(b)),
    }
}
