//! Answers to requests. A handler takes a snapshot, the document and the parameters, asks analysis, and
//! converts the answer. It runs on the blocking pool and may be cancelled or panic.

pub mod codels;
pub(crate) mod commands;
pub mod component;
pub(crate) mod convert;
pub(crate) mod diagnostics;
pub(crate) mod diagram;
pub(crate) mod generation;
pub(crate) mod inspect;
pub(crate) mod language;
pub(crate) mod mentions;
pub(crate) mod project_settings;
pub(crate) mod rules;
pub(crate) mod runs;
pub(crate) mod scenario;
pub(crate) mod source;
pub(crate) mod specification;
pub(crate) mod template;
pub(crate) mod verification;
pub(crate) mod workspace_symbol;

use camino::Utf8Path;
use dotgen_analysis::language::Language;

use crate::workspace::snapshot::Snapshot;
use language::LanguageFeatures;

/// Returns the features of the language of a document.
pub(crate) fn features_of(snapshot: &Snapshot, path: &Utf8Path) -> &'static LanguageFeatures {
    match snapshot.language_of(path) {
        Language::Specification => &specification::FEATURES,
        Language::Scenario => &scenario::FEATURES,
        Language::Codel => &source::FEATURES,
        Language::Template => &template::FEATURES,
    }
}
