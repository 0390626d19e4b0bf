//! From specifications and a scenario to a report.

mod analysed;
mod answers;
mod checks;
mod events;
mod groups;
mod soon;
mod units;
mod watch;

use std::time::Instant;

use dotgen_analysis::model::{Seconds, Spec};
use num_rational::Ratio;

use self::analysed::Analysed;
use self::checks::{Single, What, expand};
use self::groups::groups;
use self::soon::Seen;
pub(crate) use self::units::to_f64;
pub use crate::cancel::{Cancel, Effort};
use crate::explore::{Findings, Limits, Stop, Watch, explore};
use crate::report::{CheckReport, Report};
use crate::scn::Diagnostic;
use crate::scn::ast::{Check, Durations, Policy, Scenario, Unit};
use crate::scn::names::Names;
use crate::system::build::{Built, build};
use crate::system::settings::Settings;

/// The specifications of a system.
#[derive(Debug, Clone, Default)]
pub struct SystemInput<'a> {
    /// In the order of the scenario's `use`.
    pub specs: Vec<&'a Spec>,
}

/// What overrides the scenario.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Number of cores; `Some(None)`: no limit.
    pub cores: Option<Option<u32>>,
    /// Order of grants.
    pub policy: Option<Policy>,
    /// How long codels take.
    pub durations: Option<Durations>,
    /// Checks instead of those of the scenario, if any.
    pub checks: Vec<Check>,
    /// When to give up.
    pub limits: Limits,
}

/// Verifies a scenario.
pub fn verify(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    cancel: &Cancel,
) -> Report {
    let names = Names::new(&input.specs);
    verify_settings(&names, &settings(scenario, options), options.limits, cancel)
}

/// A scenario with its overrides.
pub fn settings(scenario: &Scenario, options: &Options) -> Settings {
    let mut settings = Settings::new(scenario);
    if let Some(cores) = options.cores {
        settings.cores = cores;
    }
    settings.policy = options.policy.unwrap_or(settings.policy);
    settings.durations = options.durations.unwrap_or(settings.durations);
    if !options.checks.is_empty() {
        settings.checks.clone_from(&options.checks);
    }
    settings
}

/// Verifies settings; what the derived questions vary.
pub(crate) fn verify_settings(
    names: &Names,
    settings: &Settings,
    limits: Limits,
    cancel: &Cancel,
) -> Report {
    let start = Instant::now();
    let (count, unit) = settings.unit.unwrap_or((1, Unit::Milliseconds));
    let mut report = Report {
        scenario: settings.name.clone(),
        unit: if count == 1 {
            unit.name().to_owned()
        } else {
            format!("{count} {}", unit.name())
        },
        ..Report::default()
    };
    let whole = build(names, settings, &|_| true);
    report.diagnostics.clone_from(&whole.diagnostics);
    report.assumptions.clone_from(&whole.assumptions);
    let checks = expand(names, &whole, settings, &mut report.diagnostics);
    if names.components.is_empty() {
        let message = "there is no component to verify".to_owned();
        report
            .diagnostics
            .push(Diagnostic::error("scn-no-component", 0..0, message));
    }
    if report.has_errors() {
        return report;
    }
    let unit = unit.seconds() * Ratio::from_integer(i128::from(count));
    let groups = groups(names, &whole, &checks);
    let mut answers: Vec<Option<CheckReport>> = vec![None; checks.len()];
    for group in &groups {
        let of_group: Vec<usize> = (0..checks.len())
            .filter(|&i| {
                checks[i]
                    .components
                    .first()
                    .is_none_or(|it| group.contains(it))
            })
            .collect();
        if of_group.is_empty() {
            continue;
        }
        let built = if groups.len() == 1 {
            whole.clone()
        } else {
            build(names, settings, &|c| group.contains(&c))
        };
        Group {
            names,
            built: &built,
            unit,
            settings,
            limits,
            cancel,
        }
        .answer(&checks, &of_group, &mut answers, &mut report);
    }
    report.checks = answers.into_iter().flatten().collect();
    report.seconds = start.elapsed().as_secs_f64();
    report
}

/// Components that are explored together.
struct Group<'g> {
    names: &'g Names<'g>,
    built: &'g Built,
    /// Unit of the report.
    unit: Seconds,
    settings: &'g Settings,
    limits: Limits,
    cancel: &'g Cancel,
}

/// Said when all checks were answered before everything was explored.
const NOT_EXAMINED: &str =
    "no request was seen to be refused for want of a slot, but not everything was looked at";

impl Group<'_> {
    /// Answers the checks of this group.
    fn answer(
        &self,
        checks: &[Single],
        of_group: &[usize],
        answers: &mut [Option<CheckReport>],
        report: &mut Report,
    ) {
        let analysed = Analysed::new(self.built);
        for &i in of_group {
            answers[i] = if let Some(bound) = analysed.deadline(&checks[i]) {
                Some(self.meets_deadlines(&checks[i], bound))
            } else if analysed.is_zero(&checks[i]) {
                Some(self.takes_no_time(&checks[i]))
            } else {
                None
            };
        }
        let seen = self.soon(checks, of_group, answers, report);
        let open = of_group.iter().copied().filter(|&i| answers[i].is_none());
        // What makes reductions impossible is not looked for together with what does not.
        let (together, apart): (Vec<usize>, Vec<usize>) =
            open.partition(|&i| self.is_about_ticks(&checks[i]));
        if together.is_empty() && apart.is_empty() {
            let limits = self.limits;
            let found = explore(&self.built.system, &Watch::default(), limits, self.cancel);
            self.refusals(&found, report);
        }
        for part in [together, apart] {
            self.explore(checks, &part, &analysed, &seen, answers, report);
        }
    }

    /// Notes which requests can be refused, as far as has been seen.
    fn refusals(&self, found: &Findings, report: &mut Report) {
        let system = &self.built.system;
        for &service in &found.refused {
            report.note(format!(
                "a request of {} can be refused because all its slots are in use",
                system.service_path(service)
            ));
        }
        let early = found.stopped == Some(Stop::Answered);
        if early && found.refused.is_empty() && system.may_refuse() {
            report.note(NOT_EXAMINED.to_owned());
        }
    }

    fn explore(
        &self,
        checks: &[Single],
        part: &[usize],
        analysed: &Analysed,
        seen: &Seen,
        answers: &mut [Option<CheckReport>],
        report: &mut Report,
    ) {
        let (watch, places) = self.watch(checks, part.iter().copied(), analysed);
        let explored = places
            .iter()
            .any(|&(i, _)| !matches!(checks[i].what, What::LeadsTo(..) | What::Eventually(_)));
        let found = if explored {
            explore(&self.built.system, &watch, self.limits, self.cancel)
        } else {
            Findings::default()
        };
        report.effort(&found);
        if explored {
            self.refusals(&found, report);
        }
        for (i, place) in places {
            answers[i] = Some(match checks[i].what {
                What::LeadsTo(p, q) => self.live(&checks[i], Some(p), q, report),
                What::Eventually(p) => self.live(&checks[i], None, p, report),
                _ => {
                    let mut it = self.one(&checks[i], place, &found);
                    seen.add_to(i, &mut it);
                    self.bound_unknown(&checks[i], analysed, &mut it);
                    it
                }
            });
        }
    }
}
