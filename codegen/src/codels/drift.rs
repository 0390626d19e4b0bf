//! The differences between the specification and the C or C++ sources of a component.
//!
//! A finding has a place on both sides if both have one, and the repairs that remove it, the best first.
//! Facts that the texts do not contain (macros, helpers, other libraries) give no finding.

mod comment;
pub mod finding;
mod flow;
mod names;
mod orphan;
mod ports;
mod signature;

use std::ops::Range;
use std::sync::Arc;

use camino::Utf8PathBuf;
pub use dotgen_analysis::diagnostic::Severity;
use dotgen_analysis::diagnostic::Wording;
use dotgen_analysis::model::{CodelRef, Component, ComponentId, Name, Owner, Src, TypeId};
use rustc_hash::FxHashSet;

use self::finding::Difference;
use super::{
    expected::{Expected, ExpectedFunction},
    files::{IndexedFile, Sources},
    reliability::Reliability,
    source::Function,
};

/// The code of [`Difference::Missing`].
pub const MISSING_DEFINITION: &str = "codel/missing-definition";
/// The code of [`Difference::Signature`].
pub(super) const SIGNATURE_MISMATCH: &str = "codel/signature-mismatch";
/// The code of [`Difference::Orphan`].
pub const ORPHAN: &str = "codel/orphan";

/// The codes of all differences, with their default severities.
pub const CODES: [(&str, Severity); 10] = [
    (MISSING_DEFINITION, Severity::Warning),
    (SIGNATURE_MISMATCH, Severity::Warning),
    ("codel/undeclared-yield", Severity::Warning),
    ("codel/never-yielded", Severity::Hint),
    ("codel/undeclared-throw", Severity::Warning),
    (ORPHAN, Severity::Information),
    ("codel/stale-comment", Severity::Information),
    ("codel/undeclared-name", Severity::Warning),
    ("codel/constant-write", Severity::Warning),
    ("codel/unwritten-port", Severity::Warning),
];

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourcePlace {
    /// The file.
    pub path: Utf8PathBuf,
    /// Byte offsets.
    pub range: Range<usize>,
}

/// One difference.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drift {
    pub severity: Severity,
    /// The details.
    pub kind: Difference,
    /// Component: index into the components of the specification.
    pub component: ComponentId,
    /// Places in the specification: the codel's name, or the state that is never returned.
    pub spec: Vec<Src>,
    pub source: Option<SourcePlace>,
    /// The text that the specification requires: the prototype.
    pub expected: Option<String>,
    /// The text in the source.
    pub found: Option<String>,
    /// The repairs, the best first as far as the texts alone show; see [`super::repair::Repairs::ordered`].
    pub repairs: Vec<Repair>,
}

impl Drift {
    /// A difference with its default severity, so far without a place in the sources and without repairs.
    fn new(kind: Difference, component: ComponentId, spec: Vec<Src>) -> Drift {
        let code = kind.code();
        let known = CODES.iter().find(|known| known.0 == code);
        Drift {
            severity: known.map_or(Severity::Warning, |known| known.1),
            kind,
            component,
            spec,
            source: None,
            expected: None,
            found: None,
            repairs: Vec::new(),
        }
    }

    /// The code in reports and in the configuration.
    pub fn code(&self) -> &'static str {
        self.kind.code()
    }

    /// The repair that adapts the sources to the specification, if it is the best one.
    pub fn following(&self) -> Option<&Repair> {
        self.repairs.first().filter(|repair| repair.follows_specification())
    }

    /// A description of the difference and of the correct form.
    pub fn message(&self) -> Wording {
        self.kind.wording()
    }
}

/// A change that removes a finding. [`crate::codels::repair`] turns it into text edits.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Repair {
    /// Write a stub.
    Stub { at: CodelRef },
    /// Give the function the prototype of the specification.
    UpdateSignature {
        /// Function and codel.
        name: Name,
        /// File of the function.
        path: Utf8PathBuf,
        /// Start of the function.
        start: usize,
    },
    /// Give the codel the parameters of its function.
    AdaptParameters {
        at: CodelRef,
        /// File of the function.
        path: Utf8PathBuf,
        /// Start of the function.
        start: usize,
    },
    /// Update the generated comment.
    RefreshComment {
        at: CodelRef,
        /// File of the comment.
        path: Utf8PathBuf,
        /// Start of the comment.
        start: usize,
    },
    /// Add a state to the `yield` list of a codel.
    AddYield {
        at: CodelRef,
        /// `state` or `pause::state`.
        state: String,
    },
    /// Remove a state from the `yield` list of a codel.
    RemoveYield {
        at: CodelRef,
        /// Index into its yields.
        index: usize,
    },
    /// Add an exception to the `throw` list of a task or service.
    AddThrow {
        /// Task or service.
        owner: Owner,
        exception: TypeId,
    },
    /// Add a state to the `yield` list of a codel, with a pause that the code does not make yet: without the
    /// pause, the codel would be in a cycle without `pause::`.
    AddPausedYield {
        at: CodelRef,
        /// The state, without `pause::`.
        state: String,
        /// The new return value of its function.
        returns: NameReplacement,
    },
    /// Let a function return a declared event in place of an undeclared one.
    ReturnDeclared(NameReplacement),
    /// Let a function raise a declared exception in place of an undeclared one.
    RaiseDeclared(NameReplacement),
    /// Rename a function to the name of a codel, everywhere in the sources.
    RenameFunction {
        /// Present name.
        from: Name,
        /// Name in the specification.
        to: Name,
    },
    /// Rename a codel to the name of a function, everywhere in the specification.
    RenameCodel {
        /// Name in the specification.
        from: Name,
        /// Name in the sources.
        to: Name,
    },
    /// Declare a codel for a function.
    DeclareCodel {
        /// The function.
        name: Name,
        /// File of the function.
        path: Utf8PathBuf,
        /// Start of the function.
        start: usize,
    },
}

