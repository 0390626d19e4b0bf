//! An enumeration of the states that a certificate permits.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

/// The greatest number of states.
const MOST: usize = 100_000;

/// Returns true if a certificate with one claim is inconsistent, or permits a state in which the predicate
/// holds. `None`: there are too many states.
pub(super) fn is_possible(certificate: &Value) -> Option<bool> {
    let system = &certificate["scenarios"][0]["systems"][0];
    let parts: BTreeMap<&str, &Value> =
        (list(&system["parts"])).map(|part| (text(&part["name"]), part)).collect();
    if parts.values().any(|part| !is_closed(part)) {
        return Some(true);
    }
    let never = &system["checks"][0]["never"];
    let mut leaves = Vec::new();
    find_leaves(never, &mut leaves);
    let atoms: BTreeMap<&str, &Value> =
        (list(&system["atoms"])).map(|atom| (text(&atom["name"]), atom)).collect();
    let mut within = BTreeSet::new();
    for atom in atoms.values() {
        for (part, states) in atom["parts"].as_object()? {
            let Some(of) = parts.get(&**part) else {
                return Some(true);
            };
            let known = |name: &Value| list(&of["states"]).any(|state| state["name"] == *name);
            if !list(states).all(known) {
                return Some(true);
            }
        }
    }
    for (_, atom) in &leaves {
        within.extend(atoms[*atom]["parts"].as_object()?.keys().map(|part| &**part));
    }
    let within: Vec<&str> = within.into_iter().collect();
    let sizes = within.iter().map(|part| list(&parts[part]["states"]).count());
    let total = sizes.clone().try_fold(1_usize, usize::checked_mul)?;
    if total > MOST {
        return None;
    }
    let sizes: Vec<usize> = sizes.collect();
    Some((0..total).any(|mut number| {
        let states: BTreeMap<&str, &Value> = (within.iter().zip(&sizes))
            .map(|(part, size)| {
                let at = number % size;
                number /= size;
                (*part, &parts[part]["states"][at])
            })
            .collect();
        is_permitted(system, &states) && may_hold(never, &leaves, &atoms, &states)
    }))
}

fn list(of: &Value) -> impl Iterator<Item = &Value> {
    of.as_array().into_iter().flatten()
}

fn text(of: &Value) -> &str {
    of.as_str().unwrap_or_default()
}

fn is_closed(part: &Value) -> bool {
    let known = |name: &Value| list(&part["states"]).any(|state| state["name"] == *name);
    list(&part["initial"]).next().is_some()
        && list(&part["initial"]).all(known)
        && list(&part["steps"]).all(|step| known(&step["from"]) && known(&step["to"]))
}

/// Collects the atoms of a predicate, each with `atom` or `leave`.
fn find_leaves<'v>(predicate: &'v Value, out: &mut Vec<(&'v str, &'v str)>) {
    let Some((operator, operand)) = predicate.as_object().and_then(|of| of.iter().next()) else {
        return;
    };
    match &**operator {
        "atom" | "leave" if !out.contains(&(operator, text(operand))) => {
            out.push((operator, text(operand)));
        }
        "not" => find_leaves(operand, out),
        _ => list(operand).for_each(|operand| find_leaves(operand, out)),
    }
}

fn is_permitted(system: &Value, states: &BTreeMap<&str, &Value>) -> bool {
    let cores = system["cores"].as_u64().unwrap_or(u64::MAX);
    let on_core = states.values().filter(|state| state["core"] == true).count();
    let without_slot = states.values().any(|state| {
        let service = &state["service"];
        !service.is_null() && states.values().any(|other| other["void"] == *service)
    });
    let executed: Vec<&Value> = (states.values())
        .map(|state| &state["executes"])
        .filter(|codel| !codel.is_null())
        .filter_map(|codel| list(&system["codels"]).find(|known| known["name"] == *codel))
        .collect();
    let holds =
        |codel: &Value, access: &str, lock: &Value| list(&codel[access]).any(|of| of == lock);
    let collide = |one: &Value, other: &Value| {
        if one["name"] == other["name"] {
            return one["alone"] == true;
        }
        list(&one["exclusive"])
            .any(|lock| holds(other, "shared", lock) || holds(other, "exclusive", lock))
            || list(&other["exclusive"]).any(|lock| holds(one, "shared", lock))
    };
    let pairs = executed.iter().enumerate();
    let mut pairs =
        pairs.flat_map(|(at, one)| executed[at + 1..].iter().map(move |two| (one, two)));
    on_core as u64 <= cores && !without_slot && !pairs.any(|(one, other)| collide(one, other))
}

/// Returns true if a predicate may hold in a state: the states of parts leave the values of some atoms open.
fn may_hold(
    predicate: &Value,
    leaves: &[(&str, &str)],
    atoms: &BTreeMap<&str, &Value>,
    states: &BTreeMap<&str, &Value>,
) -> bool {
    (0..1_u32 << leaves.len()).any(|values| {
        let value = |kind: &str, atom: &str| {
            let at = leaves.iter().position(|leaf| *leaf == (kind, atom));
            at.is_some_and(|at| values >> at & 1 == 1)
        };
        let consistent = leaves.iter().all(|&(kind, name)| {
            let parts = atoms[name]["parts"].as_object().into_iter().flatten();
            let inside = |(part, named): (&String, &Value)| {
                states
                    .get(&**part)
                    .is_some_and(|state| list(named).any(|name| state["name"] == *name))
            };
            let may = parts.clone().count() == 0 || parts.clone().any(inside);
            let must = atoms[name]["exact"] == true && parts.clone().any(inside);
            match kind {
                "leave" => !value(kind, name) || !must,
                _ => may && (!must || value(kind, name)) || !may && !value(kind, name),
            }
        });
        consistent && eval(predicate, &value)
    })
}

fn eval(predicate: &Value, value: &dyn Fn(&str, &str) -> bool) -> bool {
    let Some((operator, operand)) = predicate.as_object().and_then(|of| of.iter().next()) else {
        return false;
    };
    match &**operator {
        "not" => !eval(operand, value),
        "and" => list(operand).all(|operand| eval(operand, value)),
        "or" => list(operand).any(|operand| eval(operand, value)),
        _ => value(operator, text(operand)),
    }
}
