//! Certificates, as read from JSON. `docs/certificate.schema.json` is the schema.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;

pub(crate) const FORMAT: u32 = 1;

/// The version, which is read before anything else.
#[derive(Deserialize)]
pub(crate) struct Version {
    pub(crate) format: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Certificate {
    #[serde(rename = "format")]
    _format: u32,
    pub(crate) scenarios: Vec<Scenario>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Scenario {
    pub(crate) scenario: String,
    pub(crate) systems: Vec<System>,
    pub(crate) uncertified: Vec<Uncertified>,
}

/// A check without a certificate.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Uncertified {
    pub(crate) check: String,
    pub(crate) verdict: String,
    pub(crate) by: Option<String>,
}

/// Components that share cores, locks or clients, and claims about them.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct System {
    /// Number of cores, if it limits the states with `core`.
    pub(crate) cores: Option<usize>,
    pub(crate) codels: Vec<Codel>,
    pub(crate) parts: Vec<Part>,
    pub(crate) atoms: Vec<Atom>,
    pub(crate) checks: Vec<Check>,
}

/// A codel, and the locks that it holds while it is executed.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Codel {
    pub(crate) name: String,
    /// Locks that several codels may hold like this.
    pub(crate) shared: Vec<String>,
    /// Locks that no other codel holds meanwhile.
    pub(crate) exclusive: Vec<String>,
    /// Two instances of the codel are never executed at the same time.
    #[serde(default)]
    pub(crate) alone: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Part {
    pub(crate) name: String,
    pub(crate) initial: Vec<String>,
    pub(crate) states: Vec<State>,
    pub(crate) steps: Vec<Step>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct State {
    pub(crate) name: String,
    /// The codel that is executed.
    pub(crate) executes: Option<String>,
    /// A core is taken.
    #[serde(default)]
    pub(crate) core: bool,
    /// The service of whose activity a codel waits or is executed.
    pub(crate) service: Option<String>,
    /// The service that has no activity.
    pub(crate) void: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Step {
    pub(crate) from: String,
    pub(crate) to: String,
    pub(crate) what: String,
}

/// A fact about a state of the system. It implies that some listed part is in one of the listed states.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Atom {
    pub(crate) name: String,
    /// The implication also holds in the other direction.
    pub(crate) exact: bool,
    pub(crate) parts: BTreeMap<String, Vec<String>>,
}

/// The claim that a predicate holds in no state.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Check {
    pub(crate) check: String,
    pub(crate) never: Predicate,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Predicate {
    Atom(String),
    /// The atom held before the last step, and does not hold any more.
    Leave(String),
    Not(Box<Predicate>),
    And(Vec<Predicate>),
    Or(Vec<Predicate>),
}

impl fmt::Display for Predicate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (list, word, none) = match self {
            Predicate::Atom(atom) => return write!(f, "{atom}"),
            Predicate::Leave(atom) => return write!(f, "the end of {atom}"),
            Predicate::Not(negated) => return write!(f, "not {negated}"),
            Predicate::And(list) => (list, " and ", "true"),
            Predicate::Or(list) => (list, " or ", "false"),
        };
        let list: Vec<String> = list.iter().map(ToString::to_string).collect();
        if list.is_empty() { write!(f, "{none}") } else { write!(f, "({})", list.join(word)) }
    }
}
