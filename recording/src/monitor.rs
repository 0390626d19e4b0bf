//! Conformance of a log with the verified model.
//!
//! The monitor reads lines in order, so it can follow a log while the log grows. Its memory does not grow
//! with the log. Every deviation is an event that no run of the model shows (the numbers are sections of the
//! timed semantics):
//!
//! * a codel that is not in the specifications, or a transition that they do not declare (2);
//! * a codel that executes in a state that does not follow from the previous one (2);
//! * an execution longer or shorter than declared, if threads are not preempted meanwhile (2, 22);
//! * codels that exclude each other at the same time (7), or in another order than their requests, if the
//!   order matters (8);
//! * codels of one task at the same time, or more codels than cores (9);
//! * a codel that continues although one of higher priority has begun on the core to which both are bound
//!   (22);
//! * ticks of a periodic task that are not one period apart, as far as its greatest response time shows (4);
//! * a response time beyond its proved bound;
//! * a violated check of the scenario (10), which the [`LogWatch`] evaluates.
//!
//! A log does not contain the releases of jobs. The monitor therefore compares with a bound only the time
//! that a response has certainly lasted: from the first codel of a chain to its last codel in the same turn,
//! or from a moment at which its tick must have come.

mod deviation;
mod model;
mod order;
mod ticks;
mod watch;

use std::collections::BTreeMap;

use dotgen_timing::scn::names::Names;
use dotgen_timing::system::{CodelId, MachineId, TaskId, Ticks, TimedSystem};
use rustc_hash::FxHashMap;
use typed_index_collections::{TiVec, ti_vec};

use crate::log::{LineKinds, Origin, SkippedLines, origin};
use crate::matching::Mismatch;

pub use deviation::{Deviation, DeviationKind};
use model::{CodelOutcome, Model, ResolvedKind};
use order::{CodelRun, RunOrder};
use ticks::TickPhase;
pub use watch::{Executed, LogWatch, Noted, Subject, Thread};

/// Tolerance in nanoseconds: clocks of threads are read one after the other, so that smaller differences do
/// not prove an order.
pub const CLOCK_TOLERANCE_NANOS: i64 = 50_000;

/// Upper limit on the tracked activities.
const MAX_TRACKED_ACTIVITIES: usize = 32;

/// Upper limit on the kept deviations of each kind; all are counted.
const MAX_KEPT_DEVIATIONS: usize = 100;

/// The state in which a chain of codels continues.
#[derive(Debug, Clone, Copy)]
struct ExpectedState {
    state: usize,
    paused: bool,
    /// Beginning of the chain in this turn, in nanoseconds.
    since: i64,
}

/// A machine of one instance.
#[derive(Debug, Default)]
struct Machine {
    seen: bool,
    /// The machine has paused or ended.
    paused: bool,
    awaited: Vec<ExpectedState>,
}

/// The entry of a machine into a state.
struct StateEntry {
    /// Neither the start, nor the state after the last one, nor the state after an interruption.
    is_broken: bool,
    /// The machine has one activity at most.
    is_alone: bool,
    /// The state that was awaited last, before this entry.
    awaited: Option<usize>,
    /// The state begins a chain of codels in its turn.
    begins_chain: bool,
    /// Beginning of that chain, in nanoseconds.
    since: i64,
}

