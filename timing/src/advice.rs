//! What to change, so that a system holds that does not: single changes, each of which was verified itself,
//! all else as it is.
//!
//! [`remedy`] finds one for a check, soon or not at all; [`repairs`] all of them for everything that fails.

mod blame;
mod change;
mod remedy;
mod repairs;
mod trial;

pub use change::Change;
pub use remedy::remedy;
pub use repairs::{Repairs, Tell, Trying, repairs};
