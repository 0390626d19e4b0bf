//! The interface of the analysis to the outside world: texts of files, and flags of packages.

use camino::{Utf8Path, Utf8PathBuf};
use smol_str::SmolStr;

use crate::release::ReleaseChoice;

/// The content of a path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FileContent {
    /// A readable text.
    Text(String),
    /// The path does not exist.
    Missing,
    Directory,
    /// A file that is not UTF-8, with its text decoded by `dotgen_syntax::encoding::decode`.
    NotUtf8(String),
    /// The path cannot be read; the reason.
    Unreadable(String),
}

/// The flags of packages from the package tool.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PackageFlags {
    /// From `-I`, in order.
    pub include_dirs: Vec<Utf8PathBuf>,
    /// From `-D`, in order: name and value.
    pub defines: Vec<(SmolStr, SmolStr)>,
    /// Packages that are not installed and are replaced by definitions that come with dotgen.
    pub own: Vec<String>,
}

/// All input and output of the analysis. Called at most once per path or query until a `Change` invalidates
/// it.
pub trait Loader: Send + Sync {
    fn read(&self, path: &Utf8Path) -> FileContent;
    /// The flags of packages, all arguments in one query, as printed by `pkg-config --cflags`.
    ///
    /// # Errors
    /// Returns a message for the user.
    fn packages(&self, arguments: &[String]) -> Result<PackageFlags, String>;
    /// The size of a file in bytes, if it is known without reading the file.
    fn size(&self, _path: &Utf8Path) -> Option<u64> {
        None
    }
    /// The entries of a directory, for the completion of paths; empty if it cannot be read.
    fn list_dir(&self, _path: &Utf8Path) -> Vec<DirEntry> {
        Vec::new()
    }
    /// The release of the installed GenoM3, if one is found.
    fn installed_release(&self) -> Option<ReleaseChoice> {
        None
    }
    /// Names of the available packages, for completion.
    fn package_names(&self) -> Vec<String> {
        Vec::new()
    }
}

/// An entry of a directory.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct DirEntry {
    pub name: String,
    /// True if it is a directory.
    pub is_dir: bool,
}