impl Machine {
    /// Enters a state whose codel was asked for at a time, in nanoseconds.
    fn enter(&mut self, at: &model::StateOutcome, asked: i64) -> StateEntry {
        // The last one: earlier ones may belong to interrupted activities.
        let place = self.awaited.iter().rposition(|expected| expected.state == at.state);
        let is_alone = self.awaited.len() <= 1;
        let known = place.map(|place| self.awaited.remove(place));
        let is_first = !std::mem::replace(&mut self.seen, true);
        let starts = at.state == at.start && (!at.permanent || is_first);
        let interrupted = at.stop == Some(at.state);
        let awaited = self.awaited.last().map(|expected| expected.state);
        if known.is_none() && interrupted {
            self.awaited.pop();
        }
        let since = match &known {
            Some(place) if !place.paused => place.since,
            _ => asked,
        };
        if let Some((state, paused)) = at.next {
            if self.awaited.len() >= MAX_TRACKED_ACTIVITIES {
                self.awaited.remove(0);
            }
            self.awaited.push(ExpectedState { state, paused, since });
        }
        StateEntry {
            is_broken: known.is_none() && !starts && !is_first && !interrupted,
            is_alone,
            awaited,
            begins_chain: known.is_none_or(|place| place.paused),
            since,
        }
    }
}

/// A task of one instance.
#[derive(Debug, Clone, Copy, Default)]
struct Task {
    chains: u64,
    greatest: i64,
    periodic: TickPhase,
}

/// A codel in a state.
#[derive(Debug, Clone, Copy, Default)]
struct Codel {
    runs: u64,
    greatest: i64,
    waited: i64,
}

/// Compares a log with the verified model. See the [module](self).
#[derive(Debug)]
pub struct Monitor<'s> {
    model: Model<'s>,
    /// Lines that were not used.
    pub left: SkippedLines,
    kinds: LineKinds,
    resolved: Vec<ResolvedKind>,
    instances: FxHashMap<String, u32>,
    machines: FxHashMap<(u32, MachineId), Machine>,
    tasks: FxHashMap<(u32, usize), Task>,
    codels: TiVec<CodelId, Codel>,
    /// Number of runs, by machine, state and outcome.
    taken: FxHashMap<(MachineId, usize, usize), u64>,
    order: RunOrder,
    foreign: BTreeMap<String, u64>,
    runs: u64,
    found: Vec<Deviation>,
    counts: BTreeMap<&'static str, u64>,
    /// The run that is read is ending.
    ending: bool,
}

/// The times of a task, in nanoseconds.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct TaskTimes {
    /// `component.task`
    pub task: String,
    /// Number of chains of codels in one turn.
    pub chains: u64,
    /// Greatest response time that is certain.
    pub greatest: i64,
    /// Proved bound.
    pub bound: Option<i64>,
    pub period: Option<i64>,
}

/// The times of a codel, in nanoseconds.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct CodelTimes {
    /// Path.
    pub codel: String,
    /// Number of runs.
    pub runs: u64,
    /// Greatest execution time.
    pub greatest: i64,
    /// Greatest wait for its locks.
    pub waited: i64,
    /// Greatest declared execution time.
    pub declared: Option<i64>,
}

/// A transition that was never taken.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
pub struct UntakenTransition {
    /// `component.task` or `component.service`.
    pub machine: String,
    /// State before the transition.
    pub from: String,
    /// State after the transition, with `pause::`, or `ether`.
    pub to: String,
}

#[derive(Debug, Clone, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct MonitorReport {
    /// Version of the JSON form.
    pub format: u32,
    /// Number of runs of codels that were compared.
    pub runs: u64,
    pub tasks: Vec<TaskTimes>,
    /// Codels that were executed.
    pub codels: Vec<CodelTimes>,
    /// Codels that were never executed.
    pub never_executed: Vec<String>,
    /// Transitions that were never taken.
    pub never_taken: Vec<UntakenTransition>,
    /// Components that are not in the scenario, with their number of lines.
    pub foreign: BTreeMap<String, u64>,
    /// The first deviations of each kind, in order.
    pub deviations: Vec<Deviation>,
    /// Number of all deviations, by kind.
    pub counts: BTreeMap<&'static str, u64>,
    /// Number of all deviations.
    pub deviation_count: u64,
    /// Lines that were not used.
    pub left: SkippedLines,
}

