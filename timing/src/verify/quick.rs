//! What can be answered soon: with few requests, and in few states.
//!
//! Clients that may send anything at any time make most systems too large to be explored to the end. But what
//! fails usually fails after no request, one or two, and small systems are explored at once. So both are
//! tried before the whole system is explored for what is left. What was seen on the way is not lost: if that
//! exploration has to be given up, failures with a longest time not known and longest times seen are still
//! worth telling.

use std::sync::OnceLock;

use super::checks::{Single, What};
use super::{Group, ResponseBounds};
use crate::explore::{
    Findings, Kind, Limits, ResponseTime, Stop, Walked, Watch, bytes_of_walks, explore, walk,
};
use crate::report::{CheckReport, Report, Value, Verdict};
use crate::system::indexed::Built;
use crate::system::{TaskId, Ticks};

/// How often clients that may wait for ever go on; `None`: as often as they like.
const STAGES: [(Option<usize>, usize); 4] =
    [(Some(0), 100_000), (None, 20_000), (Some(1), 100_000), (Some(2), 100_000)];

/// A stage with requests takes at most this part of the states that the whole may have.
const SHARE: usize = 4;

/// Limit on the actions that look for response times as long as their bounds.
const ACTIONS: u64 = 3_000_000;

/// Limit on the actions that look for missed deadlines before schedule abstraction, which may take long to
/// find that it cannot tell.
const EARLY_ACTIONS: u64 = 200_000;

/// Number of actions of the exploration that comes before walks to missed deadlines.
const FIRST: u64 = 50_000;

/// Number of actions of a small system.
const SMALL: u64 = 20_000;

/// By check, the worst that has been seen: a failure, or the longest time.
pub(super) struct Seen(Vec<Option<CheckReport>>);

impl Seen {
    /// Nothing has been seen of a number of checks.
    pub(super) fn none(checks: usize) -> Seen {
        Seen(vec![None; checks])
    }

