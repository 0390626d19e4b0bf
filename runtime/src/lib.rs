//! Runs of GenoM3 systems.
//!
//! A run goes through the rules that are verified, step by step ([`dotgen_timing::explore::Stepper`]): what
//! can happen is known there and nowhere else. Here it is chosen ([`decide`]), done ([`engine`]), counted
//! ([`tally`]) and held to the checks of the scenario and to proved bounds ([`judge`]). [`simulation`] puts
//! these together.

pub mod decide;
pub mod engine;
pub mod judge;
pub mod profile;
pub mod report;
pub mod simulation;
pub mod tally;
