//! What would make a check of a task hold that fails: a shorter codel, or more cores. Every answer was verified itself.

use std::time::{Duration, Instant};

use dotgen_analysis::model::{Seconds, Src};
use num_rational::Ratio;
use serde::Serialize;

use super::{bisect, report_unit};
use crate::explore::{Limits, MomentKind};
use crate::report::{Awaited, CheckReport, Delay, Event, Report, Verdict};
use crate::scn::ast::{CheckKind, Path, Scenario};
use crate::scn::names::Names;
use crate::system::FOREVER;
use crate::system::build::build;
use crate::system::settings::Settings;
use crate::verify::{Cancel, Options, SystemInput, settings, to_f64, verify_settings};

/// Verifications that take longer together are not worth a hint.
const PATIENCE: Duration = Duration::from_secs(2);

/// Codels that are tried.
const SUSPECTS: usize = 3;

/// So many times the states of the verification may be looked at for each question, and so many in any case.
const STATES: (usize, usize) = (4, 20_000);

/// What to change, the rest as it is.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "change", rename_all = "kebab-case")]
pub enum Remedy {
    /// The execution time of a codel.
    Wcet {
        /// `component.owner.state`
        codel: String,
        /// The longest one now, in the unit of the report.
        now: f64,
        /// The longest one with which the check holds, in the unit of the report.
        #[serde(rename = "at-most")]
        at_most: f64,
        /// Likewise, exactly.
        #[serde(skip)]
        seconds: Seconds,
        /// Shorter ones hold as well. With fixed durations only this one was verified.
        #[serde(rename = "or-less")]
        or_less: bool,
        /// Where the codel is declared: number of the specification, and place.
        #[serde(skip)]
        src: Option<(usize, Src)>,
    },
    /// The number of cores.
    Cores {
        /// So many there are.
        now: u32,
        /// So many are enough.
        needed: u32,
    },
}

/// What makes a refuted check of a task hold, if something plain does and is found soon: of the codels that its job waits
/// for, or is made of, the longest first, how short one has to be; else, where it waits for a core, how many are needed.
pub fn remedy(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    (report, check): (&Report, &CheckReport),
    cancel: &Cancel,
) -> Option<Remedy> {
    if check.verdict != Verdict::Refuted || check.rounded {
        return None;
    }
    let names = Names::new(&input.specs);
    let mut settings = settings(scenario, options);
    let mut asked = settings.checks.get(check.id.written)?.clone();
    let task = Path::of(&check.of);
    check.id.task?;
    match &mut asked.kind {
        CheckKind::Schedulable(of) | CheckKind::NoOverdue(of) | CheckKind::Response(of, _) => {
            *of = Some(task)
        }
        _ => return None,
    }
    settings.checks = vec![asked];
    let limits = Limits {
        states: (report.states * STATES.0)
            .max(STATES.1)
            .min(options.limits.states),
        ..options.limits
    };
    let mut trial = Trial {
        names: &names,
        settings,
        limits,
        cancel,
        end: Instant::now() + PATIENCE,
    };
    let by_codel = suspects(check)
        .iter()
        .find_map(|codel| trial.codel(codel, report_unit(scenario)));
    by_codel.or_else(|| trial.cores(check))
}

