//! `textDocument/diagnostic` and `workspace/diagnostic`: diagnostics that the client pulls.

use std::collections::BTreeSet;
use std::hash::{Hash, Hasher};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::Severity;
use dotgen_analysis::host::Cancellable;
use rustc_hash::{FxHashMap, FxHasher};

use super::{scenario, verification};
use crate::codels;
use crate::convert::{diagnostic, uri};
use crate::panic;
use crate::proto::*;
use crate::snapshot::{Snapshot, Subject};
use crate::templates;

/// Marks text that a conditional leaves out.
const INACTIVE_CODE: &str = "inactive-code";

/// Diagnostics of a document, or that they are what the client has.
#[derive(Default)]
pub(crate) struct Report {
    result_id: String,
    /// `None`: unchanged.
    items: Option<Vec<Diagnostic>>,
}

/// `textDocument/diagnostic`
pub(crate) fn document(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &DocumentDiagnosticParams,
) -> Cancellable<Report> {
    let items = file_diagnostics(snapshot, &subject.path, Severity::Hint)?;
    Ok(Report::new(items, params.previous_result_id.as_deref()))
}

/// `workspace/diagnostic`: every file of every unit.
pub(crate) fn workspace(
    snapshot: &Snapshot,
    params: &WorkspaceDiagnosticParams,
) -> Cancellable<Vec<WorkspaceDocumentDiagnosticReport>> {
    let previous: FxHashMap<_, _> = params
        .previous_result_ids
        .iter()
        .map(|it| (uri::to_path(&it.uri), it))
        .collect();
    let paths = files(snapshot)?;
    let mut reports = Vec::new();
    for path in &paths {
        let Some(uri) = snapshot.uri(path) else {
            continue;
        };
        let known = previous.get(path).map(|it| it.value.as_str());
        let found = panic::isolate(|| file_diagnostics(snapshot, path, least(snapshot, path)));
        let items = survived(path, found)?.unwrap_or_default();
        let report = Report::new(items, known);
        let version = snapshot.open.get(path).map(|it| i64::from(it.version));
        reports.push(report.into_workspace(uri, version));
    }
    // Files that left the workspace are in order now.
    for (path, id) in previous {
        if !paths.contains(&path) {
            let report = Report::new(Vec::new(), Some(&id.value));
            reports.push(report.into_workspace(id.uri.clone(), None));
        }
    }
    Ok(reports)
}

/// Whether a workspace report says nothing new.
pub(crate) fn is_unchanged(reports: &[WorkspaceDocumentDiagnosticReport]) -> bool {
    let unchanged = |it: &WorkspaceDocumentDiagnosticReport| {
        matches!(it, WorkspaceDocumentDiagnosticReport::Unchanged(_))
    };
    reports.iter().all(unchanged)
}

impl Report {
    fn new(items: Vec<Diagnostic>, known: Option<&str>) -> Report {
        let mut hasher = FxHasher::default();
        // The protocol's types do not hash; their text does.
        format!("{items:?}").hash(&mut hasher);
        let result_id = format!("{:016x}", hasher.finish());
        let unchanged = known == Some(result_id.as_str());
        Report {
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

/// Every file of every unit. A unit that makes analysis panic is left out.
pub(crate) fn files(snapshot: &Snapshot) -> Cancellable<BTreeSet<Utf8PathBuf>> {
    let mut files = BTreeSet::new();
    for root in snapshot.roots.iter() {
        let unit = panic::isolate(|| snapshot.analysis.root_unit(root));
        files.extend(survived(root, unit)?.into_iter().flat_map(|it| it.files));
    }
    Ok(files)
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
    let is_template = snapshot.is_template(path);
    let mut all = match snapshot.is_code(path) {
        true => Vec::new(),
        false if is_template => templates::diagnostics(snapshot, path)?,
        false if scenario::is(path) => scenario::diagnostics(snapshot, path)?,
        false => snapshot.analysis.diagnostics(path)?,
    };
    if !scenario::is(path) && !is_template {
        all.extend(verification::in_specification(snapshot, path)?);
        all.extend(codels::file_diagnostics(snapshot, path)?);
    }
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
