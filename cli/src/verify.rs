//! `dotgen verify`

mod certificate;
pub(super) mod diagnostics;
mod explain;
pub(super) mod interrupt;
mod json;
mod limits;
mod table;
pub(super) mod text;
mod xta;

use std::time::Duration;

use anyhow::{anyhow, bail};
use camino::{Utf8Path, Utf8PathBuf};
use clap::Args;
use dotgen_analysis::diagnostic::FileEdit;
use dotgen_analysis::host::FileContent;
use dotgen_analysis::language::{self, Language, SPECIFICATION};
use dotgen_timing::derive::Sensitivity;
use dotgen_timing::diagnostic::remark::together;
use dotgen_timing::explore::{Kind, Limits};
use dotgen_timing::report::Report;
use dotgen_timing::scn::ast::Check;
use dotgen_timing::scn::{Platform, parse_check};
use dotgen_timing::verify::{Cancel, Interrupt, Options, Prepared, SystemInput, prepare, settings};

use self::diagnostics::ScenarioDiagnostics;
use super::outputs::{self, Output, VIEWER};
use super::report::TextOrJson;
use super::session::{self, ErrorReporter, Session, SourceFile};
use super::system_options::{DurationsName, SystemOptions};
use super::{CommandExit, SpecificationOptions, report, trace};
use crate::progress::{self, Activity};
use dotgen_platform::files::vfs;
use dotgen_views::verification::Problem;
use dotgen_views::verification::changes::Repairs;
use dotgen_views::verification::first::{self, FirstAnswer};
use dotgen_views::verification::runs;
use dotgen_views::verification::view::View;
use dotgen_views::verification::why::{self, FailureCause};

/// Verify real-time properties: deadlines, response times, bounded responses
///
/// A scenario (FILE.scn) names its specifications, platform, clients and checks. Without a scenario, all
/// FILE.gen are verified together as one system: their permanent activities, and a client that sends any
/// request at any time. A directory stands for the .gen files below it. Options override the scenario.
///
/// Exit status: 0 if all checks hold, 1 if a check fails, 2 if nothing could be verified (wrong usage, or a
/// file that cannot be read or has errors), 3 if no check fails but one was given up, holds only on a
/// condition, or had nothing to verify (missing execution times).
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Scenarios (.scn), specifications (.gen), and directories to search for .gen files [default: the
    /// scenario in this directory, else .]
    #[arg(value_name = "FILE")]
    files: Vec<Utf8PathBuf>,

    #[command(flatten)]
    system: SystemOptions,

    /// Execution times of codels
    #[arg(long, value_enum)]
    durations: Option<DurationsName>,

    /// Answer queries about a network of timed automata in UPPAAL's format: those of `--check`, or of FILE.q
    #[arg(long, value_name = "FILE.xta", conflicts_with_all = [
        "files", "cores", "semantics", "policy", "durations", "threads", "sensitivity", "explain", "trace",
        "certificate", "without",
    ])]
    xta: Option<Utf8PathBuf>,

    /// Check CHECK instead of the scenario's checks, for example "response arm.motion <= 5 ms"
    #[arg(long = "check", value_name = "CHECK", action = clap::ArgAction::Append)]
    checks: Vec<String>,

    /// Give up a check after N states [default: 20000000; without a scenario 25000]
    #[arg(long, value_name = "N")]
    max_states: Option<usize>,

    /// Give up a check when its states need more than MB megabytes
    #[arg(long, value_name = "MB", default_value_t = Limits::default().bytes >> 20)]
    max_memory: usize,

    /// Number of threads for --sensitivity [default: one per processor core]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<usize>,

    /// Time limit for each scenario; checks without an answer are given up
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    timeout: Option<Duration>,

    /// If deadlines are missed, list single changes that repair them; otherwise compute slack: fewest cores,
    /// longest execution times, shortest periods
    #[arg(long)]
    sensitivity: bool,

    /// List the reductions that the exploration used, and the reason against each other one
    #[arg(long)]
    explain: bool,

    /// Write a trace of the first refuted check, or else the first witness, for the trace viewer
    /// (docs/trace.md)
    #[arg(long, value_name = "FILE")]
    trace: Option<Utf8PathBuf>,

    /// Write a certificate of the checks that invariants prove, which `dotgen-check` checks
    #[arg(long, value_name = "FILE.json")]
    certificate: Option<Utf8PathBuf>,

    /// Switch off a reduction, by its name in the output of `--explain`
    #[arg(long, value_name = "REDUCTION", value_parser = reduction, hide = true)]
    without: Vec<Kind>,

    /// Output format
    #[arg(long, value_enum, default_value_t = TextOrJson::Text)]
    format: TextOrJson,

    #[command(flatten)]
    reading: SpecificationOptions,
}

