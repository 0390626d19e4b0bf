//! Files that a command writes beside its report: logs and traces.

use anyhow::bail;
use camino::{Utf8Path, Utf8PathBuf};

/// Looks at the files to be written, before anything is done.
///
/// # Errors
///
/// One of them is a directory, is among those that the command has `read`, or is given twice.
pub(super) fn check<'f>(
    outputs: &[&Utf8Path],
    read: impl IntoIterator<Item = &'f Utf8Path>,
) -> anyhow::Result<()> {
    if outputs.is_empty() {
        return Ok(());
    }
    let read: Vec<Identity> = read.into_iter().map(Identity::of).collect();
    let mut before: Vec<Identity> = Vec::new();
    for path in outputs {
        if path.is_dir() {
            bail!("`{path}` is a directory; name a file to be written");
        }
        let identity = Identity::of(path);
        if read.contains(&identity) {
            bail!("`{path}` is read by this command and would be lost; name another file");
        }
        if before.contains(&identity) {
            bail!("`{path}` is to get two contents; name two files");
        }
        before.push(identity);
    }
    Ok(())
}

/// What a path leads to, however it is spelled.
#[derive(PartialEq, Eq)]
enum Identity {
    /// Device and number: hard links too lead to the same.
    #[cfg(unix)]
    File(u64, u64),
    Path(Utf8PathBuf),
}

impl Identity {
    fn of(path: &Utf8Path) -> Identity {
        #[cfg(unix)]
        if let Ok(file) = path.metadata() {
            use std::os::unix::fs::MetadataExt;
            return Identity::File(file.dev(), file.ino());
        }
        let whole = path.canonicalize_utf8().or_else(|_| {
            // It is not there yet, but its folder may be.
            let folder = path.parent().filter(|it| !it.as_str().is_empty());
            let folder = folder.unwrap_or(Utf8Path::new(".")).canonicalize_utf8()?;
            Ok::<_, std::io::Error>(folder.join(path.file_name().unwrap_or_default()))
        });
        Identity::Path(whole.unwrap_or_else(|_| path.to_owned()))
    }
}
