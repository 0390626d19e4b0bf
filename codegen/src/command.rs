//! The command line of the generator: `dotgen generate`, and `genom3` in place of GenoM3's own.

mod preprocess;
mod project;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_analysis::release::{Release, ReleaseChoice};
use dotgen_syntax::encoding;

pub use crate::environment::{Environment, MakeRos2Packages, Pictures, Ros2Packages, search_path};

use crate::disk::NewContent;
use crate::options::{self, Mode, OptionError, Options};
use crate::template::discover::FindError;
use crate::template::{Confinement, Confirmation, Limits, OutputSink, Run};
pub use project::Project;

/// Runs the generator with command line arguments (without the program's name). Returns the exit status: 0
/// for success; 1 for wrong options; 2 for inputs that are missing, operations that fail, and a failing
/// template; the status of a template's `exit`; with parsing only, the number of errors.
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
        Mode::Template
            if env.confined.is_none() && (options.confined || is_of_project(&options, env)) =>
        {
            confined(&options, release, env)
        }
        Mode::Template => template(&options, release, env),
        Mode::Parse | Mode::Dump => parse_only(&options, release, env),
        Mode::Preprocess => preprocess_only(&options, release.release, env),
    }
}

fn list(options: &Options, env: &mut Environment<'_>) -> i32 {
    if !options.rest.is_empty() {
        env.warn("wrong number of arguments");
        return 2;
    }
    let search = env.search_path(options);
    let mut names = search.list(&*env.disk);
    // An installation of GenoM3 has its own folder.
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

/// Returns true if the template is found only through the settings of a folder.
fn is_of_project(options: &Options, env: &Environment<'_>) -> bool {
    let Some(name) = options.rest.first() else {
        return false;
    };
    env.has_project_templates(options)
        && !Path::new(name).is_absolute()
        && !crate::builtin::names().contains(&name.as_str())
}

/// Runs a template as a preview does, and writes its results if the template succeeds.
fn confined(options: &Options, release: ReleaseChoice, env: &mut Environment<'_>) -> i32 {
    let here = if env.base.as_os_str().is_empty() { Path::new(".") } else { &env.base };
    let allowed = env.allowed(options);
    env.confined = Some(Confinement {
        results: vec![env.disk.absolute(here)],
        confirmed: Confirmation::Only(allowed),
        reviewed: false,
    });
    env.limits = Limits { cancel: env.limits.cancel.take(), ..Limits::preview() };
    let direct = std::mem::replace(&mut env.sink, OutputSink::PREVIEW);
    let status = template(options, release, env);
    let kept = OutputSink { preview: false, ..std::mem::replace(&mut env.sink, direct) };
    if status != 0 {
        return status;
    }
    match kept.finish(&*env.disk, false).1 {
        Ok(()) => 0,
        Err(error) => {
            env.warn(&error.to_string());
            2
        }
    }
}

/// A folder with the files that templates expect in the built-in one. It is kept between runs, because build
/// files depend on its files.
fn support_dir(env: &Environment<'_>) -> Option<PathBuf> {
    let home = || env.variable("HOME").map(|home| PathBuf::from(home).join(".cache"));
    let cache = env.variable("XDG_CACHE_HOME").map(PathBuf::from);
    let dir =
        cache.or_else(home)?.join("dotgen").join(concat!("templates-", env!("CARGO_PKG_VERSION")));
    let all = crate::builtin::SUPPORT
        .iter()
        .map(|(name, text)| NewContent::new(dir.join(name), text.as_bytes().to_vec()));
    let there = |content: &NewContent| {
        env.disk.read(&content.path).is_ok_and(|there| there == content.bytes)
    };
    let missing: Vec<NewContent> = all.filter(|content| !there(content)).collect();
    env.disk.write(&missing).ok()?;
    Some(dir)
}

fn template(options: &Options, release: ReleaseChoice, env: &mut Environment<'_>) -> i32 {
    let search = env.search_path(options);
    let Some((name, arguments)) = options.rest.split_first() else { return 1 };
    if env.has_project_templates(options) && crate::builtin::names().contains(&name.as_str()) {
        let mut compiler = env.compiler(options, release);
        let status = crate::builtin::run(name, arguments, options, &mut compiler, env);
        return status.unwrap_or(2);
    }
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
    let mut compiler = env.compiler(options, release);
    let mut search = search;
    if search.builtin.is_none() {
        search.builtin = support_dir(env);
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
        allowed: env.allowed(options),
    };
    let sink = std::mem::replace(&mut env.sink, OutputSink::DIRECT);
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
    for message in &preprocessor.messages {
        env.console.err(message);
    }
    i32::from(preprocessor.has_errors)
}

fn usage(name: &str) -> String {
    format!(
        "Usage:
  {name} [general options] TEMPLATE [template options] FILE.gen...
  {name} [general options] -n | -N | -E FILE.gen...
  {name} [general options] -l

General options:
  -I DIR            search DIR for included files
  -C DIR            look for FILE.gen in DIR; a further -C is relative to the
                    one before
  -D MACRO[=VALUE]  define MACRO as VALUE, or as 1
  -t DIR[:DIR...]   search these directories for templates, instead of
                    GENOM_TMPL_PATH
  -l, --list        list the templates
  -n, --parse-only  read the files and report errors
  -N, --dump        read the files and print the resulting model, as JSON
  -E                preprocess the files
      --confined    restrict TEMPLATE as in an editor preview: it starts no
                    program, has no network, reads only itself and its inputs,
                    and writes only below the current directory, except hidden
                    files and executables
      --allow PATH  let TEMPLATE write this file: in a folder such as .git, or
                    an executable; with --confined, any hidden file
  -T, --tmpdir DIR  directory for temporary files
  -v, --verbose     print each step
  -d, --debug       keep temporary files
      --release R       act as this release of GenoM3, such as 2.99.41
      --version     print the version of GenoM3 that dotgen acts as
  -h, --help        print this help

TEMPLATE -h prints the options of a template."
    )
}
