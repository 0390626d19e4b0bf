//! Bundles the manual's pages of diagnostics with the program: a table of codes and texts.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

fn main() -> std::io::Result<()> {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default());
    let pages = root.join("../docs/diagnostics");
    println!("cargo::rerun-if-changed={}", pages.display());
    let mut found = Vec::new();
    collect(&pages, "", &mut found)?;
    found.sort();
    let mut out = String::from("&[\n");
    for (code, path) in found {
        let _ = writeln!(out, "    ({code:?}, include_str!({:?})),", path.display());
    }
    out.push_str("]\n");
    let target = PathBuf::from(std::env::var("OUT_DIR").unwrap_or_default());
    std::fs::write(target.join("pages.rs"), out)
}

/// The pages in a directory, by code: the name of a page is its code.
fn collect(
    directory: &Path,
    group: &str,
    found: &mut Vec<(String, PathBuf)>,
) -> std::io::Result<()> {
    println!("cargo::rerun-if-changed={}", directory.display());
    for entry in std::fs::read_dir(directory)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            collect(&path, &format!("{group}{name}/"), found)?;
        } else if let Some(name) = name.strip_suffix(".md")
            && name != "README"
        {
            found.push((format!("{group}{name}"), path.canonicalize()?));
        }
    }
    Ok(())
}
