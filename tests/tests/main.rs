//! The tests of this crate, in one program: it is linked once.

mod architecture;
mod fuzz;
mod manual;
mod sources;
