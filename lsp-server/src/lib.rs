//! The `dotgen` program: language server and command line over one analysis.
//!
//! Only this crate touches the file system, starts processes, and knows protocol types. It is built in
//! storeys: each folder uses those before it in this list, and none after.
//!
//! | storey | what it has |
//! | --- | --- |
//! | `process` | programs that are started, how they end and what confines them |
//! | `files` | files: read for analysis, written for users, packages |
//! | `hosting` | components that run: their hosts, and who asks something of them |
//! | `verification` | real-time verification: problems, answers, and how they are shown |
//! | `protocol` | the types of LSP, messages beyond it, the client, conversions |
//! | `config` | settings and what they amount to |
//! | `views` | what the command line and the editor both show: pictures, the model, the manual |
//! | `workspace` | open documents, folders, templates, and the snapshot that requests read |
//! | `features` | answers to requests, by language of the document |
//! | `session` | one client: transport, dispatch, the writer, what is told unasked |
//! | `cli` | the command line |
//!
//! `tests/tests/architecture.rs` reads the imports and fails on a circle.

#![warn(clippy::print_stdout)]

pub mod cli;
pub mod config;
mod features;
pub mod files;
#[cfg(unix)]
mod hosting;
mod panic;
mod process;
pub mod protocol;
mod session;
pub mod verification;
pub mod views;
pub mod workspace;

pub use session::server::serve;

#[cfg(test)]
mod tests;
