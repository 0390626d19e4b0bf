//! `textDocument/diagnostic` and `workspace/diagnostic`: diagnostics that the client pulls.

use std::collections::BTreeSet;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::Severity;
use dotgen_analysis::host::Cancellable;
use rustc_hash::{FxHashMap, FxHasher};

use crate::features::convert::diagnostic;
use crate::features::language::Language;
use crate::panic;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

/// Marks text that a conditional leaves out.
const INACTIVE_CODE: &str = "inactive-code";

/// Diagnostics of a document, or that they are what the client has.
#[derive(Default)]
pub(crate) struct DocumentReport {
    result_id: String,
    /// `None`: unchanged.
    items: Option<Vec<Diagnostic>>,
}

/// `textDocument/diagnostic`. Editors ask other servers for those of sources.
pub(crate) fn document(
    language: &dyn Language,
    snapshot: &Snapshot,
    subject: &Subject,
    params: &DocumentDiagnosticParams,
) -> Cancellable<DocumentReport> {
    if !language.is_own() && !snapshot.client.pull_sources {
        return Ok(DocumentReport::default());
    }
    let items = file_diagnostics(snapshot, &subject.path, Severity::Hint)?;
    Ok(DocumentReport::new(
        items,
        params.previous_result_id.as_deref(),
    ))
}

/// Some files of the workspace, and what the client has of them.
pub(crate) struct Part {
    pub(crate) paths: Vec<Utf8PathBuf>,
    /// By path.
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
        let version = snapshot.open.get(path).map(|it| i64::from(it.version));
        Ok(Some(report.into_workspace(uri, version)))
    });
    let reports: Cancellable<Vec<_>> = reports.into_iter().collect();
    Ok(reports?.into_iter().flatten().collect())
}

/// A file that left the workspace is in order now.
pub(crate) fn gone(known: PreviousResultId) -> WorkspaceDocumentDiagnosticReport {
    DocumentReport::new(Vec::new(), Some(&known.value)).into_workspace(known.uri, None)
}

/// Whether a report says nothing new.
pub(crate) fn is_unchanged(report: &WorkspaceDocumentDiagnosticReport) -> bool {
    matches!(report, WorkspaceDocumentDiagnosticReport::Unchanged(_))
}

impl DocumentReport {
    fn new(items: Vec<Diagnostic>, known: Option<&str>) -> DocumentReport {
        let mut hasher = FxHasher::default();
        // The protocol's types do not hash; their text does.
        format!("{items:?}").hash(&mut hasher);
        let result_id = format!("{:016x}", hasher.finish());
        let unchanged = known == Some(result_id.as_str());
        DocumentReport {
            items: (!unchanged).then_some(items),
            result_id,
        }
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
            // The default report, of a document nobody knows, says that there is nothing.
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

/// Files to look at, each group by path.
#[derive(Default)]
pub(crate) struct Listing {
    pub(crate) open: Vec<Utf8PathBuf>,
    pub(crate) rest: Vec<Utf8PathBuf>,
}

/// Every file of every unit. A unit that makes analysis panic is left out.
pub(crate) fn listing(snapshot: &Snapshot, (): &()) -> Cancellable<Listing> {
    let units = snapshot.on_all_cores(&snapshot.roots, |snapshot, root| {
        survived(
            root,
            panic::isolate(|| snapshot.analysis.files_of_root(root)),
        )
    });
    let mut files = BTreeSet::new();
    for unit in units {
        files.extend(unit?.into_iter().flatten());
    }
    let is_open = |it: &Utf8PathBuf| snapshot.open.contains_key(it);
    let (open, rest) = files.into_iter().partition(is_open);
    Ok(Listing { open, rest })
}

/// The answer, or nothing if there was a panic instead: work on many files goes on with the others.
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

/// What is told of a file: of files of others only what keeps the user's own from being accepted.
pub(crate) fn least(snapshot: &Snapshot, path: &Utf8Path) -> Severity {
    match snapshot.open.contains_key(path) || snapshot.in_workspace(path) {
        true => Severity::Hint,
        false => Severity::Error,
    }
}

/// Diagnostics of a file, down to a severity.
pub(crate) fn file_diagnostics(
    snapshot: &Snapshot,
    path: &Utf8Path,
    least: Severity,
) -> Cancellable<Vec<Diagnostic>> {
    let mut items = Vec::new();
    let all = super::language_of(snapshot, path).diagnostics(snapshot, path)?;
    for it in all {
        // Clients that know clangd's notification grey the regions themselves.
        let greyed = it.code == INACTIVE_CODE && snapshot.client.inactive_regions;
        if it.severity <= least
            && !greyed
            && let Some(item) = diagnostic::to_proto(snapshot, &it)?
        {
            items.push(item);
        }
    }
    Ok(items)
}

/// Regions of a file that conditionals leave out.
pub(crate) fn inactive_ranges(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Vec<Range>> {
    let Some(lines) = snapshot.lines(path)? else {
        return Ok(Vec::new());
    };
    let regions = snapshot.analysis.inactive_regions(path)?;
    Ok(regions.iter().map(|it| lines.range(it)).collect())
}
