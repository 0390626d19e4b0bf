//! The tables of a system, by name, after checks of the parts.

use std::collections::{HashMap, HashSet};

use crate::certificate::{Atom, Part, State, System};

/// The greatest number of literals, states, locks and pairs of states for a certificate.
const MOST_WORK: usize = 1 << 28;

/// The work for a certificate so far.
#[derive(Default)]
pub(crate) struct Work(usize);

impl Work {
    /// Counts more work.
    ///
    /// # Errors
    /// The certificate needs too much work.
    pub(crate) fn spend(&mut self, more: usize) -> Result<(), String> {
        self.0 = self.0.saturating_add(more);
        let error = || format!("the certificate needs more than {MOST_WORK} steps");
        (self.0 <= MOST_WORK).then_some(()).ok_or_else(error)
    }
}

/// The locks of a codel.
#[derive(Default)]
struct Locks<'c> {
    shared: HashSet<&'c str>,
    exclusive: HashSet<&'c str>,
    alone: bool,
}

/// A system whose parts are closed.
pub(crate) struct Tables<'c> {
    pub(crate) cores: Option<usize>,
    codels: HashMap<&'c str, Locks<'c>>,
    pub(crate) parts: HashMap<&'c str, &'c Part>,
    pub(crate) atoms: HashMap<&'c str, &'c Atom>,
}

impl<'c> Tables<'c> {
    /// Makes the tables of a system.
    ///
    /// # Errors
    /// A name is unknown or has two meanings, or a part can leave its local states.
    pub(crate) fn of(system: &'c System, work: &mut Work) -> Result<Self, String> {
        let set = |names: &'c [String]| names.iter().map(String::as_str).collect();
        let codels = table("codel", &system.codels, |codel| &codel.name)?;
        let codels = codels.into_iter().map(|(name, codel)| {
            let (shared, exclusive) = (set(&codel.shared), set(&codel.exclusive));
            let alone = codel.alone;
            (name, Locks { shared, exclusive, alone })
        });
        let out = Tables {
            cores: system.cores,
            codels: codels.collect(),
            parts: table("part", &system.parts, |part| &part.name)?,
            atoms: table("atom", &system.atoms, |atom| &atom.name)?,
        };
        for part in &system.parts {
            (out.closed(part)).map_err(|error| format!("part `{}`: {error}", part.name))?;
        }
        let names = |part: &'c Part| part.states.iter().map(|state| state.name.as_str());
        let states = system.parts.iter();
        let states = states.map(|part| (part.name.as_str(), names(part).collect())).collect();
        for atom in &system.atoms {
            work.spend(atom.parts.len())?;
            known(atom, &states).map_err(|error| format!("atom `{}`: {error}", atom.name))?;
        }
        Ok(out)
    }

    /// Checks that the local states of a part contain the initial ones and are closed under the steps.
    fn closed(&self, part: &Part) -> Result<(), String> {
        let states = table("state", &part.states, |state| &state.name)?;
        if part.initial.is_empty() {
            return Err("it has no initial state".to_owned());
        }
        for initial in &part.initial {
            find("initial state", &states, initial)?;
        }
        for step in &part.steps {
            let ends = find("state", &states, &step.from).and(find("state", &states, &step.to));
            ends.map_err(|error| format!("step `{}`: {error}", step.what))?;
        }
        let mut executed = part.states.iter().filter_map(|state| state.executes.as_ref());
        executed.try_for_each(|codel| find("codel", &self.codels, codel).map(drop))
    }

    /// Returns true if the codels of two states of different parts are never executed at the same time.
    ///
    /// # Errors
    /// The certificate needs too much work.
    pub(crate) fn exclude(
        &self,
        one: &State,
        other: &State,
        work: &mut Work,
    ) -> Result<bool, String> {
        let (Some(one), Some(other)) = (&one.executes, &other.executes) else {
            return Ok(false);
        };
        if one == other {
            return Ok(self.codels[&**one].alone);
        }
        let (one, other) = (&self.codels[&**one], &self.codels[&**other]);
        let all = [one, other].map(|locks| locks.shared.len() + locks.exclusive.len());
        work.spend(1 + all[0] + all[1])?;
        let bars = |one: &Locks, other: &Locks| {
            let mut locks = other.shared.union(&other.exclusive);
            locks.any(|lock| one.exclusive.contains(lock))
        };
        Ok(bars(one, other) || bars(other, one))
    }
}

/// Checks that the parts and local states of an atom exist; `states` are those of each part.
fn known(atom: &Atom, states: &HashMap<&str, HashSet<&str>>) -> Result<(), String> {
    for (part, named) in &atom.parts {
        let states = find("part", states, part)?;
        if let Some(state) = named.iter().find(|state| !states.contains(state.as_str())) {
            return Err(format!("the state `{state}` is not declared"));
        }
    }
    Ok(())
}

/// Returns items by name.
///
/// # Errors
/// A name occurs twice.
fn table<'c, T>(
    what: &str,
    items: &'c [T],
    name: impl Fn(&T) -> &String,
) -> Result<HashMap<&'c str, &'c T>, String> {
    let mut out = HashMap::new();
    for item in items {
        if out.insert(&**name(item), item).is_some() {
            return Err(format!("two {what}s are named `{}`", name(item)));
        }
    }
    Ok(out)
}

fn find<'t, T>(what: &str, names: &'t HashMap<&str, T>, name: &str) -> Result<&'t T, String> {
    (names.get(name)).ok_or_else(|| format!("the {what} `{name}` is not declared"))
}
