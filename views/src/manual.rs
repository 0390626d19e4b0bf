//! The pages of the manual. They are installed with the program, so that links work without a network.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use rustc_hash::FxHashMap;

/// The environment variable with the folder of the manual, for a program that is installed elsewhere.
const FOLDER: &str = "DOTGEN_MANUAL";

/// The folder of the pages: below the `named` folder, or else near the program. In a package, `docs` is
/// next to the program or one directory above; in a build tree, two above `target/debug`.
fn directory(named: Option<PathBuf>, program: Option<PathBuf>) -> Option<PathBuf> {
    if let Some(named) = named {
        return Some(named.join("diagnostics"));
    }
    let program = program?.canonicalize().ok()?;
    let places =
        |path: &Path| [path.join("docs/diagnostics"), path.join("share/doc/dotgen/diagnostics")];
    let around = program.ancestors().skip(1).take(4);
    around.flat_map(places).find(|place| place.is_dir())
}

/// The pages by code; `async/shared-attribute` is in a directory.
static PAGES: LazyLock<FxHashMap<String, PathBuf>> = LazyLock::new(|| {
    let named = std::env::var_os(FOLDER).map(PathBuf::from);
    let directory = directory(named, std::env::current_exe().ok());
    let Some(directory) = directory else {
        return FxHashMap::default();
    };
    // Codes of rules are `group/name`, and their pages have the same path.
    let files = walkdir::WalkDir::new(&directory).max_depth(2);
    let page = |entry: walkdir::Result<walkdir::DirEntry>| {
        let path = entry.ok()?.into_path();
        let code = path.strip_prefix(&directory).ok()?.to_str()?;
        let code = code.strip_suffix(".md")?.replace('\\', "/");
        Some((code, path))
    };
    files.into_iter().filter_map(page).collect()
});

/// The manual page of a diagnostic code, if it is installed.
pub fn page(code: &str) -> Option<&'static Path> {
    PAGES.get(code).map(PathBuf::as_path)
}

/// The pages of diagnostics by code, in order, bundled with the program.
static TEXTS: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/pages.rs"));

/// All codes that have a page.
pub fn codes() -> impl Iterator<Item = &'static str> {
    TEXTS.iter().map(|text| text.0)
}

/// The text of the page of a diagnostic code, in Markdown.
pub fn text(code: &str) -> Option<&'static str> {
    let found = TEXTS.binary_search_by_key(&code, |text| text.0);
    found.ok().map(|place| TEXTS[place].1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_named_folder_wins_over_the_one_near_the_program() {
        let root = tempfile::tempdir().expect("a folder");
        let (docs, program) =
            (root.path().join("docs/diagnostics"), root.path().join("bin/dotgen"));
        std::fs::create_dir_all(&docs).expect("a folder");
        std::fs::create_dir_all(root.path().join("bin")).expect("a folder");
        std::fs::write(&program, "").expect("a file");
        let near = directory(None, Some(program.clone())).expect("the folder near the program");
        assert_eq!(near, docs.canonicalize().expect("it is there"));
        let named = directory(Some("/extension/docs".into()), Some(program));
        assert_eq!(named, Some("/extension/docs/diagnostics".into()));
    }
}
