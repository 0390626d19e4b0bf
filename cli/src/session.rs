//! The specifications that one command reads.

use anyhow::{Context, bail};
use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::Diagnostic;
use dotgen_analysis::host::{Analysis, AnalysisHost, Cancellable, Change, FileContent};
use dotgen_analysis::language::{self, SCENARIO, SPECIFICATION};
use dotgen_analysis::parallel;
use dotgen_analysis::release::ReleaseOrigin;
use dotgen_codegen::codels::files::{FilesConfig, Indexes};
use dotgen_codegen::codels::source::Grammar;
use dotgen_syntax::encoding;
use rustc_hash::{FxHashMap, FxHashSet};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use super::{CommandExit, SpecificationOptions};
use dotgen_lsp_server::config::{self, Config, Level, Problem, Settings};
use dotgen_lsp_server::protocol::convert::{Encoding, Lines};
use dotgen_platform::files::vfs::{self, PackageConfig, UnreadableFolder, Vfs};
use dotgen_platform::panic;
use dotgen_ros2::rules::RuleError;
#[cfg(feature = "zenoh")]
use dotgen_ros2::rules::Rules;

/// Number of files after which cached results are dropped.
const MAX_CACHED_FILES: usize = 64;

/// Files that share a configuration.
pub(super) struct Session {
    pub(super) files: Vec<SourceFile>,
    /// The problems of the configuration file.
    pub(super) config: Option<ConfigProblems>,
    host: AnalysisHost,
    packages: PackageConfig,
    connections: Vec<dotgen_diagram::system::Connection>,
    codels: FilesConfig,
    /// The indexes of their sources.
    pub(super) indexes: Arc<Mutex<Indexes>>,
    /// The style of the formatter.
    pub(super) format: config::Format,
    /// Severity by diagnostic code.
    pub(super) severity: BTreeMap<String, Level>,
    /// Common messages of ports in ROS 2.
    #[cfg(feature = "zenoh")]
    pub(super) ros2: Rules,
}

/// A specification to read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct SourceFile {
    pub(super) path: Utf8PathBuf,
    /// Named by the user, not found in a directory.
    pub(super) named: bool,
    /// The folder in which commands write: the nearest one with a `dotgen.toml`, or else the folder of the
    /// file, or the one that was searched.
    pub(super) folder: Utf8PathBuf,
    /// The text, if it is not read from the disk but from standard input.
    pub(super) text: Option<Arc<str>>,
}

impl SourceFile {
    /// Returns true if the file is a scenario.
    pub(super) fn is_scenario(&self) -> bool {
        language::is_scenario(&self.path)
    }
}

/// Problems of a `dotgen.toml`.
#[derive(Clone)]
pub(super) struct ConfigProblems {
    pub(super) path: Utf8PathBuf,
    pub(super) text: Arc<str>,
    pub(super) problems: Vec<Problem>,
}

impl ConfigProblems {
    /// Fails if the file has an error: the rules for ROS 2 may be missing then.
    ///
    /// # Errors
    /// The first error, with its place.
    pub(super) fn first_error(&self) -> Result<(), String> {
        let error = self.problems.iter().find(|problem| problem.kind.is_error());
        error.map_or(Ok(()), |error| Err(self.located(error)))
    }

    fn located(&self, problem: &Problem) -> String {
        config::located(&display(&self.path), &self.text, problem)
    }
}

