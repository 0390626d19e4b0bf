//! Real-time verification of GenoM3 components: timed model, exact explorer and properties.
//!
//! Data flows one way: specifications and a scenario become a [`system::TimedSystem`]. [`verify`] answers the
//! checks of the scenario with [`analytic`] bounds, then with [`abstraction`], then with [`explore`].
//! [`mod@derive`] and [`advice`] verify variations of the system.

pub mod abstraction;
pub mod advice;
pub mod analytic;
mod cancel;
pub mod derive;
pub mod diagnostic;
pub mod explore;
pub mod invariants;
mod limit;
pub mod property;
mod questions;
pub mod reduction_use;
pub mod report;
pub mod scn;
pub mod system;
pub mod verify;
