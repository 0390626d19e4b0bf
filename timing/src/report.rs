//! The report of a verification, as data and as text. The JSON form is part of the interface of `dotgen
//! verify`.

mod stretch;
mod time_unit;
mod verdict;

use crate::system::indexed::DeclaredTask;
use std::sync::Arc;

use dotgen_analysis::model::Src;
use serde::de::{Deserializer, Error as _};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use crate::diagnostic::{Diagnostic, Severity};
use crate::explore::Findings;
use crate::explore::{Action, MomentKind};
use crate::explore::{Stop, SystemRun};
use crate::property::PropertyKind;
use crate::reduction_use::ReductionUse;
use crate::system::ground::Condition;
use crate::system::{CodelName, ThreadName};
pub use stretch::{Endless, EndlessKind, LoopExit, Stretch, StretchKind};
pub use time_unit::TimeUnit;
pub(crate) use time_unit::to_f64;
pub use verdict::Verdict;

/// Version of the JSON form: raised when a field changes its meaning or is removed. Its schema is
/// `docs/verify.schema.json`.
pub const FORMAT: u32 = 2;

/// The results of a verification.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// Name of the scenario.
    pub scenario: String,
    /// Semantics of the model: `servers` or `published`, with the single points that differ.
    pub semantics: String,
    pub unit: TimeUnit,
    /// Checks, in order of the scenario; `*` gives one per task.
    pub checks: Vec<CheckReport>,
    /// Number of states kept.
    pub states: usize,
    /// Number of actions followed.
    pub steps: u64,
    /// Bytes used for the states.
    pub memory: usize,
    /// Duration of the verification, in seconds.
    pub seconds: f64,
    /// The reductions that the explorations used.
    #[serde(skip)]
    pub reductions: ReductionUse,
    /// Assumptions on which the results depend.
    pub assumptions: Vec<String>,
    /// Other findings that the user should know.
    pub notes: Vec<String>,
    /// Problems of the scenario or the model. If one of them is an error, there are no checks.
    #[serde(skip)]
    pub diagnostics: Vec<Diagnostic>,
}

/// The strength of a verdict (section 11 of the timed semantics).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Soundness {
    /// Neither false alarms nor missed failures.
    Exact,
    /// Possibly a false alarm, but no missed failures.
    Safe,
    /// A failure is real, but failures may be missed: only worst-case durations were explored.
    Under,
    /// Both false alarms and missed failures are possible.
    Neither,
    /// The verdict is exact; the value is an upper bound of the exact value.
    UpperBound,
    /// No verdict was found. A run reaches the value, and other runs may exceed it.
    LowerBound,
    /// A failure is real. Other verdicts hold for codels that end at whole units of time, and a value is the
    /// greatest one of these runs: under preemption other codels may end later.
    WholeUnits,
}

/// The analysis that gives an answer without an exploration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layer {
    ResponseTimeAnalysis,
    ScheduleAbstraction,
    Invariants,
}

impl std::fmt::Display for Layer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Layer::ResponseTimeAnalysis => "response-time analysis",
            Layer::ScheduleAbstraction => "schedule abstraction",
            Layer::Invariants => "invariants",
        })
    }
}

/// The check to which an answer belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CheckId {
    /// Index among the checks of the scenario, or among the checks that replace them.
    pub written: usize,
    /// Task, if the check is about one. A check of all tasks has an answer for each.
    pub task: Option<DeclaredTask>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// Stated by the check.
    Stated(f64),
    /// The period of the task, if the check states no limit.
    Period(f64),
}

impl Limit {
    /// Returns the limit, in the unit of the report.
    pub fn time(self) -> f64 {
        match self {
            Limit::Stated(number) | Limit::Period(number) => number,
        }
    }

    /// Returns `true` if a time, in the unit of the report, is beyond the limit. A job that takes as long as
    /// its period is late: the tick comes before its end.
    pub fn is_exceeded_by(self, time: Value) -> bool {
        match (time, self) {
            (Value::Unbounded, _) => true,
            (Value::Time(time), Limit::Stated(limit)) => time > limit,
            (Value::Time(time), Limit::Period(limit)) => time >= limit,
        }
    }
}

