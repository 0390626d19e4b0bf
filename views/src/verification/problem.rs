//! The input of a verification.

use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::{Diagnostic, FileEdit, Fix, FixKind, Related, Severity};
use dotgen_analysis::host::{Analysis, BatchInput, Cancellable, FileContent, Input, UnitResult};
use dotgen_analysis::language;
use dotgen_analysis::model::{Component, ComponentKind, Spec, Src};
use dotgen_analysis::source_map::Locations;
use dotgen_timing::derive::{InterimResult, Sensitivity, sensitivity};
use dotgen_timing::report::Report;
use dotgen_timing::scn::ast::{Item, Scenario, Spanned};
use dotgen_timing::scn::{self, Platform, default_text_on};
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify_with_reports};

use dotgen_platform::files::vfs;

/// Code of the finding about `#pragma requires` with a package that is not installed.
const UNRESOLVED_PACKAGE: &str = "pp-requires-unresolved";

/// A scenario and the specifications it uses.
#[derive(Clone, Default)]
pub struct Problem {
    /// The file of the scenario; for the default scenario, the file of the specification.
    pub path: Utf8PathBuf,
    /// Text of the scenario.
    pub text: String,
    pub scenario: Scenario,
    /// Its specifications, in the order of `use`.
    pub units: Vec<UnitResult>,
    /// Errors that prevent a verification: syntax errors, unreadable files, errors in specifications.
    /// Warnings are reported in the specifications themselves.
    pub errors: Vec<Diagnostic>,
    /// Warnings about files of execution times.
    pub warnings: Vec<Diagnostic>,
    /// The files of execution times that were read.
    pub times: Vec<Utf8PathBuf>,
}

impl Problem {
    /// Every file that the problem was read from.
    pub fn files(&self) -> impl Iterator<Item = &Utf8Path> {
        let used = self.units.iter().flat_map(|unit| &unit.files).chain(&self.times);
        std::iter::once(&self.path).chain(used).map(camino::Utf8PathBuf::as_path)
    }
}

/// A file that a scenario uses.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UsedFile {
    /// Its absolute path.
    pub path: Utf8PathBuf,
    /// The string in the scenario.
    pub range: Range<usize>,
}

/// The specifications that a scenario uses. Relative paths start at its directory.
pub fn used(scenario: &Scenario, path: &Utf8Path) -> Vec<UsedFile> {
    files(scenario, path, |item| match item {
        Item::Use(name) => Some(name),
        _ => None,
    })
}

/// The last file of weights that a scenario names.
pub fn weights(scenario: &Scenario, path: &Utf8Path) -> Option<Utf8PathBuf> {
    let named = files(scenario, path, |item| match item {
        Item::Weights(name) => Some(name),
        _ => None,
    });
    named.into_iter().next_back().map(|file| file.path)
}

/// All files that a scenario names: specifications, files of execution times and of weights.
pub fn named(scenario: &Scenario, path: &Utf8Path) -> Vec<UsedFile> {
    files(scenario, path, |item| match item {
        Item::Use(name) | Item::Times(name) | Item::Weights(name) => Some(name),
        _ => None,
    })
}

fn files(
    scenario: &Scenario,
    path: &Utf8Path,
    of: impl Fn(&Item) -> Option<&Spanned<String>>,
) -> Vec<UsedFile> {
    let directory = path.parent().unwrap_or(path);
    let file = |spanned: &Spanned<String>| UsedFile {
        path: vfs::normalize(&directory.join(&spanned.value)),
        range: spanned.range.clone(),
    };
    scenario.items.iter().filter_map(of).map(file).collect()
}

/// A diagnostic of the scenario language, in the form of all front ends.
pub fn diagnostic(entry: &dotgen_timing::diagnostic::Diagnostic, path: &Utf8Path) -> Diagnostic {
    let severity = match entry.severity {
        dotgen_timing::diagnostic::Severity::Error => Severity::Error,
        dotgen_timing::diagnostic::Severity::Warning => Severity::Warning,
    };
    let fixes = entry.suggestion.iter().map(|suggestion| Fix {
        title: format!("Change to `{}`", suggestion.text),
        kind: if suggestion.is_word { FixKind::Plain } else { FixKind::Guess },
        edits: vec![FileEdit {
            path: path.to_owned(),
            range: entry.range.clone(),
            new_text: suggestion.text.clone(),
        }],
    });
    Diagnostic {
        fixes: fixes.collect(),
        ..Diagnostic::new(
            entry.code,
            severity,
            entry.message.clone(),
            path.to_owned(),
            entry.range.clone(),
        )
    }
}

