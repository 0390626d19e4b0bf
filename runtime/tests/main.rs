//! The tests of this crate, in one program, to link only once.

mod delegated;
mod held;
#[path = "support/random_systems.rs"]
mod random_systems;
mod recorded;
mod replayed;
#[path = "support/simulated_hosts.rs"]
mod simulated_hosts;
mod weights;

// The random texts use the path `super::super::systems`.
use random_systems::systems;
