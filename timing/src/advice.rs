//! Advice on systems that miss a deadline: single changes that repair them. Each change is verified on its
//! own, with everything else unchanged.
//!
//! `remedy` finds one change for a check and gives up early. `repairs` finds all changes that repair
//! everything that fails.

mod change;
mod remedy;
mod repairs;
mod suspects;
mod trial;

pub use change::Change;
pub use remedy::remedy;
pub use repairs::{RepairCallbacks, RepairProgress, Repairs, repairs};
