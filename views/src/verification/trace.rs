//! A run as data for viewers: lanes, the bars in them, the waits with their causes, and the steps. A
//! counterexample and a recorded run have the same form. `docs/trace.md` describes it, and
//! `docs/trace.schema.json` is its schema.

mod lanes;
mod make;
mod rules;

use std::collections::BTreeMap;

use dotgen_timing::scn::ast::Unit;
use serde::{Deserialize, Serialize};

pub use make::{TraceInput, of_run};

/// Version of the form. It increases when a field is removed or changes its meaning.
pub const FORMAT: u32 = 1;

/// A run. `P` is a place in a text. Times are in `unit`. Lanes, steps and places are referred to by index.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Trace<P> {
    /// [`FORMAT`].
    pub format: u32,
    pub title: String,
    /// The unit of all times: `us` or `ms`.
    pub unit: Unit,
    /// Time of the beginning.
    pub start: f64,
    /// Time of the end.
    pub end: f64,
    /// The moment and lane to show first.
    pub focus: Focus,
    /// Time from which the rest repeats for ever.
    pub repeats: Option<f64>,
    /// The lanes, from top to bottom.
    pub lanes: Vec<Lane>,
    /// The spans, by lane and then by time.
    pub spans: Vec<Span>,
    /// The events at a moment.
    pub marks: Vec<Mark>,
    /// Requests from one lane to another.
    pub arrows: Vec<Arrow>,
    /// The steps, in order.
    pub steps: Vec<Step>,
    /// The rules in the steps, each with a sentence that describes it.
    pub rules: BTreeMap<String, String>,
    /// The places of codels and tasks.
    pub places: Vec<P>,
    /// Notes for the reader.
    pub notes: Vec<String>,
}

/// A moment and a lane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Focus {
    /// The time.
    pub at: f64,
    /// The lane, if there is one.
    pub lane: Option<usize>,
    /// The step that is shown first.
    pub step: Option<usize>,
    /// The cause of the failure in words, if it was computed with the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cause: Option<String>,
}

/// The subject of a lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LaneKind {
    /// A core: the jobs on it.
    Core,
    /// A client: its requests.
    Client,
    /// The control task of a component.
    Control,
    Task,
    /// The locks of a component: the codels that hold locks, and in the rows below the codels that wait.
    Locks,
}

/// A line of the picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Lane {
    pub name: String,
    /// Its subject.
    pub kind: LaneKind,
    /// Number of rows for spans at the same time, at least 1.
    pub rows: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SpanKind {
    /// A codel executes; in a lane of cores, a job has the core.
    Run,
    /// A codel waits for a lock.
    WaitLock,
    /// A job waits for a core.
    WaitCore,
    /// A codel holds its locks.
    Hold,
}

/// An interval of time in a lane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Span {
    /// Index of the lane.
    pub lane: usize,
    /// The row in the lane, from 0.
    pub row: usize,
    /// Time of the beginning.
    pub from: f64,
    /// Time of the end.
    pub to: f64,
    pub kind: SpanKind,
    /// A short name.
    pub label: String,
    /// Its codel: `component.owner.state`.
    pub codel: Option<String>,
    /// The codels or jobs that it waits for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by: Vec<Holder>,
    /// The step with which it begins.
    pub step: usize,
}

/// A cause of a wait.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Holder {
    /// A codel, or the task on the core.
    pub name: String,
    /// The lane in which it executes.
    pub lane: Option<usize>,
    /// Time from which it holds the awaited lock or core.
    pub from: f64,
    /// Time at which it releases the lock or core.
    pub to: f64,
    /// The shared data, as text.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub through: Vec<String>,
    /// True if it waited as well, ahead in the queue.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub ahead: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MarkKind {
    /// A period begins.
    Tick,
    /// A job has ended.
    Complete,
    /// A request or a report.
    Request,
    /// A deadline or limit is missed.
    Miss,
}

/// See [`MarkKind`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Mark {
    /// Index of the lane.
    pub lane: usize,
    /// The time.
    pub at: f64,
    pub kind: MarkKind,
    /// Its step; none for the end of a run.
    pub step: Option<usize>,
}

/// A request from one lane to another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Arrow {
    /// Lane of the sender.
    pub from: usize,
    /// Lane of the receiver.
    pub to: usize,
    /// Time at which the request was accepted.
    pub at: f64,
    pub step: usize,
}

/// A step of the run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// The time.
    pub at: f64,
    pub lane: usize,
    /// Its rule: a key of [`Trace::rules`].
    pub rule: String,
    /// A description.
    pub what: String,
    /// Its codel: `component.owner.state`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub codel: Option<String>,
    /// The data that the codel shares with other codels, as text; for a wait, with the awaited codels.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub locks: Vec<String>,
    /// Index in [`Trace::places`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<usize>,
}

impl<P> Trace<P> {
    /// The trace with its places converted.
    ///
    /// # Errors
    ///
    /// The errors of `place`.
    pub fn placed<Q, E>(self, place: impl FnMut(P) -> Result<Q, E>) -> Result<Trace<Q>, E> {
        Ok(Trace {
            places: self.places.into_iter().map(place).collect::<Result<_, E>>()?,
            format: self.format,
            title: self.title,
            unit: self.unit,
            start: self.start,
            end: self.end,
            focus: self.focus,
            repeats: self.repeats,
            lanes: self.lanes,
            spans: self.spans,
            marks: self.marks,
            arrows: self.arrows,
            steps: self.steps,
            rules: self.rules,
            notes: self.notes,
        })
    }
}
