//! The predicates and patterns of checks, evaluated along a log.
//!
//! A log shows the codels of state machines and of control tasks: from the request for their locks to their
//! end. So the state of a run, as far as the log shows it, is the codel of each thread, and whether it waits
//! or executes. A thread that ends a codel waits for the next one at once, as in the verified model, if that
//! is the state that its next line shows. At the same nanosecond, codels that end come first, in the order of
//! the log; then come requests, then beginnings.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use dotgen_timing::explore::{RunState, Seen, Watched, Work};
use dotgen_timing::property::{Atom, Monitor, Predicate, StatePhase};
use dotgen_timing::system::{CodelId, MachineId, ServiceId, Ticks, TimedSystem};
use num_rational::Ratio;
use rustc_hash::FxHashMap;

/// Upper limit on the events that wait for earlier ones of other threads. A log is in order of the ends of
/// codels, so an event waits while a codel executes that began before it.
const MAX_PENDING_EVENTS: usize = 65_536;

const NANOS_PER_SECOND: i128 = 1_000_000_000;

/// The codel of a thread: of a state machine, or of a request to a control task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    State { machine: MachineId, state: usize },
    Control { service: ServiceId, codel: CodelId },
}

/// A thread of an instance: of a task or control task by its number, or of a machine whose asynchronous
/// codels have their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Thread {
    Task(u32, usize),
    Machine(u32, MachineId),
}

/// The codel of a thread, and whether it executes. Otherwise it waits for its locks.
type Present = Option<(Subject, bool)>;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Change {
    Ask,
    Begin,
    End,
}

/// A change of what a thread does, in order of time. Fields are compared in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct LogEvent {
    at: i64,
    /// Order among the changes of a moment; the first part is true if the codel ends later.
    order: (bool, u64, u64),
    change: Change,
    line: u64,
    thread: Thread,
    present: Present,
    /// The codel, and the task of a state: at its end.
    codel: CodelId,
    task: Option<usize>,
}

/// A codel that was executed.
#[derive(Debug, Clone, Copy)]
pub struct Executed {
    pub thread: Thread,
    pub subject: Subject,
    pub codel: CodelId,
    pub task: Option<usize>,
    /// The next codel of the same turn, if there is one.
    pub next: Option<Subject>,
    pub line: u64,
    /// Request for the locks, beginning and end, in nanoseconds.
    pub times: [i64; 3],
}

/// An event of the checks of a log.
#[derive(Debug, Clone, Copy)]
pub struct Noted {
    /// Line of the log that shows it.
    pub line: u64,
    /// Moment, in nanoseconds of the clock of the log.
    pub at: i64,
    /// `None`: time has passed.
    pub seen: Option<Seen>,
}

/// Evaluates what is watched along a log. See the [module](self).
#[derive(Debug)]
pub struct LogWatch {
    watched: Watched,
    /// Nanoseconds of a base unit.
    unit: Ratio<i128>,
    pending: BinaryHeap<Reverse<LogEvent>>,
    threads: FxHashMap<Thread, Present>,
    /// Codels of each thread that have not ended, in order.
    coming: FxHashMap<Thread, VecDeque<Subject>>,
    /// First moment of the log, and the present one.
    span: Option<(i64, i64)>,
    /// Beginning of the wait for each response that is awaited, by entry of [`Watched::within`].
    awaited: Vec<Vec<Option<i64>>>,
    /// Location of each monitor, and the last moment at which its first predicate became true.
    monitors: Vec<(u16, Option<i64>)>,
    /// Longest wait that ended, by entry of [`Watched::within`].
    longest: Vec<Option<i64>>,
    late: u64,
}

impl LogWatch {
    /// Creates a watch for the log of a system, in its initial state.
    pub fn new(system: &TimedSystem, watched: Watched) -> Self {
        LogWatch {
            unit: system.unit * Ratio::from_integer(NANOS_PER_SECOND),
            awaited: watched.within.iter().map(|(_, list)| vec![None; list.len()]).collect(),
            longest: vec![None; watched.within.len()],
            monitors: vec![(Monitor::INITIAL, None); watched.monitors.len()],
            watched,
            pending: BinaryHeap::new(),
            threads: FxHashMap::default(),
            coming: FxHashMap::default(),
            span: None,
            late: 0,
        }
    }

