//! A log as a trace for [Perfetto](https://ui.perfetto.dev): tracks for tasks, cores, locks and requests.
//!
//! The trace consists of track events, in Perfetto's own format. Slices of one track are nested or follow
//! each other; overlapping slices get further tracks. A log does not contain the core of a codel, so codels
//! of tasks are assigned to as few cores as possible. It does not contain clients either: a request lasts
//! from its first codel, that of the control task if there is one, to its last codel.

mod proto;

use std::collections::BTreeMap;

use dotgen_analysis::model::ParamSource;
use dotgen_timing::scn::names::Names;
use rustc_hash::FxHashMap;

use crate::log::{Kind, Kinds, Left, Run};
use crate::matching::{CONTROL, event, site};
use proto::{Message, annotation, descriptor, event as track_event, packet};

/// The single sequence of packets.
const SEQUENCE: u64 = 1;

/// Collects the lines of a log.
#[derive(Debug, Default)]
pub struct Trace {
    /// Lines that are not in the trace.
    pub left: Left,
    kinds: Kinds,
    runs: Vec<Run>,
}

/// The place of a slice: a group, and a track of the group.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct TrackPlace {
    group: String,
    /// Order among the groups of one instance.
    rank: u64,
    track: String,
}

#[derive(Debug)]
struct Slice {
    place: TrackPlace,
    name: String,
    category: &'static str,
    begin: i64,
    end: i64,
    flow: Option<u64>,
    notes: Vec<(&'static str, String)>,
}

/// An activity under way.
#[derive(Debug, Clone)]
struct Request {
    flow: u64,
    begin: i64,
    end: i64,
    /// Expected event; empty before its first codel.
    awaited: String,
}

impl Trace {
    /// Reads a line of a log. `ended`: the line has its line break.
    pub fn line(&mut self, text: &[u8], ended: bool) {
        let Some((line, kind)) = self.left.sift(&mut self.kinds, text, ended) else {
            return;
        };
        self.runs.push(Run {
            asked: line.asked,
            began: line.began,
            ended: line.ended,
            kind,
        });
    }

    /// Returns the number of runs in the trace.
    pub fn runs(&self) -> usize {
        self.runs.len()
    }