/// Maximum number of states for a specification without a scenario. Its client may send any request, and a
/// longer search seldom finds more.
const MAX_DEFAULT_STATES: usize = 25_000;

/// The results of `--sensitivity`.
struct Slacks {
    /// If a deadline or limit is missed, the changes that repair it, each with its edit.
    repairs: Repairs,
    edits: Vec<Option<FileEdit>>,
    /// `None` if the scenario has errors, which were reported.
    sensitivity: Option<Sensitivity>,
}

/// A problem and its answer.
struct Answer {
    problem: Problem,
    options: Options,
    report: Report,
    /// By check: the cause of a failure, and a remedy.
    why: Vec<Option<FailureCause>>,
    /// Without a scenario, the answers with fewer requests.
    first: Vec<FirstAnswer>,
    /// The diagnostics, for JSON.
    diagnostics: serde_json::Value,
    /// The results of `--sensitivity`.
    limits: Option<Slacks>,
}

fn threads(text: &str) -> Result<usize, String> {
    let threads = text.parse().ok().filter(|&threads| threads > 0);
    threads.ok_or_else(|| "give a number of threads from 1 on".to_owned())
}

fn reduction(text: &str) -> Result<Kind, String> {
    Kind::named(text).ok_or_else(|| {
        let names = Kind::ALL.map(Kind::name);
        format!("give one of {}", names.join(", "))
    })
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok();
    let time = seconds.and_then(|number| Duration::try_from_secs_f64(number).ok());
    time.ok_or_else(|| "give a number of seconds".to_owned())
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    if let Some(file) = &arguments.xta {
        return xta::run(file, arguments);
    }
    let checks: Vec<&str> = arguments.checks.iter().map(|check| body(check)).collect();
    checks.iter().try_for_each(|wanted| check(wanted, 0).map(drop))?;
    let mut answers = Vec::new();
    let interrupt = interrupt::on_terminal();
    let (all, mut trouble) =
        problems(&session::or_scenario_here(&arguments.files)?, &arguments.reading);
    let written = arguments.trace.iter().chain(&arguments.certificate);
    let written: Vec<Output<'_>> =
        written.map(|path| Output { path, endings: &[VIEWER] }).collect();
    outputs::check(&written, all.iter().flat_map(|(_, problem)| problem.files()))?;
    for (session, problem) in all {
        let is_first = answers.is_empty();
        match answer(arguments, &checks, &session, problem, &interrupt, is_first)? {
            Some(answer) => answers.push(answer),
            None => trouble.told(),
        }
    }
    if !answers.is_empty() && matches!(arguments.format, TextOrJson::Json) {
        json::print(&answers)?;
    }
    if let Some(path) = &arguments.trace {
        write_trace(path, &answers)?;
    }
    if let Some(path) = &arguments.certificate {
        certificate::write(path, &answers)?;
    }
    Ok(trouble.outcome(if answers.iter().any(|answer| answer.report.refuted()) {
        CommandExit::Errors
    } else if answers.iter().any(|answer| {
        answer.report.unknown() || answer.report.nothing() || answer.report.conditional()
    }) {
        CommandExit::GaveUp
    } else {
        CommandExit::Fine
    }))
}

