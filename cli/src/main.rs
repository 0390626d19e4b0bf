//! The program `dotgen`: one file per subcommand, over the same analysis as the server.

#![warn(clippy::print_stdout)]

#[cfg(unix)]
mod call;
mod check;
mod codels;
mod completions;
mod deps;
mod diagram;
mod explain;
mod export;
mod fmt;
mod generate;
mod help;
mod logging;
mod lsp;
mod man;
mod mcp;
mod model;
mod monitor;
mod new;
mod outputs;
#[cfg(unix)]
mod play;
mod progress;
mod query;
mod replay;
mod report;
mod run;
mod scenario;
mod session;
mod suggestion;
mod system_options;
mod trace;
mod traces;
mod tree;
mod verify;
mod wcet;
mod width;
#[cfg(unix)]
mod write;

use std::process::ExitCode;

use clap::{Args, FromArgMatches as _, Parser, Subcommand};
use dotgen_analysis::release::Release;
use dotgen_analysis::terminal;
use dotgen_syntax::encoding;
use dotgen_syntax::preproc::MacroEnv;

use dotgen_platform::process;

/// Language server and tools for GenoM3 specifications.
#[derive(Debug, Parser)]
#[command(name = "dotgen", version, max_term_width = 100)]
struct Cli {
    /// When to use colours
    #[arg(long, global = true, value_enum, default_value_t, value_name = "WHEN")]
    color: Colour,

    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    New(new::Arguments),
    Check(check::Arguments),
    Explain(explain::Arguments),
    Query(query::Arguments),
    Codels(codels::Arguments),
    Deps(deps::Arguments),
    Generate(generate::Arguments),
    Diagram(diagram::Arguments),
    Fmt(fmt::Arguments),
    Tree(tree::Arguments),
    Model(model::Arguments),
    Verify(verify::Arguments),
    Scenario(scenario::Arguments),
    Export(export::Arguments),
    Trace(traces::Arguments),
    Run(Box<run::Arguments>),
    #[cfg(unix)]
    Call(call::Call),
    #[cfg(unix)]
    Watch(call::Watch),
    #[cfg(unix)]
    Write(write::Arguments),
    #[cfg(unix)]
    Play(play::Arguments),
    Monitor(monitor::Arguments),
    Replay(replay::Arguments),
    Wcet(wcet::Arguments),
    Completions(completions::Arguments),
    Man(man::Arguments),
    Lsp(lsp::Arguments),
    Mcp(mcp::Arguments),
}

/// The use of colours in output.
#[derive(Debug, Clone, Copy, Default, clap::ValueEnum)]
enum Colour {
    /// On a terminal, unless NO_COLOR is set
    #[default]
    Auto,
    /// Also in files and pipes
    Always,
    /// Nowhere
    Never,
}

impl Colour {
    fn set(self) {
        let choice = match self {
            Colour::Auto => anstream::ColorChoice::Auto,
            Colour::Always => anstream::ColorChoice::Always,
            Colour::Never => anstream::ColorChoice::Never,
        };
        choice.write_global();
    }
}

/// The options with which specifications are read.
#[derive(Debug, Clone, Default, Args)]
struct SpecificationOptions {
    /// Search DIR for included files, before the directories of dotgen.toml
    #[arg(short = 'I', value_name = "DIR", action = clap::ArgAction::Append)]
    include_paths: Vec<String>,

    /// Define a macro; without VALUE, it expands to 1
    #[arg(short = 'D', value_name = "NAME[=VALUE]", action = clap::ArgAction::Append, value_parser = definition)]
    defines: Vec<String>,

    /// Read specifications as this release of GenoM3 does, for example 2.99.41 [default: the release in
    /// dotgen.toml, else the installed one, else the newest that the specifications require]
    #[arg(long, value_name = "RELEASE")]
    release: Option<Release>,

    /// Treats packages that are not installed as missing, even if dotgen contains their interfaces.
    #[arg(skip)]
    only_installed: bool,
}

