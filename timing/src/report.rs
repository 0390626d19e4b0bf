//! Results, as data and as text. The JSON form is part of the interface of `dotgen verify`.

use dotgen_analysis::model::Src;
use serde::Serialize;
use serde::ser::Serializer;

use crate::diagnostic::{Diagnostic, Severity};
use crate::explained::Explained;
use crate::explore::Findings;
use crate::explore::Stop;
use crate::explore::{Action, MomentKind};
use crate::property::PropertyKind;

/// Version of the JSON form: raised when a field changes its meaning or goes. `docs/verify.schema.json` is
/// its schema.
pub const FORMAT: u32 = 1;

/// What a verification found.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// Name of the scenario.
    pub scenario: String,
    /// What the model follows: `servers` or `published`, with single points that differ.
    pub semantics: String,
    /// Unit of all times: `ms`, `10 us`, …
    pub unit: String,
    /// One per check, in order of the scenario; `*` gives one per task.
    pub checks: Vec<CheckReport>,
    /// States kept.
    pub states: usize,
    /// Actions followed.
    pub steps: u64,
    /// Bytes used for the states.
    pub memory: usize,
    /// Time it took.
    pub seconds: f64,
    /// Which reductions the explorations used.
    #[serde(skip)]
    pub reductions: Explained,
    /// What the results depend on.
    pub assumptions: Vec<String>,
    /// Things seen on the way that the user should know.
    pub notes: Vec<String>,
    /// Problems of the scenario or the model. With an error there are no checks.
    #[serde(skip)]
    pub diagnostics: Vec<Diagnostic>,
}

/// Whether a property holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// It does.
    Proved,
    /// It does not.
    Refuted,
    /// Given up.
    Unknown,
    /// There is nothing that could hold or fail: execution times are missing.
    Nothing,
    /// Not answered yet. Only in what is told before the end.
    Open,
}

/// What a verdict is worth (section 11 of the timed semantics).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Soundness {
    /// Neither false alarms nor misses.
    Exact,
    /// May be a false alarm, never misses.
    Safe,
    /// A failure is real; for worst-case durations only.
    Under,
    /// Neither of both.
    Neither,
    /// The verdict is exact, the value an upper bound of the exact one.
    UpperBound,
    /// A failure is real. What holds was shown for codels that end at whole units of time, and a value is the
    /// greatest of these: under preemption others may end later.
    WholeUnits,
}

/// What proves an answer without an exploration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layer {
    /// Response-time analysis.
    ResponseTimeAnalysis,
    /// Abstract states of the schedule.
    ScheduleAbstraction,
}

impl std::fmt::Display for Layer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Layer::ResponseTimeAnalysis => "response-time analysis",
            Layer::ScheduleAbstraction => "schedule abstraction",
        })
    }
}

/// A task: number of its component, as in [`crate::scn::names::Names::components`], and its index there.
pub type TaskId = (usize, u32);

/// Which check an answer is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CheckId {
    /// Its number among the checks of the scenario, or among those that replace them.
    pub written: usize,
    /// The task, if it is about one; a check of all tasks has an answer for each.
    pub task: Option<TaskId>,
}

/// What a value must not exceed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// The check states it.
    Stated(f64),
    /// The period of the task, where the check states nothing.
    Period(f64),
}

impl Limit {
    /// In the unit of the report.
    pub fn time(self) -> f64 {
        match self {
            Limit::Stated(it) | Limit::Period(it) => it,
        }
    }

    /// Returns `true` if a time, in the unit of the report, is beyond the limit.
    pub fn is_exceeded_by(self, time: Value) -> bool {
        match time {
            Value::Unbounded => true,
            Value::Time(time) => time > self.time(),
        }
    }
}

