//! What the integration tests share: where the workspace and its optional test data are.

pub mod fuzz;

use std::path::{Path, PathBuf};

/// The root of the workspace.
pub fn workspace_root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .map_or_else(PathBuf::new, Path::to_path_buf)
}

/// A folder of the shared test data that may lie beside the workspace (`../shared`).
///
/// Tests that need it call this first and return when it is `None`; the reason is printed.
pub fn shared(folder: &str) -> Option<PathBuf> {
    let path = workspace_root().join("../shared").join(folder);
    if path.exists() {
        Some(path)
    } else {
        eprintln!("SKIPPED: no test data at ../shared/{folder}");
        None
    }
}
