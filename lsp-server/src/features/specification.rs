//! Specifications (`.gen`) and the files they include: one module per feature.

pub(crate) mod call_hierarchy;
pub(crate) mod code_action;
pub(crate) mod code_lens;
pub(crate) mod completion;
pub(crate) mod document_highlight;
pub(crate) mod document_link;
pub(crate) mod document_symbol;
pub(crate) mod folding_range;
pub(crate) mod formatting;
pub(crate) mod goto;
pub(crate) mod hover;
pub(crate) mod inlay_hint;
pub(crate) mod references;
pub(crate) mod rename;
pub(crate) mod search_paths;
pub(crate) mod selection_range;
pub(crate) mod semantic_tokens;
pub(crate) mod signature_help;

use camino::Utf8Path;
use dotgen_analysis::diagnostic::Diagnostic;
use dotgen_analysis::host::Cancellable;

use super::language::LanguageFeatures;
use super::{codels, verification};
use crate::workspace::snapshot::Snapshot;

/// The features of specifications.
pub(crate) const FEATURES: LanguageFeatures = LanguageFeatures {
    diagnostics,
    is_own: true,
    symbols: document_symbol::handle,
    folds: folding_range::handle,
    selections: selection_range::handle,
    links: document_link::handle,
    tokens: semantic_tokens::full,
    tokens_in: semantic_tokens::range,
    definition: goto::definition,
    declaration: goto::declaration,
    type_definition: goto::type_definition,
    implementation: goto::implementation,
    references: references::handle,
    highlights: document_highlight::handle,
    hover: hover::handle,
    completion: completion::handle,
    signature: signature_help::handle,
    prepare_rename: rename::prepare,
    rename: rename::rename,
    format: formatting::document,
    format_range: formatting::range,
    format_typed: formatting::on_type,
    hints: inlay_hint::handle,
    lenses: code_lens::handle,
    calls: call_hierarchy::prepare,
    actions: code_action::handle,
    ..LanguageFeatures::NONE
};

fn diagnostics(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Vec<Diagnostic>> {
    let mut all = codels::unrefuted_findings(snapshot, path)?;
    all.extend(verification::in_specification(snapshot, path)?);
    all.extend(codels::file_diagnostics(snapshot, path)?);
    Ok(all)
}
