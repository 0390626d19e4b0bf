//! `dotgen/trace`: the run of a check as data, for a viewer. `docs/trace.md` describes the form.

use dotgen_analysis::host::Cancellable;

use super::answer::{Question, locate};
use crate::protocol::types::Location;
use crate::workspace::snapshot::{Snapshot, Subject};
use dotgen_views::verification::blocking;
use dotgen_views::verification::runs::{chosen, ending, title};
use dotgen_views::verification::trace::{Trace, TraceInput, of_run};

/// Answer of `dotgen/trace`.
pub(crate) type TraceResult = Trace<Option<Location>>;

/// The run of a check, for a client; none if there is no run.
pub(crate) fn trace(
    snapshot: &Snapshot,
    _: &Subject,
    question: &Question,
) -> Cancellable<Option<TraceResult>> {
    let Some(answer) = question.shown.found() else {
        return Ok(None);
    };
    let report = &answer.report;
    let Some(number) = chosen(report, question.params.check()) else {
        return Ok(None);
    };
    let check = &report.checks[number];
    let mut trace = of_run(&TraceInput {
        title: title(check),
        unit: report.unit,
        events: check.run(),
        ending: ending(check),
        cycle: check.cycle,
        blocking: &blocking::table(&answer.problem, &answer.options),
    });
    trace.notes.extend(check.note.clone());
    let places = question.shown.places();
    trace
        .placed(|it| locate(snapshot, places, Some(it)))
        .map(Some)
}