/// Returns errors of rules for ROS 2, each with its place.
pub(super) fn told_rules(file: Option<&ConfigProblems>, errors: &[RuleError]) -> String {
    let lines = errors.iter().map(|error| match file {
        Some(file) => file.located(&config::rule_problem(&file.text, error)),
        None => error.to_string(),
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Returns the files that an argument names: the file itself, or all `.gen` files below a directory.
///
/// # Errors
/// The argument, or a file or folder below it, cannot be used.
fn files(argument: &Utf8Path) -> anyhow::Result<Vec<SourceFile>> {
    let mut found = NamedFiles::default();
    match found.add(argument, &[SPECIFICATION])?.into_iter().next() {
        Some(error) => Err(error),
        None => Ok(found.files),
    }
}

/// Returns the arguments, or without any the folder that the command is in.
pub(super) fn or_here(arguments: &[Utf8PathBuf]) -> Cow<'_, [Utf8PathBuf]> {
    match arguments {
        [] => vec![Utf8PathBuf::from(".")].into(),
        given => given.into(),
    }
}

/// Like [`or_here`]; without arguments, the scenario of the folder stands for it.
pub(super) fn or_scenario_here(
    arguments: &[Utf8PathBuf],
) -> anyhow::Result<Cow<'_, [Utf8PathBuf]>> {
    if !arguments.is_empty() {
        return Ok(arguments.into());
    }
    let entries = Utf8Path::new(".").read_dir_utf8().context("cannot list this folder")?;
    let names = entries.flatten().map(|entry| Utf8PathBuf::from(entry.file_name()));
    let mut scenarios: Vec<_> =
        names.filter(|name| name.extension() == Some(SCENARIO) && name.is_file()).collect();
    scenarios.sort();
    match scenarios.as_slice() {
        [] => Ok(or_here(arguments)),
        [_] => Ok(scenarios.into()),
        several => {
            let names: Vec<&str> = several.iter().map(|name| name.as_str()).collect();
            bail!("this folder has several scenarios; name one: {}", names.join(", "))
        }
    }
}

/// Returns the files that arguments name: the files themselves, and all below directories with one of the
/// extensions. The command continues without unusable ones, which are reported.
pub(super) fn usable_files(
    arguments: &[Utf8PathBuf],
    extensions: &[&str],
) -> (Vec<SourceFile>, ErrorReporter) {
    let (mut found, mut trouble) = (NamedFiles::default(), ErrorReporter::default());
    for argument in arguments {
        match found.add(argument, extensions) {
            Ok(skipped) => skipped.iter().for_each(|error| trouble.tell(error)),
            Err(error) => trouble.tell(&error),
        }
    }
    (found.files, trouble)
}

/// Returns the files as [`usable_files`] does, for commands that do not read scenarios.
pub(super) fn specifications(arguments: &[Utf8PathBuf]) -> (Vec<SourceFile>, ErrorReporter) {
    let (mut files, mut trouble) = usable_files(arguments, &[SPECIFICATION]);
    files.retain(|file| match refuse_scenario(file) {
        Ok(()) => true,
        Err(error) => {
            trouble.tell(&error);
            false
        }
    });
    (files, trouble)
}

fn refuse_scenario(file: &SourceFile) -> anyhow::Result<()> {
    if file.is_scenario() {
        let path = display(&file.path);
        bail!("`{path}` is a scenario, not a specification: `dotgen verify {path}` verifies it");
    }
    Ok(())
}

/// Refuses a source of codels, which the preprocessor of specifications would read.
fn refuse_codels(argument: &Utf8Path) -> anyhow::Result<()> {
    if Grammar::of_path(argument.as_str()).is_some() {
        bail!(
            "`{argument}` is a source of codels, not a specification; `dotgen codels check` checks the codels \
             of a specification"
        );
    }
    Ok(())
}

/// The files that arguments name, each once.
#[derive(Default)]
struct NamedFiles {
    files: Vec<SourceFile>,
    known: FxHashSet<Utf8PathBuf>,
}

impl NamedFiles {
    fn push(&mut self, path: Utf8PathBuf, folder: &Utf8Path, named: bool, text: Option<Arc<str>>) {
        if self.known.insert(path.clone()) {
            self.files.push(SourceFile { path, named, folder: workspace(folder), text });
        }
    }

    /// Adds the files of an argument. Returns the errors of files and folders below a directory.
    fn add(
        &mut self,
        argument: &Utf8Path,
        extensions: &[&str],
    ) -> anyhow::Result<Vec<anyhow::Error>> {
        if is_standard_input(argument) {
            let path = absolute(Utf8Path::new(STANDARD_INPUT))?;
            let folder = path.parent().unwrap_or(&path).to_owned();
            self.push(path, &folder, true, Some(standard_input()?.into()));
            return Ok(Vec::new());
        }
        let path = absolute(argument)?;
        let mut skipped = Vec::new();
        match vfs::read(&path) {
            FileContent::Directory => {
                let below = vfs::files_below(&path, extensions);
                skipped.extend(below.unreadable.iter().map(unlisted));
                skipped.extend(unusable_names(&path, extensions));
                let found = below.files;
                if found.is_empty() && skipped.is_empty() {
                    let all: Vec<String> =
                        extensions.iter().map(|extension| format!(".{extension}")).collect();
                    let all = match all.split_last() {
                        Some((last, rest)) if !rest.is_empty() => {
                            format!("{} or {last}", rest.join(", "))
                        }
                        _ => all.concat(),
                    };
                    bail!("no {all} file below `{argument}`");
                }
                for file in found {
                    self.push(file, &path, false, None);
                }
            }
            FileContent::Text(_) | FileContent::NotUtf8(_) => {
                refuse_codels(argument)?;
                let folder = path.parent().unwrap_or(&path).to_owned();
                self.push(path, &folder, true, None);
            }
            FileContent::Missing => bail!("cannot read `{argument}`: no such file or directory"),
            FileContent::Unreadable(why) => bail!("cannot read `{argument}`: {why}"),
        }
        Ok(skipped)
    }
}

/// Returns the nearest folder with a `dotgen.toml` at or around a folder, or else that folder.
pub(super) fn workspace(folder: &Utf8Path) -> Utf8PathBuf {
    config::nearest_directory(&folder.join("-")).unwrap_or_else(|| folder.to_owned())
}

/// Returns the error for a folder that cannot be listed.
fn unlisted(folder: &UnreadableFolder) -> anyhow::Error {
    let path = Utf8Path::from_path(&folder.path);
    let path = path.map_or_else(|| folder.path.display().to_string(), display);
    let path = if path.is_empty() { ".".to_owned() } else { path };
    anyhow::anyhow!("cannot list the folder `{path}`: {}", folder.reason)
}

/// Returns an error for each file below a directory whose name is not UTF-8: no message and no include could
/// name it.
fn unusable_names(directory: &Utf8Path, extensions: &[&str]) -> Vec<anyhow::Error> {
    let entries = walkdir::WalkDir::new(directory).into_iter().filter_entry(|entry| {
        let hidden = entry.file_name().to_string_lossy().starts_with('.');
        entry.depth() == 0 || !(hidden && entry.file_type().is_dir())
    });
    let wanted = |entry: &walkdir::DirEntry| {
        let extension = entry.path().extension().and_then(|extension| extension.to_str());
        entry.path().to_str().is_none()
            && extension.is_some_and(|extension| extensions.contains(&extension))
    };
    let found = entries.filter_map(Result::ok).filter(wanted);
    let error = |entry: walkdir::DirEntry| {
        anyhow::anyhow!(
            "`{}` is left out: its name is not UTF-8; rename it",
            entry.path().display()
        )
    };
    found.map(error).collect()
}

/// The argument for standard input.
const STANDARD_INPUT: &str = "-";

pub(super) fn is_standard_input(argument: &Utf8Path) -> bool {
    matches!(argument.as_str(), STANDARD_INPUT | "/dev/stdin" | "/dev/fd/0" | "/proc/self/fd/0")
}

/// Reads a file that is neither a specification nor a scenario.
///
/// # Errors
/// It cannot be read, is no text in UTF-8, or has more than so many megabytes.
pub(super) fn text(path: &Utf8Path, megabytes: usize) -> anyhow::Result<String> {
    match vfs::read(path) {
        FileContent::Text(text) if text.len() <= megabytes << 20 => Ok(text),
        FileContent::Text(_) => bail!("`{path}` is larger than {megabytes} MB"),
        FileContent::Missing => bail!("cannot read `{path}`: no such file or directory"),
        _ => bail!("cannot read `{path}`: it is not a text in UTF-8"),
    }
}

/// Reads all of standard input, as the text of a file.
pub(super) fn standard_input() -> anyhow::Result<String> {
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut std::io::stdin(), &mut bytes)
        .context("cannot read standard input")?;
    if let Some(name) = encoding::other_unicode(&bytes) {
        bail!("cannot read standard input: it is {name}; convert it to UTF-8");
    }
    Ok(encoding::decode(bytes))
}

