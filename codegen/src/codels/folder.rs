//! Components by the folder of their codels.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::codes::CODEL;
use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use dotgen_analysis::host::{Analysis, Cancellable, UnitResult};
use dotgen_analysis::model::{ComponentId, ComponentKind, Missing, Name};
use dotgen_analysis::source_map::Locations;
use rustc_hash::{FxHashMap, FxHashSet};

use super::{
    allowances::{allowances, is_allowed},
    coverage::Coverage,
    diagnostics::{Side, diagnostics},
    drift::{self, Drift, DriftOptions},
    expected::Expected,
    files::{IndexedFile, Sources},
    reliability::Reliability,
    source::Function,
};
use crate::lang::Language;

/// A folder of codels and the components whose codels it holds.
pub struct Folder {
    /// The `.gen` that declares the components.
    pub specification: Utf8PathBuf,
    pub unit: UnitResult,
    /// Indexes into the components of the unit.
    pub components: Vec<ComponentId>,
    /// The sources in the folder.
    pub sources: Sources,
    /// Names of codels of other specifications in the same folder.
    pub also_named: FxHashSet<Name>,
    /// The reliable part of the specification.
    pub trust: Arc<Reliability>,
    /// True if the unit is of an earlier text, because the present one has syntax errors.
    pub is_earlier: bool,
}

impl Folder {
    /// Keeps the components whose name is wanted.
    pub fn retain(&mut self, mut wanted: impl FnMut(&Name) -> bool) {
        let components = &self.unit.spec.components;
        self.components.retain(|component| wanted(&components[*component].name));
    }

