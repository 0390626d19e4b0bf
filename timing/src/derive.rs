//! Questions answered by verifying variations of a system: the fewest cores, the slack of times.
//!
//! Each question asks only for `schedulable`, of the tasks that the checks of the scenario name, or of all
//! tasks if they name none. A value with which a task is never released, because a start-up never completes,
//! fails. Every value reported was verified itself. The largest WCET is exact when durations are intervals,
//! because a larger upper bound only adds behaviour. Smallest periods and fixed durations are not monotonic,
//! and the result says so.

mod sensitivity;

use dotgen_analysis::model::Seconds;
use num_rational::Ratio;
use serde::Serialize;

use crate::diagnostic::Diagnostic;
use crate::explore::Limits;
use crate::limit::{Grid, Phase};
use crate::property::resolve;
use crate::report::{TimeUnit, Value, Verdict};
use crate::scn::ast::{Check, CheckKind, Durations, Path, Scenario};
use crate::scn::names::{Names, Target};
use crate::system::build::build;
use crate::system::indexed::not_a;
use crate::system::settings::Settings;
use crate::verify::{Cancel, Options, SystemInput, errors, settings, verify_until_failure};
pub use sensitivity::{InterimResult, NextToBreak, Progress, Quantity, Sensitivity, sensitivity};

/// Returns the checks of the deadlines that limits concern: those of the scenario, or else those of all
/// tasks.
pub fn deadlines(settings: &Settings) -> Vec<Check> {
    let checks = settings.checks.iter();
    let mut out: Vec<Check> =
        checks.filter(|check| matches!(check.kind, CheckKind::Schedulable(_))).cloned().collect();
    if out.is_empty() {
        let kind = CheckKind::Schedulable(None);
        out.push(Check { name: None, subject: None, kind, range: 0..0 });
    }
    out
}

/// Greatest number of verifications that run at the same time. Each has this part of the memory, so that
/// answers do not depend on the number of threads.
const MAX_TOGETHER: usize = 16;

/// Part of the states that each verification may have: a question needs many of them.
const SHARE_OF_STATES: usize = 20;

/// Limit on the actions of each verification.
const MAX_STEPS: u64 = 20_000_000;

/// Part of the time limit that each verification may take, so that no value keeps all others from being
/// tried.
const SHARE_OF_TIME: u32 = 10;

/// The fewest cores that suffice.
#[derive(Debug, Clone, Serialize)]
pub struct MinimumCores {
    /// The smallest number of cores with which all tasks asked about are schedulable.
    pub cores: Option<u32>,
    /// The verdict for each number of cores that was tried, in ascending order.
    pub tried: Vec<(u32, Verdict)>,
}

/// The answer to a question for the largest or smallest value of a parameter.
#[derive(Debug, Clone, Serialize)]
pub struct Extreme {
    /// Name of the codel or task.
    pub of: String,
    /// Its present value, in the unit of the report.
    pub now: Value,
    /// The present value is known to fail: the extreme is a value that would hold instead.
    #[serde(rename = "fails-now", skip_serializing_if = "std::ops::Not::not")]
    pub fails_now: bool,
    /// The extreme value found: the largest WCET or the smallest period. `None`: no value that was tried
    /// holds. [`Value::Unbounded`]: no upper bound was found up to the longest period.
    pub extreme: Option<Value>,
    /// Values beyond the extreme are known to fail.
    pub exact: bool,
    /// Some verification was given up: the extreme may be further out.
    pub incomplete: bool,
    /// Distance of the times that were tried, in the unit of the report: the limit is less than that beyond
    /// the extreme, if it is exact.
    pub resolution: f64,
}

/// The parameter that a question varies.
enum Parameter {
    Cores,
    Wcet(Path),
    Period(Path),
}

enum DerivedValue {
    Cores(MinimumCores),
    Wcet(Extreme),
    Period(Extreme),
}

impl Parameter {
    fn describe(&self) -> String {
        match self {
            Parameter::Cores => "the number of cores".to_owned(),
            Parameter::Wcet(path) => format!("the WCET of {}", path.text()),
            Parameter::Period(path) => format!("the period of {}", path.text()),
        }
    }
}

/// Finds the smallest number of cores with which the tasks are schedulable.
pub fn minimum_cores(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    cancel: &Cancel,
) -> Result<MinimumCores, Vec<Diagnostic>> {
    DerivationContext::of(1, &Names::new(&input.specs), scenario, options, cancel).minimum_cores()
}

/// Finds the largest WCET of a codel (`component.task.state`, …) with which the tasks are schedulable.
pub fn largest_wcet(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    codel: &Path,
    cancel: &Cancel,
) -> Result<Extreme, Vec<Diagnostic>> {
    DerivationContext::of(1, &Names::new(&input.specs), scenario, options, cancel)
        .largest_wcet(codel)
}

/// Finds, by bisection, the smallest period of a task with which the tasks are schedulable.
pub fn smallest_period(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    task: &Path,
    cancel: &Cancel,
) -> Result<Extreme, Vec<Diagnostic>> {
    DerivationContext::of(1, &Names::new(&input.specs), scenario, options, cancel)
        .smallest_period(task)
}

