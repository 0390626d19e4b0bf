//! `cargo xtask package`.

use std::path::PathBuf;

use anyhow::Result;

use xtask::extension::{self, Profile};

/// Makes the platform `.vsix` that users install.
pub(crate) fn package() -> Result<PathBuf> {
    let server = extension::build_server(Profile::Release)?;
    let vsix = extension::package(&server)?;
    let size = vsix.metadata()?.len() as f64 / 1e6;
    println!("{} ({size:.1} MB)", vsix.display());
    println!("Install it with: code --install-extension {}", vsix.display());
    Ok(vsix)
}
