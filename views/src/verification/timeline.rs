//! Runs as timelines: if cores are granted, a lane per core; then one per task. Bars show execution and
//! waiting.

use std::collections::BTreeMap;

use dotgen_diagram::timeline::{Bar, BarKind, Lane, Mark, MarkKind, Timeline};
use dotgen_timing::explore::MomentKind;
use dotgen_timing::report::Event;

/// The end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending<'t> {
    /// This task (`component.task`) is late, and the events do not show it.
    Miss(&'t str),
    /// A valid end.
    Fine,
}

/// A run as a timeline. Links are indices into `events`.
pub fn of_run(title: String, unit: &str, events: &[Event], ending: Ending) -> Timeline {
    let (unit, factor) = time_unit(unit, events);
    let at = |time: f64| (time * factor).round() as u64;
    let end = events.last().map_or(0, |it| at(it.time));
    let mut tasks = Lanes::default();
    let mut cores = Lanes::default();
    for (i, event) in events.iter().enumerate() {
        let now = at(event.time);
        let name = lane_of(event);
        let lane = tasks.lane(&name);
        let next = match event.kind {
            MomentKind::Begin => Some(BarKind::Run),
            MomentKind::Wait => Some(BarKind::WaitLock),
            MomentKind::Release if event.for_core => Some(BarKind::WaitCore),
            _ => None,
        };
        let ends = matches!(
            event.kind,
            MomentKind::End | MomentKind::Grant | MomentKind::Complete
        );
        if next.is_some() || ends {
            tasks.close(lane, now, events);
        }
        if let Some(kind) = next {
            let label = event.codel.as_deref().map_or(String::new(), last_name);
            tasks.open.insert(lane, (now, kind, label, i));
        }
        match event.kind {
            MomentKind::Grant => {
                let core = cores.free();
                cores.holders.insert(name.clone(), core);
                let what = (now, BarKind::Run, last_name(&name), i);
                cores.open.insert(core, what);
            }
            MomentKind::Complete => {
                if let Some(core) = cores.holders.remove(&name) {
                    cores.close(core, now, events);
                }
            }
            _ => {}
        }
        let mark = match event.kind {
            MomentKind::Tick => Some(MarkKind::Tick),
            MomentKind::Request => Some(MarkKind::Request),
            MomentKind::Complete => Some(MarkKind::End),
            MomentKind::Excess => Some(MarkKind::Miss),
            _ => None,
        };
        if let Some(kind) = mark {
            tasks.lanes[lane].marks.push(Mark {
                at: now,
                description: format!("{}: {name}: {}", instant(now, unit), event.what),
                kind,
                link: event.src.is_some().then(|| i.to_string()),
            });
        }
    }
    tasks.finish(end, events);
    cores.finish(end, events);
    if let Ending::Miss(task) = ending {
        let lane = tasks.lane(task);
        tasks.lanes[lane].marks.push(Mark {
            at: end,
            description: format!("{task} is too late"),
            kind: MarkKind::Miss,
            link: None,
        });
    }
    tasks.lanes.sort_by(|a, b| a.name.cmp(&b.name));
    cores.lanes.extend(tasks.lanes);
    Timeline {
        title,
        unit: unit.to_owned(),
        start: 0,
        end,
        lanes: cores.lanes,
        notes: Vec::new(),
    }
}

/// Maximum number of events in a complete picture. Longer runs are shown from a moment on: thousands of bars
/// are slow to draw and not readable.
const MAX_EVENTS: usize = 800;
/// Number of events shown of a longer run, in addition to all events at the first moment.
const TAIL_EVENTS: usize = 500;

/// The first event of a run that is shown.
pub fn first_visible_event(events: &[Event]) -> usize {
    if events.len() <= MAX_EVENTS {
        return 0;
    }
    let from = events[events.len() - TAIL_EVENTS].time;
    events.partition_point(|it| it.time < from)
}

/// The picture of [`of_run`], from an event on.
pub fn of_end(
    title: String,
    unit: &str,
    events: &[Event],
    first: usize,
    ending: Ending,
) -> Timeline {
    let whole = of_run(title, unit, events, ending);
    if first == 0 {
        return whole;
    }
    let (_, factor) = time_unit(unit, events);
    let start = (events[first].time * factor).round() as u64;
    let mut out = whole.since(start);
    out.notes.push(omitted_note(first));
    out
}

/// The note in place of the omitted events.
pub fn omitted_note(events: usize) -> String {
    format!("{events} steps before are not shown")
}

/// A moment of a picture as text.
fn instant(now: u64, unit: &str) -> String {
    match unit {
        "us" if now >= 1000 => format!("{} ms", now as f64 / 1000.0),
        _ => format!("{now} {unit}"),
    }
}

/// The unit of a picture in which all times are whole, for the unit of a report (`ms`, `10 us`), and the
/// factor between both.
fn time_unit<'u>(unit: &'u str, events: &[Event]) -> (&'u str, f64) {
    let (count, unit) = match unit.split_once(' ') {
        Some((count, unit)) => (count.parse().unwrap_or(1.0), unit),
        None => (1.0, unit),
    };
    let whole = |it: &Event| {
        let time = it.time * count;
        (time - time.round()).abs() < 1e-6
    };
    match unit {
        "s" if !events.iter().all(whole) => ("ms", count * 1000.0),
        "ms" if !events.iter().all(whole) => ("us", count * 1000.0),
        _ => (unit, count),
    }
}

