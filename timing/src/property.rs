//! The properties that can be checked of a system.

pub(crate) mod data;
mod kind;
pub(crate) mod monitor;
pub mod predicate;
pub(crate) mod resolve;

pub use crate::system::data::DataFact;
pub use kind::PropertyKind;
pub use monitor::Monitor;
pub use predicate::{Atom, Predicate, SlotStatus, StatePhase, TaskState};
