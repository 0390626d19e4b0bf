//! Runs of a whole system. Components without codels are simulated: their execution times and yields are
//! drawn.

use std::io::Write;

use dotgen_timing::explore::{Action, Run, Seen, Stepper};
use dotgen_timing::system::{Ticks, TimedSystem};
use dotgen_timing::verify::Prepared;

use crate::decide::{Drawn, Durations};
use crate::engine::{self, End};
use crate::judge::Judge;
use crate::live::Live;
use crate::paced::{self, Pace};
use crate::profile::Profile;
use crate::progress::{Follow, States};
use crate::tally::Tally;
use crate::watch::{Broken, Published, Watch};

/// The plan of a simulation.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// Duration of each run, in base units.
    pub until: u64,
    /// Number of runs, each from the start. The first run has the seed, later runs have the seeds that
    /// follow.
    pub runs: u64,
    /// Seed of the random choices.
    pub seed: u64,
    /// Choice of execution times.
    pub durations: Durations,
    /// End at the first violation.
    pub stop_at_violation: bool,
    /// Keep the actions of the first run, to describe it.
    pub record: bool,
}

/// Upper limit on the kept actions of a run.
const RECORDED: usize = 1_000_000;

/// The outcome of a simulation.
#[derive(Debug)]
pub struct Outcome<'p> {
    /// Counts of all runs.
    pub tally: Tally,
    /// Results of the checks.
    pub judge: Judge<'p>,
    /// End of the last run.
    pub end: End,
    /// Number of runs that have begun.
    pub runs: u64,
    /// Total time of all runs, in base units.
    pub time: u64,
    /// Services with a request that was refused because no slot was free.
    pub refused: Vec<usize>,
    /// First run, if the plan asks for it. A run with too many actions is truncated and marked as [left
    /// out](Run::left_out).
    pub recorded: Option<Run>,
}

/// The execution of real codels.
pub struct Execution<'l, 'p> {
    /// Real codels.
    pub live: &'l mut Live<'p>,
    /// Real clock; `None` for the virtual clock.
    pub pace: Option<Pace>,
    /// Receiver of snapshots.
    pub follow: Option<&'l mut dyn Follow>,
}

/// Records a run.
pub trait Record {
    /// Records an action before it is performed.
    fn act(&mut self, stepper: &Stepper, action: Action);

    /// Records an interruption of an activity from outside, by its place, before it is performed.
    fn interrupt(&mut self, stepper: &Stepper, place: usize);

    /// Records new data of an output port.
    fn wrote(&mut self, stepper: &Stepper, written: &Published);

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
) -> Outcome<'p> {
    simulate_recorded(
        prepared,
        bounds,
        plan,
        profile,
        None,
        execution,
        interrupted,
    )
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
) -> Outcome<'p> {
    let system = &prepared.built.system;
    let (watched, places) = prepared.watched();
    let mut stepper = Stepper::new(system, &watched);
    let follow = execution.as_mut().and_then(|it| it.follow.take());
    let mut observer = Observer {
        system,
        prepared,
        bounds: bounds.clone(),
        follow: follow.map(|it| (it, States::default())),
        tally: Tally::new(system),
        judge: Judge::new(prepared, places, bounds),
        profile,
        offset: 0,
        stop_at_violation: plan.stop_at_violation,
        recorded: plan.record.then(Run::default),
        record,
        first: true,
    };
    if let (Some(execution), Some(_)) = (&mut execution, &observer.record) {
        execution.live.keep_data();
    }
    let mut end = End::Done;
    let mut runs = 0;
    while runs < plan.runs {
        let seed = plan.seed.wrapping_add(runs);
        let mut dice = Drawn::new(system, plan.durations, seed);
        let until = plan.until;
        end = match &mut execution {
            Some(Execution {
                live,
                pace: Some(pace),
                ..
            }) => paced::run(
                &mut stepper,
                &mut dice,
                until,
                &mut observer,
                live,
                *pace,
                interrupted,
            ),
            other => {
                let live = other.as_mut().map(|it| &mut *it.live);
                engine::run(
                    &mut stepper,
                    &mut dice,
                    until,
                    &mut observer,
                    live,
                    interrupted,
                )
            }
        };
        observer.tally.end(&stepper);
        observer.judge.end(&stepper, end);
        if let Some(run) = observer.recorded.as_mut().filter(|_| observer.first) {
            run.end = match run.left_out {
                true => run.steps.last().map_or(0, |it| it.0),
                false => stepper.now(),
            };
        }
        if let Some(record) = observer.record.as_mut().filter(|_| observer.first) {
            record.end(&stepper);
        }
        observer.first = false;
        observer.offset += stepper.now();
        runs += 1;
        let violated = plan.stop_at_violation && observer.judge.has_violations();
        if violated
            || matches!(
                end,
                End::Stopped | End::Interrupted | End::Standstill | End::NotStarted
            )
        {
            break;
        }
    }
    Outcome {
        tally: observer.tally,
        judge: observer.judge,
        time: observer.offset,
        refused: (0..system.services.len())
            .filter(|&it| stepper.has_refused(it))
            .collect(),
        recorded: observer.recorded,
        end,
        runs,
    }
}

