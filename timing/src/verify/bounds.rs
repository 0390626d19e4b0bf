//! Answers from bounds on response times: those of response-time analysis, and of the middle tier.
//!
//! The bounds are never below the exact values, so a task with a bound below its period meets its deadlines.
//! Such an answer needs no exploration, and remains valid if an exploration is given up.

use std::cell::OnceCell;
use typed_index_collections::{TiVec, ti_vec};

use super::checks::{Single, What};
use super::group::Group;
use super::tasks_with_jobs::tasks_with_jobs;
use crate::abstraction::{Budget, Refusal, abstract_bounds};
use crate::analytic::{meets_deadlines, response_bounds};
use crate::cancel::Cancel;
use crate::report::{CheckReport, Layer, Soundness, Value, Verdict};
use crate::system::indexed::Built;
use crate::system::{TaskId, Ticks};

/// Bounds on the response times of the tasks of a system.
#[derive(Clone)]
pub(super) struct ResponseBounds<'b> {
    built: &'b Built,
    cancel: &'b Cancel,
    bounds: TiVec<TaskId, Option<Ticks>>,
    /// The analysis that found the bound, by task.
    layers: TiVec<TaskId, Layer>,
    /// The middle tier has treated the system.
    abstracted: bool,
    /// Tasks of which a run with a job is known, by task.
    released: OnceCell<TiVec<TaskId, bool>>,
}

impl<'b> ResponseBounds<'b> {
    pub(super) fn new(built: &'b Built, cancel: &'b Cancel) -> Self {
        ResponseBounds {
            built,
            cancel,
            bounds: response_bounds(&built.system, cancel),
            layers: ti_vec![Layer::ResponseTimeAnalysis; built.system.tasks.len()],
            abstracted: false,
            released: OnceCell::new(),
        }
    }

    /// Improves the bounds with the middle tier. Returns the tasks with periods whose deadlines are not
    /// proved by it, if some task has a bound, or the reason why none has one.
    pub(super) fn abstracted(
        &mut self,
        bytes: usize,
        cancel: &Cancel,
    ) -> Result<Vec<(TaskId, Refusal)>, Refusal> {
        let budget = Budget { bytes, ..Budget::default() };
        let system = &self.built.system;
        let found = abstract_bounds(system, budget, cancel);
        let periodic = |task: &TaskId| system.tasks[*task].period.is_some();
        let open = found.keys().filter(periodic);
        let open = open.filter_map(|task| match found[task] {
            Ok(bound) if meets_deadlines(system, task, Some(bound)) => None,
            Ok(_) => Some((task, Refusal::MayMiss { task })),
            Err(refusal) => Some((task, refusal)),
        });
        let open: Vec<(TaskId, Refusal)> = open.collect();
        for (task, &found) in found.iter_enumerated() {
            let bound = &mut self.bounds[task];
            if let Ok(found) = found
                && bound.is_none_or(|bound| found < bound)
            {
                *bound = Some(found);
                self.layers[task] = Layer::ScheduleAbstraction;
            }
        }
        self.abstracted |= found.iter().any(Result::is_ok);
        match open.first() {
            Some(&(_, refusal)) if !found.iter().any(Result::is_ok) => Err(refusal),
            _ => Ok(open),
        }
    }

    pub(super) fn path(&self, task: TaskId) -> String {
        self.built.system.task_path(task)
    }

    /// Returns the analysis that found the bound for a check of a task.
    fn layer(&self, check: &Single) -> Layer {
        let task = check.what.task().map(|task| self.built.tasks[&task]);
        task.map_or(Layer::ResponseTimeAnalysis, |task| self.layers[task])
    }

    /// Returns true if a bound of schedule abstraction answers a check of a response time, though possibly
    /// not with the least bound.
    pub(super) fn answers_check(&self, check: &Single, limit: Option<Ticks>) -> bool {
        let within = |bound: Ticks| limit.is_none_or(|limit| bound <= limit);
        self.abstracted && self.response(check).is_some_and(within)
    }

