//! `dotgen monitor`

mod checks;
#[cfg(unix)]
mod live;
mod text;

use std::io::{Read, Seek, SeekFrom, Write};
use std::time::Duration;

use anyhow::{Context, bail};
use camino::{Utf8Path, Utf8PathBuf};
use clap::Args;
use dotgen_recording::log::Lines;
use dotgen_recording::monitor::{Monitor, MonitorReport};
use dotgen_recording::trace::Trace;
use dotgen_timing::report::TimeUnit;
use dotgen_timing::scn::names::Names;
use dotgen_timing::verify::Interrupt;

use self::checks::{CheckResults, LogChecks};
use super::outputs::{self, Output, PERFETTO};
use super::report::TextOrJson;
use super::run::bounds;
use super::session::is_standard_input;
use super::system_options::SystemOptions;
use super::verify::{interrupt, one_problem, prepared, title};
use super::wcet::{CHUNK_BYTES, InputFiles, input_files, open, read_log};
use super::{CommandExit, SpecificationOptions, report};
use dotgen_platform::files::disk::Stream;

/// Interval of reads from a log that is followed.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Check recorded runs against the verified model
///
/// A log of GenoM3's profiler has one run. Servers generated with profiling write such logs, and so does
/// `dotgen run --profile`. Deviations from the model are reported: undeclared codels and transitions, codels
/// that take longer than declared, locks out of order, drifting ticks, response times beyond their bounds.
/// Transitions that were never taken are listed, but do not count as deviations.
///
/// Instead of a log, FILE may be the socket of a run (`dotgen run --clock real`), which is followed until it
/// ends.
///
/// Exit status: 0 if nothing deviates, 1 if something does, 2 if nothing could be compared.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Logs (`-` is standard input) or the socket of a run, and a scenario (.scn) or specifications (.gen)
    #[arg(value_name = "FILE", required = true)]
    files: Vec<Utf8PathBuf>,

    /// Follow the log as it grows, and report deviations at once, until Ctrl-C
    #[arg(long)]
    follow: bool,

    #[command(flatten)]
    system: SystemOptions,

    /// Bounds to compare response times with
    #[arg(long, value_enum, default_value_t = bounds::Source::Proved)]
    bounds: bounds::Source,

    /// Write the log as a trace (.pftrace) for https://ui.perfetto.dev
    #[arg(long, value_name = "FILE", conflicts_with = "follow")]
    trace: Option<Utf8PathBuf>,

    /// Output format
    #[arg(long, value_enum, default_value_t = TextOrJson::Text)]
    format: TextOrJson,

    #[command(flatten)]
    reading: SpecificationOptions,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let files = input_files(&arguments.files)?;
    check_files(arguments, &files)?;
    let interrupt = interrupt::on_terminal();
    let Some((session, problem)) = one_problem(&files.texts, &arguments.reading)? else {
        return Ok(CommandExit::Unusable);
    };
    let trace = arguments.trace.iter();
    let written: Vec<Output<'_>> =
        trace.map(|path| Output { path, endings: &[PERFETTO] }).collect();
    let read = problem.files().chain(files.logs.iter().map(camino::Utf8PathBuf::as_path));
    outputs::check(&written, read)?;
    let options = arguments.system.options();
    let Some(prepared) = prepared(&session, &problem, &options, &[], false)? else {
        return Ok(CommandExit::Unusable);
    };
    let bounds = bounds::of_tasks(arguments.bounds, &problem, &options, &prepared, &interrupt);
    let names = Names::new(&problem.specs());
    let system = &prepared.built.system;
    // Without execution times the monitor compares no bounds, but uses them for ticks.
    if let Some(note) = bounds::without_times(system, &mut [], true) {
        report::note(&note);
    }
    // Each log contains one run: a wait at the end of a run does not continue in the next one.
    let mut reports = Vec::new();
    let mut trace = (arguments.trace.is_some()).then(|| Trace::new(Some(&names)));
    for log in &files.logs {
        let monitor = Monitor::new(system, &names, bounds.clone());
        let mut monitor = LogChecks::new(&prepared, monitor);
        observe(log, &mut monitor, trace.as_mut(), arguments, &interrupt)?;
        let (report, results) = monitor.finish();
        reports.push(LogReport { log: log.clone(), report, results });
    }
    if let (Some(path), Some(trace)) = (&arguments.trace, trace) {
        write_trace(path, &trace.finish())?;
    }
    print(&title(&problem), &reports, prepared.report.unit, arguments.format)
}

/// The comparison of a log with the system.
struct LogReport {
    log: Utf8PathBuf,
    report: MonitorReport,
    results: CheckResults,
}

