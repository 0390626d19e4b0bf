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
