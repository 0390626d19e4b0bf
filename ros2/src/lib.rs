//! GenoM3 components as ROS 2 nodes, without I/O: names, type descriptions with their hashes, payloads, and
//! the keys and tokens of `rmw_zenoh` (ROS 2 Jazzy and later).
//!
//! | GenoM3 | ROS 2 |
//! | --- | --- |
//! | `::or::t3d::pos` | `or_t3d/msg/Pos`; types outside modules are in the package `genom_global` |
//! | `char`, `octet` | `int8`, `uint8` |
//! | enumeration | `uint32`; a message with constants only has the name of the enumeration |
//! | `optional<T>` | `T[<=1]` |
//! | `T[2][3]` | `T[6]` |
//! | other sequence or array of sequences, arrays or optionals | of a message with the field `data` |
//! | union | message of a `discriminator` and a `T[<=1]` for each branch |
//! | output port, input port | publisher and subscription of `/COMPONENT/PORT` |
//! | port of a number, `boolean` or `string` | message of `std_msgs` |
//! | function, attribute | service `/COMPONENT/SERVICE` |
//! | activity | action `/COMPONENT/ACTIVITY`; the feedback is the state |
//!
//! The response of a service and the result of an action have the outputs, a string `exception`, which is
//! empty after success, and a `T[<=1]` for each exception with members.
//!
//! A port has a [common](common) message instead if a [rule](rules) or `#pragma masquerade` says so.

pub mod cdr;
pub mod common;
pub mod conversion;
pub mod description;
pub mod interfaces;
pub mod mapping;
mod masquerade;
pub mod names;
pub mod node;
pub mod refusal;
pub mod remap;
pub mod rules;
mod scalar;
pub mod wire;

// The tests of the crate as others use it, in the program of the unit tests: each program takes seconds to
// link.
#[cfg(test)]
extern crate self as dotgen_ros2;
#[cfg(test)]
#[path = "../tests/main.rs"]
mod suite;
