//! `cargo xtask package`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::extension::{self, Profile};
use crate::run;

/// Makes the platform `.vsix` that users install.
pub(crate) fn package() -> Result<PathBuf> {
    let built = extension::build_server(Profile::Release)?;
    let server = stripped(&built)?;
    let vsix = extension::package(&server)?;
    let size = vsix.metadata()?.len() as f64 / 1e6;
    println!("{} ({size:.1} MB)", vsix.display());
    println!(
        "Install it with: code --install-extension {}",
        vsix.display()
    );
    Ok(vsix)
}

/// A copy without debugging information, which is most of the size; the program as it is where there is no `strip`.
fn stripped(program: &Path) -> Result<PathBuf> {
    let directory = crate::target().join("package");
    std::fs::create_dir_all(&directory)?;
    let copy = directory.join(program.file_name().context("a program has a name")?);
    let arguments = ["-o", &*copy.to_string_lossy(), &*program.to_string_lossy()];
    match run::capture(run::command(crate::root(), "strip", &arguments)) {
        Ok(_) => Ok(copy),
        Err(_) => {
            eprintln!("    no strip on PATH: the package holds debugging information");
            Ok(program.to_owned())
        }
    }
}
