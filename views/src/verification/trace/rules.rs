//! Descriptions of the rules of the model, a sentence each. `docs/verification.md` has the same table.

use dotgen_timing::explore::MomentKind;

/// The name of a rule, as in the JSON of a verification, and its description.
pub(super) fn rule(kind: MomentKind) -> (&'static str, &'static str) {
    match kind {
        MomentKind::Tick => ("tick", "The timer of the task has come round."),
        MomentKind::Release => {
            ("release", "The task takes the tick, or is woken, and asks for a core.")
        }
        MomentKind::Grant => ("grant", "The task gets a core."),
        MomentKind::Wait => ("wait", "The codel waits until no codel executes that excludes it."),
        MomentKind::Begin => ("begin", "The codel takes its locks and executes."),
        MomentKind::End => (
            "end",
            "The codel has ended, releases its locks, and goes to one of the states that it yields.",
        ),
        MomentKind::Complete => ("complete", "The job has ended and gives its core back."),
        MomentKind::Request => ("request", "A client or a control task did something."),
        MomentKind::Excess => ("excess", "The limit of the check is exceeded."),
    }
}
