//! Runs of a whole system. Components without codels are simulated: their execution times and yields are
//! drawn.

use std::io::Write;

use dotgen_analysis::model::PortId;
use dotgen_timing::explore::{Action, Run, Seen, Stepper, Work};
use dotgen_timing::system::{ComponentId, ServiceId, Ticks, TimedSystem};
use dotgen_timing::verify::Prepared;
use num_rational::Ratio;

use crate::checker::RunChecker;
use crate::decide::{Durations, RandomDecisions};
use crate::engine::{self, End};
use crate::live::Live;
use crate::measures::Measures;
use crate::port_writes::PortWrites;
use crate::profile::Profile;
use crate::progress::{ActivityStates, ProgressReceiver};
use crate::real_clock::{self, Pace};
use crate::tally::Tally;
use crate::watch::{CodelViolation, PortUpdate, RunObserver};
use crate::weights::Weights;

/// The plan of a simulation.
#[derive(Debug, Clone, Copy)]
pub struct Plan<'w> {
    /// Duration of each run, in base units.
    pub until: u64,
    /// Number of runs, each from the start. The first run has the seed, later runs have the seeds that
    /// follow.
    pub runs: u64,
    /// Seed of the random choices.
    pub seed: u64,
    /// Choice of execution times.
    pub durations: Durations,
    /// Weights of yields.
    pub weights: Option<&'w Weights>,
    /// End at the first violation.
    pub stop_at_violation: bool,
    /// Keep the actions of the first run, to describe it.
    pub record: bool,
}

/// Upper limit on the kept actions of a run.
const MAX_RECORDED_ACTIONS: usize = 1_000_000;

/// The outcome of a simulation.
#[derive(Debug)]
pub struct SimulationResult<'p> {
    /// Counts of all runs.
    pub tally: Tally,
    /// Writes of the output ports of hosted components.
    pub ports: PortWrites,
    /// Results of the checks.
    pub judge: RunChecker<'p>,
    /// End of the last run.
    pub end: End,
    /// Number of runs that have begun.
    pub runs: u64,
    /// Total time of all runs, in base units.
    pub time: u64,
    /// Services with a request that was refused because no slot was free.
    pub refused: Vec<ServiceId>,
    /// First run, if the plan asks for it. A run with too many actions is truncated and marked as [left
    /// out](Run::left_out).
    pub recorded: Option<Run>,
    /// Codels that were still executed when a run had to end, or else components that had not ended.
    pub unfinished: Vec<String>,
}

/// Receives a violation, by its number among those of the checker: how often it has come since it was passed
/// on last.
pub type ViolationReceiver<'v> = dyn Fn(&RunChecker<'_>, usize, u64) + 'v;

/// The execution of real codels.
pub struct Execution<'l, 'p> {
    /// Real codels.
    pub live: &'l mut Live<'p>,
    /// Real clock; `None` for the virtual clock.
    pub pace: Option<Pace>,
    /// Receiver of snapshots.
    pub follow: Option<&'l mut dyn ProgressReceiver>,
    /// Receives the first violation of each kind when it happens, and repetitions at most once a second.
    pub violated: Option<&'l ViolationReceiver<'l>>,
}

/// Records a run.
pub trait Record {
    /// Records an action before it is performed, with the execution time of a codel that it ends, in
    /// nanoseconds, if a host has executed the codel on the real clock.
    fn on_action(&mut self, stepper: &Stepper, action: Action, executed: Option<u64>);

    /// Records an interruption of an activity from outside, by its place, before it is performed.
    fn interrupt(&mut self, stepper: &Stepper, place: usize);

    /// Records that the run begins to end.
    fn on_ending(&mut self, stepper: &Stepper);

    /// Records new data of an output port.
    fn on_port_update(&mut self, stepper: &Stepper, written: &PortUpdate);

    /// Is called after time has passed: on the real clock, many times a second.
    fn moment(&mut self) {}

    /// Ends the recording.
    fn end(&mut self, stepper: &Stepper);
}

/// Runs a system without a recording: see [`simulate_recorded`].
pub fn simulate<'p, W: Write>(
    prepared: &'p Prepared,
    bounds: Vec<Option<Ticks>>,
    plan: &Plan,
    profile: Option<&mut Profile<'p, W>>,
    execution: Option<Execution<'_, 'p>>,
    interrupted: &dyn Fn() -> bool,
) -> SimulationResult<'p> {
    simulate_recorded(prepared, bounds, plan, profile, None, execution, interrupted)
}

