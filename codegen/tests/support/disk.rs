//! The disk and the package tool, for tests.

use std::process::Command;

use camino::Utf8Path;
use dotgen_analysis::host::{FileContent, Loader, PackageFlags};

pub(crate) struct Disk;

impl Loader for Disk {
    fn read(&self, path: &Utf8Path) -> FileContent {
        dotgen_loaders::Disk.read(path)
    }

    fn packages(&self, arguments: &[String]) -> Result<PackageFlags, String> {
        let tool = std::env::var("PKG_CONFIG").unwrap_or_else(|_| "pkg-config".into());
        let output = Command::new(tool).arg("--cflags").args(arguments).output();
        let output = output.map_err(|error| error.to_string())?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned());
        }
        let mut flags = PackageFlags::default();
        for word in String::from_utf8_lossy(&output.stdout).split_whitespace() {
            if let Some(dir) = word.strip_prefix("-I") {
                flags.include_dirs.push(dir.into());
            }
        }
        Ok(flags)
    }
}
