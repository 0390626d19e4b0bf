//! A quick bound on response times: response-time analysis with blocking.
//!
//! Never below the exact value, and there at once. It counts what others can do at most in a window of time:
//!
//! * while a codel waits for its locks, some codel that excludes it is executing; this is looked at codel by
//!   codel, and for all codels of a job together, and the lower bound counts;
//! * while a task waits for a core, all cores are held by other jobs, each for at most its own bound counted
//!   from the grant; under FIFO only by jobs released before, at most one of each task, and under EDF only by
//!   jobs that were there before or have an earlier deadline. Who holds a core for ever is counted as one
//!   core less.
//!
//! What a periodic task can do in a window of length *w*:
//!
//! * if it ends its jobs at most *R* after their release, and *R* is less than its period *P*: what it can
//!   still do of one job when the window begins, at most *R* after its release, and of those released since,
//!   *P* apart (the workload with carry-in of M. Bertogna, M. Cirinei, *Response-time analysis for globally
//!   scheduled symmetric multiprocessor platforms*, RTSS 2007);
//! * otherwise ⌊w/P⌋ + 1 jobs that are released, one carried in, and one on a pending tick;
//! * its start-up, if that is not over for sure.
//!
//! The bounds *R* are the least that follow from each other. No job can be the first to exceed its own: until
//! it does, all others have kept theirs, and what they did before is all it waits for.
//!
//! An aperiodic task that works for ever is counted by its stretches of work. Breaks of a known length in
//! between only go unnoticed while somebody else is at work.

mod cores;
mod demand;
mod instances;
mod preempted;
mod queue;
mod reaction;
mod rivals;
mod ways;

use std::cell::OnceCell;

use self::demand::{Demand, Jobs, Kind};
pub use self::reaction::reaction_bound;
use self::rivals::{Rivals, excluded};
use self::ways::{Ways, resumed};
use crate::scn::semantics::Semantics;
use crate::system::{CodelSet, FOREVER, Ticks, TimedSystem};

/// A bound on the response time of every task; `None` where this method finds none. Under the semantics of
/// the servers it has a method of its own (see `queue`), as other things delay a job there; with single
/// points of the semantics changed it finds none.
pub fn response_bounds(system: &TimedSystem) -> Vec<Option<Ticks>> {
    if !system.platform.semantics.is_published() {
        // Who asks for `abort`, `kill` or `connect` executes `stop` codels, and stops the queue, at any time.
        let plain = !system.has_builtin(|_| true);
        let queued = system.platform.semantics == Semantics::SERVERS && plain;
        return match queued {
            true if system.preempts() => preempted::response_bounds(system),
            true => queue::response_bounds(system),
            false => vec![None; system.tasks.len()],
        };
    }
    let mut analysis = Analysis::new(system);
    let mut round = 0;
    while let growing = analysis.improve()
        && growing.contains(&true)
    {
        round += 1;
        if round % PATIENCE == 0 {
            for (late, growing) in analysis.late.iter_mut().zip(growing) {
                *late |= growing;
            }
        }
        if round == PATIENCE * (2 + system.tasks.len()) {
            return vec![None; system.tasks.len()];
        }
    }
    analysis.bounds
}

/// Whether a bound on the response time of a task proves that it meets its deadlines. Where a tick is kept it
/// may be taken any time before the next one, so that nothing follows.
pub fn meets_deadlines(system: &TimedSystem, task: usize, bound: Option<Ticks>) -> bool {
    let it = &system.tasks[task];
    bound.is_some_and(|bound| !it.keep_idle_tick && Some(bound) < it.period)
}

/// Tasks with bounds that still grow after so many rounds are taken as late: a quick bound must be quick.
const PATIENCE: usize = 100;

struct Analysis<'s> {
    system: &'s TimedSystem,
    /// Per automaton, its turns in jobs.
    turns: Vec<Ways>,
    /// Per task, the sets of automata that can have turns in the same job.
    parties: Vec<Vec<Vec<usize>>>,
    /// What can keep each codel waiting for its locks.
    of_codel: Vec<Rivals>,
    /// What can keep the codels of each party waiting.
    of_party: Vec<Vec<Rivals>>,
    /// When the start-up of each task is over at the latest.
    started: Vec<Option<u64>>,
    /// Tasks that may have a tick waiting when a job ends.
    late: Vec<bool>,
    /// Bounds on response times, from below.
    bounds: Vec<Option<Ticks>>,
}