    /// Returns the bytes of the trace. Locks are included if the specifications are given.
    pub fn finish(mut self, names: Option<&Names<'_>>) -> Vec<u8> {
        self.runs.sort_by_key(|it| (it.began, it.ended));
        let locks: Vec<Vec<String>> = (self.kinds.all.iter())
            .map(|it| names.map_or(Vec::new(), |names| locks_of(names, it)))
            .collect();
        let mut slices = Vec::new();
        let mut requests = Requests::default();
        for run in &self.runs {
            let Some(kind) = self.kinds.all.get(run.kind as usize) else {
                continue;
            };
            let flow = requests.flow(kind, run, &mut slices);
            let group = kind.instance.clone();
            let place = |group: String, rank, track: String| TrackPlace { group, rank, track };
            let task = match kind.task.as_str() {
                CONTROL => "control task".to_owned(),
                task => format!("task {task}"),
            };
            let notes = vec![
                ("service", kind.service.clone()),
                ("from", kind.from.clone()),
                ("to", kind.to.clone()),
            ];
            if run.asked < run.began {
                slices.push(Slice {
                    place: place(group.clone(), 0, task.clone()),
                    name: format!("waits for locks: {}", kind.function),
                    category: "wait",
                    begin: run.asked,
                    end: run.began,
                    flow: None,
                    notes: Vec::new(),
                });
            }
            let codel = |place: TrackPlace, category, flow, notes| Slice {
                place,
                name: kind.function.clone(),
                category,
                begin: run.began,
                end: run.ended,
                flow,
                notes,
            };
            slices.push(codel(place(group.clone(), 0, task), "codel", flow, notes));
            if kind.task != CONTROL {
                let cores = place("cores".to_owned(), 0, "core".to_owned());
                let whose = vec![("task", format!("{}.{}", kind.instance, kind.task))];
                slices.push(codel(cores, "core", None, whose));
            }
            for lock in locks.get(run.kind as usize).into_iter().flatten() {
                let place = place(group.clone(), 1, format!("lock {lock}"));
                slices.push(codel(place, "lock", None, Vec::new()));
            }
        }
        requests.end(&mut slices);
        written(slices)
    }
}

/// Returns the fields of the ids and the ports that a codel uses.
fn locks_of(names: &Names<'_>, kind: &Kind) -> Vec<String> {
    let Ok(site) = site(names, kind) else {
        return Vec::new();
    };
    let Some(member) = names.components.get(site.component) else {
        return Vec::new();
    };
    let mut out = Vec::new();
    for param in &member.component.codel(site.codel).params {
        match param.source {
            ParamSource::Ids => {
                let whole = "ids".to_owned();
                out.push(param.path.first().map_or(whole, |it| match it {
                    dotgen_analysis::model::PathElement::Member(name) => name.to_string(),
                    dotgen_analysis::model::PathElement::Index(_) => "ids".to_owned(),
                }));
            }
            ParamSource::Port(port) => {
                let port = member.component.ports.get(port as usize);
                out.extend(port.map(|it| it.name.to_string()));
            }
            _ => {}
        }
    }
    out.sort();
    out.dedup();
    out
}

/// Activities, by instance and service.
#[derive(Debug, Default)]
struct Requests {
    open: FxHashMap<(String, String), Vec<Request>>,
    flows: u64,
}

impl Requests {
    /// Returns the flow to which a run belongs.
    fn flow(&mut self, kind: &Kind, run: &Run, out: &mut Vec<Slice>) -> Option<u64> {
        // No service has this name: a permanent activity has no request.
        if !kind
            .service
            .starts_with(|it: char| it.is_alphabetic() || it == '_')
        {
            return None;
        }
        let key = (kind.instance.clone(), kind.service.clone());
        let open = self.open.entry(key).or_default();
        let from = event(&kind.from);
        let place = match kind.task.as_str() {
            CONTROL => None,
            _ => (open.iter().rposition(|it| it.awaited == from.name))
                .or_else(|| open.iter().position(|it| it.awaited.is_empty())),
        };
        let mut request = match place {
            Some(place) => open.remove(place),
            None => {
                self.flows += 1;
                Request {
                    flow: self.flows,
                    begin: run.asked,
                    end: run.ended,
                    awaited: String::new(),
                }
            }
        };
        request.end = request.end.max(run.ended);
        let flow = request.flow;
        let to = event(&kind.to);
        let goes_on = match kind.task.as_str() {
            CONTROL => kind.from == "validate" && kind.to == "::genom::ok",
            // Exceptions and `ether` end the activity: no codel starts from them.
            _ => {
                request.awaited = to.name.to_owned();
                to.name != "ether" && to.component == from.component
            }
        };
        match goes_on {
            true => open.push(request),
            false => out.push(slice_of(
                kind.instance.clone(),
                kind.service.clone(),
                &request,
            )),
        }
        Some(flow)
    }

