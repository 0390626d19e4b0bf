//! What the command line and the editor both show.

pub mod manual;
pub(crate) mod model;
pub mod pictures;
