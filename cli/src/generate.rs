//! `dotgen generate`, and `genom3` if dotgen replaces it.
//!
//! All arguments after the template's name belong to the template, so the generator parses the arguments, not
//! clap.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use camino::Utf8PathBuf;
use clap::Args;
use dotgen_codegen::command::{Environment, MakeRos2Packages, Project, generate};
use dotgen_codegen::template::console::StdConsole;
use dotgen_codegen::template::{Limits, OutputSink};

use dotgen_lsp_server::config::{self, Config, Settings};
use dotgen_platform::files::disk::SystemDisk;
use dotgen_platform::files::read_regular_to_string;
use dotgen_platform::files::vfs::PackageConfig;
use dotgen_platform::files::vfs::Vfs;
use dotgen_ros2::interfaces::packages;

use super::session::{ConfigProblems, told_rules};

/// Run a template over specifications, with the arguments of `genom3`
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub(super) struct Arguments {
    /// General options, the template, its options, and the files; see `dotgen generate -h`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<String>,
}

/// Runs the generator if the command line contains the subcommand.
pub(super) fn intercept() -> Option<ExitCode> {
    let mut arguments = std::env::args_os().map(|argument| argument.to_string_lossy().into_owned());
    let program = arguments.next().unwrap_or_default();
    let program = Path::new(&program).file_stem()?.to_string_lossy().into_owned();
    let arguments: Vec<String> = arguments.collect();
    if program == "genom3" {
        return Some(run_as_genom3(&arguments));
    }
    match arguments.split_first() {
        Some((command, arguments)) if command == "generate" => Some(in_project(arguments)),
        Some((command, arguments)) if command == "genom3" => Some(run_as_genom3(arguments)),
        _ => None,
    }
}

/// Reached only through an abbreviation that [`intercept`] does not know.
pub(super) fn run_parsed(arguments: &Arguments) -> ExitCode {
    in_project(&arguments.arguments)
}

/// Runs as `genom3`: without configuration, with the options of `genom3` only.
fn run_as_genom3(arguments: &[String]) -> ExitCode {
    let packages = PackageConfig { may_run: true, ..PackageConfig::default() };
    run("genom3", arguments, packages, &ConfigFile::default())
}

/// Runs with the `dotgen.toml` of the files.
fn in_project(arguments: &[String]) -> ExitCode {
    let mut file = ConfigFile::default();
    let arguments = Project::complete(arguments, |rest| {
        file = configuration(rest);
        let config = &file.config;
        let text = |path: &Utf8PathBuf| path.to_string();
        Project {
            include_paths: config.include_paths.iter().map(text).collect(),
            defines: config.defines.clone(),
        }
    });
    let packages = PackageConfig { may_run: true, ..file.config.packages.clone() };
    run("dotgen generate", &arguments, packages, &file)
}

/// A configuration with the file that it is from.
#[derive(Default)]
struct ConfigFile {
    config: Config,
    source: Option<ConfigProblems>,
}

impl ConfigFile {
    /// Returns the maker of ROS 2 packages. It needs a configuration without errors.
    fn ros2(&self) -> Arc<MakeRos2Packages> {
        let (rules, source) = (self.config.ros2.rules(), self.source.clone());
        Arc::new(move |spec| {
            source.iter().try_for_each(ConfigProblems::first_error)?;
            packages(spec, &rules).map_err(|errors| told_rules(source.as_ref(), &errors))
        })
    }
}

/// Returns the nearest configuration around the last argument that is a file, or around the current
/// directory. `dotgen check` reports errors in the configuration.
fn configuration(words: &[String]) -> ConfigFile {
    let Ok(here) = camino::absolute_utf8(".") else {
        return ConfigFile::default();
    };
    let mut files = words.iter().rev().map(|word| here.join(word));
    let file = files.find(|file| file.is_file());
    let file = dotgen_platform::files::vfs::normalize(&file.unwrap_or_else(|| here.join("-")));
    let Some(directory) = config::nearest_directory(&file) else {
        let config = Config::new(&Settings::default(), &here, true);
        return ConfigFile { config, source: None };
    };
    let path = directory.join(config::FILE_NAME);
    let text = read_regular_to_string(path.as_std_path()).unwrap_or_default();
    let read = config::from_toml(&text);
    let settings = read.settings.resolved_against(&directory);
    ConfigFile {
        config: Config::new(&settings, &directory, true),
        source: Some(ConfigProblems { path, text: text.into(), problems: read.problems }),
    }
}

fn run(name: &str, arguments: &[String], packages: PackageConfig, file: &ConfigFile) -> ExitCode {
    let templates: Vec<&str> =
        file.config.template_paths.iter().map(|path| path.as_str()).collect();
    let mut environment = Environment {
        name,
        program: std::env::current_exe().unwrap_or_else(|_| name.into()),
        variables: &|name| std::env::var(name).ok(),
        disk: Arc::new(SystemDisk),
        loader: Arc::new(Vfs::new(packages)),
        pictures: Arc::new(dotgen_views::pictures::machine),
        ros2: file.ros2(),
        console: &mut StdConsole::default(),
        limits: Limits::default(),
        base: PathBuf::new(),
        sink: OutputSink::DIRECT,
        processes: dotgen_platform::process::system(),
        // The generator parses `--confined`, among its other options.
        confined: None,
        project_templates: (!templates.is_empty()).then(|| templates.join(":")),
        failed_at: None,
        release: file.config.release.clone(),
    };
    let status = generate(arguments, &mut environment);
    ExitCode::from(u8::try_from(status & 0xff).unwrap_or(2))
}
