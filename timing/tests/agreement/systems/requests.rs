//! Random systems with a default client: any request at any time.

use dotgen_timing::system::{
    Client, ClientAction, ClientStep, Component, ComponentId, FOREVER, Policy, Task, TaskId,
    TimedSystem,
};

use super::{Dice, automaton, empty, machine, service};

/// Returns one or two components with one or two tasks altogether, one to three services, and one or two
/// clients that let any time pass before each request. Least durations are mostly 0.
pub(crate) fn requests(dice: &mut Dice) -> TimedSystem {
    let mut system = empty(dice);
    system.platform.policy = dice.pick(&[Policy::Fifo, Policy::Edf, Policy::Any]);
    system.platform.async_free = dice.in_ten(2);
    let tasks = 1 + dice.below(2) as usize;
    for t in 0..tasks {
        if t == 0 || dice.in_ten(4) {
            system.components.push(Component {
                name: format!("c{t}"),
                tasks: Vec::new(),
                services: Vec::new(),
            });
        }
        let number = system.components.len() - 1;
        let component = ComponentId::from(number);
        system.components[component].tasks.push(TaskId::from(t));
        let permanent = dice.in_ten(7).then(|| {
            let machine = machine(&mut system, dice, component, format!("c{number}.t{t}"));
            automaton(&mut system, t, machine, None)
        });
        system.tasks.push(Task {
            places: 16,
            priority: None,
            affinity: None,
            name: format!("t{t}"),
            component,
            period: dice.in_ten(8).then(|| 2 + dice.below(4)),
            delay: 0,
            keep_idle_tick: dice.in_ten(1),
            permanent,
            slots: Vec::new(),
            src: None,
        });
    }
    let services = 1 + dice.below(3) as usize;
    for v in 0..services {
        service(&mut system, dice, v);
    }
    for v in system.services.keys() {
        for other in system.services.keys() {
            if system.services[v].component == system.services[other].component && dice.in_ten(3) {
                system.services[v].interrupts.push(other);
            }
        }
    }
    let from_zero = dice.in_ten(8);
    for codel in &mut system.codels {
        codel.upper = codel.upper.min(2);
        codel.lower = if from_zero { 0 } else { codel.lower.min(codel.upper) };
    }
    for one in 0..system.codels.len() {
        for other in 0..one {
            if dice.in_ten(2) {
                system.exclude(one.into(), other.into());
            }
        }
    }
    for k in 0..=(dice.below(4) / 3) {
        let client = any(&system, dice, k);
        system.clients.push(client);
    }
    system
}

/// Returns a client that lets time pass, sends one of some requests, and possibly waits for its end, for ever
/// or a few times.
fn any(system: &TimedSystem, dice: &mut Dice, k: u32) -> Client {
    let services = system.services.len();
    let upper = if dice.in_ten(8) { FOREVER } else { 2 };
    let delay = ClientStep {
        action: ClientAction::Delay(0, upper),
        next: (1..=services).collect(),
        label: None,
    };
    let waits = dice.in_ten(3);
    // One round, or for ever.
    let back = if dice.in_ten(6) { 0 } else { services + 2 };
    let send = |service: usize| ClientStep {
        action: ClientAction::Send {
            service: service.into(),
            trackers: vec![0],
            accepted: Vec::new(),
            aborts: None,
        },
        next: vec![if waits { services + 1 } else { back }],
        label: None,
    };
    let wait = ClientStep { action: ClientAction::AwaitEnded(0), next: vec![back], label: None };
    Client {
        awaits_event: None,
        name: format!("k{k}"),
        steps: std::iter::once(delay)
            .chain((0..services).map(send))
            .chain(std::iter::once(wait))
            .collect(),
        first: vec![0],
        trackers: 1,
    }
}
