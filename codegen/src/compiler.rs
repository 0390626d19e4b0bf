//! The front end over analysis: inputs that are parsed one after the other are compiled as one growing unit.

mod place;

use std::fmt;
use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_analysis::codes;
use dotgen_analysis::diagnostic::{Diagnostic, Severity, Wording};
use dotgen_analysis::host::{
    AnalysisHost, BatchInput, Change, Config, FileContent, Input, Loader, UnitResult,
};
use dotgen_analysis::model::{Component, Spec, TypeKind, Value};
use dotgen_analysis::release::ReleaseChoice;
use dotgen_analysis::source_map::Locations;
use dotgen_syntax::codes::{self as syntax, Stage};
use dotgen_syntax::encoding;
use rustc_hash::{FxHashMap, FxHashSet};
use smol_str::SmolStr;

use place::UnitPlaces;

use crate::disk::Disk;
use crate::frontend::{Compiled, ParseFailure};
use crate::lang::value_text;

/// Name of texts that are not files.
const INLINE: &str = "<inline string>";

/// Compiles specifications with dotgen's own analysis.
pub struct Compiler {
    disk: Arc<dyn Disk>,
    loader: Arc<dyn Loader>,
    /// Start of relative file names; empty for the current directory.
    base: Utf8PathBuf,
    /// Name of the program in messages about inputs.
    program: String,
    host: AnalysisHost,
    input: BatchInput,
    reported: FxHashSet<(Utf8PathBuf, usize, &'static str, Wording)>,
    compiled: Compiled,
}

impl Compiler {
    /// A compiler without input. `include_dirs` and `defines` are the values of `-I` and `-D`. Inputs are
    /// read as the release.
    pub fn new(
        disk: Arc<dyn Disk>,
        loader: Arc<dyn Loader>,
        include_dirs: Vec<Utf8PathBuf>,
        defines: Vec<(SmolStr, SmolStr)>,
        release: ReleaseChoice,
    ) -> Compiler {
        let number = release.release;
        let mut host = AnalysisHost::new(Arc::clone(&loader));
        host.apply(Change {
            config: Some(Config {
                include_dirs,
                defines,
                release: Some(release),
                ..Config::default()
            }),
            ..Change::default()
        });
        Compiler {
            disk,
            loader,
            base: Utf8PathBuf::new(),
            program: "genom3".to_owned(),
            host,
            input: BatchInput::default(),
            reported: FxHashSet::default(),
            compiled: Compiled::of_release(number),
        }
    }

    /// Relative names of files start at `base` instead of the current directory.
    pub(crate) fn set_base(&mut self, base: Utf8PathBuf) {
        self.base = base;
    }

    /// The path with the current directory in front, unless it is absolute.
    fn absolute(&self, path: Utf8PathBuf) -> Utf8PathBuf {
        let found = self.disk.absolute(path.as_std_path());
        let found = found.components().collect();
        Utf8PathBuf::from_path_buf(found).unwrap_or(path)
    }

    /// The name of the program that messages about inputs begin with.
    pub(crate) fn set_program(&mut self, name: &str) {
        name.clone_into(&mut self.program);
    }

    /// Compiles all inputs so far and reports the new messages.
    fn compile(&mut self, report: &mut dyn FnMut(&str)) -> Result<(), ParseFailure> {
        let unit = match self.host.analysis().batch(&self.input) {
            Ok(unit) => unit,
            Err(reason) => return Err(ParseFailure::Unreadable(reason.to_string())),
        };
        let (mut errors, mut fatal) = (0, false);
        // In the order in which files are read; GenoM3's preprocessor stops at its first error.
        let place =
            |diagnostic: &&Diagnostic| unit.files.iter().position(|file| *file == diagnostic.path);
        let mut diagnostics: Vec<&Diagnostic> = unit.diagnostics.iter().collect();
        diagnostics.sort_by_key(place);
        for diagnostic in diagnostics {
            let key = (
                diagnostic.path.clone(),
                diagnostic.range.start,
                diagnostic.code,
                diagnostic.message.clone(),
            );
            if !in_reference(diagnostic) || !self.reported.insert(key) {
                continue;
            }
            report(&encoding::shown(&self.line(diagnostic)));
            if diagnostic.severity == Severity::Error {
                errors += 1;
                fatal |= syntax::stops(diagnostic.code);
            }
        }
        let analysis = self.host.analysis();
        let texts = unit.files.iter().filter_map(|path| {
            let text = analysis.text(path).ok()??;
            Some((path.clone(), text))
        });
        let texts: FxHashMap<Utf8PathBuf, Arc<str>> = texts.collect();
        // Included files are also named by their path with links followed.
        let files = unit.files.iter().map(|path| {
            let name = canonical(&*self.disk, path.clone());
            (path.clone(), name.into_string())
        });
        let names: FxHashMap<Utf8PathBuf, String> = files.collect();
        let mut spec = narrow_literals(&unit, &texts, report);
        share_requires(&mut spec);
        share_throws(&mut spec);
        self.compiled = Compiled {
            spec,
            deps: deps(&unit, &names),
            places: Arc::new(UnitPlaces { unit, texts, names }),
        };
        match errors {
            0 => Ok(()),
            _ if fatal => Err(ParseFailure::Fatal),
            errors => Err(ParseFailure::Errors(errors)),
        }
    }

