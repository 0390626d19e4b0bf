//! The scenario language (`.scn`): what to verify, on which platform, and under which assumptions.
//!
//! Text becomes tokens, tokens become an [`ast::Scenario`] with a range on every name, and problems
//! become [`Diagnostic`](crate::diagnostic::Diagnostic)s; none of it ever fails. Paths are looked up in the
//! components by [`names`], which is also what editor features ask.

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
pub mod semantics;
mod words;

pub use default::{Platform, default_text, default_text_on};
pub use format::format;
pub use parser::{Parse, parse, parse_check};
