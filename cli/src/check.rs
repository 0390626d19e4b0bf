//! `dotgen check`

mod fix;
mod scenarios;

use camino::Utf8PathBuf;
use clap::{Args, ValueEnum};
use dotgen_analysis::codes::{is_environment, severity_here};
use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use dotgen_analysis::host::Analysis;
use dotgen_analysis::language::{SCENARIO, SPECIFICATION};
use dotgen_timing::scn::names::Names;
use rustc_hash::{FxHashMap, FxHashSet};

use super::report::{self, FileReports, Format, OpenNames};
use super::session::{self, ConfigProblems, ErrorReporter, Session, SourceFile, Texts};
use super::{CommandExit, SpecificationOptions};
use dotgen_lsp_server::protocol::convert::{Encoding, Lines};
use dotgen_platform::files::vfs;
use dotgen_views::verification::Problem;

/// Code of a file that cannot be read.
const UNREADABLE: &str = "pp-input";

/// Check specifications and scenarios
///
/// Exit status: 0 without errors (warnings do not count), 1 with errors, or with --diff if there is something
/// to fix, 2 if a file cannot be read or written.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Specifications, scenarios (.scn), directories to search for .gen files, or - for standard input
    /// [default: the specifications and scenarios of this folder]
    #[arg(value_name = "PATH")]
    paths: Vec<Utf8PathBuf>,

    /// Output format of diagnostics
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,

    /// Apply every unambiguous fix; report the rest
    #[arg(long)]
    fix: bool,

    /// Write nothing; print the changes of --fix
    #[arg(long)]
    diff: bool,

    /// With --fix or --diff: also apply the first fix of errors that could be meant in another way
    #[arg(long)]
    unsafe_fixes: bool,

    /// Print the release of GenoM3 that specifications are read as, and the reason for it
    #[arg(long, short)]
    verbose: bool,

    /// Report these warnings as errors; the environment variable DOTGEN_DENY does the same
    #[arg(long, value_enum, value_name = "WHAT")]
    deny: Vec<Deny>,

    #[command(flatten)]
    reading: SpecificationOptions,
}

/// Warnings that can be errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Deny {
    /// Packages and included files that are not found
    Missing,
}

impl Arguments {
    /// Returns true if a missing package or file is an error.
    fn denies_missing(&self) -> bool {
        let variable = std::env::var("DOTGEN_DENY").unwrap_or_default();
        let mut words = variable.split(',').map(str::trim);
        self.deny.contains(&Deny::Missing) || words.any(|word| word == "missing")
    }
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    anyhow::ensure!(
        !arguments.unsafe_fixes || arguments.fix || arguments.diff,
        "`--unsafe-fixes` needs `--fix` or `--diff`"
    );
    // The scenarios of the folder belong to it, unless paths name what is checked.
    let extensions: &[&str] =
        if arguments.paths.is_empty() { &[SPECIFICATION, SCENARIO] } else { &[SPECIFICATION] };
    let (files, mut trouble) =
        session::usable_files(&session::or_here(&arguments.paths), extensions);
    if files.is_empty() {
        return Ok(trouble.outcome(CommandExit::Fine));
    }
    let mut report = FileReports::default();
    let mut changed = fix::ChangedTexts::new();
    let mut made = fix::AppliedFixes::new();
    let mut writable = Vec::new();
    let reading = SpecificationOptions {
        only_installed: arguments.denies_missing(),
        ..arguments.reading.clone()
    };
    for mut session in session::open(files, &reading)? {
        if arguments.verbose {
            print_release(&session)?;
        }
        writable.extend(session.writable());
        if arguments.fix || arguments.diff {
            let which = if arguments.unsafe_fixes {
                fix::Applied::AlsoGuesses
            } else {
                fix::Applied::Plain
            };
            let found = fix::apply_fixes(&mut session, which, &mut changed, &mut made);
            trouble.ok_or_report(found);
            trouble.ok_or_report(scenarios::apply_fixes(
                &mut session,
                which,
                &mut changed,
                &mut made,
            ));
        }
        let before = std::mem::take(&mut report.diagnostics);
        check(&mut session, &mut report, &mut trouble);
        fix::retain_unrefuted(&mut session, &mut report.diagnostics);
        let shown = match arguments.format {
            Format::Text => fix::Shown::First,
            Format::Json | Format::Sarif => fix::Shown::All,
        };
        fix::judge(&mut session, &changed, &mut report.diagnostics, shown);
        report.diagnostics.splice(0..0, before);
    }
    if arguments.diff {
        return fix::print(&changed);
    }
    fix::write(&changed, &made, &writable)?;
    if !arguments.denies_missing() {
        for diagnostic in &mut report.diagnostics {
            diagnostic.severity = severity_here(diagnostic.code, diagnostic.severity);
        }
    }
    report.finish();
    report::print(&report, arguments.format)?;
    if arguments.fix && !arguments.unsafe_fixes {
        note_left(&report.diagnostics);
    }
    if report.diagnostics.iter().any(|diagnostic| diagnostic.code == UNREADABLE) {
        trouble.told();
    }
    Ok(trouble.outcome(match report.count(Severity::Error) {
        0 => CommandExit::Fine,
        _ => CommandExit::Errors,
    }))
}

