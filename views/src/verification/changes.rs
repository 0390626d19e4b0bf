//! Changes as text and as edits, for the editor and the command line.

use std::ops::Range;
use std::time::Duration;

use camino::Utf8PathBuf;
use dotgen_analysis::diagnostic::FileEdit;
use dotgen_analysis::host::{Analysis, Cancellable};
use dotgen_analysis::ide::TaskTime;
use dotgen_analysis::model::{Seconds, Src};
use dotgen_analysis::quantity::time;
use dotgen_timing::advice::{self, Change, RepairCallbacks};
use dotgen_timing::report::Report;
use dotgen_timing::scn::edit;
use dotgen_timing::system::CodelName;
use dotgen_timing::verify::{Cancel, Options, SystemInput, settings};
use num_rational::Ratio;

use super::Problem;
use super::blocking;
use dotgen_timing::report::TimeUnit;

/// A change with which every deadline and limit is met.
#[derive(Debug, Clone, PartialEq)]
pub struct Repair {
    pub change: Change,
    /// `` it holds if `tell` takes at most 4 ms ``
    pub words: String,
}

/// All changes that were found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Repairs {
    /// The changes, the smallest first.
    pub all: Vec<Repair>,
    /// True if not every change was tried.
    pub incomplete: bool,
}

/// The changes that meet every missed deadline and limit of a report. Each is reported when it is found.
/// `patience` is a time limit for the search.
pub fn repairs(
    problem: &Problem,
    options: &Options,
    report: &Report,
    until: (&Cancel, Option<Duration>),
    (trying, tell): RepairCallbacks<'_, Repair>,
) -> Repairs {
    let input = SystemInput { specs: problem.specs() };
    let table = blocking::table(problem, options);
    let unit = TimeUnit::of(&settings(&problem.scenario, options));
    let function = |codel: &CodelName| {
        let row = table.iter().find(|row| row.codel.path == *codel);
        row.map_or(&**codel, |row| &row.codel.function).to_owned()
    };
    let repair = |change: &Change| Repair {
        words: in_words(change, unit, &function),
        change: change.clone(),
    };
    let tell = |change: &Change| tell(&repair(change));
    let told = (trying, &tell as &(dyn Fn(&Change) + Sync));
    let found = advice::repairs(&input, &problem.scenario, options, report, until, told);
    Repairs { all: found.changes.iter().map(repair).collect(), incomplete: found.incomplete }
}

/// `` it holds if `report_start` takes at most 4 ms ``, with the functions of codels as names.
pub(crate) fn in_words(
    change: &Change,
    unit: TimeUnit,
    function: &dyn Fn(&CodelName) -> String,
) -> String {
    match change {
        Change::Wcet { codel, at_most, or_less, .. } => {
            let most = if *or_less { "at most " } else { "" };
            let (name, time) = (function(codel), unit.show(*at_most));
            format!("it holds if `{name}` takes {most}{time}")
        }
        Change::Period { task, needed, .. } => {
            format!("it holds with a period of {} for `{task}`", unit.show(*needed))
        }
        Change::Delay { task, needed, .. } => {
            format!("it holds with a delay of {} for `{task}`", unit.show(*needed))
        }
        Change::Lock { codel, other, through } => {
            let (codel, other) = (function(codel), function(other));
            let through = through.join(" and ");
            format!(
                "it holds if `{codel}` and `{other}` do not wait for each other: `{codel}` can work on a copy (`local`) of \
                 {through}"
            )
        }
        Change::Cores { needed, .. } => format!("it holds with {needed} cores"),
        Change::Policy { needed, .. } => format!("it holds with `policy {}`", needed.name()),
    }
}

/// The description of an edit, in the imperative. None for a change that cannot be an edit: another design of
/// codels.
pub fn title(change: &Change) -> Option<String> {
    Some(match change {
        Change::Wcet { codel, seconds, .. } => {
            format!("Give `{codel}` a budget of {}", time(*seconds))
        }
        Change::Period { task, seconds, .. } => {
            format!("Set the period of `{task}` to {}", time(*seconds))
        }
        Change::Delay { task, seconds, .. } => {
            format!("Set the delay of `{task}` to {}", time(*seconds))
        }
        Change::Cores { needed, .. } => format!("Verify with `cores {needed}`"),
        Change::Policy { needed, .. } => format!("Verify with `policy {}`", needed.name()),
        Change::Lock { .. } => return None,
    })
}

/// The edit of a specification or of the scenario for a change. None if there is no simple edit: two codels
/// that have to be separated, a time from a macro, a scenario without a file.
pub fn edit(
    analysis: &Analysis,
    problem: &Problem,
    change: &Change,
) -> Cancellable<Option<FileEdit>> {
    let of_scenario = |edit: Option<(Range<usize>, String)>| {
        let (range, new_text) = edit.filter(|_| problem.is_written())?;
        Some(FileEdit { path: problem.path.clone(), range, new_text })
    };
    let at = |src: &Option<(usize, Src)>| -> Option<(Utf8PathBuf, Range<usize>)> {
        let (spec, src) = (*src)?;
        problem.place(spec, src)
    };
    let (src, which, seconds) = match change {
        Change::Cores { needed, .. } => {
            let value = needed.to_string();
            return Ok(of_scenario(edit::setting(&problem.text, "cores", &value)));
        }
        Change::Policy { needed, .. } => {
            let value = needed.name();
            return Ok(of_scenario(edit::setting(&problem.text, "policy", value)));
        }
        Change::Wcet { codel, seconds, src, .. } => {
            // A duration in the scenario takes precedence over the specification.
            if let Some(scenario) = of_scenario(edit::longest(&problem.text, codel, *seconds)) {
                return Ok(Some(scenario));
            }
            let Some((path, range)) = at(src) else {
                return Ok(None);
            };
            return analysis.with_execution_time(&path, range, &written(*seconds));
        }
        Change::Lock { .. } => return Ok(None),
        Change::Period { src, seconds, .. } => (src, TaskTime::Period, seconds),
        Change::Delay { src, seconds, .. } => (src, TaskTime::Delay, seconds),
    };
    let Some((path, range)) = at(src) else {
        return Ok(None);
    };
    analysis.with_task_time(&path, range, which, &written(*seconds))
}

/// A time in the syntax of specifications: a whole number, in the largest unit that allows one.
fn written(time: Seconds) -> String {
    let whole = |per_second: i128| {
        let count = time * Ratio::from_integer(per_second);
        count.is_integer().then(|| count.to_integer())
    };
    match (whole(1_000), whole(1_000_000)) {
        (Some(number), _) => format!("{number} ms"),
        (_, Some(number)) => format!("{number} us"),
        _ => {
            // Rounded down: a slightly smaller value was verified as well, a larger one was not.
            let nanos = time * Ratio::from_integer(1_000_000_000);
            format!("{:.3} us", nanos.floor().to_integer() as f64 / 1e3)
        }
    }
}