    /// `BASENAME:LINE: TEXT`, as GenoM3 prints diagnostics.
    fn line(&self, diagnostic: &Diagnostic) -> String {
        let (text, at): (&dyn fmt::Display, _) = match &diagnostic.reference {
            Some(reference) => (&reference.text, reference.at),
            None => (&diagnostic.message, diagnostic.range.start),
        };
        let line = match self.host.analysis().text(&diagnostic.path) {
            Ok(Some(text)) => {
                let before = text.as_bytes().iter().take(at);
                1 + before.filter(|byte| **byte == b'\n').count()
            }
            _ => 1,
        };
        let is_error = diagnostic.severity == Severity::Error;
        // GenoM3's preprocessor prints the whole path and a word for the severity.
        if syntax::stage(diagnostic.code) == Some(Stage::Preprocessor) {
            let word = if is_error { "error" } else { "warning" };
            return format!("{}:{line}: {word}: {text}", diagnostic.path);
        }
        let name = diagnostic.path.file_name().unwrap_or(INLINE);
        let warning = if is_error { "" } else { " warning:" };
        format!("{name}:{line}:{warning} {text}")
    }
}

/// Shares the list of exceptions of an interface's service or task with its importers. In GenoM3 an exception
/// that one importer adds is thrown by all of them. Templates write these lists into comments and manuals.
fn share_throws(spec: &mut Arc<Spec>) {
    let mut additions = Vec::new();
    for component in &spec.components {
        for service in &component.services {
            let theirs = service.imported_from.and_then(|interface| {
                let mut services = spec.components[interface].services.iter_enumerated();
                let (index, service) = services.find(|other| other.1.name == service.name)?;
                (!service.throws.is_empty()).then_some((interface, index, &service.throws))
            });
            let Some((interface, index, throws)) = theirs else {
                continue;
            };
            let added = service.throws.iter().filter(|exception| !throws.contains(exception));
            additions.extend(added.map(|exception| (interface, index, *exception)));
        }
    }
    if additions.is_empty() {
        return;
    }
    let spec = Arc::make_mut(spec);
    for (interface, index, exception) in additions {
        let name = spec.components[interface].services[index].name.clone();
        for (at, component) in spec.components.iter_mut_enumerated() {
            let shares = component.services.iter_mut().filter(|service| {
                service.name == name
                    && (at == interface || service.imported_from == Some(interface))
            });
            for service in shares.filter(|share| !share.throws.contains(&exception)) {
                service.throws.push(exception);
            }
        }
    }
}

/// True for errors, and for warnings that GenoM3 prints too. Other warnings are for editors and `check`.
fn in_reference(diagnostic: &Diagnostic) -> bool {
    match diagnostic.severity {
        Severity::Error => true,
        Severity::Warning => {
            syntax::stage(diagnostic.code) == Some(Stage::Preprocessor)
                || codes::find(diagnostic.code).is_some_and(|code| code.reference)
        }
        _ => false,
    }
}

fn deps(unit: &UnitResult, names: &FxHashMap<Utf8PathBuf, String>) -> Vec<String> {
    let mut deps: Vec<String> = Vec::with_capacity(unit.files.len());
    for name in unit.files.iter().filter_map(|file| names.get(file)) {
        if !name.contains(INLINE) && !deps.contains(name) {
            deps.push(name.clone());
        }
    }
    deps
}

impl Compiler {
    /// Adds files, preprocessed as one unit. Each message (`BASENAME:LINE: TEXT`) is passed to `report` when
    /// it is found.
    ///
    /// # Errors
    /// Any error in the input; the correct parts are added.
    pub fn parse_files(
        &mut self,
        files: &[String],
        report: &mut dyn FnMut(&str),
    ) -> Result<(), ParseFailure> {
        let mut inputs = Vec::new();
        for file in files {
            let path = canonical(&*self.disk, self.absolute(self.base.join(file)));
            let problem = match self.loader.read(&path) {
                FileContent::Text(_) | FileContent::NotUtf8(_) => None,
                FileContent::Missing => Some("No such file or directory".to_owned()),
                FileContent::Directory => Some("Is a directory".to_owned()),
                FileContent::Unreadable(why) => Some(why),
            };
            if let Some(problem) = problem {
                // If the base directory does not exist, the error is about that directory.
                let base = self.absolute(self.base.clone());
                let gone = !self.base.as_str().is_empty()
                    && self.loader.read(&base) == FileContent::Missing;
                let what = if gone { self.base.as_str() } else { file };
                report(&format!("{}: {what}: {problem}", self.program));
                return Err(ParseFailure::Unreadable(format!("cannot parse input: {problem}")));
            }
            inputs.push(Input::File(path));
        }
        self.input.inputs.extend(inputs);
        self.compile(report)
    }

