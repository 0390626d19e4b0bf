//! What a confined run reaches: the one place that compares paths with what is allowed.
//!
//! The interpreter is confined by the system. What the engine reads and writes for it is checked here, by
//! the same folders.

use std::path::{Component, Path, PathBuf};

use super::Failure;
use super::discover::SearchPath;
use crate::disk::Disk;
use crate::process::Access;

/// What may be read.
#[derive(Debug, Clone)]
pub(crate) struct Reach {
    read: Vec<PathBuf>,
    tmpdir: PathBuf,
}

impl Reach {
    /// Of a template in `dir` that is told `words`: its own folder and those beside it, the files that
    /// words name, and the temporary folder.
    pub(crate) fn new(
        disk: &dyn Disk,
        dir: &Path,
        search: &SearchPath,
        base: &Path,
        words: &[String],
        tmpdir: &Path,
    ) -> Reach {
        let folders = search.dirs.iter().chain(&search.builtin);
        let folders = folders.map(PathBuf::as_path).chain([dir, tmpdir]);
        let files = words
            .iter()
            .map(|it| base.join(it))
            .filter(|it| disk.is_file(it));
        let read = folders.map(Path::to_owned).chain(files);
        Reach {
            read: read.filter_map(|it| disk.canonical(&it).ok()).collect(),
            tmpdir: tmpdir.to_owned(),
        }
    }

    /// The same for the system.
    pub(crate) fn access(&self) -> Access {
        Access {
            read: self.read.clone(),
            write: vec![self.tmpdir.clone()],
        }
    }

    /// Refuses to read a file elsewhere. What cannot be found at all is for others to tell.
    pub(crate) fn check_read(&self, disk: &dyn Disk, path: &Path) -> Result<(), Failure> {
        match disk.canonical(path) {
            Ok(path) if !self.read.iter().any(|it| path.starts_with(it)) => {
                Err(Failure::Error(format!(
                    "\"{}\" is not to be read by a confined template: it is neither a file of a template \
                     nor an input",
                    path.display()
                )))
            }
            _ => Ok(()),
        }
    }
}

/// Whether a file, were it written, would be below one of the folders, whatever links there are on the way.
pub(crate) fn is_below(disk: &dyn Disk, path: &Path, folders: &[PathBuf]) -> bool {
    let Some(path) = resolve(disk, path) else {
        return false;
    };
    folders
        .iter()
        .any(|it| resolve(disk, it).is_some_and(|it| path.starts_with(it)))
}

/// Whether a path has a part that begins with a dot below all of the folders around the path, whatever links
/// there are on the way. Such files configure tools, shells and editors: `.git/hooks`, `.vscode`, `.profile`.
pub(crate) fn is_hidden(disk: &dyn Disk, path: &Path, folders: &[PathBuf]) -> bool {
    let parts = |path: &Path, folders: &[PathBuf]| {
        let below = folders.iter().filter_map(|it| path.strip_prefix(it).ok());
        below
            .map(|rest| {
                let mut parts = rest.components();
                parts.any(|part| part.as_os_str().as_encoded_bytes().starts_with(b"."))
            })
            .reduce(|one, other| one && other)
    };
    let named: Vec<PathBuf> = folders.iter().map(|it| plain(disk, it)).collect();
    let real: Vec<PathBuf> = folders.iter().filter_map(|it| resolve(disk, it)).collect();
    let by_links = resolve(disk, path).and_then(|path| parts(&path, &real));
    by_links.unwrap_or(true) || parts(&plain(disk, path), &named).unwrap_or(false)
}

/// The path without links, of which the last parts need not exist. `None` for a link that leads nowhere:
/// a file that is written there would come to be where it points.
fn resolve(disk: &dyn Disk, path: &Path) -> Option<PathBuf> {
    let path = plain(disk, path);
    for ancestor in path.ancestors() {
        if let Ok(real) = disk.canonical(ancestor) {
            let rest = path.strip_prefix(ancestor).ok()?;
            return Some(match rest.as_os_str().is_empty() {
                true => real,
                false => real.join(rest),
            });
        }
        if disk.is_link(ancestor) {
            return None;
        }
    }
    Some(disk.absolute(&path))
}

/// The path without `.` and `..`, absolute.
pub(crate) fn plain(disk: &dyn Disk, path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for component in disk.absolute(path).components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                out.pop();
            }
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::Files;

    #[cfg(unix)]
    #[test]
    fn links_lead_where_they_lead() {
        use std::os::unix::fs::symlink;
        let dir = tempfile::tempdir().unwrap();
        let root = dir.path().join("root");
        std::fs::create_dir(&root).unwrap();
        std::fs::create_dir(dir.path().join("other")).unwrap();
        symlink("../other", root.join("out")).unwrap();
        symlink("../missing", root.join("nowhere")).unwrap();
        symlink("sub", root.join("inner")).unwrap();
        std::fs::create_dir(root.join("sub")).unwrap();
        let below = |path: &str| is_below(&Files, &root.join(path), std::slice::from_ref(&root));
        for path in ["a", "a/b/c", "x/../a", "inner/a", "sub/new/a"] {
            assert!(below(path), "{path}");
        }
        for path in [
            "../a",
            "x/../../a",
            "out/a",
            "out/../a/../../b",
            "nowhere",
            "nowhere/a",
            "/a",
        ] {
            assert!(!below(path), "{path}");
        }
        // A folder that is to be made is where it will be.
        assert!(is_below(
            &Files,
            &root.join("out/new/a"),
            &[root.join("out/new")]
        ));
        let hidden = |path: &str| is_hidden(&Files, &root.join(path), std::slice::from_ref(&root));
        std::fs::create_dir(root.join(".git")).unwrap();
        symlink(".git", root.join("plain")).unwrap();
        symlink("sub", root.join(".link")).unwrap();
        for path in [
            ".a",
            ".git/hooks/x",
            "sub/.b/c",
            "plain/hooks/x",
            "inner/.d",
            ".link/e",
        ] {
            assert!(hidden(path), "{path}");
        }
        for path in ["a", "inner/a", ".git/../a", "sub/b.c/d"] {
            assert!(!hidden(path), "{path}");
        }
        // The folder itself may be hidden.
        let folders = [root.clone(), root.join(".git")];
        assert!(!is_hidden(&Files, &root.join(".git/a"), &folders));
        // A folder whose name begins alike is another one.
        assert!(!is_below(&Files, &dir.path().join("root2/a"), &[root]));
    }
}
