//! A specification, or several, read for one command.

use anyhow::{Context, bail};
use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::Diagnostic;
use dotgen_analysis::host::{Analysis, AnalysisHost, Cancellable, Change, FileContent};
use dotgen_analysis::parallel;
use dotgen_analysis::release::ReleaseOrigin;
use dotgen_codegen::codels::files::FilesConfig;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;
use std::sync::Arc;

use super::Reading;
use crate::config::{self, Config, Level, Problem, Settings};
use crate::convert::{Encoding, Lines};
use crate::panic;
use crate::verification::problem::EXTENSION;
use crate::vfs::{self, Vfs};

/// Files that are read before what is known of them is forgotten again.
const BATCH: usize = 64;

/// Files that share a configuration.
pub(super) struct Session {
    pub(super) files: Vec<SourceFile>,
    /// What is wrong with the configuration file.
    pub(super) config: Option<ConfigProblems>,
    host: AnalysisHost,
    connections: Vec<dotgen_diagram::system::Connection>,
    codels: FilesConfig,
    /// The style of the formatter.
    pub(super) format: config::Format,
    /// Severity by diagnostic code.
    pub(super) severity: BTreeMap<String, Level>,
}

/// A specification to read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct SourceFile {
    pub(super) path: Utf8PathBuf,
    /// Named by the user, not found in a directory.
    pub(super) named: bool,
}

impl SourceFile {
    /// Whether it says what is to be verified.
    pub(super) fn is_scenario(&self) -> bool {
        self.path.extension() == Some(EXTENSION)
    }
}

/// Problems of a `dotgen.toml`.
pub(super) struct ConfigProblems {
    pub(super) path: Utf8PathBuf,
    pub(super) text: Arc<str>,
    pub(super) problems: Vec<Problem>,
}

/// The files that the arguments name: files themselves, directories all `.gen` below them.
pub(super) fn files(arguments: &[Utf8PathBuf]) -> anyhow::Result<Vec<SourceFile>> {
    let mut files: Vec<SourceFile> = Vec::new();
    let mut known = FxHashSet::default();
    let mut add = |path: Utf8PathBuf, named| {
        if known.insert(path.clone()) {
            files.push(SourceFile { path, named });
        }
    };
    for argument in arguments {
        let path = absolute(argument)?;
        match vfs::read(&path) {
            FileContent::Directory => {
                let found = vfs::files_below(&path, &["gen"]);
                if found.is_empty() {
                    bail!("no .gen file below `{argument}`");
                }
                found.into_iter().for_each(|it| add(it, false));
            }
            FileContent::Text(_) | FileContent::NotUtf8(_) => add(path, true),
            FileContent::Missing => bail!("cannot read `{argument}`: no such file or directory"),
            FileContent::Unreadable(why) => bail!("cannot read `{argument}`: {why}"),
        }
    }
    Ok(files)
}

/// As [`files`], for commands that have nothing to do with scenarios.
pub(super) fn specifications(arguments: &[Utf8PathBuf]) -> anyhow::Result<Vec<SourceFile>> {
    let files = files(arguments)?;
    if let Some(it) = files.iter().find(|it| it.is_scenario()) {
        let path = display(&it.path);
        bail!("`{path}` is a scenario, not a specification: `dotgen verify {path}` verifies it");
    }
    Ok(files)
}

/// The one file that a command is about.
pub(super) fn single(argument: &Utf8Path, reading: &Reading) -> anyhow::Result<Session> {
    if argument.is_dir() {
        bail!("`{argument}` is a directory; name a file");
    }
    let mut sessions = open(specifications(&[argument.to_owned()])?, reading)?;
    sessions.pop().context("there is nothing to read")
}

