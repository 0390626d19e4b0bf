//! A run as data for whoever draws it: lanes, what goes on in them, who waits for whom, and the steps. A
//! counterexample and a recorded run have this one form. `docs/trace.md` describes it,
//! `docs/trace.schema.json` is its schema.

mod lanes;
mod make;
mod rules;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub(crate) use make::{Told, of_run};

/// Version of the form: raised when a field changes its meaning or goes.
pub(crate) const FORMAT: u32 = 1;

/// A run. `P` is a place in a text. Times are in `unit`; lanes, steps and places are named by their index.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Trace<P> {
    /// [`FORMAT`].
    pub(crate) format: u32,
    /// What is shown.
    pub(crate) title: String,
    /// Of all times: `us` or `ms`.
    pub(crate) unit: String,
    /// When it begins.
    pub(crate) start: f64,
    /// When it ends.
    pub(crate) end: f64,
    /// What to look at first.
    pub(crate) focus: Focus,
    /// From here to the end it goes on for ever.
    pub(crate) repeats: Option<f64>,
    /// In the order in which they are shown.
    pub(crate) lanes: Vec<Lane>,
    /// What lasts, by lane and then in order of time.
    pub(crate) spans: Vec<Span>,
    /// What happens at a moment.
    pub(crate) marks: Vec<Mark>,
    /// Who asks whom.
    pub(crate) arrows: Vec<Arrow>,
    /// What happened, in order.
    pub(crate) steps: Vec<Step>,
    /// What the rules that acted do, a sentence for each.
    pub(crate) rules: BTreeMap<String, String>,
    /// Where codels and tasks are written.
    pub(crate) places: Vec<P>,
    /// What should be known about it.
    pub(crate) notes: Vec<String>,
}

/// Where something is, in time and among the lanes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Focus {
    /// When.
    pub(crate) at: f64,
    /// The lane, if it is about one.
    pub(crate) lane: Option<usize>,
    /// The step that is shown first.
    pub(crate) step: Option<usize>,
}

/// What a lane is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum LaneKind {
    /// A core: who has it.
    Core,
    /// A client: its requests.
    Client,
    /// The control task of a component.
    Control,
    /// A task.
    Task,
    /// The locks of a component: who has some, and below it who waits for some.
    Locks,
}

/// One line of the picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Lane {
    /// Its name.
    pub(crate) name: String,
    /// What it is of.
    pub(crate) kind: LaneKind,
    /// How many spans lie above each other in it, at least 1.
    pub(crate) rows: usize,
}

/// What a span says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum SpanKind {
    /// A codel executes; in a lane of cores, a job has the core.
    Run,
    /// A codel waits for what others use.
    WaitLock,
    /// A job waits for a core.
    WaitCore,
    /// A codel has its locks.
    Hold,
}

/// Something that lasts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Span {
    /// In which lane.
    pub(crate) lane: usize,
    /// In which row of the lane, from 0.
    pub(crate) row: usize,
    /// Since when.
    pub(crate) from: f64,
    /// Until when.
    pub(crate) to: f64,
    /// What it is.
    pub(crate) kind: SpanKind,
    /// A short name.
    pub(crate) label: String,
    /// The codel it is about: `component.owner.state`.
    pub(crate) codel: Option<String>,
    /// Whom it waits for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) by: Vec<Holder>,
    /// The step with which it begins.
    pub(crate) step: usize,
}

/// Who keeps somebody waiting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Holder {
    /// A codel, or who has the core.
    pub(crate) name: String,
    /// The lane in which it executes.
    pub(crate) lane: Option<usize>,
    /// Since when it has what is waited for.
    pub(crate) from: f64,
    /// Until when.
    pub(crate) to: f64,
    /// What both use, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) through: Vec<String>,
    /// It waited as well, ahead in the queue.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(crate) ahead: bool,
}

/// Something that happens at a moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum MarkKind {
    /// A period begins.
    Tick,
    /// A job has ended.
    Complete,
    /// A request or a report.
    Request,
    /// Something is too late.
    Miss,
}

/// See [`MarkKind`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Mark {
    /// In which lane.
    pub(crate) lane: usize,
    /// When.
    pub(crate) at: f64,
    /// What.
    pub(crate) kind: MarkKind,
    /// The step that says it; none for the end of a run.
    pub(crate) step: Option<usize>,
}

/// Somebody asks somebody else for something.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Arrow {
    /// Lane of who asks.
    pub(crate) from: usize,
    /// Lane of who is asked.
    pub(crate) to: usize,
    /// When it was taken.
    pub(crate) at: f64,
    /// The step that says it.
    pub(crate) step: usize,
}

/// One thing that happened.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Step {
    /// When.
    pub(crate) at: f64,
    /// To whom.
    pub(crate) lane: usize,
    /// The rule that acted: a key of [`Trace::rules`].
    pub(crate) rule: String,
    /// What happened, in words.
    pub(crate) what: String,
    /// The codel it is about: `component.owner.state`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) codel: Option<String>,
    /// What the codel shares with others, in words; of a wait, with those it waits for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) locks: Vec<String>,
    /// Index among [`Trace::places`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) place: Option<usize>,
}

impl<P> Trace<P> {
    /// The same with other places, made of each.
    ///
    /// # Errors
    ///
    /// Those of `place`.
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
