//! The command line of the generator: `dotgen generate`, and `genom3` where it stands in for it.

mod options;
mod preprocess;
mod project;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_analysis::host::Loader;
use dotgen_analysis::host::required_release;
use dotgen_analysis::model::Spec;
use dotgen_analysis::release::{Release, ReleaseChoice, ReleaseOrigin};
use dotgen_syntax::encoding;

use crate::compiler::Compiler;
use crate::disk::{Disk, NewContent};
use crate::frontend::Frontend;
use crate::process::Processes;
use crate::template::console::Console;
use crate::template::discover::release_of;
use crate::template::discover::{FindError, SearchPath};
use crate::template::{Confined, Limits, OutputSink, Run, TemplatePlace};
pub(crate) use options::Options;
use options::{Mode, OptionError};
pub use project::Project;

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

/// Runs the generator with command line arguments (without the program's name); returns the exit
/// status: 0; 1 for wrong options; 2 for what cannot be found or done, and for a failing template;
/// that of a template's `exit`; and the number of errors when only parsing.
pub fn generate(args: &[String], env: &mut Environment<'_>) -> i32 {
    let options = match options::parse(args, &env.disk.current_dir()) {
        Ok(options) => options,
        Err(OptionError::Usage(message)) => {
            env.warn(&message);
            env.console.err(&usage(env.name));
            return 1;
        }
        Err(OptionError::Fatal(message)) => {
            env.warn(&message);
            return 2;
        }
    };
    let release = match env.release(&options) {
        Ok(release) => release,
        Err(message) => {
            env.warn(&message);
            return 2;
        }
    };
    match options.mode {
        Mode::Version => {
            env.print(&release.release.to_string());
            0
        }
        Mode::Help => {
            env.print(&usage(env.name));
            0
        }
        Mode::List => list(&options, env),
        _ if options.rest.is_empty() => {
            env.console.err(&usage(env.name));
            1
        }
        Mode::Template if options.confined && env.confined.is_none() => {
            confined(&options, release, env)
        }
        Mode::Template => template(&options, release, env),
        Mode::Parse | Mode::Dump => parse_only(&options, release, env),
        Mode::Preprocess => preprocess_only(&options, release.release, env),
    }
}