    /// Returns the bound that proves a check of deadlines: on the response time, or on the time for which a
    /// job waits for a core.
    fn deadline_bound(&self, check: &Single) -> Option<Ticks> {
        let system = &self.built.system;
        match check.what {
            What::Schedulable(of) => {
                let task = self.built.tasks[&of];
                let bound = self.bounds[task];
                bound.filter(|_| meets_deadlines(system, task, bound))
            }
            What::NoOverdue(of) => {
                let task = self.built.tasks[&of];
                let bound = if system.needs_core(task) { self.bounds[task] } else { Some(0) };
                bound.filter(|&bound| Some(bound) < system.tasks[task].period)
            }
            _ => None,
        }
    }

    /// Returns the bound that proves a check of deadlines, if the task certainly has jobs. Otherwise only an
    /// exploration can tell whether the check is vacuous.
    pub(super) fn deadline(&self, check: &Single) -> Option<Ticks> {
        let bound = self.deadline_bound(check)?;
        let task = self.built.tasks[&check.what.task()?];
        self.is_released(task).then_some(bound)
    }

    /// Returns the bound that proves a check of deadlines if the task has jobs, if that is not certain.
    pub(super) fn deadline_on_condition(&self, check: &Single) -> Option<Ticks> {
        let bound = self.deadline_bound(check)?;
        let task = self.built.tasks[&check.what.task()?];
        (!self.is_released(task)).then_some(bound)
    }

    /// Returns true if the task certainly has jobs.
    fn is_released(&self, task: TaskId) -> bool {
        self.released.get_or_init(|| tasks_with_jobs(&self.built.system, self.cancel))[task]
    }

    /// Returns a bound on the response time of the task, for a check of a deadline or a response time.
    pub(super) fn of_task(&self, check: &Single) -> Option<Ticks> {
        match check.what {
            What::Schedulable(task) | What::Response(task, _) => {
                self.bounds[self.built.tasks[&task]]
            }
            _ => None,
        }
    }

    /// Returns a bound on the response time of the task, for a check of a response time.
    pub(super) fn response(&self, check: &Single) -> Option<Ticks> {
        match check.what {
            What::Response(response, _) => self.bounds[self.built.tasks[&response]],
            _ => None,
        }
    }

    /// Returns true if the response time of the task is zero, and the task has jobs.
    pub(super) fn is_zero(&self, check: &Single) -> bool {
        let What::Response(response, _) = check.what else {
            return false;
        };
        let task = self.built.tasks[&response];
        let system = &self.built.system.tasks[task];
        // A task for which the middle tier found no time may have no job at all.
        let exists = self.layers[task] == Layer::ResponseTimeAnalysis;
        exists
            && self.bounds[task] == Some(0)
            && system.period.is_some()
            && !system.keep_idle_tick
            && self.is_released(task)
    }
}

