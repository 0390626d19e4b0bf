//! `dotgen codels`: comparison and synchronization of specifications and their C and C++ codels.

pub(super) mod build;

use anyhow::{Context, bail};
use camino::{Utf8Path, Utf8PathBuf};
use clap::{Args, Subcommand};
use dotgen_analysis::codes::is_environment;
use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use dotgen_analysis::terminal;
use dotgen_codegen::codels::coverage::Coverage;
use dotgen_codegen::codels::expected::Expected;
use dotgen_codegen::codels::files::Files as _;
use dotgen_codegen::codels::{
    command::{self, FileChange, Project, StubTarget, SyncOptions},
    diagnostics::{Side, diagnostics},
    folder::Folder,
    repair::ManualChange,
    stub::StubOptions,
};
use std::io::Write as _;

use super::report::{self, Compared, FileReports, Format};
use super::session::{self, Session};
use super::{CommandExit, SpecificationOptions};
use dotgen_lsp_server::features::codels::Disk;
use dotgen_lsp_server::features::codels::headers::{FOLDER, IGNORED};
use dotgen_platform::files::vfs;

/// Check codels against their specification, write stubs, compile
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Check(Check),
    Stub(Stub),
    Sync(Sync),
    Headers(Headers),
    Build(build::Build),
}

/// Report codels whose code disagrees with the specification
///
/// Exit status: 0 if all codels agree (hints do not count), 1 if one disagrees or a specification does not
/// parse, 2 if a file cannot be read.
#[derive(Debug, Args)]
struct Check {
    /// Specifications, directories to search for .gen files, or - for standard input [default: .]
    #[arg(value_name = "PATH")]
    paths: Vec<Utf8PathBuf>,

    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,

    #[command(flatten)]
    reading: SpecificationOptions,
}

/// Write stubs for codels without a function
///
/// Stubs are added at the end of existing files, or in new ones. Nothing else changes.
#[derive(Debug, Args)]
struct Stub {
    /// Specification (.gen), or directory with one specification
    file: Utf8PathBuf,

    /// Write only the stub of this codel
    #[arg(long, value_name = "NAME", conflicts_with = "service")]
    codel: Option<String>,

    /// Write only the stubs of this task or service
    #[arg(long, value_name = "NAME")]
    service: Option<String>,

    /// Write nothing; print the changes
    #[arg(long)]
    dry_run: bool,

    #[command(flatten)]
    reading: SpecificationOptions,
}

/// Apply every unambiguous fix: stubs, prototypes, comments, missing yields and throws
#[derive(Debug, Args)]
struct Sync {
    /// Specifications, and directories to search for .gen files [default: .]
    #[arg(value_name = "PATH")]
    paths: Vec<Utf8PathBuf>,

    /// Write nothing; print the changes
    #[arg(long)]
    dry_run: bool,

    /// Remove STATE from the yields of CODEL if the code never returns it; may be repeated
    #[arg(long, value_name = "CODEL=STATE", value_parser = yield_of_codel)]
    remove_yield: Vec<(String, String)>,

    #[command(flatten)]
    reading: SpecificationOptions,
}

/// Write the headers that codels include, so that clangd works without a build
///
/// Writes mapped types, events and a compile_flags.txt to a separate folder.
#[derive(Debug, Args)]
struct Headers {
    /// Specification (.gen), or directory with one specification
    file: Utf8PathBuf,

    /// Folder to write to [default: .dotgen next to the specification]
    #[arg(short, long, value_name = "DIR")]
    output: Option<Utf8PathBuf>,

    #[command(flatten)]
    reading: SpecificationOptions,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    match &arguments.command {
        Command::Check(options) => check(options),
        Command::Stub(options) => stub(options),
        Command::Sync(options) => sync(options),
        Command::Headers(options) => headers(options),
        Command::Build(options) => build::run(options),
    }
}

pub(super) fn project(session: &mut Session) -> Project<'_> {
    let files = session.codels();
    let indexes = session.indexes.clone();
    let stubs = StubOptions { use_parameters: true, ..StubOptions::default() };
    Project::new(session.host_mut(), &Disk, files, stubs).sharing(indexes)
}

/// Output goes next to the specification, so standard input is refused.
fn check_is_file(paths: &[Utf8PathBuf]) -> anyhow::Result<()> {
    if let Some(path) = paths.iter().find(|path| session::is_standard_input(path)) {
        bail!("`{path}` is no file beside which codels could be written; name the specification");
    }
    Ok(())
}

