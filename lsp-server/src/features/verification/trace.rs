//! `dotgen/trace`: the run of a check as data, for a viewer. `docs/trace.md` describes the form.

use dotgen_analysis::host::Cancellable;

use dotgen_timing::report::CheckReport;
use dotgen_timing::verify::{Choice, Simulation, SystemInput};
use dotgen_views::verification::blocking;
use dotgen_views::verification::results::Answer;
use dotgen_views::verification::runs::{Ending, chosen, ending, title};
use dotgen_views::verification::trace::{Trace, TraceInput, of_run};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::answer::{Question, locate};
use super::diagnostics::changes;
use super::remedy;
use crate::protocol::types::Location;
use crate::workspace::snapshot::{Snapshot, Subject};

/// Maximum number of chosen steps.
const MAX_TAKEN: usize = 1000;

/// Answer of `dotgen/trace`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct TraceResult {
    #[serde(flatten)]
    trace: Trace<Option<Location>>,
    /// The number of the check.
    check: usize,
    /// The steps that may follow, if the request has `after`, and the number of steps of the trace before
    /// each chosen step.
    #[serde(skip_serializing_if = "Option::is_none")]
    next: Option<Value>,
    /// Changes that repair the check.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    remedies: Vec<Value>,
}

/// The run of a check, for a client; none if there is no run.
pub(crate) fn trace(
    snapshot: &Snapshot,
    subject: &Subject,
    question: &Question,
) -> Cancellable<Option<TraceResult>> {
    let Some(answer) = question.shown.found() else {
        return Ok(None);
    };
    let report = &answer.report;
    let wanted = question.params.check();
    let Some(number) = chosen(report, wanted) else {
        return Ok(None);
    };
    // A variation is about the check that the client has asked for, and about no other.
    if question.params.is_varied() && wanted.is_some_and(|wanted| wanted != number) {
        return Ok(None);
    }
    let check = &report.checks[number];
    let simulation = simulated(answer, check, question);
    let mut trace = of_run(&TraceInput {
        title: match simulation {
            Some(_) => format!("{} {}: with chosen steps", check.kind, check.of),
            None => title(check),
        },
        unit: report.unit,
        events: simulation.as_ref().map_or(check.run(), |simulation| &simulation.events),
        ending: match simulation {
            Some(_) => Ending::Fine,
            None => ending(check),
        },
        end: simulation.as_ref().map(|simulation| simulation.end),
        cycle: check.cycle.filter(|_| simulation.is_none()),
        blocking: &blocking::table(&answer.problem, &answer.options),
    });
    if simulation.is_none() {
        trace.notes.extend(check.note.clone());
        trace.focus.cause.clone_from(&answer.view().checks[number].cause);
    }
    let places = question.shown.places();
    let trace = trace.placed(|place| locate(snapshot, places, Some(place)))?;
    let changes = if simulation.is_none() && !question.params.is_varied() {
        changes(answer, &answer.view().checks[number])
    } else {
        Vec::new()
    };
    let remedies = remedy::of_run(snapshot, subject, places, &changes)?;
    let next = simulation.map(|simulation| {
        let choices = simulation.choices.iter().map(|choice| in_words(choice, answer));
        json!({ "choices": choices.collect::<Vec<_>>(), "taken": simulation.taken })
    });
    Ok(Some(TraceResult { trace, check: number, next, remedies }))
}

/// Returns the run of a check continued by the chosen steps, if the request has some.
fn simulated(answer: &Answer, check: &CheckReport, question: &Question) -> Option<Simulation> {
    let after = question.params.after?;
    let take = &question.params.take;
    let take = &take[..take.len().min(MAX_TAKEN)];
    let input = SystemInput { specs: answer.problem.specs() };
    let run = check.kept.as_ref()?;
    Some(run.simulate(&input, answer.report.unit, after, take))
}

fn in_words(choice: &Choice, answer: &Answer) -> String {
    match choice {
        Choice::Step(thread, what) => format!("{thread}: {what}"),
        Choice::Silent(what) => what.clone(),
        Choice::Wait(time) => format!("{} pass", answer.report.unit.show(*time)),
    }
}