impl Group<'_> {
    pub(super) fn meets_deadlines(
        &self,
        check: &Single,
        bound: Ticks,
        analysed: &ResponseBounds,
    ) -> CheckReport {
        let blank = self.blank(check);
        let by = analysed.layer(check);
        CheckReport {
            verdict: Verdict::Proved,
            soundness: for_any_time(blank.soundness),
            by: Some(by),
            note: Some(match check.what {
                What::NoOverdue(_) if bound == 0 => "no job ever waits for a core".to_owned(),
                _ => format!("by {by}: a job takes at most {}", self.describe(bound)),
            }),
            ..blank
        }
    }

    pub(super) fn takes_no_time(&self, check: &Single) -> CheckReport {
        CheckReport {
            verdict: Verdict::Proved,
            value: Some(self.time(0)),
            by: Some(Layer::ResponseTimeAnalysis),
            note: Some("by response-time analysis: a job takes no time".to_owned()),
            soundness: for_any_time(self.blank(check).soundness),
            ..self.blank(check)
        }
    }

    /// Uses a bound of analysis for a check whose exploration covered only whole units of time, if ends at
    /// other times make a difference.
    pub(super) fn bound_between_units(
        &self,
        check: &Single,
        analysed: &ResponseBounds,
        out: &mut CheckReport,
    ) {
        if out.soundness != Soundness::WholeUnits {
            return;
        }
        let (Verdict::Proved, Some(bound)) = (out.verdict, analysed.response(check)) else {
            return;
        };
        let What::Response(_, limit) = check.what else {
            return;
        };
        let (bound_text, by) = (self.describe(bound), analysed.layer(check));
        if self.ticks(limit).is_some_and(|limit| bound > limit) {
            out.note = Some(format!("for ends at any time analysis knows a bound of {bound_text}"));
        } else if out.value == Some(self.time(bound)) {
            out.soundness = Soundness::Exact;
            out.by = Some(by);
        } else {
            let reached = match out.value {
                Some(value @ Value::Time(time)) if time > 0.0 => {
                    format!(", and {} is reached", self.unit.show_value(value))
                }
                _ => String::new(),
            };
            out.note = Some(format!(
                "by {by}: at most {bound_text}{reached}; ends between whole units of time were not \
                    explored"
            ));
            out.value = Some(self.time(bound));
            out.soundness = Soundness::UpperBound;
            out.by = Some(by);
            out.witness.clear();
            out.left_out = false;
            out.kept = None;
        }
    }

    /// Uses a bound of analysis for a check whose exploration was given up.
    pub(super) fn bound_unknown(
        &self,
        check: &Single,
        analysed: &ResponseBounds,
        out: &mut CheckReport,
    ) {
        if out.verdict == Verdict::Unknown
            && let Some(bound) = analysed.deadline_bound(check)
        {
            // A task that is never released meets its deadlines too.
            let met = self.meets_deadlines(check, bound, analysed).note;
            out.note = met.map(|met| format!("{met}; no run that has a job was found"));
            return;
        }
        let (Verdict::Unknown, Some(bound)) = (out.verdict, analysed.of_task(check)) else {
            return;
        };
        let within = match check.what {
            What::Response(_, limit) => self.ticks(limit).is_none_or(|limit| bound <= limit),
            _ => false,
        };
        let by = analysed.layer(check);
        self.bounded_by((&by.to_string(), "a job takes"), bound, within, out);
        if out.verdict == Verdict::Proved {
            out.by = Some(by);
        }
    }

    /// Adds a bound of analysis to an open check. The bound is an answer if it is within the limit. `by`
    /// names the analysis, and `what` is the text before "at most".
    pub(super) fn bounded_by(
        &self,
        (by, what): (&str, &str),
        bound: Ticks,
        within: bool,
        out: &mut CheckReport,
    ) {
        if !within {
            if let Some(note) = &mut out.note {
                let bound = self.describe(bound);
                note.push_str(&format!("; by {by} {what} at most {bound}"));
            }
            return;
        }
        out.verdict = Verdict::Proved;
        if out.value == Some(self.time(bound)) {
            // A run reaches the bound, so that the bound is exact.
            (out.note, out.gave_up) = (None, None);
            return;
        }
        let why = out.gave_up.map_or(String::new(), |gave_up| format!(": {gave_up}"));
        let reached = match out.value {
            Some(value @ Value::Time(time)) if time > 0.0 => {
                format!(", and {} is reached", self.unit.show_value(value))
            }
            _ => String::new(),
        };
        out.note = Some(format!(
            "by {by}: at most {}{reached}; the exact value was not found{why}",
            self.describe(bound)
        ));
        out.value = Some(self.time(bound));
        out.soundness = Soundness::UpperBound;
        out.witness.clear();
        out.left_out = false;
        out.kept = None;
    }
}

/// Returns the soundness of an answer of analysis, which holds for any times at which codels end.
fn for_any_time(soundness: Soundness) -> Soundness {
    match soundness {
        Soundness::WholeUnits => Soundness::Exact,
        other => other,
    }
}
