//! Traces from the events of a run.

use std::collections::{BTreeMap, HashMap};

use dotgen_analysis::model::Src;
use dotgen_analysis::phrase::Phrase;
use dotgen_timing::explore::MomentKind;
use dotgen_timing::report::{Event, TimeUnit};
use dotgen_timing::scn::ast::Unit;
use dotgen_timing::system::{CodelName, ThreadName};

use super::lanes::{BuiltLanes, Key, Lanes, Of, Part, SpanStart};
use super::rules::rule;
use super::{Arrow, FORMAT, Focus, Holder, Mark, MarkKind, Span, SpanKind, Step, Trace};
use crate::verification::blocking::Row;
use crate::verification::runs::Ending;

/// A run, and the data for its trace.
pub struct TraceInput<'e> {
    pub title: String,
    /// The unit of the times of events.
    pub unit: TimeUnit,
    pub events: &'e [Event],
    /// The end of the run.
    pub ending: Ending<'e>,
    /// Time of the end, in the unit of the times of events; by default that of the last event.
    pub end: Option<f64>,
    /// The event from which the run repeats.
    pub cycle: Option<usize>,
    /// The codels that exclude each other, and the data they share.
    pub blocking: &'e [Row],
}

/// A specification, and a place in it.
pub(super) type SourceRef = (usize, Src);

/// The trace of a run. Codels and tasks without a place get none.
pub fn of_run(told: &TraceInput) -> Trace<SourceRef> {
    let last = told.events.last().map_or(0.0, |event| event.time);
    let unit = base_unit(told.unit, told.end.map_or(last, |end| end.max(last)));
    let time = |event: &Event| clean(told.unit.in_base(event.time, unit));
    let mut reading = TraceBuilder {
        excludes: Exclusions::of(told.blocking),
        lanes: Lanes::default(),
        steps: Vec::new(),
        marks: Vec::new(),
        arrows: Vec::new(),
        places: Vec::new(),
        rules: BTreeMap::new(),
    };
    for (step, event) in told.events.iter().enumerate() {
        reading.read(step, event, time(event));
    }
    let last = told.events.last().map_or(0.0, time);
    let end = told.end.map(|end| clean(told.unit.in_base(end, unit)));
    let end = end.unwrap_or(last).max(last);
    if let Ending::Miss(task) = told.ending {
        let owner = told.events.iter().rev().find(|event| event.thread == *task);
        if let Some(key) = owner.map(|owner| key_of(&owner.thread)) {
            reading.marks.push((key, end, MarkKind::Miss, None));
        }
    }
    let repeats = told.cycle.and_then(|cycle| told.events.get(cycle));
    reading.finish(told.title.clone(), unit, end, repeats.map(time))
}

/// The unit of all times of a trace: microseconds for a run of less than a millisecond.
fn base_unit(unit: TimeUnit, end: f64) -> Unit {
    if unit.in_base(end, Unit::Milliseconds) < 1.0 {
        Unit::Microseconds
    } else {
        Unit::Milliseconds
    }
}

/// A time without the rounding errors of binary fractions.
fn clean(time: f64) -> f64 {
    (time * 1e6).round() / 1e6
}

/// Codels that exclude each other, and the data they share.
struct Exclusions<'e> {
    through: HashMap<&'e str, HashMap<&'e str, &'e [Phrase]>>,
}

impl<'e> Exclusions<'e> {
    fn of(rows: &'e [Row]) -> Self {
        let others = |row: &'e Row| {
            let by = row.by.iter();
            by.map(|blocker| (&*blocker.codel.path, &*blocker.through)).collect()
        };
        let rows = rows.iter().filter(|row| !row.by.is_empty());
        Exclusions { through: rows.map(|row| (&*row.codel.path, others(row))).collect() }
    }

    /// The data that two codels share, if they exclude each other.
    fn through(&self, one: &str, other: &str) -> Option<&'e [Phrase]> {
        self.through.get(one)?.get(other).copied()
    }

    /// The data that a codel shares with some other codels, or with any.
    fn shared(&self, codel: &str, with: Option<&[&str]>) -> Vec<String> {
        let mut out: Vec<String> = Vec::new();
        let others = self.through.get(codel).into_iter().flatten();
        let wanted = others.filter(|(other, _)| with.is_none_or(|with| with.contains(other)));
        for text in wanted.flat_map(|(_, data)| data.iter()).map(ToString::to_string) {
            if !out.contains(&text) {
                out.push(text);
            }
        }
        out.sort();
        out
    }
}

struct TraceBuilder<'e> {
    excludes: Exclusions<'e>,
    lanes: Lanes,
    steps: Vec<(Key, Step)>,
    marks: Vec<(Key, f64, MarkKind, Option<usize>)>,
    /// Each arrow: the lane of its sender, that of its receiver, its time and its step.
    arrows: Vec<(Key, Key, f64, usize)>,
    places: Vec<SourceRef>,
    rules: BTreeMap<String, String>,
}

/// The lane of a task or of the control task of a component.
fn key_of(thread: &ThreadName) -> Key {
    let part = match &thread.task {
        Some(task) => Part::Task(task.clone()),
        None => Part::Control,
    };
    Key::Of(thread.component.clone(), part)
}