    /// Ends the log. Activities under way last to their last line.
    fn end(self, out: &mut Vec<Slice>) {
        let mut open: Vec<_> = self.open.into_iter().collect();
        open.sort_by(|a, b| a.0.cmp(&b.0));
        for ((instance, service), requests) in open {
            let slices = requests.iter();
            out.extend(slices.map(|it| slice_of(instance.clone(), service.clone(), it)));
        }
    }
}

fn slice_of(instance: String, service: String, request: &Request) -> Slice {
    Slice {
        place: TrackPlace {
            group: instance,
            rank: 2,
            track: format!("requests of {service}"),
        },
        name: service,
        category: "request",
        begin: request.begin,
        end: request.end,
        flow: Some(request.flow),
        notes: Vec::new(),
    }
}

/// Returns the packets: descriptions of tracks, then slices.
fn written(mut slices: Vec<Slice>) -> Vec<u8> {
    slices.sort_by(|a, b| (&a.place, a.begin, a.end).cmp(&(&b.place, b.begin, b.end)));
    let mut trace = Message::default();
    let mut uuid = 0;
    let mut groups: BTreeMap<String, u64> = BTreeMap::new();
    let mut events: Vec<(i64, Message)> = Vec::new();
    for track in slices.chunk_by(|a, b| a.place == b.place) {
        let Some(place) = track.first().map(|it| &it.place) else {
            continue;
        };
        let parent = *groups.entry(place.group.clone()).or_insert_with(|| {
            uuid += 1;
            describe(&mut trace, uuid, None, &place.group, 0);
            uuid
        });
        // Lanes, with the end of the last slice of each.
        let mut lanes: Vec<(u64, i64)> = Vec::new();
        for slice in track {
            let lane = lanes.iter_mut().position(|it| it.1 <= slice.begin);
            let lane = lane.unwrap_or_else(|| {
                uuid += 1;
                let name = match (place.track.as_str(), lanes.len()) {
                    ("core", number) => format!("core {number}"),
                    (track, 0) => track.to_owned(),
                    (track, number) => format!("{track} ({})", number + 1),
                };
                describe(&mut trace, uuid, Some(parent), &name, place.rank);
                lanes.push((uuid, i64::MIN));
                lanes.len() - 1
            });
            if let Some(lane) = lanes.get_mut(lane) {
                lane.1 = slice.end;
                events.push((slice.begin, begin(slice, lane.0)));
                events.push((slice.end, end(slice, lane.0)));
            }
        }
    }
    // A stable sort: at equal times, the end of a slice stays before the beginning of the next one.
    events.sort_by_key(|it| it.0);
    for (_, event) in &events {
        trace.message(1, event);
    }
    trace.into_bytes()
}

fn describe(trace: &mut Message, uuid: u64, parent: Option<u64>, name: &str, rank: u64) {
    let mut track = Message::default();
    track.number(descriptor::UUID, uuid);
    track.text(descriptor::NAME, name);
    match parent {
        Some(parent) => {
            track.number(descriptor::PARENT, parent);
            track.number(descriptor::RANK, rank);
        }
        None => track.number(descriptor::CHILD_ORDERING, descriptor::EXPLICIT),
    }
    let mut out = Message::default();
    out.number(packet::SEQUENCE, SEQUENCE);
    out.message(packet::TRACK_DESCRIPTOR, &track);
    trace.message(1, &out);
}

fn begin(slice: &Slice, track: u64) -> Message {
    let mut event = Message::default();
    event.number(track_event::TYPE, track_event::BEGIN);
    event.number(track_event::TRACK, track);
    event.text(track_event::CATEGORY, slice.category);
    event.text(track_event::NAME, &slice.name);
    if let Some(flow) = slice.flow {
        event.fixed(track_event::FLOW, flow);
    }
    for (name, value) in &slice.notes {
        let mut note = Message::default();
        note.text(annotation::NAME, name);
        note.text(annotation::TEXT, value);
        event.message(track_event::ANNOTATION, &note);
    }
    at(slice.begin, &event)
}

fn end(slice: &Slice, track: u64) -> Message {
    let mut event = Message::default();
    event.number(track_event::TYPE, track_event::END);
    event.number(track_event::TRACK, track);
    at(slice.end, &event)
}

fn at(time: i64, event: &Message) -> Message {
    let mut out = Message::default();
    out.number(packet::TIMESTAMP, time.max(0) as u64);
    out.number(packet::SEQUENCE, SEQUENCE);
    out.message(packet::TRACK_EVENT, event);
    out
}