impl Repair {
    /// True if it changes the behaviour of code, to agree with the specification.
    pub(crate) fn changes_code(&self) -> bool {
        matches!(self, Repair::ReturnDeclared(_) | Repair::RaiseDeclared(_))
    }

    /// True if it changes only the sources, and has no alternative that changes as little.
    pub(crate) fn follows_specification(&self) -> bool {
        matches!(
            self,
            Repair::Stub { .. }
                | Repair::UpdateSignature { .. }
                | Repair::RefreshComment { .. }
                | Repair::ReturnDeclared(_)
                | Repair::RenameFunction { .. }
        )
    }

    /// True if only the user can decide that it is right. It is then never applied without a request.
    pub fn is_choice(&self) -> bool {
        self.changes_code()
            || matches!(self, Repair::AddPausedYield { .. } | Repair::AdaptParameters { .. })
    }
}

/// A new name at some places of a source.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct NameReplacement {
    /// The function around them.
    pub function: Name,
    /// The file.
    pub path: Utf8PathBuf,
    /// Each place, with its new text.
    pub places: Vec<(Range<usize>, String)>,
    /// The new name in the spelling of the mapping.
    pub to: String,
}

/// The input of the comparison in addition to the two sides.
#[derive(Debug, Clone, Default)]
pub struct DriftOptions {
    /// Names of codels of specifications that share the sources.
    pub also_named: FxHashSet<Name>,
    /// The reliable part of the specification.
    pub trust: Arc<Reliability>,
}

/// Compares components with the sources they share. Findings are by component, in order of codels, then
/// orphans in text order.
pub fn check(all: &[Expected<'_>], sources: &Sources, options: &DriftOptions) -> Vec<Drift> {
    let mut out = Vec::new();
    if !sources.exists || sources.sources.is_empty() {
        return out;
    }
    let orphans = orphan::find(all, sources, options);
    let mut renamed = FxHashSet::default();
    for expected in all.iter().filter(|expected| are_here(expected, sources)) {
        let known = names::KnownNames::new();
        for function in &expected.functions {
            if options.trust.is_faulty(expected, function) {
                continue;
            }
            let check = Check { expected, function, sources, options };
            let definitions = check.definitions();
            if definitions.is_empty() {
                let mut uses = function.uses.iter();
                if !uses.any(|at| expected.has_stub(*at)) {
                    continue;
                }
                match orphan::renamed(&orphans, function, expected, sources) {
                    // The other name may be declared in text that does not parse.
                    Some(_) if options.trust.lacks_text => {}
                    Some(orphan) => {
                        renamed.insert(orphan.place());
                        out.push(check.renamed(orphan));
                    }
                    None => out.extend(check.missing()),
                }
                continue;
            }
            signature::check(&check, &definitions, &mut out);
            flow::check(&check, &definitions, &mut out);
            names::check(&check, &definitions, &known, &mut out);
            comment::check(&check, &definitions, &mut out);
        }
        ports::check(expected, sources, options, &mut out);
    }
    let alone = |input: &&FunctionIn<'_>| !renamed.contains(&input.place());
    let certain = orphan::are_certain(all, options);
    for orphan in orphans.iter().filter(|_| certain).filter(alone) {
        out.extend(orphan::report(orphan, all));
    }
    out
}

/// Maximum number of codels without a function that are each a warning, whatever the others are.
const FEW: usize = 2;

/// While most codels of a component have no function, its sources are being written: one warning says so, and
/// the findings at the codels become hints. `found` are all findings about the component that are reported,
/// and `defined` is the number of its codels with a function.
pub(super) fn unwritten(
    component: (ComponentId, &Component),
    found: &mut [Drift],
    defined: usize,
) -> Option<Drift> {
    let is_missing = |drift: &&mut Drift| {
        let of_component = drift.component == component.0;
        // A severity that the user has chosen stays.
        of_component && drift.code() == MISSING_DEFINITION && drift.severity == Severity::Warning
    };
    let count = found.iter_mut().filter(is_missing).count();
    if count <= defined.max(FEW) {
        return None;
    }
    for drift in found.iter_mut().filter(is_missing) {
        drift.severity = Severity::Hint;
    }
    let name = component.1.name.clone();
    let kind = Difference::Unwritten { component: name, count: count as u64 };
    Some(Drift::new(kind, component.0, vec![component.1.src]))
}

/// Functions that look like codels and that no specification names, with their files, in file and text order.
pub fn unnamed<'a>(
    all: &[Expected<'_>],
    sources: &'a Sources,
    options: &DriftOptions,
) -> Vec<(&'a IndexedFile, &'a Function)> {
    let found = orphan::find(all, sources, options);
    found.into_iter().map(|input| (input.file, input.function)).collect()
}

/// True if these sources contain a part of the component. Otherwise its codels are in other sources.
fn are_here(expected: &Expected<'_>, sources: &Sources) -> bool {
    let component = &expected.component().name;
    let prefix = format!("{component}_");
    let named = |file: &IndexedFile| {
        file.path
            .file_name()
            .is_some_and(|name| name.starts_with(&prefix) && name.contains("_codels."))
    };
    let defined = |file: &IndexedFile| {
        let mut names = expected.functions.iter();
        names.any(|name| file.index().definitions(&name.name).next().is_some())
    };
    sources.sources.iter().any(|source| named(source) || defined(source))
}

/// A function that the specification requires, and the sources to search.
struct Check<'a> {
    expected: &'a Expected<'a>,
    function: &'a ExpectedFunction,
    sources: &'a Sources,
    options: &'a DriftOptions,
}