/// Reports errors, and keeps the fact for the exit status, while the command continues.
#[derive(Debug, Default)]
#[must_use]
pub(super) struct ErrorReporter {
    any: bool,
    silent: bool,
}

impl ErrorReporter {
    /// Creates a reporter that prints nothing, for a first pass that a second one repeats.
    pub(super) fn silent() -> ErrorReporter {
        ErrorReporter { any: false, silent: true }
    }

    /// Prints an error on standard error.
    pub(super) fn tell(&mut self, error: &anyhow::Error) {
        if !self.silent {
            super::failure(error);
        }
        self.any = true;
    }

    /// Notes that an error was reported elsewhere.
    pub(super) fn told(&mut self) {
        self.any = true;
    }

    /// Returns true if there was an error.
    pub(super) fn any(&self) -> bool {
        self.any
    }

    /// Returns the value, or `None` after reporting the error.
    pub(super) fn ok_or_report<T>(&mut self, result: anyhow::Result<T>) -> Option<T> {
        result.inspect_err(|error| self.tell(error)).ok()
    }

    /// Returns the outcome of the command: `otherwise` if there was no error.
    pub(super) fn outcome(&self, otherwise: CommandExit) -> CommandExit {
        if self.any { CommandExit::Unusable } else { otherwise }
    }
}

