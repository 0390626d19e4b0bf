//! Which components have their codels in which folder.

use std::collections::BTreeMap;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::Severity;
use dotgen_analysis::host::{Analysis, Cancellable, UnitResult};
use dotgen_analysis::model::{ComponentKind, Name};
use dotgen_analysis::source_map::Locations;
use rustc_hash::{FxHashMap, FxHashSet};

use super::{
    allow,
    command::{Side, diagnostics},
    drift::{self, Drift, DriftOptions},
    expected::Expected,
    files::Sources,
};

/// A folder of codels and the components whose codels it holds.
pub struct Folder {
    /// The `.gen` that declares the components.
    pub specification: Utf8PathBuf,
    /// Its unit.
    pub unit: UnitResult,
    /// Indexes into the components of the unit.
    pub components: Vec<u32>,
    /// The other side.
    pub sources: Sources,
    /// Names of codels of other specifications beside this one.
    pub also_named: FxHashSet<Name>,
}

impl Folder {
    /// Keeps the components whose name is wanted.
    pub fn retain(&mut self, mut wanted: impl FnMut(&Name) -> bool) {
        let components = &self.unit.spec.components;
        self.components
            .retain(|it| wanted(&components[*it as usize].name));
    }

    /// What the components want.
    pub fn expected(&self) -> Vec<Expected<'_>> {
        let components = self.components.iter();
        components
            .map(|&it| Expected::new(&self.unit.spec, it))
            .collect()
    }

    /// Compares both sides.
    pub fn check(&self, all: &[Expected<'_>]) -> Vec<Drift> {
        let options = DriftOptions {
            also_named: self.also_named.clone(),
            ..DriftOptions::default()
        };
        drift::check(all, &self.sources, &options)
    }

    /// Findings as the configuration and the comments on both sides want them: with their
    /// severities, without what is switched off or allowed.
    pub fn adjust(&self, findings: Vec<Drift>, analysis: &Analysis) -> Cancellable<Vec<Drift>> {
        let mut out = Vec::with_capacity(findings.len());
        for mut drift in findings {
            let source = drift.source.as_ref();
            let file = source.and_then(|it| Some((self.sources.file(&it.path)?, it.range.start)));
            if file.is_some_and(|(file, at)| allow::is_allowed(file, at, drift.code.as_str())) {
                continue;
            }
            let one = diagnostics(
                std::slice::from_ref(&drift),
                &*self.unit.locations,
                Side::First,
            );
            if let Some(it) = analysis.adjusted(one)?.first() {
                drift.severity = it.severity;
                out.push(drift);
            }
        }
        Ok(out)
    }
}

/// The folders of codels of all components that a unit declares. `sources` reads the folder of a
/// `.gen`. A unit with errors has none: why.
pub fn folders(
    root: &Utf8Path,
    unit: &UnitResult,
    sources: &mut dyn FnMut(&Utf8Path) -> Sources,
) -> Result<Vec<Folder>, String> {
    // A model with errors has gaps that would be reported as drift.
    if !unit.accepted() {
        let mut errors = unit
            .diagnostics
            .iter()
            .filter(|it| it.severity == Severity::Error);
        let first = errors.next().map(|it| it.message.as_str());
        return Err(format!(
            "{root}: not compared with its codels: the specification has {} error(s), the first: {}",
            errors.count() + 1,
            first.unwrap_or_default()
        ));
    }
    let mut by_file: BTreeMap<Utf8PathBuf, Vec<u32>> = BTreeMap::new();
    for (index, component) in (0u32..).zip(&unit.spec.components) {
        let location = unit.locations.locate(component.src);
        let is_component = component.kind == ComponentKind::Component;
        if let Some(location) = location.filter(|_| is_component) {
            by_file.entry(location.path).or_default().push(index);
        }
    }
    let folder = |(specification, components): (Utf8PathBuf, Vec<u32>)| Folder {
        sources: sources(&specification),
        specification,
        unit: unit.clone(),
        components,
        also_named: FxHashSet::default(),
    };
    Ok(by_file.into_iter().map(folder).collect())
}

/// Specifications in one folder share its codels: each learns the names that the others use.
pub fn share_names(folders: &mut [Folder]) {
    let mut names: FxHashMap<Utf8PathBuf, FxHashSet<Name>> = FxHashMap::default();
    for folder in folders.iter() {
        let known = names.entry(folder.sources.folder.clone()).or_default();
        for component in &folder.unit.spec.components {
            let codels = component.all_codels();
            known.extend(codels.map(|it| component.codel(it).name.clone()));
        }
    }
    for folder in folders {
        if let Some(names) = names.get(&folder.sources.folder) {
            folder.also_named = names.clone();
        }
    }
}
