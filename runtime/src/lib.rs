//! Runs of GenoM3 systems.
//!
//! A run goes through the rules that are verified, step by step ([`dotgen_timing::explore::Stepper`]): what
//! can happen is known there and nowhere else. Here it is chosen ([`decide`]), done ([`engine`]), counted
//! ([`tally`]) and held to the checks of the scenario and to proved bounds ([`judge`]). [`simulation`] puts
//! these together. Whoever looks on is told through [`watch`],
//! and how far a run has come by [`progress`].
//!
//! Where components have codels, [`live`] has them executed: by [`hosts`], which this crate knows as a trait
//! only. On the real clock ([`paced`]) the rules are the same, with times as they really are ([`refine`]).

pub mod counted;
pub mod decide;
pub mod engine;
pub mod hosts;
pub mod judge;
pub mod live;
pub mod paced;
pub mod profile;
pub mod progress;
pub mod refine;
pub mod report;
pub mod simulation;
pub mod tally;
pub mod watch;
