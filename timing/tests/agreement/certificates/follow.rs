//! Random runs, whose parts are followed along the steps of a certificate.

use std::collections::{BTreeMap, BTreeSet};

use dotgen_timing::explore::{Possible, Seen, Stepper, Watched};
use dotgen_timing::property::{Atom, Predicate, SlotStatus, StatePhase, TaskState};
use dotgen_timing::system::TimedSystem;
use serde_json::Value;

use crate::agreement::systems::Dice;

/// The greatest number of actions in a run.
const ACTIONS: usize = 300;

/// The greatest number of steps of a part for one action.
const AT_ONCE: usize = 3;

/// Returns the atoms that tell the local states of a system.
pub(super) fn atoms(system: &TimedSystem) -> Vec<Predicate> {
    let mut out = Vec::new();
    for task in system.tasks.keys() {
        let states = [TaskState::Idle, TaskState::Waiting, TaskState::Running];
        out.extend(states.map(|state| Atom::Task(task, state)));
    }
    let phases = [StatePhase::Lock, StatePhase::Exec];
    for (machine, it) in system.machines.iter_enumerated() {
        for state in 0..it.states.len() {
            out.extend(phases.map(|phase| Atom::State { machine, state, phase }));
        }
    }
    for (service, it) in system.services.iter_enumerated() {
        out.push(Atom::Slot(service, SlotStatus::Void));
        for codel in it.validate.iter().chain(&it.simple).copied().map(Some) {
            out.extend(phases.map(|phase| Atom::Handling { service, codel, phase }));
        }
    }
    out.extend(system.components.keys().map(Atom::ControlBusy));
    for (client, it) in system.clients.iter_enumerated() {
        out.extend((0..=it.done() + 1).map(|step| Atom::Client(client, vec![step])));
    }
    out.into_iter().map(Predicate::Atom).collect()
}

/// A part, and the local states in which it may be.
struct Followed<'c> {
    part: &'c Value,
    next: BTreeMap<&'c str, Vec<&'c str>>,
    now: BTreeSet<&'c str>,
}

/// Follows the parts along a random run.
pub(super) fn run(
    system: &TimedSystem,
    atoms: &[Predicate],
    certificate: &Value,
    dice: &mut Dice,
) -> Result<(), String> {
    let of = &certificate["scenarios"][0]["systems"][0];
    let mut followed: Vec<Followed> = list(&of["parts"]).map(Followed::new).collect();
    let negated = |atom: &Predicate| Predicate::Not(Box::new(atom.clone()));
    let watched = Watched {
        reach: atoms.iter().flat_map(|atom| [atom.clone(), negated(atom)]).collect(),
        ..Watched::default()
    };
    let mut values = vec![None; atoms.len()];
    let mut stepper = Stepper::new(system, &watched);
    let mut fresh = Vec::new();
    stepper.begin(&mut fresh);
    let mut possible = Possible::default();
    for _ in 0..ACTIONS {
        for seen in fresh.drain(..) {
            match seen {
                Seen::Reached { predicate } => values[predicate / 2] = Some(predicate % 2 == 0),
                Seen::Begun { executor, time: (least, greatest), .. } => {
                    let more = dice.below(greatest.min(least + 20) - least + 1);
                    stepper.decide(executor, least + more);
                }
                _ => {}
            }
        }
        for part in &mut followed {
            part.proceed(list(&of["atoms"]).zip(&values))?;
        }
        stepper.possible(&mut possible);
        let actions = possible.actions();
        if possible.may_wait() && (actions.is_empty() || dice.in_ten(7)) {
            let Some(jump) = stepper.next_moment() else {
                break;
            };
            stepper.pass(jump, &mut fresh);
        } else if actions.is_empty() {
            break;
        } else {
            stepper.perform(dice.pick(actions), &mut fresh);
        }
    }
    Ok(())
}

impl<'c> Followed<'c> {
    fn new(part: &'c Value) -> Self {
        let mut next: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for step in list(&part["steps"]) {
            next.entry(text(&step["from"])).or_default().push(text(&step["to"]));
        }
        let now = list(&part["initial"]).map(text).collect();
        Followed { part, next, now }
    }

    /// Goes on by the steps of one action to the local states that agree with the values of atoms.
    fn proceed<'v>(
        &mut self,
        atoms: impl Iterator<Item = (&'v Value, &'v Option<bool>)>,
    ) -> Result<(), String> {
        let mut agree: BTreeSet<&str> =
            list(&self.part["states"]).map(|state| text(&state["name"])).collect();
        let mut told = Vec::new();
        for (atom, value) in atoms {
            let value = value.ok_or_else(|| format!("{} has no value", atom["name"]))?;
            let parts = atom["parts"].as_object().expect("parts are an object");
            let Some(states) = parts.get(text(&self.part["name"])) else {
                continue;
            };
            if parts.len() == 1 || !value {
                agree.retain(|name| list(states).any(|state| state == *name) == value);
            }
            if value {
                told.push(&atom["name"]);
            }
        }
        let before = self.now.clone();
        for _ in 0..AT_ONCE {
            let next = self.now.iter().filter_map(|state| self.next.get(state));
            let next: Vec<&str> = next.flatten().copied().collect();
            self.now.extend(next);
        }
        self.now.retain(|state| agree.contains(state));
        if self.now.is_empty() {
            Err(format!("{}: from {before:?} to {told:?}", self.part["name"]))
        } else {
            Ok(())
        }
    }
}

fn list(of: &Value) -> impl Iterator<Item = &Value> {
    of.as_array().into_iter().flatten()
}

fn text(of: &Value) -> &str {
    of.as_str().unwrap_or_default()
}
