//! `dotgen wcet`: execution times from recorded runs.

mod import;
pub(super) mod stats;

use std::fs::File;
use std::io::Read;

use camino::{Utf8Path, Utf8PathBuf};
use clap::{Args, Subcommand};
use dotgen_analysis::language;
use dotgen_recording::log::{Lines, TruncationCheck};

use super::CommandExit;
use super::report;
use super::session::is_standard_input;

/// Bytes of one read.
pub(super) const CHUNK_BYTES: usize = 1 << 18;

/// Import and summarise measured execution times
///
/// Servers generated with profiling write logs of GenoM3's profiler, and so does `dotgen run --profile`.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Import(import::Arguments),
    Stats(stats::Arguments),
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    match &arguments.command {
        Command::Import(arguments) => import::run(arguments),
        Command::Stats(arguments) => stats::run(arguments),
    }
}

/// Reads a log piece by piece. The function gets each line with its number, and true if the line ends with a
/// line break. A note tells where a truncated log ends.
pub(super) fn read_log(
    path: &Utf8Path,
    mut each: impl FnMut(u64, &[u8], bool),
) -> anyhow::Result<()> {
    let mut source: Box<dyn Read> = if is_standard_input(path) {
        Box::new(std::io::stdin().lock())
    } else {
        Box::new(open(path)?)
    };
    let mut piece = vec![0; CHUNK_BYTES];
    let mut lines = Lines::default();
    let mut breaks = TruncationCheck::default();
    let mut each = |number, line: &[u8], ended| {
        breaks.line(number, line, ended);
        each(number, line, ended);
    };
    loop {
        let length = match source.read(&mut piece) {
            Ok(0) => break,
            Ok(length) => length,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(unreadable(path, &error)),
        };
        let read = piece.get(..length).unwrap_or_default();
        lines.feed(read, |number, line| each(number, line, true));
    }
    if let Some((number, line)) = lines.unterminated_line() {
        each(number, line, false);
    }
    if let Some(last) = breaks.after() {
        report::note(&format!(
            "`{path}` breaks off after line {last}: its run was killed, found no room, or goes on"
        ));
    }
    Ok(())
}

/// Opens a log.
///
/// # Errors
/// The message of all commands for files that cannot be read.
pub(super) fn open(path: &Utf8Path) -> anyhow::Result<File> {
    File::open(path).map_err(|error| unreadable(path, &error))
}

/// Returns the error for a file that cannot be read.
pub(super) fn unreadable(path: &Utf8Path, error: &std::io::Error) -> anyhow::Error {
    match error.kind() {
        std::io::ErrorKind::NotFound => {
            anyhow::anyhow!("cannot read `{path}`: no such file or directory")
        }
        _ => anyhow::anyhow!("cannot read `{path}`: {error}"),
    }
}

/// Logs and other files, distinguished by their extensions.
pub(super) struct InputFiles {
    pub(super) logs: Vec<Utf8PathBuf>,
    /// Scenarios and specifications.
    pub(super) texts: Vec<Utf8PathBuf>,
}

/// Sorts the arguments.
///
/// # Errors
/// The arguments name no log.
pub(super) fn input_files(files: &[Utf8PathBuf]) -> anyhow::Result<InputFiles> {
    let is_text =
        |path: &&Utf8PathBuf| language::is_specification(path) || language::is_scenario(path);
    let texts: Vec<_> = files.iter().filter(is_text).cloned().collect();
    let logs: Vec<_> = files.iter().filter(|file| !is_text(file)).cloned().collect();
    anyhow::ensure!(
        !logs.is_empty(),
        "no log is named; give a file that a server or `dotgen run --profile` has written"
    );
    Ok(InputFiles { logs, texts })
}
