//! Files that a command writes beside its report: logs and traces.

use anyhow::bail;
use camino::{Utf8Path, Utf8PathBuf};
use dotgen_codegen::codels::source::Grammar;

/// Ending of the names of traces that Perfetto opens.
pub(super) const PERFETTO: &str = "pftrace";

/// Ending of the names of traces for the trace viewer.
pub(super) const VIEWER: &str = "json";

/// Ending of the names of recordings that Foxglove opens.
pub(super) const MCAP: &str = "mcap";

/// A file to be written.
pub(super) struct Output<'f> {
    pub(super) path: &'f Utf8Path,
    /// What its name may end in; empty: in anything.
    pub(super) endings: &'static [&'static str],
}

/// Looks at the files to be written, before anything is done.
///
/// # Errors
///
/// One of them is a directory, has another ending, is among those that the command has `read`, is some other
/// source that is there already, or is given twice.
pub(super) fn check<'f>(
    outputs: &[Output<'_>],
    read: impl IntoIterator<Item = &'f Utf8Path>,
) -> anyhow::Result<()> {
    if outputs.is_empty() {
        return Ok(());
    }
    let read: Vec<Identity> = read.into_iter().map(Identity::of).collect();
    let mut before: Vec<Identity> = Vec::new();
    for &Output { path, endings } in outputs {
        if path.is_dir() {
            bail!("`{path}` is a directory; name a file to be written");
        }
        let fits = |it: &&str| path.extension() == Some(it);
        if !endings.is_empty() && !endings.iter().any(fits) {
            let names: Vec<String> = endings.iter().map(|it| format!("FILE.{it}")).collect();
            bail!(
                "`{path}` does not say what it is to be; name it {}",
                names.join(" or ")
            );
        }
        let identity = Identity::of(path);
        if read.contains(&identity) || path.exists() && is_source(path) {
            bail!("`{path}` is a source and would be lost; name another file");
        }
        if before.contains(&identity) {
            bail!("`{path}` is to get two contents; name two files");
        }
        before.push(identity);
    }
    Ok(())
}

/// Whether a name is that of something that people write: codels and settings are not among the files that
/// are read before a run.
fn is_source(path: &Utf8Path) -> bool {
    let other = matches!(path.extension(), Some("gen" | "idl" | "scn" | "toml"));
    other || Grammar::of_path(path.as_str()).is_some()
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
