//! Fixtures: several files in one string, a cursor, and a log of what the database did.
//!
//! ```text
//! //- /main.gen
//! #include "types.idl"
//! component c { port in t$0 p; };
//! //- /types.idl
//! typedef long t;
//! ```
//!
//! Without a header the text is `/main.gen`. `$0` marks the cursor (twice: a range). Every `.gen`
//! file is a root.

use std::{
    collections::BTreeMap,
    fmt::Write as _,
    ops::Range,
    sync::{Arc, Mutex},
};

use camino::{Utf8Path, Utf8PathBuf};

use crate::{
    diagnostic::{Diagnostic, Severity},
    host::{Analysis, AnalysisHost, Change, Config, DirEntry, FileContent, Loader, PackageFlags},
    ide::FilePosition,
};

/// Files in memory, and configured packages.
#[derive(Default)]
pub(crate) struct MemoryLoader {
    pub(crate) files: Mutex<BTreeMap<Utf8PathBuf, String>>,
    pub(crate) packages: Mutex<BTreeMap<String, PackageFlags>>,
}

impl Loader for MemoryLoader {
    fn read(&self, path: &Utf8Path) -> FileContent {
        let files = self.files.lock().unwrap();
        match files.get(path) {
            Some(text) => FileContent::Text(text.clone()),
            None if files.keys().any(|key| key.starts_with(path)) => FileContent::Directory,
            None => FileContent::Missing,
        }
    }

    fn packages(&self, arguments: &[String]) -> Result<PackageFlags, String> {
        let known = self.packages.lock().unwrap();
        let mut flags = PackageFlags::default();
        for argument in arguments {
            let found = known.get(argument).ok_or(format!("no package `{argument}`"))?;
            flags.include_dirs.extend(found.include_dirs.iter().cloned());
            flags.defines.extend(found.defines.iter().cloned());
        }
        Ok(flags)
    }

    fn list_dir(&self, path: &Utf8Path) -> Vec<DirEntry> {
        let files = self.files.lock().unwrap();
        let mut out: Vec<DirEntry> = files
            .keys()
            .filter_map(|key| key.strip_prefix(path).ok())
            .filter_map(|path| {
                let mut parts = path.components();
                Some(DirEntry { name: parts.next()?.to_string(), is_dir: parts.next().is_some() })
            })
            .collect();
        out.dedup();
        out
    }

    fn package_names(&self) -> Vec<String> {
        self.packages.lock().unwrap().keys().cloned().collect()
    }
}

pub(crate) struct Fixture {
    pub(crate) host: AnalysisHost,
    pub(crate) loader: Arc<MemoryLoader>,
    pub(crate) cursor: Option<FilePosition>,
    log: Arc<Mutex<Vec<String>>>,
}

/// Splits a fixture into files; markers stay in the texts.
pub(crate) fn split(fixture: &str) -> Vec<(Utf8PathBuf, String)> {
    let mut files: Vec<(Utf8PathBuf, String)> = Vec::new();
    for line in fixture.split_inclusive('\n') {
        if let Some(path) = line.trim_start().strip_prefix("//- ") {
            files.push((path.trim().into(), String::new()));
        } else if !(files.is_empty() && line.trim().is_empty()) {
            if files.is_empty() {
                files.push(("/main.gen".into(), String::new()));
            }
            files.last_mut().unwrap().1.push_str(line);
        }
    }
    files
}

impl Fixture {
    pub(crate) fn new(fixture: &str) -> Fixture {
        Fixture::with_config(fixture, Config::default())
    }

    pub(crate) fn with_config(fixture: &str, config: Config) -> Fixture {
        let loader = Arc::new(MemoryLoader::default());
        let log = Arc::new(Mutex::new(Vec::new()));
        let events = {
            let log = log.clone();
            Box::new(move |event: salsa::Event| {
                if let salsa::EventKind::WillExecute { database_key } = event.kind {
                    log.lock().unwrap().push(format!("{database_key:?}"));
                }
            })
        };
        let mut host = AnalysisHost::with_events(loader.clone(), events);
        let mut cursor = None;
        let mut roots = Vec::new();
        for (path, mut text) in split(fixture) {
            if let Some(offset) = text.find("$0") {
                text.replace_range(offset..offset + 2, "");
                cursor = Some(FilePosition { path: path.clone(), offset });
            }
            if path.extension() == Some("gen") {
                roots.push(path.clone());
            }
            loader.files.lock().unwrap().insert(path, text);
        }
        host.apply(Change { roots: Some(roots), config: Some(config), ..Change::default() });
        Fixture { host, loader, cursor, log }
    }

    pub(crate) fn analysis(&self) -> Analysis {
        self.host.analysis()
    }

    pub(crate) fn at(&self) -> FilePosition {
        self.cursor.clone().expect("the fixture has a $0")
    }

    pub(crate) fn text(&self, path: &str) -> String {
        let text = self.analysis().text(Utf8Path::new(path)).unwrap();
        text.expect("a file of the fixture").to_string()
    }

    pub(crate) fn paths(&self) -> Vec<Utf8PathBuf> {
        self.loader.files.lock().unwrap().keys().cloned().collect()
    }

    /// Gives a file a new text, as an editor does.
    pub(crate) fn edit(&mut self, path: &str, text: impl Into<String>) {
        self.host
            .apply(Change { files: vec![(path.into(), Some(text.into()))], ..Change::default() });
    }

    /// Replaces the one occurrence of a piece of text.
    pub(crate) fn replace(&mut self, path: &str, from: &str, to: &str) {
        let text = self.text(path);
        assert_eq!(text.matches(from).count(), 1, "`{from}` in {path}");
        self.edit(path, text.replace(from, to));
    }

    /// Names of the queries that ran since the last call, sorted, keys left out.
    pub(crate) fn take_log(&self) -> Vec<String> {
        let mut log = std::mem::take(&mut *self.log.lock().unwrap());
        for log in &mut log {
            let end = log.find('(').unwrap_or(log.len());
            log.truncate(end);
        }
        log.sort();
        log
    }

    /// Diagnostics of every file, one per line: `path:offset..offset severity code: message`.
    pub(crate) fn all_diagnostics(&self) -> String {
        let mut out = String::new();
        for path in self.paths() {
            for diagnostic in self.analysis().diagnostics(&path).unwrap() {
                writeln!(out, "{}", diagnostic_line(&diagnostic)).unwrap();
            }
        }
        out
    }
}

pub(crate) fn diagnostic_line(diagnostic: &Diagnostic) -> String {
    let severity = match diagnostic.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Information => "information",
        Severity::Hint => "hint",
    };
    format!(
        "{}:{:?} {severity} {}: {}",
        diagnostic.path, diagnostic.range, diagnostic.code, diagnostic.message
    )
}

/// Ranges marked by lines of `^^^ label` under the text they mark, with their labels; the marker
/// lines are comments.
pub(crate) fn annotations(text: &str) -> Vec<(Range<usize>, String)> {
    let mut out = Vec::new();
    let mut start = 0;
    let mut previous = 0;
    for line in text.split_inclusive('\n') {
        let trimmed = line.trim_start();
        if let Some(rest) = trimmed.strip_prefix("//")
            && rest.trim_start().starts_with('^')
        {
            let column = line.find('^').unwrap();
            let length =
                line[column..].find(|character| character != '^').unwrap_or(line.len() - column);
            let label = line[column + length..].trim().to_owned();
            out.push((previous + column..previous + column + length, label));
        } else {
            previous = start;
        }
        start += line.len();
    }
    out
}
