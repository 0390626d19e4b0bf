//! Compilation of codels by the system's compilers, without an installation of GenoM3: the steps for a folder
//! of codels, the steps that are up to date, and the messages of compilers. This module runs nothing.

use std::path::{Path, PathBuf};

use camino::{Utf8Path, Utf8PathBuf};
use md5::{Digest as _, Md5};
use rustc_hash::FxHashMap;

use super::files::IndexedFile;
use super::folder::Folder;
use super::headers;
use super::links::implementations;
use super::stub::NewFile;
use crate::disk::Disk;

/// The compilers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tools {
    /// For C sources: a program, and arguments that always come first.
    pub c: Vec<String>,
    /// For C++ sources. It also links, if there are C++ sources.
    pub cxx: Vec<String>,
    /// The level of optimization.
    pub optimization: Optimization,
}

/// The level of optimization of compilers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Optimization {
    /// Some optimization, with short compile times.
    Some,
    /// No optimization: a debugger shows every variable, and executes lines in order.
    None,
}

impl Optimization {
    /// The argument of compilers.
    pub fn flag(self) -> &'static str {
        match self {
            Optimization::Some => "-O1",
            Optimization::None => "-O0",
        }
    }
}

/// The flags that packages need.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Packages {
    /// Flags for compiling sources.
    pub compile: Vec<String>,
    /// Flags for linking objects.
    pub link: Vec<String>,
}

/// A program to run, whose output is one file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// The source; `None` for the library.
    pub source: Option<Utf8PathBuf>,
    /// The output file.
    pub output: Utf8PathBuf,
    /// The program and its arguments.
    pub command: Vec<String>,
    /// The inputs, as far as they are known before the step.
    pub inputs: Vec<Utf8PathBuf>,
}

/// The steps that make a shared object of a folder of codels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// Headers to be written first, by absolute path.
    pub headers: Vec<NewFile>,
    /// The steps for the sources, in any order.
    pub compile: Vec<Step>,
    /// The step after all others.
    pub link: Step,
    /// Codels without a function.
    pub missing: Vec<String>,
}

/// Packages that a folder of codels names, in the syntax of `pkg-config`, without repetition.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Required {
    /// Required for reading the specification and for building the server; codels may not need them.
    pub specification: Vec<String>,
    /// Required by the codels.
    pub codels: Vec<String>,
}

impl Required {
    /// All of them.
    pub fn all(&self) -> Vec<String> {
        self.specification.iter().chain(&self.codels).cloned().collect()
    }
}

/// The name of a package, without its version.
pub fn package_name(requirement: &str) -> &str {
    let end = requirement.find(|c: char| c.is_whitespace() || "<>=!".contains(c));
    &requirement[..end.unwrap_or(requirement.len())]
}

/// Packages that a folder of codels requires. `genom3` is omitted: codels are compiled without GenoM3.
pub fn packages(folder: &Folder) -> Required {
    let spec = &folder.unit.spec;
    let mut out = Required { specification: spec.pragma_requires.clone(), codels: Vec::new() };
    for &component in &folder.components {
        let component = &spec.components[component];
        out.specification.extend(component.requires.iter().cloned());
        out.codels.extend(component.codels_requires.iter().cloned());
    }
    let mut seen = rustc_hash::FxHashSet::default();
    let mut is_wanted =
        |text: &String| package_name(text.trim()) != "genom3" && seen.insert(text.clone());
    out.codels.retain(&mut is_wanted);
    out.specification.retain(&mut is_wanted);
    out
}

/// Plans the build of a folder, in a separate directory.
///
/// # Errors
/// A type of the specification has no mapping.
pub fn plan(
    folder: &Folder,
    place: &Utf8Path,
    tools: &Tools,
    packages: &Packages,
) -> Result<Plan, String> {
    let codels = &folder.sources.folder;
    let mut headers: Vec<NewFile> = Vec::new();
    let mut missing = Vec::new();
    let mut name = String::new();
    for expected in folder.expected() {
        let files =
            headers::headers(&expected, place, codels, &[]).map_err(|error| error.message)?;
        headers
            .extend(files.into_iter().map(|file| NewFile { path: place.join(file.path), ..file }));
        let functions = expected.functions.iter();
        let absent = functions
            .filter(|function| implementations(&folder.sources, &function.name).is_empty());
        missing.extend(absent.map(|function| function.name.to_string()));
        name.push_str(&expected.component().name);
    }
    let mut seen = rustc_hash::FxHashSet::default();
    headers.retain(|header| seen.insert(header.path.clone()));
    let names = folder.expected().iter().find_map(headers::flags_of_names);
    let own: Vec<&str> = {
        let components = folder.components.iter();
        components.map(|&component| folder.unit.spec.components[component].name.as_str()).collect()
    };
    let sources = || folder.sources.of_components(&own);
    let build = Build { place, codels, tools, packages };
    let compile: Vec<Step> = sources().map(|source| build.source(source, names.as_ref())).collect();
    let is_cxx = |file: &IndexedFile| file.path.extension() != Some("c");
    let linker = if sources().any(is_cxx) { &tools.cxx } else { &tools.c };
    let inputs = compile.iter().map(|step| step.output.clone()).collect();
    let link = build.link(&name, linker.clone(), inputs, &["-lm"]);
    Ok(Plan { headers, compile, link, missing })
}