/// The tasks that must stay schedulable, and the effort for each verification.
struct DerivationContext<'a> {
    names: &'a Names<'a>,
    scenario: &'a Scenario,
    options: &'a Options,
    cancel: &'a Cancel,
    /// Number of verifications that run at the same time.
    together: usize,
    /// Limits of each verification.
    share: Limits,
}

impl<'a> DerivationContext<'a> {
    fn of(
        questions: usize,
        names: &'a Names<'a>,
        scenario: &'a Scenario,
        options: &'a Options,
        cancel: &'a Cancel,
    ) -> Self {
        let limits = options.limits;
        DerivationContext {
            names,
            scenario,
            options,
            cancel,
            together: limits.threads.clamp(1, questions.clamp(1, MAX_TOGETHER)),
            share: Limits {
                states: limits.states / SHARE_OF_STATES,
                steps: limits.steps.min(MAX_STEPS),
                bytes: limits.bytes / MAX_TOGETHER,
                ..limits
            },
        }
    }

    fn one(&self, question: &Parameter) -> Result<DerivedValue, Vec<Diagnostic>> {
        Ok(match question {
            Parameter::Cores => DerivedValue::Cores(self.minimum_cores()?),
            Parameter::Wcet(codel) => DerivedValue::Wcet(self.largest_wcet(codel)?),
            Parameter::Period(task) => DerivedValue::Period(self.smallest_period(task)?),
        })
    }

    fn minimum_cores(&self) -> Result<MinimumCores, Vec<Diagnostic>> {
        let mut variation = Variation::new(self)?;
        variation.settings.cores = None;
        let most = build(self.names, &variation.settings, &|_| true).system.tasks.len() as u32;
        let mut out = MinimumCores { cores: None, tried: Vec::new() };
        for cores in 1..=most.max(1) {
            if self.cancel.is_over() {
                break;
            }
            variation.settings.cores = Some(cores);
            let verdict = variation.schedulable(Phase::Units);
            out.tried.push((cores, verdict));
            if verdict == Verdict::Proved {
                out.cores = Some(cores);
                break;
            }
        }
        Ok(out)
    }

    fn largest_wcet(&self, codel: &Path) -> Result<Extreme, Vec<Diagnostic>> {
        let mut variation = Variation::new(self)?;
        let target = self.names.resolve(codel).map_err(|error| vec![error])?;
        if !matches!(target, Target::State(..) | Target::Codel(..)) {
            return Err(vec![not_a("codel", codel)]);
        }
        let built = build(self.names, &variation.settings, &|_| true);
        let path = codel.text();
        let unit = built.system.unit;
        let current = built.system.codels.iter().find(|codel| {
            *codel.path == *path
                || codel.site.is_some_and(|site| same_codel(&target, site, &codel.path, &path))
        });
        let Some(current) = current else {
            return Err(vec![not_a("codel that is executed", codel)]);
        };
        let longest = built.system.tasks.iter().filter_map(|task| task.period).max().unwrap_or(1);
        let grid =
            Grid::of(&variation.settings, unit, unit * Ratio::from_integer(i128::from(longest)));
        let mut holds = |time: Seconds, phase| {
            variation.settings.upper_bound = Some((codel.clone(), time));
            variation.schedulable(phase)
        };
        let report_unit = TimeUnit::of(&Settings::new(self.scenario));
        let value = |steps: u32| Value::Time(report_unit.from_seconds(grid.time(steps)));
        let endless = current.upper == crate::system::FOREVER;
        let start = if endless { 0 } else { grid.steps(current.upper) };
        let mut out = Extreme {
            of: path,
            now: if endless { Value::Unbounded } else { value(start) },
            fails_now: false,
            extreme: None,
            exact: settings(self.scenario, self.options).durations != Durations::Fixed,
            incomplete: false,
            resolution: report_unit.from_seconds(grid.step),
        };
        let verdict = holds(grid.time(start), Phase::Units);
        if !verdict.holds() {
            out.fails_now = verdict == Verdict::Refuted;
            out.incomplete = verdict == Verdict::Unknown;
            // Downwards: an execution time is at least the lower limit of its interval, and never zero.
            let least = if out.exact { grid.steps(current.lower).max(1) } else { 1 };
            if verdict == Verdict::Refuted && least < start {
                match holds(grid.time(least), Phase::Units) {
                    verdict if verdict.holds() => out.found(grid, least, start, holds, value),
                    verdict => out.incomplete = verdict == Verdict::Unknown,
                }
            }
            return Ok(out);
        }
        // Double the value until it fails, then bisect.
        let (mut good, mut bad) = (start, None);
        let mut step = grid.steps((longest / 16).max(1));
        while good < grid.steps(longest.saturating_mul(2)) {
            match holds(grid.time(good + step), Phase::Units) {
                verdict if verdict.holds() => good += step,
                verdict => {
                    out.incomplete |= verdict == Verdict::Unknown;
                    bad = Some(good + step);
                    break;
                }
            }
            step = step.saturating_mul(2);
        }
        if let Some(bad) = bad {
            out.found(grid, good, bad, holds, value);
        } else {
            out.extreme = Some(Value::Unbounded);
            out.exact = false;
        }
        Ok(out)
    }

