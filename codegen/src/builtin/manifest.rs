//! `template.toml`: the files that a template writes.

use serde::Deserialize;

/// A template.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Manifest {
    /// Its description, in one line.
    pub about: String,
    /// The files it writes, in order.
    #[serde(default)]
    pub files: Vec<FileRule>,
}

/// A rule for one file, or for a file per component, codel file or state machine.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FileRule {
    /// The objects for which it is written.
    #[serde(default)]
    pub each: RunScope,
    /// Path below the output directory; a MiniJinja text.
    pub path: String,
    /// Name of the MiniJinja text in the folder of the template.
    pub source: String,
    /// Permissions, in the form of `chmod`.
    #[serde(default)]
    pub permissions: String,
    /// True if the file is also written with `--terse`.
    #[serde(default = "default_true")]
    pub terse: bool,
}

/// See [`FileRule::each`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunScope {
    /// Once.
    #[default]
    Run,
    /// For each component: `component`.
    Component,
    /// For each file of codels of each component: `component`, `file.path`, `file.text`.
    CodelFile,
    /// For each task and activity with a state machine: `component`, `owner` (its name).
    StateMachine,
}

fn default_true() -> bool {
    true
}
