//! Diagnostics.

use dotgen_analysis::diagnostic::{Diagnostic, Severity, Tag};
use dotgen_analysis::host::Cancellable;

use crate::proto;
use crate::snapshot::Snapshot;

/// Shown as the source of every diagnostic.
pub const SOURCE: &str = "dotgen";

/// The protocol's severity.
pub fn severity(severity: Severity) -> proto::DiagnosticSeverity {
    match severity {
        Severity::Error => proto::DiagnosticSeverity::ERROR,
        Severity::Warning => proto::DiagnosticSeverity::WARNING,
        Severity::Information => proto::DiagnosticSeverity::INFORMATION,
        Severity::Hint => proto::DiagnosticSeverity::HINT,
    }
}

/// A diagnostic, as much of it as the client understands.
pub fn to_proto(
    snapshot: &Snapshot,
    diagnostic: &Diagnostic,
) -> Cancellable<Option<proto::Diagnostic>> {
    let Some(lines) = snapshot.lines(&diagnostic.path)? else {
        return Ok(None);
    };
    let mut related = Vec::new();
    if snapshot.client.related_information {
        for it in &diagnostic.related {
            if let Some(location) = snapshot.location(&it.path, &it.range)? {
                related.push(proto::DiagnosticRelatedInformation {
                    location,
                    message: it.message.clone(),
                });
            }
        }
    }
    let tags = diagnostic.tags.iter().map(|tag| match tag {
        Tag::Unnecessary => proto::DiagnosticTag::UNNECESSARY,
        Tag::Deprecated => proto::DiagnosticTag::DEPRECATED,
    });
    let page = crate::manual::page(diagnostic.code).filter(|_| snapshot.client.code_description);
    Ok(Some(proto::Diagnostic {
        range: lines.range(&diagnostic.range),
        severity: Some(severity(diagnostic.severity)),
        code: Some(proto::NumberOrString::String(diagnostic.code.to_owned())),
        code_description: page.map(|href| proto::CodeDescription { href }),
        source: Some(SOURCE.to_owned()),
        message: diagnostic.message.clone(),
        related_information: (!related.is_empty()).then_some(related),
        tags: (!diagnostic.tags.is_empty()).then(|| tags.collect()),
        data: None,
    }))
}
