//! What the command line of the generator needs of its surroundings, and what it finds there.

use std::path::PathBuf;
use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_analysis::host::{Loader, required_release};
use dotgen_analysis::model::Spec;
use dotgen_analysis::release::{ReleaseChoice, ReleaseOrigin};

use crate::compiler::Compiler;
use crate::disk::Disk;
use crate::options::Options;
use crate::process::Processes;
use crate::template::console::Console;
use crate::template::discover::{SearchPath, release_of};
use crate::template::{Confined, Limits, OutputSink, TemplatePlace};

/// Environment variable that says the release of GenoM3 to stand in for.
const RELEASE_VARIABLE: &str = "DOTGEN_GENOM_RELEASE";

/// What the command line needs of its surroundings.
pub struct Environment<'a> {
    /// Name for messages: `genom3`, or `dotgen generate`.
    pub name: &'a str,
    /// Absolute path of the program, as templates see it.
    pub program: PathBuf,
    /// Environment variables.
    pub variables: &'a dyn Fn(&str) -> Option<String>,
    /// All access to files but those of specifications.
    pub disk: Arc<dyn Disk>,
    /// Reads specifications and asks about packages.
    pub loader: Arc<dyn Loader>,
    /// What built-in templates and those of users have drawn.
    pub pictures: Arc<Pictures>,
    /// The standard channels.
    pub console: &'a mut dyn Console,
    /// What a template may use up.
    pub limits: Limits,
    /// Directory where relative paths start; empty for the current one.
    pub base: PathBuf,
    /// Where files go. Afterwards it has what was kept of them.
    pub sink: OutputSink,
    /// The release of GenoM3 that a project's settings say.
    pub release: Option<ReleaseChoice>,
    /// Starts interpreters and tools.
    pub processes: Arc<dyn Processes>,
    /// Keeps templates from what is not their business; `None` lets them do what their user can.
    pub confined: Option<Confined>,
    /// Where the template failed, if it did and that is known.
    pub failed_at: Option<TemplatePlace>,
}

/// Draws the state machine of a task or activity of a component, both by name, in a form: `svg`, `mermaid` or
/// `dot`. Empty when there is none. Pictures belong to another layer than templates, so the caller brings
/// them.
///
/// # Errors
/// When there is no such form, in words.
pub type Pictures = dyn Fn(&Spec, &str, &str, &str) -> Result<String, String> + Send + Sync;

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

    /// Where templates are looked for.
    pub(crate) fn search_path(&self, options: &Options) -> SearchPath {
        search_path(options.templates.as_deref(), self.variables)
    }

    /// The current directory.
    pub(crate) fn here(&self) -> Utf8PathBuf {
        Utf8PathBuf::from_path_buf(self.disk.current_dir()).unwrap_or_default()
    }

    /// The release of GenoM3 to stand in for: what the command line says, the environment, the project; that
    /// of the templates in use, the installed one; what the inputs require; or the newest that was verified.
    pub(crate) fn release(&self, options: &Options) -> Result<ReleaseChoice, String> {
        if let Some(release) = options.release {
            let origin = ReleaseOrigin::CommandLine;
            return Ok(ReleaseChoice { release, origin });
        }
        if let Some(text) = self.variable(RELEASE_VARIABLE) {
            let release = text
                .parse()
                .map_err(|error| format!("{RELEASE_VARIABLE}: {error}"))?;
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
        let base = self.base.to_str().map_or(here.clone(), |it| here.join(it));
        let base = base.join(&options.directory);
        let files = options.rest.iter().map(|it| base.join(it));
        Ok(ReleaseChoice::required(required_release(
            &*self.loader,
            files,
        )))
    }

    pub(crate) fn compiler(&self, options: &Options, release: ReleaseChoice) -> Compiler {
        let here = self.here();
        let include_dirs = options.include_dirs.iter();
        let defines = options.defines.iter();
        let mut compiler = Compiler::new(
            Arc::clone(&self.disk),
            Arc::clone(&self.loader),
            include_dirs
                .map(|dir| here.join(Utf8PathBuf::from(dir)))
                .collect(),
            defines
                .map(|(name, value)| (name.as_str().into(), value.as_str().into()))
                .collect(),
            release,
        );
        let base = self.base.join(&options.directory);
        compiler.set_base(Utf8PathBuf::from_path_buf(base).unwrap_or_default());
        compiler.set_program(self.name);
        compiler
    }
}

/// Where templates are looked for: the list given (`-t`), else that of `GENOM_TMPL_PATH`; and the
/// folder of `DOTGEN_BUILTIN_TEMPLATES`.
pub fn search_path(given: Option<&str>, variables: &dyn Fn(&str) -> Option<String>) -> SearchPath {
    let variable = |name: &str| variables(name).filter(|it| !it.is_empty());
    let given = given.map(str::to_owned);
    let given = given.or_else(|| variable("GENOM_TMPL_PATH"));
    SearchPath {
        dirs: given.map(|it| SearchPath::parse(&it)).unwrap_or_default(),
        builtin: variable("DOTGEN_BUILTIN_TEMPLATES").map(PathBuf::from),
    }
}