/// Returns the one specification of a command: a file, or the only one below a directory.
pub(super) fn single(
    argument: &Utf8Path,
    reading: &SpecificationOptions,
) -> anyhow::Result<Session> {
    let files = files(argument)?;
    files.iter().try_for_each(refuse_scenario)?;
    if files.len() > 1 {
        let names: Vec<_> = files.iter().map(|file| display(&file.path)).collect();
        bail!("`{argument}` has {} specifications; name one: {}", names.len(), names.join(", "));
    }
    let mut sessions = open(files, reading)?;
    sessions.pop().context("there is nothing to read")
}

/// Groups files by the nearest `dotgen.toml` around them.
pub(super) fn open(
    files: Vec<SourceFile>,
    reading: &SpecificationOptions,
) -> anyhow::Result<Vec<Session>> {
    let mut groups: Vec<(Option<Utf8PathBuf>, Vec<SourceFile>)> = Vec::new();
    let mut nearest: FxHashMap<Utf8PathBuf, Option<Utf8PathBuf>> = FxHashMap::default();
    for file in files {
        let around = file.path.parent().unwrap_or(&file.path).to_owned();
        let directory =
            nearest.entry(around).or_insert_with(|| config::nearest_directory(&file.path)).clone();
        match groups.iter_mut().find(|group| group.0 == directory) {
            Some(group) => group.1.push(file),
            None => groups.push((directory, vec![file])),
        }
    }
    let here = absolute(Utf8Path::new("."))?;
    let sessions = groups.into_iter();
    Ok(sessions
        .map(|(directory, files)| Session::new(directory.as_deref(), &here, files, reading))
        .collect())
}

/// Returns a session for files, with the configuration of `path`.
pub(super) fn around(
    path: &Utf8Path,
    files: Vec<SourceFile>,
    reading: &SpecificationOptions,
) -> Session {
    let here = absolute(Utf8Path::new(".")).unwrap_or_default();
    Session::new(config::nearest_directory(path).as_deref(), &here, files, reading)
}

pub(super) fn absolute(path: &Utf8Path) -> anyhow::Result<Utf8PathBuf> {
    let path = camino::absolute_utf8(path)
        .with_context(|| format!("`{path}` is not a path that can be used"))?;
    Ok(vfs::normalize(&path))
}

impl Session {
    fn new(
        directory: Option<&Utf8Path>,
        here: &Utf8Path,
        files: Vec<SourceFile>,
        reading: &SpecificationOptions,
    ) -> Session {
        let mut arguments = Settings {
            include_paths: reading.include_paths.clone(),
            release: reading.release,
            ..Settings::default()
        }
        .chosen_by(ReleaseOrigin::CommandLine);
        for define in &reading.defines {
            arguments.define(define);
        }
        let mut settings = arguments.resolved_against(here);
        let mut config = None;
        if let Some(directory) = directory {
            let path = directory.join(config::FILE_NAME);
            let (text, unreadable): (Arc<str>, _) = match vfs::read(&path) {
                FileContent::Text(text) | FileContent::NotUtf8(text) => (text.into(), None),
                FileContent::Missing => ("".into(), None),
                _ => ("".into(), Some(Problem::unreadable())),
            };
            let mut read = config::from_toml(&text);
            read.problems.extend(unreadable);
            let own = read.settings.resolved_against(directory);
            settings = settings.over(own.chosen_by(ReleaseOrigin::ConfigurationFile(path.clone())));
            config = Some(ConfigProblems { path, text, problems: read.problems });
        }
        let mut configuration = Config::new(&settings, here, true);
        configuration.packages.own_interfaces &= !reading.only_installed;
        let vfs = Arc::new(Vfs::new(configuration.packages.clone()));
        let mut host = AnalysisHost::new(vfs);
        let given = files
            .iter()
            .filter_map(|file| Some((file.path.clone(), Some(file.text.as_deref()?.to_owned()))));
        host.apply(Change {
            files: given.collect(),
            roots: Some(files.iter().map(|file| file.path.clone()).collect()),
            config: Some(configuration.for_analysis()),
            ..Change::default()
        });
        Session {
            files,
            config,
            host,
            packages: configuration.packages.clone(),
            connections: configuration.connections.into_iter().map(|(_, one)| one).collect(),
            codels: settings.codels.files(),
            indexes: Arc::default(),
            format: settings.format,
            severity: configuration.severity,
            #[cfg(feature = "zenoh")]
            ros2: settings.ros2.rules(),
        }
    }

