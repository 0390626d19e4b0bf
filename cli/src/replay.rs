//! `dotgen replay`

mod checks;

use std::io::Write;

use anyhow::bail;
use camino::Utf8PathBuf;
use clap::Args;
use dotgen_analysis::terminal;
use dotgen_recording::record;
use dotgen_recording::replay::{
    Difference, DifferenceKind, ReplayReport, Step, with_any_exception,
};
use dotgen_runtime::refine;
use dotgen_timing::system::ClientId;
use dotgen_timing::verify::Prepared;

use self::checks::RecordedChecks;
use super::outputs::{self, MCAP};
use super::report::TextOrJson;
use super::system_options::SystemOptions;
use super::verify::{one_problem, prepared, title};
use super::wcet::unreadable;
use super::{CommandExit, SpecificationOptions, report};

/// Compare a recorded run step by step with the verified model
///
/// FILE.mcap is a recording of `dotgen run --record`; the other FILEs are its scenario or its specifications.
/// Each step must be possible in the model at that moment. If a step is not possible, the violated rule is
/// printed. Undeclared execution times and exceptions of codels are reported, and the comparison goes on.
///
/// The checks of the scenario are answered for the recorded run, also those that compare data of ports.
///
/// A damaged recording is compared up to the damage.
///
/// Exit status: 0 if the recording is a run of the model, 1 if not, or if a codel violates its declaration or
/// a check is violated, 2 if the recording is damaged or nothing could be compared.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A recording (.mcap), and a scenario (.scn) or specifications (.gen)
    #[arg(value_name = "FILE", required = true)]
    files: Vec<Utf8PathBuf>,

    #[command(flatten)]
    system: SystemOptions,

    /// Output format
    #[arg(long, value_enum, default_value_t = TextOrJson::Text)]
    format: TextOrJson,

    #[command(flatten)]
    reading: SpecificationOptions,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let is_recording = |path: &&Utf8PathBuf| path.extension() == Some(MCAP);
    let (recordings, texts): (Vec<_>, Vec<_>) = arguments.files.iter().partition(is_recording);
    let [path] = recordings[..] else {
        bail!("name one recording (.mcap): `dotgen run --record FILE.mcap` writes it");
    };
    if texts.is_empty() {
        bail!("name the scenario (.scn) of the run, or its specification (.gen)");
    }
    let texts: Vec<Utf8PathBuf> = texts.into_iter().cloned().collect();
    let bytes = std::fs::read(path).map_err(|error| unreadable(path, &error))?;
    let recorded = record::read(&bytes).map_err(|error| anyhow::anyhow!("`{path}`: {error}"))?;
    let damaged = recorded.broken.as_ref().and_then(|broken| broken.damaged);
    if let Some(broken) = &recorded.broken {
        let steps = recorded.steps.len();
        report::note(&match damaged {
            Some(_) => format!("`{path}` is {broken}; only the {steps} steps before are compared"),
            None => format!(
                "`{path}` breaks off after step {steps} ({broken}): its run was killed, found no room, or \
                 goes on"
            ),
        });
    }
    let Some((session, problem)) = one_problem(&texts, &arguments.reading)? else {
        return Ok(CommandExit::Unusable);
    };
    let options = arguments.system.options();
    let Some(mut prepared) = prepared(&session, &problem, &options, &[], false)? else {
        return Ok(CommandExit::Unusable);
    };
    let default = !problem.is_written();
    let outside = with_environment(&mut prepared, &recorded.about, default);
    let verified = &prepared.built.system;
    if verified.unit.to_string() != recorded.about.unit {
        bail!(
            "`{path}` counts time in units of {} s, the model in units of {} s: it is a run of another \
                scenario",
            recorded.about.unit,
            verified.unit
        );
    }
    let system = with_any_exception(verified);
    let recorded_checks = RecordedChecks::read(&prepared, &bytes)?;
    let (report, judge) = recorded_checks.replay(&system, outside, &recorded);
    let checks = recorded_checks.results(&judge, recorded.about.simulated);
    for note in &prepared.report.notes {
        report::note(note);
    }
    let title = title(&problem);
    match arguments.format {
        TextOrJson::Text => {
            print_text(&title, &recorded.about.scenario, &prepared, &report, damaged)?;
            recorded_checks.print(&checks, report.followed == report.steps && damaged.is_none())?;
        }
        TextOrJson::Json => {
            let mut document = serde_json::to_value(&report)?;
            document["scenario"] = title.into();
            document["recording"] = path.as_str().into();
            document["unit"] = recorded.about.unit.into();
            document["clock"] = recorded.about.clock.into();
            document["breaks-off"] = recorded.broken.is_some().into();
            if !checks.is_empty() {
                document["checks"] = RecordedChecks::json(&checks, &judge);
            }
            if let Some(at) = damaged {
                document["damaged-at"] = at.into();
            }
            outputs::print_json(&document)?;
        }
    }
    Ok(match report.difference_count {
        _ if damaged.is_some() => CommandExit::Unusable,
        0 if checks.iter().all(|check| check.violations == 0) => CommandExit::Fine,
        _ => CommandExit::Errors,
    })
}