/// The answer to one check.
#[derive(Debug, Clone, Serialize)]
pub struct CheckReport {
    #[serde(skip)]
    pub id: CheckId,
    /// Name, if the scenario gives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    #[serde(rename = "check")]
    pub kind: PropertyKind,
    /// Task, or predicates, in words.
    pub of: String,
    /// Task, if the check is about one.
    #[serde(skip)]
    pub task: Option<ThreadName>,
    #[serde(skip)]
    pub limit: Option<Limit>,
    /// Bound that the check states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<Value>,
    pub verdict: Verdict,
    /// What the verdict rests on although it is not stated; none unless the property holds.
    #[serde(rename = "conditional", skip_serializing_if = "Vec::is_empty")]
    pub conditions: Vec<Condition>,
    /// Strength of the verdict.
    pub soundness: Soundness,
    /// Analysis that proves the verdict or bounds the value, if no exploration does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by: Option<Layer>,
    /// Least bound, for `response` and `within`, in the unit of the report. If the verdict is unknown, a
    /// lower limit of the least bound. With [`Soundness::UpperBound`], an upper limit of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<Value>,
    /// Reason, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// Reason for an incomplete exploration.
    #[serde(skip_serializing_if = "Option::is_none", rename = "gave-up")]
    pub gave_up: Option<GaveUp>,
    /// A run that ends in the violation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub counterexample: Vec<Event>,
    /// Causes for the lateness of the job at the end of the run: its waits, in order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reason: Vec<Delay>,
    /// The job at the end of the run, if it is late.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub job: Option<LateJob>,
    /// What the time until the awaited event is spent on, if the check is refuted and not about a task.
    #[serde(skip)]
    pub spent: Vec<Stretch>,
    /// What goes on for ever, if the check is refuted because a time has no bound.
    #[serde(skip)]
    pub endless: Option<Endless>,
    /// A run that reaches the value or the predicate.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub witness: Vec<Event>,
    /// Index of the event from which the run repeats for ever.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cycle: Option<usize>,
    /// A run exists, but there was no time to find its steps.
    #[serde(skip)]
    pub left_out: bool,
    /// The run, to be continued with other steps.
    #[serde(skip)]
    pub kept: Option<Arc<SystemRun>>,
    /// A run with rounded durations that would answer the check, if it were one of the system.
    #[serde(skip)]
    pub(crate) candidate: Option<Arc<SystemRun>>,
    /// The check was answered with rounded durations: the verdict holds, and the value is an upper bound.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub rounded: bool,
}

/// A job that is late at the end of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LateJob {
    /// Its tick, in the unit of the report.
    #[serde(serialize_with = "serialize_time")]
    pub from: f64,
    /// Time at which it could begin, in the unit of the report: later than its tick if the job before had
    /// not ended.
    #[serde(serialize_with = "serialize_time")]
    pub begun: f64,
    /// End of the run, in the unit of the report.
    #[serde(serialize_with = "serialize_time")]
    pub until: f64,
    /// The codels that it executed, in order of their first execution.
    pub executed: Vec<JobExecutions>,
}

/// The executions of one codel in a job.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JobExecutions {
    pub codel: CodelName,
    /// Number of executions, the last of which may not have ended.
    pub times: u32,
    /// Time with a core, in the unit of the report.
    #[serde(serialize_with = "serialize_time")]
    pub time: f64,
    /// Time without a core, because other threads had it, in the unit of the report.
    #[serde(serialize_with = "serialize_time", skip_serializing_if = "is_zero")]
    pub preempted: f64,
}

fn is_zero(time: &f64) -> bool {
    *time == 0.0
}

/// A resource for which a job waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Awaited {
    Core,
    /// Data or ports in use by other codels.
    Lock,
}

/// An interval of a run in which a job waits.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Delay {
    /// Resource.
    #[serde(rename = "for")]
    pub awaited: Awaited,
    /// Codel that waits for its locks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub codel: Option<CodelName>,
    /// Start of the wait, in the unit of the report.
    #[serde(serialize_with = "serialize_time")]
    pub from: f64,
    /// End of the wait, in the unit of the report; the end of the run if the job still waits there.
    #[serde(serialize_with = "serialize_time")]
    pub until: f64,
    /// Holders of the resource meanwhile, in order. Between two holders the resource was free, and the next
    /// one took it.
    pub held: Vec<Holder>,
}

