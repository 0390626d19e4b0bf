//! The proof that a predicate holds in no state: each of its cases contradicts an invariant.

use std::collections::HashMap;

use crate::certificate::{Predicate, State};
use crate::system::{Tables, Work};

/// The work for a literal of a case, which takes memory.
const JOIN: usize = 16;

/// An atom, and whether it holds.
type Literal<'c> = (&'c str, bool);

/// Checks that a predicate holds in no state.
///
/// # Errors
/// The proof needs too much work, an atom is unknown, or a case contradicts no invariant.
pub(crate) fn never_holds(
    tables: &Tables,
    predicate: &Predicate,
    work: &mut Work,
) -> Result<(), String> {
    for case in cases(predicate, true, work)? {
        if !contradicts(tables, &case, work)? {
            let word = |(atom, holds)| format!("`{atom}` {holds}");
            let case: Vec<String> = case.into_iter().map(word).collect();
            return Err(format!("no invariant excludes {}", case.join(", ")));
        }
    }
    Ok(())
}

/// Returns the cases in which a predicate has a value: conjunctions of literals.
fn cases<'c>(
    predicate: &'c Predicate,
    value: bool,
    work: &mut Work,
) -> Result<Vec<Vec<Literal<'c>>>, String> {
    let (list, joined) = match predicate {
        Predicate::Atom(atom) => return Ok(vec![vec![(atom, value)]]),
        // The atom does not hold any more. Nothing follows if no atom is left.
        Predicate::Leave(atom) if value => return Ok(vec![vec![(atom, false)]]),
        Predicate::Leave(_) => return Ok(vec![Vec::new()]),
        Predicate::Not(negated) => return cases(negated, !value, work),
        Predicate::And(list) => (list, value),
        Predicate::Or(list) => (list, !value),
    };
    let mut out = vec![Vec::new(); usize::from(joined)];
    for operand in list {
        let more = cases(operand, value, work)?;
        if !joined {
            out.extend(more);
            continue;
        }
        let mut pairs = Vec::new();
        for one in &out {
            for other in &more {
                work.spend(JOIN * (1 + one.len() + other.len()))?;
                pairs.push([&one[..], other].concat());
            }
        }
        out = pairs;
    }
    Ok(out)
}

/// Returns true if no state of the system is in a case.
fn contradicts(tables: &Tables, case: &[Literal], work: &mut Work) -> Result<bool, String> {
    // By part, the local states that the literals leave.
    let mut left: HashMap<&str, Vec<&State>> = HashMap::new();
    for &(name, holds) in case {
        let atom = tables.atoms.get(name);
        let atom = atom.ok_or_else(|| format!("the atom `{name}` is not declared"))?;
        // Any one of several parts may make an atom true.
        let tells = if holds { atom.parts.len() == 1 } else { atom.exact };
        for (part, states) in atom.parts.iter().filter(|_| tells) {
            let all = || tables.parts[&**part].states.iter().collect();
            let own = left.entry(part).or_insert_with(all);
            let whole = tables.parts[&**part].states.len();
            work.spend(whole + own.len().saturating_mul(1 + states.len()))?;
            own.retain(|state| states.contains(&state.name) == holds);
        }
    }
    let left: Vec<Vec<&State>> = left.into_values().collect();
    let pairs = left.iter().map(Vec::len).sum::<usize>().saturating_mul(left.len());
    work.spend(pairs)?;
    if left.iter().any(Vec::is_empty) || are_too_many(tables, &left) || without_slot(&left) {
        return Ok(true);
    }
    let executes = |states: &&Vec<&State>| states.iter().all(|state| state.executes.is_some());
    let busy: Vec<&Vec<&State>> = left.iter().filter(executes).collect();
    for (at, one) in busy.iter().enumerate() {
        for other in &busy[at + 1..] {
            if exclude(tables, one, other, work)? {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

/// Returns true if each state of one part excludes each state of another one.
fn exclude(
    tables: &Tables,
    one: &[&State],
    other: &[&State],
    work: &mut Work,
) -> Result<bool, String> {
    for one in one {
        for other in other {
            if !tables.exclude(one, other, work)? {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// Returns true if more parts have a core than there are cores.
fn are_too_many(tables: &Tables, left: &[Vec<&State>]) -> bool {
    let with_core = left.iter().filter(|states| states.iter().all(|state| state.core));
    tables.cores.is_some_and(|cores| with_core.count() > cores)
}

/// Returns true if a part has a codel of a service without any activity.
fn without_slot(left: &[Vec<&State>]) -> bool {
    let void = |service: &String| {
        (left.iter()).any(|states| states.iter().all(|state| state.void.as_ref() == Some(service)))
    };
    let of_void = |state: &&State| state.service.as_ref().is_some_and(void);
    left.iter().any(|states| states.iter().all(of_void))
}