/// The unit of a file for a scenario in `directory`, which is searched for includes after the
/// configured directories.
pub(crate) fn unit_for(
    analysis: &Analysis,
    file: &Utf8Path,
    directory: &Utf8Path,
) -> Cancellable<UnitResult> {
    let unit = analysis.root_unit(file)?;
    if prevents(&unit).next().is_none() {
        return Ok(unit);
    }
    let with_directory = analysis.batch(&BatchInput {
        inputs: vec![Input::File(file.to_owned())],
        include_dirs: vec![directory.to_owned()],
        defines: Vec::new(),
    })?;
    let better = prevents(&with_directory).next().is_none();
    Ok(if better { with_directory } else { unit })
}

/// The components (not interfaces) of a specification.
pub fn components(spec: &Spec) -> impl Iterator<Item = &Component> {
    let all = spec.components.iter();
    all.filter(|component| component.kind == ComponentKind::Component)
}

impl Problem {
    /// Reads a scenario and the specifications it uses.
    pub fn from_scenario(
        path: &Utf8Path,
        text: String,
        analysis: &Analysis,
        read: impl Fn(&Utf8Path) -> FileContent,
    ) -> Cancellable<Problem> {
        let parsed = scn::parse(&text);
        let directory = path.parent().unwrap_or(path);
        let mut errors: Vec<Diagnostic> =
            parsed.errors.iter().map(|error| diagnostic(error, path)).collect();
        let mut units = Vec::new();
        let files = used(&parsed.scenario, path);
        if files.is_empty() && errors.is_empty() {
            let message = "the scenario uses no specification; add `use \"FILE.gen\";`".to_owned();
            let range = parsed.scenario.name_range.clone();
            errors.push(error("scn-no-use", path, range, message));
        }
        for file in files {
            let why = match read(&file.path) {
                FileContent::Text(_) | FileContent::NotUtf8(_) => {
                    let unit = unit_for(analysis, &file.path, directory)?;
                    add_errors_of(&unit, &mut errors);
                    units.push(unit);
                    continue;
                }
                FileContent::Missing => "there is no such file".to_owned(),
                FileContent::Directory => "it is a directory".to_owned(),
                FileContent::Unreadable(why) => why,
            };
            errors.push(unreadable(path, &text, file.range, &why));
        }
        let mut problem = Problem {
            path: path.to_owned(),
            text,
            scenario: parsed.scenario,
            units,
            errors,
            ..Problem::default()
        };
        problem.read_times(&read);
        Ok(problem)
    }

    /// The default scenario over some specifications, on a platform.
    pub fn default_scenario_on(
        platform: Platform,
        path: &Utf8Path,
        files: &[String],
        units: Vec<UnitResult>,
        read: impl Fn(&Utf8Path) -> FileContent,
    ) -> Problem {
        let mut errors = Vec::new();
        for unit in &units {
            add_errors_of(unit, &mut errors);
        }
        let members: Vec<&Component> =
            units.iter().flat_map(|unit| components(&unit.spec)).collect();
        let text = default_text_on(&members, files, platform);
        if members.is_empty() && errors.is_empty() {
            let message = "this specification has no component, so there is nothing to verify";
            errors.push(error("scn-no-component", path, 0..0, message.to_owned()));
        }
        let scenario = scn::parse(&text).scenario;
        let mut problem =
            Problem { path: path.to_owned(), text, scenario, units, errors, ..Problem::default() };
        problem.read_times(&read);
        problem
    }

    /// True if the problem was read from a file.
    pub fn reads(&self, file: &Utf8Path) -> bool {
        self.path == file
            || (self.units.iter()).any(|unit| unit.files.iter().any(|path| path == file))
            || self.uses(file)
            || self.times.iter().any(|path| path == file)
    }

