//! Requests about specifications and the C and C++ sources of their codels: what `code_action`,
//! `code_lens`, `goto`, `references` and `rename` say of both sides.

pub(crate) mod actions;
pub(crate) mod headers;
pub(crate) mod lenses;
pub(crate) mod navigation;