impl<'s> Monitor<'s> {
    /// Creates a monitor for logs of a system. `bounds` are the known bounds on the response times of its
    /// tasks, in base units.
    pub fn new(system: &'s TimedSystem, names: &'s Names<'s>, bounds: Vec<Option<Ticks>>) -> Self {
        Monitor {
            codels: ti_vec![Codel::default(); system.codels.len()],
            order: RunOrder::new(system),
            model: Model::new(system, names, bounds),
            left: SkippedLines::default(),
            kinds: LineKinds::default(),
            resolved: Vec::new(),
            instances: FxHashMap::default(),
            machines: FxHashMap::default(),
            tasks: FxHashMap::default(),
            taken: FxHashMap::default(),
            foreign: BTreeMap::new(),
            runs: 0,
            found: Vec::new(),
            counts: BTreeMap::new(),
            ending: false,
        }
    }

    /// Reads a line of a log. `ended`: the line has its line break. Returns the codel of the model that was
    /// executed.
    pub fn line(&mut self, number: u64, text: &[u8], ended: bool) -> Option<Executed> {
        match origin(text) {
            Some(Origin::Ending) => self.ending = true,
            Some(Origin::Measured | Origin::Simulated) => self.ending = false,
            _ => {}
        }
        // While components are shut down, turns do not wait for ticks.
        if self.ending {
            return None;
        }
        let (line, kind) = self.left.classify(&mut self.kinds, text, ended)?;
        while kind as usize >= self.resolved.len()
            && let Some(kind) = self.kinds.all.get(self.resolved.len())
        {
            let next = self.instances.len() as u32;
            let instance = *self.instances.entry(kind.instance.clone()).or_insert(next);
            self.resolved.push(self.model.resolve(kind, instance));
        }
        let resolved = self.resolved.get(kind as usize).copied()?;
        let run = CodelRun {
            asked: line.asked,
            began: line.began,
            ended: line.ended,
            line: number,
            ..CodelRun::default()
        };
        match resolved {
            ResolvedKind::Mismatch(Mismatch::NoCodel) => {}
            ResolvedKind::Mismatch(Mismatch::Component) => {
                if let Some(kind) = self.kinds.all.get(kind as usize) {
                    *self.foreign.entry(kind.instance.clone()).or_default() += 1;
                }
            }
            ResolvedKind::Mismatch(stray) => {
                let kind = self.kinds.all.get(kind as usize).cloned();
                if let Some(kind) = kind {
                    let what = DeviationKind::Unknown {
                        task: kind.task,
                        service: kind.service,
                        function: kind.function,
                        from: kind.from,
                        why: stray,
                    };
                    self.report(&run, kind.instance, what);
                }
            }
            ResolvedKind::State(at) => {
                self.state(at, kind, run);
                return Some(self.executed_state(at, &run));
            }
            ResolvedKind::Control { codel, component, service, instance, declared } => {
                self.codel(codel, &run);
                if !declared
                    && let Some(to) = self.kinds.all.get(kind as usize).map(|kind| kind.to.clone())
                {
                    let from = self.model.last_name(codel);
                    self.report(
                        &run,
                        self.model.path(codel),
                        DeviationKind::Transition { from, to },
                    );
                }
                let run = CodelRun {
                    codel,
                    instance,
                    thread: self.model.control(component),
                    core: None,
                    ..run
                };
                self.check_order(run);
                return Some(Executed {
                    thread: Thread::Task(instance, self.model.control(component)?),
                    subject: Subject::Control { service, codel },
                    codel,
                    task: None,
                    next: None,
                    line: number,
                    times: [line.asked, line.began, line.ended],
                });
            }
        }
        None
    }

    fn executed_state(&self, at: model::StateOutcome, run: &CodelRun) -> Executed {
        let machine = at.machine;
        let next = at.next.filter(|(_, paused)| !paused);
        Executed {
            thread: match self.model.thread(at.task, at.is_async) {
                Some(thread) => Thread::Task(at.instance, thread),
                None => Thread::Machine(at.instance, machine),
            },
            subject: Subject::State { machine, state: at.state },
            codel: at.codel,
            task: Some(at.task),
            next: next.map(|(state, _)| Subject::State { machine, state }),
            line: run.line,
            times: [run.asked, run.began, run.ended],
        }
    }

