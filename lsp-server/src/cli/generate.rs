//! `dotgen generate`, and `genom3` where it stands in for it.
//!
//! Everything after the template's name belongs to the template, so these arguments are read by the
//! generator itself, not here.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use clap::Args;
use dotgen_codegen::command::{Environment, generate};
use dotgen_codegen::template::console::StdConsole;
use dotgen_codegen::template::{Limits, OutputSink};

use crate::config::PackageConfig;
use crate::vfs::Vfs;

/// Run a template over specifications; takes the arguments of `genom3`
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub(super) struct Arguments {
    /// General options, the template, its options, and the files; `-h` tells more
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<String>,
}

/// Runs the generator when the command line is for it.
pub(super) fn intercept() -> Option<ExitCode> {
    let mut arguments = std::env::args_os().map(|it| it.to_string_lossy().into_owned());
    let program = arguments.next().unwrap_or_default();
    let program = Path::new(&program)
        .file_stem()?
        .to_string_lossy()
        .into_owned();
    let arguments: Vec<String> = arguments.collect();
    if program == "genom3" {
        return Some(run("genom3", &arguments));
    }
    match arguments.split_first() {
        Some((command, arguments)) if command == "generate" => {
            Some(run("dotgen generate", arguments))
        }
        Some((command, arguments)) if command == "genom3" => Some(run("genom3", arguments)),
        _ => None,
    }
}

/// Only reached by way of an abbreviation that [`intercept`] does not know.
pub(super) fn run_parsed(arguments: &Arguments) -> ExitCode {
    run("dotgen generate", &arguments.arguments)
}

fn run(name: &str, arguments: &[String]) -> ExitCode {
    let mut environment = Environment {
        name,
        program: std::env::current_exe().unwrap_or_else(|_| name.into()),
        variables: &|name| std::env::var(name).ok(),
        loader: Arc::new(Vfs::new(PackageConfig {
            may_run: true,
            ..PackageConfig::default()
        })),
        pictures: Arc::new(crate::pictures::machine),
        console: &mut StdConsole,
        limits: Limits::default(),
        base: PathBuf::new(),
        sink: OutputSink::Direct,
        failed_at: None,
    };
    let status = generate(arguments, &mut environment);
    ExitCode::from(u8::try_from(status & 0xff).unwrap_or(2))
}