/// Codels whose execution times are in the way of the job at the end of a run, the longest first.
fn suspects(check: &CheckReport) -> Vec<String> {
    let length = |it: &Delay| it.until - it.from;
    let longest = check.reason.iter();
    let longest = longest.max_by(|a, b| length(a).total_cmp(&length(b)));
    let mut all: Vec<(f64, String)> = Vec::new();
    match longest {
        Some(delay) => {
            for holder in &delay.held {
                match &holder.codel {
                    Some(codel) => all.push((holder.until - holder.from, codel.clone())),
                    None => {
                        all.extend(executed(check.run(), &holder.by, holder.from, holder.until))
                    }
                }
            }
        }
        None => {
            let begins = |it: &&Event| it.kind == MomentKind::Release && who(it) == check.of;
            let job = check
                .run()
                .iter()
                .rev()
                .find(begins)
                .map_or(0.0, |it| it.time);
            all.extend(executed(check.run(), &check.of, job, f64::INFINITY));
        }
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut out: Vec<String> = Vec::new();
    for (_, codel) in all {
        if !out.contains(&codel) {
            out.push(codel);
        }
    }
    out.truncate(SUSPECTS);
    out
}

fn who(it: &Event) -> String {
    match &it.task {
        Some(task) => format!("{}.{task}", it.component),
        None => it.component.clone(),
    }
}

/// What somebody executes between two times of a run, and for how long.
fn executed(run: &[Event], by: &str, from: f64, until: f64) -> Vec<(f64, String)> {
    let mut begun: Vec<(f64, &str)> = Vec::new();
    let mut out = Vec::new();
    let end = run.last().map_or(0.0, |it| it.time).min(until);
    for it in run.iter().filter(|it| who(it) == by) {
        let Some(codel) = it.codel.as_deref().filter(|_| it.time <= until) else {
            continue;
        };
        match it.kind {
            MomentKind::Begin => begun.push((it.time, codel)),
            MomentKind::End => {
                if let Some(at) = begun.iter().position(|begun| begun.1 == codel) {
                    let (since, _) = begun.remove(at);
                    if it.time > from {
                        out.push((it.time - since, codel.to_owned()));
                    }
                }
            }
            _ => {}
        }
    }
    out.extend(
        begun
            .into_iter()
            .map(|(since, codel)| (end - since, codel.to_owned())),
    );
    out
}

struct Trial<'t> {
    names: &'t Names<'t>,
    settings: Settings,
    limits: Limits,
    cancel: &'t Cancel,
    end: Instant,
}

impl Trial<'_> {
    /// Whether the check holds with these settings.
    fn holds(&self, settings: &Settings) -> Verdict {
        if self.cancel.is_over() || Instant::now() > self.end {
            return Verdict::Unknown;
        }
        let report = verify_settings(self.names, settings, self.limits, self.cancel, &|_| {});
        match &report.checks[..] {
            [it] if it.verdict == Verdict::Proved && it.exceeds() => Verdict::Refuted,
            [it] => it.verdict,
            _ => Verdict::Unknown,
        }
    }

    /// The longest execution time of a codel with which it holds.
    fn codel(&self, path: &str, report_unit: Seconds) -> Option<Remedy> {
        use crate::scn::ast::Durations;
        let built = build(self.names, &self.settings, &|_| true);
        let codel = built.system.codels.iter().find(|it| it.path == path)?;
        let (lower, upper) = (codel.lower, codel.upper);
        let fixed = self.settings.durations == Durations::Fixed;
        // What takes no time is no codel any more, and below its least time it cannot be brought by a greatest one.
        let least = if fixed { 1 } else { lower.max(1) };
        if upper == FOREVER || upper <= least {
            return None;
        }
        let unit = built.system.unit;
        let seconds = |ticks: u32| unit * Ratio::from_integer(i128::from(ticks));
        let mut settings = self.settings.clone();
        let mut holds = |ticks: u32| {
            settings.upper_bound = Some((Path::of(path), seconds(ticks)));
            self.holds(&settings)
        };
        if holds(least) != Verdict::Proved {
            return None;
        }
        let mut incomplete = false;
        let at_most = bisect(least, upper, holds, &mut incomplete);
        let (c, src) = (codel.site.map(|it| it.0), codel.src);
        Some(Remedy::Wcet {
            codel: path.to_owned(),
            now: to_f64(seconds(upper) / report_unit),
            at_most: to_f64(seconds(at_most) / report_unit),
            seconds: seconds(at_most),
            or_less: !fixed,
            src: c.and_then(|c| Some((self.names.components[c].spec_index, src?))),
        })
    }

    /// Enough cores, where the job waits for one.
    fn cores(&mut self, check: &CheckReport) -> Option<Remedy> {
        let now = self.settings.cores?;
        if !check.reason.iter().any(|it| it.awaited == Awaited::Core) {
            return None;
        }
        let enough = |needed: &u32| {
            let mut settings = self.settings.clone();
            settings.cores = Some(*needed);
            self.holds(&settings) == Verdict::Proved
        };
        let needed = (now + 1..=now + 3).find(enough)?;
        Some(Remedy::Cores { now, needed })
    }
}
