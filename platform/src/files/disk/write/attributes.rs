//! Attributes of a file that replaces another one: owner, permissions, and extended attributes. A file with
//! several names is not replaced.

use std::fs::{File, Metadata};
use std::io;
use std::path::Path;

/// Sets the attributes to those of the old file, as far as permitted.
#[cfg(unix)]
pub(super) fn set(
    file: &File,
    mode: Option<u32>,
    target: &Path,
    old: Option<&Metadata>,
) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
    let mut mode = mode;
    if let Some(old) = old {
        let now = file.metadata()?;
        mode = mode.or(Some(old.mode() & 0o7777));
        let kept = (now.uid(), now.gid()) == (old.uid(), old.gid())
            || fchown(file, Some(old.uid()), Some(old.gid())).is_ok();
        if !kept {
            // A group can be set by its members.
            let _ = fchown(file, None, Some(old.gid()));
            // A file that ran with the rights of its owner must not run with the rights of this user.
            mode = mode.map(|mode| mode & 0o1777);
        }
        copy_extended(target, file);
    }
    match mode {
        Some(mode) => file.set_permissions(std::fs::Permissions::from_mode(mode)),
        None => Ok(()),
    }
}

#[cfg(not(unix))]
pub(super) fn set(_: &File, _: Option<u32>, _: &Path, _: Option<&Metadata>) -> io::Result<()> {
    Ok(())
}

/// Maximum size of a list of names, and of a value, on Linux.
#[cfg(any(target_os = "linux", target_os = "macos"))]
const MAX_EXTENDED: usize = 1 << 16;

/// Copies the extended attributes that the file system and the rights of this user permit. The rights of an
/// executable (`security.capability`) end with its content, as they do when a file is written in place.
#[cfg(any(target_os = "linux", target_os = "macos"))]
fn copy_extended(from: &Path, to: &File) {
    use rustix::fs::{XattrFlags, fgetxattr, flistxattr, fsetxattr};
    let Ok(old) = File::open(from) else { return };
    let (mut names, mut value) = (vec![0; MAX_EXTENDED], vec![0; MAX_EXTENDED]);
    let count = flistxattr(&old, &mut names).unwrap_or(0);
    let names = names[..count].split(|byte| *byte == 0);
    for name in names.filter(|name| !name.is_empty() && *name != b"security.capability") {
        if let Ok(size) = fgetxattr(&old, name, &mut value) {
            let _ = fsetxattr(to, name, &value[..size], XattrFlags::empty());
        }
    }
}

#[cfg(all(unix, not(any(target_os = "linux", target_os = "macos"))))]
fn copy_extended(_: &Path, _: &File) {}

/// Fails for a file with several names (hard links): a new file would take the place of one of them, and the
/// others would keep the old content. `is_second` recognizes the names that writers give for a while.
#[cfg(unix)]
pub(super) fn has_one_name(target: &Path, is_second: &dyn Fn(&str) -> bool) -> io::Result<()> {
    use std::os::unix::fs::MetadataExt;
    let Ok(metadata) = std::fs::metadata(target) else { return Ok(()) };
    if !metadata.is_file() || metadata.nlink() < 2 {
        return Ok(());
    }
    let entries = std::fs::read_dir(super::directory_of(target)).into_iter().flatten().flatten();
    let seconds = entries.filter(|entry| {
        is_second(&entry.file_name().to_string_lossy())
            && entry.metadata().is_ok_and(|other| other.ino() == metadata.ino())
    });
    let names = metadata.nlink().saturating_sub(seconds.count() as u64);
    if names > 1 {
        Err(io::Error::other(format!(
            "it has {names} names (hard links), and the others would keep the old text; \
         replace it by a copy of its own"
        )))
    } else {
        Ok(())
    }
}

#[cfg(not(unix))]
pub(super) fn has_one_name(_: &Path, _: &dyn Fn(&str) -> bool) -> io::Result<()> {
    Ok(())
}

#[cfg(all(test, unix))]
mod tests {
    use dotgen_codegen::disk::NewContent;

    use super::super::{OLD, SUFFIX, WatchedMoves, write};

    /// The result of writing one file.
    fn written(path: &std::path::Path) -> Result<(), String> {
        let files = [NewContent::new(path.to_owned(), b"new\n".to_vec())];
        let done = write(&files, &mut WatchedMoves::default(), &mut |_| Ok(()));
        done.map_err(|error| error.to_string())
    }

    #[test]
    fn a_file_with_several_names_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let [file, other] = ["a.gen", "b.gen"].map(|name| folder.path().join(name));
        std::fs::write(&file, "old\n").expect("written");
        std::fs::hard_link(&file, &other).expect("linked");
        let error = written(&file).expect_err("both names have the text");
        assert!(error.contains("it has 2 names (hard links)"), "{error}");
        assert_eq!(std::fs::read_to_string(&file).expect("read"), "old\n");
        // The second name that a writer gave is not a name of the user.
        std::fs::rename(&other, folder.path().join(format!("{OLD}1{SUFFIX}"))).expect("renamed");
        written(&file).expect("written");
        assert_eq!(std::fs::read_to_string(&file).expect("read"), "new\n");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn extended_attributes_are_kept() {
        use rustix::fs::{XattrFlags, getxattr, setxattr};
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("a.gen");
        std::fs::write(&file, "old\n").expect("written");
        // Not every file system has them.
        if setxattr(&file, "user.dotgen", b"kept", XattrFlags::empty()).is_err() {
            return;
        }
        written(&file).expect("written");
        let mut value = [0; 8];
        let size = getxattr(&file, "user.dotgen", &mut value).expect("the attribute");
        assert_eq!(&value[..size], b"kept");
    }
}
