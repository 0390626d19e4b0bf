//! Early answers: with few requests, and in few states.
//!
//! Clients that may send requests at any time make most systems too large for a complete exploration. But
//! most failures show after no request, one or two, and small systems are explored at once. So runs with few
//! requests are explored before the whole system. The results are kept: if the complete exploration has to be
//! given up, failures and longest times seen are still reported.

use super::checks::Single;
use super::{Analysed, Group};
use crate::explore::{Limits, Stop, explore};
use crate::report::{CheckReport, Report, Value, Verdict};
use crate::system::built::Built;

/// The stages: number of delays without an upper bound that clients pass (`None`: no limit), and upper limit
/// on states.
const STAGES: [(Option<usize>, usize); 4] = [
    (Some(0), 100_000),
    (None, 20_000),
    (Some(1), 100_000),
    (Some(2), 100_000),
];

/// The worst result so far, by check: a failure, or the longest time.
pub(super) struct Seen(Vec<Option<CheckReport>>);

impl Seen {
    fn note(&mut self, check: usize, it: CheckReport) {
        let time = |it: &CheckReport| match it.value {
            Some(Value::Time(time)) => Some(time),
            _ => None,
        };
        let worse = |old: &CheckReport| match (old.verdict, it.verdict) {
            (Verdict::Refuted, Verdict::Refuted) => false,
            (_, Verdict::Refuted) => true,
            (Verdict::Refuted, _) => false,
            _ => time(&it) > time(old),
        };
        let place = &mut self.0[check];
        if place.as_ref().is_none_or(worse) {
            *place = Some(it);
        }
    }

    /// Adds the early results to a check whose exploration was given up.
    pub(super) fn add_to(&self, check: usize, out: &mut CheckReport) {
        let Some(it) = &self.0[check] else {
            return;
        };
        if out.verdict != Verdict::Unknown {
            return;
        }
        let longer = match (it.value, out.value) {
            (Some(Value::Time(it)), Some(Value::Time(out))) => it > out,
            (Some(_), None) => true,
            _ => false,
        };
        if it.verdict == Verdict::Refuted || longer {
            *out = CheckReport {
                note: out.note.take(),
                gave_up: out.gave_up.take(),
                ..it.clone()
            };
            if it.verdict != Verdict::Refuted {
                out.verdict = Verdict::Unknown;
            }
        }
    }
}

impl Group<'_> {
    /// Answers the checks that few requests or few states can answer. A single group without clients that may
    /// wait is left to the complete exploration.
    pub(super) fn soon(
        &self,
        checks: &[Single],
        of_group: &[usize],
        alone: bool,
        report: &mut Report,
    ) -> Seen {
        let mut seen = Seen(vec![None; checks.len()]);
        for (rounds, states) in STAGES {
            let staying = self.built.system.staying_after(rounds.unwrap_or(0));
            let built = match (rounds, staying) {
                (None, None) if alone => break,
                (None, _) => self.built,
                (Some(_), None) => continue,
                (Some(_), Some(system)) => &Built {
                    system,
                    ..self.built.clone()
                },
            };
            let stage = Group {
                built,
                limits: Limits {
                    states: self.limits.states.min(states),
                    ..self.limits
                },
                ..*self
            };
            let open = of_group.iter().copied();
            let (ticks, others): (Vec<usize>, Vec<usize>) = open
                .filter(|&i| report.is_open(i) && checks[i].is_of_task())
                .partition(|&i| self.is_about_ticks(&checks[i]));
            for part in [ticks, others] {
                stage.stage(checks, part, rounds.is_none(), &mut seen, report);
            }
        }
        seen
    }

    fn stage(
        &self,
        checks: &[Single],
        part: Vec<usize>,
        whole: bool,
        seen: &mut Seen,
        report: &mut Report,
    ) {
        let analysed = Analysed::new(self.built);
        let (mut watch, places) = self.watch(checks, part.into_iter(), &analysed);
        // Later failures are left to later stages.
        watch.in_order = true;
        if places.is_empty() {
            return;
        }
        let found = explore(&self.built.system, &watch, self.limits, self.cancel);
        report.effort(&found);
        let complete = whole && matches!(found.stopped, None | Some(Stop::Answered));
        if complete {
            self.refusals(&found, report);
        }
        let before = report.answered();
        for (i, place) in places {
            let mut it = self.one(&checks[i], place, &found);
            if complete {
                self.bound_unknown(&checks[i], &analysed, &mut it);
                self.bound_between_units(&checks[i], &analysed, &mut it);
            }
            // With more requests another run may take longer, unless this run already takes for ever.
            let final_value = matches!(it.value, None | Some(Value::Unbounded));
            if complete || (it.verdict == Verdict::Refuted && final_value) {
                report.answer(i, it);
            } else if found.stopped != Some(Stop::Cancelled) {
                seen.note(i, it);
            }
        }
        if report.answered() > before {
            (self.tell)(report);
        }
    }
}
