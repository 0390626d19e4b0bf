//! Workspace folders, their files, and the layers of configuration.

use std::collections::BTreeSet;
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::FileContent;
use dotgen_analysis::language::SCENARIO;
use dotgen_codegen::template::files::SCRIPT;
use serde_json::Value;

use crate::config::{self, Config, Problem, Settings};
use crate::protocol::convert::{Encoding, Lines, uri};
use crate::protocol::types::{
    self, Diagnostic, DiagnosticSeverity, InitializeParams, NumberOrString, Uri,
    WorkspaceFoldersChangeEvent,
};
use crate::workspace::templates::Templates;
use dotgen_platform::files::vfs;

/// The folders of the workspace and their contents.
#[derive(Default)]
pub(crate) struct Workspace {
    folders: Vec<Folder>,
    /// Other directories with a `dotgen.toml`, most of them below the folders.
    projects: Vec<Folder>,
    /// `.gen` files below the folders.
    pub(crate) files: BTreeSet<Utf8PathBuf>,
    /// `.scn` files below the folders.
    pub(crate) scenarios: Arc<BTreeSet<Utf8PathBuf>>,
    /// Templates below the folders.
    pub(crate) templates: Arc<Templates>,
    /// Settings of the editor for every folder.
    editor: Settings,
    trusted: bool,
}

struct Folder {
    /// The URI in the spelling of the client; `None` for the directory of a file opened without a workspace.
    uri: Option<Uri>,
    path: Utf8PathBuf,
    file: ConfigFile,
    /// Settings of the editor for this folder alone.
    editor: Option<Settings>,
}

/// The `dotgen.toml` of a folder.
#[derive(Default)]
struct ConfigFile {
    text: String,
    settings: Settings,
    problems: Vec<Problem>,
}

impl Folder {
    fn new(uri: Option<Uri>, path: Utf8PathBuf) -> Folder {
        let file = ConfigFile::read(&path);
        Folder { uri, path, file, editor: None }
    }
}

impl ConfigFile {
    fn read(folder: &Utf8Path) -> ConfigFile {
        match vfs::read(&folder.join(config::FILE_NAME)) {
            FileContent::Text(text) => {
                let read = config::from_toml(&text);
                ConfigFile { text, settings: read.settings, problems: read.problems }
            }
            FileContent::Missing => ConfigFile::default(),
            _ => ConfigFile { problems: vec![Problem::unreadable()], ..ConfigFile::default() },
        }
    }
}

impl Workspace {
    /// Reads folders, trust and settings from `initialize`. Returns the errors in the settings.
    pub(crate) fn initialize(&mut self, params: &InitializeParams) -> BTreeSet<String> {
        let options = params.initialization_options.as_ref();
        let option = |name: &str| options.and_then(|option| option.get(name));
        self.trusted = option("trusted").and_then(Value::as_bool).unwrap_or(false);
        let problems = match option("settings") {
            Some(settings) => self.set_editor_settings(std::slice::from_ref(settings)),
            None => BTreeSet::new(),
        };
        let folders = params.workspace_folders.clone().unwrap_or_default();
        let mut uris: Vec<Uri> = folders.into_iter().map(|folder| folder.uri).collect();
        if uris.is_empty() {
            #[allow(deprecated, reason = "older clients send nothing else")]
            uris.extend(params.root_uri.clone());
        }
        for uri in uris {
            self.add(uri);
        }
        problems
    }

    fn add(&mut self, uri: Uri) {
        let path = uri::to_path(&uri);
        if self.folders.iter().all(|folder| folder.path != path) {
            self.folders.push(Folder::new(Some(uri), path));
        }
    }

    /// `didChangeWorkspaceFolders`
    pub(crate) fn change_folders(&mut self, event: &WorkspaceFoldersChangeEvent) {
        let removed: Vec<_> =
            event.removed.iter().map(|folder| uri::to_path(&folder.uri)).collect();
        self.folders.retain(|folder| !removed.contains(&folder.path));
        self.files.retain(|file| !removed.iter().any(|folder| file.starts_with(folder)));
        let kept = |path: &Utf8Path| !removed.iter().any(|folder| path.starts_with(folder));
        self.projects.retain(|project| kept(&project.path));
        Arc::make_mut(&mut self.templates).retain(kept);
        Arc::make_mut(&mut self.scenarios).retain(|scenario| kept(scenario));
        for folder in &event.added {
            self.add(folder.uri.clone());
        }
    }

    /// Sets the files found below the folders. Returns true if the configuration may have changed.
    pub(crate) fn set_files(&mut self, files: Vec<Utf8PathBuf>) -> bool {
        let (mut scripts, mut scenarios) = (Vec::new(), BTreeSet::new());
        let mut configured = false;
        self.files.clear();
        for file in files {
            match file.extension() {
                Some(SCENARIO) => _ = scenarios.insert(file),
                Some("tcl") => scripts.push(file),
                Some("toml") if file.file_name() == Some(config::FILE_NAME) => {
                    configured |= self.add_project(file.parent());
                }
                Some("toml") => {}
                _ => _ = self.files.insert(file),
            }
        }
        scripts.retain(|script| script.file_name() == Some(SCRIPT));
        self.scenarios = Arc::new(scenarios);
        self.templates = Arc::new(Templates::new(scripts));
        configured
    }

    /// Removes the files at or below a path. Returns true if there were any.
    pub(crate) fn remove(&mut self, path: &Utf8Path) -> bool {
        let kept = |other: &Utf8Path| !other.starts_with(path);
        let before = self.files.len() + self.scenarios.len();
        self.files.retain(|file| kept(file));
        Arc::make_mut(&mut self.scenarios).retain(|change| kept(change));
        Arc::make_mut(&mut self.templates).retain(kept);
        before != self.files.len() + self.scenarios.len()
    }

