//! `dotgen trace import`: a trace of another tool over an exported model, as a run of the verified system.

use std::io::{Read as _, Write as _};

use anyhow::bail;
use camino::Utf8PathBuf;
use clap::Args;
use dotgen_export::{Goal, Imported, MAX_BYTES, import};
use dotgen_timing::explore::MomentKind;
use dotgen_timing::report::Event;
use dotgen_timing::verify::{Prepared, SystemInput};
use dotgen_views::verification::runs::Ending;

use crate::export::{Model, ModelOptions};
use crate::outputs::{self, Output, VIEWER};
use crate::trace::{self, RecordedRun};
use crate::verify::text;
use crate::{CommandExit, report, session, wcet};

/// Import a counterexample of UPPAAL or TChecker as a run of tasks and codels
///
/// TRACE is the text that `verifyta -t0` prints, or the graph of `tck-reach -C symbolic` or `-C concrete`.
/// The verifier performs the actions of the trace. Give FILE and the options of `dotgen export`: a trace of
/// another model is an error at its first line that does not fit. Without times in TRACE, the run has the
/// earliest ones.
///
/// Exit status: 0 if the trace is imported, 2 if not.
#[derive(Debug, Args)]
pub(in super::super) struct Arguments {
    /// The trace
    #[arg(value_name = "TRACE")]
    trace: Utf8PathBuf,

    /// Write the run for the trace viewer
    #[arg(long, short, value_name = "FILE.json")]
    output: Option<Utf8PathBuf>,

    #[command(flatten)]
    model: ModelOptions,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let path = &arguments.trace;
    let mut bytes = Vec::new();
    let read = wcet::open(path)?.take(MAX_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|error| wcet::unreadable(path, &error))?;
    let Ok(text) = String::from_utf8(bytes) else { bail!("`{path}` is not UTF-8") };
    let Some(model) = arguments.model.model()? else {
        return Ok(CommandExit::Unusable);
    };
    let written: Vec<Output> =
        (arguments.output.iter()).map(|path| Output { path, endings: &[VIEWER] }).collect();
    outputs::check(&written, model.problem.files().chain([path.as_path()]))?;
    let imported = import(&model.prepared, &text);
    let imported = imported.map_err(|error| anyhow::anyhow!("`{path}`: {error}"))?;
    let events = events(&model, &imported);
    print(&model.prepared, &imported, &events)?;
    if let Some(path) = &arguments.output {
        let recorded = RecordedRun {
            title: title(&model.prepared, &imported),
            unit: model.prepared.report.unit,
            events: &events,
            ending: ending(&model.prepared, imported.end.as_ref(), &events),
            cycle: None,
            notes: vec![SOURCE.replace("FORM", imported.form)],
        };
        trace::write(path, recorded, &model.problem, &model.options)?;
        report::note(&format!("wrote `{}`", session::display(path)));
    }
    Ok(CommandExit::Fine)
}

/// Note of a written run.
const SOURCE: &str = "a trace of FORM, replayed by the rules of the verifier";

/// Returns the run in words. If time passes until a check fails, the failure is an event.
fn events(model: &Model, imported: &Imported) -> Vec<Event> {
    let Model { problem, prepared, .. } = model;
    let mut events = prepared.told(&SystemInput { specs: problem.specs() }, &imported.run);
    let end = prepared.time(imported.run.end);
    if let Some(Goal { check, name, holds: false }) = &imported.end
        && let Some(last) = events.last().filter(|last| last.time < end)
    {
        let task = prepared.checks[*check].report.task.as_ref().unwrap_or(&last.thread);
        let what = format!("`{name}` fails: its limit is exceeded");
        events.push(Event::of_thread(end, task.clone(), MomentKind::Excess, what));
    }
    events
}

/// Says which check the end of the trace answers.
fn title(prepared: &Prepared, imported: &Imported) -> String {
    match &imported.end {
        Some(Goal { name, holds: false, .. }) => format!("reaches the failure of check `{name}`"),
        Some(Goal { name, holds: true, .. }) => format!("reaches the witness of check `{name}`"),
        None => format!("ends in no failure or witness of {}", prepared.report.scenario),
    }
}

/// Returns the end of a run: a missed deadline is not an event.
fn ending<'p>(prepared: &'p Prepared, end: Option<&Goal>, events: &[Event]) -> Ending<'p> {
    let says_so = events.last().is_some_and(|last| last.kind == MomentKind::Excess);
    let failed = end.filter(|goal| !goal.holds && !says_so);
    let task = failed.and_then(|goal| prepared.checks[goal.check].report.task.as_ref());
    task.map_or(Ending::Fine, Ending::Miss)
}

fn print(prepared: &Prepared, imported: &Imported, events: &[Event]) -> anyhow::Result<()> {
    let out = &mut anstream::AutoStream::auto(std::io::stdout().lock());
    let unit = prepared.report.unit;
    let Imported { form, transitions, run, has_times, notes, .. } = imported;
    let times = if *has_times { "its own times" } else { "the earliest times" };
    writeln!(
        out,
        "{}: a trace of {form}, {transitions} transitions, {} with {times}",
        prepared.report.scenario,
        unit.show(prepared.time(run.end))
    )?;
    writeln!(out, "{}", title(prepared, imported))?;
    text::run(out, events, None, unit, false)?;
    for note in notes {
        report::note(note);
    }
    Ok(())
}
