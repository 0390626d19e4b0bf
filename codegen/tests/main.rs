//! The tests of this crate, in one program: it is linked once.

mod builtin;
mod codels;
mod readable_files;
mod ros;
mod search;
mod template_files;
mod templates;
