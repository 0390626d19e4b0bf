//! Mutations of certificates.

use serde_json::{Value, json};

use crate::agreement::systems::Dice;

/// The kinds of mutations.
pub(super) const KINDS: [&str; 10] = [
    "a step leads out of the local states",
    "a local state is removed",
    "a lock is dropped",
    "a lock is made shared",
    "a core is added",
    "the value of an atom is flipped",
    "the predicate is changed",
    "an attribute of a local state is dropped",
    "a part is removed",
    "the initial state is removed",
];

/// Mutates a certificate of one system. Returns false if it has nothing to be mutated like this.
pub(super) fn mutate(certificate: &mut Value, kind: usize, dice: &mut Dice) -> bool {
    let system = &mut certificate["scenarios"][0]["systems"][0];
    let mutated = match kind {
        0 => any(&mut system["parts"], dice).and_then(|part| {
            let from = part["initial"][0].clone();
            let step = json!({ "from": from, "to": "elsewhere", "what": "leaves" });
            part["steps"].as_array_mut()?.push(step);
            Some(())
        }),
        1 => any(&mut system["parts"], dice).and_then(|part| remove(&mut part["states"], dice)),
        2 => {
            let access = dice.pick(&["exclusive", "shared"]);
            locks(system, dice, access).map(drop)
        }
        3 => make_shared(system, dice),
        4 => system.get_mut("cores").map(|cores| {
            *cores = json!(cores.as_u64().unwrap_or_default() + 1);
        }),
        5 => flip(system, dice),
        6 => change(&mut system["checks"][0]["never"], dice),
        7 => drop_attribute(system, dice),
        8 => remove(&mut system["parts"], dice),
        _ => any(&mut system["parts"], dice).map(|part| part["initial"] = json!([])),
    };
    mutated.is_some()
}

fn any<'v>(list: &'v mut Value, dice: &mut Dice) -> Option<&'v mut Value> {
    let list = list.as_array_mut()?;
    let length = u32::try_from(list.len()).ok().filter(|&length| length > 0)?;
    list.get_mut(dice.below(length) as usize)
}

fn remove(list: &mut Value, dice: &mut Dice) -> Option<()> {
    let list = list.as_array_mut().filter(|list| !list.is_empty())?;
    list.remove(dice.below(list.len() as u32) as usize);
    Some(())
}

/// Removes a lock with an access from a codel. Returns the codel and the lock.
fn locks<'v>(
    system: &'v mut Value,
    dice: &mut Dice,
    access: &str,
) -> Option<(&'v mut Value, Value)> {
    let codels = system["codels"].as_array_mut()?;
    let has = |codel: &&mut Value| codel[access].as_array().is_some_and(|all| !all.is_empty());
    let mut with: Vec<&mut Value> = codels.iter_mut().filter(has).collect();
    if with.is_empty() {
        return None;
    }
    let codel = with.swap_remove(dice.below(with.len() as u32) as usize);
    let list = codel[access].as_array_mut()?;
    let lock = list.remove(dice.below(list.len() as u32) as usize);
    Some((codel, lock))
}

fn make_shared(system: &mut Value, dice: &mut Dice) -> Option<()> {
    let (codel, lock) = locks(system, dice, "exclusive")?;
    codel["shared"].as_array_mut()?.push(lock);
    Some(())
}

/// Adds a local state to those in which an atom may hold, or removes one.
fn flip(system: &mut Value, dice: &mut Dice) -> Option<()> {
    let parts = system["parts"].clone();
    let atom = any(&mut system["atoms"], dice)?;
    let (name, states) = atom["parts"].as_object_mut()?.iter_mut().next()?;
    let part = parts.as_array()?.iter().find(|part| part["name"] == **name)?;
    let all = part["states"].as_array()?;
    let state = &all[dice.below(all.len() as u32) as usize]["name"];
    let states = states.as_array_mut()?;
    match states.iter().position(|known| known == state) {
        Some(at) => drop(states.remove(at)),
        None => states.push(state.clone()),
    }
    Some(())
}

/// Changes a predicate at its root.
fn change(never: &mut Value, dice: &mut Dice) -> Option<()> {
    let old = never.take();
    let (operator, list) = old.as_object()?.iter().next()?;
    let operands = list.as_array().filter(|list| !list.is_empty());
    *never = match (dice.below(4), operands) {
        (0, Some(_)) if operator == "and" => json!({ "or": list }),
        (1, Some(operands)) => operands[0].clone(),
        (2, Some(operands)) => {
            let mut operands = operands.clone();
            operands[0] = json!({ "not": operands[0] });
            json!({ operator: operands })
        }
        _ => json!({ "not": old }),
    };
    Some(())
}

fn drop_attribute(system: &mut Value, dice: &mut Dice) -> Option<()> {
    let part = any(&mut system["parts"], dice)?;
    let attribute = dice.pick(&["executes", "core", "service", "void"]);
    for state in part["states"].as_array_mut()? {
        state.as_object_mut()?.remove(attribute);
    }
    Some(())
}
