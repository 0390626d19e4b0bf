//! Formal models of GenoM3 systems for the tools of others: UPPAAL, TChecker, TINA and BIP.
//!
//! Data flows one way: the timed system that the verifier explores, with the questions of its checks,
//! becomes a [`model::Network`] of timed automata ([`translate()`]). A printer writes the network in the
//! language of a tool. A model has the verdicts of the verifier's exact exploration; what is not translated
//! exactly is [refused](Refusal), with its place.
//!
//! A trace of another tool comes back as a run of the verifier ([`import()`]).

mod bip;
mod fiacre;
mod import;
pub mod model;
mod tchecker;
pub mod translate;
mod uppaal;

use dotgen_timing::verify::Prepared;

pub use self::import::{Error, Goal, Imported, MAX_BYTES, import};
use self::model::{Network, Query, QueryKind};
pub use self::translate::{Place, Refusal, check_name, translate};

/// The language of a tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// UPPAAL 4.1 or later: a network (`.xta`), its queries (`.q`), and both as a drawing (`.xml`).
    Uppaal,
    /// TChecker 0.8 or later: a network (`.tck`), whose labels are the queries.
    TChecker,
    /// `frac` of TINA: a Fiacre program (`.fcr`) with a property for each query.
    Fiacre,
    /// BIP 2 with real time: a package (`.bip`) with a comment for each query.
    Bip,
}

impl Format {
    /// Returns the refusal of a query that the language cannot ask.
    fn refusal(self, query: &Query, network: &Network) -> Option<Refusal> {
        let has_limit = || {
            let mut same = network.queries.iter().filter(|other| other.check == query.check);
            same.any(|other| matches!(other.kind, QueryKind::Never { .. }))
        };
        let tool = match self {
            Format::Uppaal => return None,
            Format::TChecker => "TChecker",
            Format::Fiacre => "Fiacre",
            Format::Bip => "BIP",
        };
        let why = match query.kind {
            QueryKind::Lively { .. } => format!("deadlock ({tool} has no such query)"),
            QueryKind::Greatest(_) if !has_limit() => {
                format!("time without a limit ({tool} has no greatest value)")
            }
            _ => return None,
        };
        Some(Refusal::new(&why, Some(query.name.clone())))
    }
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
    let refused = network.queries.iter().filter_map(|query| format.refusal(query, &network));
    let refusals: Vec<Refusal> = refused.collect();
    if !refusals.is_empty() {
        return Err(refusals);
    }
    Ok(match format {
        Format::Uppaal => uppaal::print(&network),
        Format::TChecker => vec![tchecker::print(&network)],
        Format::Fiacre => vec![fiacre::print(&network)?],
        Format::Bip => vec![bip::print(&network)?],
    })
}