fn lane_of(event: &Event) -> String {
    match &event.task {
        Some(task) => format!("{}.{task}", event.component),
        None => event.component.clone(),
    }
}

fn last_name(path: &str) -> String {
    path.rsplit('.').next().unwrap_or_default().to_owned()
}

/// Begin, kind, label, event.
type OpenBar = (u64, BarKind, String, usize);

#[derive(Default)]
struct Lanes {
    lanes: Vec<Lane>,
    /// The open bar of each lane.
    open: BTreeMap<usize, OpenBar>,
    /// The core of each task that has one.
    holders: BTreeMap<String, usize>,
}

impl Lanes {
    fn lane(&mut self, name: &str) -> usize {
        let found = self.lanes.iter().position(|it| it.name == name);
        found.unwrap_or_else(|| {
            self.lanes.push(Lane {
                name: name.to_owned(),
                ..Lane::default()
            });
            self.lanes.len() - 1
        })
    }

    /// The first free core. The choice of a core does not affect the system.
    fn free(&mut self) -> usize {
        let core = (0..).find(|it| !self.holders.values().any(|held| held == it));
        self.lane(&format!("core {}", core.unwrap_or(0) + 1))
    }

    fn close(&mut self, lane: usize, now: u64, events: &[Event]) {
        if let Some(it) = self.open.remove(&lane) {
            self.lanes[lane].bars.extend(bar(it, now, events));
        }
    }

    fn finish(&mut self, end: u64, events: &[Event]) {
        for (lane, it) in std::mem::take(&mut self.open) {
            self.lanes[lane].bars.extend(bar(it, end, events));
        }
    }
}

fn bar((from, kind, label, event): OpenBar, to: u64, events: &[Event]) -> Option<Bar> {
    let it = &events[event];
    // Execution without duration is drawn, waiting without duration is not.
    (to > from || kind == BarKind::Run).then(|| Bar {
        from,
        to,
        label,
        description: format!("{}: {} ({from} to {to})", lane_of(it), it.what),
        kind,
        link: it.src.is_some().then(|| event.to_string()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(time: f64, task: &str, kind: MomentKind, what: &str) -> Event {
        Event {
            task: Some(task.to_owned()),
            for_core: kind == MomentKind::Release,
            ..Event::of_component(time, "a".to_owned(), kind, what.to_owned())
        }
    }

    #[test]
    fn bars_say_who_ran_who_waited_and_on_which_core() {
        use MomentKind::*;
        let events = [
            event(0.0, "t", Release, "released, asks for a core"),
            event(0.0, "t", Grant, "gets a core"),
            event(0.0, "t", Begin, "a.t.main begins"),
            event(0.0, "u", Release, "released, asks for a core"),
            event(1.5, "t", End, "a.t.main ends, yields ether"),
            event(1.5, "t", Complete, "job complete"),
            event(1.5, "u", Grant, "gets a core"),
            event(1.5, "u", Wait, "a.u.main waits for a.v.main"),
            event(2.0, "u", Tick, "tick before the job has ended"),
        ];
        let timeline = of_run("x".to_owned(), "ms", &events, Ending::Miss("a.u"));
        let mut text = format!("{} {}\n", timeline.unit, timeline.end);
        for lane in &timeline.lanes {
            text += &format!("{}:", lane.name);
            for it in &lane.bars {
                text += &format!(" {}-{} {:?}", it.from, it.to, it.kind);
            }
            for it in &lane.marks {
                text += &format!(" {:?}@{}", it.kind, it.at);
                let told = format!("{}: ", instant(it.at, "us"));
                assert!(
                    it.kind == MarkKind::Miss || it.description.starts_with(&told),
                    "{it:?}"
                );
            }
            text += "\n";
        }
        assert_eq!(
            text,
            "us 2000\n\
             core 1: 0-1500 Run 1500-2000 Run\n\
             a.t: 0-1500 Run End@1500\n\
             a.u: 0-1500 WaitCore 1500-2000 WaitLock Tick@2000 Miss@2000\n"
        );
    }

    #[test]
    fn a_run_lasts_until_its_limit_is_exceeded() {
        use MomentKind::*;
        let events = [
            event(0.0, "t", Begin, "a.t.main begins"),
            event(6.0, "t", Excess, "the job has taken more than 5 ms"),
        ];
        let timeline = of_run("x".to_owned(), "ms", &events, Ending::Fine);
        let lane = &timeline.lanes[0];
        assert_eq!((timeline.end, lane.bars[0].to), (6, 6));
        assert_eq!((lane.marks[0].kind, lane.marks[0].at), (MarkKind::Miss, 6));
    }
    #[test]
    fn of_a_long_run_the_end_is_shown() {
        use MomentKind::*;
        let steps = (0..2000).map(|i| {
            let (task, time) = (["t", "u"][i / 2 % 2], (i / 4) as f64);
            let (kind, what) = [(Begin, "begins"), (End, "ends")][i % 2];
            event(time, task, kind, what)
        });
        let events: Vec<Event> = steps.collect();
        assert_eq!(first_visible_event(&events[..MAX_EVENTS]), 0);
        let first = first_visible_event(&events);
        assert_eq!(first, 1500);
        let timeline = of_end("x".to_owned(), "ms", &events, first, Ending::Fine);
        assert_eq!((timeline.start, timeline.end), (375, 499));
        assert_eq!(timeline.notes, ["1500 steps before are not shown"]);
        let bars = timeline.lanes.iter().flat_map(|it| &it.bars);
        assert_eq!(bars.count(), 250);
    }
}
