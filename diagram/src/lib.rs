//! Pictures of specifications: state machines, systems of components and locks.
//!
//! One graph model ([`graph`]), one layout ([`layout`]), a few renderers ([`render`]). The modules that build
//! graphs ([`fsm`], [`system`], [`locks`]) choose the content of a picture; the renderer and its [`theme`]
//! choose its appearance. The same input gives the same bytes, in the editor and on the command line, without
//! fonts, browser or network.

pub mod fsm;
pub mod graph;
pub mod layout;
pub mod locks;
pub mod render;
pub mod system;
pub mod text;
pub mod theme;

// The tests of the crate as others use it, in the program of the unit tests: each program takes seconds to
// link.
#[cfg(test)]
extern crate self as dotgen_diagram;
#[cfg(test)]
#[path = "../tests/main.rs"]
mod suite;