impl<'s> Analysis<'s> {
    fn new(system: &'s TimedSystem) -> Self {
        let tasks = 0..system.tasks.len();
        let mut analysis = Analysis {
            system,
            turns: (0..system.automata.len())
                .map(|it| turns_in_jobs(system, it))
                .collect(),
            parties: instances::of_one_job(system),
            of_codel: Vec::new(),
            of_party: Vec::new(),
            started: Vec::new(),
            late: tasks.clone().map(|it| may_be_late(system, it)).collect(),
            bounds: vec![Some(0); system.tasks.len()],
        };
        let excluded = excluded(system);
        let mut owner = vec![None; system.codels.len()];
        for automaton in &system.automata {
            for state in &system.machines[automaton.machine].states {
                owner[state.codel] = Some(automaton.task);
            }
        }
        analysis.of_codel = (excluded.iter().zip(owner))
            .map(|(it, owner)| analysis.rivals(it, owner, &|_| true))
            .collect();
        let of_party = |task: usize, party: &[usize]| {
            let mut all = CodelSet::default();
            for &automaton in party {
                let machine = system.machine_of(automaton);
                for state in analysis.turns[automaton].states() {
                    let codel = machine.states[state].codel;
                    excluded[codel].iter().for_each(|it| all.insert(it));
                }
            }
            analysis.rivals(&all, Some(task), &|_| true)
        };
        analysis.of_party = (analysis.parties.iter().enumerate())
            .map(|(task, parties)| parties.iter().map(|it| of_party(task, it)).collect())
            .collect();
        analysis.started = tasks.map(|it| analysis.started(it, &excluded)).collect();
        analysis
    }

    /// When the start-up of a task is over at the latest: it comes after that of earlier tasks of the
    /// component, and waits for others in their start-up and in their first jobs.
    fn started(&self, task: usize, excluded: &[CodelSet]) -> Option<u64> {
        let system = self.system;
        let it = &system.tasks[task];
        let mut work = 0u64;
        let mut all = CodelSet::default();
        let mut add = |codel: usize| excluded[codel].iter().for_each(|it| all.insert(it));
        let tasks = system.components[it.component].tasks.iter();
        let before = tasks.take_while(|&&it| it != task);
        for a in before.filter_map(|&it| system.tasks[it].permanent) {
            let machine = system.machine_of(a);
            let codel = machine.states[machine.start].codel;
            work = work.checked_add(self.upper(codel)?)?;
            add(codel);
        }
        let mut more = false;
        if let Some(a) = it.permanent {
            let machine = system.machine_of(a);
            let states: Vec<usize> = match it.period {
                Some(_) => Ways::turns(machine, [machine.start]).states().collect(),
                // An aperiodic task is past its start-up after the first codel.
                None => vec![machine.start],
            };
            more = states.iter().any(|&it| it != machine.start);
            states.iter().for_each(|&it| add(machine.states[it].codel));
            let own = match it.period {
                Some(_) => self.start_up(a, &|it| self.upper(it)),
                None => self.upper(machine.states[machine.start].codel),
            };
            work = work.checked_add(own?)?;
        }
        // Until the first codel ends, later tasks of the component wait, and there are no requests.
        let waits = |other: usize| {
            let component = system.tasks[other].component;
            let own_cycles = other == task && it.period.is_none();
            component == it.component && (own_cycles || (other >= task && !more))
        };
        let rivals = self.rivals(&all, None, &|other| !waits(other));
        let mut demand = Demand {
            jobs: Vec::new(),
            stretches: rivals.stretches.into_iter().collect::<Option<_>>()?,
            once: work.checked_add(rivals.control?)?,
        };
        for it in rivals.jobs {
            if it.task != task {
                demand.once = demand.once.checked_add(it.start?)?;
            }
            demand.jobs.push(Jobs {
                period: system.tasks[it.task].period?,
                work: it.job?,
                kind: Kind::First(self.first_tick(it.task)),
                released: Some(u64::MAX),
            });
        }
        demand.jobs.retain(|it| it.work > 0);
        demand.longest_busy(1)
    }

    /// Draws the next conclusions from the bounds. Of which tasks there are any?
    fn improve(&mut self) -> Vec<bool> {
        let bounds = self.next_bounds();
        let growing = |task: usize| {
            let gets_late = !self.late[task] && !meets_deadlines(self.system, task, bounds[task]);
            gets_late || bounds[task] != self.bounds[task]
        };
        let growing = (0..bounds.len()).map(growing).collect();
        for (task, late) in self.late.iter_mut().enumerate() {
            *late |= !meets_deadlines(self.system, task, bounds[task]);
        }
        self.bounds = bounds;
        growing
    }

    fn next_bounds(&self) -> Vec<Option<Ticks>> {
        let tasks = 0..self.system.tasks.len();
        let held: Vec<Option<u64>> = tasks.clone().map(|it| self.held(it)).collect();
        let response = |task: usize| {
            let response = held[task]?.checked_add(self.core_wait(task, &held)?)?;
            u32::try_from(response).ok().filter(|&it| it < FOREVER)
        };
        tasks.map(response).collect()
    }

