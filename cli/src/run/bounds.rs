//! Bounds on response times, to compare a run with.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use clap::ValueEnum;
use dotgen_runtime::counts::{codels_without_time, has_times};
use dotgen_timing::analytic::response_bounds;
use dotgen_timing::explore::Limits;
use dotgen_timing::property::PropertyKind;
use dotgen_timing::report::{Value, Verdict};
use dotgen_timing::scn::parse_check;
use dotgen_timing::system::indexed::DeclaredTask;
use dotgen_timing::system::{Ticks, TimedSystem};
use dotgen_timing::verify::{Cancel, Interrupt, Options, Prepared};

use super::Clock;
use dotgen_views::verification::Problem;

/// Sources of bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Source {
    /// Response-time analysis, lowered by a short verification
    Proved,
    /// Response-time analysis
    Analysed,
    /// No bounds
    None,
}

/// Maximum number of states of the verification during a run.
pub(super) const STATES: usize = 200_000;

/// Maximum number of states of the verification before a run, which the run waits for.
const MAX_STATES_BEFORE_RUN: usize = 1_000;

/// Returns the bounds, by task; `None` if no bound is known.
pub(crate) fn of_tasks(
    source: Source,
    problem: &Problem,
    options: &Options,
    prepared: &Prepared,
    interrupt: &Interrupt,
) -> Vec<Option<Ticks>> {
    let mut bounds = analysed(source, &prepared.built.system, interrupt);
    if source == Source::Proved {
        let proving = BoundVerification::new(prepared);
        proving.prove(problem, options, STATES, &Cancel::interrupted_by(interrupt));
        proving.add_to(&mut bounds);
    }
    bounds
}

/// Returns the bounds that are known at once, as [`of_tasks`] does. On the real clock, also returns the
/// verification that may prove more of them. On the virtual clock there is none, because a report must not
/// depend on the speed of the machine.
pub(super) fn at_once(
    (source, clock): (Source, Clock),
    problem: &Problem,
    options: &Options,
    prepared: &Prepared,
    interrupt: &Interrupt,
) -> (Vec<Option<Ticks>>, Option<BoundVerification>) {
    let mut bounds = analysed(source, &prepared.built.system, interrupt);
    if source != Source::Proved {
        return (bounds, None);
    }
    let proving = BoundVerification::new(prepared);
    let cancel = Cancel::interrupted_by(interrupt);
    proving.prove(problem, options, MAX_STATES_BEFORE_RUN, &cancel);
    proving.add_to(&mut bounds);
    let left = clock == Clock::Real && !proving.is_done();
    (bounds, left.then_some(proving))
}

fn analysed(source: Source, system: &TimedSystem, interrupt: &Interrupt) -> Vec<Option<Ticks>> {
    match source {
        Source::None => vec![None; system.tasks.len()],
        Source::Proved | Source::Analysed => {
            response_bounds(system, &Cancel::interrupted_by(interrupt)).raw
        }
    }
}

/// A verification of response times.
pub(super) struct BoundVerification {
    /// Tasks by component and number, as in the report.
    tasks: HashMap<DeclaredTask, usize>,
    /// A base unit, in the unit of the report.
    tick: f64,
    /// The proved bounds, by task; `None` before the verification has ended.
    proved: Mutex<Option<Answers>>,
}

#[derive(Default)]
struct Answers {
    bounds: Vec<(usize, Ticks)>,
    given_up: bool,
}

impl BoundVerification {
    fn new(prepared: &Prepared) -> BoundVerification {
        BoundVerification {
            tasks: (prepared.built.tasks.iter())
                .map(|(&task, &id)| (task, usize::from(id)))
                .collect(),
            tick: prepared.time(1),
            proved: Mutex::default(),
        }
    }

    /// Verifies within this number of states.
    pub(super) fn prove(
        &self,
        problem: &Problem,
        options: &Options,
        states: usize,
        cancel: &Cancel,
    ) {
        let Ok(checks) = parse_check("response *") else {
            return;
        };
        let options =
            Options { checks, limits: Limits { states, ..options.limits }, ..options.clone() };
        let report = problem.verify(&options, cancel, &|_| {});
        let mut answers = Answers::default();
        for check in &report.checks {
            answers.given_up |= check.verdict == Verdict::Unknown;
            // A bound that rests on a missing time or interface is not proved.
            let proved = check.verdict.holds() && check.conditions.is_empty();
            let known = proved && check.kind == PropertyKind::Response;
            let task = check.id.task.and_then(|task| self.tasks.get(&task));
            if let (true, Some(&task), Some(Value::Time(time))) = (known, task, check.value) {
                let ticks = (time / self.tick).round() as Ticks;
                answers.bounds.push((task, ticks));
            }
        }
        if !cancel.is_abandoned() {
            *self.proved() = Some(answers);
        }
    }

    /// Returns true if every response time was answered.
    fn is_done(&self) -> bool {
        self.proved().as_ref().is_some_and(|answers| !answers.given_up)
    }

    /// Starts again: earlier results are dropped.
    pub(super) fn reset(&self) {
        *self.proved() = None;
    }

    /// Lowers bounds to the proved ones. Returns false if the verification has not ended.
    pub(super) fn add_to(&self, bounds: &mut [Option<Ticks>]) -> bool {
        let proved = self.proved();
        let Some(answers) = proved.as_ref() else {
            return false;
        };
        for &(task, ticks) in &answers.bounds {
            bounds[task] = Some(bounds[task].map_or(ticks, |bound| bound.min(ticks)));
        }
        true
    }

    fn proved(&self) -> MutexGuard<'_, Option<Answers>> {
        self.proved.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Drops bounds that are meaningless because codels have no execution time: of tasks without any; if times
/// are measured, of all tasks, because codels delay each other. Returns a note on codels without a time.
pub(crate) fn without_times(
    system: &TimedSystem,
    bounds: &mut [Option<Ticks>],
    measured: bool,
) -> Option<String> {
    let codels_without_time = codels_without_time(system);
    for (task, bound) in bounds.iter_mut().enumerate() {
        let is_unknown = measured && !codels_without_time.is_empty();
        if is_unknown || !has_times(system, task) {
            *bound = None;
        }
    }
    let all = system.codels.iter().filter(|codel| codel.site.is_some());
    let none_has = all.clone().next().is_some() && all.clone().all(|codel| codel.upper == 0);
    let names = || match codels_without_time.len() {
        n if n > NAMED => {
            format!("{} and {} more", codels_without_time[..NAMED].join(", "), n - NAMED)
        }
        _ => codels_without_time.join(", "),
    };
    match (measured, none_has) {
        _ if codels_without_time.is_empty() => None,
        (false, true) => Some(
            "no execution times: this run shows the order of codels, not their timing; measure with `dotgen \
             run --clock real --profile FILE` and `dotgen wcet import`, or write `wcet`"
                .to_owned(),
        ),
        (false, false) => Some(format!("no execution time, taken as 0: {}", names())),
        (true, _) => Some(format!("no bounds, because no execution time: {}", names())),
    }
}

/// Maximum number of codels in the note. Further ones are only counted.
const NAMED: usize = 10;