/// Checks that the files and options fit together.
///
/// # Errors
/// They do not.
fn check_files(arguments: &Arguments, files: &InputFiles) -> anyhow::Result<()> {
    if files.texts.is_empty() {
        bail!("name the scenario (.scn) that the log is held to, or its specification (.gen)");
    }
    if arguments.follow && files.logs.len() > 1 {
        bail!("`--follow` follows one log");
    }
    #[cfg(unix)]
    if files.logs.iter().any(|log| live::is_socket(log)) {
        anyhow::ensure!(files.logs.len() == 1, "follow one run at a time");
        let tracing = arguments.trace.is_some();
        anyhow::ensure!(
            !tracing,
            "`--trace` is for logs; a run writes its own (`dotgen run --trace`)"
        );
    }
    Ok(())
}

/// Compares the run in a log, or the run behind a socket, with the system.
fn observe(
    log: &Utf8Path,
    monitor: &mut LogChecks<'_>,
    mut trace: Option<&mut Trace<'_>>,
    arguments: &Arguments,
    interrupt: &Interrupt,
) -> anyhow::Result<()> {
    #[cfg(unix)]
    if live::is_socket(log) {
        return live::follow(log, monitor, arguments.format, interrupt);
    }
    if arguments.follow {
        return follow(log, monitor, arguments.format, interrupt);
    }
    read_log(log, |number, line, ended| {
        monitor.line(number, line, ended);
        if let Some(trace) = &mut trace {
            trace.line(line, ended);
        }
    })
}

/// Prints the reports of all logs.
fn print(
    title: &str,
    reports: &[LogReport],
    unit: TimeUnit,
    format: TextOrJson,
) -> anyhow::Result<CommandExit> {
    let mut all = reports.iter().map(|of| &of.report);
    let nothing = all.all(|report| report.runs == 0 && report.deviation_count == 0);
    match format {
        // Without lines, only the error is printed.
        TextOrJson::Text if nothing => {}
        TextOrJson::Text => text::print(title, reports, unit)?,
        TextOrJson::Json => print_json(title, reports)?,
    }
    if nothing {
        bail!("the log has no line of a codel of {title}");
    }
    let deviates = reports.iter().any(|of| of.report.deviation_count > 0);
    Ok(if deviates { CommandExit::Errors } else { CommandExit::Fine })
}

/// Deviations that were printed while the log was followed.
#[derive(Debug, Default)]
struct NewDeviations(usize);

impl NewDeviations {
    /// Prints the deviations since the last call, in text format.
    fn print(&mut self, monitor: &LogChecks<'_>, format: TextOrJson) -> anyhow::Result<()> {
        let fresh = monitor.monitor.found(self.0);
        self.0 += fresh.len();
        match format {
            TextOrJson::Text => text::as_they_come(fresh),
            TextOrJson::Json => Ok(()),
        }
    }
}

/// Reads a log as it grows. A pipe ends with its writer, a file with Ctrl-C.
fn follow(
    path: &Utf8Path,
    monitor: &mut LogChecks<'_>,
    format: TextOrJson,
    interrupt: &Interrupt,
) -> anyhow::Result<()> {
    let wrong = || format!("cannot read `{path}`");
    let mut file = if is_standard_input(path) { None } else { Some(open(path)?) };
    let is_file = file.as_ref().and_then(|file| file.metadata().ok());
    let is_file = is_file.is_some_and(|metadata| metadata.is_file());
    let mut piece = vec![0; CHUNK_BYTES];
    let mut lines = Lines::default();
    let mut told = NewDeviations::default();
    let mut place = 0u64;
    loop {
        let length = match &mut file {
            Some(file) => file.read(&mut piece),
            None => std::io::stdin().lock().read(&mut piece),
        };
        let length = match length {
            Ok(length) => length,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(error).with_context(wrong),
        };
        place += length as u64;
        let read = piece.get(..length).unwrap_or_default();
        lines.feed(read, |number, line| monitor.line(number, line, true));
        told.print(monitor, format)?;
        if interrupt.is_raised() {
            break;
        }
        if length > 0 {
            continue;
        }
        let Some(file) = file.as_mut().filter(|_| is_file) else {
            break;
        };
        // A restarted server has emptied the file.
        if file.metadata().with_context(wrong)?.len() < place {
            file.seek(SeekFrom::Start(0)).with_context(wrong)?;
            (place, lines) = (0, Lines::default());
        }
        std::thread::sleep(POLL_INTERVAL);
    }
    Ok(())
}

fn write_trace(path: &Utf8Path, bytes: &[u8]) -> anyhow::Result<()> {
    let wrong = || format!("cannot write `{path}`");
    let mut stream = Stream::create(path.as_std_path()).with_context(wrong)?;
    stream.write_all(bytes).with_context(wrong)?;
    stream.finish().with_context(wrong)
}

/// One document: an object for one log, a list for several.
fn print_json(title: &str, reports: &[LogReport]) -> anyhow::Result<()> {
    let mut documents = Vec::new();
    for LogReport { log, report, results } in reports {
        let mut document = serde_json::to_value(report)?;
        document["scenario"] = title.into();
        document["log"] = log.as_str().into();
        document["checks"] = results.json();
        document["not-checked"] = results.unshown_json();
        documents.push(document);
    }
    outputs::print_json(&outputs::one_or_all(documents))
}
