//! Fixes for an included file or a required package that is not found: adding its directory to the settings.

use std::collections::BTreeSet;
use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::Cancellable;
use toml_edit::{Array, DocumentMut, value};

use crate::config;
use crate::features::convert::edit::{Review, edit_of, with_edit};
use crate::features::project_settings::{edit, project};
use crate::protocol::convert::position::touches;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};
use dotgen_platform::files::vfs;

/// Maximum number of directories that are offered.
const MAX_DIRECTORIES: usize = 3;

/// The directories of pkg-config files below the prefix of an installation.
const BELOW_PREFIX: [&str; 3] = ["lib/pkgconfig", "share/pkgconfig", "lib64/pkgconfig"];

/// A setting that is a list of directories.
struct Setting {
    key: &'static str,
    /// The content of the directories, as text.
    wanted: &'static str,
}

const INCLUDES: Setting = Setting { key: "include-paths", wanted: "included files" };

const PACKAGES: Setting = Setting { key: "package-paths", wanted: "packages" };

/// Fixes at a missing file or package: for every missing file and package, the directories that contain it. A
/// file may belong to a package, so both are searched in either case.
pub(crate) fn fixes(
    snapshot: &Snapshot,
    subject: &Subject,
    range: &Range<usize>,
    out: &mut Vec<CodeActionOrCommand>,
) -> Cancellable<()> {
    let mut includes = snapshot.analysis.missing_includes(&subject.path)?;
    let mut packages = snapshot.analysis.missing_packages(&subject.path)?;
    let at_include = includes.iter().any(|include| touches(&include.range, range));
    let at_package = packages.iter().any(|package| touches(&package.range, range));
    if !at_include && !at_package {
        return Ok(());
    }
    includes.retain(|include| at_package || touches(&include.range, range));
    packages.retain(|package| at_include || touches(&package.range, range));
    let Some(project) = project(snapshot, &subject.path) else {
        return Ok(());
    };
    let of_includes =
        includes.iter().flat_map(|include| below(&project, Utf8Path::new(&include.path)));
    for directory in of_includes.collect::<BTreeSet<_>>() {
        add(snapshot, &project, &INCLUDES, &directory, out)?;
    }
    for name in packages.into_iter().flat_map(|package| package.names) {
        // A package that is found does not have the required version: another directory does not help.
        let file = format!("{name}.pc");
        let mut found = below(&project, Utf8Path::new(&file));
        for prefix in prefixes() {
            let all = BELOW_PREFIX.iter().map(|below_prefix| prefix.join(below_prefix));
            found.extend(all.filter(|prefix| prefix.join(&file).is_file()));
        }
        found.truncate(MAX_DIRECTORIES);
        for directory in found {
            add(snapshot, &project, &PACKAGES, &directory, out)?;
        }
    }
    Ok(())
}

/// The prefixes of robotpkg: first the value of its environment variable, then the default of its manual.
fn prefixes() -> Vec<Utf8PathBuf> {
    let said = std::env::var("ROBOTPKG_BASE").ok();
    let home = std::env::var("HOME").ok().map(Utf8PathBuf::from);
    let homes = home.iter().map(|path| path.join("openrobots"));
    let mut out: Vec<Utf8PathBuf> = Vec::new();
    let usual = std::iter::once(Utf8PathBuf::from("/opt/openrobots"));
    let said = said.map(Utf8PathBuf::from).into_iter();
    for path in said.chain(usual).chain(homes) {
        if path.is_absolute() && !out.contains(&path) {
            out.push(path);
        }
    }
    out
}

/// The action that adds a directory to a setting.
fn add(
    snapshot: &Snapshot,
    project: &Utf8Path,
    setting: &Setting,
    directory: &Utf8Path,
    out: &mut Vec<CodeActionOrCommand>,
) -> Cancellable<()> {
    let change = |document: &mut DocumentMut| add_directory(document, setting, directory);
    let Some(edit) = edit(snapshot, project, change)? else {
        return Ok(());
    };
    let name = match directory.as_str() {
        "" => ".",
        name => name,
    };
    let action = CodeAction {
        title: format!("Search `{name}` for {}, in {}", setting.wanted, config::FILE_NAME),
        kind: Some(CodeActionKind::QUICKFIX),
        ..CodeAction::default()
    };
    let edit = edit_of(snapshot, Review::None, &edit)?;
    out.extend(with_edit(snapshot, action, edit).map(CodeActionOrCommand::CodeAction));
    Ok(())
}

/// The directories below a folder that contain a file, relative to the folder.
fn below(folder: &Utf8Path, wanted: &Utf8Path) -> Vec<Utf8PathBuf> {
    let Some(extension) = wanted.extension() else {
        return Vec::new();
    };
    let all = vfs::files_below(folder, &[extension]).files.into_iter();
    let found = all.filter(|path| path.ends_with(wanted));
    let directory = |path: Utf8PathBuf| {
        let up = path.ancestors().nth(wanted.components().count())?;
        Some(up.strip_prefix(folder).ok()?.to_owned())
    };
    found.filter_map(directory).take(MAX_DIRECTORIES).collect()
}

/// Adds a directory to a setting. Returns `None` if the setting is not a list, or contains the directory.
fn add_directory(
    document: &mut DocumentMut,
    setting: &Setting,
    directory: &Utf8Path,
) -> Option<()> {
    let directory = match directory.as_str() {
        "" => ".".to_owned(),
        other => other.replace('\\', "/"),
    };
    let entry = document.entry(setting.key).or_insert_with(|| value(Array::new()));
    let paths = entry.as_value_mut().and_then(|value| value.as_array_mut())?;
    if paths.iter().any(|path| path.as_str() == Some(&directory)) {
        return None;
    }
    paths.push(directory);
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::project_settings::changed;

    #[test]
    fn a_directory_is_added_and_the_rest_stays() {
        let add =
            |document: &mut DocumentMut| add_directory(document, &INCLUDES, Utf8Path::new("idl"));
        for (before, after) in [
            ("", "include-paths = [\"idl\"]\n"),
            (
                "# ours\ninclude-paths = [\"a\"] # here\n[codels]\ncheck = false\n",
                "# ours\ninclude-paths = [\"a\", \"idl\"] # here\n[codels]\ncheck = false\n",
            ),
            ("release = \"2.99.41\"\n", "release = \"2.99.41\"\ninclude-paths = [\"idl\"]\n"),
        ] {
            assert_eq!(changed(before, add).as_deref(), Some(after));
            assert_eq!(changed(after, add), None, "it is there");
        }
        assert_eq!(changed("include-paths = 1\n", add), None);
    }
}
