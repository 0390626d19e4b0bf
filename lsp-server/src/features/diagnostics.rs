//! `textDocument/diagnostic` and `workspace/diagnostic`: diagnostics that the client pulls.

use std::collections::BTreeSet;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::Severity;
use dotgen_analysis::host::Cancellable;
use rustc_hash::{FxHashMap, FxHasher};

use crate::features::convert::diagnostic;
use crate::features::language::LanguageFeatures;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};
use dotgen_platform::panic;

/// The code for text that a conditional excludes.
const INACTIVE_CODE: &str = "inactive-code";

/// The diagnostics of a document, or a note that they are unchanged.
#[derive(Default)]
pub(crate) struct DocumentReport {
    result_id: String,
    /// `None`: unchanged.
    items: Option<Vec<Diagnostic>>,
}

/// `textDocument/diagnostic`. Empty for sources: editors get their diagnostics from other servers.
pub(crate) fn document(
    features: &LanguageFeatures,
    snapshot: &Snapshot,
    subject: &Subject,
    params: &DocumentDiagnosticParams,
) -> Cancellable<DocumentReport> {
    if !features.is_own && !snapshot.client.pull_sources {
        return Ok(DocumentReport::default());
    }
    let items = file_diagnostics(snapshot, &subject.path, Severity::Hint)?;
    Ok(DocumentReport::new(items, params.previous_result_id.as_deref()))
}

/// Some files of the workspace, and the identifiers of the client's reports.
pub(crate) struct Part {
    pub(crate) paths: Vec<Utf8PathBuf>,
    /// The identifiers of the client's reports, by path.
    pub(crate) known: Arc<FxHashMap<Utf8PathBuf, String>>,
}

/// `workspace/diagnostic` for some files.
pub(crate) fn part(
    snapshot: &Snapshot,
    part: &Part,
) -> Cancellable<Vec<WorkspaceDocumentDiagnosticReport>> {
    let reports = snapshot.on_all_cores(&part.paths, |snapshot, path| {
        let Some(uri) = snapshot.uri(path) else {
            return Ok(None);
        };
        let found = panic::isolate(|| file_diagnostics(snapshot, path, least(snapshot, path)));
        let items = survived(path, found)?.unwrap_or_default();
        let report = DocumentReport::new(items, part.known.get(path).map(String::as_str));
        let version = snapshot.open.get(path).map(|file| i64::from(file.version));
        Ok(Some(report.into_workspace(uri, version)))
    });
    let reports: Cancellable<Vec<_>> = reports.into_iter().collect();
    Ok(reports?.into_iter().flatten().collect())
}

/// An empty report for a file that left the workspace.
pub(crate) fn gone(known: PreviousResultId) -> WorkspaceDocumentDiagnosticReport {
    DocumentReport::new(Vec::new(), Some(&known.value)).into_workspace(known.uri, None)
}

pub(crate) fn is_unchanged(report: &WorkspaceDocumentDiagnosticReport) -> bool {
    matches!(report, WorkspaceDocumentDiagnosticReport::Unchanged(_))
}

impl DocumentReport {
    fn new(items: Vec<Diagnostic>, known: Option<&str>) -> DocumentReport {
        let mut hasher = FxHasher::default();
        // The protocol's types do not implement `Hash`; their debug text is hashed instead.
        format!("{items:?}").hash(&mut hasher);
        let result_id = format!("{:016x}", hasher.finish());
        let unchanged = known == Some(result_id.as_str());
        DocumentReport { items: (!unchanged).then_some(items), result_id }
    }

    /// The answer of `textDocument/diagnostic`.
    pub(crate) fn into_document(self) -> DocumentDiagnosticReportResult {
        let report = match self.items {
            Some(items) => RelatedFullDocumentDiagnosticReport {
                full_document_diagnostic_report: FullDocumentDiagnosticReport {
                    result_id: Some(self.result_id),
                    items,
                },
                ..RelatedFullDocumentDiagnosticReport::default()
            }
            .into(),
            // The default report is that of an unknown document: it has no diagnostics.
            None if self.result_id.is_empty() => {
                RelatedFullDocumentDiagnosticReport::default().into()
            }
            None => DocumentDiagnosticReport::Unchanged(RelatedUnchangedDocumentDiagnosticReport {
                unchanged_document_diagnostic_report: UnchangedDocumentDiagnosticReport {
                    result_id: self.result_id,
                },
                related_documents: None,
            }),
        };
        DocumentDiagnosticReportResult::Report(report)
    }

