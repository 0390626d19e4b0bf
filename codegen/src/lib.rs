//! Code generation: the C and C++ mapping of specifications, and the GenoM3 template engine.

pub mod builtin;
pub mod catalog;
pub mod codels;
pub mod command;
pub mod compiler;
pub mod component;
pub mod disk;
mod environment;
pub mod frontend;
pub mod lang;
mod options;
pub mod process;
pub mod template;

/// The name of this crate in shared test code, which other crates' tests include as well.
#[cfg(test)]
extern crate self as dotgen_codegen;
#[cfg(test)]
#[path = "../tests/support/files.rs"]
mod files;
