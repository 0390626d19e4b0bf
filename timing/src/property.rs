//! What can be asked about a system.

pub mod predicate;
pub(crate) mod resolve;

pub use predicate::{Atom, Predicate, SlotStatus, StatePhase, TaskState};
