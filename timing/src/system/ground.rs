//! The ground of an answer: what it rests on although it is not stated.

use serde::Serialize;

use super::CodelName;

/// Something that is not stated, and without which an answer may not hold.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "missing", rename_all = "kebab-case")]
pub enum Condition {
    /// An execution time: the codel is taken to need no time.
    Wcet {
        /// The codel, which can execute in this scenario.
        codel: CodelName,
    },
    /// An interface that the component provides or extends: its tasks, services and codels are taken not to
    /// exist.
    Interface {
        /// The interface, which is missing or a stand-in.
        interface: String,
        component: String,
    },
}

impl Condition {
    /// Returns true if an execution time is missing.
    pub(crate) fn is_wcet(&self) -> bool {
        matches!(self, Condition::Wcet { .. })
    }
}

/// Number of names in a sentence; further names are only counted.
const NAMED: usize = 6;

/// The conditions in a few words: `2 codels without wcet, 1 unknown interface`.
pub fn short(conditions: &[Condition]) -> String {
    let times = conditions.iter().filter(|condition| condition.is_wcet()).count();
    let interfaces = conditions.len() - times;
    let parts = [
        (times, "codel without wcet", "codels without wcet"),
        (interfaces, "unknown interface", "unknown interfaces"),
    ];
    let parts = parts.into_iter().filter(|(count, ..)| *count > 0);
    let parts = parts
        .map(|(count, one, several)| format!("{count} {}", if count == 1 { one } else { several }));
    parts.collect::<Vec<_>>().join(", ")
}

/// The conditions as a sentence that names each subject.
pub fn sentence(conditions: &[Condition]) -> String {
    let codels = conditions.iter().filter_map(|condition| match condition {
        Condition::Wcet { codel } => Some(codel.to_string()),
        Condition::Interface { .. } => None,
    });
    let interfaces = conditions.iter().filter_map(|condition| match condition {
        Condition::Interface { interface, component } => {
            Some(format!("{interface} (of {component})"))
        }
        Condition::Wcet { .. } => None,
    });
    let parts = [
        named(
            codels.collect(),
            "has no `wcet` and counts as taking no time",
            "have no `wcet` and count as taking no time",
        ),
        named(
            interfaces.collect(),
            "is an unknown interface, whose services are not in the model",
            "are unknown interfaces, whose services are not in the model",
        ),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join("; ")
}

/// The names, followed by what is said about one or several of them; `None` without names.
fn named(names: Vec<String>, one: &str, several: &str) -> Option<String> {
    let mut all = names.iter().take(NAMED).cloned().collect::<Vec<_>>().join(", ");
    if names.len() > NAMED {
        all += &format!(" and {} more", names.len() - NAMED);
    }
    let said = if names.len() == 1 { one } else { several };
    (!names.is_empty()).then(|| format!("{all} {said}"))
}