    fn smallest_period(&self, task: &Path) -> Result<Extreme, Vec<Diagnostic>> {
        let mut variation = Variation::new(self)?;
        let key = resolve::task(self.names, task).map_err(|error| vec![error])?;
        let built = build(self.names, &variation.settings, &|_| true);
        let unit = built.system.unit;
        let Some(period) = built.system.tasks[built.tasks[&key]].period else {
            return Err(vec![not_a("periodic task", task)]);
        };
        let grid =
            Grid::of(&variation.settings, unit, unit * Ratio::from_integer(i128::from(period)));
        let mut holds = |time: Seconds, phase| {
            variation.settings.period = Some((task.clone(), time));
            variation.schedulable(phase)
        };
        let report_unit = TimeUnit::of(&Settings::new(self.scenario));
        let value = |steps: u32| Value::Time(report_unit.from_seconds(grid.time(steps)));
        let now = grid.steps(period);
        let mut out = Extreme {
            of: task.text(),
            now: value(now),
            fails_now: false,
            extreme: None,
            exact: false,
            incomplete: false,
            resolution: report_unit.from_seconds(grid.step),
        };
        let verdict = holds(grid.time(now), Phase::Units);
        if verdict.holds() {
            out.found(grid, now, 0, holds, value);
        } else {
            out.fails_now = verdict == Verdict::Refuted;
            out.incomplete = verdict == Verdict::Unknown;
            if verdict == Verdict::Refuted
                && let Some((longer, fails)) = longer(grid, now, &mut holds, &mut out.incomplete)
            {
                out.found(grid, longer, fails, holds, value);
            }
        }
        out.exact = false;
        Ok(out)
    }
}

impl Extreme {
    /// Sets the extreme to the last value that holds, between one that holds and one that does not.
    fn found(
        &mut self,
        grid: Grid,
        good: u32,
        bad: u32,
        holds: impl FnMut(Seconds, Phase) -> Verdict,
        value: impl Fn(u32) -> Value,
    ) {
        let last = grid.last(good, bad, holds);
        self.extreme = Some(value(last.steps));
        self.incomplete |= last.given_up;
        self.exact &= !self.incomplete;
        self.resolution *= f64::from(last.resolution);
    }
}

/// Finds a period of up to eight times the present one that holds, and a shorter one that does not hold.
fn longer(
    grid: Grid,
    period: u32,
    holds: &mut impl FnMut(Seconds, Phase) -> Verdict,
    incomplete: &mut bool,
) -> Option<(u32, u32)> {
    let mut fails = period;
    for times in [2, 4, 8] {
        let longer = period.checked_mul(times)?;
        match holds(grid.time(longer), Phase::Units) {
            verdict if verdict.holds() => return Some((longer, fails)),
            verdict => *incomplete |= verdict == Verdict::Unknown,
        }
        fails = longer;
    }
    None
}

fn same_codel(
    target: &Target,
    (c, codel): (usize, dotgen_analysis::model::CodelRef),
    path: &str,
    wanted: &str,
) -> bool {
    match target {
        Target::Codel(a, s, index) => {
            (*a, *index) == (c, codel.index)
                && codel.owner == dotgen_analysis::model::Owner::Service(*s)
        }
        _ => path == wanted,
    }
}

/// The settings to vary, with a check of each task that must stay schedulable.
struct Variation<'v> {
    asked: &'v DerivationContext<'v>,
    settings: Settings,
}

impl<'v> Variation<'v> {
    fn new(asked: &'v DerivationContext<'v>) -> Result<Self, Vec<Diagnostic>> {
        let mut settings = settings(asked.scenario, asked.options);
        settings.checks = deadlines(&settings);
        let errors = errors(asked.names, &settings);
        if errors.is_empty() { Ok(Variation { asked, settings }) } else { Err(errors) }
    }

    /// Verifies the tasks.
    fn schedulable(&self, phase: Phase) -> Verdict {
        let asked = self.asked;
        if asked.cancel.is_over() {
            return Verdict::Unknown;
        }
        let part = asked.cancel.time_limit().map(|limit| asked.cancel.part(limit / SHARE_OF_TIME));
        let cancel = part.as_ref().unwrap_or(asked.cancel);
        let limits = Limits { states: asked.share.states.min(phase.states()), ..asked.share };
        let report = verify_until_failure(asked.names, &self.settings, limits, cancel);
        let verdicts = report.checks.iter().map(|check| check.verdict);
        // A task without times or jobs says nothing about the others. Where no job is ever released, the
        // deadlines are kept for that reason only.
        let mut verdicts = verdicts.filter(|&verdict| verdict != Verdict::Nothing).peekable();
        if report.has_errors() || verdicts.peek().is_none() {
            Verdict::Unknown
        } else if verdicts.clone().any(|of| matches!(of, Verdict::Refuted | Verdict::Vacuous)) {
            Verdict::Refuted
        } else if verdicts.all(Verdict::holds) {
            Verdict::Proved
        } else {
            Verdict::Unknown
        }
    }
}
