//! Where verifications stand, and what they found.

use std::collections::BTreeMap;
use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_timing::derive::MinimumCores;
use dotgen_timing::report::{Report, Verdict};
use dotgen_timing::verify::{Cancel, Options};
use serde::{Deserialize, Serialize};

use super::changes::Repairs;
use super::view::View;
use super::why::Why;
use super::{Problem, TaskBound};

/// Answers by the document they are about.
pub(crate) type Results = BTreeMap<Utf8PathBuf, Entry>;

/// Where a verification stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// What is shown is of an earlier text; a verification follows.
    Stale,
    /// At work on the present text.
    Running,
    /// Everything holds.
    Proved,
    /// Something does not hold.
    Refuted,
    /// Nothing was refuted, but not everything answered.
    GaveUp,
    /// Nothing was refuted and everything answered, but somewhere execution times are missing.
    Nothing,
    /// There are errors first.
    Blocked,
}

/// One verification.
#[derive(Clone)]
pub(crate) struct Entry {
    pub(crate) status: Status,
    /// Version of the document it holds for, if that is open.
    pub(crate) version: Option<i32>,
    /// What is verified.
    pub(crate) problem: Arc<Problem>,
    /// The last answer.
    pub(crate) answer: Option<Arc<Answer>>,
    /// Whether that is about `problem`; while the status is running, checks are open.
    pub(crate) holds: bool,
    /// Quick bounds of `problem`, once there.
    pub(crate) bounds: Arc<Vec<TaskBound>>,
    /// What the answer is to be found with.
    pub(crate) options: Options,
    pub(crate) job: u64,
    pub(crate) cancel: Arc<Cancel>,
}

impl Entry {
    /// Where the places of the answer are.
    pub(crate) fn places(&self) -> &Arc<Problem> {
        match (self.known(), &self.answer) {
            (None, Some(answer)) => &answer.problem,
            _ => &self.problem,
        }
    }

    /// What is known of the present text: the answer, or what there is of it.
    pub(crate) fn known(&self) -> Option<&Arc<Answer>> {
        self.answer.as_ref().filter(|_| self.holds)
    }

    /// The answer, if it is complete and about the present text.
    pub(crate) fn settled(&self) -> Option<&Arc<Answer>> {
        self.known().filter(|_| self.status != Status::Running)
    }
}

/// A problem and what was found; as long as the work goes on, what has been found so far.
pub(crate) struct Answer {
    pub(crate) problem: Arc<Problem>,
    pub(crate) options: Options,
    pub(crate) report: Report,
    pub(crate) bounds: Arc<Vec<TaskBound>>,
    /// By check: why it fails, and later what helps.
    pub(crate) why: Vec<Option<Why>>,
    /// What repairs all that is missed; found after what helps.
    pub(crate) repairs: Repairs,
    /// Found last, if at all.
    pub(crate) cores: Option<MinimumCores>,
}

impl Answer {
    /// What people look at.
    pub(crate) fn view(&self) -> View<'_> {
        View::new(&self.problem, &self.options, &self.report, &self.why)
    }

    /// What it amounts to.
    pub(crate) fn status(&self) -> Status {
        let mut checks = self.report.checks.iter();
        if self.report.has_errors() {
            Status::Blocked
        } else if self.report.refuted() {
            Status::Refuted
        } else if checks.any(|it| it.verdict == Verdict::Unknown) {
            Status::GaveUp
        } else if self.report.nothing() {
            Status::Nothing
        } else {
            Status::Proved
        }
    }
}
