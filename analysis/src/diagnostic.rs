//! Diagnostics as every front end shows them: a code, a message, places in files, fixes.
//!
//! Layers below report with their own positions (raw offsets, syntax ranges, ids of the item tree);
//! `host` turns all of them into this one type. Ranges are byte offsets.

use std::ops::Range;

use camino::Utf8PathBuf;
use serde::{Deserialize, Serialize};

/// How bad it is. Only errors reject a specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs, reason = "the names of the LSP")]
pub enum Severity {
    Error,
    Warning,
    Information,
    Hint,
}

/// Extra meaning of a diagnostic, as the LSP has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the names of the LSP")]
pub enum Tag {
    Unnecessary,
    Deprecated,
}

/// One diagnostic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// Stable identifier: the Id of the language reference, section 19, or one of our own.
    pub code: &'static str,
    /// After the configuration has been applied.
    pub severity: Severity,
    /// What is wrong, and what would be right.
    pub message: String,
    /// What the reference compiler says of it, where it says something.
    pub reference: Option<Reference>,
    /// File it is in.
    pub path: Utf8PathBuf,
    /// Where in the file.
    pub range: Range<usize>,
    /// Other places that explain it.
    pub related: Vec<Related>,
    /// Extra meaning.
    pub tags: Vec<Tag>,
    /// Ways to mend it, the best first.
    pub fixes: Vec<Fix>,
}

/// A line of the reference compiler.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reference {
    /// Its words.
    pub text: String,
    /// Where in the file it sees the problem.
    pub at: usize,
}

/// A place that explains a diagnostic ("previous declaration").
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Related {
    /// File of the place.
    pub path: Utf8PathBuf,
    /// Where in the file.
    pub range: Range<usize>,
    /// What is there.
    pub message: String,
}

/// A set of edits that removes the cause of a diagnostic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fix {
    /// What it does, in the imperative.
    pub title: String,
    /// How sure it is that the author wants it.
    pub kind: FixKind,
    /// Non-overlapping edits.
    pub edits: Vec<FileEdit>,
}

/// How sure it is that the author of a text wants a fix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FixKind {
    /// There is no other way to mend the finding: the fix can be made unasked.
    Plain,
    /// The fix may not be what was meant.
    Guess,
    /// The fix changes what the program does (a transition, a throw, a lock, an execution time): never made
    /// together with others.
    Choice,
}

impl FixKind {
    /// A fix without alternative, or a guess.
    pub(crate) fn of(plain: bool) -> FixKind {
        match plain {
            true => FixKind::Plain,
            false => FixKind::Guess,
        }
    }
}

/// Replacement of a range of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileEdit {
    /// File to change.
    pub path: Utf8PathBuf,
    /// What is replaced; empty to insert.
    pub range: Range<usize>,
    /// The new text.
    pub new_text: String,
}

impl Diagnostic {
    /// A diagnostic at a place, with nothing that explains or mends it.
    pub fn new(
        code: &'static str,
        severity: Severity,
        message: impl Into<String>,
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

    /// The key by which diagnostics are sorted and deduplicated: place first.
    pub(crate) fn sort_key(&self) -> (&str, usize, usize, Severity, &str, &str) {
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
