//! The GenoM3 template engine.
//!
//! A template is a directory with a Tcl script `template.tcl` and sources that mix text and marked Tcl code.
//! Tcl runs in a process of its own ([`host`]); the engine answers its questions about the specification and
//! writes its files.
//!
//! Rules: "Templates" chapter of the GenoM3 manual.

pub(crate) mod api;
pub mod check;
mod closure;
pub mod console;
pub mod discover;
mod error_location;
pub mod files;
pub(crate) mod host;
pub(crate) mod marker;
pub mod merge;
pub(crate) mod model;
mod mutex;
mod notice;
pub(crate) mod object;
pub(crate) mod output;
pub mod readable_files;
mod script;
mod session;
pub(crate) mod tcl;
pub mod throws;

use std::path::PathBuf;
use std::sync::Arc;

use crate::compiler::Compiler;
use crate::disk::Disk;
use crate::process::Processes;
use console::Console;
use discover::SearchPath;

pub(crate) use error_location::place;
pub use host::{Limits, find_tclsh};
pub use notice::notice;
pub(crate) use notice::notice_of;
pub(crate) use output::Output;
pub use output::{Concern, Modes, OutputSink, PreviewFile};

/// The reason why a question of a template fails.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Failure {
    /// A Tcl error.
    Error(String),
    /// `template fatal`: ends every level.
    Fatal(String),
    /// The run cannot continue.
    Stop(String),
}

impl Failure {
    /// The reason, as text.
    pub(crate) fn into_text(self) -> String {
        match self {
            Failure::Error(text) | Failure::Fatal(text) | Failure::Stop(text) => text,
        }
    }
}

/// A template to run, and its settings.
pub struct Run<'a> {
    /// All access to files.
    pub disk: Arc<dyn Disk>,
    /// Absolute path of the template.
    pub dir: PathBuf,
    /// The words after the template's name, not parsed.
    pub args: Vec<String>,
    /// The directories with templates.
    pub search: &'a SearchPath,
    /// Absolute path of the tool.
    pub program: String,
    /// General options as `dotgen genom cmdline` shows them.
    pub cmdline: String,
    /// True to print progress, and traces of errors.
    pub verbose: bool,
    /// True to keep temporary files.
    pub debug: bool,
    /// Directory for temporary files; by default the system's.
    pub tmpdir: Option<PathBuf>,
    /// The resource limits of the template.
    pub limits: Limits,
    /// Base directory of relative paths; empty for the current one.
    pub base: PathBuf,
    /// Base directory of the names of inputs (`-C`), as given; empty for [`Run::base`].
    pub input_path: String,
    /// Starts the interpreter process.
    pub processes: Arc<dyn Processes>,
    /// The confinement of the template; `None` gives it all rights of its user.
    pub confined: Option<&'a Confinement>,
    /// Files in control folders that a template may write without being confined, by absolute path.
    pub allowed: Vec<PathBuf>,
}

/// The rights of a confined run. It starts no program, has no network, reads only its template and its
/// inputs, and writes nothing itself: the engine keeps its results.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Confinement {
    /// Folders for its results.
    pub results: Vec<PathBuf>,
    /// The confirmation of hidden files and of executable ones.
    pub confirmed: Confirmation,
    /// True if the user reviews all results before they are written. A file that exists is then merged where
    /// the template would refuse to write it.
    pub reviewed: bool,
}

/// The confirmation of results that act later: hidden files and executable files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Confirmation {
    /// Only these files, by absolute path.
    Only(Vec<PathBuf>),
    /// All that the user selects: results are shown and marked before they are written.
    Shown,
    /// All: the template is part of dotgen.
    All,
}

/// The result of a run.
#[derive(Debug)]
pub struct TemplateResult {
    /// Exit status: 0, the status of the template's `exit`, or 2.
    pub status: i32,
    /// The written files, if they were kept.
    pub sink: OutputSink,
    /// The error that ended the run; already printed.
    pub error: Option<String>,
    /// The place of the error in the files of the template, if known.
    pub place: Option<TemplatePlace>,
}

/// A place in a file of a template.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TemplatePlace {
    /// Absolute path of the file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: u32,
    /// The error, without the place.
    pub message: String,
}

impl Run<'_> {
    /// Last component of the template's directory.
    pub fn name(&self) -> String {
        let name = self.dir.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    /// Runs the template.
    pub fn execute(
        &self,
        compiler: &mut Compiler,
        console: &mut dyn Console,
        sink: OutputSink,
    ) -> TemplateResult {
        let tmpdir = match self.processes.folder(self.tmpdir.as_deref()) {
            Ok(tmpdir) => tmpdir,
            Err(error) => {
                let message = format!("cannot create a temporary directory: {error}");
                console.err(&format!("{}: {message}", self.name()));
                return TemplateResult { status: 2, sink, error: Some(message), place: None };
            }
        };
        let disk = Arc::clone(&self.disk);
        let mut output = Output::new(self.name(), self.base.clone(), self.debug, disk, sink);
        output.confined = self.confined.cloned();
        output.rights = output::Rights::Tcl(self.allowed.clone());
        let mut tmpdir = tmpdir;
        if self.debug {
            tmpdir.keep();
        }
        session::run(self, compiler, console, output, tmpdir.path().to_owned())
    }
}
