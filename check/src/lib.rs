//! Checks certificates of proofs by invariants, which `dotgen verify --certificate` writes.
//!
//! The checker shares no code with the verifier. It trusts that the parts, locks and atoms of a certificate
//! stand for the specification and its scenario. Everything that follows from them is computed again: that
//! the local states of each part are closed under its steps, the codels that exclude each other, the number
//! of codels that have a core, and that each case of a predicate contradicts one of these invariants.

mod certificate;
mod proof;
mod system;

use std::fmt;

use certificate::{Certificate, FORMAT};
use system::Tables;

/// The greatest size of a certificate, in bytes.
pub const MOST_BYTES: usize = 64 << 20;

/// The answer about a check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Answer {
    /// Scenario and check.
    pub check: String,
    /// Outcome.
    pub outcome: Outcome,
}

/// The outcome for a check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// The predicate holds in no state.
    Accepted,
    /// The certificate does not prove the claim, for a reason.
    Refused(String),
    /// There is no certificate: the verdict, and the method of the verifier.
    NotCertified(String),
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Outcome::Accepted => f.write_str("accepted"),
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
    let certificate: Certificate =
        serde_json::from_slice(text).map_err(|error| format!("is not a certificate: {error}"))?;
    if certificate.format != FORMAT {
        return Err(format!("has format {}, not {FORMAT}", certificate.format));
    }
    let mut out = Vec::new();
    for scenario in &certificate.scenarios {
        let mut tell = |check: &str, outcome| {
            let check = format!("{}: {check}", scenario.scenario);
            out.push(Answer { check, outcome });
        };
        for system in &scenario.systems {
            let tables = Tables::of(system);
            for check in &system.checks {
                let proof = match &tables {
                    Ok(tables) => proof::never_holds(tables, &check.never),
                    Err(reason) => Err(reason.clone()),
                };
                let outcome = proof.map_or_else(Outcome::Refused, |()| Outcome::Accepted);
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
