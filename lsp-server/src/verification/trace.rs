//! A run as data for viewers: lanes, the bars in them, the waits with their causes, and the steps. A
//! counterexample and a recorded run have the same form. `docs/trace.md` describes it, and
//! `docs/trace.schema.json` is its schema.

mod lanes;
mod make;
mod rules;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub(crate) use make::{Told, of_run};

/// Version of the form. It increases when a field is removed or changes its meaning.
pub(crate) const FORMAT: u32 = 1;

/// A run. `P` is a place in a text. Times are in `unit`. Lanes, steps and places are referred to by index.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Trace<P> {
    /// [`FORMAT`].
    pub(crate) format: u32,
    /// The title.
    pub(crate) title: String,
    /// The unit of all times: `us` or `ms`.
    pub(crate) unit: String,
    /// Time of the beginning.
    pub(crate) start: f64,
    /// Time of the end.
    pub(crate) end: f64,
    /// The moment and lane to show first.
    pub(crate) focus: Focus,
    /// Time from which the rest repeats for ever.
    pub(crate) repeats: Option<f64>,
    /// The lanes, from top to bottom.
    pub(crate) lanes: Vec<Lane>,
    /// The spans, by lane and then by time.
    pub(crate) spans: Vec<Span>,
    /// The events at a moment.
    pub(crate) marks: Vec<Mark>,
    /// Requests from one lane to another.
    pub(crate) arrows: Vec<Arrow>,
    /// The steps, in order.
    pub(crate) steps: Vec<Step>,
    /// The rules in the steps, each with a sentence that describes it.
    pub(crate) rules: BTreeMap<String, String>,
    /// The places of codels and tasks.
    pub(crate) places: Vec<P>,
    /// Notes for the reader.
    pub(crate) notes: Vec<String>,
}

/// A moment and a lane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Focus {
    /// The time.
    pub(crate) at: f64,
    /// The lane, if there is one.
    pub(crate) lane: Option<usize>,
    /// The step that is shown first.
    pub(crate) step: Option<usize>,
}

/// The subject of a lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum LaneKind {
    /// A core: the jobs on it.
    Core,
    /// A client: its requests.
    Client,
    /// The control task of a component.
    Control,
    /// A task.
    Task,
    /// The locks of a component: the codels that hold locks, and in the rows below the codels that wait.
    Locks,
}

/// A line of the picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Lane {
    /// Its name.
    pub(crate) name: String,
    /// Its subject.
    pub(crate) kind: LaneKind,
    /// Number of rows for spans at the same time, at least 1.
    pub(crate) rows: usize,
}

/// The kind of a span.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum SpanKind {
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
pub(crate) struct Span {
    /// Index of the lane.
    pub(crate) lane: usize,
    /// The row in the lane, from 0.
    pub(crate) row: usize,
    /// Time of the beginning.
    pub(crate) from: f64,
    /// Time of the end.
    pub(crate) to: f64,
    /// Its kind.
    pub(crate) kind: SpanKind,
    /// A short name.
    pub(crate) label: String,
    /// Its codel: `component.owner.state`.
    pub(crate) codel: Option<String>,
    /// The codels or jobs that it waits for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) by: Vec<Holder>,
    /// The step with which it begins.
    pub(crate) step: usize,
}

/// A cause of a wait.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Holder {
    /// A codel, or the task on the core.
    pub(crate) name: String,
    /// The lane in which it executes.
    pub(crate) lane: Option<usize>,
    /// Time from which it holds the awaited lock or core.
    pub(crate) from: f64,
    /// Time at which it releases the lock or core.
    pub(crate) to: f64,
    /// The shared data, as text.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) through: Vec<String>,
    /// True if it waited as well, ahead in the queue.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(crate) ahead: bool,
}

/// The kind of a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum MarkKind {
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
pub(crate) struct Mark {
    /// Index of the lane.
    pub(crate) lane: usize,
    /// The time.
    pub(crate) at: f64,
    /// Its kind.
    pub(crate) kind: MarkKind,
    /// Its step; none for the end of a run.
    pub(crate) step: Option<usize>,
}

/// A request from one lane to another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Arrow {
    /// Lane of the sender.
    pub(crate) from: usize,
    /// Lane of the receiver.
    pub(crate) to: usize,
    /// Time at which the request was accepted.
    pub(crate) at: f64,
    /// Its step.
    pub(crate) step: usize,
}

/// A step of the run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Step {
    /// The time.
    pub(crate) at: f64,
    /// Its lane.
    pub(crate) lane: usize,
    /// Its rule: a key of [`Trace::rules`].
    pub(crate) rule: String,
    /// A description.
    pub(crate) what: String,
    /// Its codel: `component.owner.state`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) codel: Option<String>,
    /// The data that the codel shares with other codels, as text; for a wait, with the awaited codels.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) locks: Vec<String>,
    /// Index in [`Trace::places`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) place: Option<usize>,
}

impl<P> Trace<P> {
    /// The trace with its places converted.
    ///
    /// # Errors
    ///
    /// The errors of `place`.
    pub(crate) fn placed<Q, E>(self, place: impl FnMut(P) -> Result<Q, E>) -> Result<Trace<Q>, E> {
        Ok(Trace {
            places: self
                .places
                .into_iter()
                .map(place)
                .collect::<Result<_, E>>()?,
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
