//! The effect of rounding to the unit of a scenario (section 20 of the timed semantics).

use crate::report::{CheckReport, Report, Soundness, Verdict};
use crate::system::indexed::Built;
use crate::system::units;
use dotgen_analysis::quantity;

/// The note of a check that fails with rounded times only, as far as is known.
const UNCONFIRMED: &str = "it fails with durations rounded to the unit of the scenario, and no run with the exact \
                           ones was found";

/// The note of a check whose answer with rounded times is none with the exact ones.
const ROUNDED_ONLY: &str = "it was answered with durations rounded to the unit of the scenario only, which says \
                            nothing about the exact ones; their common unit is too fine";

/// Number of codels named in the note; further codels are only counted.
const NAMED: usize = 4;

/// Returns a note about the rounded codels: their effect on the answers that were found with them. `None` if
/// no codel was rounded.
pub(super) fn note(built: &Built) -> Option<String> {
    let rounded = &built.rounded;
    if rounded.is_empty() {
        return None;
    }
    let names = rounded.iter().take(NAMED).map(|rounded| {
        let times = [rounded.exact, rounded.taken].map(quantity::time);
        format!("{} ({} taken as {})", rounded.codel, times[0], times[1])
    });
    let mut names = names.collect::<Vec<_>>().join(", ");
    if rounded.len() > NAMED {
        names += &format!(" and {} more", rounded.len() - NAMED);
    }
    let exact = match built.exact_unit.and_then(units::as_written) {
        Some(unit) => format!("`unit {unit};` gives exact values"),
        None => "without `unit`, values are exact".to_owned(),
    };
    Some(format!(
        "rounded to the unit of the scenario: {names}; what is proved holds for the exact times, and values are upper \
         bounds; {exact}"
    ))
}

/// Leaves checks open whose answers with rounded times say nothing about the exact ones, in a system that can
/// only be explored with rounded times.
pub(super) fn leave_open(whole: &Built, report: &mut Report) {
    if whole.rounded.is_empty() {
        return;
    }
    let answered = |check: &&mut CheckReport| {
        check.rounded && (check.verdict.holds() || check.verdict == Verdict::Refuted)
    };
    let mut holds = false;
    for check in report.checks.iter_mut().filter(answered) {
        if is_proof(check) {
            holds = true;
            continue;
        }
        check.verdict = Verdict::Unknown;
        check.value = None;
        check.note = Some(ROUNDED_ONLY.to_owned());
    }
    for check in &mut report.checks {
        if check.candidate.is_some() && check.verdict == Verdict::Unknown {
            check.note = Some(ROUNDED_ONLY.to_owned());
        }
    }
    if holds {
        report.notes.extend(note(whole));
    }
}

/// Adds to the notes of checks without verdict that they fail with rounded times.
pub(super) fn note_unconfirmed(unconfirmed: &[usize], report: &mut Report) {
    for &i in unconfirmed {
        let check = &mut report.checks[i];
        if check.verdict == Verdict::Unknown {
            let note = check.note.take().map_or(String::new(), |note| note + "; ");
            check.note = Some(note + UNCONFIRMED);
        }
    }
}

/// Returns true if an answer with rounded times is one with the exact times: with intervals, rounding only
/// adds runs. (A predicate that is never reached is refuted.) Times are upper bounds, and those beyond their
/// limit are left to the exact exploration.
pub(super) fn is_proof(found: &CheckReport) -> bool {
    let answered = found.verdict.holds() || found.verdict == Verdict::Refuted;
    let limit = found.limit.zip(found.value);
    let within = limit.is_none_or(|(limit, value)| !limit.is_exceeded_by(value));
    answered && found.soundness == Soundness::Safe && within
}
