//! The state that requests are answered from: open documents, folders with their configuration, templates,
//! and the [`snapshot`] of them.

pub(crate) mod codels;
pub(crate) mod documents;
pub(crate) mod folders;
pub(crate) mod snapshot;
pub(crate) mod templates;
