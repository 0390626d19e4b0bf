//! Codels and specifications in step: against the reference outputs, the system's compilers, and
//! the example with seeded drift.

mod clone;
mod detect;
mod directions;
mod example;
mod fresh;
mod golden;
mod once;
mod project;
mod rename;
mod repair;
mod skeletons;
mod support;
mod sync;
mod typing;
