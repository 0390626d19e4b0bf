//! The scenario language (`.scn`): the checks to verify, the platform and the assumptions.
//!
//! The lexer turns text into tokens. The parser turns tokens into an [`ast::Scenario`] with a range on every
//! name. Problems become [`Diagnostic`](crate::diagnostic::Diagnostic)s; no stage ever fails. [`names`] looks
//! up paths in the components, also for editor features.

pub mod ast;
pub mod codes;
pub mod complete;
mod default;
pub mod describe;
pub mod edit;
mod format;
pub mod lexer;
pub mod names;
pub mod outline;
mod parser;
mod pattern;
pub mod requests;
pub mod selection;
pub mod semantics;
pub mod times;
mod values;
pub mod words;

pub use default::{Platform, default_text, default_text_on};
pub use format::{format, format_edits};
pub use parser::{Parse, parse, parse_check};
