//! The system that runs with real codels: the same rules, with room for what real codels do.

use dotgen_timing::system::{Client, ClientAction, ClientStep, FOREVER, Ticks, TimedSystem};
use dotgen_timing::verify::{Prepared, Question};
use num_rational::Ratio;

/// Nanoseconds of the unit in which a run on the real clock is counted, where times are not too long for it.
const UNIT: i128 = 1_000;

/// Any codel that is executed may throw: what it yields and must not ends its activity as an exception does.
/// There is no limit on how often a state is entered in a turn.
pub fn open(prepared: &mut Prepared, is_real: &dyn Fn(usize) -> bool) {
    let system = &mut prepared.built.system;
    for (at, codel) in system.codels.iter_mut().enumerate() {
        codel.throws |= is_real(at);
    }
    for machine in &mut system.machines {
        machine.loop_limit = None;
        machine.rounds = false;
    }
}

/// For the real clock: times in units of a microsecond or finer, as far as they stay small enough; how many
/// of the new units an old one has.
pub fn scale(prepared: &mut Prepared) -> Ticks {
    let system = &mut prepared.built.system;
    let nanos = (system.unit * Ratio::from_integer(1_000_000_000)).ceil();
    let wanted = (nanos.to_integer() + UNIT - 1) / UNIT;
    let greatest = times(system).into_iter().filter(|it| **it != FOREVER);
    let greatest = greatest.map(|it| *it).max().unwrap_or(0).max(1);
    // Leave room for sums.
    let most = FOREVER / 64 / greatest;
    let factor = Ticks::try_from(wanted).unwrap_or(most).min(most).max(1);
    for it in times(system) {
        if *it != FOREVER {
            *it *= factor;
        }
    }
    system.unit /= Ratio::from_integer(i128::from(factor));
    for it in &mut prepared.checks {
        if let Question::Response(_, Some(limit)) | Question::Within(_, _, Some(limit)) =
            &mut it.question
        {
            *limit = limit.saturating_mul(factor);
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

/// Real codels take what they take.
pub fn release(prepared: &mut Prepared, is_real: &dyn Fn(usize) -> bool) {
    for (at, codel) in prepared.built.system.codels.iter_mut().enumerate() {
        if is_real(at) {
            codel.lower = 0;
            codel.upper = FOREVER;
        }
    }
}

/// One client more for each component, which may send any of its requests at any time: it stands for whoever
/// is outside. Returns the first of them.
pub fn add_outside(prepared: &mut Prepared) -> usize {
    let system = &mut prepared.built.system;
    let first = system.clients.len();
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
            // Nothing can be asked of it: its client is done before it begins.
            steps.clear();
        }
        system.clients.push(Client {
            name: format!("outside of {}", component.name),
            first: vec![0],
            steps,
            trackers: 0,
        });
    }
    first
}