    /// Returns true if a log shows the value of an atom: not of a service with several codels or none, nor of
    /// a machine whose activities have threads of their own.
    pub fn shows(system: &TimedSystem, atom: &Atom) -> bool {
        match *atom {
            Atom::State { machine, .. } => {
                let machine = &system.machines[machine];
                !system.platform.async_free || machine.states.iter().all(|state| !state.is_async)
            }
            Atom::Handling { service, codel: None, .. } => {
                let service = &system.services[service];
                service.validate.iter().chain(&service.simple).count() == 1
            }
            Atom::Handling { .. } => true,
            _ => false,
        }
    }

    /// Returns the number of codels that began before a moment that had already been evaluated: then the
    /// order of the log is unknown.
    pub fn late(&self) -> u64 {
        self.late
    }

    /// Returns the longest wait so far for an entry of [`Watched::within`], in nanoseconds.
    pub fn longest(&self, within: usize) -> Option<i64> {
        let now = self.span.map_or(0, |span| span.1);
        let open = self.awaited[within].iter().flatten().map(|since| now - since);
        open.chain(self.longest[within]).max()
    }

    /// Adds a codel, and evaluates what is certain.
    pub fn add(&mut self, executed: &Executed, mut note: impl FnMut(&Self, Noted)) {
        let Executed { thread, subject, codel, task, line, times, .. } = *executed;
        let [asked, began, ended] = times;
        if self.span.is_some_and(|(_, now)| asked < now) {
            self.late += 1;
            return;
        }
        let mut add = |at: i64, change: Change, present: Present| {
            let number = change as u64;
            let order = if at < ended { (true, number, line) } else { (false, line, number) };
            let event = LogEvent { at, order, change, line, thread, present, codel, task };
            self.pending.push(Reverse(event));
        };
        add(asked, Change::Ask, Some((subject, false)));
        add(began, Change::Begin, Some((subject, true)));
        add(ended, Change::End, executed.next.map(|next| (next, false)));
        self.coming.entry(thread).or_default().push_back(subject);
        while self.pending.len() > MAX_PENDING_EVENTS {
            self.step(&mut note);
        }
    }

    /// Evaluates what is left at the end of a log.
    pub fn finish(&mut self, mut note: impl FnMut(&Self, Noted)) {
        while !self.pending.is_empty() {
            self.step(&mut note);
        }
    }

    /// Performs the earliest change.
    fn step(&mut self, note: &mut impl FnMut(&Self, Noted)) {
        let Some(Reverse(mut event)) = self.pending.pop() else { return };
        if event.change == Change::End {
            let coming = self.coming.entry(event.thread).or_default();
            coming.pop_front();
            // An interruption may lead elsewhere, and the log may end here.
            event.present = event.present.filter(|next| coming.front() == Some(&next.0));
        }
        let is_first = self.span.is_none();
        self.span = Some((self.span.map_or(event.at, |span| span.0), event.at));
        if self.awaited.iter().flatten().any(Option::is_some) {
            note(self, Noted { line: event.line, at: event.at, seen: None });
        }
        let mut seen = Vec::new();
        if is_first {
            // The state before the first codel.
            self.evaluate(None, &mut seen);
        }
        if event.change == Change::End {
            seen.push(Seen::Ended { executor: 0, work: event.work(), outcome: 0 });
        }
        let before = self.threads.insert(event.thread, event.present).flatten();
        if before != event.present {
            self.evaluate(Some((event.thread, before)), &mut seen);
        }
        for seen in seen {
            note(self, Noted { line: event.line, at: event.at, seen: Some(seen) });
        }
    }