/// A holder of a resource for which a job waits.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Holder {
    /// Codel, if the resource is a lock.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub codel: Option<CodelName>,
    pub by: ThreadName,
    /// Start, in the unit of the report.
    #[serde(serialize_with = "serialize_time")]
    pub from: f64,
    /// End, in the unit of the report; at most the end of the run.
    #[serde(serialize_with = "serialize_time")]
    pub until: f64,
}

/// The note of a check whose run is left out.
const LEFT_OUT: &str = "the run that shows it is left out: there was no time to find its steps";

/// The state of an exploration that was given up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GaveUp {
    pub reason: Stop,
    /// Number of states.
    pub states: usize,
    /// Bytes taken by the states.
    pub memory: usize,
    /// Time limit, in seconds, if there was one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
}

impl std::fmt::Display for GaveUp {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let states = self.states;
        match (self.reason, self.seconds) {
            (Stop::Memory, _) => {
                let megabytes = self.memory >> 20;
                write!(f, "gave up at {megabytes} MB of memory and {states} states")
            }
            (Stop::Time, Some(seconds)) => {
                write!(f, "gave up after {seconds} s and {states} states")
            }
            (Stop::Cancelled, _) => f.write_str("cancelled"),
            (Stop::Interrupted, _) => write!(f, "interrupted at {states} states"),
            _ => write!(f, "gave up at {states} states"),
        }
    }
}

/// A time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// Finite time, in the unit of the report.
    Time(f64),
    /// No bound.
    Unbounded,
}

/// Removes the noise of binary fractions from a time: at most nine digits after the point remain.
fn clean(time: f64) -> f64 {
    let clean = (time * 1e9).round() / 1e9;
    if clean.is_finite() { clean } else { time }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match *self {
            Value::Time(time) => serialize_time(&time, to),
            Value::Unbounded => to.serialize_str("unbounded"),
        }
    }
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Value, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Time(f64),
            Word(String),
        }
        match Written::deserialize(from)? {
            Written::Time(time) => Ok(Value::Time(time)),
            Written::Word(word) if word == "unbounded" => Ok(Value::Unbounded),
            Written::Word(word) => Err(D::Error::custom(format!("`{word}` is no time"))),
        }
    }
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Value::Time(time) => write!(f, "{}", clean(*time)),
            Value::Unbounded => f.write_str("unbounded"),
        }
    }
}

/// Writes whole numbers without a fraction.
fn serialize_time<S: Serializer>(time: &f64, to: S) -> Result<S::Ok, S::Error> {
    let time = clean(*time);
    if time.fract() == 0.0 && time.abs() < 9e15 {
        to.serialize_i64(time as i64)
    } else {
        to.serialize_f64(time)
    }
}

/// One line of a run.
#[derive(Debug, Clone, Serialize)]
pub struct Event {
    /// Time, in the unit of the report.
    #[serde(serialize_with = "serialize_time")]
    pub time: f64,
    /// Thread: a task, the control task of a component, or a client.
    #[serde(flatten, serialize_with = "ThreadName::serialize_parts")]
    pub thread: ThreadName,
    /// Description.
    pub what: String,
    /// Kind of event: the rule that acted.
    pub kind: MomentKind,
    /// From this event on, the task waits for a core.
    #[serde(skip)]
    pub for_core: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub codel: Option<CodelName>,
    /// Codels that keep the codel waiting from this event on: first those that execute, then those ahead in
    /// the queue.
    #[serde(rename = "waits-for", skip_serializing_if = "Vec::is_empty")]
    pub waits_for: Vec<Blocking>,
    /// Client whose request the control task takes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub client: Option<String>,
    /// Task whose activity a control task allows to go on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub releases: Option<ThreadName>,
    /// Thread that is preempted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preempts: Option<ThreadName>,
    /// Action of the run.
    #[serde(skip)]
    pub action: Option<Action>,
    /// Declaration of the codel or the task: number of the specification, and place.
    #[serde(skip)]
    pub src: Option<(usize, Src)>,
}

/// A codel that keeps another codel waiting.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Blocking {
    pub codel: CodelName,
    /// Thread that executes it.
    pub by: ThreadName,
    /// The blocking codel waits as well, ahead in the queue of the component.
    pub ahead: bool,
}

