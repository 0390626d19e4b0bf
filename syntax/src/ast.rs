//! Typed view of the tree.
//!
//! Every accessor returns an `Option` or an iterator, since any part may be missing in incomplete text. The
//! nodes are generated from `genom.ungram`; [`ext`] adds the accessors that the grammar file cannot express.
//! A token that comes out of a macro has no text in the tree: read texts through the
//! [`ExpansionMap`](crate::ExpansionMap) of the tree, as the methods with a `map` parameter do.

mod ext;
mod generated;
#[cfg(test)]
mod generator;
mod traits;

pub use ext::*;
pub use generated::*;
pub use traits::{AstChildren, AstNode, HasBody, support};
