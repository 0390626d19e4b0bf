//! Verification: from specifications and a scenario to a report.

mod answers;
mod bounds;
mod certified;
mod chains;
mod checks;
mod events;
mod group;
mod groups;
mod no_jobs;
mod part;
mod prepared;
mod reason;
mod rounding;
mod seen;
mod simulate;
mod spent;
mod stages;
mod tasks_with_jobs;
mod units;
mod watch;

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use dotgen_analysis::model::Spec;

pub use self::certified::certificate;
use self::checks::expand;
use self::group::Group;
use self::part::{Part, Parted, parted};
pub use self::prepared::{Prepared, PreparedCheck, Question, prepare};
pub use self::simulate::{Choice, Simulation};
pub use crate::cancel::{Cancel, Effort, Interrupt};
use crate::diagnostic::{Diagnostic, Severity};
use crate::explore::Limits;
use crate::report::{Report, Soundness, TimeUnit, Verdict};
use crate::scn::ast::{Check, Durations, Policy, Scenario};
use crate::scn::names::Names;
use crate::scn::semantics::Preset;
use crate::system::build::build;
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
    verify_settings(&names, &settings, (options.limits, false), cancel, tell)
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

/// Verifies settings until some check fails, for one verdict about all of them.
pub(crate) fn verify_until_failure(
    names: &Names,
    settings: &Settings,
    limits: Limits,
    cancel: &Cancel,
) -> Report {
    verify_settings(names, settings, (limits, true), cancel, &|_| {})
}

/// Returns the errors of a system and its checks.
pub(crate) fn errors(names: &Names, settings: &Settings) -> Vec<Diagnostic> {
    let whole = build(names, settings, &|_| true);
    let mut errors = whole.diagnostics.clone();
    expand(names, &whole, settings, &mut errors);
    errors.retain(|error| error.severity == Severity::Error);
    errors
}

fn verify_settings(
    names: &Names,
    settings: &Settings,
    (limits, until_failure): (Limits, bool),
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
    // The first report is always sent. A later report is sent only if it has more answers.
    let told = AtomicUsize::new(usize::MAX);
    let tell = |report: &mut Report| {
        if told.swap(report.answered(), Ordering::Relaxed) == report.answered() {
            return;
        }
        report.seconds = start.elapsed().as_secs_f64();
        mark_lower_bounds(report);
        if !cancel.is_abandoned() {
            tell(report);
        }
    };
    let built = &whole;
    let tell = &tell;
    let group = Group { names, built, unit, settings, limits, until_failure, cancel, tell };
    report.checks = checks.iter().map(|check| group.open(check)).collect();
    let parted = parted(names, settings, &whole, &checks);
    let alone = parted.len() == 1;
    let parts = parted.iter().map(|Parted { built, of_group }| {
        Part::new(Group { built, ..group }, &checks, of_group, alone)
    });
    let mut parts: Vec<Part> = parts.collect();
    stages::answer(&mut parts, &mut report);
    if !until_failure {
        for part in &mut parts {
            part.finish(&mut report);
        }
    }
    rounding::leave_open(&whole, &mut report);
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
