//! The shared test data, which is not part of the repository, and the record of tests that could not run.
//!
//! Depends on nothing: crates below `dotgen-loaders`, and `xtask`, include this file as a module.

use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The variable that names the folder of the data, or is `none`.
const VARIABLE: &str = "DOTGEN_SHARED";

/// The variable that names the file to which skipped tests are added.
pub const SKIPPED: &str = "DOTGEN_SKIPPED";

/// Beginning of the reason of a test that lacks data of others.
pub const NO_DATA: &str = "no data";

/// A file or folder of the shared test data, which the test needs; the empty name is the data itself. `None`:
/// the test is recorded as skipped, and returns.
///
/// The data is in the folder that the environment variable `DOTGEN_SHARED` names. If the variable is not set,
/// it is in `../shared`, next to the workspace; if it is `none`, there is no data.
pub fn shared(name: &str) -> Option<PathBuf> {
    let found = optional(name);
    if found.is_none() {
        skip(format_args!("{NO_DATA}: {VARIABLE} names no folder with `{name}`"));
    }
    found
}

/// A file or folder of the shared test data that a test uses besides its own.
pub fn optional(name: &str) -> Option<PathBuf> {
    let found = place()?.join(name);
    if found.exists() { found.canonicalize().ok() } else { None }
}

/// The folder of the data, which need not exist.
fn place() -> Option<PathBuf> {
    match std::env::var_os(VARIABLE) {
        Some(folder) if folder == "none" => None,
        Some(folder) if !folder.is_empty() => Some(PathBuf::from(folder)),
        _ => {
            let here = Path::new(env!("CARGO_MANIFEST_DIR"));
            let workspace = here.ancestors().find(|folder| folder.join("Cargo.lock").is_file())?;
            Some(workspace.parent()?.join("shared"))
        }
    }
}

/// Records that the current test cannot run, or not in full. The test runner counts it as passed; `cargo
/// xtask test` counts it as skipped. The message is printed even if the runner captures the output.
pub fn skip(reason: impl std::fmt::Display) {
    let reason = reason.to_string();
    let thread = std::thread::current();
    // A test without its own thread has no name.
    let test = thread.name().unwrap_or("main");
    let _ = writeln!(std::io::stderr(), "skipped: {test}: {reason}");
    let Some(path) = std::env::var_os(SKIPPED) else {
        return;
    };
    let program = std::env::current_exe().unwrap_or_default();
    let program = program.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let line = format!("{program}\t{test}\t{}\n", reason.replace('\n', " "));
    let file = std::fs::OpenOptions::new().append(true).create(true).open(path);
    // One write a line: lines of several tests do not mix.
    let _ = file.and_then(|mut file| file.write_all(line.as_bytes()));
}
