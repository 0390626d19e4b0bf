//! Requests that show internal representations of a document: `dotgen/syntaxTree`, `dotgen/model`, …

use dotgen_analysis::host::Cancellable;
use serde_json::{Value, json};

use crate::protocol::messages::{DocumentParams, IncludingRoots, PositionParams, ReleaseInfo};
use crate::workspace::snapshot::{Snapshot, Subject};

/// `dotgen/syntaxTree`: the tree as text.
pub(crate) fn syntax_tree(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentParams,
) -> Cancellable<Option<String>> {
    snapshot.analysis.syntax_tree(&subject.path)
}

/// `dotgen/model`: the component model of the unit that serves the document, as `dotgen model`
/// prints it.
pub(crate) fn model(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentParams,
) -> Cancellable<Value> {
    let unit = snapshot.analysis.unit(&subject.path)?;
    Ok(dotgen_views::model::document(&unit))
}

/// `dotgen/itemTree`: the declarations that lowering reads, as text.
pub(crate) fn item_tree(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentParams,
) -> Cancellable<Option<String>> {
    snapshot.analysis.item_tree(&subject.path)
}

/// `dotgen/expandMacro`: the innermost macro call around a place.
pub(crate) fn expand_macro(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &PositionParams,
) -> Cancellable<Option<Value>> {
    let Some(at) = snapshot.cursor(subject, params.position)? else {
        return Ok(None);
    };
    let Some(found) = snapshot.analysis.expand_macro(&at)? else {
        return Ok(None);
    };
    let location = snapshot.location(&at.path, &found.range)?;
    Ok(location.map(|location| {
        let (name, expansion) = (found.info.name, found.info.expansion);
        json!({ "name": name, "expansion": expansion, "range": location.range })
    }))
}

/// `dotgen/includingRoots`: the units that a document may be shown in.
pub(crate) fn including_roots(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentParams,
) -> Cancellable<IncludingRoots> {
    let roots = snapshot.analysis.roots_containing(&subject.path)?;
    let roots: Vec<_> = roots.iter().filter_map(|root| snapshot.uri(root)).collect();
    Ok(IncludingRoots { current: roots.first().cloned(), roots })
}

/// `dotgen/release`: the release of GenoM3 that a document is read as.
pub(crate) fn release(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentParams,
) -> Cancellable<ReleaseInfo> {
    let root = snapshot.analysis.root_of(&subject.path)?;
    let choice = snapshot.analysis.release(&root)?;
    Ok(ReleaseInfo {
        release: choice.release.to_string(),
        verified: choice.release.is_verified(),
        origin: choice.origin.to_string(),
    })
}