    fn note(&mut self, check: usize, report: CheckReport) {
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

impl Group<'_> {
    /// Looks for missed deadlines before schedule abstraction: without requests, if clients may wait for
    /// ever.
    pub(super) fn early(
        &self,
        checks: &[Single],
        of_group: &[usize],
        analysed: &ResponseBounds,
        report: &mut Report,
    ) {
        let staying = self.staying(0);
        let early = Group { built: staying.as_ref().unwrap_or(self.built), ..*self };
        early.walk_to_misses(checks, of_group, analysed, EARLY_ACTIONS, report);
    }

    /// Returns the system whose clients wait for ever after some requests, if they may wait.
    fn staying(&self, rounds: usize) -> Option<Built> {
        let system = self.built.system.waiting_forever_after(rounds)?;
        Some(Built { system, shared: OnceLock::new(), ..self.built.clone() })
    }

    /// Answers what can be answered soon. What is alone and has no clients that may wait is explored anyway.
    pub(super) fn soon(
        &self,
        checks: &[Single],
        of_group: &[usize],
        alone: bool,
        analysed: &ResponseBounds,
        report: &mut Report,
    ) -> Seen {
        let mut seen = Seen::none(checks.len());
        self.walk(checks, of_group, analysed, &mut seen, report);
        for (rounds, states) in STAGES {
            let share = if rounds == Some(0) { 1 } else { SHARE };
            let staying = self.staying(rounds.unwrap_or(0));
            let built = match (rounds, &staying) {
                (None, None) if alone => break,
                (None, _) => self.built,
                (Some(_), None) => continue,
                (Some(_), Some(built)) => built,
            };
            let stage = Group {
                built,
                limits: Limits { states: (self.limits.states / share).min(states), ..self.limits },
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
        self.walk_to_misses(checks, of_group, analysed, ACTIONS, report);
        seen
    }

    /// Looks for missed deadlines that come late.
    fn walk_to_misses(
        &self,
        checks: &[Single],
        of_group: &[usize],
        analysed: &ResponseBounds,
        actions: u64,
        report: &mut Report,
    ) {
        let open = of_group.iter().copied().filter(|&i| report.is_open(i));
        let deadlines = open.filter(|&i| matches!(checks[i].what, What::Schedulable(_)));
        let (mut watch, places) = self.watch(checks, deadlines, analysed);
        if places.is_empty() || self.limits.without.contains(Kind::RandomSearch) {
            return;
        }
        // An exploration finds the shortest runs, if they are short.
        let limits = Limits { steps: self.limits.steps.min(FIRST).min(actions / 4), ..self.limits };
        let explored = explore(&self.built.system, &watch, limits, self.cancel);
        if matches!(explored.stopped, None | Some(Stop::Answered)) {
            return;
        }
        // The longest job and the first missed deadline of each task.
        let bytes = bytes_of_walks(2 * places.len());
        if explored.bytes + bytes > self.limits.bytes {
            return;
        }
        watch.response.clear();
        // An action takes less time than a state that is kept.
        let actions = actions.min((self.limits.states as u64).saturating_mul(8));
        let walked = walk(&self.built.system, &watch, actions, self.cancel);
        let runs = explored.missed.into_iter().zip(walked.missed);
        let found = Findings {
            missed: runs.map(|(shortest, walked)| shortest.or(walked)).collect(),
            states: explored.states + walked.actions as usize,
            stopped: Some(Stop::States),
            ..Findings::default()
        };
        report.effort(&found);
        let before = report.answered();
        for (i, place) in places {
            let entry = self.one(&checks[i], place, &found);
            if entry.verdict == Verdict::Refuted {
                report.answer(i, entry);
            }
        }
        if report.answered() > before {
            (self.tell)(report);
        }
    }

    /// Looks for response times as long as their bounds, which are then exact, and for jobs of tasks that
    /// meet their deadlines if they have any.
    fn walk(
        &self,
        checks: &[Single],
        of_group: &[usize],
        analysed: &ResponseBounds,
        seen: &mut Seen,
        report: &mut Report,
    ) {
        if self.limits.without.contains(Kind::RandomSearch) {
            return;
        }
        let open: Vec<usize> = of_group.iter().copied().filter(|&i| report.is_open(i)).collect();
        let settled = open.iter().copied().filter(|&i| self.is_settled(&checks[i], analysed));
        let (mut watch, places) = self.watch(checks, settled, analysed);
        let on_condition = open.iter().filter_map(|&i| {
            let bound = analysed.deadline_on_condition(&checks[i])?;
            Some((i, bound, self.built.tasks[&checks[i].what.task()?]))
        });
        let on_condition: Vec<(usize, Ticks, TaskId)> = on_condition.collect();
        let job = |&(.., task): &(usize, Ticks, TaskId)| ResponseTime {
            task,
            limit: None,
            // Any job is long enough.
            most: Some(0),
        };
        watch.response.extend(on_condition.iter().map(job));
        if watch.response.is_empty() || self.is_small(&watch) {
            return;
        }
        let Walked { response, .. } = walk(&self.built.system, &watch, ACTIONS, self.cancel);
        let found = Findings { response, stopped: Some(Stop::Answered), ..Findings::default() };
        let before = report.answered();
        let jobs = &found.response[found.response.len() - on_condition.len()..];
        for (&(i, bound, _), job) in on_condition.iter().zip(jobs) {
            if job.is_some() {
                report.answer(i, self.meets_deadlines(&checks[i], bound, analysed));
            }
        }
        for (i, place) in places {
            let mut entry = self.one(&checks[i], place, &found);
            let bound = analysed.response(&checks[i]).map(|bound| self.time(bound));
            if entry.value.is_some() && entry.value == bound {
                self.bound_unknown(&checks[i], analysed, &mut entry);
                report.answer(i, entry);
            } else {
                seen.note(i, entry);
            }
        }
        if report.answered() > before {
            (self.tell)(report);
        }
    }

    /// Returns true if an exploration soon comes to its end.
    fn is_small(&self, watch: &Watch) -> bool {
        let limits = Limits { steps: self.limits.steps.min(SMALL), ..self.limits };
        let explored = explore(&self.built.system, watch, limits, self.cancel);
        matches!(explored.stopped, None | Some(Stop::Answered))
    }

    fn stage(
        &self,
        checks: &[Single],
        part: Vec<usize>,
        whole: bool,
        seen: &mut Seen,
        report: &mut Report,
    ) {
        let analysed = ResponseBounds::new(self.built);
        let (mut watch, places) = self.watch(checks, part.into_iter(), &analysed);
        // What fails later is left to later stages.
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
            let mut entry = self.one(&checks[i], place, &found);
            if complete {
                self.bound_unknown(&checks[i], &analysed, &mut entry);
                self.bound_between_units(&checks[i], &analysed, &mut entry);
            }
            // With more requests some other run may take longer, unless this one takes for ever.
            let final_value = matches!(entry.value, None | Some(Value::Unbounded));
            if complete || (entry.verdict == Verdict::Refuted && final_value) {
                report.answer(i, entry);
            } else if found.stopped != Some(Stop::Cancelled) {
                seen.note(i, entry);
            }
        }
        if report.answered() > before {
            (self.tell)(report);
        }
    }
}
