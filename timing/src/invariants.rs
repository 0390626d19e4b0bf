//! Proofs by invariants: predicates that hold in no state, without an exploration.
//!
//! *Component invariants.* Each part of a system (a thread, a control task, a client, the slots of a service)
//! is always in one of the local states that its own rules can reach, see [`parts`]. *Interaction invariants*
//! say which local states occur together: two codels that exclude each other are not executed at the same
//! time; no more tasks execute codels than there are cores; an activity that executes a codel has a slot. A
//! predicate never holds if each case of it, as a conjunction of atoms and negated atoms, leaves some part
//! without a local state or contradicts an interaction invariant.
//!
//! This is the compositional method of S. Bensalem, M. Bozga, J. Sifakis, T.-H. Nguyen, *D-Finder: a tool for
//! compositional deadlock detection and verification*, CAV 2009, without clocks. It does not depend on
//! durations. It is not complete: if it fails, the predicate may hold or not.

pub mod certificate;
mod parts;

use self::parts::{Local, Part, Parts};
use crate::property::{Atom, Predicate};
use crate::system::{ServiceId, TimedSystem};

/// Upper limit on the cases of a predicate.
const CASES: usize = 4096;

/// An atom, and whether it holds.
type Literal<'p> = (&'p Atom, bool);

/// Returns true if a predicate is proved to hold in no state of a system.
pub fn never_holds(system: &TimedSystem, predicate: &Predicate) -> bool {
    let Some(cases) = cases(predicate, true) else {
        return false;
    };
    let parts = Parts::of(system);
    // The parts of each literal are looked up once: a predicate has many cases, but few literals.
    let mut about: Vec<(Literal, Vec<&Part>)> = Vec::new();
    for &(atom, holds) in cases.iter().flatten() {
        if about.iter().all(|(known, _)| *known != (atom, holds)) {
            about.push(((atom, holds), parts.about(atom, holds)));
        }
    }
    cases.iter().all(|case| contradicts(&parts, &about, case))
}

/// Returns the cases in which a predicate has a value; `None` if there are too many.
fn cases(predicate: &Predicate, value: bool) -> Option<Vec<Vec<Literal<'_>>>> {
    let out = match predicate {
        Predicate::Atom(atom) => vec![vec![(atom, value)]],
        // The atom does not hold any more. If no atom is left, nothing follows.
        Predicate::Leave(atom) if value => vec![vec![(atom, false)]],
        Predicate::Leave(_) => vec![Vec::new()],
        Predicate::Not(negated) => cases(negated, !value)?,
        Predicate::And(one, other) | Predicate::Or(one, other) => {
            let (one, other) = (cases(one, value)?, cases(other, value)?);
            if matches!(predicate, Predicate::And(..)) == value {
                let pairs = one.len().checked_mul(other.len())?;
                if pairs > CASES {
                    return None;
                }
                let mut joined = Vec::with_capacity(pairs);
                for one in &one {
                    let with = |other: &Vec<_>| one.iter().chain(other).copied().collect();
                    joined.extend(other.iter().map(with));
                }
                joined
            } else {
                one.into_iter().chain(other).collect()
            }
        }
    };
    (out.len() <= CASES).then_some(out)
}

/// Returns true if no state of the system is in a case.
fn contradicts(parts: &Parts, about: &[(Literal, Vec<&Part>)], case: &[Literal]) -> bool {
    let mut present: Vec<(&Part, Vec<&Local>)> = Vec::new();
    for &(atom, holds) in case {
        let known = about.iter().find(|(known, _)| *known == (atom, holds));
        for &part in known.map_or(&[][..], |(_, parts)| parts) {
            let at = present.iter().position(|(other, _)| std::ptr::eq(*other, part));
            let at = at.unwrap_or_else(|| {
                present.push((part, part.locals.iter().collect()));
                present.len() - 1
            });
            present[at].1.retain(|local| parts.value(local, atom) == holds);
        }
    }
    if present.iter().any(|(_, locals)| locals.is_empty()) {
        return true;
    }
    let busy: Vec<&Vec<&Local>> = (present.iter())
        .map(|(_, locals)| locals)
        .filter(|locals| locals.iter().all(|local| local.executes()))
        .collect();
    let exclusive = |one: &[&Local], other: &[&Local]| {
        (one.iter()).all(|one| other.iter().all(|other| parts.exclude(one, other)))
    };
    let locked = (busy.iter().enumerate())
        .any(|(at, one)| busy[at + 1..].iter().any(|other| exclusive(one, other)));
    locked || parts.are_too_many(&present) || without_slot(parts, &present)
}

/// Returns true if a thread executes a codel of a service without any activity.
fn without_slot(parts: &Parts, present: &[(&Part, Vec<&Local>)]) -> bool {
    let void = |service: ServiceId| {
        (present.iter()).any(|(_, locals)| locals.iter().all(|local| local.is_void(service)))
    };
    present
        .iter()
        .any(|(_, locals)| (locals.iter()).all(|local| parts.service(local).is_some_and(void)))
}
