//! Runs of GenoM3 systems.
//!
//! A run follows the verified rules step by step ([`dotgen_timing::explore::Stepper`]): only the stepper
//! knows the possible actions. This crate chooses an action ([`decide`]), performs it ([`engine`]), counts it
//! ([`tally`]) and compares the run with the checks of the scenario and with proved bounds ([`checker`]).
//! [`simulation`] combines these modules; [`parts`] divides many runs among processors. [`watch`] is the
//! interface for observers of every step, and [`progress`] reports the state of a run under way.
//!
//! If components have codels, [`live`] has them executed by [`hosts`], which this crate knows only as a
//! trait. On the real clock ([`real_clock`], [`model_time`]) the rules are the same, with real times
//! ([`refine`]).

pub mod checker;
pub mod counts;
pub mod decide;
mod end;
mod ending;
pub mod engine;
pub mod estimate;
pub mod hosts;
pub mod live;
mod measures;
mod merge;
pub mod model_time;
pub mod parts;
pub mod port_writes;
pub mod profile;
pub mod progress;
pub mod real_clock;
pub mod refine;
pub mod report;
pub mod simulation;
pub mod tally;
pub mod watch;
pub mod weights;
