//! Random systems of symmetric, or nearly symmetric, parts.

use dotgen_timing::property::{Atom, Predicate};
use dotgen_timing::system::{
    Automaton, Client, ClientAction, ClientStep, Codel, CodelSet, Component, Machine, Policy,
    Service, State, Task, TimedSystem,
};

use super::{Dice, automaton, client, empty, machine, predicate, service};

/// Returns a system of two or three copies of a component, or of its contents, with pairs of predicates;
/// sometimes the copies differ.
pub(crate) fn alike(dice: &mut Dice) -> (TimedSystem, Vec<(Predicate, Predicate)>) {
    let one = part(dice);
    let copies = 2 + usize::from(dice.in_ten(4));
    let together = dice.in_ten(5);
    let mut system = TimedSystem {
        components: Vec::new(),
        tasks: Vec::new(),
        machines: Vec::new(),
        automata: Vec::new(),
        codels: Vec::new(),
        services: Vec::new(),
        clients: Vec::new(),
        ..one.clone()
    };
    for copy in 0..copies {
        Copier {
            one: &one,
            copy,
            together,
        }
        .add_to(&mut system);
    }
    between(&mut system, dice, (&one, copies, together));
    if dice.in_ten(2) && !system.codels.is_empty() {
        let it = dice.below(system.codels.len() as u32) as usize;
        system.codels[it].upper = system.codels[it].upper.saturating_add(1);
    }
    let mut asked = Vec::new();
    for _ in 0..dice.below(3) {
        let everywhere = |dice: &mut Dice| {
            let it = predicate(&one, dice);
            if dice.in_ten(3) {
                return it;
            }
            let and = dice.in_ten(3);
            (1..copies).fold(it.clone(), |all, copy| {
                let other = Box::new(renamed(&it, &one, copy));
                match and {
                    true => Predicate::And(Box::new(all), other),
                    false => Predicate::Or(other, Box::new(all)),
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
        tasks: vec![0],
        services: Vec::new(),
    });
    let permanent = dice.in_ten(5).then(|| {
        let machine = machine(&mut system, dice, 0, "c.t".to_owned());
        automaton(&mut system, 0, machine, None)
    });
    system.tasks.push(Task {
        places: 16,
        priority: None,
        affinity: None,
        name: "t".to_owned(),
        component: 0,
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
    let (codels, services) = (one.codels.len(), one.services.len());
    let pairs = |n: usize| (0..n).flat_map(move |a| (0..n).map(move |b| (a, b)));
    for (c, d) in pairs(codels) {
        let (inside, across) = (dice.in_ten(2), dice.in_ten(2));
        for (a, b) in pairs(copies) {
            let (x, y) = (a * codels + c, b * codels + d);
            if x != y && ((a == b && inside) || (a != b && across)) {
                system.exclude(x, y);
            }
        }
    }
    for (v, w) in pairs(services) {
        let (inside, across) = (dice.in_ten(3), together && dice.in_ten(3));
        for (a, b) in pairs(copies) {
            if (a == b && inside) || (a != b && across) {
                system.services[a * services + v]
                    .interrupts
                    .push(b * services + w);
            }
        }
    }
}

/// Adds one copy of a part to a system.
struct Copier<'o> {
    one: &'o TimedSystem,
    copy: usize,
    together: bool,
}

impl Copier<'_> {
    fn component(&self) -> usize {
        if self.together { 0 } else { self.copy }
    }

    fn add_to(&self, system: &mut TimedSystem) {
        let (one, copy) = (self.one, self.copy);
        let task = |it: usize| copy * one.tasks.len() + it;
        let machine = |it: usize| copy * one.machines.len() + it;
        let automaton = |it: usize| copy * one.automata.len() + it;
        let codel = |it: usize| copy * one.codels.len() + it;
        let service = |it: usize| copy * one.services.len() + it;
        let all = |list: &[usize], name: &dyn Fn(usize) -> usize| -> Vec<usize> {
            list.iter().map(|&it| name(it)).collect()
        };
        if system.components.len() <= self.component() {
            system.components.push(Component {
                name: format!("c{copy}"),
                tasks: Vec::new(),
                services: Vec::new(),
            });
        }
        let component = &mut system.components[self.component()];
        component.tasks.extend((0..one.tasks.len()).map(task));
        component
            .services
            .extend((0..one.services.len()).map(service));
        system.tasks.extend(one.tasks.iter().map(|it| Task {
            component: self.component(),
            permanent: it.permanent.map(automaton),
            slots: all(&it.slots, &automaton),
            ..it.clone()
        }));
        system.machines.extend(one.machines.iter().map(|it| {
            Machine {
                states: (it.states.iter())
                    .map(|it| State {
                        codel: codel(it.codel),
                        ..it.clone()
                    })
                    .collect(),
                ..it.clone()
            }
        }));
        system
            .automata
            .extend(one.automata.iter().map(|it| Automaton {
                task: task(it.task),
                machine: machine(it.machine),
                service: it.service.map(service),
            }));
        system.codels.extend(one.codels.iter().map(|it| Codel {
            component: self.component(),
            conflicts: CodelSet::default(),
            ..it.clone()
        }));
        system
            .services
            .extend(one.services.iter().map(|it| Service {
                component: self.component(),
                validate: it.validate.map(codel),
                simple: all(&it.simple, &codel),
                slots: all(&it.slots, &automaton),
                ..it.clone()
            }));
        system.clients.extend(one.clients.iter().map(|it| {
            Client {
                steps: (it.steps.iter())
                    .map(|it| ClientStep {
                        action: match it.action.clone() {
                            ClientAction::Send {
                                service: it,
                                trackers,
                                accepted,
                                aborts,
                            } => ClientAction::Send {
                                service: service(it),
                                trackers,
                                accepted,
                                aborts,
                            },
                            other => other,
                        },
                        ..it.clone()
                    })
                    .collect(),
                ..it.clone()
            }
        }));
    }
}

fn renamed(it: &Predicate, one: &TimedSystem, copy: usize) -> Predicate {
    let atom = |it: &Atom| match it.clone() {
        Atom::Task(task, state) => Atom::Task(copy * one.tasks.len() + task, state),
        Atom::State {
            machine,
            state,
            phase,
        } => Atom::State {
            machine: copy * one.machines.len() + machine,
            state,
            phase,
        },
        other => other,
    };
    let other = |it: &Predicate| Box::new(renamed(it, one, copy));
    match it {
        Predicate::Atom(it) => Predicate::Atom(atom(it)),
        Predicate::Leave(it) => Predicate::Leave(atom(it)),
        Predicate::Not(it) => Predicate::Not(other(it)),
        Predicate::And(a, b) => Predicate::And(other(a), other(b)),
        Predicate::Or(a, b) => Predicate::Or(other(a), other(b)),
    }
}
