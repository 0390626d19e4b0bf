//! Questions that are answered by verifying variations: how many cores, how much slack.
//!
//! Only `schedulable` is asked, of the tasks that the checks of the scenario name (all of them if none
//! does). Every value reported was verified itself. The largest WCET is exact when durations are
//! intervals, as a larger upper bound only adds behaviour; smallest periods and fixed durations are
//! not monotonic, and the result says so.

use dotgen_analysis::model::Seconds;
use num_rational::Ratio;
use serde::Serialize;

use crate::analytic::{meets_deadlines, response_bounds};
use crate::explore::Stop;
use crate::explore::{Watch, explore};
use crate::property::resolve;
use crate::report::{Value, Verdict};
use crate::scn::ast::{CheckKind, Durations, Path, Scenario, Unit};
use crate::scn::names::{Names, Target};
use crate::scn::{Diagnostic, Severity};
use crate::system::FOREVER;
use crate::system::build::{build, not_a};
use crate::system::settings::Settings;
use crate::verify::{Cancel, Options, SystemInput, settings, to_f64};

/// The answer to "how many cores?".
#[derive(Debug, Clone, Serialize)]
pub struct MinimumCores {
    /// The smallest number with which all tasks asked about are schedulable.
    pub cores: Option<u32>,
    /// The verdict for each number that was tried, ascending.
    pub tried: Vec<(u32, Verdict)>,
}

/// The answer to "how large, or small, may this become?".
#[derive(Debug, Clone, Serialize)]
pub struct Extreme {
    /// Of what: a codel or a task.
    pub of: String,
    /// Its value now, in the unit of the report.
    pub now: Value,
    /// The extreme value found: largest WCET or smallest period. `None`: even the value now fails.
    /// [`Value::Unbounded`]: no bound was found up to the longest period.
    pub extreme: Option<Value>,
    /// Whether values beyond it are known to fail.
    pub exact: bool,
    /// Set when some verification was given up: the extreme may be further out.
    pub incomplete: bool,
}

/// All of it: how far a system is from missing a deadline, or from meeting them.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Sensitivity {
    /// The smallest number of cores.
    pub minimum_cores: MinimumCores,
    /// The largest WCET of each codel that has a bound, the others as they are.
    pub wcet: Vec<Extreme>,
    /// The smallest period of each periodic task, the others as they are.
    pub period: Vec<Extreme>,
    /// Set when it was cancelled: questions are missing.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub incomplete: bool,
}

/// How far [`sensitivity`] has come.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Progress {
    /// Questions answered, of all.
    pub done: usize,
    /// All of them.
    pub of: usize,
    /// What is asked now, in words.
    pub asking: String,
}

/// Every derived question about a scenario. Takes as long as some dozen verifications for each codel and
/// task.
pub fn sensitivity(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    cancel: &Cancel,
    progress: &dyn Fn(Progress),
) -> Result<Sensitivity, Vec<Diagnostic>> {
    let names = Names::new(&input.specs);
    let system = build(&names, &settings(scenario, options), &|_| true).system;
    let codels = system.codels.iter();
    let codels: Vec<Path> = codels
        .filter(|it| it.site.is_some() && it.upper != FOREVER)
        .map(|it| Path::of(&it.path))
        .collect();
    let tasks = system.tasks.iter();
    let tasks: Vec<Path> = tasks
        .filter(|it| it.period.is_some())
        .map(|it| {
            let component = &system.components[it.component].name;
            Path::of(&format!("{component}.{}", it.name))
        })
        .collect();
    let of = 1 + codels.len() + tasks.len();
    let asking = |done, asking| progress(Progress { done, of, asking });
    asking(0, "the number of cores".to_owned());
    let mut out = Sensitivity {
        minimum_cores: minimum_cores(input, scenario, options, cancel)?,
        wcet: Vec::new(),
        period: Vec::new(),
        incomplete: false,
    };
    for (i, path) in codels.iter().enumerate() {
        if cancel.is_over() {
            break;
        }
        asking(1 + i, format!("the WCET of {}", path.text()));
        out.wcet
            .push(largest_wcet(input, scenario, options, path, cancel)?);
    }
    for (i, path) in tasks.iter().enumerate() {
        if cancel.is_over() {
            break;
        }
        let done = 1 + codels.len() + i;
        asking(done, format!("the period of {}", path.text()));
        out.period
            .push(smallest_period(input, scenario, options, path, cancel)?);
    }
    out.incomplete = cancel.is_over();
    Ok(out)
}