/// The answer to one check.
#[derive(Debug, Clone, Serialize)]
pub struct CheckReport {
    /// Which check it is.
    #[serde(skip)]
    pub id: CheckId,
    /// Its name, if the scenario gives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What kind of property it asks for.
    #[serde(rename = "check")]
    pub kind: PropertyKind,
    /// The task, or the predicates, in words.
    pub of: String,
    /// What its value must not exceed.
    #[serde(skip)]
    pub limit: Option<Limit>,
    /// The bound that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<Value>,
    /// The answer.
    pub verdict: Verdict,
    /// What the answer is worth.
    pub soundness: Soundness,
    /// What proves it, or its bound, where no exploration does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by: Option<Layer>,
    /// The least bound, for `response` and `within`. When the verdict is unknown, a lower bound of it; with
    /// [`Soundness::UpperBound`] an upper one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<Value>,
    /// It holds because what it is about never happens: `note` says what.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub vacuous: bool,
    /// Why, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// Why it was not answered by exploring, or not completely.
    #[serde(skip_serializing_if = "Option::is_none", rename = "gave-up")]
    pub gave_up: Option<GaveUp>,
    /// A run that ends in the violation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub counterexample: Vec<Event>,
    /// Instead, where durations were rounded: such a run with the rounded ones, which need not exist.
    #[serde(skip_serializing_if = "Vec::is_empty", rename = "possible-run")]
    pub possible_run: Vec<Event>,
    /// Why the job at the end of such a run is late: what it waited for, in order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reason: Vec<Delay>,
    /// A run that reaches the value, or the predicate.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub witness: Vec<Event>,
    /// Event of the run from which on it repeats for ever.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cycle: Option<usize>,
    /// There is a run, but there was no time to find its steps.
    #[serde(skip)]
    pub left_out: bool,
    /// Durations of what it is about were rounded: its value is an upper bound, and a failure may be a false
    /// alarm.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub rounded: bool,
}

/// What a job waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Awaited {
    /// A core.
    Core,
    /// Data or ports that other codels use.
    Lock,
}

/// A part of a run in which a job waited.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Delay {
    /// What for.
    #[serde(rename = "for")]
    pub awaited: Awaited,
    /// The codel that waited for its locks: `component.owner.state`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub codel: Option<String>,
    /// Since when, in the unit of the report.
    #[serde(serialize_with = "serialize_time")]
    pub from: f64,
    /// Until when; the end of the run if it still waits there.
    #[serde(serialize_with = "serialize_time")]
    pub until: f64,
    /// Who had it meanwhile, one after the other. Between them it was free, and the next one took it.
    pub held: Vec<Holder>,
}

/// Who kept somebody waiting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Holder {
    /// The codel, where it is about locks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub codel: Option<String>,
    /// The task, `component.task`; the component for its control task.
    pub by: String,
    /// Since when it had it, in the unit of the report.
    #[serde(serialize_with = "serialize_time")]
    pub from: f64,
    /// Until when, or the end of the run.
    #[serde(serialize_with = "serialize_time")]
    pub until: f64,
}

/// Said of such a check.
const LEFT_OUT: &str = "the run that shows it is left out: there was no time to find its steps";

/// Where an exploration was given up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GaveUp {
    /// What there was too much of, or too little.
    pub reason: Stop,
    /// States until then.
    pub states: usize,
    /// Bytes that they took.
    pub memory: usize,
    /// The time there was, in seconds, if it was limited.
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

/// A time in the unit of the report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// So many.
    Time(f64),
    /// No bound.
    Unbounded,
}

/// A time without the noise of binary fractions: at most nine digits after the point.
fn clean(time: f64) -> f64 {
    let clean = (time * 1e9).round() / 1e9;
    if clean.is_finite() { clean } else { time }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match *self {
            Value::Time(it) => serialize_time(&it, to),
            Value::Unbounded => to.serialize_str("unbounded"),
        }
    }
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Value::Time(it) => write!(f, "{}", clean(*it)),
            Value::Unbounded => f.write_str("unbounded"),
        }
    }
}

/// Whole numbers are written as such.
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
    /// In the unit of the report.
    #[serde(serialize_with = "serialize_time")]
    pub time: f64,
    /// The component.
    pub component: String,
    /// The task, without its component; none for the control task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub task: Option<String>,
    /// Words.
    pub what: String,
    /// Kind of event: the rule that acted.
    pub kind: MomentKind,
    /// Whether the task waits for a core from here on.
    #[serde(skip)]
    pub for_core: bool,
    /// The codel it is about: `component.owner.state`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub codel: Option<String>,
    /// Who keeps that codel waiting from here on: those that execute, then those ahead in the queue.
    #[serde(rename = "waits-for", skip_serializing_if = "Vec::is_empty")]
    pub waits_for: Vec<Blocking>,
    /// The client whose request is taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub client: Option<String>,
    /// Whose activity a control task lets go on: `component.task`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub releases: Option<String>,
    /// Who loses the core: `component.task`, or the component for its control task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preempts: Option<String>,
    /// The step that it tells of.
    #[serde(skip)]
    pub action: Option<Action>,
    /// Where that codel (or the task) is declared: number of the specification, and place.
    #[serde(skip)]
    pub src: Option<(usize, Src)>,
}

