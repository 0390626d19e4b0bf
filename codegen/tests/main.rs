//! The tests of this crate, in one program: it is linked once.

mod builtin;
mod codels;
#[path = "support/disk.rs"]
mod disk;
#[path = "support/files.rs"]
mod files;
#[path = "support/processes.rs"]
mod processes;
mod ros;
mod search;
mod template_files;
mod templates;
