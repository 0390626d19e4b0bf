//! What the commands of the project share: running programs, the tools they need, the extension. The
//! measurements in
//! `bench/`, a workspace of their own, use it as well.

pub mod extension;
pub mod run;
#[path = "../../tests/loaders/src/shared.rs"]
pub mod shared;
pub mod tools;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The exit status of a command: 1 if it found something, 2 if it failed, after its message.
pub fn exit(result: anyhow::Result<bool>) -> ExitCode {
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

/// The root of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask/ is in the root")
}

/// The build directory.
pub fn target() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(directory) => root().join(directory),
        None => root().join("target"),
    }
}

/// The example workspace.
pub fn example() -> PathBuf {
    root().join("examples/maneuver")
}
