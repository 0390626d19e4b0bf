//! Where the specifications of tests and benchmarks come from: one copy of each loader, for every crate.

pub mod pages;
mod shared;

use std::io::ErrorKind;
use std::sync::Arc;

use camino::Utf8Path;
use dotgen_analysis::diagnostic::Severity;
use dotgen_analysis::host::{
    AnalysisHost, BatchInput, FileContent, Input, Loader, PackageFlags, UnitResult,
};

pub use shared::{NO_DATA, SKIPPED, optional, shared, skip};

/// A number of random cases: the ordinary one, which takes seconds, times the factor in the environment
/// variable
/// `DOTGEN_TIMES` (each night in continuous integration: 50).
pub fn times(ordinary: u64) -> u64 {
    let factor = std::env::var("DOTGEN_TIMES").ok();
    ordinary * factor.and_then(|factor| factor.parse().ok()).unwrap_or(1)
}

/// No file is there; every package is installed, without flags.
#[derive(Debug, Clone, Copy)]
pub struct EmptyLoader;

impl Loader for EmptyLoader {
    fn read(&self, _: &Utf8Path) -> FileContent {
        FileContent::Missing
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags::default())
    }
}

/// The files of the disk; every package is installed, without flags.
#[derive(Debug, Clone, Copy)]
pub struct Disk;

impl Loader for Disk {
    fn read(&self, path: &Utf8Path) -> FileContent {
        if path.is_dir() {
            return FileContent::Directory;
        }
        match std::fs::read(path) {
            Ok(bytes) => match String::from_utf8(bytes) {
                Ok(text) => FileContent::Text(text),
                Err(error) => {
                    FileContent::NotUtf8(String::from_utf8_lossy(error.as_bytes()).into_owned())
                }
            },
            Err(error) if error.kind() == ErrorKind::NotFound => FileContent::Missing,
            Err(error) => FileContent::Unreadable(error.to_string()),
        }
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags::default())
    }
}

/// A text as a specification that needs no other file.
///
/// # Errors
///
/// The message of its first error.
pub fn unit(text: &str) -> Result<UnitResult, String> {
    let input = BatchInput {
        inputs: vec![Input::Text { name: "test.gen".into(), text: text.into() }],
        ..BatchInput::default()
    };
    let host = AnalysisHost::new(Arc::new(EmptyLoader));
    let unit = host.analysis().batch(&input).expect("nobody cancels");
    let mut errors = unit.diagnostics.iter();
    match errors.find(|error| error.severity == Severity::Error) {
        Some(error) => Err(error.message.to_string()),
        None => Ok(unit),
    }
}
