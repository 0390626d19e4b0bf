//! Instantiation: names, types and expressions of a model become addresses and code.

pub(crate) mod ceilings;
mod declarations;
pub(crate) mod edges;
mod expressions;
mod functions;
mod instances;
pub(crate) mod scope;

pub(crate) use instances::system;
