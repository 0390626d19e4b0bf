//! The language server.
//!
//! Each folder uses those before it in this list, and none after.
//!
//! | folder | content |
//! | --- | --- |
//! | `protocol` | the types of LSP, messages beyond it, the client, conversions |
//! | `config` | settings and their combination |
//! | `workspace` | open documents, folders, templates, and the snapshot that requests read |
//! | `features` | answers to requests, by language of the document |
//! | `session` | one client: transport, dispatch, the writer, notifications |
//!
//! `tests/tests/architecture.rs` reads the imports and fails on a circle.

#![warn(clippy::print_stdout)]

pub mod config;
pub mod features;
pub mod protocol;
pub mod session;
mod workspace;

pub use session::server::serve;

#[cfg(test)]
mod tests;
