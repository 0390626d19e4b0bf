//! The adaptation of a system to real codels: the rules are the same, but real codels may do more.

use dotgen_timing::property::Monitor;
use dotgen_timing::system::{
    Client, ClientAction, ClientId, ClientStep, CodelId, FOREVER, Ticks, TimedSystem,
};
use dotgen_timing::verify::{Prepared, Question};
use num_rational::Ratio;

/// Nanoseconds per unit on the real clock, unless times are too long for it.
const UNIT: i128 = 1_000;

/// Lets every real codel throw: an undeclared yield ends its activity like an exception. Removes the limit on
/// entries of a state in a turn.
pub fn open(prepared: &mut Prepared, is_real: &dyn Fn(CodelId) -> bool) {
    let system = &mut prepared.built.system;
    for (at, codel) in system.codels.iter_mut_enumerated() {
        codel.throws |= is_real(at);
    }
    for machine in &mut system.machines {
        machine.loop_limit = None;
        machine.rounds = false;
    }
}

/// Changes the unit for the real clock to a microsecond or less, as far as times stay small enough. Returns
/// the number of new units per old unit.
pub fn scale(prepared: &mut Prepared) -> Ticks {
    let system = &mut prepared.built.system;
    let nanos = (system.unit * Ratio::from_integer(1_000_000_000)).ceil();
    let wanted = (nanos.to_integer() + UNIT - 1) / UNIT;
    let greatest = times(system).into_iter().filter(|time| **time != FOREVER);
    let greatest = greatest.map(|time| *time).max().unwrap_or(0).max(1);
    // The limit leaves room for sums.
    let most = FOREVER / 64 / greatest;
    let factor = Ticks::try_from(wanted).unwrap_or(most).min(most).max(1);
    for time in times(system) {
        if *time != FOREVER {
            *time *= factor;
        }
    }
    system.unit /= Ratio::from_integer(i128::from(factor));
    for check in &mut prepared.checks {
        match &mut check.question {
            Question::Response(_, Some(time))
            | Question::Within(_, _, Some(time))
            | Question::Pattern(Monitor { time, .. }) => *time = time.saturating_mul(factor),
            _ => {}
        }
    }
    factor
}

fn times(system: &mut TimedSystem) -> Vec<&mut Ticks> {
    let mut out = Vec::new();
    for task in &mut system.tasks {
        out.extend(task.period.as_mut());
        out.push(&mut task.delay);
    }
    for codel in &mut system.codels {
        out.push(&mut codel.lower);
        out.push(&mut codel.upper);
    }
    for client in &mut system.clients {
        for step in &mut client.steps {
            if let ClientAction::Delay(least, greatest) = &mut step.action {
                out.push(least);
                out.push(greatest);
            }
        }
    }
    out
}

/// Removes the limits on the execution times of real codels.
pub fn release(prepared: &mut Prepared, is_real: &dyn Fn(CodelId) -> bool) {
    for (at, codel) in prepared.built.system.codels.iter_mut_enumerated() {
        if is_real(at) {
            codel.lower = 0;
            codel.upper = FOREVER;
        }
    }
}

/// Adds a client for each component that may send any of its requests at any time. These clients stand for
/// requests from outside. Activities that no client of the scenario requests get slots. Returns the index of
/// the first of these clients.
pub fn add_outside(prepared: &mut Prepared) -> ClientId {
    prepared.built.add_slots();
    let system = &mut prepared.built.system;
    let first = system.clients.next_key();
    for component in &system.components {
        let sends = component.services.iter().map(|&service| ClientStep {
            action: ClientAction::Send {
                service,
                trackers: Vec::new(),
                accepted: Vec::new(),
                aborts: None,
            },
            next: vec![0],
            label: None,
        });
        let wait = ClientStep {
            action: ClientAction::Delay(0, FOREVER),
            next: (1..=component.services.len()).collect(),
            label: None,
        };
        let mut steps: Vec<ClientStep> = std::iter::once(wait).chain(sends).collect();
        if component.services.is_empty() {
            // The component accepts no request: its client ends before it begins.
            steps.clear();
        }
        system.clients.push(Client {
            name: format!("outside of {}", component.name),
            first: vec![0],
            steps,
            trackers: 0,
            awaits_event: None,
        });
    }
    first
}
