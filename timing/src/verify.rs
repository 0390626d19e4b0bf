//! Verification: from specifications and a scenario to a report.

mod answers;
mod bounds;
mod certified;
mod chains;
mod checks;
mod coarse;
mod events;
mod groups;
mod invariants;
mod no_jobs;
mod prepared;
mod quick;
mod reason;
mod rounding;
mod simulate;
mod spent;
pub(crate) mod tasks_with_jobs;
mod units;
mod watch;

use std::time::Instant;

use dotgen_analysis::model::Spec;

use self::bounds::ResponseBounds;
pub use self::certified::certificate;
use self::checks::{Single, What, expand};
use self::groups::groups;
pub use self::prepared::{Prepared, PreparedCheck, Question, prepare};
use self::quick::Seen;
pub use self::simulate::{Choice, Simulation};
pub use crate::cancel::{Cancel, Effort, Interrupt};
use crate::diagnostic::Diagnostic;
use crate::diagnostic::remark::Sighting;
use crate::explore::{Findings, Kind, Limits, Stop, Watch, explore, explore_with_reports};
use crate::report::{Report, Soundness, TimeUnit, Verdict};
use crate::scn::ast::{Check, Durations, Policy, Scenario};
use crate::scn::names::Names;
use crate::scn::semantics::Preset;
use crate::system::ServiceId;
use crate::system::build::build;
use crate::system::indexed::Built;
use crate::system::settings::Settings;

/// The specifications of a system.
#[derive(Debug, Clone, Default)]
pub struct SystemInput<'a> {
    /// Specifications, in the order of `use` in the scenario.
    pub specs: Vec<&'a Spec>,
}

/// Options that override the scenario.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Number of cores. `Some(None)`: no limit.
    pub cores: Option<Option<u32>>,
    /// Semantics of the model. Single points that the scenario states still apply.
    pub semantics: Option<Preset>,
    /// Order in which cores are granted.
    pub policy: Option<Policy>,
    /// Interpretation of execution times.
    pub durations: Option<Durations>,
    /// Checks that replace those of the scenario, if not empty.
    pub checks: Vec<Check>,
    /// Limits on the effort.
    pub limits: Limits,
}

/// Verifies a scenario.
pub fn verify(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    cancel: &Cancel,
) -> Report {
    verify_with_reports(input, scenario, options, cancel, &|_| {})
}

/// Verifies a scenario, and reports intermediate results.
///
/// `tell` gets the report so far. A check without an answer is [open](crate::report::Verdict::Open) there;
/// every other answer is the one of the final report. After the verification is abandoned, `tell` is not
/// called.
pub fn verify_with_reports(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    cancel: &Cancel,
    tell: &(dyn Fn(&Report) + Sync),
) -> Report {
    let names = Names::new(&input.specs);
    let settings = settings(scenario, options);
    verify_settings(&names, &settings, options.limits, cancel, tell)
}

/// Returns the settings of a scenario with its overrides.
pub fn settings(scenario: &Scenario, options: &Options) -> Settings {
    let mut settings = Settings::new(scenario);
    if let Some(cores) = options.cores {
        settings.cores = cores;
    }
    settings.preset = options.semantics.unwrap_or(settings.preset);
    settings.stated_policy = options.policy.or(settings.stated_policy);
    settings.durations = options.durations.unwrap_or(settings.durations);
    if !options.checks.is_empty() {
        settings.checks.clone_from(&options.checks);
    }
    settings
}

