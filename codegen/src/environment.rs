//! The environment of the generator's command line.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_analysis::host::{Loader, required_release};
use dotgen_analysis::model::{Spec, Src};
use dotgen_analysis::release::{ReleaseChoice, ReleaseOrigin};

use crate::compiler::Compiler;
use crate::disk::Disk;
use crate::options::Options;
use crate::process::Processes;
use crate::template::console::Console;
use crate::template::discover::{SearchPath, release_of};
use crate::template::{Confinement, Limits, OutputSink, TemplatePlace, readable_files};

/// Environment variable that sets the release of GenoM3 to emulate.
const RELEASE_VARIABLE: &str = "DOTGEN_GENOM_RELEASE";

/// The environment of the command line.
pub struct Environment<'a> {
    /// Name of the program in messages: `genom3`, or `dotgen generate`.
    pub name: &'a str,
    /// Absolute path of the program, for templates.
    pub program: PathBuf,
    /// Environment variables.
    pub variables: &'a dyn Fn(&str) -> Option<String>,
    /// All access to files except specifications.
    pub disk: Arc<dyn Disk>,
    /// Reads specifications and queries packages.
    pub loader: Arc<dyn Loader>,
    /// Draws pictures for templates.
    pub pictures: Arc<Pictures>,
    /// Makes ROS 2 packages.
    pub ros2: Arc<MakeRos2Packages>,
    /// The standard channels.
    pub console: &'a mut dyn Console,
    /// The limits on the resources of a template.
    pub limits: Limits,
    /// Start of relative paths; empty for the current directory.
    pub base: PathBuf,
    /// The destination of result files. After the run it contains those that were kept.
    pub sink: OutputSink,
    /// The release of GenoM3 in a project's settings.
    pub release: Option<ReleaseChoice>,
    /// Starts interpreters and tools.
    pub processes: Arc<dyn Processes>,
    /// The confinement of templates. `None` gives them the rights of the user.
    pub confined: Option<Confinement>,
    /// Directories searched for templates if the command line names none, in the form of `-t`, from the
    /// settings of a folder. The folder may be of another author: its templates do not replace those of
    /// dotgen, and run confined.
    pub project_templates: Option<String>,
    /// The place at which the template failed, if it failed and the place is known.
    pub failed_at: Option<TemplatePlace>,
}

/// Draws the state machine of a task or activity of a component, both by name, in a form: `svg`, `mermaid` or
/// `dot`. Empty if there is no such state machine. The caller provides it, because pictures belong to another
/// layer than templates.
///
/// # Errors
/// A message, if the form does not exist.
pub type Pictures = dyn Fn(&Spec, &str, &str, &str) -> Result<String, String> + Send + Sync;

/// ROS 2 packages with the types of components.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Ros2Packages {
    /// The files, by path below the folder of the packages.
    pub files: BTreeMap<String, String>,
    /// Parts of the model without a form in ROS 2: their places, and messages with the reasons.
    pub refused: Vec<(Src, String)>,
}

/// Makes the ROS 2 packages of all components of a specification. The caller provides it, as the mapping
/// belongs to another layer than templates.
///
/// # Errors
/// A message: the settings for ROS 2 are wrong.
pub type MakeRos2Packages = dyn Fn(&Spec) -> Result<Ros2Packages, String> + Send + Sync;

