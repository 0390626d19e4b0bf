//! The shared test data, which is not part of the repository.
//!
//! Depends on nothing: crates below `dotgen-loaders`, and `xtask`, include this file as a module.

use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The variable that names the folder of the data, or is `none`.
const VARIABLE: &str = "DOTGEN_SHARED";

/// The variable that names the file to which uses of the data are added.
const LOG: &str = "DOTGEN_SHARED_LOG";

/// A file or folder of the shared test data; the empty name is the data itself.
///
/// The data is in the folder that the environment variable `DOTGEN_SHARED` names. If the variable is not set,
/// it is in `../shared`, next to the workspace; if it is `none`, there is no data. Tests that need it return
/// when this is `None`; the reason is printed.
pub fn shared(name: &str) -> Option<PathBuf> {
    let found = place().map(|place| place.join(name));
    let found = found.filter(|path| path.exists());
    let found = found.and_then(|path| path.canonicalize().ok());
    if found.is_none() {
        eprintln!("SKIPPED: no shared test data `{name}`; {VARIABLE} names its folder");
    }
    log(name, found.is_some());
    found
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

/// Adds a line to the log: program, its folder, the test, and the use of the data. `cargo xtask test` reads
/// it.
fn log(name: &str, found: bool) {
    let Some(path) = std::env::var_os(LOG) else {
        return;
    };
    let program = std::env::current_exe().unwrap_or_default();
    let folder = std::env::current_dir().unwrap_or_default();
    let thread = std::thread::current();
    let line = format!(
        "{}\t{}\t{}\t{name}\t{}\n",
        program.display(),
        folder.display(),
        thread.name().unwrap_or("main"),
        if found { "found" } else { "missing" },
    );
    let file = std::fs::OpenOptions::new().append(true).create(true).open(path);
    // One write a line: lines of several tests do not mix.
    let _ = file.and_then(|mut file| file.write_all(line.as_bytes()));
}