impl Environment<'_> {
    fn print(&mut self, text: &str) {
        self.console.out(format!("{text}\n").as_bytes());
    }

    fn warn(&mut self, message: &str) {
        self.console.err(&format!("{}: {message}", self.name));
    }

    fn variable(&self, name: &str) -> Option<String> {
        (self.variables)(name).filter(|value| !value.is_empty())
    }

    /// Where templates are looked for.
    fn search_path(&self, options: &Options) -> SearchPath {
        search_path(options.templates.as_deref(), self.variables)
    }

    /// A folder with the files that templates expect in the built-in one. Kept between runs, since
    /// build files come to depend on them.
    fn support_dir(&self) -> Option<PathBuf> {
        let home = || {
            self.variable("HOME")
                .map(|home| PathBuf::from(home).join(".cache"))
        };
        let cache = self.variable("XDG_CACHE_HOME").map(PathBuf::from);
        let dir = cache
            .or_else(home)?
            .join("dotgen")
            .join(concat!("templates-", env!("CARGO_PKG_VERSION")));
        let all = crate::builtin::SUPPORT
            .iter()
            .map(|(name, text)| NewContent {
                path: dir.join(name),
                bytes: text.as_bytes().to_vec(),
                mode: None,
            });
        let there = |it: &NewContent| {
            self.disk
                .read(&it.path)
                .is_ok_and(|there| there == it.bytes)
        };
        let missing: Vec<NewContent> = all.filter(|it| !there(it)).collect();
        self.disk.write(&missing).ok()?;
        Some(dir)
    }

    /// The current directory.
    fn here(&self) -> Utf8PathBuf {
        Utf8PathBuf::from_path_buf(self.disk.current_dir()).unwrap_or_default()
    }

    /// The release of GenoM3 to stand in for: what the command line says, the environment, the project; that
    /// of the templates in use, the installed one; what the inputs require; or the newest that was verified.
    fn release(&self, options: &Options) -> Result<ReleaseChoice, String> {
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

    fn compiler(&self, options: &Options, release: ReleaseChoice) -> Compiler {
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

fn list(options: &Options, env: &mut Environment<'_>) -> i32 {
    if !options.rest.is_empty() {
        env.warn("wrong number of arguments");
        return 2;
    }
    let search = env.search_path(options);
    let mut names = search.list(&*env.disk);
    // An installation of GenoM3 brings its own.
    if search.builtin.is_none() {
        names.extend(crate::builtin::names().into_iter().map(str::to_owned));
        names.sort();
        names.dedup();
    }
    if names.is_empty() {
        env.warn("no template found!");
        return 2;
    }
    for name in names {
        env.print(&name);
    }
    0
}

/// Runs a template as a preview does, and writes what comes of it if the template succeeds.
fn confined(options: &Options, release: ReleaseChoice, env: &mut Environment<'_>) -> i32 {
    let here = if env.base.as_os_str().is_empty() {
        Path::new(".")
    } else {
        &env.base
    };
    let results = vec![env.disk.absolute(here)];
    env.confined = Some(Confined { results });
    env.limits = Limits {
        cancel: env.limits.cancel.take(),
        ..Limits::preview()
    };
    let direct = std::mem::replace(&mut env.sink, OutputSink::preview());
    let status = template(options, release, env);
    let kept = std::mem::replace(&mut env.sink, direct);
    if status != 0 {
        return status;
    }
    match kept.write_out(&*env.disk) {
        Ok(()) => 0,
        Err(error) => {
            env.warn(&error.to_string());
            2
        }
    }
}

fn template(options: &Options, release: ReleaseChoice, env: &mut Environment<'_>) -> i32 {
    let search = env.search_path(options);
    let (name, arguments) = match options.rest.split_first() {
        Some((name, arguments)) => (name, arguments),
        None => return 1,
    };
    if let Some(dir) = search.find_manifest(&*env.disk, name) {
        let mut compiler = env.compiler(options, release);
        return crate::builtin::run_folder(&dir, arguments, options, &mut compiler, env);
    }
    let dir = match search.find(&*env.disk, name) {
        Ok(dir) => dir,
        Err(FindError::NotFound(_)) if crate::builtin::names().contains(&name.as_str()) => {
            let mut compiler = env.compiler(options, release);
            let status = crate::builtin::run(name, arguments, options, &mut compiler, env);
            return status.unwrap_or(2);
        }
        Err(error) => {
            env.warn(&error.to_string());
            if let FindError::NotFound(_) = error
                && search.dirs.is_empty()
            {
                env.warn("name the directory of your templates with -t or GENOM_TMPL_PATH");
            }
            return 2;
        }
    };
    if !options.verbose
        && !options.debug
        && let Some(status) = crate::builtin::run_known(
            &dir,
            arguments,
            release.release,
            options,
            env.compiler(options, release.clone()),
            env,
        )
    {
        return status;
    }
    let mut compiler = env.compiler(options, release);
    let mut search = search;
    if search.builtin.is_none() {
        search.builtin = env.support_dir();
    }
    let run = Run {
        disk: Arc::clone(&env.disk),
        dir,
        args: arguments.to_vec(),
        search: &search,
        program: env.program.display().to_string(),
        cmdline: options.cmdline.clone(),
        verbose: options.verbose,
        debug: options.debug,
        tmpdir: options.tmpdir.clone().map(PathBuf::from),
        limits: env.limits.clone(),
        base: env.base.clone(),
        input_path: options.directory.clone(),
        processes: Arc::clone(&env.processes),
        confined: env.confined.as_ref(),
    };
    let sink = std::mem::replace(&mut env.sink, OutputSink::Direct);
    let outcome = run.execute(&mut compiler, env.console, sink);
    env.sink = outcome.sink;
    env.failed_at = outcome.place;
    outcome.status
}

fn parse_only(options: &Options, release: ReleaseChoice, env: &mut Environment<'_>) -> i32 {
    let mut compiler = env.compiler(options, release);
    let console = &mut *env.console;
    let result = compiler.parse_files(&options.rest, &mut |line| console.err(line));
    if options.mode == Mode::Dump {
        let model = dotgen_analysis::model_json::to_json(&compiler.compiled().spec, None);
        env.print(&encoding::shown(&format!("{model:#}")));
    }
    match result {
        Ok(()) => 0,
        Err(failure) => {
            env.warn(&failure.to_string());
            match failure {
                crate::frontend::ParseFailure::Errors(count) => {
                    i32::try_from(count).unwrap_or(125).min(125)
                }
                crate::frontend::ParseFailure::Fatal => 1,
                crate::frontend::ParseFailure::Unreadable(_) => 2,
            }
        }
    }
}

fn preprocess_only(options: &Options, release: Release, env: &mut Environment<'_>) -> i32 {
    let here = env.here();
    let dirs = options.include_dirs.iter().map(|dir| here.join(dir));
    let mut preprocessor =
        preprocess::Preprocessor::new(Arc::clone(&env.loader), dirs.collect(), release);
    for (name, value) in &options.defines {
        if let Err(problem) = preprocessor.env.define_option(&format!("{name}={value}")) {
            env.warn(&problem);
            return 2;
        }
    }
    let mut failed = false;
    for input in &options.rest {
        let path = Utf8PathBuf::from(&options.directory).join(input);
        match preprocessor.file(&path) {
            Ok(text) => env.console.out(&encoding::encode(&text)),
            Err(problem) => {
                env.warn(&format!("{input}: {problem}"));
                return 2;
            }
        }
    }
    for error in std::mem::take(&mut preprocessor.errors) {
        failed |= error.contains(": error: ");
        env.console.err(&error);
    }
    i32::from(failed)
}

fn usage(name: &str) -> String {
    format!(
        "Usage:
  {name} [general options] TEMPLATE [template options] FILE.gen...
  {name} [general options] -n | -N | -E FILE.gen...
  {name} [general options] -l

General options:
  -I DIR            search DIR for included files
  -C DIR            look for FILE.gen in DIR; given again, in DIR below the one before
  -D MACRO[=VALUE]  define MACRO as VALUE, or as 1
  -t DIR[:DIR...]   search these directories for templates, instead of GENOM_TMPL_PATH
  -l, --list        list the templates
  -n, --parse-only  read the files and report what is wrong
  -N, --dump        read the files and print the resulting model, as JSON
  -E                preprocess the files
      --confined    as a preview in an editor: TEMPLATE starts no program, has no network, reads
                    itself and its inputs, and writes below the current directory
  -T, --tmpdir DIR  directory for temporary files
  -v, --verbose     say what is done
  -d, --debug       keep temporary files
      --release R       stand in for this release of GenoM3, such as 2.99.41
      --version     print the version of GenoM3 this stands for
  -h, --help        print this help

TEMPLATE -h tells the options of a template."
    )
}
