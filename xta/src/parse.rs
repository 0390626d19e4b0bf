//! Recursive descent from tokens to syntax trees.

mod cursor;
mod declarations;
mod expressions;
mod processes;
mod queries;
mod statements;

pub(crate) use processes::model;
pub(crate) use queries::queries;