    /// Adds texts without preprocessing; their file name is `<inline string>`.
    ///
    /// # Errors
    /// The same as of [`Compiler::parse_files`].
    pub fn parse_strings(
        &mut self,
        texts: &[String],
        report: &mut dyn FnMut(&str),
    ) -> Result<(), ParseFailure> {
        let here = self.absolute(INLINE.into());
        self.input.inputs.extend(
            texts.iter().map(|text| Input::Text { name: here.clone(), text: text.as_str().into() }),
        );
        self.compile(report)
    }

    /// Everything parsed so far.
    pub fn compiled(&self) -> Compiled {
        self.compiled.clone()
    }
}

/// The path with links followed, if it exists.
fn canonical(disk: &dyn Disk, path: Utf8PathBuf) -> Utf8PathBuf {
    let found = disk.canonical(path.as_std_path()).ok();
    let found = found.and_then(|path| Utf8PathBuf::from_path_buf(path).ok());
    found.unwrap_or(path)
}

/// Narrows constants to GenoM3's value. GenoM3 keeps 32 bits of an integer literal, and generated code must
/// agree with that of GenoM3. A constant with a longer literal gets that value, with a warning.
fn narrow_literals(
    unit: &UnitResult,
    texts: &FxHashMap<Utf8PathBuf, Arc<str>>,
    report: &mut dyn FnMut(&str),
) -> Arc<Spec> {
    let mut spec = Arc::clone(&unit.spec);
    for (id, ty) in unit.spec.types.iter_enumerated() {
        let (TypeKind::Const { value, .. }, Some(name)) = (&ty.kind, &ty.name) else {
            continue;
        };
        let wide = match value {
            Value::Uint(value) => *value > i32::MAX as u64,
            Value::Int(value) => i32::try_from(*value).is_err(),
            _ => false,
        };
        if !wide {
            continue;
        }
        let narrow = unit.locations.locate(ty.src).and_then(|location| {
            let text = texts.get(&location.path)?.get(location.range.end..)?;
            let literal = text.trim_start().strip_prefix('=')?.split(';').next()?.trim();
            narrow_literal(literal)
        });
        let narrow = match (value, narrow) {
            (Value::Uint(_), Some(narrow)) if narrow >= 0 => Value::Uint(narrow as u64),
            (Value::Int(_), Some(narrow)) => Value::Int(narrow),
            _ => continue,
        };
        if narrow == *value {
            continue;
        }
        report(&format!(
            "warning: constant {name}: GenoM3 keeps 32 bits of its literal, so generated code has {}",
            value_text(&unit.spec, &narrow)
        ));
        if let TypeKind::Const { value, .. } = &mut Arc::make_mut(&mut spec).types[id].kind {
            *value = narrow;
        }
    }
    spec
}

/// Shares the packages of `#pragma requires` of all components after the first. In GenoM3 they have one list,
/// so that each requires the packages of all of them. Templates write these lists into build files.
fn share_requires(spec: &mut Arc<Spec>) {
    let Some(first) = spec.pragma_requires.first() else {
        return;
    };
    let shares = |component: &Component| component.requires.first() == Some(first);
    let mut shared: Vec<String> = Vec::new();
    let sharing = spec.components.iter().filter(|component| shares(component));
    for package in sharing.flat_map(|component| &component.requires).chain(&spec.pragma_requires) {
        if !shared.contains(package) {
            shared.push(package.clone());
        }
    }
    let first = first.clone();
    for component in &mut Arc::make_mut(spec).components {
        if component.requires.first() == Some(&first) {
            component.requires.clone_from(&shared);
        }
    }
}

/// The value GenoM3 gives to `[-]LITERAL`.
fn narrow_literal(text: &str) -> Option<i64> {
    let (negative, digits) = match text.strip_prefix('-') {
        Some(digits) => (true, digits.trim_start()),
        None => (false, text),
    };
    let digits = digits.trim_end_matches(['u', 'U', 'l', 'L']);
    let value = if let Some(hex) = digits.strip_prefix("0x").or(digits.strip_prefix("0X")) {
        u64::from_str_radix(hex, 16)
    } else if digits.len() > 1 && digits.starts_with('0') {
        u64::from_str_radix(digits, 8)
    } else {
        digits.parse()
    };
    let low = i64::from(value.ok()? as u32 as i32);
    Some(if negative { -low } else { low })
}
