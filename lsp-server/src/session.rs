//! One client: messages from bytes, requests in order, the writer that owns the state, and the notifications
//! to the client.

pub(crate) mod backend;
mod capabilities;
mod component;
mod dispatch;
mod post;
mod publish;
mod requests;
pub mod server;
mod transport;
mod verifier;
mod writer;