    /// The longest that all turns of one job can be.
    fn held(&self, task: usize) -> Option<u64> {
        let alone = self.alone(task);
        let waits = vec![OnceCell::new(); self.system.codels.len()];
        let with_wait = |codel: usize| {
            let rivals = &self.of_codel[codel];
            let wait: &Option<u64> =
                waits[codel].get_or_init(|| self.longest_busy(task, rivals, 0, alone));
            self.upper(codel)?.checked_add((*wait)?)
        };
        let mut longest = 0;
        for (party, rivals) in self.parties[task].iter().zip(&self.of_party[task]) {
            let one_by_one = self.turns(party, &with_wait);
            let together = (self.turns(party, &|it| self.upper(it)))
                .and_then(|work| self.longest_busy(task, rivals, work, alone));
            longest = longest.max(one_by_one.into_iter().chain(together).min()?);
        }
        Some(longest)
    }

    /// The longest that turns of these automata in one job can be together, with the cost of each codel.
    fn turns(&self, party: &[usize], cost: &dyn Fn(usize) -> Option<u64>) -> Option<u64> {
        party.iter().try_fold(0u64, |sum, &automaton| {
            let machine = self.system.machine_of(automaton);
            let cost = |state: usize| cost(machine.states[state].codel);
            sum.checked_add(self.turns[automaton].costliest(&cost)?)
        })
    }

    /// The same of the first turn of a permanent activity.
    fn start_up(&self, automaton: usize, cost: &dyn Fn(usize) -> Option<u64>) -> Option<u64> {
        let machine = self.system.machine_of(automaton);
        let cost = |state: usize| cost(machine.states[state].codel);
        Ways::turns(machine, [machine.start]).costliest(&cost)
    }

    /// How long a job of a task that has so much work can be kept busy by it and by rivals. `alone`: no job
    /// of another periodic task can be under way.
    fn longest_busy(&self, task: usize, rivals: &Rivals, work: u64, alone: bool) -> Option<u64> {
        let mut demand = Demand {
            jobs: Vec::new(),
            stretches: rivals.stretches.iter().copied().collect::<Option<_>>()?,
            once: rivals.control?.checked_add(work)?,
        };
        for it in &rivals.jobs {
            let started = self.started[it.task];
            let starting = started.is_none_or(|it| it > self.first_tick(task));
            let (mut work, mut over) = (it.job?, 0);
            if starting {
                match started.filter(|&over| over <= self.first_tick(it.task)) {
                    // Like a job before the first one.
                    Some(by) if !alone && work > 0 => (work, over) = (work.max(it.start?), by),
                    _ => demand.once = demand.once.checked_add(it.start?)?,
                }
            }
            if !alone && work > 0 {
                demand.jobs.push(self.jobs(it.task, work, over)?);
            }
        }
        demand.longest_busy(1)
    }

    /// So much work in each job of a task, if it is periodic. Each takes at most as long as the bound says,
    /// or `over`.
    fn jobs(&self, task: usize, work: u64, over: u64) -> Option<Jobs> {
        let period = self.system.tasks[task].period?;
        let bound = self.bounds[task].map(|it| over.max(work).max(u64::from(it)));
        let kind = match bound {
            Some(it) if !self.late[task] && it < u64::from(period) => Kind::Punctual(it),
            // With a codel that goes on beside the next job.
            _ if self.system.runs_apart(task) => Kind::Late(3),
            _ => Kind::Late(2),
        };
        Some(Jobs {
            period,
            work,
            kind,
            released: Some(u64::MAX),
        })
    }

    /// No job of a task begins earlier.
    fn first_tick(&self, task: usize) -> u64 {
        let it = &self.system.tasks[task];
        u64::from(it.period.unwrap_or(0)) + u64::from(it.delay)
    }
}

fn turns_in_jobs(system: &TimedSystem, automaton: usize) -> Ways {
    let it = &system.automata[automaton];
    let machine = system.machine_of(automaton);
    if system.tasks[it.task].period.is_none() || system.runs_apart(it.task) {
        return Ways::turns(machine, 0..machine.states.len());
    }
    let anew = it.service.map(|_| machine.start);
    let stop = it.service.and(machine.stop);
    let begins = anew.into_iter().chain(stop);
    Ways::turns(machine, begins.chain(resumed(machine)))
}

/// Whether more than one job of a task may be under way whatever bound is known.
fn may_be_late(system: &TimedSystem, task: usize) -> bool {
    let it = &system.tasks[task];
    it.keep_idle_tick || it.period.is_none() || system.runs_apart(task)
}