impl Event {
    /// Returns an event of a thread, at a time in the unit of the report.
    pub fn of_thread(time: f64, thread: ThreadName, kind: MomentKind, what: String) -> Event {
        Event {
            time,
            thread,
            what,
            kind,
            for_core: false,
            codel: None,
            waits_for: Vec::new(),
            client: None,
            releases: None,
            preempts: None,
            action: None,
            src: None,
        }
    }
}

impl Report {
    /// Adds a note, unless the report already has it.
    pub(crate) fn note(&mut self, note: String) {
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    /// Returns true if a check has no answer yet.
    pub(crate) fn is_open(&self, check: usize) -> bool {
        self.checks[check].verdict == Verdict::Open
    }

    /// Sets the final answer to a check.
    pub(crate) fn answer(&mut self, check: usize, mut answer: CheckReport) {
        assert!(self.is_open(check), "an answer is final");
        // The only place where a proof gets its word, so that no stage can forget its ground.
        if answer.verdict == Verdict::Proved {
            answer.verdict = answer.worth();
        }
        if !answer.verdict.holds() {
            answer.conditions.clear();
        }
        if answer.left_out {
            answer.note = Some(match answer.note {
                Some(note) => format!("{note}; {LEFT_OUT}"),
                None => LEFT_OUT.to_owned(),
            });
        }
        self.checks[check] = answer;
    }

    /// Returns the number of checks with an answer.
    pub fn answered(&self) -> usize {
        let open = |report: &&CheckReport| report.verdict == Verdict::Open;
        self.checks.len() - self.checks.iter().filter(open).count()
    }

    /// Returns the progress: `5 of 7 checks answered`.
    pub fn how_far(&self) -> String {
        let of = self.checks.len();
        let checks = if of == 1 { "check" } else { "checks" };
        format!("{} of {of} {checks} answered", self.answered())
    }

    /// Adds the states, actions, memory and reductions of an exploration.
    pub(crate) fn effort(&mut self, found: &Findings) {
        self.states += found.states;
        self.steps += found.steps;
        found.reductions.iter().for_each(|reduction| self.reductions.add(reduction));
        self.memory = self.memory.max(found.bytes);
    }

    /// Returns true if some check failed.
    pub fn refuted(&self) -> bool {
        self.checks.iter().any(|check| check.verdict == Verdict::Refuted)
    }

    /// Returns true if some check was given up.
    pub fn unknown(&self) -> bool {
        self.checks.iter().any(|check| check.verdict == Verdict::Unknown)
    }

    /// Returns true if some check holds only under conditions.
    pub fn conditional(&self) -> bool {
        self.checks.iter().any(|check| check.verdict == Verdict::Conditional)
    }

    /// Returns true if some check had nothing to verify.
    pub fn nothing(&self) -> bool {
        self.checks.iter().any(|check| check.verdict == Verdict::Nothing)
    }

    /// Returns true if the scenario or the model has errors.
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }
}

impl CheckReport {
    /// Returns the most telling run: one that refutes the check, else one that reaches the value.
    pub fn run(&self) -> &[Event] {
        let runs = [&self.counterexample, &self.witness];
        runs.into_iter().find(|run| !run.is_empty()).map_or(&[], |run| run)
    }

    /// Returns the part of the limit that is left, in percent of the limit; below 0 if the limit is exceeded.
    /// `None` if the value has neither been found nor bounded.
    pub fn slack(&self) -> Option<f64> {
        let known = self.verdict.holds() || self.verdict == Verdict::Refuted;
        match (self.value, self.limit) {
            (Some(Value::Time(value)), Some(limit)) if known => {
                Some((limit.time() - value) / limit.time() * 100.0)
            }
            _ => None,
        }
    }

    /// What a proof says about its subject.
    fn worth(&self) -> Verdict {
        if self.exceeds() {
            Verdict::Exceeds
        } else if self.slack().is_some_and(|slack| slack < 0.0) {
            Verdict::Bounded
        } else if !self.conditions.is_empty() {
            Verdict::Conditional
        } else {
            Verdict::Proved
        }
    }

    /// Returns true if the value certainly exceeds the limit, stated or not.
    pub fn exceeds(&self) -> bool {
        let limit = self.limit.zip(self.value);
        let beyond = limit.is_some_and(|(limit, value)| limit.is_exceeded_by(value));
        beyond && self.soundness != Soundness::UpperBound && !self.rounded
    }
}
