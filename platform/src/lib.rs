//! What dotgen asks of the operating system. Only this crate and `hosting` start processes, and only this
//! crate reads and writes files.

#![warn(clippy::print_stdout)]

pub mod files;
pub mod panic;
pub mod process;
