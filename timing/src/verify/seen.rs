//! The worst results of short explorations: failures, and the longest times. If the whole exploration is
//! given up, the report contains these results.

use crate::report::{CheckReport, Value, Verdict};

/// By check, the worst that has been seen: a failure, or the longest time.
#[derive(Clone)]
pub(super) struct Seen(Vec<Option<CheckReport>>);

impl Seen {
    /// Nothing has been seen of a number of checks.
    pub(super) fn none(checks: usize) -> Seen {
        Seen(vec![None; checks])
    }

    pub(super) fn note(&mut self, check: usize, report: CheckReport) {
        let time = |report: &CheckReport| match report.value {
            Some(Value::Time(time)) => Some(time),
            _ => None,
        };
        let worse = |old: &CheckReport| match (old.verdict, report.verdict) {
            (Verdict::Refuted, Verdict::Refuted) => false,
            (_, Verdict::Refuted) => true,
            (Verdict::Refuted, _) => false,
            _ => time(&report) > time(old),
        };
        let place = &mut self.0[check];
        if place.as_ref().is_none_or(worse) {
            *place = Some(report);
        }
    }

    /// Adds what has been seen to what is known of a check after an exploration that was given up.
    pub(super) fn add_to(&self, check: usize, out: &mut CheckReport) {
        let Some(report) = &self.0[check] else {
            return;
        };
        if out.verdict != Verdict::Unknown {
            return;
        }
        let longer = match (report.value, out.value) {
            (Some(Value::Time(time)), Some(Value::Time(out))) => time > out,
            (Some(_), None) => true,
            _ => false,
        };
        if report.verdict == Verdict::Refuted || longer {
            *out = CheckReport {
                note: out.note.take(),
                gave_up: out.gave_up.take(),
                ..report.clone()
            };
            if report.verdict != Verdict::Refuted {
                out.verdict = Verdict::Unknown;
            }
        }
    }
}
