//! A log as a trace for [Perfetto](https://ui.perfetto.dev): tracks for tasks, cores, locks and requests.
//!
//! The trace consists of track events, in Perfetto's own format. Slices of one track are nested or follow
//! each other; overlapping slices get further tracks. A log does not contain the core of a codel, so codels
//! of tasks are assigned to as few cores as possible. It does not contain clients either: a request lasts
//! from its first codel, that of the control task if there is one, to its last codel.
//!
//! Packets are written as soon as their slice has ended, so a trace that breaks off has everything before.
//! Perfetto sorts packets by time.

mod proto;

use std::collections::BTreeMap;

use dotgen_analysis::model::ParamSource;
use dotgen_timing::scn::names::Names;
use rustc_hash::FxHashMap;

use crate::log::{LineKind, LineKinds, LoggedRun, SkippedLines};
use crate::matching::{CONTROL, event, site};
use proto::{Message, annotation, descriptor, event as track_event, packet};

/// The single sequence of packets.
const SEQUENCE: u64 = 1;

/// Makes packets of the lines of a log.
#[derive(Debug)]
pub struct Trace<'n> {
    /// Lines that are not in the trace.
    pub left: SkippedLines,
    names: Option<&'n Names<'n>>,
    kinds: LineKinds,
    /// Locks of codels, by kind.
    locks: Vec<Vec<String>>,
    /// Runs whose packets are not made yet.
    runs: Vec<LoggedRun>,
    requests: Requests,
    tracks: Tracks,
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

impl<'n> Trace<'n> {
    /// Creates a trace. Locks are included if the specifications are given.
    pub fn new(names: Option<&'n Names<'n>>) -> Self {
        Trace {
            left: SkippedLines::default(),
            names,
            kinds: LineKinds::default(),
            locks: Vec::new(),
            runs: Vec::new(),
            requests: Requests::default(),
            tracks: Tracks::default(),
        }
    }

    /// Reads a line of a log. `ended`: the line has its line break.
    pub fn line(&mut self, text: &[u8], ended: bool) {
        let Some((line, kind)) = self.left.classify(&mut self.kinds, text, ended) else {
            return;
        };
        self.runs.push(LoggedRun { asked: line.asked, began: line.began, ended: line.ended, kind });
    }

    /// Returns the bytes that the lines since the last call add to the trace.
    pub fn packets(&mut self) -> Vec<u8> {
        let mut slices = Vec::new();
        let mut runs = std::mem::take(&mut self.runs);
        // Codels are logged as they end. Lines of several logs are mixed.
        runs.sort_by_key(|run| run.ended);
        for run in &runs {
            self.run(run, &mut slices);
        }
        let mut out = Message::default();
        for slice in &slices {
            self.tracks.write(slice, &mut out);
        }
        out.into_bytes()
    }

    /// Returns the last bytes of the trace.
    pub fn finish(mut self) -> Vec<u8> {
        let mut bytes = self.packets();
        let mut slices = Vec::new();
        self.requests.end(&mut slices);
        let mut out = Message::default();
        for slice in &slices {
            self.tracks.write(slice, &mut out);
        }
        bytes.extend(out.into_bytes());
        bytes
    }

    /// Adds the slices of a run.
    fn run(&mut self, run: &LoggedRun, slices: &mut Vec<Slice>) {
        while self.locks.len() < self.kinds.all.len()
            && let Some(kind) = self.kinds.all.get(self.locks.len())
        {
            let locks = self.names.map(|names| locks_of(names, kind));
            self.locks.push(locks.unwrap_or_default());
        }
        let Some(kind) = self.kinds.all.get(run.kind as usize) else {
            return;
        };
        let mut ended = Vec::new();
        let flow = self.requests.flow(kind, run, &mut ended);
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
        for lock in self.locks.get(run.kind as usize).into_iter().flatten() {
            let place = place(group.clone(), 1, format!("lock {lock}"));
            slices.push(codel(place, "lock", None, Vec::new()));
        }
        slices.append(&mut ended);
    }
}