pub(crate) fn verify_settings(
    names: &Names,
    settings: &Settings,
    limits: Limits,
    cancel: &Cancel,
    tell: &(dyn Fn(&Report) + Sync),
) -> Report {
    let start = Instant::now();
    let unit = TimeUnit::of(settings);
    let mut report = Report {
        scenario: settings.name.clone(),
        semantics: settings.semantics().text(),
        unit,
        ..Report::default()
    };
    let whole = build(names, settings, &|_| true);
    report.diagnostics.clone_from(&whole.diagnostics);
    report.assumptions.clone_from(&whole.assumptions);
    let checks = expand(names, &whole, settings, &mut report.diagnostics);
    if names.components.is_empty() {
        let message = "there is no component to verify".to_owned();
        report.diagnostics.push(Diagnostic::error("scn-no-component", 0..0, message));
    }
    if report.has_errors() {
        return report;
    }
    let tell = |report: &mut Report| {
        report.seconds = start.elapsed().as_secs_f64();
        mark_lower_bounds(report);
        if !cancel.is_abandoned() {
            tell(report);
        }
    };
    let of_whole = Group { names, built: &whole, unit, settings, limits, cancel, tell: &tell };
    report.checks = checks.iter().map(|check| of_whole.open(check)).collect();
    let parts = parted(names, settings, &whole, &checks);
    let mut groups: Vec<(Group, &[usize], ResponseBounds)> = (parts.iter())
        .map(|Parted { built, of_group }| {
            let group = Group { built, ..of_whole };
            (group, &**of_group, ResponseBounds::new(built))
        })
        .collect();
    // Cheap analyses of all groups come first, so that no group waits for the exploration of another one.
    for (group, of_group, analysed) in &groups {
        group.analyse(&checks, of_group, analysed, &mut report);
    }
    tell(&mut report);
    for (group, of_group, analysed) in &groups {
        group.early(&checks, of_group, analysed, &mut report);
    }
    for (group, of_group, analysed) in &mut groups {
        group.abstracted(&checks, of_group, analysed, &mut report);
    }
    for (group, of_group, _) in &groups {
        group.invariants(&checks, of_group, &mut report);
    }
    let seen: Vec<Seen> = (groups.iter())
        .map(|(group, of_group, analysed)| {
            group.soon(&checks, of_group, groups.len() == 1, analysed, &mut report)
        })
        .collect();
    let unconfirmed = coarse::answer(&parts, of_whole, &checks, &mut report);
    for ((group, of_group, analysed), seen) in groups.iter().zip(&seen) {
        group.rest(&checks, of_group, analysed, seen, &mut report);
    }
    coarse::note_unconfirmed(&unconfirmed, &mut report);
    coarse::leave_open(&whole, &mut report);
    mark_lower_bounds(&mut report);
    report.seconds = start.elapsed().as_secs_f64();
    report
}

/// Marks the values of checks without verdict: they are reached, and others may exceed them.
fn mark_lower_bounds(report: &mut Report) {
    for check in &mut report.checks {
        if check.verdict == Verdict::Unknown && check.value.is_some() {
            check.soundness = Soundness::LowerBound;
        }
    }
}

/// A group of components as a system, and the indices of its checks.
struct Parted {
    built: Built,
    of_group: Vec<usize>,
}

/// Returns the groups of components that have checks.
fn parted(names: &Names, settings: &Settings, whole: &Built, checks: &[Single]) -> Vec<Parted> {
    let groups = groups(names, whole, checks);
    let mut out = Vec::new();
    for group in &groups {
        let of_group: Vec<usize> = (0..checks.len())
            .filter(|&i| {
                checks[i].components.first().is_none_or(|component| group.contains(component))
            })
            .collect();
        if of_group.is_empty() {
            continue;
        }
        let built = match groups.len() {
            1 => whole.clone(),
            _ => build(names, settings, &|c| group.contains(&c)),
        };
        out.push(Parted { built, of_group });
    }
    out
}

/// Components that are explored together.
#[derive(Clone, Copy)]
struct Group<'g> {
    names: &'g Names<'g>,
    built: &'g Built,
    /// Unit of the report.
    unit: TimeUnit,
    settings: &'g Settings,
    limits: Limits,
    cancel: &'g Cancel,
    /// Reports the intermediate results.
    tell: &'g (dyn Fn(&mut Report) + Sync),
}

