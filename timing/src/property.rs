//! The properties that can be checked of a system.

mod kind;
pub mod predicate;
pub(crate) mod resolve;

pub use kind::PropertyKind;
pub use predicate::{Atom, Predicate, SlotStatus, StatePhase, TaskState};
