//! Checks certificates of proofs by invariants, which `dotgen verify --certificate` writes.
//!
//! The checker shares no code with the verifier. It trusts that a certificate stands for the specification
//! and its scenario: the parts with all their steps, the codels that exclude each other, the atoms, and the
//! predicate of each check. What follows from them is computed again: that the local states of each part
//! are closed under its steps, the number of codels that have a core, and that each case of a predicate
//! contradicts an invariant.

mod certificate;
mod proof;
mod system;

use std::fmt;

use certificate::{Certificate, FORMAT, Version};
use system::{Tables, Work};

/// The greatest size of a certificate, in bytes.
pub const MOST_BYTES: usize = 64 << 20;

/// The answer about a check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Answer {
    /// Scenario and check.
    pub check: String,
    pub outcome: Outcome,
}

/// The outcome for a check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// This predicate holds in no state.
    Accepted(String),
    /// The certificate does not prove the claim, for a reason.
    Refused(String),
    /// The check is not certified. The text has its verdict and the method of the verifier.
    NotCertified(String),
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Outcome::Accepted(never) => write!(f, "accepted: never {never}"),
            Outcome::Refused(reason) => write!(f, "refused: {reason}"),
            Outcome::NotCertified(why) => write!(f, "not certified: {why}"),
        }
    }
}

/// Checks a certificate, and returns an answer for each check.
///
/// # Errors
/// The text is too large, is not a certificate, or has another version.
pub fn check(text: &[u8]) -> Result<Vec<Answer>, String> {
    if text.len() > MOST_BYTES {
        return Err(format!("has more than {} MiB", MOST_BYTES >> 20));
    }
    let not_one = |error| format!("is not a certificate: {error}");
    let Version { format } = serde_json::from_slice(text).map_err(not_one)?;
    if format != FORMAT {
        return Err(format!("has format {format}, not {FORMAT}"));
    }
    let certificate: Certificate = serde_json::from_slice(text).map_err(not_one)?;
    let (mut out, mut work) = (Vec::new(), Work::default());
    for scenario in &certificate.scenarios {
        let mut tell = |check: &str, outcome| {
            let check = format!("{}: {check}", scenario.scenario);
            out.push(Answer { check, outcome });
        };
        for system in &scenario.systems {
            let tables = Tables::of(system, &mut work);
            for check in &system.checks {
                let proof = match &tables {
                    Ok(tables) => proof::never_holds(tables, &check.never, &mut work),
                    Err(reason) => Err(reason.clone()),
                };
                let accepted = |()| Outcome::Accepted(check.never.to_string());
                let outcome = proof.map_or_else(Outcome::Refused, accepted);
                tell(&check.check, outcome);
            }
        }
        for other in &scenario.uncertified {
            let by = other.by.iter().map(|by| format!(" by {by}"));
            let why = other.verdict.clone() + &by.collect::<String>();
            tell(&other.check, Outcome::NotCertified(why));
        }
    }
    Ok(out)
}