    fn into_workspace(self, uri: Uri, version: Option<i64>) -> WorkspaceDocumentDiagnosticReport {
        match self.items {
            Some(items) => WorkspaceFullDocumentDiagnosticReport {
                uri,
                version,
                full_document_diagnostic_report: FullDocumentDiagnosticReport {
                    result_id: Some(self.result_id),
                    items,
                },
            }
            .into(),
            None => WorkspaceDocumentDiagnosticReport::Unchanged(
                WorkspaceUnchangedDocumentDiagnosticReport {
                    uri,
                    version,
                    unchanged_document_diagnostic_report: UnchangedDocumentDiagnosticReport {
                        result_id: self.result_id,
                    },
                },
            ),
        }
    }
}

/// Files to report on, each group by path.
#[derive(Default)]
pub(crate) struct Listing {
    pub(crate) open: Vec<Utf8PathBuf>,
    pub(crate) rest: Vec<Utf8PathBuf>,
}

/// Every file of every unit, except units that make analysis panic.
pub(crate) fn listing(snapshot: &Snapshot, (): &()) -> Cancellable<Listing> {
    let units = snapshot.on_all_cores(&snapshot.roots, |snapshot, root| {
        survived(root, panic::isolate(|| snapshot.analysis.files_of_root(root)))
    });
    let mut files = BTreeSet::new();
    for unit in units {
        files.extend(unit?.into_iter().flatten());
    }
    let is_open = |path: &Utf8PathBuf| snapshot.open.contains_key(path);
    let (open, rest) = files.into_iter().partition(is_open);
    Ok(Listing { open, rest })
}

/// The result, or `None` after a panic: work on many files continues with the other files.
pub(crate) fn survived<R>(
    path: &Utf8Path,
    result: std::result::Result<Cancellable<R>, String>,
) -> Cancellable<Option<R>> {
    match result {
        Ok(Ok(value)) => Ok(Some(value)),
        Ok(Err(cancelled)) => Err(cancelled),
        Err(message) => {
            tracing::error!(%path, "diagnostics panicked: {message}");
            Ok(None)
        }
    }
}

/// The lowest severity that is reported for a file. Files that are not open and not in the workspace have
/// errors reported only.
pub(crate) fn least(snapshot: &Snapshot, path: &Utf8Path) -> Severity {
    if snapshot.open.contains_key(path) || snapshot.in_workspace(path) {
        Severity::Hint
    } else {
        Severity::Error
    }
}

/// Diagnostics of a file, from a severity up.
pub(crate) fn file_diagnostics(
    snapshot: &Snapshot,
    path: &Utf8Path,
    least: Severity,
) -> Cancellable<Vec<Diagnostic>> {
    let mut items = Vec::new();
    let all = (super::features_of(snapshot, path).diagnostics)(snapshot, path)?;
    for diagnostic in all {
        // Clients that support clangd's notification grey the regions by it.
        let greyed = diagnostic.code == INACTIVE_CODE && snapshot.client.inactive_regions;
        if diagnostic.severity <= least
            && !greyed
            && let Some(item) = diagnostic::to_proto(snapshot, &diagnostic)?
        {
            items.push(item);
        }
    }
    Ok(items)
}

/// Regions of a file that conditionals exclude.
pub(crate) fn inactive_ranges(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Vec<Range>> {
    let Some(lines) = snapshot.lines(path)? else {
        return Ok(Vec::new());
    };
    let regions = snapshot.analysis.inactive_regions(path)?;
    Ok(regions.iter().map(|region| lines.range(region)).collect())
}
