//! Results, as data and as text. The JSON form is part of the interface of `dotgen verify`.

use std::fmt::Write;

use dotgen_analysis::model::Src;
use serde::Serialize;
use serde::ser::Serializer;

use crate::explore::Findings;
use crate::explore::MomentKind;
use crate::explore::Stop;
use crate::scn::{Diagnostic, Severity};

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
}

/// The answer to one check.
#[derive(Debug, Clone, Serialize)]
pub struct CheckReport {
    /// Its name, if the scenario gives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Its kind: `schedulable`, `response`, …
    pub check: &'static str,
    /// The task, or the predicates.
    pub of: String,
    /// The bound that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<Value>,
    /// The answer.
    pub verdict: Verdict,
    /// What the answer is worth.
    pub soundness: Soundness,
    /// The least bound, for `response` and `within`. When the verdict is unknown, a lower bound of it; with
    /// [`Soundness::UpperBound`] an upper one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<Value>,
    /// Why, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// Why it was not answered by exploring, or not completely.
    #[serde(skip_serializing_if = "Option::is_none", rename = "gave-up")]
    pub gave_up: Option<GaveUp>,
    /// A run that ends in the violation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub counterexample: Vec<Event>,
    /// A run that reaches the value, or the predicate.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub witness: Vec<Event>,
    /// Event of the run from which on it repeats for ever.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cycle: Option<usize>,
    /// There is a run, but there was no time to find its steps.
    #[serde(skip)]
    pub left_out: bool,
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
            Value::Time(it) => write!(f, "{it}"),
            Value::Unbounded => f.write_str("unbounded"),
        }
    }
}

/// Whole numbers are written as such.
fn serialize_time<S: Serializer>(time: &f64, to: S) -> Result<S::Ok, S::Error> {
    if time.fract() == 0.0 && time.abs() < 9e15 {
        to.serialize_i64(*time as i64)
    } else {
        to.serialize_f64(*time)
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
    /// Kind of event.
    pub kind: MomentKind,
    /// The codel it is about: `component.owner.state`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub codel: Option<String>,
    /// Where that codel (or the task) is declared: number of the specification, and place.
    #[serde(skip)]
    pub src: Option<(usize, Src)>,
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

    /// Whether the scenario or model has errors.
    pub fn has_errors(&self) -> bool {
        self.diagnostics
            .iter()
            .any(|it| it.severity == Severity::Error)
    }

    /// For people. `runs` shows counterexamples.
    pub fn to_text(&self, runs: bool) -> String {
        let mut out = String::new();
        for it in &self.diagnostics {
            let word = match it.severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
            };
            let _ = writeln!(out, "{word}[{}]: {}", it.code, it.message);
        }
        let width = self
            .checks
            .iter()
            .map(|it| it.check.len() + it.of.len())
            .max()
            .unwrap_or(0);
        for it in &self.checks {
            let verdict = match it.verdict {
                Verdict::Proved => "proved ",
                Verdict::Refuted => "REFUTED",
                Verdict::Unknown => "unknown",
                Verdict::Open => "open   ",
            };
            let title = format!("{} {}", it.check, it.of);
            let _ = write!(out, "{verdict}  {title:<0$}", width + 1);
            if let Some(value) = it.value {
                let at_least = if it.verdict == Verdict::Unknown {
                    "at least "
                } else {
                    ""
                };
                let _ = match value {
                    Value::Time(_) => write!(out, "  {at_least}{value} {}", unit_word(&self.unit)),
                    Value::Unbounded => write!(out, "  unbounded"),
                };
            }
            if let Some(bound) = it.bound {
                let _ = write!(out, "  (bound {bound} {})", unit_word(&self.unit));
            }
            match it.soundness {
                Soundness::Exact => {}
                Soundness::Safe => out.push_str("  [safe: may be a false alarm]"),
                Soundness::Under => out.push_str("  [for worst-case durations only]"),
                Soundness::UpperBound => out.push_str("  [an upper bound]"),
                Soundness::Neither => out.push_str("  [for worst-case durations only, indicative]"),
            }
            out.truncate(out.trim_end().len());
            out.push('\n');
            if let Some(note) = &it.note {
                let _ = writeln!(out, "         {note}");
            }
            if runs && !it.counterexample.is_empty() {
                run_text(&it.counterexample, it.cycle, &mut out);
            }
        }
        let _ = writeln!(
            out,
            "{} states, {} steps, {:.3} s, {:.1} MB",
            self.states,
            self.steps,
            self.seconds,
            self.memory as f64 / 1e6
        );
        for it in &self.notes {
            let _ = writeln!(out, "note: {it}");
        }
        for it in &self.assumptions {
            let _ = writeln!(out, "assuming {it}");
        }
        out
    }
}

/// `ms` as it is, `10 us` as a factor.
fn unit_word(unit: &str) -> String {
    if unit.contains(' ') {
        format!("x {unit}")
    } else {
        unit.to_owned()
    }
}

fn run_text(run: &[Event], cycle: Option<usize>, out: &mut String) {
    for (i, it) in run.iter().enumerate() {
        if cycle == Some(i) {
            out.push_str("         from here on for ever:\n");
        }
        let task = it.task.as_ref().map_or(it.component.clone(), |task| {
            format!("{}.{task}", it.component)
        });
        let _ = writeln!(out, "         {:>8}  {task:<24}  {}", it.time, it.what);
    }
}