/// Runs a system and records the first run. `bounds` are the known bounds on the response times of its tasks,
/// in base units.
pub fn simulate_recorded<'p, W: Write>(
    prepared: &'p Prepared,
    bounds: Vec<Option<Ticks>>,
    plan: &Plan,
    profile: Option<&mut Profile<'p, W>>,
    record: Option<&mut dyn Record>,
    mut execution: Option<Execution<'_, 'p>>,
    interrupted: &dyn Fn() -> bool,
) -> SimulationResult<'p> {
    let system = &prepared.built.system;
    let (watched, places) = prepared.watched();
    let mut stepper = Stepper::new(system, &watched);
    let second = system.unit.recip().to_integer();
    let second = u64::try_from(second).unwrap_or(u64::MAX).max(1);
    let follow = execution.as_mut().and_then(|execution| execution.follow.take());
    let violated = execution.as_ref().and_then(|execution| execution.violated);
    let facts = prepared.built.data.as_deref().unwrap_or_default();
    let mut judge = RunChecker::new(prepared, places, bounds.clone());
    let live = execution.as_mut().map(|execution| &mut *execution.live);
    judge.find_data(&|fact| live.as_ref().is_some_and(|live| live.has_data(fact)));
    if let Some(live) = live {
        live.compare(facts);
    }
    let mut observer = Observer {
        system,
        prepared,
        bounds,
        follow: follow.map(|execution| (execution, ActivityStates::default())),
        tally: Tally::new(system),
        judge,
        profile,
        offset: 0,
        stop_at_violation: plan.stop_at_violation,
        recorded: plan.record.then(Run::default),
        record,
        first: true,
        violated,
        measures: Measures::new(&prepared.built),
        ports: PortWrites::default(),
        shown: Vec::new(),
        repetitions_from: second,
        second,
        ended: None,
    };
    if let (Some(execution), Some(_)) = (&mut execution, &observer.record) {
        execution.live.keep_data();
    }
    let mut end = End::Done;
    let mut runs = 0;
    while runs < plan.runs {
        let seed = plan.seed.wrapping_add(runs);
        let mut dice =
            RandomDecisions::new(system, plan.durations, seed).with_weights(plan.weights);
        end = one_run(
            &mut stepper,
            &mut dice,
            plan.until,
            &mut observer,
            execution.as_mut(),
            interrupted,
        );
        observer.end_run(&stepper, end);
        runs += 1;
        let violated = plan.stop_at_violation && observer.judge.has_violations();
        if violated || end.ends_all() {
            break;
        }
    }
    SimulationResult {
        ports: observer.ports,
        tally: observer.tally,
        judge: observer.judge,
        time: observer.offset,
        refused: (system.services.keys()).filter(|&service| stepper.has_refused(service)).collect(),
        recorded: observer.recorded,
        unfinished: execution.map_or(Vec::new(), |execution| execution.live.unfinished().to_vec()),
        end,
        runs,
    }
}

/// Runs the system once, on the clock of the execution or else on the virtual clock.
fn one_run(
    stepper: &mut Stepper,
    dice: &mut RandomDecisions,
    until: u64,
    observer: &mut dyn RunObserver,
    execution: Option<&mut Execution<'_, '_>>,
    interrupted: &dyn Fn() -> bool,
) -> End {
    match execution {
        Some(Execution { live, pace: Some(pace), .. }) => {
            real_clock::run(stepper, dice, until, observer, live, *pace, interrupted)
        }
        other => {
            let live = other.map(|execution| &mut *execution.live);
            engine::run(stepper, dice, until, observer, live, interrupted)
        }
    }
}

struct Observer<'o, 'r, 'f, 'p, W> {
    system: &'p TimedSystem,
    prepared: &'p Prepared,
    bounds: Vec<Option<Ticks>>,
    /// Receiver of snapshots, with the present states.
    follow: Option<(&'f mut dyn ProgressReceiver, ActivityStates)>,
    tally: Tally,
    judge: RunChecker<'p>,
    profile: Option<&'o mut Profile<'p, W>>,
    /// Total time of earlier runs, in base units.
    offset: u64,
    stop_at_violation: bool,
    recorded: Option<Run>,
    record: Option<&'r mut dyn Record>,
    /// The present run is the first one.
    first: bool,
    /// Receives violations when they happen.
    violated: Option<&'f ViolationReceiver<'f>>,
    measures: Measures<'p>,
    ports: PortWrites,
    /// The number of occurrences of each violation when it was last passed on.
    shown: Vec<u64>,
    /// Time of all runs from which repetitions are passed on, in base units.
    repetitions_from: u64,
    /// A second, in base units.
    second: u64,
    /// Time at which the present run began to end, in base units: from then on its checks are not observed.
    ended: Option<u64>,
}

impl<W: Write> Observer<'_, '_, '_, '_, W> {
    /// Passes on new violations.
    fn show_violations(&mut self) {
        self.measures.on_checked(&self.judge);
        let Some(violated) = self.violated else { return };
        for number in self.shown.len()..self.judge.violations.len() {
            self.shown.push(self.judge.times[number]);
            violated(&self.judge, number, self.judge.times[number]);
        }
    }

    /// Passes on repetitions of violations.
    fn show_repetitions(&mut self) {
        let Some(violated) = self.violated else { return };
        for (number, shown) in self.shown.iter_mut().enumerate() {
            let times = self.judge.times[number];
            let more = times - std::mem::replace(shown, times);
            if more > 0 {
                violated(&self.judge, number, more);
            }
        }
    }

