//! The tests of this crate, in one program: it is linked once.

mod build;
mod cli;
mod conventions;
mod data;
mod debug;
#[path = "support/directory.rs"]
mod directory;
mod ends;
mod examples;
mod faults;
mod first_hour;
mod fixing;
mod flight;
mod ground;
mod hosted;
mod hostile;
mod inputs;
mod interfaces;
mod listening;
mod machines;
mod mcp;
mod measure;
mod monitor;
mod needs;
mod network;
mod new;
mod packaging;
mod pictures;
mod processes;
mod protocol;
mod published;
mod python;
mod query;
mod recordings;
mod releases;
mod remote;
mod replay;
mod ros2;
mod ros2_interfaces;
mod run;
#[path = "support/running.rs"]
mod running;
mod scenario_import;
#[path = "support/server.rs"]
mod server;
mod socket;
mod stdio;
mod trace;
mod tutorial;
mod verify;
mod worst_cases;
mod writing;