impl TraceBuilder<'_> {
    fn read(&mut self, step: usize, event: &Event, now: f64) {
        let thread = &event.thread;
        let mut key = key_of(thread);
        // The awaited reply of a client can be late.
        let client = Key::Client(thread.component.clone());
        if event.kind == MomentKind::Excess && thread.task.is_none() && self.lanes.has(&client) {
            key = client;
        }
        self.lanes.touch(&key);
        if let Some(victim) = &event.preempts {
            self.take_core(victim, thread, step, now);
        }
        self.spans(step, event, now, &key);
        if let Some(client) = &event.client {
            let from = Key::Client(client.clone());
            self.lanes.touch(&from);
            self.arrows.push((from, key.clone(), now, step));
        }
        if let Some(task) = &event.releases {
            self.arrows.push((key.clone(), key_of(task), now, step));
        }
        let mark = match event.kind {
            MomentKind::Tick => Some(MarkKind::Tick),
            MomentKind::Request => Some(MarkKind::Request),
            MomentKind::Complete => Some(MarkKind::Complete),
            MomentKind::Excess => Some(MarkKind::Miss),
            _ => None,
        };
        self.marks.extend(mark.map(|mark| (key.clone(), now, mark, Some(step))));
        let blockers: Vec<&str> = event.waits_for.iter().map(|wait| &*wait.codel).collect();
        let with = (event.kind == MomentKind::Wait).then_some(&*blockers);
        let codel_locks = event.codel.as_deref().map(|codel| self.excludes.shared(codel, with));
        let (rule, sentence) = rule(event.kind);
        self.rules.entry(rule.to_owned()).or_insert_with(|| sentence.to_owned());
        let place = event.src.map(|src| {
            let known = self.places.iter().position(|place| *place == src);
            known.unwrap_or_else(|| {
                self.places.push(src);
                self.places.len() - 1
            })
        });
        self.steps.push((
            key,
            Step {
                at: now,
                lane: 0,
                rule: rule.to_owned(),
                what: event.what.clone(),
                codel: event.codel.as_ref().map(ToString::to_string),
                locks: codel_locks.unwrap_or_default(),
                place,
            },
        ));
    }

    /// Begins and ends the spans in the lanes of a thread, its locks and its core.
    fn spans(&mut self, step: usize, event: &Event, now: f64, key: &Key) {
        let thread = &event.thread;
        let locks = Key::Of(thread.component.clone(), Part::Locks);
        let of = event.codel.clone().map(Of::Codel);
        let begun = |kind, codel: &CodelName| SpanStart {
            of: Of::Codel(codel.clone()),
            kind,
            label: codel.inside().to_owned(),
            step,
            ahead: Vec::new(),
        };
        let shares =
            event.codel.as_deref().is_some_and(|codel| self.excludes.through.contains_key(codel));
        match (event.kind, &event.codel, &of) {
            (MomentKind::Release, ..) if event.for_core => {
                let waits = SpanStart {
                    of: Of::Core(thread.clone()),
                    kind: SpanKind::WaitCore,
                    label: "waits for a core".to_owned(),
                    step,
                    ahead: Vec::new(),
                };
                self.lanes.begin(key, now, waits);
            }
            (MomentKind::Grant, ..) if event.preempts.is_none() => {
                let core = Of::Core(thread.clone());
                self.lanes.end(key, now, &core, SpanKind::WaitCore);
                let free = Key::Core(self.lanes.free_core());
                self.has_core(&free, thread.clone(), step, now);
            }
            (MomentKind::Wait, Some(path), Some(of)) => {
                let ahead = event.waits_for.iter().filter(|wait| wait.ahead);
                let ahead: Vec<CodelName> = ahead.map(|wait| wait.codel.clone()).collect();
                for lane in [key, &locks] {
                    if let Some(span) = self.lanes.open(lane, of, SpanKind::WaitLock) {
                        span.ahead.extend(ahead.iter().cloned());
                    } else {
                        let ahead = ahead.clone();
                        let waits = begun(SpanKind::WaitLock, path);
                        self.lanes.begin(lane, now, SpanStart { ahead, ..waits });
                    }
                }
            }
            (MomentKind::Begin, Some(path), Some(of)) => {
                self.lanes.end(key, now, of, SpanKind::WaitLock);
                self.lanes.end(&locks, now, of, SpanKind::WaitLock);
                self.lanes.begin(key, now, begun(SpanKind::Run, path));
                if shares {
                    self.lanes.begin(&locks, now, begun(SpanKind::Hold, path));
                }
            }
            (MomentKind::End, _, Some(of)) => {
                self.lanes.end(key, now, of, SpanKind::Run);
                self.lanes.end(&locks, now, of, SpanKind::Hold);
            }
            (MomentKind::Complete, ..) => {
                if let Some(core) = self.lanes.core_of(thread) {
                    self.lanes.end(&core, now, &Of::Core(thread.clone()), SpanKind::Run);
                }
            }
            _ => {}
        }
    }

    fn has_core(&mut self, core: &Key, thread: ThreadName, step: usize, now: f64) {
        let has = SpanStart {
            label: thread.own().to_owned(),
            of: Of::Core(thread),
            kind: SpanKind::Run,
            step,
            ahead: Vec::new(),
        };
        self.lanes.begin(core, now, has);
    }

    /// A job takes the core of another job.
    fn take_core(&mut self, victim: &ThreadName, by: &ThreadName, step: usize, now: f64) {
        let Some(core) = self.lanes.core_of(victim) else {
            return;
        };
        self.lanes.end(&core, now, &Of::Core(victim.clone()), SpanKind::Run);
        self.has_core(&core, by.clone(), step, now);
    }

    fn finish(self, title: String, unit: Unit, end: f64, repeats: Option<f64>) -> Trace<SourceRef> {
        let BuiltLanes { lanes, mut spans, ahead, at } = self.lanes.finish(end);
        let lane = |key: &Key| at.get(key).copied().unwrap_or(0);
        let core = |span: &Span| span.codel.is_none() && span.kind == SpanKind::Run;
        let holds = SpanIndex::of(spans.iter().filter(|span| span.kind == SpanKind::Hold));
        let cores = SpanIndex::of(spans.iter().filter(|span| core(span)));
        // The step with which a codel begins to execute gives its lane.
        let executes = |span: &Span| self.steps.get(span.step).map(|step| lane(&step.0));
        let mut waits = Vec::new();
        for (i, span) in spans.iter().enumerate() {
            let holder = |span: &Span| Holder {
                name: span.label.clone(),
                lane: executes(span),
                from: span.from,
                to: span.to,
                through: Vec::new(),
                ahead: false,
            };
            let by = match (span.kind, &span.codel) {
                (SpanKind::WaitLock, Some(codel)) => {
                    let mut by = holds.during(span, |span| {
                        let other = span.codel.as_deref()?;
                        let through = self.excludes.through(codel, other)?;
                        let through = through.iter().map(ToString::to_string).collect();
                        Some(Holder { through, ..holder(span) })
                    });
                    add_ahead(&mut by, &ahead[i], span);
                    by
                }
                (SpanKind::WaitCore, _) => cores.during(span, |span| Some(holder(span))),
                _ => continue,
            };
            waits.push((i, by));
        }
        for (i, by) in waits {
            spans[i].by = by;
        }
        let arrows = self.arrows.iter().filter_map(|(from, to, time, step)| {
            Some(Arrow { from: lane(from), to: *at.get(to)?, at: *time, step: *step })
        });
        let marks = self.marks.iter().map(|(key, at, kind, step)| Mark {
            lane: lane(key),
            at: *at,
            kind: *kind,
            step: *step,
        });
        let marks: Vec<Mark> = marks.collect();
        let missed = marks.iter().rev().find(|mark| mark.kind == MarkKind::Miss);
        let last = self.steps.len().checked_sub(1);
        Trace {
            format: FORMAT,
            title,
            unit,
            start: 0.0,
            end,
            focus: Focus {
                at: missed.map_or(end, |mark| mark.at),
                lane: missed.map(|mark| mark.lane),
                step: missed.and_then(|mark| mark.step).or(last),
                cause: None,
            },
            repeats,
            arrows: arrows.collect(),
            marks,
            steps: (self.steps.iter())
                .map(|(key, step)| Step { lane: lane(key), ..step.clone() })
                .collect(),
            rules: self.rules,
            places: self.places,
            notes: Vec::new(),
            lanes,
            spans,
        }
    }
}

