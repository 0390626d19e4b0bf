//! Cause-effect chains: the data that each codel reads and writes, by number.

use typed_index_collections::TiVec;

use super::CodelId;
pub use crate::scn::ast::ChainKind;

/// A place that holds a datum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum DataPlace {
    /// A place shared by the whole system: a port, or data of a component.
    Shared(usize),
    /// A local variable of the activity instance, or of the request, for which the codel runs.
    Local(usize),
}

/// A cause-effect chain through a system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chain {
    /// The delay to measure.
    pub kind: ChainKind,
    /// Number of shared places.
    pub shared: usize,
    /// Number of local places of an instance or a request.
    pub locals: usize,
    pub reads: TiVec<CodelId, Vec<DataPlace>>,
    pub writes: TiVec<CodelId, Vec<DataPlace>>,
    /// Codels whose outputs depend on their inputs. The outputs of other codels depend on nothing.
    pub carries: TiVec<CodelId, bool>,
    /// The first datum, a shared place.
    pub first: usize,
    /// The last datum, a shared place.
    pub last: usize,
    /// No codel of the system writes the first datum: it can be new at any moment.
    pub external: bool,
}