    /// Moves the watches into the present state. `change`: the thread that has changed, and what it did
    /// before.
    fn evaluate(&mut self, change: Option<(Thread, Present)>, seen: &mut Vec<Seen>) {
        let threads = &self.threads;
        let now = |atom: &Atom| threads.values().flatten().any(|present| is_at(atom, *present));
        let was = |atom: &Atom| {
            change.is_some_and(|(thread, before)| {
                let others = threads.iter().filter(|entry| *entry.0 != thread);
                let mut all = others.filter_map(|entry| *entry.1).chain(before);
                all.any(|present| is_at(atom, present))
            })
        };
        let holds = |predicate: &Predicate| match change {
            Some(_) => predicate.eval(&|atom, is_now| if is_now { now(atom) } else { was(atom) }),
            None => predicate.eval_still(&now),
        };
        let held = |predicate: &Predicate| change.is_some() && predicate.eval_still(&was);
        for (predicate, entry) in self.watched.reach.iter().enumerate() {
            if holds(entry) && !held(entry) {
                seen.push(Seen::Reached { predicate });
            }
        }
        let moment = self.span.map_or(0, |span| span.1);
        let entries = self.watched.within.iter().zip(&mut self.awaited);
        for (within, ((trigger, responses), stages)) in entries.enumerate() {
            let is_free = stages.first().is_some_and(Option::is_none);
            let mut coming = (is_free && holds(trigger) && !held(trigger)).then_some(moment);
            for (stage, response) in stages.iter_mut().zip(responses) {
                let Some(since) = stage.or(coming) else { continue };
                let is_met = holds(response);
                coming = is_met.then_some(since);
                *stage = (!is_met).then_some(since);
            }
            if let Some(since) = coming {
                self.longest[within] = self.longest[within].max(Some(moment - since));
                let after = ticks_above(moment - since, self.unit);
                seen.push(Seen::Answered { within, after });
            }
        }
        for (number, monitor) in self.watched.monitors.iter().enumerate() {
            let (location, since) = &mut self.monitors[number];
            let first = &monitor.predicates[0];
            let rises = holds(first) && !held(first);
            if rises {
                *since = Some(moment);
            }
            let mut left = since.map_or(0, |since| {
                let passed = Ratio::from_integer(i128::from(moment - since)) / self.unit;
                let passed = Ticks::try_from(passed.to_integer()).unwrap_or(Ticks::MAX);
                monitor.time.saturating_sub(passed)
            });
            let (opening, before) = (monitor.opening(), *location);
            *location =
                monitor.next(*location, rises, &mut left, |i| holds(&monitor.predicates[i]));
            if monitor.is_exercised((before, *location), holds(opening) && !held(opening)) {
                seen.push(Seen::Opened { monitor: number });
            }
            if *location == Monitor::VIOLATED {
                (*location, *since) = (Monitor::INITIAL, None);
                seen.push(Seen::Violated { monitor: number });
            }
        }
    }
}

impl LogEvent {
    /// Returns the work that has ended.
    fn work(&self) -> Work {
        let codel = self.codel;
        match self.task {
            Some(task) => Work::State { codel, task, automaton: 0.into(), state: 0, slot: 0 },
            None => Work::Control { codel, service: 0.into(), number: 0 },
        }
    }
}

impl RunState for LogWatch {
    fn now(&self) -> u64 {
        let passed = self.span.map_or(0, |(first, now)| now - first);
        (Ratio::from_integer(i128::from(passed)) / self.unit).to_integer().try_into().unwrap_or(0)
    }

    fn job(&self, _: usize) -> Option<Ticks> {
        None
    }

    fn awaited(&self, within: usize) -> Option<Ticks> {
        let now = self.span.map_or(0, |span| span.1);
        let since = self.awaited.get(within)?.iter().flatten().min()?;
        Some(ticks_above(now - since, self.unit))
    }

    fn knows_fact(&self, _: usize) -> bool {
        false
    }
}

/// Returns the least number of base units that is not below a time in nanoseconds: a limit in base units is
/// exceeded by both or by none.
fn ticks_above(nanos: i64, unit: Ratio<i128>) -> Ticks {
    let units = (Ratio::from_integer(i128::from(nanos)) / unit).ceil().to_integer();
    Ticks::try_from(units).unwrap_or(Ticks::MAX)
}

/// Returns the value of an atom for what one thread does.
fn is_at(atom: &Atom, (subject, executes): (Subject, bool)) -> bool {
    let (is_subject, phase) = match (atom, subject) {
        (Atom::State { machine, state, phase }, Subject::State { machine: of, state: at }) => {
            (*machine == of && *state == at, phase)
        }
        (Atom::Handling { service, codel, phase }, Subject::Control { service: of, codel: at }) => {
            (*service == of && codel.is_none_or(|codel| codel == at), phase)
        }
        _ => return false,
    };
    is_subject
        && match phase {
            StatePhase::Any => true,
            StatePhase::Lock => !executes,
            StatePhase::Exec => executes,
        }
}
