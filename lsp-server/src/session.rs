//! One client: bytes to messages, requests in order, the writer that owns the state, and what the client is
//! told unasked.

pub(crate) mod backend;
mod capabilities;
mod component;
mod dispatch;
mod post;
mod publish;
mod requests;
pub(crate) mod server;
mod transport;
mod verifier;
mod writer;
