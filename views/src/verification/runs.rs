//! The run of a report that is shown, its title and its end.

use dotgen_timing::explore::MomentKind;
use dotgen_timing::report::{CheckReport, Report, Verdict};
use dotgen_timing::system::ThreadName;

/// The end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending<'t> {
    /// This task is late, and the events do not show it.
    Miss(&'t ThreadName),
    /// A valid end.
    Fine,
}

/// The check whose run is shown: the requested one, else the first refuted one, else the first one with a
/// run.
pub fn chosen(report: &Report, wanted: Option<usize>) -> Option<usize> {
    let has_run = |report: &CheckReport| !report.run().is_empty();
    let refuted = |report: &CheckReport| report.verdict == Verdict::Refuted && has_run(report);
    let wanted = wanted.filter(|&number| report.checks.get(number).is_some_and(has_run));
    let position =
        |matches_check: &dyn Fn(&CheckReport) -> bool| report.checks.iter().position(matches_check);
    wanted.or_else(|| position(&refuted)).or_else(|| position(&has_run))
}

/// What the run of a check shows: `a run that refutes it`.
pub fn shows(check: &CheckReport) -> &'static str {
    match (check.verdict == Verdict::Refuted, check.kind.is_time()) {
        (true, _) => "a run that refutes it",
        (false, true) => "the longest run found",
        (false, false) => "a run that shows it",
    }
}

/// The title of the run of a check.
pub fn title(check: &CheckReport) -> String {
    format!("{} {}: {}", check.kind, check.of, shows(check))
}

/// The end of the run of a check.
pub fn ending(check: &CheckReport) -> Ending<'_> {
    let last = check.run().last();
    let says_so = last.is_some_and(|run| run.kind == MomentKind::Excess);
    match &check.task {
        Some(task) if check.verdict == Verdict::Refuted && !says_so => Ending::Miss(task),
        _ => Ending::Fine,
    }
}
