//! Rounded times: proofs in fewer states, and runs that are then looked for with the exact times.
//!
//! If a scenario states a unit, execution times that are no multiples of it are rounded for a first
//! exploration: lower bounds down, upper bounds up. With intervals that only adds runs, so what holds there
//! holds. What fails there is a candidate: a run with the exact times and the same decisions is looked for
//! ([`follow`]), and without one the check stays open for the exact exploration.

use num_rational::Ratio;

use super::checks::{Single, What};
use super::quick::Seen;
use super::{Group, Parted, ResponseBounds, parted, rounding};
use crate::explore::{Limits, follow};
use crate::report::{CheckReport, Report, Soundness, Verdict};
use crate::system::build::build;
use crate::system::indexed::Built;
use crate::system::settings::Settings;

/// The note of a check that fails with rounded times only, as far as is known.
const UNCONFIRMED: &str = "it fails with durations rounded to the unit of the scenario, and no run with the exact \
                           ones was found";

/// The note of a check whose answer with rounded times is none with the exact ones.
const ROUNDED_ONLY: &str = "it was answered with durations rounded to the unit of the scenario only, which says \
                            nothing about the exact ones; their common unit is too fine";

/// The exact exploration that is tried before rounded times has at most this part of the greatest number of
/// states as actions.
const SMALL: usize = 200;

/// Ratio of the units with rounded and with exact times from which on rounding pays.
const COARSER: i128 = 8;

/// Part of the states that the exploration with rounded times may have.
const SHARE: usize = 4;

/// Returns the system with times rounded to the unit of the scenario; `None` if no time has to be rounded, or
/// if that saves too few states.
pub(super) fn rounded(group: &Group) -> Option<Built> {
    let settings = Settings { rounds: true, ..group.settings.clone() };
    let built = build(group.names, &settings, &|_| true);
    let coarser = built.system.unit / group.built.system.unit;
    let pays = coarser >= Ratio::from_integer(COARSER) && !built.rounded.is_empty();
    (pays && !built.has_errors()).then_some(built)
}

/// Answers open checks with rounded times. Returns the checks that fail with them, and for which no run with
/// the exact times was found.
pub(super) fn answer(
    exact: &[Parted],
    of_whole: Group,
    checks: &[Single],
    report: &mut Report,
) -> Vec<usize> {
    if !of_whole.built.rounded.is_empty() || report.answered() == checks.len() {
        return Vec::new();
    }
    let Some(coarse) = rounded(&of_whole) else {
        return Vec::new();
    };
    answer_small(exact, of_whole, checks, report);
    if report.answered() == checks.len() {
        return Vec::new();
    }
    let settings = Settings { rounds: true, ..of_whole.settings.clone() };
    let mut limits = of_whole.limits;
    limits.states /= SHARE;
    let group = Group { built: &coarse, settings: &settings, limits, tell: &|_| {}, ..of_whole };
    let mut candidates = scratch(report);
    let parts = parted(of_whole.names, &settings, &coarse, checks);
    for part in &parts {
        let group = Group { built: &part.built, ..group };
        let mut analysed = ResponseBounds::new(&part.built);
        group.analyse(checks, &part.of_group, &analysed, &mut candidates);
        group.abstracted(checks, &part.of_group, &mut analysed, &mut candidates);
        let nothing = Seen::none(checks.len());
        group.rest(checks, &part.of_group, &analysed, &nothing, &mut candidates);
    }
    add_effort(report, &mut candidates);
    let open: Vec<usize> = (0..checks.len()).filter(|&i| report.is_open(i)).collect();
    let (mut holds, mut unconfirmed) = (false, Vec::new());
    for i in open {
        let found = &candidates.checks[i];
        if is_proof(found) {
            report.checks[i] = found.clone();
            holds = true;
        } else if let Some(part) = exact.iter().find(|part| part.of_group.contains(&i)) {
            let group = Group { built: &part.built, ..of_whole };
            match group.confirmed(&checks[i], found) {
                Some(confirmed) => report.answer(i, confirmed),
                None => unconfirmed.extend(found.candidate.is_some().then_some(i)),
            }
        }
    }
    if holds {
        report.notes.extend(rounding::note(&coarse));
    }
    (of_whole.tell)(report);
    unconfirmed
}

/// Answers checks whose exact exploration is short.
fn answer_small(exact: &[Parted], of_whole: Group, checks: &[Single], report: &mut Report) {
    let small = (of_whole.limits.states / SMALL) as u64;
    let limits = Limits { steps: of_whole.limits.steps.min(small), ..of_whole.limits };
    for part in exact {
        let group = Group { built: &part.built, limits, tell: &|_| {}, ..of_whole };
        let mut tried = scratch(report);
        let (analysed, nothing) = (ResponseBounds::new(&part.built), Seen::none(checks.len()));
        group.rest(checks, &part.of_group, &analysed, &nothing, &mut tried);
        for &i in &part.of_group {
            let check = &tried.checks[i];
            // With more effort, what was given up may be exact.
            if report.is_open(i) && check.verdict != Verdict::Unknown && check.gave_up.is_none() {
                report.checks[i] = check.clone();
            }
        }
        for note in std::mem::take(&mut tried.notes) {
            report.note(note);
        }
        add_effort(report, &mut tried);
    }
}

/// A report with the same answers, for answers that need not be those of the report.
fn scratch(report: &mut Report) -> Report {
    let reductions = std::mem::take(&mut report.reductions);
    Report { checks: report.checks.clone(), reductions, ..Report::default() }
}

/// Adds the effort of a [`scratch`] report.
fn add_effort(report: &mut Report, other: &mut Report) {
    report.states += other.states;
    report.steps += other.steps;
    report.memory = report.memory.max(other.memory);
    report.reductions = std::mem::take(&mut other.reductions);
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
        report.notes.extend(rounding::note(whole));
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
fn is_proof(found: &CheckReport) -> bool {
    let answered = found.verdict.holds() || found.verdict == Verdict::Refuted;
    let limit = found.limit.zip(found.value);
    let within = limit.is_none_or(|(limit, value)| !limit.is_exceeded_by(value));
    answered && found.soundness == Soundness::Safe && within
}

impl Group<'_> {
    /// Looks for a run with the exact times that does what a run with rounded times does.
    fn confirmed(&self, check: &Single, found: &CheckReport) -> Option<CheckReport> {
        let guide = found.candidate.as_ref()?;
        let analysed = ResponseBounds::new(self.built);
        let (watch, places) = self.watch(std::slice::from_ref(check), [0].into_iter(), &analysed);
        let &(_, place) = places.first()?;
        if matches!(check.what, What::LeadsTo(..) | What::Eventually(_) | What::Chain(_)) {
            return None;
        }
        let findings = follow(&self.built.system, &watch, guide, self.cancel)?;
        let mut out = self.one(check, place, &findings);
        // The run ends where the limit is exceeded; how much longer it can take was not looked for.
        out.value = None;
        matches!(out.verdict, Verdict::Refuted | Verdict::Proved).then_some(out)
    }
}