/// Verifies one problem, and prints the answers as text unless JSON is wanted. Returns `None` after errors of
/// the problem, which are printed.
fn answer(
    arguments: &Arguments,
    checks: &[&str],
    session: &Session,
    problem: Problem,
    interrupt: &Interrupt,
    is_first: bool,
) -> anyhow::Result<Option<Answer>> {
    if !problem.errors.is_empty() {
        ScenarioDiagnostics::about(session, &problem, problem.errors.clone())?.print()?;
        return Ok(None);
    }
    let options = arguments.options(checks, &problem)?;
    let cancel = Cancel::interrupted_by(interrupt);
    if let Some(time) = arguments.timeout {
        cancel.limit(time);
    }
    let doing = format!("verifying {}", problem.scenario.name);
    let first =
        if checks.is_empty() { first::answers(&problem, &options, &cancel) } else { Vec::new() };
    let report = progress::during(Some(&cancel), &doing, |tell| {
        problem.verify(&options, &cancel, &|report| {
            tell(Activity { what: doing.clone(), how_far: report.how_far() });
        })
    });
    let told = |all: &[dotgen_timing::diagnostic::Diagnostic]| {
        ScenarioDiagnostics::by_verifier(session, &problem, all, checks)
    };
    let is_text = matches!(arguments.format, TextOrJson::Text);
    // In JSON, diagnostics are part of the document, if there is one.
    if is_text || report.has_errors() {
        told(&together(&report.diagnostics))?.print()?;
    }
    if report.has_errors() {
        return Ok(None);
    }
    let diagnostics = told(&report.diagnostics)?.to_json()?;
    let why = why::of_report(&problem, &options, &report, Some(&cancel));
    let mut answer = Answer { why, problem, options, report, first, diagnostics, limits: None };
    if is_text {
        text::head(&answer, is_first, arguments.explain)?;
    }
    if arguments.sensitivity && !interrupt.is_raised() {
        answer.limits = Some(limits::found(session, &answer, &cancel, is_text)?);
    }
    if is_text {
        text::tail(&answer, arguments.explain)?;
    }
    Ok(Some(answer))
}

/// Writes the run of the first refuted check, or else the first witness. Of several scenarios, the first one
/// with such a run counts.
fn write_trace(path: &Utf8Path, answers: &[Answer]) -> anyhow::Result<()> {
    let with_run = |answer: &'_ Answer| runs::chosen(&answer.report, None);
    let found = answers.iter().find_map(|answer| Some((answer, with_run(answer)?)));
    let Some((answer, number)) = found else {
        bail!("`--trace`: no check has a run to be written");
    };
    let check = &answer.report.checks[number];
    let recorded = trace::RecordedRun {
        title: runs::title(check),
        unit: answer.report.unit,
        events: check.run(),
        ending: runs::ending(check),
        cycle: check.cycle,
        notes: check.note.iter().cloned().collect(),
    };
    trace::write(path, recorded, &answer.problem, &answer.options).map(drop)
}

/// Returns one problem for each scenario, and one for all named specifications. Unusable files are reported.
pub(super) fn problems(
    arguments: &[Utf8PathBuf],
    reading: &SpecificationOptions,
) -> (Vec<(Session, Problem)>, ErrorReporter) {
    let (files, mut trouble) = session::usable_files(arguments, &[SPECIFICATION]);
    report::note_unused_scenarios(arguments, &files);
    // Without one of its parts the system would differ.
    let mut whole = !trouble.any();
    let mut out = Vec::new();
    let mut specifications = Vec::new();
    for file in files {
        match Language::of(&file.path) {
            Some(Language::Scenario) => {
                out.extend(trouble.ok_or_report(of_scenario(&file, reading)));
            }
            _ if language::is_specification(&file.path) => specifications.push(file),
            _ => {
                let path = session::display(&file.path);
                let error = "is neither a scenario (.scn) nor a specification (.gen)";
                trouble.tell(&anyhow!("`{path}` {error}"));
                whole = false;
            }
        }
    }
    if whole {
        let together = trouble.ok_or_report(of_specifications(specifications, reading));
        out.extend(together.flatten());
    }
    (out, trouble)
}

/// Returns the single problem of the arguments. Returns `None` if it cannot be used, which was reported.
pub(super) fn one_problem(
    files: &[Utf8PathBuf],
    reading: &SpecificationOptions,
) -> anyhow::Result<Option<(Session, Problem)>> {
    let (mut all, trouble) = problems(files, reading);
    if trouble.any() {
        return Ok(None);
    }
    let (Some((session, problem)), true) = (all.pop(), all.is_empty()) else {
        bail!("name one scenario, or specifications");
    };
    if !problem.errors.is_empty() {
        ScenarioDiagnostics::about(&session, &problem, problem.errors.clone())?.print()?;
        return Ok(None);
    }
    Ok(Some((session, problem)))
}

