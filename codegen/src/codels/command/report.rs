//! Findings as reports and as diagnostics of editors.

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::{Severity, Wording};
use dotgen_analysis::source_map::Locations;
use serde::Serialize;

use super::{Folder, project::Project};
use crate::codels::coverage::Coverage;

/// Result of `check`.
#[derive(Debug, Clone, Default, Serialize)]
pub struct CheckReport {
    /// By file of the specification, in the order of [`crate::codels::drift::check`].
    pub findings: Vec<Finding>,
    /// The compared folders.
    pub folders: Vec<FolderSummary>,
    /// Specifications that could not be compared, with the reason.
    pub errors: Vec<String>,
}

/// The result for one folder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FolderSummary {
    /// The `.gen`.
    pub specification: Utf8PathBuf,
    /// The folder of codels.
    pub folder: Utf8PathBuf,
    /// True if the folder exists.
    pub exists: bool,
    /// Names of its components.
    pub components: Vec<String>,
    /// Number of sources read.
    pub sources: usize,
    /// Number of functions that the specification names.
    pub codels: usize,
    /// Number of these functions that have a definition.
    pub defined: usize,
    /// The compared part of them.
    pub coverage: Coverage,
}

/// One finding with its places.
#[derive(Debug, Clone, Serialize)]
pub struct Finding {
    /// `codel/…`
    pub code: &'static str,
    pub severity: Severity,
    pub component: String,
    /// The description.
    pub message: Wording,
    /// The first place: in the source if it has one, else in the specification.
    pub at: Option<FindingPlace>,
    /// The places on the other side.
    pub related: Vec<FindingPlace>,
    /// The text that the specification requires.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected: Option<String>,
    /// The text in the source.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub found: Option<String>,
}

/// A place of a finding. Lines and columns count from 1; columns are in bytes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FindingPlace {
    /// The file.
    pub path: Utf8PathBuf,
    /// Byte offsets.
    pub start: usize,
    /// See [`FindingPlace::start`].
    pub end: usize,
    /// Line of the start.
    pub line: usize,
    /// Column of the start.
    pub column: usize,
}

impl CheckReport {
    pub(super) fn add(&mut self, project: &Project<'_>, folder: &Folder) {
        let all = folder.expected();
        let files = || folder.sources.all();
        let functions = all.iter().flat_map(|expected| &expected.functions);
        let defined = functions.clone().filter(|function| {
            files().any(|file| file.index().definitions(&function.name).next().is_some())
        });
        self.folders.push(FolderSummary {
            specification: folder.specification.clone(),
            folder: folder.sources.folder.clone(),
            exists: folder.sources.exists,
            components: all.iter().map(|expected| expected.component().name.to_string()).collect(),
            sources: folder.sources.sources.len(),
            codels: functions.clone().count(),
            defined: defined.count(),
            coverage: folder.coverage(&all),
        });
        let place = |path: &Utf8Path, range: std::ops::Range<usize>| {
            let text = project.text(path).unwrap_or_default();
            let before = text.as_bytes().get(..range.start).unwrap_or_default();
            let line_start =
                before.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
            FindingPlace {
                path: path.to_owned(),
                start: range.start,
                end: range.end,
                line: 1 + before.iter().filter(|byte| **byte == b'\n').count(),
                column: 1 + range.start - line_start,
            }
        };
        for drift in project.findings(folder, &all) {
            let source =
                drift.source.iter().map(|source| place(&source.path, source.range.clone()));
            let spec = drift.spec.iter().filter_map(|&spec| folder.unit.locations.locate(spec));
            let spec = spec.map(|spec| place(&spec.path, spec.range));
            let mut places = source.chain(spec);
            let component = &folder.unit.spec.components[drift.component];
            self.findings.push(Finding {
                code: drift.code(),
                severity: drift.severity,
                component: component.name.to_string(),
                at: places.next(),
                related: places.collect(),
                message: drift.message(),
                expected: drift.expected,
                found: drift.found,
            });
        }
    }
}
