//! Bounds on response times, for a run to be compared with.

use clap::ValueEnum;
use dotgen_timing::analytic::response_bounds;
use dotgen_timing::explore::Limits;
use dotgen_timing::property::PropertyKind;
use dotgen_timing::report::{Value, Verdict};
use dotgen_timing::scn::parse_check;
use dotgen_timing::system::Ticks;
use dotgen_timing::verify::{Cancel, Interrupt, Options, Prepared};

use crate::verification::Problem;

/// Sources of bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Source {
    /// Verification if it is quick, else response-time analysis
    Proved,
    /// Response-time analysis
    Analysed,
    /// No bounds
    None,
}

/// What is given up at this number of states would keep people waiting before anything runs.
const STATES: usize = 200_000;

/// By task; `None` where no bound is known.
pub(in crate::cli) fn of_tasks(
    source: Source,
    problem: &Problem,
    options: &Options,
    prepared: &Prepared,
    interrupt: &Interrupt,
) -> Vec<Option<Ticks>> {
    let system = &prepared.built.system;
    let mut bounds = match source {
        Source::None => return vec![None; system.tasks.len()],
        Source::Proved | Source::Analysed => response_bounds(system),
    };
    let Ok(check) = parse_check("response *") else {
        return bounds;
    };
    if source == Source::Analysed {
        return bounds;
    }
    let options = Options {
        checks: vec![check],
        limits: Limits {
            states: STATES,
            ..options.limits
        },
        ..options.clone()
    };
    let report = problem.verify(&options, &Cancel::interrupted_by(interrupt), &|_| {});
    for it in &report.checks {
        let known = it.verdict == Verdict::Proved && it.kind == PropertyKind::Response;
        let task = it.id.task.and_then(|it| prepared.built.tasks.get(&it));
        if let (true, Some(&task), Some(Value::Time(time))) = (known, task, it.value) {
            let ticks = (time / prepared.time(1)).round() as Ticks;
            bounds[task] = Some(bounds[task].map_or(ticks, |it| it.min(ticks)));
        }
    }
    bounds
}