    /// The functions that the components require.
    pub fn expected(&self) -> Vec<Expected<'_>> {
        let spec = &self.unit.spec;
        let components = self.components.iter();
        components
            .map(|&component| {
                // The language of a missing interface is read from the sources.
                let unsaid = spec.gaps_of(component).any(|gap| *gap == Missing::Language);
                if unsaid && self.sources.uses_cxx() {
                    Expected::in_language(spec, component, Language::Cxx)
                } else {
                    Expected::new(spec, component)
                }
            })
            .collect()
    }

    /// The part of the codels that can be compared.
    pub fn coverage(&self, all: &[Expected<'_>]) -> Coverage {
        let mut out = Coverage::default();
        for expected in all {
            out.add(expected, &self.trust);
        }
        out
    }

    /// Compares both sides.
    pub fn check(&self, all: &[Expected<'_>]) -> Vec<Drift> {
        drift::check(all, &self.sources, &self.options())
    }

    /// Functions of the sources that look like codels and that no specification names.
    pub fn unnamed(&self, all: &[Expected<'_>]) -> Vec<(&IndexedFile, &Function)> {
        drift::unnamed(all, &self.sources, &self.options())
    }

    fn options(&self) -> DriftOptions {
        DriftOptions { also_named: self.also_named.clone(), trust: self.trust.clone() }
    }

    /// Findings after configuration and comments on both sides are applied: with their severities, without
    /// those that are switched off or allowed.
    pub fn adjust(&self, findings: Vec<Drift>, analysis: &Analysis) -> Cancellable<Vec<Drift>> {
        let mut out = Vec::with_capacity(findings.len());
        let mut missing: BTreeMap<ComponentId, usize> = BTreeMap::new();
        for mut drift in findings {
            if drift.code() == drift::MISSING_DEFINITION {
                *missing.entry(drift.component).or_default() += 1;
            }
            let source = drift.source.as_ref();
            let file = source
                .and_then(|source| Some((self.sources.file(&source.path)?, source.range.start)));
            if file.is_some_and(|(file, at)| is_allowed(file, at, drift.code())) {
                continue;
            }
            if let Some(severity) = self.severity(&drift, analysis)? {
                drift.severity = severity;
                out.push(drift);
            }
        }
        for (index, count) in missing {
            let component = &self.unit.spec.components[index];
            let codels = component.all_codels().map(|at| &component.codel(at).name);
            let functions = codels.collect::<FxHashSet<_>>().len();
            let defined = functions.saturating_sub(count);
            if let Some(unwritten) = drift::unwritten((index, component), &mut out, defined)
                && self.severity(&unwritten, analysis)?.is_some()
            {
                out.push(unwritten);
            }
        }
        Ok(out)
    }

    /// The severity of a finding by the configuration; `None` if it is switched off, or a comment of the
    /// specification allows it.
    fn severity(&self, drift: &Drift, analysis: &Analysis) -> Cancellable<Option<Severity>> {
        let one = diagnostics(std::slice::from_ref(drift), &*self.unit.locations, Side::First);
        let adjusted = analysis.adjusted(one)?;
        Ok(adjusted.first().map(|diagnostic| diagnostic.severity))
    }
}

/// The folders of codels of all components that a unit declares. `sources` reads the folder of a `.gen`. In a
/// unit with errors, the declarations without errors are compared: see [`Reliability`].
pub fn folders(unit: &UnitResult, sources: &mut dyn FnMut(&Utf8Path) -> Sources) -> Vec<Folder> {
    let trust = Arc::new(Reliability::of(unit));
    let mut by_file: BTreeMap<Utf8PathBuf, Vec<ComponentId>> = BTreeMap::new();
    for (index, component) in unit.spec.components.iter_enumerated() {
        let location = unit.locations.locate(component.src);
        let is_component = component.kind == ComponentKind::Component;
        if let Some(location) = location.filter(|_| is_component) {
            by_file.entry(location.path).or_default().push(index);
        }
    }
    let folder = |(specification, components): (Utf8PathBuf, Vec<ComponentId>)| Folder {
        sources: sources(&specification),
        specification,
        unit: unit.clone(),
        components,
        also_named: FxHashSet::default(),
        trust: trust.clone(),
        is_earlier: false,
    };
    by_file.into_iter().map(folder).collect()
}

/// True if the sources disprove a finding about a specification: they raise an exception that is in no
/// `throw` list. `text`: the text of the finding's file.
pub fn is_refuted(finding: &Diagnostic, text: &str, sources: &Sources) -> bool {
    let name = text.get(finding.range.clone()).unwrap_or_default();
    finding.code == NEVER_THROWN && !name.is_empty() && sources.mention(name)
}

/// The code of the finding that an exception is never thrown.
pub const NEVER_THROWN: &str = "unused/exception";

/// Adds to each folder the codel names of the other specifications in the same folder.
pub(crate) fn share_names(folders: &mut [Folder]) {
    let mut names: FxHashMap<Utf8PathBuf, FxHashSet<Name>> = FxHashMap::default();
    for folder in folders.iter() {
        let known = names.entry(folder.sources.folder.clone()).or_default();
        for component in &folder.unit.spec.components {
            let codels = component.all_codels();
            known.extend(codels.map(|codel| component.codel(codel).name.clone()));
        }
    }
    for folder in folders {
        if let Some(names) = names.get(&folder.sources.folder) {
            folder.also_named = names.clone();
        }
    }
}

/// Comments that allow findings which do not occur, in specifications and sources. `compared` has folders
/// with all their differences, allowed or not.
///
/// # Errors
/// The query was cancelled.
pub fn unused_allowances(
    compared: &[(&Folder, &[Drift])],
    analysis: &Analysis,
) -> Cancellable<Vec<Diagnostic>> {
    let mut out: Vec<Diagnostic> = Vec::new();
    let known = drift::CODES.map(|known| known.0);
    // A folder that is not completely read may contain the finding that a comment allows.
    let seen = |folder: &Folder| folder.sources.exists && !folder.sources.incomplete;
    let compared = || compared.iter().filter(|(folder, _)| seen(folder));
    for (folder, findings) in compared() {
        let found = diagnostics(findings, &*folder.unit.locations, Side::Both);
        let specification = &folder.specification;
        let unused = analysis.unused_allowances(specification, CODEL, &known, &found)?;
        out.extend(unused);
        let expected = OnceCell::new();
        for file in folder.sources.all() {
            for allowance in allowances(file) {
                let has = |found: &&Drift| {
                    let place = found.source.as_ref().filter(|at| at.path == file.path);
                    found.code() == allowance.code
                        && place.is_some_and(|at| allowance.scope.contains(&at.range.start))
                };
                // A function that none of these specifications names may belong to another one.
                let speaks = allowance.code.starts_with(CODEL)
                    && names(expected.get_or_init(|| folder.expected()), &allowance.function.name);
                if !speaks
                    || analysis.is_off(allowance.code)?
                    || compared().flat_map(|(_, findings)| *findings).any(|drift| has(&drift))
                {
                    continue;
                }
                let known = known.contains(&allowance.code);
                out.push(Analysis::unused_allowance(
                    allowance.code,
                    known,
                    &file.path,
                    allowance.range,
                ));
            }
        }
    }
    analysis.adjusted(out)
}

fn names(expected: &[Expected<'_>], function: &str) -> bool {
    let mut functions = expected.iter().flat_map(|expected| &expected.functions);
    functions.any(|candidate| candidate.name == function)
}