/// What keeps a codel waiting.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Blocking {
    /// A codel: `component.owner.state`.
    pub codel: String,
    /// Who executes it: `component.task`, or the component for its control task.
    pub by: String,
    /// It waits as well, ahead in the queue of the component.
    pub ahead: bool,
}

impl Event {
    /// A line about a component or a client alone, at a time in the unit of the report.
    pub fn of_component(time: f64, component: String, kind: MomentKind, what: String) -> Event {
        Event {
            time,
            component,
            task: None,
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
    /// Adds a note, once.
    pub(crate) fn note(&mut self, note: String) {
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    /// Whether a check has no answer yet.
    pub(crate) fn is_open(&self, check: usize) -> bool {
        self.checks[check].verdict == Verdict::Open
    }

    /// Answers a check, once and for all.
    pub(crate) fn answer(&mut self, check: usize, mut answer: CheckReport) {
        assert!(self.is_open(check), "an answer is final");
        if answer.left_out {
            answer.note = Some(match answer.note {
                Some(note) => format!("{note}; {LEFT_OUT}"),
                None => LEFT_OUT.to_owned(),
            });
        }
        self.checks[check] = answer;
    }

    /// How many checks have an answer.
    pub fn answered(&self) -> usize {
        let open = |it: &&CheckReport| it.verdict == Verdict::Open;
        self.checks.len() - self.checks.iter().filter(open).count()
    }

    /// `5 of 7 checks answered`
    pub fn how_far(&self) -> String {
        let of = self.checks.len();
        let checks = if of == 1 { "check" } else { "checks" };
        format!("{} of {of} {checks} answered", self.answered())
    }

    /// Adds what an exploration took.
    pub(crate) fn effort(&mut self, found: &Findings) {
        self.states += found.states;
        self.steps += found.steps;
        found
            .reductions
            .iter()
            .for_each(|it| self.reductions.add(it));
        self.memory = self.memory.max(found.bytes);
    }

    /// Whether some check failed.
    pub fn refuted(&self) -> bool {
        self.checks.iter().any(|it| it.verdict == Verdict::Refuted)
    }

    /// Whether some check was given up.
    pub fn unknown(&self) -> bool {
        self.checks.iter().any(|it| it.verdict == Verdict::Unknown)
    }

    /// Whether there was nothing to verify for some check.
    pub fn nothing(&self) -> bool {
        self.checks.iter().any(|it| it.verdict == Verdict::Nothing)
    }

    /// Whether the scenario or model has errors.
    pub fn has_errors(&self) -> bool {
        self.diagnostics
            .iter()
            .any(|it| it.severity == Severity::Error)
    }
}

impl CheckReport {
    /// The run that shows most: one that refutes it, that may do so, or that reaches the value.
    pub fn run(&self) -> &[Event] {
        let runs = [&self.counterexample, &self.possible_run, &self.witness];
        runs.into_iter()
            .find(|it| !it.is_empty())
            .map_or(&[], |it| it)
    }

    /// How much of its limit is left, in percent of it; below 0 if it is exceeded. Only of a value that is
    /// known, or bounded.
    pub fn slack(&self) -> Option<f64> {
        let known = matches!(self.verdict, Verdict::Proved | Verdict::Refuted);
        match (self.value, self.limit) {
            (Some(Value::Time(value)), Some(limit)) if known => {
                Some((limit.time() - value) / limit.time() * 100.0)
            }
            _ => None,
        }
    }

    /// Whether its value exceeds its limit for certain, stated or not.
    pub fn exceeds(&self) -> bool {
        let limit = self.limit.zip(self.value);
        let beyond = limit.is_some_and(|(limit, value)| limit.is_exceeded_by(value));
        beyond && self.soundness != Soundness::UpperBound && !self.rounded
    }
}
