//! Real-time verification, for the command line and the editor.
//!
//! A [`Problem`] is a scenario with the specifications it uses, and `dotgen_timing` verifies it. [`summary`]
//! turns results into text. [`view`] is the common form that command line, lenses, panel and diagnostics
//! show. Nothing here does I/O or uses the protocol.

pub(crate) mod advice;
pub(crate) mod blocking;
pub(crate) mod changes;
pub(crate) mod first;
pub(crate) mod folded;
pub mod problem;
pub(crate) mod quick;
pub(crate) mod results;
pub(crate) mod run;
pub(crate) mod runs;
pub mod summary;
pub(crate) mod timeline;
pub(crate) mod trace;
pub(crate) mod view;
pub(crate) mod what_if;
pub(crate) mod why;

pub use problem::Problem;
pub(crate) use quick::{TaskBound, quick_bounds};
