//! Real-time verification, for the command line and the editor.
//!
//! A [`Problem`] is a scenario with the specifications it uses, and `dotgen_timing` verifies it. [`summary`]
//! turns results into text. [`view`] is the common form that command line, lenses, panel and diagnostics
//! show. Nothing here does I/O or uses the protocol.

pub mod advice;
pub mod blocking;
pub mod changes;
mod endless;
pub mod first;
pub mod fold_repetitions;
pub mod problem;
pub(crate) mod quick;
pub mod results;
pub mod run;
pub mod runs;
pub mod summary;
mod times;
pub mod trace;
pub mod view;
pub mod what_if;
pub mod why;

pub use problem::Problem;
pub use quick::{TaskBound, quick_bounds};
