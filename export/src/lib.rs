//! Formal models of GenoM3 systems for the tools of others: UPPAAL, TChecker and TINA.
//!
//! Data flows one way: the timed system that the verifier explores, with the questions of its checks,
//! becomes a [`model::Network`] of timed automata ([`translate()`]). A printer writes the network in the
//! language of a tool. A model has the verdicts of the verifier's exact exploration; what is not translated
//! exactly is [refused](Refusal), with its place.

mod fiacre;
pub mod model;
mod tchecker;
pub mod translate;
mod uppaal;

use dotgen_timing::verify::Prepared;

pub use self::translate::{Place, Refusal, translate};

/// The language of a tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// UPPAAL 4.1 or later: a network (`.xta`), its queries (`.q`), and both as a drawing (`.xml`).
    Uppaal,
    /// TChecker 0.8 or later: a network (`.tck`), whose labels are the queries.
    TChecker,
    /// `frac` of TINA: a Fiacre program (`.fcr`) with a property for each query.
    Fiacre,
}

/// A file to write.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Name, without a folder.
    pub name: String,
    pub text: String,
}

/// Returns the formal model of a system, as the files of a tool. `place` gives the places of declarations,
/// for comments.
///
/// # Errors
///
/// Everything that the model cannot contain.
pub fn export(
    prepared: &Prepared,
    place: &Place,
    format: Format,
) -> Result<Vec<File>, Vec<Refusal>> {
    let network = translate(prepared, place)?;
    let is_deadlock = |query: &model::Query| matches!(query.kind, model::QueryKind::Lively { .. });
    if format == Format::TChecker && network.queries.iter().any(is_deadlock) {
        return Err(vec![Refusal::new("deadlock (TChecker has no such query)", None)]);
    }
    Ok(match format {
        Format::Uppaal => uppaal::print(&network),
        Format::TChecker => vec![tchecker::print(&network)],
        Format::Fiacre => vec![fiacre::print(&network)?],
    })
}
