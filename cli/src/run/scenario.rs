//! The run of one scenario, and its files.

use camino::Utf8PathBuf;
use dotgen_runtime::report::RunReport;
use dotgen_timing::scn::names::Names;
use dotgen_timing::verify::{Interrupt, Options, settings};
use dotgen_views::verification::Problem;
use dotgen_views::verification::runs::Ending;
use dotgen_views::verification::summary;

use super::recorder::{Files, Recorder};
use super::{Answer, Arguments, Clock, Contents, Simulate, WrittenFile, bounds, execute};
use crate::outputs::PERFETTO;
use crate::report::TextOrJson;
use crate::session::{self, ErrorReporter, Session};
use crate::verify::diagnostics::ScenarioDiagnostics;
use crate::verify::{parsed, prepared};
use crate::{CommandExit, report, trace};

/// The end of the run of one scenario.
pub(super) enum Ended {
    Answered(Box<Answer>),
    /// The scenario has errors, which are printed.
    Unusable,
    /// The command ends.
    Stopped(CommandExit),
}

/// Runs one scenario.
pub(super) fn one(
    arguments: &Arguments,
    (session, problem): (&Session, Problem),
    (checks, interrupt): (&[&str], &Interrupt),
    trouble: &mut ErrorReporter,
) -> anyhow::Result<Ended> {
    if !problem.errors.is_empty() {
        ScenarioDiagnostics::about(session, &problem, problem.errors.clone())?.print()?;
        return Ok(Ended::Unusable);
    }
    let options = Options { checks: parsed(checks, &problem)?, ..arguments.system.options() };
    let is_text = arguments.format == TextOrJson::Text;
    let Some(prepared) = prepared(session, &problem, &options, checks, is_text)? else {
        return Ok(Ended::Unusable);
    };
    let source = (arguments.bounds, arguments.clock);
    let (mut bounds, proving) = bounds::at_once(source, &problem, &options, &prepared, interrupt);
    let measured = arguments.clock == Clock::Real && arguments.simulate == Simulate::Missing;
    let untimed = bounds::without_times(&prepared.built.system, &mut bounds, measured);
    let names = Names::new(&problem.specs());
    let paths = Paths::of(arguments);
    let mut files = Files::open(
        paths.log.map(camino::Utf8PathBuf::as_path),
        paths.perfetto.map(camino::Utf8PathBuf::as_path),
        paths.recording.map(camino::Utf8PathBuf::as_path),
        &names,
    )?;
    let context = execute::Context {
        session,
        problem: &problem,
        names: &names,
        options: &options,
        bounds,
        proving: proving.as_ref(),
        measured,
        interrupt,
    };
    let Some(mut run) = context.run_while_proving(arguments, prepared, &mut files)? else {
        return Ok(Ended::Stopped(if interrupt.is_raised() {
            report::note("interrupted before it ran");
            CommandExit::GaveUp
        } else {
            CommandExit::Unusable
        }));
    };
    run.report.notes.extend(untimed);
    let mut written = paths.finish(&mut run, files, trouble);
    if let (Some(path), Some(events)) = (paths.viewer, run.told) {
        let recorded = recorded(&run.report, &events);
        let steps = trouble.ok_or_report(trace::write(path, recorded, &problem, &options));
        let steps = steps.and_then(|step| u64::try_from(step).ok());
        written.extend(steps.map(|step| (path.clone(), step, Contents::Steps)));
    }
    let (executed_codels, simulated_codels) = run.executed;
    let answer = Answer {
        file: session::display(&problem.path),
        clock: arguments.clock,
        platform: summary::platform(&settings(&problem.scenario, &options)),
        executed_codels,
        simulated_codels,
        report: run.report,
        written,
    };
    Ok(Ended::Answered(Box::new(answer)))
}

/// The files that a run writes.
struct Paths<'a> {
    log: Option<&'a Utf8PathBuf>,
    perfetto: Option<&'a Utf8PathBuf>,
    /// Trace for the trace viewer.
    viewer: Option<&'a Utf8PathBuf>,
    recording: Option<&'a Utf8PathBuf>,
}

impl<'a> Paths<'a> {
    fn of(arguments: &'a Arguments) -> Self {
        let (perfetto, viewer) = (arguments.trace.iter())
            .partition::<Vec<_>, _>(|trace| trace.extension() == Some(PERFETTO));
        Paths {
            log: arguments.profile.as_ref(),
            perfetto: perfetto.first().copied(),
            viewer: viewer.first().copied(),
            recording: arguments.record.as_ref(),
        }
    }

    /// Ends the files of a run, and returns those that are whole. The run is reported even if its files could
    /// not be written.
    fn finish(
        &self,
        run: &mut execute::Run,
        files: Files,
        trouble: &mut ErrorReporter,
    ) -> Vec<WrittenFile> {
        let mut written = Vec::new();
        let messages = std::mem::replace(&mut run.messages, Ok(None));
        if let (Some(path), Some(recording_result)) =
            (self.recording, trouble.ok_or_report(messages).flatten())
        {
            if recording_result.whole {
                written.push((
                    path.clone(),
                    recording_result.data,
                    Contents::Messages(recording_result.steps),
                ));
            } else {
                trouble.told();
            }
        }
        let recorded = std::mem::replace(&mut run.lines, Ok(0)).and_then(|lines| {
            let whole = files.runs.map(Recorder::finish).transpose()?;
            Ok((lines, whole))
        });
        if let Some((lines, Some(whole))) = trouble.ok_or_report(recorded.map_err(Into::into)) {
            let files = [
                (self.log, whole.log, Contents::Lines),
                (self.perfetto, whole.trace, Contents::Codels),
            ];
            for (path, whole, of) in files {
                match (path, whole) {
                    (Some(path), true) => written.push((path.clone(), lines, of)),
                    (Some(_), false) => trouble.told(),
                    (None, _) => {}
                }
            }
        }
        written
    }
}

/// Returns the first run, for the trace viewer.
fn recorded<'e>(report: &RunReport, run: &'e execute::RunEvents) -> trace::RecordedRun<'e> {
    trace::RecordedRun {
        title: format!("a run of {}, seed {}", report.scenario, report.seed),
        unit: report.unit,
        events: &run.events,
        ending: Ending::Fine,
        cycle: None,
        notes: if run.left_out {
            vec!["the run goes on, but not here: it is too long".to_owned()]
        } else {
            Vec::new()
        },
    }
}
