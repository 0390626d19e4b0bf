//! The tables of a system, by name, after checks of the parts.

use std::collections::HashMap;

use crate::certificate::{Atom, Codel, Part, State, System};

/// A system whose parts are closed.
pub(crate) struct Tables<'c> {
    pub(crate) cores: Option<usize>,
    codels: HashMap<&'c str, &'c Codel>,
    pub(crate) parts: HashMap<&'c str, &'c Part>,
    pub(crate) atoms: HashMap<&'c str, &'c Atom>,
}

impl<'c> Tables<'c> {
    /// Makes the tables of a system.
    ///
    /// # Errors
    /// A name is unknown or has two meanings, or a part can leave its local states.
    pub(crate) fn of(system: &'c System) -> Result<Self, String> {
        let out = Tables {
            cores: system.cores,
            codels: table("codel", &system.codels, |codel| &codel.name)?,
            parts: table("part", &system.parts, |part| &part.name)?,
            atoms: table("atom", &system.atoms, |atom| &atom.name)?,
        };
        for part in &system.parts {
            (out.closed(part)).map_err(|error| format!("part `{}`: {error}", part.name))?;
        }
        for atom in &system.atoms {
            (out.known(atom)).map_err(|error| format!("atom `{}`: {error}", atom.name))?;
        }
        Ok(out)
    }

    /// Checks that the local states of a part contain the initial ones and are closed under the steps.
    fn closed(&self, part: &Part) -> Result<(), String> {
        let states = table("state", &part.states, |state| &state.name)?;
        if part.initial.is_empty() {
            return Err("there is no initial state".to_owned());
        }
        for initial in &part.initial {
            find("initial state", &states, initial)?;
        }
        for step in &part.steps {
            let ends = find("state", &states, &step.from).and(find("state", &states, &step.to));
            ends.map_err(|error| format!("step `{}`: {error}", step.what))?;
        }
        let mut executed = part
            .states
            .iter()
            .filter_map(|state| state.executes.as_ref());
        executed.try_for_each(|codel| find("codel", &self.codels, codel).map(drop))
    }

    /// Checks that the parts and local states of an atom exist.
    fn known(&self, atom: &Atom) -> Result<(), String> {
        for (part, named) in &atom.parts {
            let part = find("part", &self.parts, part)?;
            let states = table("state", &part.states, |state| &state.name)?;
            for state in named {
                find("state", &states, state)?;
            }
        }
        Ok(())
    }

    /// Returns true if the codels of two states of different parts are never executed at the same time.
    pub(crate) fn exclude(&self, one: &State, other: &State) -> bool {
        let codel = |state: &State| Some(self.codels[state.executes.as_deref()?]);
        let (Some(one), Some(other)) = (codel(one), codel(other)) else {
            return false;
        };
        if one.name == other.name {
            return one.alone;
        }
        let bars = |one: &Codel, other: &Codel| {
            let mut locks = other.shared.iter().chain(&other.exclusive);
            locks.any(|lock| one.exclusive.contains(lock))
        };
        bars(one, other) || bars(other, one)
    }
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
    (names.get(name)).ok_or_else(|| format!("there is no {what} `{name}`"))
}
