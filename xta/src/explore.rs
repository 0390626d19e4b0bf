//! Symbolic reachability.

pub(crate) mod moves;
pub(crate) mod search;
mod store;
pub(crate) mod trace;