/// Adds the environment of the recorded run to a model: units of the real clock, and clients for requests
/// from outside. Returns the first of these clients.
fn with_environment(
    prepared: &mut Prepared,
    about: &record::RunInfo,
    without_clients: bool,
) -> Option<ClientId> {
    if !about.outside {
        return None;
    }
    refine::scale(prepared);
    if without_clients {
        prepared.built.system.clients.clear();
    }
    Some(refine::add_outside(prepared))
}

fn print_text(
    title: &str,
    recorded: &str,
    prepared: &Prepared,
    report: &ReplayReport,
    damaged: Option<usize>,
) -> anyhow::Result<()> {
    let mut out = anstream::AutoStream::auto(std::io::stdout().lock());
    let time = |units: u64| {
        let seconds = prepared.built.system.unit * num_rational::Ratio::from_integer(units.into());
        let nanos: i128 = (seconds * num_rational::Ratio::from_integer(1_000_000_000)).to_integer();
        format!("{}.{:06} s", nanos / 1_000_000_000, nanos % 1_000_000_000 / 1_000)
    };
    if title != recorded {
        let recorded = terminal::text(recorded);
        writeln!(out, "note: this is the recording of a run of {recorded}")?;
    }
    let from_outside = match report.from_outside {
        0 => String::new(),
        count => format!(", {count} of them from outside, which no client of the scenario does"),
    };
    writeln!(
        out,
        "{}: {} of {} steps followed, {}{from_outside}",
        terminal::text(title),
        report.followed,
        report.steps,
        time(report.time)
    )?;
    for difference in &report.differences {
        let what = differs(difference, &time);
        let step = terminal::text(&difference.step.describe()).into_owned();
        writeln!(out, "\nstep {}, at {}: {step}", difference.number, time(difference.step.time))?;
        writeln!(out, "  {}", terminal::text(&what))?;
        writeln!(out, "  the rule: {}", difference.rule.describe())?;
    }
    let more = report.difference_count - report.differences.len() as u64;
    if more > 0 {
        writeln!(out, "\n{more} more differences")?;
    }
    if let Some(at) = damaged {
        let what = match report.difference_count {
            0 if report.steps == 0 => "no step before can be compared",
            0 => "the steps before are steps of the model",
            _ => "the steps before already differ from the model",
        };
        writeln!(out, "damaged at byte {at}; {what}")?;
        return Ok(());
    }
    match report.difference_count {
        0 => writeln!(out, "it is a run of the model")?,
        1 if report.violation_count == 1 => {
            writeln!(out, "\n1 violation by a codel; all other steps follow the model")?;
        }
        count if report.violation_count == count => {
            writeln!(out, "\n{count} violations by codels; all other steps follow the model")?;
        }
        _ if report.followed < report.steps => writeln!(
            out,
            "\nit is not a run of the model; it was not followed after the last difference"
        )?,
        _ => writeln!(out, "\nit is not a run of the model")?,
    }
    Ok(())
}

/// Describes a difference.
fn differs(difference: &Difference, time: &dyn Fn(u64) -> String) -> String {
    match &difference.what {
        DifferenceKind::Longer { took, limit } => {
            format!("took {}, and may take {}", time(*took), time(u64::from(*limit)))
        }
        DifferenceKind::Shorter { took, limit } => {
            format!("took {}, and takes at least {}", time(*took), time(u64::from(*limit)))
        }
        DifferenceKind::Undeclared => "an exception that is not declared".to_owned(),
        DifferenceKind::Impossible { possible } if possible.is_empty() => {
            "is not possible there: nothing but time can pass".to_owned()
        }
        DifferenceKind::Impossible { possible } => {
            let all: Vec<String> = possible.iter().map(Step::describe).collect();
            format!("is not possible there; this is: {}", all.join(", or "))
        }
        DifferenceKind::Omitted { due } => format!("before it has to come: {}", due.describe()),
        DifferenceKind::Backwards => "goes back in time".to_owned(),
    }
}
