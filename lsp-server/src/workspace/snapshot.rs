//! The data of a request handler: analysis, documents, configuration and client at the time of the request.
//!
//! A snapshot blocks the writer until it is dropped. Handlers run on the blocking pool and drop it before
//! their answer is sent.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{Analysis, Cancellable, Cancelled, UnitResult};
use dotgen_analysis::ide::FilePosition;
use dotgen_analysis::language::{self, Language};
use dotgen_analysis::parallel;
use dotgen_analysis::progress::Progress;
use rustc_hash::FxHashMap;

use crate::config::{Config, FILE_NAME};
use crate::protocol::client::ClientCaps;
use crate::protocol::convert::{Lines, uri};
use crate::protocol::types::{Location, Position, Uri};
use crate::workspace::codels;
use crate::workspace::templates::Templates;
use dotgen_platform::files::vfs::Vfs;

/// A document the client has open.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct OpenFile {
    /// The URI in the spelling of the client.
    pub uri: Uri,
    /// Last version seen.
    pub version: i32,
    pub language: Language,
    /// The client says that it is a source of a template, by its language id.
    pub is_template_source: bool,
}

/// The state of the server at the time of a request.
#[derive(Clone)]
pub(crate) struct Snapshot {
    /// The queries of analysis.
    pub analysis: Analysis,
    /// Open documents by path.
    pub open: Arc<FxHashMap<Utf8PathBuf, OpenFile>>,
    /// `.gen` files of the workspace and open documents: the roots of units.
    pub roots: Arc<Vec<Utf8PathBuf>>,
    /// Workspace folders.
    pub folders: Arc<Vec<Utf8PathBuf>>,
    /// The configuration in force.
    pub config: Arc<Config>,
    /// The capabilities of the client.
    pub client: Arc<ClientCaps>,
    /// Number of applied changes.
    pub revision: u64,
    /// The answers of verification.
    pub(crate) verification: Arc<dotgen_views::verification::results::Results>,
    /// `.scn` files of the workspace.
    pub(crate) scenarios: Arc<BTreeSet<Utf8PathBuf>>,
    /// Templates of the workspace.
    pub(crate) templates: Arc<Templates>,
    /// The disk.
    pub(crate) vfs: Arc<Vfs>,
    /// Stored comparisons of sources of codels.
    pub(crate) codels: Arc<codels::Cache>,
    /// The progress of the answer, for display.
    pub(crate) progress: Arc<Progress>,
    /// Shared by all live snapshots.
    #[expect(dead_code, reason = "the writer counts the clones")]
    pub(crate) readers: Arc<()>,
    /// Stored conversions of positions.
    pub(crate) lines: RefCell<FxHashMap<Utf8PathBuf, Option<Arc<Lines>>>>,
}

/// A reason why a handler has no answer.
#[derive(Debug)]
pub(crate) enum Stop {
    Cancelled(Cancelled),
    /// The answer is empty: nothing is at the place of the request, or its document is unknown.
    Nothing,
}

impl From<Cancelled> for Stop {
    fn from(cancelled: Cancelled) -> Stop {
        Stop::Cancelled(cancelled)
    }
}

/// The answer of a handler.
pub(crate) type Answer<T> = Result<T, Stop>;

/// An answer, empty if there is none.
pub(crate) fn or_empty<T: Default>(answer: Answer<T>) -> Cancellable<T> {
    match answer {
        Ok(answer) => Ok(answer),
        Err(Stop::Nothing) => Ok(T::default()),
        Err(Stop::Cancelled(cancelled)) => Err(cancelled),
    }
}

/// The document of a request.
#[derive(Debug, Clone)]
pub(crate) struct Subject {
    /// Absolute path.
    pub path: Utf8PathBuf,
    /// The URI in the spelling of the client.
    pub uri: Uri,
    /// Version, if it is open.
    pub version: Option<i32>,
}

impl Snapshot {
    /// Applies `f` to every item, on all cores; see [`parallel::map`].
    pub(crate) fn on_all_cores<T: Sync, R: Send>(
        &self,
        items: &[T],
        f: impl Fn(&Snapshot, &T) -> R + Sync,
    ) -> Vec<R> {
        parallel::map(items, || self.clone(), |argument| f(self, argument), &f)
    }

    /// The lines of a file; `None` if it cannot be read.
    pub(crate) fn lines(&self, path: &Utf8Path) -> Cancellable<Option<Arc<Lines>>> {
        if let Some(lines) = self.lines.borrow().get(path) {
            return Ok(lines.clone());
        }
        let lines = match self.analysis.text(path)? {
            Some(text) => {
                let index = self.analysis.line_index(path)?;
                let lines = Lines::with_index(text, index, self.client.encoding);
                Some(Arc::new(lines))
            }
            // Diagnostics of a file that is too large are at its beginning.
            None if self.analysis.is_too_large(path)? => {
                Some(Arc::new(Lines::new("".into(), self.client.encoding)))
            }
            None => None,
        };
        self.lines.borrow_mut().insert(path.to_owned(), lines.clone());
        Ok(lines)
    }

