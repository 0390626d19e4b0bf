//! Recorded runs.
//!
//! Servers that are generated with profiling, and `dotgen run --profile`, write a line for each run of a
//! codel: see [`log`]. From such logs come statistics ([`statistics`]), execution times ([`measured`],
//! [`propose`]) and the edits that write them into specifications ([`edits`]), comparisons with the model
//! that is verified ([`monitor`]), and traces ([`trace`]).
//!
//! Nothing here reads or writes files: what is read is handed over as bytes.

pub mod edits;
pub mod log;
pub mod matching;
pub mod measured;
pub mod monitor;
pub mod propose;
pub mod record;
pub mod replay;
pub mod statistics;
pub mod trace;