/// Divisor of the limit on states, for the search of exact values after bounds have answered all checks.
const SETTLED: usize = 100;

/// Limit on actions, for the search of exact values after bounds have answered all checks.
const STEPS_IF_SETTLED: u64 = 200_000;

/// Limit on actions, for the search of exact values where bounds lie beyond periods.
const STEPS_IF_BOUNDED: u64 = 10_000_000;

/// The note of a report whose checks were all answered before the exploration was complete.
const NOT_EXAMINED: &str =
    "no request was seen to be refused for want of a slot, but not everything was looked at";

impl Group<'_> {
    /// Answers the checks that response-time analysis alone can answer.
    fn analyse(
        &self,
        checks: &[Single],
        of_group: &[usize],
        analysed: &ResponseBounds,
        report: &mut Report,
    ) {
        for &i in of_group {
            if !report.is_open(i) {
                continue;
            }
            if let Some(missing) = self.nothing(&checks[i]) {
                report.answer(i, missing);
            } else if let Some(bound) = analysed.deadline(&checks[i]) {
                report.answer(i, self.meets_deadlines(&checks[i], bound, analysed));
            } else if analysed.is_zero(&checks[i]) {
                report.answer(i, self.takes_no_time(&checks[i]));
            }
        }
    }

    /// Answers checks by schedule abstraction, if it could answer any open check.
    fn abstracted(
        &self,
        checks: &[Single],
        of_group: &[usize],
        analysed: &mut ResponseBounds,
        report: &mut Report,
    ) {
        let open = |&&i: &&usize| report.is_open(i) && checks[i].is_of_task();
        let wanted = of_group.iter().any(|group| open(&group));
        if !wanted || self.limits.without.contains(Kind::ScheduleAbstraction) {
            return;
        }
        let found = analysed.abstracted(self.limits.bytes, self.cancel);
        report.reductions.add_abstraction(found.as_ref().err().copied());
        let Ok(open) = found else {
            return;
        };
        let open = open.into_iter().map(|(task, why)| (analysed.path(task), why));
        report.reductions.left_open.extend(open);
        let before = report.answered();
        self.analyse(checks, of_group, analysed, report);
        if report.answered() > before {
            (self.tell)(report);
        }
    }

    /// Returns true if a bound answers a check of a response time.
    fn is_settled(&self, check: &Single, analysed: &ResponseBounds) -> bool {
        match check.what {
            What::Response(of, limit) => {
                // Beyond its period, a bound says little.
                let period = self.built.system.tasks[self.built.tasks[&of]].period;
                analysed.answers_check(check, self.ticks(limit).or(period))
            }
            _ => false,
        }
    }

    /// Returns the limits for some checks. If each of them has a bound, exact values are worth less effort,
    /// and still less if the bounds answer the checks.
    fn limits_for(&self, checks: &[Single], part: &[usize], analysed: &ResponseBounds) -> Limits {
        if part.iter().all(|&i| self.is_settled(&checks[i], analysed)) {
            Limits {
                states: self.limits.states / SETTLED,
                steps: self.limits.steps.min(STEPS_IF_SETTLED),
                ..self.limits
            }
        } else if part.iter().all(|&i| analysed.response(&checks[i]).is_some()) {
            Limits { steps: self.limits.steps.min(STEPS_IF_BOUNDED), ..self.limits }
        } else {
            self.limits
        }
    }

    /// Answers the checks that are still open.
    fn rest(
        &self,
        checks: &[Single],
        of_group: &[usize],
        analysed: &ResponseBounds,
        seen: &Seen,
        report: &mut Report,
    ) {
        let open = of_group.iter().copied().filter(|&i| report.is_open(i));
        // Checks that rule out reductions are explored apart from checks that do not.
        let (together, apart): (Vec<usize>, Vec<usize>) =
            open.partition(|&i| self.is_about_ticks(&checks[i]));
        // Less effort is spent on exact values.
        let (settled, unsettled): (Vec<usize>, Vec<usize>) =
            together.into_iter().partition(|&i| self.is_settled(&checks[i], analysed));
        let together = [unsettled, settled];
        if together.iter().chain([&apart]).all(Vec::is_empty) {
            let limits = self.limits;
            let found = explore(&self.built.system, &Watch::default(), limits, self.cancel);
            self.refusals(&found, report);
        }
        for part in together.into_iter().chain([apart]) {
            self.explore(checks, &part, analysed, seen, report);
        }
    }

    /// Notes the requests that can be refused, among those seen so far.
    fn refusals(&self, found: &Findings, report: &mut Report) {
        let system = &self.built.system;
        let path = |&service: &ServiceId| system.service_path(service);
        let refused = found.refused.iter().map(path);
        let restarts = found.restarts.iter().map(path);
        let seen = (refused.map(|service| Sighting::NoSlot { service }))
            .chain(restarts.map(|service| Sighting::RestartsEndBoth { service }));
        seen.for_each(|no_slot| report.note(no_slot.to_string()));
        let early = found.stopped == Some(Stop::Answered);
        if early && found.refused.is_empty() && system.may_refuse() {
            report.note(NOT_EXAMINED.to_owned());
        }
    }

    fn explore(
        &self,
        checks: &[Single],
        part: &[usize],
        analysed: &ResponseBounds,
        seen: &Seen,
        report: &mut Report,
    ) {
        let (lasting, explored): (Vec<usize>, Vec<usize>) = part.iter().partition(|&&i| {
            let apart = &checks[i].what;
            matches!(apart, What::Chain(_) | What::LeadsTo(..) | What::Eventually(_))
        });
        if !explored.is_empty() {
            let limits = self.limits_for(checks, &explored, analysed);
            let (watch, places) = self.watch(checks, explored.into_iter(), analysed);
            let mut news = |found: &Findings| {
                let before = report.answered();
                self.final_answers(checks, &places, found, report);
                if report.answered() > before {
                    (self.tell)(report);
                }
            };
            let system = &self.built.system;
            let found = explore_with_reports(system, &watch, limits, self.cancel, &mut news);
            report.effort(&found);
            self.refusals(&found, report);
            // An exploration that begins again may reach the answer by another run, so reported answers stay.
            let open = places.into_iter().filter(|place| report.is_open(place.0));
            for (i, place) in open.collect::<Vec<_>>() {
                let mut entry = self.one(&checks[i], place, &found);
                seen.add_to(i, &mut entry);
                self.bound_unknown(&checks[i], analysed, &mut entry);
                self.bound_between_units(&checks[i], analysed, &mut entry);
                self.after_all(&checks[i], &found, &mut entry);
                report.answer(i, entry);
            }
            (self.tell)(report);
        }
        for i in lasting {
            let check = match checks[i].what {
                What::LeadsTo(p, q) => self.live(&checks[i], Some(p), q, report),
                What::Eventually(p) => self.live(&checks[i], None, p, report),
                What::Chain(of) => self.chain(&checks[i], of, report),
                _ => continue,
            };
            report.answer(i, check);
            (self.tell)(report);
        }
    }

    /// Answers the checks that no later state of an exploration can change.
    fn final_answers(
        &self,
        checks: &[Single],
        places: &[(usize, usize)],
        found: &Findings,
        report: &mut Report,
    ) {
        for &(i, place) in places {
            let seen = match checks[i].what {
                What::Schedulable(_) => found.missed[place].is_some(),
                What::NoOverdue(_) => found.overdue[place].is_some(),
                What::Always(_) | What::Reachable(_) | What::Pattern(_) => {
                    found.reached[place].is_some()
                }
                _ => continue,
            };
            if seen && report.is_open(i) {
                report.answer(i, self.one(&checks[i], place, found));
            }
        }
    }
}
