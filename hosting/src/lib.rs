//! Components that run with their own codels. Each component is one process, which is this program again.
//!
//! | module | contents |
//! | --- | --- |
//! | [`wire`] | the messages between the engine and a host |
//! | [`host`] | a host: loads a shared object and calls its codels |
//! | [`library`] | the shared object, and all unsafe code that calls its functions |
//! | [`children`] | the engine's side: starts hosts, sends commands, and reports how they ended |
//! | [`memory`] | memory that the engine shares with hosts |
//! | [`executing`] | the codels that threads execute, in such memory |
//! | [`clock`] | the clock of the engine and the hosts |
//! | [`shared_data`] | the data of a port, in memory that the engine shares with hosts |
//! | [`server`] | requests from outside, as JSON over a socket |
//! | [`clients`] | the clients of the socket, and their limits |
//! | [`components`] | the components of a run, as clients see them |
//! | `network` | ports between machines, by Zenoh; with the feature `zenoh` |
//! | [`remote`] | components of runs on other machines |
//! | `ros2` | components as ROS 2 nodes, by Zenoh; with the feature `zenoh` |
//! | [`stream`] | a connection with a client |
//! | [`sockets`] | the paths of the sockets of this user |
//! | [`realtime`] | real-time priority, cores and locked memory |
//! | [`orphans`] | processes that codels leave behind |
//! | [`debugger`] | hosts under a debugger |

pub mod children;
mod clients;
mod clock;
pub mod components;
mod debugger;
mod executing;
pub mod host;
mod library;
mod memory;
#[cfg(feature = "zenoh")]
pub mod network;
pub mod orphans;
pub mod realtime;
pub mod remote;
#[cfg(feature = "zenoh")]
pub mod ros2;
pub mod server;
mod shared_data;
pub mod sockets;
mod stream;
mod wire;
