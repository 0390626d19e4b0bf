//! Results of the language front end.

use std::sync::Arc;

use dotgen_analysis::model::Spec;
use dotgen_analysis::release::Release;

use crate::lang::{NoPlaces, Places};

/// A model with its places and files.
#[derive(Clone)]
pub struct Compiled {
    /// Everything parsed so far.
    pub spec: Arc<Spec>,
    /// The places of its declarations.
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
    /// An empty model, for inputs of a release.
    pub fn of_release(release: Release) -> Compiled {
        Compiled {
            spec: Arc::new(Spec { release, ..Spec::default() }),
            places: Arc::new(NoPlaces),
            deps: Vec::new(),
        }
    }
}

/// A failure to parse. The correct parts have been added to the model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ParseFailure {
    /// The number of errors, which were already reported.
    Errors(usize),
    /// Reading stopped before the end; the error was reported.
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