    /// True if the scenario uses a specification.
    pub fn uses(&self, file: &Utf8Path) -> bool {
        used(&self.scenario, &self.path).iter().any(|candidate| candidate.path == file)
    }

    /// True if both problems have the same answer: the same scenario over the same models. Comments and
    /// layout of specifications may differ as long as no place moves.
    pub fn is_same(&self, other: &Problem) -> bool {
        self.path == other.path
            && self.text == other.text
            && self.errors == other.errors
            && self.warnings == other.warnings
            && self.scenario.times == other.scenario.times
            && self.units.len() == other.units.len()
            && (self.units.iter().zip(&other.units)).all(|(a, b)| a.spec == b.spec)
    }

    /// The specifications, as the input of the verifier.
    pub fn specs(&self) -> Vec<&Spec> {
        self.units.iter().map(|unit| &*unit.spec).collect()
    }

    /// A diagnostic of the verifier: at its place in the scenario if there is one, else in its specification,
    /// else at the name of the scenario.
    pub fn diagnostic(&self, entry: &dotgen_timing::diagnostic::Diagnostic) -> Diagnostic {
        let mut out = diagnostic(entry, &self.path);
        let places = entry.places.iter();
        let mut places = places.filter_map(|place| {
            let (path, range) = self.place(place.spec, place.src)?;
            let message = place.what.clone();
            Some(Related { path, range, message: message.into() })
        });
        if !self.is_written() || entry.range.is_empty() {
            (out.path, out.range) = match places.next() {
                Some(place) => (place.path, place.range),
                None if self.is_written() => (out.path, self.scenario.name_range.clone()),
                None => (out.path, 0..0),
            };
        }
        out.related = places.collect();
        out
    }

    /// The file and range of a place in one of the specifications.
    pub fn place(&self, spec: usize, src: Src) -> Option<(Utf8PathBuf, Range<usize>)> {
        let at = self.units.get(spec)?.locations.locate(src)?;
        Some((at.path, at.range))
    }

    /// True if the scenario is in a file; the default scenario is not.
    pub fn is_written(&self) -> bool {
        language::is_scenario(&self.path)
    }

    /// The distance of the system from missing its deadlines, or from meeting them. Requires that
    /// [`Problem::errors`] is empty.
    ///
    /// # Errors
    /// The errors of the scenario.
    pub fn sensitivity(
        &self,
        options: &Options,
        cancel: &Cancel,
        tell: &(dyn Fn(InterimResult) + Sync),
    ) -> Result<Sensitivity, Vec<dotgen_timing::diagnostic::Diagnostic>> {
        let input = SystemInput { specs: self.specs() };
        sensitivity(&input, &self.scenario, options, cancel, tell)
    }

    /// Verifies, and reports each new result at once. Requires that [`Problem::errors`] is empty.
    pub fn verify(
        &self,
        options: &Options,
        cancel: &Cancel,
        tell: &(dyn Fn(&Report) + Sync),
    ) -> Report {
        let input = SystemInput { specs: self.specs() };
        verify_with_reports(&input, &self.scenario, options, cancel, tell)
    }
}

/// Errors that prevent the verification of a specification. A missing package is not one of them: a missing
/// declaration of the package has an error of its own.
fn prevents(unit: &UnitResult) -> impl Iterator<Item = &Diagnostic> {
    let errors =
        unit.diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error);
    errors.filter(|error| error.code != UNRESOLVED_PACKAGE)
}

fn add_errors_of(unit: &UnitResult, errors: &mut Vec<Diagnostic>) {
    errors.extend(prevents(unit).cloned());
}

pub(super) fn unreadable(
    path: &Utf8Path,
    text: &str,
    range: Range<usize>,
    why: &str,
) -> Diagnostic {
    let name = text[range.clone()].trim_matches('"');
    let message =
        format!("cannot read `{name}`: {why}; paths start at the directory of the scenario");
    error("scn-use-not-found", path, range, message)
}

pub(super) fn error(
    code: &'static str,
    path: &Utf8Path,
    range: Range<usize>,
    message: String,
) -> Diagnostic {
    Diagnostic::new(code, Severity::Error, message, path.to_owned(), range)
}