/// Returns the fields of the ids and the ports that a codel uses.
fn locks_of(names: &Names<'_>, kind: &LineKind) -> Vec<String> {
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
                out.push(param.path.first().map_or(whole, |path| match path {
                    dotgen_analysis::model::PathElement::Member(name) => name.to_string(),
                    dotgen_analysis::model::PathElement::Index(_) => "ids".to_owned(),
                }));
            }
            ParamSource::Port(port) => {
                let port = member.component.ports.get(port);
                out.extend(port.map(|port| port.name.to_string()));
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
    fn flow(&mut self, kind: &LineKind, run: &LoggedRun, out: &mut Vec<Slice>) -> Option<u64> {
        // No service has this name: a permanent activity has no request.
        if !kind
            .service
            .starts_with(|character: char| character.is_alphabetic() || character == '_')
        {
            return None;
        }
        let key = (kind.instance.clone(), kind.service.clone());
        let open = self.open.entry(key).or_default();
        let from = event(&kind.from);
        let place = match kind.task.as_str() {
            CONTROL => None,
            _ => (open.iter().rposition(|request| request.awaited == from.name))
                .or_else(|| open.iter().position(|request| request.awaited.is_empty())),
        };
        let mut request = if let Some(place) = place {
            open.remove(place)
        } else {
            self.flows += 1;
            Request { flow: self.flows, begin: run.asked, end: run.ended, awaited: String::new() }
        };
        request.end = request.end.max(run.ended);
        let flow = request.flow;
        let to = event(&kind.to);
        let goes_on = if kind.task.as_str() == CONTROL {
            kind.from == "validate" && kind.to == "::genom::ok"
        } else {
            to.name.clone_into(&mut request.awaited);
            to.name != "ether" && to.component == from.component
        };
        if goes_on {
            open.push(request);
        } else {
            out.push(slice_of(kind.instance.clone(), kind.service.clone(), &request));
        }
        Some(flow)
    }

    /// Ends the log. Activities under way last to their last line.
    fn end(self, out: &mut Vec<Slice>) {
        let mut open: Vec<_> = self.open.into_iter().collect();
        open.sort_by(|a, b| a.0.cmp(&b.0));
        for ((instance, service), requests) in open {
            let slices = requests.iter();
            out.extend(slices.map(|slice| slice_of(instance.clone(), service.clone(), slice)));
        }
    }
}

fn slice_of(instance: String, service: String, request: &Request) -> Slice {
    Slice {
        place: TrackPlace { group: instance, rank: 2, track: format!("requests of {service}") },
        name: service,
        category: "request",
        begin: request.begin,
        end: request.end,
        flow: Some(request.flow),
        notes: Vec::new(),
    }
}

/// The tracks that have been described.
#[derive(Debug, Default)]
struct Tracks {
    groups: BTreeMap<String, u64>,
    /// Lanes of each place, each with its identifier and the end of its last slice.
    lanes: BTreeMap<TrackPlace, Vec<(u64, i64)>>,
    /// Last identifier.
    uuid: u64,
}

impl Tracks {
    /// Writes a slice, after the description of its track if that is new.
    fn write(&mut self, slice: &Slice, out: &mut Message) {
        let place = &slice.place;
        let parent = if let Some(&parent) = self.groups.get(&place.group) {
            parent
        } else {
            self.uuid += 1;
            describe(out, self.uuid, None, &place.group, 0);
            self.groups.insert(place.group.clone(), self.uuid);
            self.uuid
        };
        let lanes = match self.lanes.get_mut(place) {
            Some(lanes) => lanes,
            None => self.lanes.entry(place.clone()).or_default(),
        };
        // Slices come as they end. The free lane that was used last is the one that leads to the fewest.
        let free = lanes.iter_mut().filter(|lane| lane.1 <= slice.begin);
        let lane = if let Some(lane) = free.max_by_key(|lane| lane.1) {
            lane.1 = slice.end;
            lane.0
        } else {
            self.uuid += 1;
            let name = match (place.track.as_str(), lanes.len()) {
                ("core", number) => format!("core {number}"),
                (track, 0) => track.to_owned(),
                (track, number) => format!("{track} ({})", number + 1),
            };
            describe(out, self.uuid, Some(parent), &name, place.rank);
            lanes.push((self.uuid, slice.end));
            self.uuid
        };
        out.message(1, &begin(slice, lane));
        out.message(1, &end(slice, lane));
    }
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
