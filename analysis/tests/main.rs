//! The tests of this crate, in one program, so that it is linked only once.

mod codes;
mod conformance;
mod lints;
mod mistakes;
mod model;
mod reference;
mod robust;