/// A function and its file.
#[derive(Clone, Copy)]
struct FunctionIn<'a> {
    file: &'a IndexedFile,
    function: &'a Function,
}

impl FunctionIn<'_> {
    fn place(&self) -> (Utf8PathBuf, usize) {
        (self.file.path.clone(), self.function.span.start)
    }

    fn at(&self, range: Range<usize>) -> SourcePlace {
        SourcePlace { path: self.file.path.clone(), range }
    }
}

impl<'a> Check<'a> {
    fn definitions(&self) -> Vec<FunctionIn<'a>> {
        let files = self.sources.all();
        files
            .flat_map(|file| {
                let functions = file.index().definitions(&self.function.name);
                functions.map(move |function| FunctionIn { file, function })
            })
            .collect()
    }

    /// Places of all uses in the specification.
    fn places(&self) -> Vec<Src> {
        let component = self.expected.component();
        let uses = self.function.uses.iter();
        uses.map(|&at| component.codel(at).src).collect()
    }

    fn drift(&self, kind: Difference) -> Drift {
        Drift::new(kind, self.expected.component, self.places())
    }

    fn missing(&self) -> Option<Drift> {
        let name = &self.function.name;
        let mut files = self.sources.all();
        // A macro may define the function, a build step may generate it, or incomplete code may hide it.
        let hidden = self.sources.incomplete
            || files.any(|file| {
                let mut macros = file.index().macros.iter();
                let bodies =
                    file.index().functions.iter().filter_map(|function| function.body.as_ref());
                file.index().loose.contains(name)
                    || macros.any(|definition| definition.name == *name)
                    || bodies.filter(|body| body.broken).any(|body| body.mentions.contains(name))
            })
            || self.pasted();
        if hidden {
            return None;
        }
        let folder = self.sources.folder.file_name().unwrap_or_default();
        let mut drift =
            self.drift(Difference::Missing { folder: folder.into(), codel: name.clone() });
        drift.expected = self.function.signature.clone().ok();
        if let Some(&at) = self.function.uses.first() {
            drift.repairs.push(Repair::Stub { at });
        }
        Some(drift)
    }

    /// True if macros outside functions build names.
    fn pasted(&self) -> bool {
        let paste = |file: &IndexedFile| {
            let mut macros = file.index().macros.iter().filter(|definition| definition.pastes);
            macros.any(|definition| {
                self.sources.all().any(|file| file.index().loose.contains(&definition.name))
            })
        };
        self.sources.all().any(paste)
    }

    fn renamed(&self, orphan: FunctionIn<'_>) -> Drift {
        let (from, to) = (&orphan.function.name, &self.function.name);
        let mut drift =
            self.drift(Difference::Renamed { function: from.as_str().into(), codel: to.clone() });
        // A program with a codel that has no function does not link.
        drift.severity = Severity::Warning;
        drift.source = Some(orphan.at(orphan.function.name_span.clone()));
        drift.expected = Some(to.to_string());
        drift.found = Some(from.to_string());
        drift.repairs = vec![
            Repair::RenameFunction { from: from.as_str().into(), to: to.clone() },
            Repair::RenameCodel { from: to.clone(), to: from.as_str().into() },
        ];
        if let Some(&at) = self.function.uses.first() {
            drift.repairs.push(Repair::Stub { at });
        }
        drift
    }
}
