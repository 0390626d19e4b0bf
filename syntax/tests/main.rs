//! The tests of this crate, in one program, so that it is linked only once.

mod braces;
mod conformance;
mod format;
mod parser;
mod preproc_disk;
mod robustness;
#[allow(unreachable_pub, reason = "public in dotgen-loaders")]
#[path = "../../tests/loaders/src/shared.rs"]
mod shared;
