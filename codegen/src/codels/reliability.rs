//! The reliable part of a specification with errors, for the comparison with its codels.
//!
//! An error excludes the codel whose declaration contains it. After a syntax error, declarations may be
//! missing: what is found because the specification lacks a name, an exception or a member waits until the
//! text parses. Packages and files that are missing on this machine are not errors of the text: see
//! [`dotgen_analysis::model::gaps`].

use camino::Utf8PathBuf;
use dotgen_analysis::host::UnitResult;
use dotgen_analysis::model::{CodelRef, ComponentId, Name};
use dotgen_analysis::source_map::{Location, Locations};
use dotgen_syntax::codes as syntax;
use rustc_hash::FxHashSet;
use std::sync::Arc;

use super::expected::{Expected, ExpectedFunction};

/// The reliable part of a specification. By default it is the whole specification.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Reliability {
    /// True if files or packages are missing on this machine.
    pub lacks_files: bool,
    /// True if the text has syntax errors, or ends inside a declaration: it may declare names that are not in
    /// the specification yet.
    pub lacks_text: bool,
    /// Codels with errors in their declaration, by component.
    faulty: FxHashSet<(ComponentId, CodelRef)>,
    /// Words in the text that could not be parsed, which may be names.
    words: Arc<FxHashSet<Name>>,
}

/// An error and its place.
struct Fault<'a> {
    path: &'a Utf8PathBuf,
    start: usize,
    end: usize,
    /// True if text around it may have been skipped.
    loses_text: bool,
}

impl Fault<'_> {
    fn touches(&self, place: &Location) -> bool {
        place.path == *self.path && self.start <= place.range.end && place.range.start <= self.end
    }
}

impl Reliability {
    /// The reliable part of a unit.
    pub fn of(unit: &UnitResult) -> Reliability {
        let mut trust = Reliability { lacks_files: unit.lacks_files(), ..Reliability::default() };
        let faults: Vec<Fault<'_>> = (unit.errors_in_text())
            .map(|error| Fault {
                path: &error.path,
                start: error.range.start,
                end: error.range.end,
                loses_text: syntax::find(error.code).is_some() && error.code != "missing-semicolon",
            })
            .collect();
        if faults.is_empty() {
            return trust;
        }
        trust.words = unit.words.clone();
        let is_cut =
            unit.is_cut || (unit.diagnostics.iter()).any(|error| syntax::is_cut(error.code));
        trust.lacks_text = is_cut || unit.has_syntax_errors();
        let codels: Vec<(ComponentId, CodelRef, Location)> = unit
            .spec
            .components
            .iter_enumerated()
            .flat_map(|(index, component)| {
                component.all_codels().map(move |at| (index, at, component.codel(at).node))
            })
            .filter_map(|(index, at, node)| Some((index, at, unit.locations.locate(node)?)))
            .collect();
        for fault in &faults {
            let hit = codels.iter().filter(|codel| fault.touches(&codel.2));
            // At the beginning of a codel, the declaration before it ends too early.
            let inside_codel = hit.clone().any(|codel| codel.2.range.start < fault.start);
            let hit: Vec<_> = hit.map(|hit| (hit.0, hit.1)).collect();
            trust.faulty.extend(hit);
            if fault.loses_text && !inside_codel {
                // The declaration before the error may be incomplete.
                let before = codels.iter().filter(|codel| codel.2.path == *fault.path);
                let before = before.filter(|codel| codel.2.range.end <= fault.start);
                let last = before.clone().map(|codel| codel.2.range.end).max();
                let last = before.filter(|codel| Some(codel.2.range.end) == last);
                trust.faulty.extend(last.map(|codel| (codel.0, codel.1)));
            }
        }
        trust
    }

    /// Excludes the codels whose declaration was changed since, because their new declaration is not known
    /// yet. `changed` returns true for a changed place of the unit.
    pub fn leave_out(&mut self, unit: &UnitResult, changed: &dyn Fn(&Location) -> bool) {
        for (index, component) in unit.spec.components.iter_enumerated() {
            for at in component.all_codels() {
                let place = unit.locations.locate(component.codel(at).node);
                if place.is_some_and(|place| changed(&place)) {
                    self.faulty.insert((index, at));
                }
            }
        }
    }

    /// True if the declaration of a codel has errors, in any of its uses.
    pub(crate) fn is_faulty(&self, expected: &Expected<'_>, function: &ExpectedFunction) -> bool {
        let mut uses = function.uses.iter();
        uses.any(|&at| self.faulty.contains(&(expected.component, at)))
    }

    /// True if a name may be declared in text that could not be parsed.
    pub(crate) fn may_declare(&self, name: &str) -> bool {
        self.words.contains(name)
    }
}
