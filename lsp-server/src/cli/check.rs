//! `dotgen check`

use std::collections::BTreeSet;

use camino::Utf8PathBuf;
use clap::Args;
use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use dotgen_timing::scn::names::Names;

use super::report::{self, Format, Report};
use super::session::{self, ConfigProblems, Session, SourceFile, Texts};
use super::{Outcome, Reading};
use crate::convert::{Encoding, Lines};
use crate::verification::Problem;
use crate::vfs;

/// Report what is wrong with specifications
///
/// Exit status: 0 without errors (warnings do not count), 1 with errors, 2 if a file cannot be read.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Specifications, scenarios (.scn), and directories to search for .gen files
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<Utf8PathBuf>,

    /// How to print diagnostics
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,

    #[command(flatten)]
    reading: Reading,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let files = session::files(&arguments.paths)?;
    let mut report = Report::default();
    for session in session::open(files, &arguments.reading)? {
        check(&session, &mut report)?;
    }
    report.finish();
    report::print(&report, arguments.format)?;
    Ok(match report.count(Severity::Error) {
        0 => Outcome::Fine,
        _ => Outcome::Errors,
    })
}

fn check(session: &Session, report: &mut Report) -> anyhow::Result<()> {
    if let Some(config) = &session.config {
        add_config_problems(config, &mut report.diagnostics, &mut report.texts);
    }
    let ours: BTreeSet<_> = session.files.iter().map(|it| &it.path).collect();
    for file in &session.files {
        if file.is_scenario() {
            let found = scenario(session, file)?;
            session.add_texts(&found, &mut report.texts)?;
            report.diagnostics.extend(found);
            report.checked += 1;
            continue;
        }
        if !file.named {
            // Found in a directory and included by another file of it: it is checked in there, and
            // need not make sense alone.
            let roots = session.ask(&file.path, |it| it.roots_containing(&file.path))?;
            if roots.iter().any(|it| *it != file.path && ours.contains(it)) {
                continue;
            }
        }
        let unit = session.ask(&file.path, |it| it.root_unit(&file.path))?;
        session.add_texts(&unit.diagnostics, &mut report.texts)?;
        report.diagnostics.extend(unit.diagnostics.iter().cloned());
        report.checked += 1;
    }
    Ok(())
}

/// What is wrong with a scenario: syntax, the specifications it uses, names.
fn scenario(session: &Session, file: &SourceFile) -> anyhow::Result<Vec<Diagnostic>> {
    let problem = session.ask(&file.path, |it| {
        let text = it.text(&file.path)?.unwrap_or_default().to_string();
        Problem::from_scenario(&file.path, text, it, vfs::read)
    })?;
    let mut found = problem.errors.clone();
    if found.is_empty() {
        let specs = problem.specs();
        let unknown = Names::new(&specs).unknown_names(&problem.scenario);
        found.extend(unknown.iter().map(|it| problem.diagnostic(it)));
    }
    Ok(found)
}

fn add_config_problems(
    config: &ConfigProblems,
    diagnostics: &mut Vec<Diagnostic>,
    texts: &mut Texts,
) {
    let problems = config.problems.iter().map(|problem| {
        let severity = match problem.kind.is_error() {
            true => Severity::Error,
            false => Severity::Warning,
        };
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
