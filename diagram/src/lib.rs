//! Pictures of specifications: state machines, systems of components, locks, timelines.
//!
//! One graph model ([`graph`]), one layout ([`layout`]), a few renderers ([`render`]). What a picture shows
//! is decided where its graph is built ([`fsm`], [`system`], [`locks`]); how it looks is decided by the
//! renderer and its [`theme`]. The same input gives the same bytes, in the editor and on the command line,
//! without fonts, browser or network.

pub mod fsm;
pub mod graph;
pub mod layout;
pub mod locks;
pub mod render;
pub mod system;
pub mod text;
pub mod theme;
pub mod timeline;
