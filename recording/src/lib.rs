//! Recorded runs.
//!
//! Servers generated with profiling, and `dotgen run --profile`, write a line for each run of a codel: see
//! [`log`]. From such logs this crate computes statistics ([`statistics`]), execution times
//! ([`measurements`], [`proposal`]), the edits that write them into specifications ([`edits`]), comparisons
//! with the verified model ([`monitor`]), and traces ([`trace`]).
//!
//! This crate neither reads nor writes files: callers pass the bytes.

pub mod edits;
pub mod log;
pub mod matching;
pub mod measurements;
pub mod monitor;
pub mod proposal;
pub mod record;
pub mod replay;
pub mod statistics;
pub mod trace;
