//! Views that the command line and the editor share.

pub mod manual;
pub(crate) mod model;
pub mod pictures;
