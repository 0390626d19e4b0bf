//! The tests of this crate, in one program: it is linked once.

mod architecture;
mod book;
mod fuzz;
mod manual;
mod sources;