/// Groups files by the nearest `dotgen.toml` around them.
pub(super) fn open(files: Vec<SourceFile>, reading: &Reading) -> anyhow::Result<Vec<Session>> {
    let mut groups: Vec<(Option<Utf8PathBuf>, Vec<SourceFile>)> = Vec::new();
    let mut nearest: FxHashMap<Utf8PathBuf, Option<Utf8PathBuf>> = FxHashMap::default();
    for file in files {
        let around = file.path.parent().unwrap_or(&file.path).to_owned();
        let directory = nearest
            .entry(around)
            .or_insert_with(|| config::nearest_directory(&file.path))
            .clone();
        match groups.iter_mut().find(|it| it.0 == directory) {
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

/// Files under the configuration that counts for `path`.
pub(super) fn around(path: &Utf8Path, files: Vec<SourceFile>, reading: &Reading) -> Session {
    let here = absolute(Utf8Path::new(".")).unwrap_or_default();
    Session::new(
        config::nearest_directory(path).as_deref(),
        &here,
        files,
        reading,
    )
}

fn absolute(path: &Utf8Path) -> anyhow::Result<Utf8PathBuf> {
    let path = camino::absolute_utf8(path)
        .with_context(|| format!("`{path}` is not a path that can be used"))?;
    Ok(vfs::normalize(&path))
}

impl Session {
    fn new(
        directory: Option<&Utf8Path>,
        here: &Utf8Path,
        files: Vec<SourceFile>,
        reading: &Reading,
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
        let mut settings = arguments.anchored(here);
        let mut config = None;
        if let Some(directory) = directory {
            let path = directory.join(config::FILE_NAME);
            let text: Arc<str> = match vfs::read(&path) {
                FileContent::Text(text) | FileContent::NotUtf8(text) => text.into(),
                _ => "".into(),
            };
            let read = config::from_toml(&text);
            let own = read.settings.anchored(directory);
            settings = settings.over(own.chosen_by(ReleaseOrigin::ConfigurationFile(path.clone())));
            config = Some(ConfigProblems {
                path,
                text,
                problems: read.problems,
            });
        }
        let configuration = Config::new(&settings, here, true);
        let vfs = Arc::new(Vfs::new(configuration.packages.clone()));
        let mut host = AnalysisHost::new(vfs);
        host.apply(Change {
            roots: Some(files.iter().map(|it| it.path.clone()).collect()),
            config: Some(configuration.for_analysis()),
            ..Change::default()
        });
        Session {
            files,
            config,
            host,
            connections: configuration.connections,
            codels: settings.codels.files(),
            format: settings.format,
            severity: configuration.severity,
        }
    }

    /// The host, for commands that change texts before they ask.
    pub(super) fn host_mut(&mut self) -> &mut AnalysisHost {
        &mut self.host
    }

    /// Connections between components that the configuration gives.
    pub(super) fn connections(&self) -> &[dotgen_diagram::system::Connection] {
        &self.connections
    }

    /// Which files hold codels.
    pub(super) fn codels(&self) -> FilesConfig {
        self.codels.clone()
    }

    /// Asks analysis something. A bug in there is an error of this command.
    pub(super) fn ask<R>(
        &self,
        about: &Utf8Path,
        question: impl FnOnce(&Analysis) -> Cancellable<R>,
    ) -> anyhow::Result<R> {
        let analysis = self.host.analysis();
        told(about, panic::isolate(|| question(&analysis)))
    }

    /// Asks the same of many files, on all cores, and hands each answer on in the order of the files. What is
    /// remembered from the files does not grow with their number.
    pub(super) fn ask_each<R: Send>(
        &mut self,
        files: &[Utf8PathBuf],
        question: impl Fn(&Analysis, &Utf8Path) -> Cancellable<R> + Sync,
        mut answered: impl FnMut(&Session, &Utf8Path, R) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        self.host.keep_little();
        for batch in files.chunks(BATCH) {
            let analysis = self.host.analysis();
            let one = |analysis: &Analysis, path: &Utf8PathBuf| {
                panic::isolate(|| question(analysis, path))
            };
            let fork = || self.host.analysis();
            let answers = parallel::map(batch, fork, |it| one(&analysis, it), one);
            for (path, answer) in std::iter::zip(batch, answers) {
                answered(self, path, told(path, answer)?)?;
            }
            // The host waits for the last snapshot.
            drop(analysis);
            self.host.shrink();
        }
        Ok(())
    }

    /// The texts that diagnostics talk about.
    pub(super) fn add_texts(
        &self,
        diagnostics: &[Diagnostic],
        texts: &mut Texts,
    ) -> anyhow::Result<()> {
        for diagnostic in diagnostics {
            let related = diagnostic.related.iter().map(|it| &it.path);
            let fixes = diagnostic.fixes.iter().flat_map(|it| &it.edits);
            let paths = std::iter::once(&diagnostic.path).chain(related);
            for path in paths.chain(fixes.map(|it| &it.path)) {
                if !texts.contains_key(path) {
                    let text = self.ask(path, |it| it.text(path))?.unwrap_or_default();
                    texts.insert(path.clone(), Lines::new(text, Encoding::Utf16));
                }
            }
        }
        Ok(())
    }
}

/// An answer about a file. A bug in analysis is an error of the command.
fn told<R>(about: &Utf8Path, answer: Result<Cancellable<R>, String>) -> anyhow::Result<R> {
    match answer {
        Ok(Ok(answer)) => Ok(answer),
        Ok(Err(cancelled)) => bail!("reading `{about}` was cancelled ({cancelled:?})"),
        Err(message) => bail!("internal error while reading `{about}`: {message}"),
    }
}

/// Texts by path, with lines as the LSP counts them.
pub(super) type Texts = FxHashMap<Utf8PathBuf, Lines>;

/// A path as the user would write it: relative if it is below the current directory.
pub(super) fn display(path: &Utf8Path) -> String {
    match absolute(Utf8Path::new(".")) {
        Ok(here) => path.strip_prefix(&here).unwrap_or(path).to_string(),
        Err(_) => path.to_string(),
    }
}
