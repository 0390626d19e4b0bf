//! The `dotgen` program: language server and command line over one analysis.
//!
//! Only this crate touches the file system, starts processes, and knows protocol types. A message
//! travels `server` (transport) → `backend` (one method per message) → `state` (the writer) or
//! `dispatch` → `handlers` (one file per request) → `convert`. The command line is in `cli`.

#![warn(clippy::print_stdout)]

mod backend;
pub mod caps;
pub mod cli;
mod client_process;
mod codels;
pub mod config;
pub mod convert;
mod dispatch;
pub mod ext;
mod generation;
mod handlers;
pub mod logging;
pub mod manual;
mod model;
mod outbox;
mod panic;
pub mod pictures;
mod process;
mod progress;
pub mod proto;
mod publish;
pub mod server;
pub mod snapshot;
mod state;
mod templates;
mod transport;
pub mod verification;
pub mod verifier;
pub mod vfs;

#[cfg(test)]
mod tests;