/// Reports the fixes of errors that were not applied.
fn note_left(found: &[Diagnostic]) {
    let guessed = found.iter().filter(|diagnostic| {
        let fix = diagnostic.fixes.first();
        fix.is_some_and(|fix| fix::Applied::AlsoGuesses.includes(fix, diagnostic.severity))
    });
    let left = match guessed.count() {
        0 => return,
        1 => "1 fix is a guess and was not applied: `--unsafe-fixes` applies it".to_owned(),
        count => {
            format!("{count} fixes are guesses and were not applied: `--unsafe-fixes` applies them")
        }
    };
    report::note(&left);
}

/// Adds the diagnostics of the files of a session. A file that cannot be read is reported, and the others are
/// checked.
fn check(session: &mut Session, report: &mut FileReports, trouble: &mut ErrorReporter) {
    if let Some(config) = &session.config {
        add_config_problems(config, &mut report.diagnostics, &mut report.texts);
    }
    trouble.ok_or_report(check_specifications(session, report));
    for file in session.files.iter().filter(|file| file.is_scenario()) {
        if let Some(found) = trouble.ok_or_report(scenario(session, file)) {
            trouble.ok_or_report(session.add_texts(&found, &mut report.texts));
            report.diagnostics.extend(found);
            report.checked += 1;
        }
    }
}

fn check_specifications(session: &mut Session, report: &mut FileReports) -> anyhow::Result<()> {
    let specifications = session.files.iter().filter(|file| !file.is_scenario());
    let specifications: Vec<Utf8PathBuf> =
        specifications.map(|specification| specification.path.clone()).collect();
    // The includes of each file have to be known before the question which files are included.
    session.ask_each(&specifications, Analysis::files_of_root, |_, _, _| Ok(()))?;
    let ours: FxHashSet<&Utf8PathBuf> = session.files.iter().map(|file| &file.path).collect();
    let mut wanted = Vec::new();
    for file in session.files.iter().filter(|file| !file.is_scenario()) {
        if !file.named {
            // The file was found in a directory, and another file of the directory includes it. It is checked
            // there, and may be incomplete alone.
            let roots =
                session.ask(&file.path, |analysis| analysis.roots_containing(&file.path))?;
            if roots.iter().any(|root| *root != file.path && ours.contains(root)) {
                continue;
            }
        }
        wanted.push(file.path.clone());
    }
    let mut reports = FxHashMap::default();
    session.ask_each(&wanted, Analysis::root_diagnostics, |_, path, found| {
        reports.insert(path.to_owned(), found);
        Ok(())
    })?;
    for path in &wanted {
        if let Some(found) = reports.remove(path) {
            if found.iter().any(|diagnostic| is_environment(diagnostic.code)) {
                let needs = session.ask(path, |analysis| analysis.dependencies(path))?;
                report.waiting.extend(OpenNames::of(&needs));
            }
            session.add_texts(&found, &mut report.texts)?;
            report.diagnostics.extend(found.iter().cloned());
            report.checked += 1;
        }
    }
    Ok(())
}

/// Prints the release of GenoM3 on standard error, once for all files that are read as the same one.
fn print_release(session: &Session) -> anyhow::Result<()> {
    let mut said = Vec::new();
    for file in session.files.iter().filter(|file| !file.is_scenario()) {
        let choice = session.ask(&file.path, |analysis| analysis.release(&file.path))?;
        if !said.contains(&choice) {
            anstream::eprintln!("{}: GenoM3 {choice}", session::display(&file.path));
            said.push(choice);
        }
    }
    Ok(())
}

/// Returns the problems of a scenario: syntax, specifications, names.
fn scenario(session: &Session, file: &SourceFile) -> anyhow::Result<Vec<Diagnostic>> {
    let text = session.ask(&file.path, |analysis| analysis.text(&file.path))?;
    scenario_with(session, file, &text.unwrap_or_default())
}

/// Returns the problems of a scenario with a text.
fn scenario_with(
    session: &Session,
    file: &SourceFile,
    text: &str,
) -> anyhow::Result<Vec<Diagnostic>> {
    let problem = session.ask(&file.path, |analysis| {
        Problem::from_scenario(&file.path, text.to_owned(), analysis, vfs::read)
    })?;
    let mut found = problem.errors.clone();
    if found.is_empty() {
        let specs = problem.specs();
        let unknown = Names::new(&specs).unknown_names(&problem.scenario);
        found.extend(unknown.iter().map(|unknown_name| problem.diagnostic(unknown_name)));
        found.extend(problem.warnings.iter().cloned());
    }
    Ok(found)
}

fn add_config_problems(
    config: &ConfigProblems,
    diagnostics: &mut Vec<Diagnostic>,
    texts: &mut Texts,
) {
    let problems = config.problems.iter().map(|problem| {
        let severity = if problem.kind.is_error() { Severity::Error } else { Severity::Warning };
        Diagnostic::new(
            problem.kind.code(),
            severity,
            problem.message.clone(),
            config.path.clone(),
            problem.range.clone().unwrap_or(0..0),
        )
    });
    diagnostics.extend(problems);
    let lines = Lines::new(config.text.clone(), Encoding::Utf16);
    texts.insert(config.path.clone(), lines);
}
