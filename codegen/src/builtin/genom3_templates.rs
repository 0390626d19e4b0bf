//! The templates of GenoM3 itself, recognised by their contents.

use std::path::Path;

use dotgen_analysis::release::Release;
use md5::{Digest, Md5};

use crate::disk::{Disk, Entry};

/// Name, release, and the digest of the installed files: for each file, in order of names, its name, a zero,
/// its text and a zero.
const KNOWN: &[(&str, Release, &str)] = &[
    ("mappings", Release::V2_99_39, "17b35f65014b0ee83bf04d5d87db8c81"),
    ("mappings", Release::V2_99_41, "3cb4154a274e20d5d7c0f5bbe9dee8e7"),
    ("skeleton", Release::V2_99_39, "afa3ee302fe9efe0fb2fd9ffe5cb7933"),
    ("skeleton", Release::V2_99_41, "a31c58e10c829415f0838bc2eecef611"),
];

/// The file that installs the folder of a source tree. It is not installed itself.
const INSTALLER: &str = "Makefile.am";

/// The template and release of a folder, if the folder contains exactly its files.
pub(super) fn template(disk: &dyn Disk, dir: &Path) -> Option<(&'static str, Release)> {
    let mut files = Vec::new();
    for Entry { path, is_dir } in disk.list(dir).ok()? {
        if is_dir || disk.is_link(&path) || !disk.is_file(&path) {
            return None;
        }
        let name = path.file_name()?.to_str()?.to_owned();
        if name != INSTALLER {
            files.push((name, path));
        }
    }
    files.sort();
    // Known templates have at most a dozen files.
    if files.len() > 32 {
        return None;
    }
    let mut digest = Md5::new();
    for (name, path) in files {
        digest.update(name.as_bytes());
        digest.update([0]);
        digest.update(disk.read(&path).ok()?);
        digest.update([0]);
    }
    let digest: String = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    let known = KNOWN.iter().find(|triple| triple.2 == digest);
    known.map(|triple| (triple.0, triple.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::Files;

    #[test]
    fn a_folder_with_other_contents_is_not_known() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(template(&Files, dir.path()), None);
        std::fs::write(dir.path().join("template.tcl"), "puts {}").unwrap();
        assert_eq!(template(&Files, dir.path()), None);
        assert_eq!(template(&Files, Path::new("/nowhere")), None);
    }
}
