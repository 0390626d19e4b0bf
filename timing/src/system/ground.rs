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
}

/// Number of names in a sentence; further names are only counted.
const NAMED: usize = 6;

/// The conditions in a few words: `2 codels without wcet`.
pub fn short(conditions: &[Condition]) -> String {
    let count = conditions.len();
    format!("{count} {} without wcet", if count == 1 { "codel" } else { "codels" })
}

/// The conditions as a sentence that names each subject.
pub fn sentence(conditions: &[Condition]) -> String {
    let names = conditions.iter().map(|Condition::Wcet { codel }| &**codel);
    let mut all = names.clone().take(NAMED).collect::<Vec<_>>().join(", ");
    if conditions.len() > NAMED {
        all += &format!(" and {} more", conditions.len() - NAMED);
    }
    let (has, counts) = if conditions.len() == 1 { ("has", "counts") } else { ("have", "count") };
    format!("{all} {has} no `wcet` and {counts} as taking no time")
}
