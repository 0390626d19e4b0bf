//! Exploration of all runs. It answers every check, or says how far it came.

use crate::explore::{Findings, Limits, explore_with_reports};
use crate::report::Report;
use crate::verify::bounds::ResponseBounds;
use crate::verify::checks::{Single, What};
use crate::verify::group::Group;
use crate::verify::part::Part;

/// Divisor of the limit on states, for the search of exact values after bounds have answered all checks.
const SETTLED: usize = 100;

/// Limit on actions, for the search of exact values after bounds have answered all checks.
const STEPS_IF_SETTLED: u64 = 200_000;

/// Limit on actions, for the search of exact values where bounds lie beyond periods.
const STEPS_IF_BOUNDED: u64 = 10_000_000;

pub(super) fn answer(part: &mut Part, report: &mut Report) {
    let Part { group, ref analysed, .. } = *part;
    // Checks that rule out reductions are explored apart from checks that do not.
    let (together, apart): (Vec<_>, Vec<_>) =
        part.open(report).into_iter().partition(|(_, check)| group.is_about_ticks(check));
    // Less effort is spent on exact values.
    let (settled, unsettled): (Vec<_>, Vec<_>) =
        together.into_iter().partition(|(_, check)| group.is_settled(check, analysed));
    for some in [unsettled, settled, apart] {
        let (lasting, explored): (Vec<_>, Vec<_>) =
            some.into_iter().partition(|(_, check)| check.what.is_lasting());
        if !part.is_done(report) && !explored.is_empty() {
            explore_some(part, explored.into_iter().map(|(i, _)| i).collect(), report);
        }
        for (i, check) in lasting {
            if part.is_done(report) {
                break;
            }
            let entry = match check.what {
                What::LeadsTo(p, q) => group.live(check, Some(p), q, report),
                What::Eventually(p) => group.live(check, None, p, report),
                What::Chain(of) => group.chain(check, of, report),
                _ => continue,
            };
            report.answer(i, entry);
            (group.tell)(report);
        }
    }
}

fn explore_some(part: &mut Part, some: Vec<usize>, report: &mut Report) {
    let Part { group, checks, ref analysed, .. } = *part;
    let limits = group.limits_for(checks, &some, analysed);
    let (mut watch, places) = group.watch(checks, some.into_iter(), analysed);
    watch.stop_at_first = group.until_failure;
    let mut news = |found: &Findings| {
        group.final_answers(checks, &places, found, report);
        (group.tell)(report);
    };
    let system = &group.built.system;
    let found = explore_with_reports(system, &watch, limits, group.cancel, &mut news);
    report.effort(&found);
    // An exploration that begins again may reach the answer by another run, so reported answers stay.
    let open = places.into_iter().filter(|place| report.is_open(place.0));
    for (i, place) in open.collect::<Vec<_>>() {
        let mut entry = group.one(&checks[i], place, &found);
        part.seen.add_to(i, &mut entry);
        group.bound_unknown(&checks[i], analysed, &mut entry);
        group.bound_between_units(&checks[i], analysed, &mut entry);
        group.after_all(&checks[i], &found, &mut entry);
        report.answer(i, entry);
    }
    part.refusals(&found, report);
    (group.tell)(report);
}

impl Group<'_> {
    /// Returns true if a bound answers a check of a response time.
    pub(super) fn is_settled(&self, check: &Single, analysed: &ResponseBounds) -> bool {
        match check.what {
            What::Response(of, limit) => {
                // Beyond its period, a bound says little.
                let period = self.built.system.tasks[self.built.tasks[&of]].period;
                analysed.answers_check(check, self.ticks(limit).or(period))
            }
            _ => false,
        }
    }

    /// Returns the limits for some checks. If each of them has a bound, exact values are worth less effort,
    /// and still less if the bounds answer the checks.
    fn limits_for(&self, checks: &[Single], some: &[usize], analysed: &ResponseBounds) -> Limits {
        if some.iter().all(|&i| self.is_settled(&checks[i], analysed)) {
            Limits {
                states: self.limits.states / SETTLED,
                steps: self.limits.steps.min(STEPS_IF_SETTLED),
                ..self.limits
            }
        } else if some.iter().all(|&i| analysed.response(&checks[i]).is_some()) {
            Limits { steps: self.limits.steps.min(STEPS_IF_BOUNDED), ..self.limits }
        } else {
            self.limits
        }
    }

    /// Answers the checks that no later state of an exploration can change.
    fn final_answers(
        &self,
        checks: &[Single],
        places: &[(usize, usize)],
        found: &Findings,
        report: &mut Report,
    ) {
        for &(i, place) in places {
            let seen = match checks[i].what {
                What::Schedulable(_) => found.missed[place].is_some(),
                What::NoOverdue(_) => found.overdue[place].is_some(),
                What::Always(_) | What::Reachable(_) | What::Pattern(_) => {
                    found.reached[place].is_some()
                }
                _ => continue,
            };
            if seen && report.is_open(i) {
                report.answer(i, self.one(&checks[i], place, found));
            }
        }
    }
}
