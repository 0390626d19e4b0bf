//! The release of GenoM3 for a specification.
//!
//! The user's setting counts first, then the installed release, then the requirements of the specifications,
//! and otherwise the newest release that dotgen was compared with. The requirements of a specification are
//! read from its tokens, since their meaning depends on the release.

use camino::Utf8PathBuf;
use dotgen_syntax::{SyntaxKind, line_index::line_start};
use rustc_hash::FxHashSet;

use crate::{
    base::{Db, SourceFile, Workspace, normalize},
    loader::{FileContent, Loader},
    release::{Release, ReleaseChoice, ReleaseOrigin},
};

/// The requirements of one file's text on releases.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Requirement {
    /// The greatest lower bound for the package `genom3` in it.
    pub(crate) bound: Option<Release>,
    /// Names in its `#include "…"`.
    pub(crate) includes: Vec<String>,
}

impl Requirement {
    /// Reads a text. All specifications are read, so only possible places of comments are lexed.
    pub(crate) fn of(text: &str) -> Requirement {
        let mut found = Requirement::default();
        let named = text.match_indices(PACKAGE).map(|(at, _)| at);
        let bounds = named.filter_map(|at| {
            let before = text[..at].trim_end_matches([' ', '\t']);
            let start = before.strip_suffix('"')?.len();
            let length = text[start + 1..].find(['"', '\n'])?;
            let bound = Release::lower_bound(&text[start + 1..start + 1 + length])?;
            is_string(text, start).then_some(bound)
        });
        found.bound = bounds.max();
        for (at, word) in text.match_indices("include") {
            let line = line_start(text, at);
            if text[line..at].trim() != "#" {
                continue;
            }
            let after = &text[at + word.len()..];
            let name = after.trim_start_matches([' ', '\t']).strip_prefix('"');
            if let Some((name, _)) = name.and_then(|name| name.split_once('"')) {
                found.includes.push(name.to_owned());
            }
        }
        found
    }
}

/// The package whose version is the release.
const PACKAGE: &str = "genom3";

/// Returns true if the quote at an offset begins a string, and is not in a comment or in another string.
fn is_string(text: &str, at: usize) -> bool {
    let before = &text[..at];
    let line = line_start(text, at);
    let plain = !before[line..].contains(['"', '\'']) && !before[line..].contains("//");
    if plain && before.rfind("/*").is_none_or(|open| before[open + 2..].contains("*/")) {
        return true;
    }
    let raw = dotgen_syntax::lexer::lex(text);
    let mut strings = (0..raw.len()).filter(|token| raw.kind(*token) == SyntaxKind::STRING);
    strings.any(|token| raw.start(token) == at)
}

/// The greatest lower bound for the package `genom3` in some files and their includes in the same
/// directories.
pub fn required_release(
    loader: &dyn Loader,
    files: impl IntoIterator<Item = Utf8PathBuf>,
) -> Option<Release> {
    let mut seen = FxHashSet::default();
    let mut todo: Vec<Utf8PathBuf> = files.into_iter().collect();
    let mut bound = None;
    while let Some(file) = todo.pop().map(|file| normalize(&file)) {
        if seen.contains(&file) {
            continue;
        }
        if let FileContent::Text(text) | FileContent::NotUtf8(text) = loader.read(&file) {
            let found = Requirement::of(&text);
            bound = bound.max(found.bound);
            let directory = file.parent().unwrap_or(&file);
            todo.extend(found.includes.iter().map(|include| directory.join(include)));
        }
        seen.insert(file);
    }
    bound
}

/// The requirements of a file on releases.
#[salsa::tracked]
fn requirement(db: &dyn Db, file: SourceFile) -> Requirement {
    Requirement::of(file.text(db))
}

/// The greatest lower bound in some files and their includes in the same directories.
fn bound(db: &dyn Db, files: impl IntoIterator<Item = SourceFile>) -> Option<Release> {
    let mut seen = FxHashSet::default();
    let mut todo: Vec<SourceFile> = files.into_iter().collect();
    let mut bound = None;
    while let Some(file) = todo.pop() {
        if !seen.insert(file) || !file.status(db).is_text() {
            continue;
        }
        let found = requirement(db, file);
        bound = bound.max(found.bound);
        let Some(directory) = file.path(db).parent() else {
            continue;
        };
        todo.extend(
            found.includes.iter().map(|include| db.file(&normalize(&directory.join(include)))),
        );
    }
    bound
}

/// The release of the specifications of a project, by its directory; `None` for specifications outside of
/// projects.
#[salsa::tracked]
fn of_project(db: &dyn Db, workspace: Workspace, directory: Option<Utf8PathBuf>) -> ReleaseChoice {
    let projects = workspace.projects(db);
    let project = projects.iter().find(|project| Some(&project.directory) == directory.as_ref());
    let given = match project {
        Some(project) => project.release.as_ref(),
        None => workspace.release(db).as_ref(),
    };
    if let Some(given) = given.or(db.installed().release(db).as_ref()) {
        return given.clone();
    }
    let of_project = |path: &&Utf8PathBuf| {
        workspace.project(db, path).map(|project| &project.directory) == directory.as_ref()
    };
    let roots = workspace.roots(db).iter().filter(of_project);
    ReleaseChoice::required(bound(db, roots.map(|root| db.file(root))))
}

/// The release of the project that contains a path.
pub(crate) fn of_path(db: &dyn Db, path: &camino::Utf8Path) -> ReleaseChoice {
    let project = db.workspace().project(db, path);
    let directory = project.map(|project| project.directory.clone());
    of_project(db, db.workspace(), directory).clone()
}

/// The release of a unit by its inputs: a given release, or the greater of the lower bounds of the first
/// input's project and of the inputs themselves.
pub(crate) fn of_inputs(db: &dyn Db, inputs: &[SourceFile]) -> ReleaseChoice {
    let Some(first) = inputs.first() else {
        return ReleaseChoice::default();
    };
    let choice = of_path(db, first.path(db));
    if choice.origin.is_given() {
        return choice;
    }
    let own = bound(db, inputs.iter().copied());
    match &choice.origin {
        ReleaseOrigin::Required(bound) if own <= Some(*bound) => choice,
        _ => ReleaseChoice::required(own),
    }
}