/// Checks the definition of a macro.
fn definition(text: &str) -> Result<String, String> {
    MacroEnv::default().define_option(text)?;
    Ok(text.to_owned())
}

/// The exit status of a command.
enum CommandExit {
    /// No errors: exit status 0.
    Fine,
    /// The specification has errors, or is not formatted: 1.
    Errors,
    /// The input has errors, which were printed, and nothing could be done: 2.
    Unusable,
    /// Not finished within the limits: 3.
    GaveUp,
    /// A run did not end in order: 4.
    NotStopped,
}

/// Runs the program. Exit status 0: no errors; 1: errors in a specification; 2: wrong usage, or a file that
/// cannot be read or written.
fn main() -> ExitCode {
    if let Some(status) = process::launch::intercept() {
        return status;
    }
    #[cfg(unix)]
    if let Some(status) = dotgen_hosting::host::intercept() {
        return status;
    }
    process::is_dotgen();
    if let Some(status) = generate::intercept() {
        return status;
    }
    let parsed =
        help::command().try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = parsed.unwrap_or_else(|error| suggestion::add_suggestion(error).exit());
    cli.color.set();
    if let Err(message) = dotgen_lsp_server::config::release_of_environment() {
        failure(&anyhow::Error::msg(message));
        return ExitCode::from(2);
    }
    let result = match cli.command {
        Command::New(arguments) => new::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Explain(arguments) => explain::run(&arguments),
        Command::Query(arguments) => query::run(&arguments),
        Command::Codels(arguments) => codels::run(&arguments),
        Command::Deps(arguments) => deps::run(&arguments),
        Command::Generate(arguments) => return generate::run_parsed(&arguments),
        Command::Diagram(arguments) => diagram::run(&arguments),
        Command::Fmt(arguments) => fmt::run(&arguments),
        Command::Tree(arguments) => tree::run(&arguments),
        Command::Model(arguments) => model::run(&arguments),
        Command::Verify(arguments) => verify::run(&arguments),
        Command::Scenario(arguments) => scenario::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Trace(arguments) => traces::run(&arguments),
        Command::Run(arguments) => run::run(&arguments),
        #[cfg(unix)]
        Command::Call(arguments) => call::call(&arguments),
        #[cfg(unix)]
        Command::Watch(arguments) => call::watch(&arguments),
        #[cfg(unix)]
        Command::Write(arguments) => write::run(&arguments),
        #[cfg(unix)]
        Command::Play(arguments) => play::run(&arguments),
        Command::Monitor(arguments) => monitor::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Wcet(arguments) => wcet::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments),
        Command::Man(arguments) => man::run(&arguments),
        Command::Lsp(_) => lsp::run(),
        Command::Mcp(_) => mcp::run(),
    };
    match result {
        Ok(CommandExit::Fine) => ExitCode::SUCCESS,
        Ok(CommandExit::Errors) => ExitCode::from(1),
        Ok(CommandExit::Unusable) => ExitCode::from(2),
        Ok(CommandExit::GaveUp) => ExitCode::from(3),
        Ok(CommandExit::NotStopped) => ExitCode::from(4),
        // The reader of the output has closed it.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            failure(&error);
            ExitCode::from(2)
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<std::io::Error>()
        .is_some_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe)
}

/// Prints the reason for the failure of a command on standard error.
fn failure(error: &anyhow::Error) {
    use std::io::Write;
    let style = clap::builder::styling::AnsiColor::Red.on_default().bold();
    let error = format!("{error:#}");
    let error = terminal::text(&error);
    let error = encoding::shown(&error);
    let error = width::wrapped_for_errors(&error, "error: ".len(), 2);
    // If standard error is closed, nothing can be reported.
    let _ = writeln!(anstream::stderr(), "{style}error{style:#}: {error}");
}

#[cfg(all(test, unix))]
mod tests;
