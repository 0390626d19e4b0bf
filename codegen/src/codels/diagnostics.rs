//! Differences between specifications and sources as diagnostics.

use dotgen_analysis::diagnostic::{Diagnostic, Related};
use dotgen_analysis::source_map::Locations;

use super::drift::Drift;

/// The files that get a diagnostic for a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Both files, for editors.
    Both,
    /// The source if the finding has a place there, else the specification.
    First,
}

/// Findings as diagnostics; each side has the other one as related information.
pub fn diagnostics(findings: &[Drift], locations: &dyn Locations, side: Side) -> Vec<Diagnostic> {
    let mut out = Vec::new();
    for drift in findings {
        let mut places: Vec<Related> = Vec::new();
        if let Some(source) = &drift.source {
            places.push(Related {
                path: source.path.clone(),
                range: source.range.clone(),
                message: "the function".into(),
            });
        }
        for location in drift.spec.iter().filter_map(|&spec| locations.locate(spec)) {
            places.push(Related {
                path: location.path,
                range: location.range,
                message: "the codel".into(),
            });
        }
        let count = match side {
            Side::Both => places.len(),
            Side::First => places.len().min(1),
        };
        for index in 0..count {
            let mut related = places.clone();
            let here = related.remove(index);
            out.push(Diagnostic {
                related,
                ..Diagnostic::new(
                    drift.code(),
                    drift.severity,
                    drift.message(),
                    here.path,
                    here.range,
                )
            });
        }
    }
    out
}
