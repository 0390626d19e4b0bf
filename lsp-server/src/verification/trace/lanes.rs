//! The lanes of a trace while a run is read: what is open in them, and in which row.

use std::collections::BTreeMap;

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
    /// Its name, and what it is of.
    fn described(&self) -> (String, LaneKind) {
        match self {
            Key::Core(it) => (format!("core {}", it + 1), LaneKind::Core),
            Key::Client(name) => (format!("client {name}"), LaneKind::Client),
            Key::Of(component, Part::Control) => {
                (format!("{component} control task"), LaneKind::Control)
            }
            Key::Of(component, Part::Task(task)) => (format!("{component}.{task}"), LaneKind::Task),
            Key::Of(component, Part::Locks) => (format!("{component} locks"), LaneKind::Locks),
        }
    }
}

/// By what something that is open is found again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Of {
    /// A codel that executes, waits or has locks.
    Codel(String),
    /// Who waits for a core, or has one.
    Core(String),
}

/// What lasts; lane and row are filled in.
#[derive(Debug, Clone)]
pub(super) struct Begun {
    pub(super) of: Of,
    pub(super) kind: SpanKind,
    pub(super) label: String,
    pub(super) step: usize,
    pub(super) ahead: Vec<String>,
}

#[derive(Debug, Default)]
struct Building {
    /// By row.
    open: Vec<Option<(f64, Begun)>>,
    ended: Vec<(Span, Vec<String>)>,
}

/// All lanes.
#[derive(Debug, Default)]
pub(super) struct Lanes {
    all: BTreeMap<Key, Building>,
}

impl Lanes {
    /// There is such a lane.
    pub(super) fn touch(&mut self, key: &Key) {
        if !self.all.contains_key(key) {
            self.all.insert(key.clone(), Building::default());
        }
    }

    /// Whether there is such a lane.
    pub(super) fn has(&self, key: &Key) -> bool {
        self.all.contains_key(key)
    }

    /// Something begins, in the first row that is free.
    pub(super) fn begin(&mut self, key: &Key, now: f64, begun: Begun) {
        self.touch(key);
        let Some(lane) = self.all.get_mut(key) else {
            return;
        };
        match lane.open.iter_mut().find(|it| it.is_none()) {
            Some(row) => *row = Some((now, begun)),
            None => lane.open.push(Some((now, begun))),
        }
    }

    /// Whether something of this kind goes on there.
    pub(super) fn open(&mut self, key: &Key, of: &Of, kind: SpanKind) -> Option<&mut Begun> {
        let rows = self.all.get_mut(key)?.open.iter_mut();
        let mut found = rows.filter_map(|it| it.as_mut().map(|it| &mut it.1));
        found.find(|it| it.of == *of && it.kind == kind)
    }

    /// Something ends, if it goes on.
    pub(super) fn end(&mut self, key: &Key, now: f64, of: &Of, kind: SpanKind) {
        let Some(lane) = self.all.get_mut(key) else {
            return;
        };
        for (row, it) in lane.open.iter_mut().enumerate() {
            if it
                .as_ref()
                .is_some_and(|it| it.1.of == *of && it.1.kind == kind)
                && let Some(begun) = it.take()
            {
                lane.ended.extend(span(begun, row, now));
                return;
            }
        }
    }

    /// The first core that nobody has. Which one it is makes no difference to the system.
    pub(super) fn free_core(&self) -> usize {
        let busy = |core: usize| {
            let lane = self.all.get(&Key::Core(core));
            lane.is_some_and(|it| it.open.iter().any(Option::is_some))
        };
        (0..).find(|&it| !busy(it)).unwrap_or(0)
    }

    /// The core that somebody has.
    pub(super) fn core_of(&self, who: &str) -> Option<Key> {
        let has = |it: &(&Key, &Building)| {
            let mut rows = it.1.open.iter().flatten();
            matches!(it.0, Key::Core(_)) && rows.any(|it| it.1.of == Of::Core(who.to_owned()))
        };
        self.all.iter().find(has).map(|it| it.0.clone())
    }

    /// Everything ends. All lanes, their spans with those ahead of them, and where each lane is.
    pub(super) fn finish(mut self, now: f64) -> Finished {
        let mut out = Finished::default();
        for (at, (key, lane)) in std::mem::take(&mut self.all).into_iter().enumerate() {
            let (name, kind) = key.described();
            let rows = lane.open.len().max(1);
            out.lanes.push(Lane { name, kind, rows });
            let mut ended = lane.ended;
            for (row, begun) in lane.open.into_iter().enumerate() {
                ended.extend(begun.and_then(|it| span(it, row, now)));
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
pub(super) struct Finished {
    pub(super) lanes: Vec<Lane>,
    pub(super) spans: Vec<Span>,
    /// By span.
    pub(super) ahead: Vec<Vec<String>>,
    pub(super) at: BTreeMap<Key, usize>,
}

/// What executes without taking time is shown; waiting without time is not worth it.
fn span((from, it): (f64, Begun), row: usize, to: f64) -> Option<(Span, Vec<String>)> {
    let waits = matches!(it.kind, SpanKind::WaitLock | SpanKind::WaitCore);
    (to > from || !waits).then_some((
        Span {
            lane: 0,
            row,
            from,
            to,
            kind: it.kind,
            label: it.label,
            codel: match it.of {
                Of::Codel(codel) => Some(codel),
                Of::Core(_) => None,
            },
            by: Vec::new(),
            step: it.step,
        },
        it.ahead,
    ))
}
