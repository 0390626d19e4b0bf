//! Diagnostics.

use dotgen_analysis::codes::severity_here;
use dotgen_analysis::diagnostic::{Diagnostic, Severity, Tag};
use dotgen_analysis::host::Cancellable;

use crate::protocol::types;
use crate::workspace::snapshot::Snapshot;

/// The protocol's severity.
pub(crate) fn severity(severity: Severity) -> types::DiagnosticSeverity {
    match severity {
        Severity::Error => types::DiagnosticSeverity::ERROR,
        Severity::Warning => types::DiagnosticSeverity::WARNING,
        Severity::Information => types::DiagnosticSeverity::INFORMATION,
        Severity::Hint => types::DiagnosticSeverity::HINT,
    }
}

/// A diagnostic, reduced to what the client supports.
pub(crate) fn to_proto(
    snapshot: &Snapshot,
    diagnostic: &Diagnostic,
) -> Cancellable<Option<types::Diagnostic>> {
    let Some(lines) = snapshot.lines(&diagnostic.path)? else {
        return Ok(None);
    };
    let mut related = Vec::new();
    if snapshot.client.related_information {
        for place in &diagnostic.related {
            if let Some(location) = snapshot.location(&place.path, &place.range)? {
                related.push(types::DiagnosticRelatedInformation {
                    location,
                    message: place.message.to_string(),
                });
            }
        }
    }
    let tags = diagnostic.tags.iter().map(|tag| match tag {
        Tag::Unnecessary => types::DiagnosticTag::UNNECESSARY,
        Tag::Deprecated => types::DiagnosticTag::DEPRECATED,
    });
    let page =
        dotgen_views::manual::page(diagnostic.code).filter(|_| snapshot.client.code_description);
    let page = page.and_then(types::Uri::from_file_path);
    Ok(Some(types::Diagnostic {
        range: lines.range(&diagnostic.range),
        severity: Some(severity(severity_here(diagnostic.code, diagnostic.severity))),
        code: Some(types::NumberOrString::String(diagnostic.code.to_owned())),
        code_description: page.map(|href| types::CodeDescription { href }),
        source: Some(types::SOURCE.to_owned()),
        message: diagnostic.message.to_string(),
        related_information: (!related.is_empty()).then_some(related),
        tags: (!diagnostic.tags.is_empty()).then(|| tags.collect()),
        data: None,
    }))
}
