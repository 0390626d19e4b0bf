//! Certificates: the invariants of a system, and the predicates that they exclude, as data.
//!
//! The program `dotgen-check` accepts or refuses them. The format is that of `docs/certificate.schema.json`.

mod words;

use serde::Serialize;
use serde_json::Map;

use self::words::{PartNames, Unique};
use super::parts::{Local, Part, Parts, is_exact};
use crate::property::{Atom, Predicate};
use crate::system::{CodelId, TimedSystem};

/// The version of the format.
pub const FORMAT: u32 = 1;

/// The certificates of scenarios.
#[derive(Debug, Clone, Serialize)]
pub struct Certificate {
    /// [`FORMAT`].
    pub format: u32,
    /// One entry per scenario.
    pub scenarios: Vec<ScenarioCertificate>,
}

#[derive(Debug, Clone, Serialize)]
pub struct ScenarioCertificate {
    /// Name of the scenario.
    pub scenario: String,
    /// Groups of components that have a claim.
    pub systems: Vec<SystemCertificate>,
    /// The other checks.
    pub uncertified: Vec<Uncertified>,
}

/// A check without a certificate.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Uncertified {
    /// The check, in words.
    pub check: String,
    pub verdict: String,
    /// The method that found the verdict, if there is a verdict.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
}

/// The parts, locks and cores of a system, and claims about it.
#[derive(Debug, Clone, Serialize)]
pub struct SystemCertificate {
    /// Number of cores, if it limits the tasks that have codels.
    #[serde(skip_serializing_if = "Option::is_none")]
    cores: Option<u32>,
    codels: Vec<CodelEntry>,
    parts: Vec<PartEntry>,
    atoms: Vec<AtomEntry>,
    checks: Vec<CheckEntry>,
}

/// A codel, and the locks that it holds while it is executed.
#[derive(Debug, Clone, Serialize)]
struct CodelEntry {
    name: String,
    shared: Vec<String>,
    exclusive: Vec<String>,
    /// Two instances of the codel are never executed at the same time.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    alone: bool,
}

#[derive(Debug, Clone, Serialize)]
struct PartEntry {
    name: String,
    initial: Vec<String>,
    states: Vec<StateEntry>,
    steps: Vec<StepEntry>,
}

#[derive(Debug, Clone, Serialize)]
struct StateEntry {
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    executes: Option<String>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    core: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    service: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    void: Option<String>,
}

#[derive(Debug, Clone, Serialize)]
struct StepEntry {
    from: String,
    to: String,
    what: String,
}

/// An atom, which implies that one of the parts is in one of the states. If it is exact, this also implies
/// the atom.
#[derive(Debug, Clone, Serialize)]
struct AtomEntry {
    name: String,
    exact: bool,
    /// By part, its states.
    parts: Map<String, serde_json::Value>,
}

#[derive(Debug, Clone, Serialize)]
struct CheckEntry {
    check: String,
    never: Formula,
}

/// A predicate with the names of its atoms.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "lowercase")]
enum Formula {
    Atom(String),
    Leave(String),
    Not(Box<Formula>),
    And(Vec<Formula>),
    Or(Vec<Formula>),
}

impl SystemCertificate {
    /// Returns the certificate of predicates that hold in no state of a system, each with the check that
    /// claims it.
    pub fn new(system: &TimedSystem, claims: &[(String, Predicate)]) -> SystemCertificate {
        let parts = Parts::of(system);
        let names = PartNames::of(&parts);
        let mut atoms = Atoms {
            parts: &parts,
            names: &names,
            unique: Unique::default(),
            known: Vec::new(),
            entries: Vec::new(),
        };
        let checks = (claims.iter())
            .map(|(check, never)| CheckEntry { check: check.clone(), never: atoms.formula(never) })
            .collect();
        SystemCertificate {
            cores: parts.cores(),
            codels: codels(system, &names),
            atoms: atoms.entries,
            parts: (parts.parts.iter().zip(&names.parts))
                .map(|(part, name)| part_entry(&parts, part, name, &names))
                .collect(),
            checks,
        }
    }
}

