//! The tests of this crate, in one program: it is linked once.

mod codes;
mod conformance;
mod lints;
mod mistakes;
mod model;
mod reference;
mod robust;
