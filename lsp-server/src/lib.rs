//! The `dotgen` program: language server and command line over one analysis.
//!
//! Only this crate uses the file system, starts processes, and knows protocol types. It is built in storeys:
//! each folder uses those before it in this list, and none after.
//!
//! | storey | content |
//! | --- | --- |
//! | `process` | child processes: their start, their end and their confinement |
//! | `files` | files: read for analysis, written for users, packages |
//! | `hosting` | components that run: their hosts, and the clients that send requests |
//! | `verification` | real-time verification: problems, answers, and their common views |
//! | `protocol` | the types of LSP, messages beyond it, the client, conversions |
//! | `config` | settings and their combination |
//! | `views` | views that the command line and the editor share: pictures, the model, the manual |
//! | `workspace` | open documents, folders, templates, and the snapshot that requests read |
//! | `features` | answers to requests, by language of the document |
//! | `session` | one client: transport, dispatch, the writer, notifications |
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