fn roots(session: &Session) -> Vec<Utf8PathBuf> {
    session.files.iter().map(|file| file.path.clone()).collect()
}

fn check(arguments: &Check) -> anyhow::Result<CommandExit> {
    let (files, mut trouble) = session::specifications(&session::or_here(&arguments.paths));
    let mut report = FileReports::default();
    let mut errors = Vec::new();
    let mut broken = false;
    for mut session in session::open(files, &arguments.reading)? {
        let roots = roots(&session);
        let mut project = project(&mut session);
        let folders = project.folders(&roots, &mut errors);
        broken |= roots.iter().any(|root| project.has_errors_in_text(root));
        let folders = folders.into_iter().map(|folder| {
            let found = folder.check(&folder.expected());
            (folder, found)
        });
        let compared: Vec<_> = folders.collect();
        for (folder, _) in compared.iter().filter(|folder| folder.0.sources.exists) {
            report.compared.extend(coverage_of(folder));
        }
        let mut found = project.unused_allowances(&compared);
        report.checked += compared.len();
        for (folder, differs) in compared {
            if folder.sources.sources.is_empty() {
                warn_nothing_compared(&folder);
            } else if !folder.unit.accepted() {
                has_errors(&folder);
            }
            let differs = project.adjusted(&folder, differs);
            let locations = &*folder.unit.locations;
            found.extend(diagnostics(&differs, locations, Side::First));
        }
        report.add(found, |path| project.text(path));
    }
    report.finish();
    report::print(&report, arguments.format)?;
    for error in errors {
        trouble.tell(&anyhow::Error::msg(error));
    }
    let differs = report.diagnostics.iter();
    let differs = differs.filter(|diagnostic| diagnostic.severity != Severity::Hint).count();
    Ok(trouble.outcome(if differs == 0 && !broken {
        CommandExit::Fine
    } else {
        CommandExit::Errors
    }))
}

/// Prints a warning: the specification has errors, so not everything could be compared.
fn has_errors(folder: &Folder) {
    let path = session::display(&folder.specification);
    let errors = folder.unit.diagnostics.iter();
    let errors = errors.filter(|error| error.severity == Severity::Error);
    let (here, text): (Vec<_>, Vec<_>) = errors.partition(|error| is_environment(error.code));
    let count = |all: &[&Diagnostic], one: &str| match all.len() {
        1 => format!("1 {one}"),
        n => format!("{n} {one}s"),
    };
    let what = match (here.is_empty(), text.is_empty()) {
        (false, true) => format!(
            "{} missing on this machine: `dotgen deps {path}` says what brings it",
            count(&here, "thing")
        ),
        (true, _) => format!("{}: `dotgen check {path}` shows them", count(&text, "error")),
        (false, false) => format!(
            "{}, and {} missing on this machine: `dotgen check {path}` and `dotgen deps {path}` say more",
            count(&text, "error"),
            count(&here, "thing"),
        ),
    };
    report::note(&format!("`{path}` has {what}"));
}

/// Returns the coverage of the codels of a folder, by component.
fn coverage_of(folder: &Folder) -> Vec<Compared> {
    let all = folder.expected();
    let one = |expected: &Expected<'_>| {
        let mut coverage = Coverage::default();
        coverage.add(expected, &folder.trust);
        Compared {
            file: session::display(&folder.specification),
            component: expected.component().name.to_string(),
            coverage,
        }
    };
    all.iter().map(one).collect()
}

/// Prints a warning: nothing was compared. This differs from agreement.
fn warn_nothing_compared(folder: &Folder) {
    let path = session::display(&folder.specification);
    let sources = session::display(&folder.sources.folder);
    report::note(&format!(
        "`{path}` has no sources in `{sources}`, so nothing was compared; `dotgen codels stub {path}` \
            writes them"
    ));
}

fn stub(arguments: &Stub) -> anyhow::Result<CommandExit> {
    check_is_file(std::slice::from_ref(&arguments.file))?;
    let mut session = session::single(&arguments.file, &arguments.reading)?;
    let root = roots(&session).pop().context("there is nothing to read")?;
    let target = match (&arguments.codel, &arguments.service) {
        (Some(name), _) => StubTarget::Codel(name.clone()),
        (None, Some(name)) => StubTarget::Owner(name.clone()),
        (None, None) => StubTarget::All,
    };
    let changes =
        command::stub(&mut project(&mut session), &root, &target).map_err(anyhow::Error::msg)?;
    if changes.is_empty() {
        report::note("every codel has a function; there is nothing to write");
    }
    write(&changes, &session.writable(), arguments.dry_run)?;
    Ok(CommandExit::Fine)
}

