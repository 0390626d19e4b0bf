//! Chains of data: what each codel reads and writes, by number.

pub use crate::scn::ast::ChainKind;

/// Where a datum is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum DataPlace {
    /// One of those that everybody shares: ports, data of a component.
    Shared(usize),
    /// A local variable of the instance of an activity, or of the request, for which the codel is executed.
    Local(usize),
}

/// A chain of data through a system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chain {
    /// What is asked.
    pub kind: ChainKind,
    /// Number of shared places.
    pub shared: usize,
    /// Number of local places of an instance or a request.
    pub locals: usize,
    /// What each codel reads.
    pub reads: Vec<Vec<DataPlace>>,
    /// What each codel writes.
    pub writes: Vec<Vec<DataPlace>>,
    /// Codels whose data depend on what they read. What others write depends on nothing.
    pub carries: Vec<bool>,
    /// The first datum, a shared place.
    pub first: usize,
    /// The last datum, a shared place.
    pub last: usize,
    /// Nobody in the system writes the first datum: it is new at any moment.
    pub external: bool,
}