/// The parts that the steps of a build have in common.
pub(super) struct Build<'a> {
    /// The folder of headers and objects.
    pub(super) place: &'a Utf8Path,
    /// The folder of the sources.
    pub(super) codels: &'a Utf8Path,
    pub(super) tools: &'a Tools,
    pub(super) packages: &'a Packages,
}

impl Build<'_> {
    fn source(&self, source: &IndexedFile, names: Option<&String>) -> Step {
        let name = source.path.strip_prefix(self.codels).unwrap_or(&source.path);
        // Sources in subfolders may have equal names.
        let name = name.as_str().replace('_', "__").replace(['/', '\\'], "_-");
        let is_c = source.path.extension() == Some("c");
        let compiler = if is_c { &self.tools.c } else { &self.tools.cxx };
        let compiler = compiler.iter().chain(names.filter(|_| !is_c)).cloned().collect();
        // Columns are counted in characters.
        self.compile(source.path.clone(), &name, compiler, &["-Wall", "-ftabstop=1"])
    }

    /// The step that compiles a source to the object `NAME.o`. `flags` are those of its messages.
    pub(super) fn compile(
        &self,
        source: Utf8PathBuf,
        name: &str,
        mut command: Vec<String>,
        flags: &[&str],
    ) -> Step {
        let output = self.place.join("objects").join(format!("{name}.o"));
        let level = self.tools.optimization.flag();
        let flags = [&["-c", "-fPIC", "-g", level], flags, &["-MMD", "-MF"]].concat();
        command.extend(flags.into_iter().map(str::to_owned));
        command.push(dependencies_of(&output).to_string());
        command.extend(headers::include_flags(self.place, self.codels));
        command.extend(self.packages.compile.iter().cloned());
        command.extend(["-o".to_owned(), output.to_string(), source.to_string()]);
        Step { inputs: vec![source.clone()], source: Some(source), output, command }
    }

    /// The step that links objects to the shared object `NAME.so`.
    pub(super) fn link(
        &self,
        name: &str,
        mut command: Vec<String>,
        inputs: Vec<Utf8PathBuf>,
        libraries: &[&str],
    ) -> Step {
        let output = self.place.join(format!("{name}.so"));
        command.extend(["-shared", "-o", output.as_str()].map(str::to_owned));
        command.extend(inputs.iter().map(ToString::to_string));
        command.extend(self.packages.link.iter().cloned());
        command.extend(libraries.iter().map(|&library| library.to_owned()));
        Step { source: None, output, command, inputs }
    }
}

fn dependencies_of(output: &Utf8Path) -> Utf8PathBuf {
    format!("{output}.d").into()
}

impl Step {
    /// The file with the command that made the output and the contents of its inputs. It is written when the
    /// output is complete.
    pub fn record(&self) -> Utf8PathBuf {
        format!("{}.command", self.output).into()
    }

    /// The text of that file: the command, and a digest of each input. `None` if an input cannot be read.
    pub fn recorded(&self, contents: &mut Contents<'_>) -> Option<String> {
        let mut inputs: Vec<PathBuf> = self.inputs.iter().map(Into::into).collect();
        if self.source.is_some() {
            let listed = contents.disk.read(dependencies_of(&self.output).as_std_path()).ok()?;
            inputs.extend(dependencies(&String::from_utf8_lossy(&listed)));
        }
        let mut out = self.command.join("\n") + "\n";
        for input in inputs {
            let digest = contents.digest(&input)?;
            out.push_str(&format!("{digest:032x} {}\n", input.display()));
        }
        Some(out)
    }

    /// True if the output is up to date: it was made by the same command, from inputs with the same contents.
    /// Times do not count: a restored file is older than the output of the text before.
    pub fn is_fresh(&self, contents: &mut Contents<'_>) -> bool {
        let record = contents.disk.read(self.record().as_std_path());
        contents.disk.is_file(self.output.as_std_path())
            && record.is_ok_and(|record| {
                self.recorded(contents).is_some_and(|now| record == now.as_bytes())
            })
    }

    /// The inputs that are known before the step, as they are now. A step whose inputs are different when it
    /// has ended may have read either text.
    pub fn before(&self, contents: &mut Contents<'_>) -> Vec<Option<u128>> {
        self.inputs.iter().map(|input| contents.digest(input.as_std_path())).collect()
    }
}

/// Digests of files, each of which is read once.
#[derive(Debug)]
pub struct Contents<'d> {
    disk: &'d dyn Disk,
    digests: FxHashMap<PathBuf, Option<u128>>,
}

impl<'d> Contents<'d> {
    /// The files as they are from now on; what is written later is not noticed.
    pub fn new(disk: &'d dyn Disk) -> Self {
        Contents { disk, digests: FxHashMap::default() }
    }

