//! Diagnostics in the form that every front end shows: a code, a message, places in files, fixes.
//!
//! Layers below report with their own positions (raw offsets, syntax ranges, ids of the item tree); `host`
//! converts all of them to this one type. Ranges are byte offsets.

use std::ops::Range;

use camino::Utf8PathBuf;

pub use dotgen_syntax::{Severity, finding::Wording};

/// Extra meaning of a diagnostic, as in LSP.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Tag {
    Unnecessary,
    Deprecated,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// Stable identifier: the Id of the language reference, section 19, or a code of dotgen's own.
    pub code: &'static str,
    /// Severity after the configuration has been applied.
    pub severity: Severity,
    /// The error, and the correct form.
    pub message: Wording,
    /// The message of the reference compiler, if it reports one.
    pub reference: Option<Reference>,
    /// The file.
    pub path: Utf8PathBuf,
    /// Byte range in the file.
    pub range: Range<usize>,
    /// Other places that explain it.
    pub related: Vec<Related>,
    /// Extra meaning.
    pub tags: Vec<Tag>,
    /// Fixes, the best first.
    pub fixes: Vec<Fix>,
}

/// A message of the reference compiler.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reference {
    /// The words.
    pub text: String,
    /// Byte offset in the file at which it reports the problem.
    pub at: usize,
}

/// A place that explains a diagnostic ("previous declaration").
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Related {
    /// File of the place.
    pub path: Utf8PathBuf,
    /// Byte range in the file.
    pub range: Range<usize>,
    /// The description of the place.
    pub message: Wording,
}

/// A set of edits that removes the cause of a diagnostic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fix {
    /// The action, in the imperative.
    pub title: String,
    /// The certainty that the author wants it.
    pub kind: FixKind,
    /// Non-overlapping edits.
    pub edits: Vec<FileEdit>,
}

/// The certainty that the author of a text wants a fix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FixKind {
    /// The only way to correct the finding: it can be applied automatically.
    Plain,
    /// The fix may not be the intended one.
    Guess,
    /// The fix changes the behaviour of the program (a transition, a throw, a lock, an execution time): it is
    /// never applied together with others.
    Choice,
}

impl FixKind {
    /// `Plain` for a fix without an alternative, `Guess` otherwise.
    pub(crate) fn of(plain: bool) -> FixKind {
        if plain { FixKind::Plain } else { FixKind::Guess }
    }
}

/// Replacement of a range of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileEdit {
    /// File to change.
    pub path: Utf8PathBuf,
    /// The replaced byte range; empty to insert.
    pub range: Range<usize>,
    pub new_text: String,
}

impl Diagnostic {
    /// A diagnostic at a place, without related places and fixes.
    pub fn new(
        code: &'static str,
        severity: Severity,
        message: impl Into<Wording>,
        path: Utf8PathBuf,
        range: Range<usize>,
    ) -> Diagnostic {
        Diagnostic {
            code,
            severity,
            message: message.into(),
            reference: None,
            path,
            range,
            related: Vec::new(),
            tags: Vec::new(),
            fixes: Vec::new(),
        }
    }

    /// The sort and deduplication key of diagnostics: place first.
    pub(crate) fn sort_key(&self) -> (&str, usize, usize, Severity, &str, &Wording) {
        (
            self.path.as_str(),
            self.range.start,
            self.range.end,
            self.severity,
            self.code,
            &self.message,
        )
    }
}
