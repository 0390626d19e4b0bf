//! Answers as data that the command line and editors show: pictures, the model, the manual, verification.

pub mod manual;
pub mod model;
pub mod pictures;
pub mod verification;
