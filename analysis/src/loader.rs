//! What analysis asks of the world outside: texts of files, and what packages bring.

use camino::{Utf8Path, Utf8PathBuf};
use smol_str::SmolStr;

use crate::release::ReleaseChoice;

/// What a path leads to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FileContent {
    /// A readable text.
    Text(String),
    /// Nothing is there.
    Missing,
    /// A directory.
    Directory,
    /// A file that is not UTF-8: its text as of `dotgen_syntax::encoding::decode`.
    NotUtf8(String),
    /// It cannot be read: why.
    Unreadable(String),
}

/// What the package tool says about packages.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PackageFlags {
    /// From `-I`, in order.
    pub include_dirs: Vec<Utf8PathBuf>,
    /// From `-D`, in order: name and value.
    pub defines: Vec<(SmolStr, SmolStr)>,
    /// Packages that are not installed, and instead of which definitions of dotgen's own are found.
    pub own: Vec<String>,
}

/// All input and output of analysis. Called at most once per path or question until a [`Change`]
/// says otherwise.
pub trait Loader: Send + Sync {
    /// Reads a file.
    fn read(&self, path: &Utf8Path) -> FileContent;
    /// The flags of packages, all arguments in one query, as `pkg-config --cflags` answers it.
    /// The error is a message for the user.
    fn packages(&self, arguments: &[String]) -> Result<PackageFlags, String>;
    /// The size of a file in bytes, if that can be told without reading it.
    fn size(&self, _path: &Utf8Path) -> Option<u64> {
        None
    }
    /// What a directory holds, for the completion of paths; empty if it cannot be read.
    fn list_dir(&self, _path: &Utf8Path) -> Vec<DirEntry> {
        Vec::new()
    }
    /// The release of the GenoM3 that is installed, if one is found.
    fn installed_release(&self) -> Option<ReleaseChoice> {
        None
    }
    /// Names of the packages that can be asked for, for completion.
    fn package_names(&self) -> Vec<String> {
        Vec::new()
    }
}

/// An entry of a directory.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct DirEntry {
    /// Its name.
    pub name: String,
    /// Whether it is a directory.
    pub is_dir: bool,
}