struct Observer<'o, 'r, 'f, 'p, W> {
    system: &'p TimedSystem,
    prepared: &'p Prepared,
    bounds: Vec<Option<Ticks>>,
    /// Receiver of snapshots, with the present states.
    follow: Option<(&'f mut dyn Follow, States)>,
    tally: Tally,
    judge: Judge<'p>,
    profile: Option<&'o mut Profile<'p, W>>,
    /// Total time of earlier runs, in base units.
    offset: u64,
    stop_at_violation: bool,
    recorded: Option<Run>,
    record: Option<&'r mut dyn Record>,
    /// The present run is the first one.
    first: bool,
}

impl<W: Write> Watch for Observer<'_, '_, '_, '_, W> {
    fn see(&mut self, stepper: &Stepper, seen: &Seen) {
        if let Some(profile) = &mut self.profile {
            profile.see(&mut self.tally, stepper, seen, self.offset);
        }
        self.tally.see(self.system, stepper, seen);
        self.judge.see(stepper, seen);
        if let Some((_, states)) = &mut self.follow {
            states.see(self.system, seen);
        }
    }

    fn act(&mut self, stepper: &Stepper, action: Action) {
        let now = stepper.now();
        if let Some(record) = self.record.as_mut().filter(|_| self.first) {
            record.act(stepper, action);
        }
        if let Some(run) = self.recorded.as_mut().filter(|_| self.first) {
            match run.steps.len() < RECORDED {
                true => run.steps.push((now, action)),
                false => run.left_out = true,
            }
        }
    }

    fn interrupt(&mut self, stepper: &Stepper, place: usize) {
        if let Some(record) = self.record.as_mut().filter(|_| self.first) {
            record.interrupt(stepper, place);
        }
    }

    fn wrote(&mut self, stepper: &Stepper, written: &Published) {
        if let Some(record) = self.record.as_mut().filter(|_| self.first) {
            record.wrote(stepper, written);
        }
    }

    fn moment(&mut self, stepper: &Stepper) {
        self.judge.moment(stepper);
        if let Some(record) = self.record.as_mut().filter(|_| self.first) {
            record.moment();
        }
        if let Some((follow, states)) = &mut self.follow
            && follow.wants()
        {
            let count = self.judge.count;
            let progress =
                states.progress(self.prepared, stepper, &self.tally, &self.bounds, count);
            follow.hear(progress);
        }
    }

    fn broke(&mut self, stepper: &Stepper, broken: Broken) {
        self.judge.broke(stepper, broken);
    }

    fn is_over(&self) -> bool {
        self.stop_at_violation && self.judge.has_violations()
    }
}