/// Adds the codels that wait ahead in a queue of locks.
fn add_ahead(by: &mut Vec<Holder>, ahead: &[CodelName], wait: &Span) {
    for other in ahead {
        let name = other.inside();
        if by.iter().all(|holder| holder.name != name) {
            by.push(Holder {
                name: name.to_owned(),
                lane: None,
                from: wait.from,
                to: wait.to,
                through: Vec::new(),
                ahead: true,
            });
        }
    }
}

/// Spans in order of time, for queries about the holders during a wait.
struct SpanIndex<'s> {
    all: Vec<&'s Span>,
    longest: f64,
}

impl<'s> SpanIndex<'s> {
    fn of(spans: impl Iterator<Item = &'s Span>) -> Self {
        let mut all: Vec<&Span> = spans.collect();
        all.sort_by(|a, b| a.from.total_cmp(&b.from));
        let longest = all.iter().map(|span| span.to - span.from).fold(0.0, f64::max);
        SpanIndex { all, longest }
    }

    /// The holders during a wait, in order: the one at its beginning, and all later ones.
    fn during(&self, wait: &Span, holder: impl Fn(&Span) -> Option<Holder>) -> Vec<Holder> {
        // No span that began earlier than the longest duration before the wait can overlap it. This avoids a
        // search from the beginning of long runs.
        let first = (self.all).partition_point(|span| span.from < wait.from - self.longest);
        let after = self.all[first..].iter();
        let candidates = after.take_while(|span| span.from < wait.to);
        let meanwhile = candidates.filter(|candidate| candidate.to > wait.from);
        meanwhile.filter_map(|candidate| holder(candidate)).collect()
    }
}
