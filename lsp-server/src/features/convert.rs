//! Answers of analysis as values of the protocol, where that takes a snapshot.

pub(crate) mod diagnostic;
pub(crate) mod edit;