    fn report(&mut self, run: &CodelRun, of: String, what: DeviationKind) {
        let count = self.counts.entry(what.kind()).or_default();
        *count += 1;
        if *count <= MAX_KEPT_DEVIATIONS as u64 {
            self.found.push(Deviation {
                line: run.line,
                at: run.began,
                of,
                rule: what.rule(),
                what,
            });
        }
    }

    /// Adds a violation of a check, which a line shows at a moment in nanoseconds.
    pub fn violated(&mut self, line: u64, at: i64, check: String) {
        let run = CodelRun { line, began: at, ..CodelRun::default() };
        self.report(&run, check, DeviationKind::Check);
    }

    /// Returns the kept deviations from index `since` on.
    pub fn found(&self, since: usize) -> &[Deviation] {
        self.found.get(since..).unwrap_or_default()
    }

    /// Returns the number of all deviations.
    pub fn deviations(&self) -> u64 {
        self.counts.values().sum()
    }

    /// Checks a run of a codel, by any thread.
    fn codel(&mut self, codel: CodelId, run: &CodelRun) {
        self.runs += 1;
        let took = run.ended - run.began;
        if let Some(codel) = self.codels.get_mut(codel) {
            codel.runs += 1;
            codel.greatest = codel.greatest.max(took);
            codel.waited = codel.waited.max(run.began - run.asked);
        }
        let (least, greatest) = self.model.limits(codel);
        if let Some(limit) = greatest.filter(|&number| took > number + 1) {
            self.report(run, self.model.path(codel), DeviationKind::Longer { took, limit });
        }
        if let Some(limit) = least.filter(|&number| took + 1 < number) {
            self.report(run, self.model.path(codel), DeviationKind::Shorter { took, limit });
        }
    }

    /// Checks mutual exclusion, order and cores against runs at the same time.
    fn check_order(&mut self, run: CodelRun) {
        let mut all = Vec::new();
        self.order.add(self.model.system, run, &mut all);
        for (codel, what) in all {
            let what = match what {
                order::OrderViolation::Together(other) => {
                    DeviationKind::Together { other: self.model.path(other) }
                }
                order::OrderViolation::Overtaken(other) => {
                    DeviationKind::Overtaken { other: self.model.path(other) }
                }
                order::OrderViolation::SameThread(other) => {
                    DeviationKind::SameTask { other: self.model.path(other) }
                }
                order::OrderViolation::SameCore(other, core) => DeviationKind::SameCore {
                    other: self.model.path(other),
                    // Scenarios count cores from 1.
                    core: core + 1,
                },
                order::OrderViolation::Cores(executing, cores) => {
                    DeviationKind::Cores { executing, cores }
                }
            };
            self.report(&run, self.model.path(codel), what);
        }
    }

