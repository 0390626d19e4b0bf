//! Components that run with their own codels: one process for each, which is this program again.
//!
//! | file | what it has |
//! | --- | --- |
//! | [`wire`] | what the engine and a host say to each other |
//! | [`host`] | a host: it loads a shared object and calls its codels |
//! | [`library`] | the shared object, and all that is unsafe about calling it |
//! | [`children`] | the engine's side: starts hosts, talks to them, knows how they ended |
//! | [`board`] | the data of a port, in memory that engine and hosts share |
//! | [`server`] | requests from outside, as JSON over a socket |
//! | [`known`] | what is known of the components of a run |
//! | `network` | ports between machines, by Zenoh; with the feature `zenoh` |
//! | [`stream`] | a connection with a client |
//! | [`places`] | where the sockets of this user are |
//! | [`realtime`] | what the system grants to who has to be in time |
//! | [`strays`] | processes that codels leave behind |

pub mod children;
mod clients;
pub mod components;
mod debugger;
pub mod host;
mod library;
#[cfg(feature = "zenoh")]
pub mod network;
pub mod orphans;
pub mod realtime;
pub mod server;
mod shared_data;
pub mod sockets;
mod stream;
mod wire;
