//! A run of a template that writes no file.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{Cancellable, FileContent, Loader, PackageFlags};
use dotgen_analysis::release::ReleaseChoice;
use dotgen_codegen::catalog::{self, TemplateInfo, TemplateOption};
use dotgen_codegen::command::{self, Environment};
use dotgen_codegen::disk::{Disk, Entry, NewContent, Status, WriteError};
use dotgen_codegen::template::console::CapturedConsole;
use dotgen_codegen::template::discover::SearchPath;
use dotgen_codegen::template::{
    Confinement, Confirmation, Limits, OutputSink, PreviewFile, TemplatePlace,
};
use rustc_hash::FxHashMap;

use super::choices;
use crate::config::{Config, Generate};
use crate::protocol::client::ClientCaps;
use crate::protocol::convert::uri;
use crate::workspace::snapshot::{Snapshot, Subject};
use dotgen_platform::files::disk::SystemDisk;
use dotgen_platform::files::vfs::Vfs;

/// The input of a run, taken from the state when the command arrived.
#[derive(Clone)]
pub(crate) struct Job {
    /// The specification.
    pub(crate) file: Utf8PathBuf,
    /// The workspace folder, or the folder of the file.
    pub(crate) folder: Utf8PathBuf,
    /// The folders in which a template may write: the workspace, or the folder of a file outside it.
    folders: Vec<Utf8PathBuf>,
    pub(crate) config: Arc<Config>,
    pub(crate) client: Arc<ClientCaps>,
    /// Texts of the open documents, which take precedence over the disk.
    open: Arc<FxHashMap<Utf8PathBuf, String>>,
    /// The client shows the text of each file before one is written.
    pub(crate) reviewed: bool,
}

/// The result of a run.
pub(crate) struct Generated {
    /// The exit status of the template.
    pub(crate) status: i32,
    /// Files by path, as written by the template.
    pub(crate) files: BTreeMap<PathBuf, PreviewFile>,
    /// The standard output.
    pub(crate) output: String,
    /// The error output.
    pub(crate) messages: String,
    /// The place in the template of its failure.
    pub(crate) failed_at: Option<TemplatePlace>,
}

/// The job for a document; `None` if the document is not a file.
pub(crate) fn job(snapshot: &Snapshot, subject: &Subject, _: &()) -> Cancellable<Option<Box<Job>>> {
    let file = subject.path.clone();
    if uri::is_virtual(&file) {
        return Ok(None);
    }
    let mut open = FxHashMap::default();
    for path in snapshot.open.keys() {
        if let Some(text) = snapshot.analysis.text(path)? {
            open.insert(path.clone(), text.to_string());
        }
    }
    let own = file.parent().map(Utf8Path::to_owned).unwrap_or_default();
    let folders = snapshot.folders.iter().filter(|folder| file.starts_with(folder));
    let folder = folders.max_by_key(|folder| folder.as_str().len()).cloned();
    let project = snapshot.config.project(&file);
    let folder = project.map(|project| project.directory.clone()).or(folder);
    let folder = folder.or_else(|| crate::config::nearest_directory(&file));
    let folder = folder.unwrap_or(own);
    let mut folders = snapshot.folders.to_vec();
    if !folders.iter().any(|folder| file.starts_with(folder)) {
        folders.push(folder.clone());
    }
    Ok(Some(Box::new(Job {
        folder,
        folders,
        file,
        config: snapshot.config.clone(),
        client: snapshot.client.clone(),
        open: Arc::new(open),
        reviewed: false,
    })))
}

impl Job {
    /// True if programs may be run for this workspace.
    pub(crate) fn trusted(&self) -> bool {
        self.config.packages.may_run
    }

    /// The stored choices for this file.
    pub(crate) fn remembered(&self) -> Vec<Generate> {
        let all = self.config.generate.iter();
        let own = all.filter(|generate| generate.file == self.file.as_str());
        let named = own.map(|generate| Generate { file: self.name(), ..generate.clone() });
        named.collect()
    }

    /// The name of the file in `dotgen.toml`.
    pub(crate) fn name(&self) -> String {
        choices::relative(&self.file, &self.folder)
    }

    /// The directories of the settings, which may be of another author.
    fn template_paths(&self) -> Option<String> {
        let paths = self.config.template_paths.iter().map(|path| path.as_str());
        let paths: Vec<&str> = paths.collect();
        (!paths.is_empty()).then(|| paths.join(":"))
    }

    fn search(&self) -> SearchPath {
        command::search_path(self.template_paths().as_deref(), &environment)
    }

    /// The available templates.
    pub(crate) fn templates(&self) -> Vec<TemplateInfo> {
        catalog::templates(&SystemDisk, &self.search(), !self.config.template_paths.is_empty())
    }

    /// The description of a template, and its options.
    pub(crate) fn usage(&self, template: &str) -> (String, Vec<TemplateOption>) {
        let shown = self.run_words(&[template.to_owned(), "-h".to_owned()], Arc::default());
        let options = catalog::options(&shown.output);
        (shown.output.trim().to_owned(), options)
    }

