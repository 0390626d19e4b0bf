//! Counts along runs.

use dotgen_timing::explore::{RunState as _, Seen, Stepper, Work};
use dotgen_timing::system::{ClientId, CodelId, MachineId, ServiceId, Ticks, TimedSystem};
use typed_index_collections::{TiVec, ti_vec};

/// Statistics of repeated times, in base units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Times {
    /// Number of times.
    pub count: u64,
    /// Least time, if there is one.
    pub least: Ticks,
    /// Greatest time.
    pub greatest: Ticks,
    /// Sum.
    pub total: u64,
}

impl Times {
    pub fn add(&mut self, time: Ticks) {
        self.least = match self.count {
            0 => time,
            _ => self.least.min(time),
        };
        self.greatest = self.greatest.max(time);
        self.count += 1;
        self.total += u64::from(time);
    }
}

/// The counts of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TaskTally {
    /// Response times of jobs that have ended.
    pub jobs: Times,
    /// Greatest duration of a job so far, including a job that has not ended.
    pub greatest: Option<Ticks>,
    /// Ticks that came before the previous job had ended.
    pub missed: u64,
    /// Jobs that waited for a core for at least their period.
    pub overdue: u64,
    /// Time in which codels of the activities that have ended held their locks, in base units.
    pub executed: u64,
}

/// The counts of a service.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ServiceTally {
    /// Requests that the control task has taken.
    pub requests: u64,
    /// Requests refused by `after` or `before`, for lack of a slot, or by a codel or its exception.
    pub refused: u64,
    /// Activities that have ended in `ether`, or by an exception.
    pub ended: u64,
}

/// The counts of a codel in one place of use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CodelTally {
    /// Times from the grant of its locks to their release.
    pub runs: Times,
    /// Times from the request of its locks to their grant.
    pub waits: Times,
}

/// The present work of an executor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ActiveWork {
    /// Time of the request of its locks.
    pub(crate) asked: u64,
    /// Time of the grant of its locks.
    pub(crate) begun: u64,
}

/// The counts of one or several runs.
#[derive(Debug, Clone)]
pub struct Tally {
    /// Counts of each task.
    pub tasks: Vec<TaskTally>,
    /// Counts of each service.
    pub services: TiVec<ServiceId, ServiceTally>,
    /// Requests that control tasks have taken from each client.
    pub clients: TiVec<ClientId, u64>,
    /// Counts of each codel.
    pub codels: TiVec<CodelId, CodelTally>,
    /// By machine, state and outcome (the last one: an exception), the times of the codels that ended with
    /// this outcome.
    pub transitions: TiVec<MachineId, Vec<Vec<Times>>>,
    pub(crate) busy: Vec<ActiveWork>,
}

impl Tally {
    /// Creates empty counts.
    pub fn new(system: &TimedSystem) -> Self {
        let machines = system.machines.iter().map(|machine| {
            let states = machine.states.iter();
            states.map(|state| vec![Times::default(); state.yields.len() + 1]).collect()
        });
        Tally {
            tasks: vec![TaskTally::default(); system.tasks.len()],
            services: ti_vec![ServiceTally::default(); system.services.len()],
            clients: ti_vec![0; system.clients.len()],
            codels: ti_vec![CodelTally::default(); system.codels.len()],
            transitions: machines.collect(),
            busy: Vec::new(),
        }
    }

    /// Counts an event.
    pub(crate) fn on_event(&mut self, system: &TimedSystem, stepper: &Stepper, seen: &Seen) {
        let now = stepper.now();
        match *seen {
            Seen::Asked { executor, .. } => self.busy(executor).asked = now,
            Seen::Begun { executor, work, .. } => {
                let busy = self.busy(executor);
                busy.begun = now;
                let waited = now - busy.asked;
                if let Some(codel) = work.codel() {
                    self.codels[codel].waits.add(ticks(waited));
                }
            }
            Seen::Ended { executor, work, outcome } => {
                let took = now - self.busy(executor).begun;
                if let Some(codel) = work.codel() {
                    self.codels[codel].runs.add(ticks(took));
                }
                if let Work::State { task, .. } = work {
                    self.tasks[task].executed += took;
                }
                self.ended(system, &work, outcome, ticks(took));
            }
            Seen::Requested { client, service } => {
                self.services[service].requests += 1;
                self.clients[client] += 1;
            }
            Seen::Refused { service } => self.services[service].refused += 1,
            Seen::Job { task, response } => {
                self.tasks[task].jobs.add(response);
                self.lasts(task, response);
            }
            Seen::Missed { task } => self.tasks[task].missed += 1,
            Seen::Overdue { task } => self.tasks[task].overdue += 1,
            Seen::Reached { .. }
            | Seen::Answered { .. }
            | Seen::Opened { .. }
            | Seen::Violated { .. } => {}
        }
    }

    /// Counts unfinished jobs with their time so far, when a run ends or begins to.
    pub(crate) fn count_unfinished(&mut self, stepper: &Stepper) {
        for task in 0..self.tasks.len() {
            if let Some(so_far) = stepper.job(task) {
                self.lasts(task, so_far);
            }
        }
    }

    fn lasts(&mut self, task: usize, time: Ticks) {
        let greatest = &mut self.tasks[task].greatest;
        *greatest = (*greatest).max(Some(time));
    }

    fn ended(&mut self, system: &TimedSystem, work: &Work, outcome: usize, took: Ticks) {
        match *work {
            Work::State { automaton, state, .. } => {
                let automaton = &system.automata[automaton];
                let outcomes = self.transitions[automaton.machine].get_mut(state);
                if let Some(times) = outcomes.and_then(|times| times.get_mut(outcome)) {
                    times.add(took);
                }
                let ends = match crate::decide::yield_of_outcome(system, work, outcome) {
                    Some(state) => state == dotgen_timing::system::Yield::End,
                    None => true,
                };
                if let (true, Some(service)) = (ends, automaton.service) {
                    self.services[service].ended += 1;
                }
            }
            Work::Control { .. } | Work::Delay { .. } => {}
        }
    }

    /// Sets the execution time of work that ends now, if that is less than the time since its locks were
    /// granted: the rest is the exchange of messages with its host. Times are in base units.
    pub(crate) fn set_executed(&mut self, executor: usize, now: u64, executed: u64) {
        let busy = self.busy(executor);
        busy.begun = busy.begun.max(now.saturating_sub(executed));
    }

    pub(crate) fn busy(&mut self, executor: usize) -> &mut ActiveWork {
        if self.busy.len() <= executor {
            let idle = ActiveWork { asked: 0, begun: 0 };
            self.busy.resize(executor + 1, idle);
        }
        &mut self.busy[executor]
    }
}

fn ticks(time: u64) -> Ticks {
    Ticks::try_from(time).unwrap_or(Ticks::MAX)
}