/// `CODEL=STATE`
fn yield_of_codel(text: &str) -> Result<(String, String), String> {
    let (codel, state) = text
        .split_once('=')
        .ok_or("write the codel and the state, as in `arm_move=pause::main`")?;
    Ok((codel.trim().to_owned(), state.trim().to_owned()))
}

fn sync(arguments: &Sync) -> anyhow::Result<CommandExit> {
    let (files, mut trouble) = session::specifications(&session::or_here(&arguments.paths));
    check_is_file(&arguments.paths)?;
    let options = SyncOptions { remove_yields: arguments.remove_yield.clone() };
    let mut outcome = CommandExit::Fine;
    for mut session in session::open(files, &arguments.reading)? {
        let roots = roots(&session);
        let done = command::sync(&mut project(&mut session), &roots, &options);
        if trouble
            .ok_or_report(write(&done.changes, &session.writable(), arguments.dry_run))
            .is_none()
        {
            continue;
        }
        let mut out = anstream::stdout();
        for title in &done.applied {
            writeln!(out, "{title}")?;
        }
        if done.applied.is_empty() && done.left.errors.is_empty() {
            report::note("there is nothing to mend");
        }
        for note in &done.notes {
            let path = session::display(&note.path).into();
            report::note(&ManualChange { path, ..note.clone() }.to_string());
        }
        let left = done.left.findings.iter();
        let left: Vec<_> = left.filter(|finding| finding.severity != Severity::Hint).collect();
        for finding in &left {
            let at = finding.at.as_ref();
            let at = at.map_or_else(String::new, |at| {
                format!("{}:{}: ", session::display(&at.path), at.line)
            });
            writeln!(out, "{at}{}", finding.message)?;
        }
        if !left.is_empty() {
            writeln!(out, "{} left, see `dotgen codels check`", left.len())?;
            outcome = CommandExit::Errors;
        }
        for error in &done.left.errors {
            trouble.tell(&anyhow::Error::msg(error.clone()));
        }
    }
    Ok(trouble.outcome(outcome))
}

fn headers(arguments: &Headers) -> anyhow::Result<CommandExit> {
    check_is_file(std::slice::from_ref(&arguments.file))?;
    let mut session = session::single(&arguments.file, &arguments.reading)?;
    let root = roots(&session).pop().context("there is nothing to read")?;
    let beside = root.parent().unwrap_or(Utf8Path::new("."));
    let output = match &arguments.output {
        Some(output) => vfs::normalize(&camino::absolute_utf8(output)?),
        None => beside.join(FOLDER),
    };
    let files = command::headers(&mut project(&mut session), &root, &output, &[])
        .map_err(anyhow::Error::msg)?;
    let mut changes: Vec<FileChange> = files
        .into_iter()
        .map(|file| {
            let path = output.join(file.path);
            let before = Disk.read(&path).map(|read| read.to_string());
            FileChange { path, before, after: file.text }
        })
        .collect();
    let ignored = output.join(".gitignore");
    if arguments.output.is_none() && !ignored.exists() {
        changes.push(FileChange { path: ignored, before: None, after: IGNORED.to_owned() });
    }
    // A folder of the command line may be anywhere.
    let within = match &arguments.output {
        Some(_) => vec![output],
        None => session.writable(),
    };
    write(&changes, &within, false)?;
    Ok(CommandExit::Fine)
}

/// Writes changes, all or none, and prints the names of the files; or prints the differences.
fn write(changes: &[FileChange], within: &[Utf8PathBuf], dry_run: bool) -> anyhow::Result<()> {
    let changed = |change: &&FileChange| change.before.as_deref() != Some(&change.after);
    let changes: Vec<&FileChange> = changes.iter().filter(changed).collect();
    let mut out = anstream::stdout();
    if dry_run {
        for change in changes {
            let path = session::display(&change.path).into();
            let shown = FileChange { path, ..change.clone() };
            write!(out, "{}", report::patch(&shown.diff()))?;
        }
        return Ok(());
    }
    let content = |change: &&FileChange| {
        report::edited(&change.path, change.before.as_deref(), &change.after)
    };
    report::write_files(changes.iter().map(content).collect(), within)?;
    for change in changes {
        let did = if change.before.is_some() { "changed" } else { "created" };
        writeln!(out, "{did} {}", terminal::name(&session::display(&change.path)))?;
    }
    Ok(())
}
