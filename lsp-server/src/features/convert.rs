//! Conversions from answers of analysis to values of the protocol that need a snapshot.

pub(crate) mod diagnostic;
pub(crate) mod edit;
