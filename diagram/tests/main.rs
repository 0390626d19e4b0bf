//! Pictures: geometry, determinism, well-formed XML.

mod geometry;
mod handmade;
mod large;
mod specifications;
