//! The lanes of a trace while a run is read: their open spans, and the row of each.

use std::collections::BTreeMap;

use dotgen_timing::system::{CodelName, ThreadName};

use super::{Lane, LaneKind, Span, SpanKind};

/// A lane, in the order in which lanes are shown.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Key {
    Core(usize),
    Client(String),
    Of(String, Part),
}

/// A lane of a component.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Part {
    Control,
    Task(String),
    Locks,
}

impl Key {
    /// Its name and its kind.
    fn described(&self) -> (String, LaneKind) {
        match self {
            Key::Core(core) => (format!("core {}", core + 1), LaneKind::Core),
            Key::Client(name) => (format!("client {name}"), LaneKind::Client),
            Key::Of(component, Part::Control) => {
                (format!("{component} control task"), LaneKind::Control)
            }
            Key::Of(component, Part::Task(task)) => (format!("{component}.{task}"), LaneKind::Task),
            Key::Of(component, Part::Locks) => (format!("{component} locks"), LaneKind::Locks),
        }
    }
}

/// The key by which an open span is found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Of {
    /// A codel that executes, waits or holds locks.
    Codel(CodelName),
    /// A job that waits for a core, or has one.
    Core(ThreadName),
}

/// The beginning of a span, without lane and row.
#[derive(Debug, Clone)]
pub(super) struct SpanStart {
    pub(super) of: Of,
    pub(super) kind: SpanKind,
    pub(super) label: String,
    pub(super) step: usize,
    pub(super) ahead: Vec<CodelName>,
}

#[derive(Debug, Default)]
struct LaneBuilder {
    /// The open spans, by row.
    open: Vec<Option<(f64, SpanStart)>>,
    ended: Vec<(Span, Vec<CodelName>)>,
}

#[derive(Debug, Default)]
pub(super) struct Lanes {
    all: BTreeMap<Key, LaneBuilder>,
}

impl Lanes {
    /// Adds the lane if it does not exist.
    pub(super) fn touch(&mut self, key: &Key) {
        if !self.all.contains_key(key) {
            self.all.insert(key.clone(), LaneBuilder::default());
        }
    }

    /// True if the lane exists.
    pub(super) fn has(&self, key: &Key) -> bool {
        self.all.contains_key(key)
    }

    /// Begins a span, in the first free row.
    pub(super) fn begin(&mut self, key: &Key, now: f64, begun: SpanStart) {
        self.touch(key);
        let Some(lane) = self.all.get_mut(key) else {
            return;
        };
        match lane.open.iter_mut().find(|span| span.is_none()) {
            Some(row) => *row = Some((now, begun)),
            None => lane.open.push(Some((now, begun))),
        }
    }

    pub(super) fn open(&mut self, key: &Key, of: &Of, kind: SpanKind) -> Option<&mut SpanStart> {
        let rows = self.all.get_mut(key)?.open.iter_mut();
        let mut found = rows.filter_map(|row| row.as_mut().map(|row| &mut row.1));
        found.find(|row| row.of == *of && row.kind == kind)
    }

    /// Ends a span, if it is open.
    pub(super) fn end(&mut self, key: &Key, now: f64, of: &Of, kind: SpanKind) {
        let Some(lane) = self.all.get_mut(key) else {
            return;
        };
        for (row, open) in lane.open.iter_mut().enumerate() {
            if open.as_ref().is_some_and(|(_, row)| row.of == *of && row.kind == kind)
                && let Some(begun) = open.take()
            {
                lane.ended.extend(span(begun, row, now));
                return;
            }
        }
    }

    /// The first free core. The choice of a core does not affect the system.
    pub(super) fn free_core(&self) -> usize {
        let busy = |core: usize| {
            let lane = self.all.get(&Key::Core(core));
            lane.is_some_and(|lane| lane.open.iter().any(Option::is_some))
        };
        (0..).find(|&executor| !busy(executor)).unwrap_or(0)
    }

    /// The core on which a job runs.
    pub(super) fn core_of(&self, thread: &ThreadName) -> Option<Key> {
        let has = |(key, lane): &(&Key, &LaneBuilder)| {
            let mut rows = lane.open.iter().flatten();
            matches!(key, Key::Core(_)) && rows.any(|row| row.1.of == Of::Core(thread.clone()))
        };
        self.all.iter().find(has).map(|(key, _)| (*key).clone())
    }

    /// Ends all spans. Returns all lanes, their spans with the codels ahead of them, and the index of each
    /// lane.
    pub(super) fn finish(mut self, now: f64) -> BuiltLanes {
        let mut out = BuiltLanes::default();
        for (at, (key, lane)) in std::mem::take(&mut self.all).into_iter().enumerate() {
            let (name, kind) = key.described();
            let rows = lane.open.len().max(1);
            out.lanes.push(Lane { name, kind, rows });
            let mut ended = lane.ended;
            for (row, begun) in lane.open.into_iter().enumerate() {
                ended.extend(begun.and_then(|begun| span(begun, row, now)));
            }
            ended.sort_by(|a, b| a.0.from.total_cmp(&b.0.from));
            for (mut span, ahead) in ended {
                span.lane = at;
                out.spans.push(span);
                out.ahead.push(ahead);
            }
            out.at.insert(key, at);
        }
        out
    }
}

/// See [`Lanes::finish`].
#[derive(Debug, Default)]
pub(super) struct BuiltLanes {
    pub(super) lanes: Vec<Lane>,
    pub(super) spans: Vec<Span>,
    /// The codels ahead in the queue, by span.
    pub(super) ahead: Vec<Vec<CodelName>>,
    pub(super) at: BTreeMap<Key, usize>,
}

/// A span, or `None` for waiting without duration. Execution without duration is a span.
fn span((from, start): (f64, SpanStart), row: usize, to: f64) -> Option<(Span, Vec<CodelName>)> {
    let waits = matches!(start.kind, SpanKind::WaitLock | SpanKind::WaitCore);
    (to > from || !waits).then_some((
        Span {
            lane: 0,
            row,
            from,
            to,
            kind: start.kind,
            label: start.label,
            codel: match start.of {
                Of::Codel(codel) => Some(codel.to_string()),
                Of::Core(_) => None,
            },
            by: Vec::new(),
            step: start.step,
        },
        start.ahead,
    ))
}