/// The smallest number of cores with which the tasks are schedulable.
pub fn minimum_cores(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    cancel: &Cancel,
) -> Result<MinimumCores, Vec<Diagnostic>> {
    let names = Names::new(&input.specs);
    let mut variation = Variation::new(&names, settings(scenario, options), options, cancel)?;
    variation.settings.cores = None;
    let most = build(&names, &variation.settings, &|_| true)
        .system
        .tasks
        .len() as u32;
    let mut out = MinimumCores {
        cores: None,
        tried: Vec::new(),
    };
    for cores in 1..=most.max(1) {
        if cancel.is_over() {
            break;
        }
        variation.settings.cores = Some(cores);
        let verdict = variation.schedulable();
        out.tried.push((cores, verdict));
        if verdict == Verdict::Proved {
            out.cores = Some(cores);
            break;
        }
    }
    Ok(out)
}

/// The largest WCET of a codel (`component.task.state`, …) with which the tasks are schedulable.
pub fn largest_wcet(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    codel: &Path,
    cancel: &Cancel,
) -> Result<Extreme, Vec<Diagnostic>> {
    let names = Names::new(&input.specs);
    let mut variation = Variation::new(&names, settings(scenario, options), options, cancel)?;
    let target = names.resolve(codel).map_err(|it| vec![it])?;
    if !matches!(target, Target::State(..) | Target::Codel(..)) {
        return Err(vec![not_a("codel", codel)]);
    }
    let built = build(&names, &variation.settings, &|_| true);
    let path = codel.text();
    let unit = built.system.unit;
    let current = built.system.codels.iter().find(|it| {
        it.path == path
            || it
                .site
                .is_some_and(|site| same_codel(&target, site, &it.path, &path))
    });
    let Some(current) = current else {
        return Err(vec![not_a("codel that is executed", codel)]);
    };
    let upper = current.upper;
    let longest = built
        .system
        .tasks
        .iter()
        .filter_map(|it| it.period)
        .max()
        .unwrap_or(1);
    let of_ticks = |ticks: u32| unit * Ratio::from_integer(i128::from(ticks));
    let mut holds = |ticks: u32| {
        variation.settings.upper_bound = Some((codel.clone(), of_ticks(ticks)));
        variation.schedulable()
    };
    let report_unit = report_unit(scenario);
    let value = |ticks: u32| Value::Time(to_f64(of_ticks(ticks) / report_unit));
    let mut out = Extreme {
        of: path,
        now: if upper == crate::system::FOREVER {
            Value::Unbounded
        } else {
            value(upper)
        },
        extreme: None,
        exact: settings(scenario, options).durations != Durations::Fixed,
        incomplete: false,
    };
    let start = if upper == crate::system::FOREVER {
        0
    } else {
        upper
    };
    match holds(start) {
        Verdict::Proved => {}
        verdict => {
            out.incomplete = verdict == Verdict::Unknown;
            return Ok(out);
        }
    }
    // Double until it fails, then bisect.
    let (mut good, mut bad) = (start, None);
    let mut step = (longest / 16).max(1);
    while good < longest.saturating_mul(2) {
        match holds(good + step) {
            Verdict::Proved => good += step,
            verdict => {
                out.incomplete |= verdict == Verdict::Unknown;
                bad = Some(good + step);
                break;
            }
        }
        step = step.saturating_mul(2);
    }
    let Some(mut bad) = bad else {
        out.extreme = Some(Value::Unbounded);
        out.exact = false;
        return Ok(out);
    };
    while bad - good > 1 {
        let middle = good + (bad - good) / 2;
        match holds(middle) {
            Verdict::Proved => good = middle,
            verdict => {
                out.incomplete |= verdict == Verdict::Unknown;
                bad = middle;
            }
        }
    }
    out.extreme = Some(value(good));
    out.exact &= !out.incomplete;
    Ok(out)
}

