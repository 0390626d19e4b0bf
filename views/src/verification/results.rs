//! The status and results of verifications.

use std::collections::BTreeMap;
use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_timing::derive::MinimumCores;
use dotgen_timing::report::{Report, Verdict};
use dotgen_timing::verify::{Cancel, Options, settings};
use serde::{Deserialize, Serialize};

use super::changes::Repairs;
use super::view::View;
use super::why::FailureCause;
use super::{Problem, TaskBound};
use dotgen_timing::report::TimeUnit;

/// Verifications by their document.
pub type Results = BTreeMap<Utf8PathBuf, Entry>;

/// The status of a verification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// The results are of an earlier text; a verification follows.
    Stale,
    /// The present text is being verified.
    Running,
    /// Every check holds; some may be vacuous, as the response time of a task without period.
    Proved,
    /// Every check has an answer: all are vacuous, or some are beyond the period.
    Answered,
    /// Every check holds, some of them only if something is true that is not stated.
    Conditional,
    /// A check fails.
    Refuted,
    /// No check failed, but some are not settled.
    GaveUp,
    /// No check failed and all are settled, but execution times are missing.
    Nothing,
    /// Errors prevent the verification.
    Blocked,
}

/// One verification.
#[derive(Clone)]
pub struct Entry {
    pub status: Status,
    /// Version of the verified document, if it is open.
    pub version: Option<i32>,
    /// The verified problem.
    pub problem: Arc<Problem>,
    /// The last answer.
    pub answer: Option<Arc<Answer>>,
    /// True if the answer is for `problem`. While the status is running, some of its checks are open.
    pub holds: bool,
    /// Quick bounds of `problem`, as soon as they are known.
    pub bounds: Arc<Vec<TaskBound>>,
    /// The options of the verification.
    pub options: Options,
    /// The number of the verification, to tell it from later ones.
    pub job: u64,
    /// Ends the verification early.
    pub cancel: Arc<Cancel>,
}

impl Entry {
    /// The problem with the places of the answer.
    pub fn places(&self) -> &Arc<Problem> {
        match (self.known(), &self.answer) {
            (None, Some(answer)) => &answer.problem,
            _ => &self.problem,
        }
    }

    /// The results for the present text, complete or partial.
    pub fn known(&self) -> Option<&Arc<Answer>> {
        self.answer.as_ref().filter(|_| self.holds)
    }

    /// The answer, if it is complete and for the present text.
    pub fn settled(&self) -> Option<&Arc<Answer>> {
        self.known().filter(|_| self.status != Status::Running)
    }
}

/// A problem and its results. While the verification runs, the results are partial.
pub struct Answer {
    /// The scenario with its specifications.
    pub problem: Arc<Problem>,
    /// The options of the verification.
    pub options: Options,
    /// The results of all checks.
    pub report: Report,
    /// Quick bounds of the tasks.
    pub bounds: Arc<Vec<TaskBound>>,
    /// By check: the cause of its failure, and later the remedy.
    pub(crate) why: Vec<Option<FailureCause>>,
    /// The repairs of all missed deadlines and limits, found after the remedies.
    pub repairs: Repairs,
    /// The minimum number of cores, found last, if at all.
    pub cores: Option<MinimumCores>,
}

impl Answer {
    /// The results in the common form of all front ends.
    pub fn view(&self) -> View<'_> {
        View::new(&self.problem, &self.options, &self.report, &self.why)
    }

    pub fn unit(&self) -> TimeUnit {
        TimeUnit::of(&settings(&self.problem.scenario, &self.options))
    }

    /// The status of the results.
    pub fn status(&self) -> Status {
        let mut checks = self.report.checks.iter();
        if self.report.has_errors() {
            Status::Blocked
        } else if self.report.refuted() {
            Status::Refuted
        } else if self.report.unknown() {
            Status::GaveUp
        } else if self.report.nothing() {
            Status::Nothing
        } else if self.report.conditional() {
            Status::Conditional
        } else if checks.clone().any(|check| check.verdict == Verdict::Proved)
            && checks.all(|check| matches!(check.verdict, Verdict::Proved | Verdict::Vacuous))
        {
            Status::Proved
        } else {
            Status::Answered
        }
    }
}
