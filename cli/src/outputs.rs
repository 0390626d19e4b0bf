//! Documents of JSON on standard output, and files that a command writes in addition to its report: logs,
//! traces and recordings.

use std::io::Write as _;

use anyhow::bail;
use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::language::Language;
use dotgen_codegen::codels::source::Grammar;
use serde::Serialize;
use serde_json::Value;

/// Extension of traces for Perfetto.
pub(super) const PERFETTO: &str = "pftrace";

/// Extension of traces for the trace viewer.
pub(super) const VIEWER: &str = "json";

/// Extension of recordings for Foxglove.
pub(super) const MCAP: &str = "mcap";

/// Prints a document of JSON.
pub(super) fn print_json(document: &impl Serialize) -> anyhow::Result<()> {
    let text = serde_json::to_string_pretty(document)? + "\n";
    Ok(std::io::stdout().write_all(text.as_bytes())?)
}

/// Returns one document for several: one alone stands for itself, more are a list.
pub(super) fn one_or_all(mut documents: Vec<Value>) -> Value {
    match documents.len() {
        1 => documents.remove(0),
        _ => Value::Array(documents),
    }
}

/// An output file.
pub(super) struct Output<'f> {
    pub(super) path: &'f Utf8Path,
    /// The permitted extensions; empty: any.
    pub(super) endings: &'static [&'static str],
}

/// Checks the output files before anything is done.
///
/// # Errors
/// A file is a directory, has another extension, is one of the files that the command has `read`, is another
/// existing source, or is given twice.
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
        let fits = |text: &&str| path.extension() == Some(text);
        if !endings.is_empty() && !endings.iter().any(fits) {
            let names: Vec<String> =
                endings.iter().map(|ending| format!("FILE.{ending}")).collect();
            bail!("`{path}` does not say what it is to be; name it {}", names.join(" or "));
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

/// Returns true if a name is that of a source or of settings. Sources of codels and settings are not among
/// the files that are read before a run.
fn is_source(path: &Utf8Path) -> bool {
    let known = matches!(Language::of(path), Some(Language::Specification | Language::Scenario));
    known || path.extension() == Some("toml") || Grammar::of_path(path.as_str()).is_some()
}

/// The identity of a file, independent of the spelling of its path.
#[derive(PartialEq, Eq)]
enum Identity {
    /// Device and inode: hard links have the same identity.
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
            // The file does not exist yet, but its folder may.
            let folder = path.parent().filter(|parent| !parent.as_str().is_empty());
            let folder = folder.unwrap_or(Utf8Path::new(".")).canonicalize_utf8()?;
            Ok::<_, std::io::Error>(folder.join(path.file_name().unwrap_or_default()))
        });
        Identity::Path(whole.unwrap_or_else(|_| path.to_owned()))
    }
}
