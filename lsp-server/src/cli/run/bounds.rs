//! Bounds on response times, for a run to be compared with.

use clap::ValueEnum;
use dotgen_runtime::counted::{has_times, untimed};
use dotgen_timing::analytic::response_bounds;
use dotgen_timing::explore::Limits;
use dotgen_timing::property::PropertyKind;
use dotgen_timing::report::{Value, Verdict};
use dotgen_timing::scn::parse_check;
use dotgen_timing::system::{Ticks, TimedSystem};
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

/// Drops bounds that say nothing because codels have no execution time: of tasks without any; if times are
/// measured, of all tasks, because codels delay each other. Returns a note on codels without a time.
pub(in crate::cli) fn without_times(
    system: &TimedSystem,
    bounds: &mut [Option<Ticks>],
    measured: bool,
) -> Option<String> {
    let untimed = untimed(system);
    for (task, bound) in bounds.iter_mut().enumerate() {
        let is_unknown = measured && !untimed.is_empty();
        if is_unknown || !has_times(system, task) {
            *bound = None;
        }
    }
    let all = system.codels.iter().filter(|it| it.site.is_some());
    let none_has = all.clone().next().is_some() && all.clone().all(|it| it.upper == 0);
    let names = || match untimed.len() {
        n if n > NAMED => format!("{} and {} more", untimed[..NAMED].join(", "), n - NAMED),
        _ => untimed.join(", "),
    };
    match (measured, none_has) {
        _ if untimed.is_empty() => None,
        (false, true) => Some(
            "no execution times: this run shows the order of codels, not their timing; measure with `dotgen \
             run --clock real --profile FILE` and `dotgen wcet import`, or write `wcet`"
                .to_owned(),
        ),
        (false, false) => Some(format!("no execution time, taken as 0: {}", names())),
        (true, _) => Some(format!("no bounds, because no execution time: {}", names())),
    }
}

/// More codels without a time are counted only.
const NAMED: usize = 10;