/// Returns codels with locks that make the same codels exclude each other as in the system: each codel has a
/// lock, which it holds exclusively. Codels that exclude it hold the lock too.
fn codels(system: &TimedSystem, names: &PartNames) -> Vec<CodelEntry> {
    let excludes = |one: CodelId, other: CodelId| {
        let [one_set, other_set] = [one, other].map(|codel| &system.codels[codel].conflicts);
        one_set.contains(other) && other_set.contains(one)
    };
    let entry = |codel: CodelId| {
        let others = || {
            let others = system.codels[codel].conflicts.iter();
            others.filter(|&other| other != codel && excludes(codel, other))
        };
        CodelEntry {
            name: names.codel(codel).to_owned(),
            shared: (others().filter(|&other| other < codel))
                .map(|other| names.codel(other).to_owned())
                .collect(),
            exclusive: (others().any(|other| codel < other))
                .then(|| names.codel(codel).to_owned())
                .into_iter()
                .collect(),
            alone: excludes(codel, codel),
        }
    };
    system.codels.keys().map(entry).collect()
}

fn part_entry(parts: &Parts, part: &Part, name: &str, names: &PartNames) -> PartEntry {
    let of_part = names.states(parts, part);
    let service = |service| parts.system.service_path(service);
    let state = |(local, name): (&Local, &String)| StateEntry {
        name: name.clone(),
        executes: (local.codel())
            .filter(|_| local.executes())
            .map(|codel| names.codel(codel).to_owned()),
        core: parts.has_core(part, local),
        service: parts.service(local).map(service),
        void: match *local {
            Local::Slots { service: of, void: true } => Some(service(of)),
            _ => None,
        },
    };
    let step = |&(from, to): &(usize, usize)| StepEntry {
        from: of_part[from].clone(),
        to: of_part[to].clone(),
        what: words::step(parts, names, name, (&part.locals[from], &part.locals[to])),
    };
    PartEntry {
        name: name.to_owned(),
        initial: vec![of_part[0].clone()],
        states: part.locals.iter().zip(&of_part).map(state).collect(),
        steps: part.steps.iter().map(step).collect(),
    }
}

/// The atoms of formulas.
struct Atoms<'p> {
    parts: &'p Parts<'p>,
    names: &'p PartNames,
    unique: Unique,
    known: Vec<Atom>,
    entries: Vec<AtomEntry>,
}

impl Atoms<'_> {
    fn formula(&mut self, predicate: &Predicate) -> Formula {
        match predicate {
            Predicate::Atom(atom) => Formula::Atom(self.name(atom)),
            Predicate::Leave(atom) => Formula::Leave(self.name(atom)),
            Predicate::Not(negated) => Formula::Not(Box::new(self.formula(negated))),
            Predicate::And(..) => Formula::And(self.list(predicate)),
            Predicate::Or(..) => Formula::Or(self.list(predicate)),
        }
    }

    /// Returns the operands of a conjunction or disjunction, in one list however it is nested.
    fn list(&mut self, predicate: &Predicate) -> Vec<Formula> {
        let mut out = Vec::new();
        let mut open = vec![predicate];
        while let Some(next) = open.pop() {
            match (predicate, next) {
                (Predicate::And(..), Predicate::And(one, other))
                | (Predicate::Or(..), Predicate::Or(one, other)) => open.extend([&**other, one]),
                _ => out.push(self.formula(next)),
            }
        }
        out
    }

    /// Returns the name of an atom, which is added if it is new.
    fn name(&mut self, atom: &Atom) -> String {
        if let Some(at) = self.known.iter().position(|known| known == atom) {
            return self.entries[at].name.clone();
        }
        let entry = AtomEntry {
            name: (self.unique).name(words::atom(self.parts.system, self.names, atom)),
            exact: is_exact(atom),
            parts: self.places(atom),
        };
        let name = entry.name.clone();
        self.known.push(atom.clone());
        self.entries.push(entry);
        name
    }

    /// Returns, by part, the states in which an atom may hold.
    fn places(&self, atom: &Atom) -> Map<String, serde_json::Value> {
        let mut out = Map::new();
        for (part, name) in self.parts.parts.iter().zip(&self.names.parts) {
            if !self.parts.is_about(part, atom) {
                continue;
            }
            let states = self.names.states(self.parts, part);
            let holds = part.locals.iter().zip(states);
            let holds = holds.filter(|(local, _)| self.parts.value(local, atom));
            let states: Vec<String> = holds.map(|(_, name)| name).collect();
            out.insert(name.clone(), states.into());
        }
        out
    }
}