    /// Handles the end of a run.
    fn end_run(&mut self, stepper: &Stepper, end: End) {
        if self.ended.is_none() {
            self.tally.count_unfinished(stepper);
            self.judge.end_checks(stepper, end);
        }
        self.show_violations();
        self.show_repetitions();
        self.judge.next_run();
        self.measures.next_run();
        self.tally.busy.clear();
        if self.first {
            if let Some(run) = &mut self.recorded {
                run.end = if run.left_out {
                    run.steps.last().map_or(0, |step| step.0)
                } else {
                    stepper.now()
                };
            }
            if let Some(record) = &mut self.record {
                record.end(stepper);
            }
        }
        self.first = false;
        let ended = self.ended.take().unwrap_or(stepper.now());
        self.ports.end_run(ended);
        self.offset += ended;
    }
}

impl<W: Write> RunObserver for Observer<'_, '_, '_, '_, W> {
    fn on_event(&mut self, stepper: &Stepper, seen: &Seen) {
        if let Some(profile) = &mut self.profile {
            profile.on_event(&mut self.tally, stepper, seen, self.offset);
        }
        // The jobs of an end are no jobs of the run.
        let of_job = matches!(seen, Seen::Job { .. } | Seen::Missed { .. } | Seen::Overdue { .. });
        if self.ended.is_none() || !of_job {
            self.tally.on_event(self.system, stepper, seen);
        }
        if self.ended.is_none() {
            self.measures.on_event(seen);
            self.judge.on_event(stepper, seen);
            self.show_violations();
        }
        if let Some((_, states)) = &mut self.follow {
            states.on_event(self.system, seen);
        }
    }

    fn on_action(&mut self, stepper: &Stepper, action: Action, executed: Option<u64>) {
        let now = stepper.now();
        if let (Action::Finish { executor, .. }, Some(nanos)) = (action, executed) {
            let nanos = Ratio::new(i128::from(nanos), 1_000_000_000);
            let units = (nanos / self.system.unit).ceil().to_integer();
            self.tally.set_executed(executor, now, u64::try_from(units).unwrap_or(u64::MAX));
        }
        if let Some(record) = self.record.as_mut().filter(|_| self.first) {
            record.on_action(stepper, action, executed);
        }
        if let Some(run) = self.recorded.as_mut().filter(|_| self.first) {
            if run.steps.len() < MAX_RECORDED_ACTIONS {
                run.steps.push((now, action));
            } else {
                run.left_out = true;
            }
        }
    }

    fn interrupt(&mut self, stepper: &Stepper, place: usize) {
        if let Some(record) = self.record.as_mut().filter(|_| self.first) {
            record.interrupt(stepper, place);
        }
    }

    fn on_ending(&mut self, stepper: &Stepper, end: End) {
        if self.ended.is_none() {
            self.tally.count_unfinished(stepper);
            self.judge.end_checks(stepper, end);
            self.ended = Some(stepper.now());
            if let Some(profile) = &mut self.profile {
                profile.on_ending();
            }
        }
        if let Some(record) = self.record.as_mut().filter(|_| self.first) {
            record.on_ending(stepper);
        }
    }

    fn on_port_write(&mut self, stepper: &Stepper, component: ComponentId, port: PortId) {
        self.ports.on_write(stepper.now(), (component, port));
    }

    fn on_port_update(&mut self, stepper: &Stepper, written: &PortUpdate) {
        if let Some(record) = self.record.as_mut().filter(|_| self.first) {
            record.on_port_update(stepper, written);
        }
    }

    fn moment(&mut self, stepper: &Stepper) {
        if self.ended.is_none() {
            self.measures.on_moment(stepper.now(), &self.ports);
            self.judge.moment(stepper);
            self.show_violations();
            let now = self.offset + stepper.now();
            if now >= self.repetitions_from {
                self.show_repetitions();
                self.repetitions_from = now.saturating_add(self.second);
            }
        }
        if let Some(record) = self.record.as_mut().filter(|_| self.first) {
            record.moment();
        }
        if let Some((follow, states)) = &mut self.follow
            && follow.is_due()
        {
            let count = self.judge.count;
            let progress =
                states.progress(self.prepared, stepper, &self.tally, &self.bounds, count);
            follow.receive(progress);
        }
    }

    fn on_violation(&mut self, stepper: &Stepper, broken: CodelViolation) {
        self.measures.on_violation(&broken);
        self.judge.on_violation(stepper, broken);
        self.show_violations();
    }

    fn is_over(&self, stepper: &Stepper) -> Option<End> {
        if self.ended.is_some() {
            None
        } else if self.stop_at_violation && self.judge.has_violations() {
            Some(End::Stopped)
        } else {
            self.measures.stop(stepper).then_some(End::Measure)
        }
    }

    fn measure(&self, work: &Work) -> Option<bool> {
        self.measures.begun(work)
    }
}
