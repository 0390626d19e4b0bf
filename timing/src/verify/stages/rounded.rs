//! Rounded times: proofs in fewer states, and runs that are then looked for with the exact times.
//!
//! If a scenario states a unit, execution times that are no multiples of it are rounded for a first
//! exploration: lower bounds down, upper bounds up. With intervals that only adds runs, so what holds there
//! holds. What fails there is a candidate: a run with the exact times and the same decisions is looked for
//! ([`follow`]), and without one the check stays open for the exact exploration.

use num_rational::Ratio;

use super::{ROUNDED, by, exploration};
use crate::explore::{Limits, follow};
use crate::report::{CheckReport, Report, Verdict};
use crate::system::build::build;
use crate::system::settings::Settings;
use crate::verify::bounds::ResponseBounds;
use crate::verify::checks::Single;
use crate::verify::group::Group;
use crate::verify::part::Part;
use crate::verify::rounding::{self, is_proof};
use crate::verify::seen::Seen;

/// The exact exploration that is tried before rounded times has at most this part of the greatest number of
/// states as actions.
const SMALL: usize = 200;

/// Ratio of the units with rounded and with exact times from which on rounding pays.
const COARSER: i128 = 8;

/// Part of the states that the exploration with rounded times may have.
const SHARE: usize = 4;

/// Answers checks with rounded times, if their exact exploration is not short.
pub(super) fn answer(part: &mut Part, report: &mut Report) {
    let group = part.group;
    if !group.built.rounded.is_empty() {
        return;
    }
    let settings = Settings { rounds: true, ..group.settings.clone() };
    let coarse = build(group.names, &settings, &|c| group.built.components.contains_key(&c));
    let coarser = coarse.system.unit / group.built.system.unit;
    let pays = coarser >= Ratio::from_integer(COARSER) && !coarse.rounded.is_empty();
    if !pays || coarse.has_errors() {
        return;
    }
    answer_small(part, report);
    if part.is_done(report) {
        return;
    }
    let mut limits = group.limits;
    limits.states /= SHARE;
    let of_coarse = Group { built: &coarse, settings: &settings, limits, tell: &|_| {}, ..group };
    let mut candidates = scratch(report);
    let mut rounded = [Part::new(of_coarse, part.checks, part.of_group, part.alone)];
    by(&ROUNDED, &mut rounded, &mut candidates);
    add_effort(report, &mut candidates);
    let mut holds = false;
    for (i, check) in part.open(report) {
        let found = &candidates.checks[i];
        if is_proof(found) {
            report.checks[i] = found.clone();
            holds = true;
        } else if let Some(confirmed) = group.confirmed(check, found, &part.analysed) {
            report.answer(i, confirmed);
        } else if found.candidate.is_some() {
            part.unconfirmed.push(i);
        }
    }
    if holds {
        report.notes.extend(rounding::note(&coarse));
    }
}

/// Answers checks whose exact exploration is short.
fn answer_small(part: &mut Part, report: &mut Report) {
    let limits = part.group.limits;
    let small = (limits.states / SMALL) as u64;
    let limits = Limits { steps: limits.steps.min(small), ..limits };
    let mut tried = scratch(report);
    let mut little = Part {
        group: Group { limits, tell: &|_| {}, ..part.group },
        seen: Seen::none(part.checks.len()),
        ..part.clone()
    };
    exploration::answer(&mut little, &mut tried);
    for (i, _) in part.open(report) {
        let check = &tried.checks[i];
        // With more effort, what was given up may be exact.
        if !matches!(check.verdict, Verdict::Unknown | Verdict::Open) && check.gave_up.is_none() {
            report.checks[i] = check.clone();
        }
    }
    for note in std::mem::take(&mut tried.notes) {
        report.note(note);
    }
    add_effort(report, &mut tried);
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

impl Group<'_> {
    /// Looks for a run with the exact times that does what a run with rounded times does.
    fn confirmed(
        &self,
        check: &Single,
        found: &CheckReport,
        analysed: &ResponseBounds,
    ) -> Option<CheckReport> {
        let guide = found.candidate.as_ref()?;
        if check.what.is_lasting() {
            return None;
        }
        let (watch, places) = self.watch(std::slice::from_ref(check), [0].into_iter(), analysed);
        let &(_, place) = places.first()?;
        let findings = follow(&self.built.system, &watch, guide, self.cancel)?;
        let mut out = self.one(check, place, &findings);
        // The run ends where the limit is exceeded; how much longer it can take was not looked for.
        out.value = None;
        matches!(out.verdict, Verdict::Refuted | Verdict::Proved).then_some(out)
    }
}
