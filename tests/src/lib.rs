//! What the integration tests share: where the workspace and its optional test data are.

pub mod fuzz;

use std::path::{Path, PathBuf};

pub use dotgen_loaders::shared;

/// The root of the workspace.
pub fn workspace_root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map_or_else(PathBuf::new, Path::to_path_buf)
}
