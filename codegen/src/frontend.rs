//! What the template engine needs of the language front end.

use std::sync::Arc;

use dotgen_analysis::model::Spec;
use dotgen_analysis::release::Release;

use crate::lang::{NoPlaces, Places};

/// A model and what belongs to it.
#[derive(Clone)]
pub struct Compiled {
    /// Everything parsed so far.
    pub spec: Arc<Spec>,
    /// Where it was written.
    pub places: Arc<dyn Places + Send + Sync>,
    /// Normalized paths of all files read, in order of first appearance.
    pub deps: Vec<String>,
}

impl Default for Compiled {
    fn default() -> Compiled {
        Compiled::of_release(Release::default())
    }
}

impl Compiled {
    /// Nothing yet, to be read as a release does.
    pub fn of_release(release: Release) -> Compiled {
        Compiled {
            spec: Arc::new(Spec {
                release,
                ..Spec::default()
            }),
            places: Arc::new(NoPlaces),
            deps: Vec::new(),
        }
    }
}

/// Why parsing failed. The correct parts have been added to the model all the same.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ParseFailure {
    /// So many errors, each already reported.
    Errors(usize),
    /// Reading stopped before the end; reported.
    Fatal,
    /// An input that cannot be read, with the reason; not yet reported.
    Unreadable(String),
}

impl std::fmt::Display for ParseFailure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            ParseFailure::Errors(1) => f.write_str("1 error"),
            ParseFailure::Errors(count) => write!(f, "{count} errors"),
            ParseFailure::Fatal => f.write_str("fatal errors"),
            ParseFailure::Unreadable(reason) => f.write_str(reason),
        }
    }
}

/// Parses specifications into one growing model.
pub trait Frontend {
    /// Adds files, preprocessed as one unit. Each message (`BASENAME:LINE: TEXT`) goes to
    /// `report` as it is found.
    ///
    /// # Errors
    /// Any error in the input; the correct parts are added.
    fn parse_files(
        &mut self,
        files: &[String],
        report: &mut dyn FnMut(&str),
    ) -> Result<(), ParseFailure>;

    /// Adds texts, not preprocessed; their places name `<inline string>`.
    ///
    /// # Errors
    /// As for [`Frontend::parse_files`].
    fn parse_strings(
        &mut self,
        texts: &[String],
        report: &mut dyn FnMut(&str),
    ) -> Result<(), ParseFailure>;

    /// Everything parsed so far.
    fn compiled(&self) -> Compiled;
}