impl Environment<'_> {
    pub(crate) fn print(&mut self, text: &str) {
        self.console.out(format!("{text}\n").as_bytes());
    }

    pub(crate) fn warn(&mut self, message: &str) {
        self.console.err(&format!("{}: {message}", self.name));
    }

    pub(crate) fn variable(&self, name: &str) -> Option<String> {
        (self.variables)(name).filter(|value| !value.is_empty())
    }

    /// The search path of templates.
    pub(crate) fn search_path(&self, options: &Options) -> SearchPath {
        let given = options.templates.as_deref().or(self.project_templates.as_deref());
        search_path(given, self.variables)
    }

    /// Returns true if templates are searched in directories that settings of a folder name.
    pub(crate) fn has_project_templates(&self, options: &Options) -> bool {
        options.templates.is_none() && self.project_templates.is_some()
    }

    /// The files that the user allows a template to write, absolute.
    pub(crate) fn allowed(&self, options: &Options) -> Vec<PathBuf> {
        let here = if self.base.as_os_str().is_empty() { Path::new(".") } else { &self.base };
        let allowed = options.allowed.iter();
        allowed.map(|path| readable_files::plain(&*self.disk, &here.join(path))).collect()
    }

    /// The current directory.
    pub(crate) fn here(&self) -> Utf8PathBuf {
        Utf8PathBuf::from_path_buf(self.disk.current_dir()).unwrap_or_default()
    }

    /// The release of GenoM3 to emulate, from the first of: the command line, the environment, the project,
    /// the templates in use, the installed GenoM3, the requirements of the inputs, the newest verified
    /// release.
    pub(crate) fn release(&self, options: &Options) -> Result<ReleaseChoice, String> {
        if let Some(release) = options.release {
            let origin = ReleaseOrigin::CommandLine;
            return Ok(ReleaseChoice { release, origin });
        }
        if let Some(text) = self.variable(RELEASE_VARIABLE) {
            let release = text.parse().map_err(|error| format!("{RELEASE_VARIABLE}: {error}"))?;
            let origin = ReleaseOrigin::Environment;
            return Ok(ReleaseChoice { release, origin });
        }
        if let Some(release) = &self.release {
            return Ok(release.clone());
        }
        let search = self.search_path(options);
        let dirs: Vec<PathBuf> = search.dirs.into_iter().chain(search.builtin).collect();
        if let Some((release, file)) = release_of(&*self.disk, &dirs) {
            let file = Utf8PathBuf::from_path_buf(file).unwrap_or_default();
            let origin = ReleaseOrigin::Templates(file);
            return Ok(ReleaseChoice { release, origin });
        }
        if let Some(release) = self.loader.installed_release() {
            return Ok(release);
        }
        let here = self.here();
        let base = self.base.to_str().map_or(here.clone(), |text| here.join(text));
        let base = base.join(&options.directory);
        let files = options.rest.iter().map(|rest| base.join(rest));
        Ok(ReleaseChoice::required(required_release(&*self.loader, files)))
    }

    pub(crate) fn compiler(&self, options: &Options, release: ReleaseChoice) -> Compiler {
        let here = self.here();
        let include_dirs = options.include_dirs.iter();
        let defines = options.defines.iter();
        let mut compiler = Compiler::new(
            Arc::clone(&self.disk),
            Arc::clone(&self.loader),
            include_dirs.map(|dir| here.join(Utf8PathBuf::from(dir))).collect(),
            defines.map(|(name, value)| (name.as_str().into(), value.as_str().into())).collect(),
            release,
        );
        let base = self.base.join(&options.directory);
        compiler.set_base(Utf8PathBuf::from_path_buf(base).unwrap_or_default());
        compiler.set_program(self.name);
        compiler
    }
}

/// The search path of templates: the given list (`-t`), else `GENOM_TMPL_PATH`; and the folder in
/// `DOTGEN_BUILTIN_TEMPLATES`.
pub fn search_path(given: Option<&str>, variables: &dyn Fn(&str) -> Option<String>) -> SearchPath {
    let variable = |name: &str| variables(name).filter(|variable| !variable.is_empty());
    let given = given.map(str::to_owned);
    let given = given.or_else(|| variable("GENOM_TMPL_PATH"));
    SearchPath {
        dirs: given.map(|text| SearchPath::parse(&text)).unwrap_or_default(),
        builtin: variable("DOTGEN_BUILTIN_TEMPLATES").map(PathBuf::from),
    }
}