    /// Adds a directory with a `dotgen.toml`. Returns true if it is new.
    fn add_project(&mut self, directory: Option<&Utf8Path>) -> bool {
        let known = |path: &Utf8Path| {
            let mut all = self.folders.iter().chain(&self.projects);
            all.any(|known| known.path == path)
        };
        let Some(directory) = directory.filter(|directory| !known(directory)) else {
            return false;
        };
        self.projects.push(Folder::new(None, directory.to_owned()));
        self.projects.sort_by(|a, b| a.path.cmp(&b.path));
        true
    }

    /// Uses the configuration of the nearest directory around an open file that has a `dotgen.toml`. Without
    /// workspace folders, the directory of the first such file becomes the only folder; its files are not
    /// listed. Returns true if the configuration may have changed.
    pub(crate) fn adopt(&mut self, file: &Utf8Path) -> bool {
        if uri::is_virtual(file) {
            return false;
        }
        let directory = config::nearest_directory(file);
        match directory {
            Some(directory) if self.folders.is_empty() => {
                self.folders.push(Folder::new(None, directory));
                true
            }
            directory => self.add_project(directory.as_deref()),
        }
    }

    /// Sets the settings for every folder, then those of each folder in turn. Returns the errors in them.
    pub(crate) fn set_editor_settings(&mut self, values: &[Value]) -> BTreeSet<String> {
        let mut problems = BTreeSet::new();
        let mut values = values.iter().map(|value| {
            let read = config::from_editor(value);
            problems.extend(read.problems.into_iter().map(|problem| problem.message));
            read.settings
        });
        self.editor = values.next().unwrap_or_default();
        let folders = self.folders.iter_mut().filter(|folder| folder.uri.is_some());
        for folder in folders {
            folder.editor = values.next();
        }
        problems
    }

    /// Reads the configuration files again. `changed` is one of them, and may be new.
    pub(crate) fn reload_files(&mut self, changed: &Utf8Path) {
        if self.contains(changed) {
            self.add_project(changed.parent());
        }
        for folder in self.folders.iter_mut().chain(&mut self.projects) {
            folder.file = ConfigFile::read(&folder.path);
        }
        self.projects.retain(|project| project.path.join(config::FILE_NAME).is_file());
    }

    /// The configuration in force.
    pub(crate) fn config(&self) -> Config {
        let of = |folder: &Folder| {
            // A folder's own settings already contain the general settings: clients answer in this way.
            let editor = folder.editor.clone().unwrap_or_else(|| self.editor.clone());
            let settings = editor.over(folder.file.settings.clone());
            Config::new(&settings, &folder.path, self.trusted)
        };
        let folders = self.folders.iter().map(of).reduce(Config::join);
        let all =
            folders.unwrap_or_else(|| Config::new(&self.editor, Utf8Path::new("/"), self.trusted));
        self.projects.iter().fold(all, |all, project| {
            let around = self.folders.iter();
            let around = around.filter(|folder| project.path.starts_with(&folder.path));
            let around = around.max_by_key(|folder| folder.path.as_str().len());
            let editor = around.and_then(|folder| folder.editor.as_ref()).unwrap_or(&self.editor);
            // Paths in the editor's settings are relative to the workspace folder.
            let base = around.map_or(&project.path, |folder| &folder.path);
            let own = project.file.settings.clone().resolved_against(&project.path);
            let settings = editor.clone().resolved_against(base).over(own);
            let own = Config::new(&settings, &project.path, self.trusted);
            all.with_project(&project.path, own)
        })
    }

    /// The errors in configuration files, by file. Files without errors are absent.
    pub(crate) fn problems(&self, encoding: Encoding) -> Vec<(Utf8PathBuf, Vec<Diagnostic>)> {
        let of = |folder: &Folder| {
            let lines = Lines::new(folder.file.text.as_str().into(), encoding);
            let diagnostics = folder.file.problems.iter().map(|problem| Diagnostic {
                range: lines.range(&problem.range.clone().unwrap_or(0..0)),
                severity: Some(if problem.kind.is_error() {
                    DiagnosticSeverity::ERROR
                } else {
                    DiagnosticSeverity::WARNING
                }),
                code: Some(NumberOrString::String(problem.kind.code().to_owned())),
                source: Some(types::SOURCE.to_owned()),
                message: problem.message.clone(),
                ..Diagnostic::default()
            });
            (folder.path.join(config::FILE_NAME), diagnostics.collect())
        };
        let with_problems = self
            .folders
            .iter()
            .chain(&self.projects)
            .filter(|folder| !folder.file.problems.is_empty());
        with_problems.map(of).collect()
    }

    /// The configuration files, which may not exist yet.
    pub(crate) fn config_files(&self) -> impl Iterator<Item = Utf8PathBuf> {
        let folders = self.folders.iter().chain(&self.projects);
        folders.map(|folder| folder.path.join(config::FILE_NAME))
    }

    /// The folders of the client.
    pub(crate) fn folder_uris(&self) -> impl Iterator<Item = Uri> {
        self.folders.iter().filter_map(|folder| folder.uri.clone())
    }

    /// The folders whose files belong to the workspace.
    pub(crate) fn scanned_folders(&self) -> Vec<Utf8PathBuf> {
        let folders = self.folders.iter().filter(|folder| folder.uri.is_some());
        folders.map(|folder| folder.path.clone()).collect()
    }

    /// True if a path is below a folder of the client.
    pub(crate) fn contains(&self, path: &Utf8Path) -> bool {
        let mut folders = self.folders.iter().filter(|folder| folder.uri.is_some());
        folders.any(|folder| path.starts_with(&folder.path))
    }
}
