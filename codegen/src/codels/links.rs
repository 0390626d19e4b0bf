//! Links from codels to functions and back, for navigation.

use std::ops::Range;

use camino::Utf8Path;
use dotgen_analysis::model::{CodelRef, ComponentId};

use super::{
    drift::SourcePlace,
    expected::Expected,
    files::Sources,
    source::{Function, Grammar, SourceIndex, mentions},
};

/// The places of the names of functions that implement a codel. With conditional compilation there may be
/// several.
pub fn implementations(sources: &Sources, codel: &str) -> Vec<SourcePlace> {
    let files = sources.all();
    files
        .flat_map(|file| {
            file.index().definitions(codel).map(|definition| SourcePlace {
                path: file.path.clone(),
                range: definition.name_span.clone(),
            })
        })
        .collect()
}

/// Every mention of a codel's function in the sources, by file and place.
pub fn references(sources: &Sources, codel: &str) -> Vec<SourcePlace> {
    let files = sources.all();
    files
        .flat_map(|file| {
            let found = mentions(&file.text, file.grammar, codel);
            found.into_iter().map(|range| SourcePlace { path: file.path.clone(), range })
        })
        .collect()
}

/// The place for the cursor in the function of a codel in the text of a file: the first line between its
/// braces, without leading and trailing blanks. If there is no such line, the place after the opening brace.
pub fn body_start(path: &Utf8Path, text: &str, codel: &str) -> Option<Range<usize>> {
    let index = SourceIndex::new(text, Grammar::of_path(path.as_str())?);
    let function = index.definitions(codel).next()?;
    let braces = function.body.as_ref()?.span.clone();
    let start = braces.start + 1;
    let inside = text.get(start..braces.end.checked_sub(1)?)?;
    let blank = inside.len() - inside.trim_start().len();
    let line = inside[blank..].lines().next().map_or("", str::trim_end);
    if line.is_empty() {
        Some(start..start)
    } else {
        Some(start + blank..start + blank + line.len())
    }
}

/// A function that implements a codel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CodelFunction {
    pub name: String,
    /// The place of its name.
    pub name_range: Range<usize>,
    /// The whole function.
    pub range: Range<usize>,
    /// The codels it implements: component (index into the components of the specification) and
    /// codel.
    pub codels: Vec<(ComponentId, CodelRef)>,
}

/// Functions of a file that implement codels, in text order, for code lenses.
pub fn codel_functions(
    all: &[Expected<'_>],
    sources: &Sources,
    path: &Utf8Path,
) -> Vec<CodelFunction> {
    let Some(file) = sources.file(path) else {
        return Vec::new();
    };
    let functions = file.index().functions.iter();
    functions
        .filter(|function| function.body.is_some() && function.is_global())
        .filter_map(|function| codel_function(all, function))
        .collect()
}

fn codel_function(all: &[Expected<'_>], function: &Function) -> Option<CodelFunction> {
    let mut codels = Vec::new();
    for expected in all {
        if let Some(wanted) = expected.function(&function.name) {
            codels.extend(wanted.uses.iter().map(|&at| (expected.component, at)));
        }
    }
    (!codels.is_empty()).then(|| CodelFunction {
        name: function.name.to_string(),
        name_range: function.name_span.clone(),
        range: function.span.clone(),
        codels,
    })
}

/// The codel whose function contains, or is called at, an offset of a source.
pub fn codel_at(
    all: &[Expected<'_>],
    sources: &Sources,
    path: &Utf8Path,
    offset: usize,
) -> Option<CodelFunction> {
    let file = sources.file(path)?;
    codel_function(all, file.index().function_at(offset)?)
}