/// Prepares a problem. Returns `None` after errors. Errors are printed, and with `with_warnings` all
/// diagnostics.
pub(super) fn prepared(
    session: &Session,
    problem: &Problem,
    options: &Options,
    checks: &[&str],
    with_warnings: bool,
) -> anyhow::Result<Option<Prepared>> {
    let input = SystemInput { specs: problem.specs() };
    let prepared = prepare(&input, &problem.scenario, options);
    let has_errors = prepared.report.has_errors();
    if with_warnings || has_errors {
        let told = together(&prepared.report.diagnostics);
        ScenarioDiagnostics::by_verifier(session, problem, &told, checks)?.print()?;
    }
    Ok((!has_errors).then_some(prepared))
}

/// Returns the name of a scenario, or else its file.
pub(super) fn title(problem: &Problem) -> String {
    match problem.scenario.name.as_str() {
        "" => display(&problem.path),
        name => name.to_owned(),
    }
}

fn of_scenario(
    file: &SourceFile,
    reading: &SpecificationOptions,
) -> anyhow::Result<(Session, Problem)> {
    let (FileContent::Text(text) | FileContent::NotUtf8(text)) = vfs::read(&file.path) else {
        bail!("cannot read `{}`", session::display(&file.path))
    };
    let session = session::around(&file.path, Vec::new(), reading);
    let problem = session.ask(&file.path, |analysis| {
        Problem::from_scenario(&file.path, text.clone(), analysis, vfs::read)
    })?;
    Ok((session, problem))
}

/// Returns all specifications as one system, even if they have different configurations.
fn of_specifications(
    files: Vec<SourceFile>,
    reading: &SpecificationOptions,
) -> anyhow::Result<Option<(Session, Problem)>> {
    let Some(first) = files.first().map(|file| file.path.clone()) else {
        return Ok(None);
    };
    let mut units = Vec::new();
    let mut names = Vec::new();
    let sessions = session::open(files, reading)?;
    for session in &sessions {
        for file in &session.files {
            units.push(session.ask(&file.path, |analysis| analysis.root_unit(&file.path))?);
            names.push(session::display(&file.path));
        }
    }
    let problem =
        Problem::default_scenario_on(Platform::default(), &first, &names, units, vfs::read);
    Ok(sessions.into_iter().next().map(|session| (session, problem)))
}

impl Arguments {
    fn options(&self, checks: &[&str], problem: &Problem) -> anyhow::Result<Options> {
        let written = problem.is_written();
        let most = if written { Limits::default().states } else { MAX_DEFAULT_STATES };
        let limits = Limits {
            states: self.max_states.unwrap_or(most),
            bytes: self.max_memory.saturating_mul(1 << 20),
            threads: self.threads.unwrap_or(Limits::default().threads),
            without: self.without.iter().copied().collect(),
            ..Limits::default()
        };
        Ok(Options {
            durations: self.durations.map(DurationsName::durations),
            checks: parsed(checks, problem)?,
            limits,
            ..self.system.options()
        })
    }
}

/// Parses checks of the command line, with places after the text of the scenario.
pub(super) fn parsed(checks: &[&str], problem: &Problem) -> anyhow::Result<Vec<Check>> {
    let mut at = problem.text.len();
    let mut parsed = Vec::new();
    for body in checks {
        parsed.extend(check(body, at)?);
        at += body.len() + 1;
    }
    Ok(parsed)
}

/// Returns a check of the command line without `check` before it and `;` after it.
pub(super) fn body(text: &str) -> &str {
    let body = text.trim().trim_end_matches(';');
    body.strip_prefix("check ").unwrap_or(body).trim()
}

/// Parses a check with places from `at`.
fn check(body: &str, at: usize) -> anyhow::Result<Vec<Check>> {
    match parse_check(&format!("{}{body}", " ".repeat(at))) {
        Ok(checks) => Ok(checks),
        Err(error) => {
            let at = error.range.start.min(body.len());
            let at = body.get(..at).map_or(0, |body| body.chars().count());
            bail!("in `--check`: {}\n  {body}\n  {}^", error.message, " ".repeat(at))
        }
    }
}

impl Answer {
    fn settings(&self) -> dotgen_timing::system::settings::Settings {
        settings(&self.problem.scenario, &self.options)
    }

    fn view(&self) -> View<'_> {
        View::new(&self.problem, &self.options, &self.report, &self.why)
    }

    fn file(&self) -> String {
        display(&self.problem.path)
    }
}

fn display(path: &Utf8Path) -> String {
    session::display(path)
}