/// The smallest period of a task, by bisection, with which the tasks are schedulable.
pub fn smallest_period(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    task: &Path,
    cancel: &Cancel,
) -> Result<Extreme, Vec<Diagnostic>> {
    let names = Names::new(&input.specs);
    let mut variation = Variation::new(&names, settings(scenario, options), options, cancel)?;
    let key = resolve::task(&names, task).map_err(|it| vec![it])?;
    let built = build(&names, &variation.settings, &|_| true);
    let unit = built.system.unit;
    let Some(period) = built.system.tasks[built.tasks[&key]].period else {
        return Err(vec![not_a("periodic task", task)]);
    };
    let of_ticks = |ticks: u32| unit * Ratio::from_integer(i128::from(ticks));
    let mut holds = |ticks: u32| {
        variation.settings.period = Some((task.clone(), of_ticks(ticks)));
        variation.schedulable()
    };
    let report_unit = report_unit(scenario);
    let value = |ticks: u32| Value::Time(to_f64(of_ticks(ticks) / report_unit));
    let mut out = Extreme {
        of: task.text(),
        now: value(period),
        extreme: None,
        exact: false,
        incomplete: false,
    };
    match holds(period) {
        Verdict::Proved => {}
        verdict => {
            out.incomplete = verdict == Verdict::Unknown;
            return Ok(out);
        }
    }
    let (mut good, mut bad) = (period, 0);
    while good - bad > 1 {
        let middle = bad + (good - bad) / 2;
        match holds(middle) {
            Verdict::Proved => good = middle,
            verdict => {
                out.incomplete |= verdict == Verdict::Unknown;
                bad = middle;
            }
        }
    }
    out.extreme = Some(value(good));
    Ok(out)
}

fn same_codel(
    target: &Target,
    (c, it): (usize, dotgen_analysis::model::CodelRef),
    path: &str,
    wanted: &str,
) -> bool {
    match target {
        Target::Codel(a, s, index) => {
            (*a, *index) == (c, it.index) && it.owner == dotgen_analysis::model::Owner::Service(*s)
        }
        _ => path == wanted,
    }
}

fn report_unit(scenario: &Scenario) -> Seconds {
    let (count, unit) = Settings::new(scenario)
        .unit
        .unwrap_or((1, Unit::Milliseconds));
    unit.seconds() * Ratio::from_integer(i128::from(count))
}

/// Settings to be varied, and the tasks that must stay schedulable.
struct Variation<'v> {
    names: &'v Names<'v>,
    settings: Settings,
    tasks: Vec<(usize, u32)>,
    options: &'v Options,
    cancel: &'v Cancel,
}

impl<'v> Variation<'v> {
    fn new(
        names: &'v Names<'v>,
        settings: Settings,
        options: &'v Options,
        cancel: &'v Cancel,
    ) -> Result<Self, Vec<Diagnostic>> {
        let mut errors: Vec<Diagnostic> = build(names, &settings, &|_| true).diagnostics;
        errors.retain(|it| it.severity == Severity::Error);
        let mut tasks = Vec::new();
        let mut all = true;
        for check in &settings.checks {
            if let CheckKind::Schedulable(path) = &check.kind {
                match path.as_ref().map(|it| resolve::task(names, it)) {
                    None => {
                        all = true;
                        tasks.clear();
                        break;
                    }
                    Some(Ok(task)) => {
                        all = false;
                        tasks.push(task);
                    }
                    Some(Err(error)) => errors.push(error),
                }
            }
        }
        if all {
            for (c, member) in names.components.iter().enumerate() {
                let periodic = member.component.tasks.iter().enumerate();
                let periodic = periodic.filter(|(_, it)| it.period.is_some());
                tasks.extend(periodic.map(|(t, _)| (c, t as u32)));
            }
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        Ok(Variation {
            names,
            settings,
            tasks,
            options,
            cancel,
        })
    }

    fn schedulable(&self) -> Verdict {
        if self.cancel.is_over() {
            return Verdict::Unknown;
        }
        let built = build(self.names, &self.settings, &|_| true);
        if built.has_errors() {
            return Verdict::Unknown;
        }
        let tasks: Vec<usize> = self.tasks.iter().map(|it| built.tasks[it]).collect();
        let bounds = response_bounds(&built.system);
        let open = tasks
            .into_iter()
            .filter(|&task| !meets_deadlines(&built.system, task, bounds[task]));
        let watch = Watch {
            schedulable: open.collect(),
            stop_at_first: true,
            ..Watch::default()
        };
        if watch.schedulable.is_empty() {
            return Verdict::Proved;
        }
        let found = explore(&built.system, &watch, self.options.limits, self.cancel);
        if found.missed.iter().any(Option::is_some) {
            Verdict::Refuted
        } else if found.stopped.is_some_and(|it| it != Stop::Answered) {
            Verdict::Unknown
        } else {
            Verdict::Proved
        }
    }
}
