//! The language server protocol: its types, messages beyond it, the client, and conversions between values of
//! the protocol and of analysis.

pub mod client;
pub mod convert;
pub mod messages;
pub(crate) mod outbox;
pub(crate) mod progress;
pub mod types;
pub(crate) mod user_result;