    /// The URI of a file; for an open file, in the spelling of the client.
    pub(crate) fn uri(&self, path: &Utf8Path) -> Option<Uri> {
        match self.open.get(path) {
            Some(open) => Some(open.uri.clone()),
            None => uri::from_path(path),
        }
    }

    /// A range of a file.
    pub(crate) fn location(
        &self,
        path: &Utf8Path,
        range: &Range<usize>,
    ) -> Cancellable<Option<Location>> {
        let Some(lines) = self.lines(path)? else {
            return Ok(None);
        };
        let location = |uri| Location::new(uri, lines.range(range));
        Ok(self.uri(path).map(location))
    }

    /// A cursor; `None` for a position that does not exist.
    pub(crate) fn cursor(
        &self,
        subject: &Subject,
        position: Position,
    ) -> Cancellable<Option<FilePosition>> {
        let Some(lines) = self.lines(&subject.path)? else {
            return Ok(None);
        };
        Ok(lines.offset(position).map(|offset| FilePosition { path: subject.path.clone(), offset }))
    }

    /// The lines of a file that can be read.
    pub(crate) fn text_lines(&self, path: &Utf8Path) -> Answer<Arc<Lines>> {
        self.lines(path)?.ok_or(Stop::Nothing)
    }

    /// A cursor at a position that exists.
    pub(crate) fn at(&self, subject: &Subject, position: Position) -> Answer<FilePosition> {
        self.cursor(subject, position)?.ok_or(Stop::Nothing)
    }

    /// The language of a document. Without another one, it is part of a specification.
    pub(crate) fn language_of(&self, path: &Utf8Path) -> Language {
        let is_codel = match self.open.get(path) {
            Some(open) => return open.language,
            None if language::is_header(path) => {
                let config = self.config.codels_of(path);
                config.is_some_and(|config| codels::home(config, path).is_some())
            }
            None => codels::is_code(path, None),
        };
        match is_codel {
            true => Language::Codel,
            false if language::is_scenario(path) => Language::Scenario,
            false => Language::Specification,
        }
    }

    /// True if a file is C or C++, and not part of a specification.
    pub(crate) fn is_code(&self, path: &Utf8Path) -> bool {
        self.language_of(path) == Language::Codel
    }

    /// The units of the system that a file belongs to: the files of the same workspace folder below the same
    /// `dotgen.toml`, and the open files below that `dotgen.toml`. Without a `dotgen.toml`, open files
    /// without one in any folder.
    pub(crate) fn system_units(&self, path: &Utf8Path) -> Cancellable<Vec<UnitResult>> {
        let folder = self.folders.iter().find(|folder| path.starts_with(folder));
        let project = self.config.project(path);
        let mut paths: Vec<&Utf8Path> = self
            .roots
            .iter()
            .filter(|root| {
                let beside = folder.is_some_and(|folder| root.starts_with(folder));
                beside || self.open.contains_key(*root)
            })
            .filter(|root| self.config.project(root) == project)
            .map(camino::Utf8PathBuf::as_path)
            .collect();
        if paths.is_empty() {
            paths.push(path);
        }
        paths.sort();
        let units = paths.into_iter().map(|path| self.analysis.root_unit(path));
        units.collect()
    }

    /// The units of the system picture of a file. The files that follow the `dotgen.toml` of their workspace
    /// folder, or none, are one system in all folders; other files have [`Snapshot::system_units`].
    pub(crate) fn workspace_units(&self, path: &Utf8Path) -> Cancellable<Vec<UnitResult>> {
        let follows_folder = |file: &Utf8Path| {
            let around = self.folders.iter().filter(|folder| file.starts_with(folder));
            let folder = around.max_by_key(|folder| folder.as_str().len());
            let project = folder.and_then(|folder| self.config.project(&folder.join(FILE_NAME)));
            self.config.project(file) == project
        };
        let mut units = self.system_units(path)?;
        if follows_folder(path) {
            let others = self.roots.iter().filter(|root| {
                (self.in_workspace(root) || self.open.contains_key(*root)) && follows_folder(root)
            });
            for other in others {
                if units.iter().all(|unit| unit.files.first() != Some(other)) {
                    units.push(self.analysis.root_unit(other)?);
                }
            }
            units.sort_by(|a, b| a.files.first().cmp(&b.files.first()));
        }
        Ok(units)
    }

    /// True if a file belongs to the workspace.
    pub(crate) fn in_workspace(&self, path: &Utf8Path) -> bool {
        self.folders.iter().any(|folder| path.starts_with(folder))
    }
}