    /// Runs a template on the file. Conflicts of a merge become conflict markers, because the run cannot ask
    /// questions.
    pub(crate) fn run(
        &self,
        template: &str,
        arguments: &[String],
        cancel: Arc<AtomicBool>,
    ) -> Generated {
        if let Some(why) = self.unknown(template) {
            return Generated {
                status: 2,
                files: BTreeMap::new(),
                output: String::new(),
                messages: why,
                failed_at: None,
            };
        }
        let mut words = vec![template.to_owned()];
        words.extend(arguments.iter().cloned());
        words.push(self.file.file_name().unwrap_or_default().to_owned());
        self.run_words(&words, cancel)
    }

    /// The message for an unknown template, or `None` if the template exists. In an editor it names settings,
    /// not options.
    fn unknown(&self, template: &str) -> Option<String> {
        let all = self.templates();
        let known = all.iter().any(|template_info| template_info.name == template);
        if known || Utf8Path::new(template).is_absolute() {
            return None;
        }
        let names: Vec<String> =
            all.iter().map(|template| format!("`{}`", template.name)).collect();
        Some(format!(
            "there is no template `{template}`; choose one of {}, or add the directory that has it to the setting \
             `dotgen.templatePaths` (`template-paths` in dotgen.toml)",
            names.join(", ")
        ))
    }

    fn run_words(&self, words: &[String], cancel: Arc<AtomicBool>) -> Generated {
        let mut arguments = Vec::new();
        let (include_paths, defines) = match self.config.project(&self.file) {
            Some(project) => (&project.include_paths, &project.defines),
            None => (&self.config.include_paths, &self.config.defines),
        };
        for dir in include_paths {
            arguments.extend(["-I".to_owned(), dir.to_string()]);
        }
        for (name, body) in defines {
            arguments.extend(["-D".to_owned(), format!("{name}={body}")]);
        }
        arguments.extend(words.iter().cloned());
        let mut console = CapturedConsole::default();
        console.answer = Some("c".to_owned());
        let rules = self.config.ros2.rules();
        let mut environment = Environment {
            name: "dotgen",
            program: std::env::current_exe().unwrap_or_else(|_| "dotgen".into()),
            variables: &environment,
            disk: Arc::new(OverlayDisk(self.open.clone())),
            loader: Arc::new(Overlay {
                open: self.open.clone(),
                disk: Vfs::new(self.config.packages.clone()),
            }),
            pictures: Arc::new(dotgen_views::pictures::machine),
            ros2: Arc::new(move |spec| {
                dotgen_ros2::interfaces::packages(spec, &rules).map_err(|errors| {
                    let errors: Vec<String> = errors.iter().map(ToString::to_string).collect();
                    errors.join("\n")
                })
            }),
            console: &mut console,
            limits: Limits { cancel: Some(cancel), ..Limits::preview() },
            base: self.file.parent().map(Into::into).unwrap_or_default(),
            sink: OutputSink::PREVIEW,
            processes: dotgen_platform::process::system(),
            confined: Some(Confinement {
                results: self.folders.iter().map(Into::into).collect(),
                confirmed: Confirmation::Shown,
                reviewed: self.reviewed,
            }),
            failed_at: None,
            project_templates: self.template_paths(),
            release: self.config.release_of(&self.file),
        };
        let status = command::generate(&arguments, &mut environment);
        let sink = std::mem::replace(&mut environment.sink, OutputSink::DIRECT);
        let failed_at = environment.failed_at.take();
        Generated {
            status,
            files: sink.files,
            output: String::from_utf8_lossy(&console.out).into_owned(),
            messages: console.err,
            failed_at,
        }
    }
}

fn environment(name: &str) -> Option<String> {
    std::env::var(name).ok()
}

/// The disk with the open documents over it: a template merges with the texts that the client will change.
#[derive(Debug)]
struct OverlayDisk(Arc<FxHashMap<Utf8PathBuf, String>>);

impl Disk for OverlayDisk {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        match Utf8Path::from_path(path).and_then(|path| self.0.get(path)) {
            Some(text) => Ok(text.clone().into_bytes()),
            None => SystemDisk.read(path),
        }
    }

    fn status(&self, path: &Path) -> Option<Status> {
        SystemDisk.status(path)
    }

    fn list(&self, directory: &Path) -> io::Result<Vec<Entry>> {
        SystemDisk.list(directory)
    }

    fn canonical(&self, path: &Path) -> io::Result<PathBuf> {
        SystemDisk.canonical(path)
    }

    fn current_dir(&self) -> PathBuf {
        SystemDisk.current_dir()
    }

    fn write(&self, files: &[NewContent]) -> Result<(), WriteError> {
        SystemDisk.write(files)
    }

    fn set_mode(&self, path: &Path, mode: u32) -> io::Result<()> {
        SystemDisk.set_mode(path, mode)
    }

    fn is_link(&self, path: &Path) -> bool {
        SystemDisk.is_link(path)
    }

    fn put(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        SystemDisk.put(path, bytes)
    }

    fn remove(&self, path: &Path) {
        SystemDisk.remove(path);
    }
}

/// The open documents over the disk.
struct Overlay {
    open: Arc<FxHashMap<Utf8PathBuf, String>>,
    disk: Vfs,
}

impl Loader for Overlay {
    fn read(&self, path: &Utf8Path) -> FileContent {
        match self.open.get(path) {
            Some(text) => FileContent::Text(text.clone()),
            None => self.disk.read(path),
        }
    }

    fn packages(&self, arguments: &[String]) -> Result<PackageFlags, String> {
        self.disk.packages(arguments)
    }

    fn installed_release(&self) -> Option<ReleaseChoice> {
        self.disk.installed_release()
    }
}
