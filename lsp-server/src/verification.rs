//! Real-time verification: what the command line and the editor share.
//!
//! A [`Problem`] is a scenario and the specifications it uses; `dotgen_timing` answers it; [`summary`] has
//! the words, and [`view`] what people look at: made once, shown by command line, lenses, panel and
//! diagnostics. Nothing here does I/O or knows the protocol.

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