    fn state(&mut self, at: model::StateOutcome, kind: u32, run: CodelRun) {
        self.codel(at.codel, &run);
        let key = (at.instance, at.machine);
        let machine = self.machines.entry(key).or_default();
        // Servers start their tasks before cores matter.
        let starts_up = at.permanent && !machine.paused;
        machine.paused |= at.next.is_none_or(|(_, paused)| paused);
        let core = self.model.core(at.task, at.is_async);
        let run = CodelRun {
            codel: at.codel,
            instance: at.instance,
            thread: self.model.thread(at.task, at.is_async),
            core: core.filter(|_| !starts_up),
            core_and_priority: self
                .model
                .core_and_priority(at.task, at.is_async)
                .filter(|_| !starts_up),
            ..run
        };
        self.check_order(run);
        if let CodelOutcome::Undeclared = at.to {
            let to = self.kinds.all.get(kind as usize).map(|kind| kind.to.clone());
            let what = DeviationKind::Transition {
                from: self.model.last_name(at.codel),
                to: to.unwrap_or_default(),
            };
            self.report(&run, self.model.path(at.codel), what);
        }
        if let CodelOutcome::Outcome(outcome) = at.to {
            let key = (at.machine, at.state, outcome);
            *self.taken.entry(key).or_default() += 1;
        }
        let machine = self.machines.entry(key).or_default();
        let entry = machine.enter(&at, run.asked);
        if entry.is_broken {
            let awaited = entry.awaited.map(|state| self.model.state_name(at.machine, state));
            let what = DeviationKind::Elsewhere { state: self.model.last_name(at.codel), awaited };
            self.report(&run, self.model.path(at.codel), what);
        }
        // A chain of asynchronous codels with threads of their own lasts over several turns, and is not a
        // job.
        if entry.is_alone && !(at.is_async && self.model.system.platform.async_free) {
            let ends = at.next.is_none_or(|(_, paused)| paused);
            self.chain(at, &run, entry.since, entry.begins_chain, ends);
        }
    }

    /// Adds a codel to a chain that began at `since` in this turn.
    fn chain(
        &mut self,
        at: model::StateOutcome,
        run: &CodelRun,
        since: i64,
        begins: bool,
        ends: bool,
    ) {
        let limits = self.model.of_task(at.task);
        let task = self.tasks.entry((at.instance, at.task)).or_default();
        let mut tick = since;
        let mut off = None;
        if at.permanent
            && let (Some(period), Some(latest)) = (limits.period, limits.latest)
        {
            if begins {
                off = task.periodic.begins(since, period, latest);
            }
            tick = task.periodic.tick(period).map_or(since, |tick| tick.min(since));
        }
        let mut beyond = None;
        if ends {
            let response = run.ended - tick;
            task.chains += 1;
            task.greatest = task.greatest.max(response);
            beyond = limits
                .bound
                .filter(|&bound| response > bound + 1)
                .map(|bound| DeviationKind::Response { response, bound });
        }
        let name = || self.model.system.task_path(TaskId::from(at.task));
        if let Some(off) = off {
            self.report(run, name(), off);
        } else if let Some(beyond) = beyond {
            self.report(run, name(), beyond);
        }
    }

    pub fn report_so_far(&self) -> MonitorReport {
        let system = self.model.system;
        let tasks = (0..system.tasks.len()).map(|task| {
            let limits = self.model.of_task(task);
            let of = self.tasks.iter().filter(|candidate| candidate.0.1 == task);
            let (mut chains, mut greatest) = (0, 0);
            for (_, task) in of {
                chains += task.chains;
                greatest = greatest.max(task.greatest);
            }
            TaskTimes {
                task: system.task_path(TaskId::from(task)),
                chains,
                greatest,
                bound: limits.bound,
                period: limits.period,
            }
        });
        let executed = |codel: &&(CodelId, &Codel)| codel.1.runs > 0;
        let codels = self.codels.iter_enumerated();
        let codels = codels.filter(|codel| executed(&codel)).map(|(number, codel)| CodelTimes {
            codel: self.model.path(number),
            runs: codel.runs,
            greatest: codel.greatest,
            waited: codel.waited,
            declared: self.model.declared(number),
        });
        let never = self.model.codels_of_threads();
        let never =
            never.filter(|&codel| self.codels.get(codel).is_some_and(|codel| codel.runs == 0));
        let mut never: Vec<String> = never.map(|codel| self.model.path(codel)).collect();
        never.sort();
        never.dedup();
        MonitorReport {
            format: 1,
            runs: self.runs,
            tasks: tasks.collect(),
            codels: codels.collect(),
            never_executed: never,
            never_taken: self.model.untaken_transitions(&self.taken),
            foreign: self.foreign.clone(),
            deviations: self.found.clone(),
            counts: self.counts.clone(),
            deviation_count: self.deviations(),
            left: self.left,
        }
    }
}