    fn digest(&mut self, path: &Path) -> Option<u128> {
        if let Some(&known) = self.digests.get(path) {
            return known;
        }
        let digest = |bytes: Vec<u8>| u128::from_be_bytes(Md5::digest(bytes).into());
        let found = self.disk.read(path).ok().map(digest);
        self.digests.insert(path.to_owned(), found);
        found
    }
}

/// The prerequisites of a makefile rule, as compilers write it (`-MMD`).
fn dependencies(rule: &str) -> Vec<PathBuf> {
    let Some((_, list)) = rule.split_once(": ") else {
        return Vec::new();
    };
    let mut out = Vec::new();
    let mut name = String::new();
    let mut chars = list.chars().peekable();
    while let Some(c) = chars.next() {
        match (c, chars.peek()) {
            ('\\', Some(' ' | '#' | '\\')) => name.extend(chars.next()),
            // A continued line.
            ('\\', Some('\n' | '\r')) => {}
            ('$', Some('$')) => name.extend(chars.next()),
            (c, _) if c.is_whitespace() => {
                if !name.is_empty() {
                    out.push(std::mem::take(&mut name).into());
                }
            }
            (c, _) => name.push(c),
        }
    }
    if !name.is_empty() {
        out.push(name.into());
    }
    out
}

/// The severity of a message, in the words of compilers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MessageLevel {
    /// The compiler writes no output.
    Error,
    /// The compiler writes its output.
    Warning,
    /// Belongs to the preceding message.
    Note,
}

/// A compiler's message about a place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CompilerMessage {
    /// The file, with the compiler's name for it.
    pub path: Utf8PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1; 1 if the message has none.
    pub column: usize,
    /// The severity.
    pub weight: MessageLevel,
    /// The text of the message.
    pub what: String,
}

/// Reads the output of a compiler or linker (`FILE:LINE:COLUMN: error: …`, as GCC and Clang write it).
/// Returns the messages with a place, and all other lines that report an error.
pub fn said(printed: &str) -> (Vec<CompilerMessage>, Vec<String>) {
    let (mut about, mut other) = (Vec::new(), Vec::new());
    for line in printed.lines() {
        match one(line) {
            Some(message) => about.push(message),
            None if line.contains("error: ") || line.contains("undefined reference") => {
                other.push(line.to_owned());
            }
            None => {}
        }
    }
    (about, other)
}

fn one(line: &str) -> Option<CompilerMessage> {
    let kinds = [
        (": fatal error: ", MessageLevel::Error),
        (": error: ", MessageLevel::Error),
        (": warning: ", MessageLevel::Warning),
        (": note: ", MessageLevel::Note),
    ];
    let found =
        kinds.into_iter().filter_map(|(word, weight)| Some((line.find(word)?, word, weight)));
    // The first one counts: the text of a message may contain such words.
    let (at, word, weight) = found.min_by_key(|(at, ..)| *at)?;
    let (place, what) = (&line[..at], &line[at + word.len()..]);
    let (before, last) = place.rsplit_once(':')?;
    let last: usize = last.parse().ok()?;
    let with_column = || {
        let (path, line) = before.rsplit_once(':')?;
        Some((path, line.parse::<usize>().ok()?))
    };
    let (path, line, column) = match with_column() {
        Some((path, line)) => (path, line, last),
        None => (before, last, 1),
    };
    Some(CompilerMessage { path: path.into(), what: what.to_owned(), weight, line, column })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_has_its_files() {
        let rule = "a\\ b.o: /x/a\\ b.c \\\n /y/c$$.h \\\n  /z/d.h\n";
        let expected = ["/x/a b.c", "/y/c$.h", "/z/d.h"].map(PathBuf::from);
        assert_eq!(dependencies(rule), expected);
        assert_eq!(dependencies("nothing"), Vec::<PathBuf>::new());
    }

    #[test]
    fn what_compilers_say_has_places() {
        let printed = "\
/x/a.c: In function 'f':
/x/a.c:12:3: error: 'x' undeclared: note: no
   12 |   x;
C:\\b.c:7: warning: odd
/x/a.c:13:1: fatal error: no.h: No such file or directory
cc1: fatal error: cannot go on
ld: a.o: undefined reference to `f'
";
        let (about, other) = said(printed);
        let short = about.iter().map(|message| {
            (message.path.as_str(), message.line, message.column, message.weight, &*message.what)
        });
        assert_eq!(
            short.collect::<Vec<_>>(),
            [
                ("/x/a.c", 12, 3, MessageLevel::Error, "'x' undeclared: note: no"),
                ("C:\\b.c", 7, 1, MessageLevel::Warning, "odd"),
                ("/x/a.c", 13, 1, MessageLevel::Error, "no.h: No such file or directory"),
            ]
        );
        assert_eq!(
            other,
            ["cc1: fatal error: cannot go on", "ld: a.o: undefined reference to `f'"]
        );
    }
}