    /// Returns the folders in which the command writes, and the files that the user named, which may be
    /// links.
    pub(super) fn writable(&self) -> Vec<Utf8PathBuf> {
        let folders = self.files.iter().map(|file| file.folder.clone());
        let named = self.files.iter().filter(|file| file.named).map(|file| file.path.clone());
        let mut all: Vec<Utf8PathBuf> = folders.chain(named).collect();
        all.sort();
        // A path below another one adds nothing, unless it is a link.
        let outer = all.clone();
        all.retain(|path| {
            path.is_symlink() || !outer.iter().any(|other| path != other && path.starts_with(other))
        });
        all.dedup();
        all
    }

    /// Returns the host, for commands that change texts before queries.
    pub(super) fn host_mut(&mut self) -> &mut AnalysisHost {
        &mut self.host
    }

    /// Returns the connections between components that the configuration gives.
    pub(super) fn connections(&self) -> &[dotgen_diagram::system::Connection] {
        &self.connections
    }

    /// Returns the configuration of packages.
    pub(super) fn packages(&self) -> &PackageConfig {
        &self.packages
    }

    /// Returns the configuration of the sources of codels.
    pub(super) fn codels(&self) -> FilesConfig {
        self.codels.clone()
    }

    /// Runs a query. A bug in analysis is an error of this command.
    pub(super) fn ask<R>(
        &self,
        about: &Utf8Path,
        question: impl FnOnce(&Analysis) -> Cancellable<R>,
    ) -> anyhow::Result<R> {
        let analysis = self.host.analysis();
        told(about, panic::isolate(|| question(&analysis)))
    }

    /// Runs a query for many files, on all cores, and passes on each answer in the order of the files. Cached
    /// results do not grow with the number of files.
    pub(super) fn ask_each<R: Send>(
        &mut self,
        files: &[Utf8PathBuf],
        question: impl Fn(&Analysis, &Utf8Path) -> Cancellable<R> + Sync,
        mut answered: impl FnMut(&Session, &Utf8Path, R) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        self.host.keep_little();
        for batch in files.chunks(MAX_CACHED_FILES) {
            let analysis = self.host.analysis();
            let one = |analysis: &Analysis, path: &Utf8PathBuf| {
                panic::isolate(|| question(analysis, path))
            };
            let fork = || self.host.analysis();
            let answers = parallel::map(batch, fork, |path| one(&analysis, path), one);
            for (path, answer) in std::iter::zip(batch, answers) {
                answered(self, path, told(path, answer)?)?;
            }
            // The host waits for the last snapshot.
            drop(analysis);
            self.host.evict_cache();
        }
        Ok(())
    }

    /// Adds the texts to which diagnostics refer.
    pub(super) fn add_texts(
        &self,
        diagnostics: &[Diagnostic],
        texts: &mut Texts,
    ) -> anyhow::Result<()> {
        for diagnostic in diagnostics {
            let related = diagnostic.related.iter().map(|related| &related.path);
            let fixes = diagnostic.fixes.iter().flat_map(|fix| &fix.edits);
            let paths = std::iter::once(&diagnostic.path).chain(related);
            for path in paths.chain(fixes.map(|fix| &fix.path)) {
                if !texts.contains_key(path) {
                    let text = self.ask(path, |analysis| analysis.text(path))?.unwrap_or_default();
                    texts.insert(path.clone(), Lines::new(text, Encoding::Utf16));
                }
            }
        }
        Ok(())
    }
}

/// Returns an answer about a file. A bug in analysis is an error of the command.
fn told<R>(about: &Utf8Path, answer: Result<Cancellable<R>, String>) -> anyhow::Result<R> {
    match answer {
        Ok(Ok(answer)) => Ok(answer),
        Ok(Err(cancelled)) => bail!("reading `{about}` was cancelled ({cancelled:?})"),
        Err(message) => bail!("internal error while reading `{about}`: {message}"),
    }
}

/// Texts by path, with lines as in the LSP.
pub(super) type Texts = FxHashMap<Utf8PathBuf, Lines>;

/// Returns a path for display: relative if it is below the current directory.
pub(super) fn display(path: &Utf8Path) -> String {
    match absolute(Utf8Path::new(".")) {
        Ok(here) => path.strip_prefix(&here).unwrap_or(path).to_string(),
        Err(_) => path.to_string(),
    }
}
