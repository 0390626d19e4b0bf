//! Response-time analysis with blocking: a quick upper bound on response times.
//!
//! The bound is never below the exact value. It counts the most that other tasks can do in a window of time:
//!
//! * While a codel waits for its locks, a codel that excludes it is executing. The blocking is computed codel
//!   by codel, and for all codels of a job together. The lower of the two bounds counts.
//! * While a task waits for a core, all cores are held by other jobs, each for at most its own bound counted
//!   from the grant. Under FIFO these are jobs released earlier, at most one of each task. Under EDF they are
//!   jobs that were released earlier or have an earlier deadline. A task that holds a core for ever counts as
//!   one core less.
//!
//! In a window of length *w*, a periodic task can do the following work:
//!
//! * If its jobs end at most *R* after their release, and *R* is less than its period *P*: the rest of one
//!   job when the window begins, at most *R* after its release, and the jobs released since, *P* apart (the
//!   workload with carry-in of M. Bertogna, M. Cirinei, *Response-time analysis for globally scheduled
//!   symmetric multiprocessor platforms*, RTSS 2007).
//! * Otherwise: ⌊w/P⌋ + 1 released jobs, one carried in, and one on a pending tick.
//! * Its start-up, unless the start-up is certainly over.
//!
//! The bounds *R* are the least fixed point of these equations. No job can be the first to exceed its own
//! bound: until it does, all other jobs have kept theirs, and it waits only for work done before.
//!
//! If a job starts at its tick, the times since the last ticks of the other tasks are known, and so is the
//! work that these carry in.
//!
//! An aperiodic task that works for ever is counted by its stretches of work. The breaks between them have a
//! known length, unless another task is at work.

mod cores;
mod demand;
mod instances;
mod latest;
mod reaction;
mod rivals;
mod servers;
mod situations;
mod ways;
mod windows;

use std::cell::OnceCell;

use typed_index_collections::{TiSlice, TiVec, ti_vec};

use self::cores::Held;
use self::demand::{Demand, Jobs, Kind, SplitWork};
pub use self::reaction::reaction_bound;
use self::rivals::{Rivals, excluded};
use self::situations::{Situations, situations};
use self::ways::{Ways, resumed};
use self::windows::{Requests, whole_run, windows};
use crate::cancel::Cancel;
use crate::scn::semantics::{Cycle, Semantics};
use crate::system::{
    AutomatonId, CodelId, CodelSet, FOREVER, ServiceId, TaskId, Ticks, TimedSystem,
};

/// Returns a bound on the response time of every task, or `None` where this method finds none. Under the
/// semantics of the servers other things delay a job, and a separate method applies (see `servers`). If
/// single points of the semantics are changed, there are no bounds, nor if `cancel` is over before they are
/// found.
pub fn response_bounds(system: &TimedSystem, cancel: &Cancel) -> TiVec<TaskId, Option<Ticks>> {
    if system.platform.semantics.fixed().cycle == Cycle::Passes {
        // A client of `abort`, `kill` or `connect` causes `stop` codels, and stops the queue, at any time.
        let plain = !system.has_builtin(|_| true);
        let queued = system.platform.semantics == Semantics::SERVERS && plain;
        return if queued {
            servers::response_bounds(system, cancel)
        } else {
            ti_vec![None; system.tasks.len()]
        };
    }
    let mut analysis = Analysis::new(system);
    let mut round = 0;
    while let growing = analysis.improve()
        && growing.contains(&true)
    {
        round += 1;
        if round % MAX_GROWTH_ROUNDS == 0 {
            for (late, growing) in analysis.late.iter_mut().zip(growing) {
                *late |= growing;
            }
        }
        let interrupted = round % POLL == 0 && cancel.is_over();
        if interrupted || round == MAX_GROWTH_ROUNDS * (2 + system.tasks.len()) {
            return ti_vec![None; system.tasks.len()];
        }
    }
    analysis.bounds.iter().map(|bound| Some(bound.as_ref()?.response)).collect()
}

/// Returns true if a bound on the response time of a task proves that the task meets its deadlines. A kept
/// idle tick may be taken any time before the next tick, so that nothing follows for its task.
pub fn meets_deadlines(system: &TimedSystem, task: TaskId, bound: Option<Ticks>) -> bool {
    let task = &system.tasks[task];
    bound.is_some_and(|bound| !task.keep_idle_tick && Some(bound) < task.period)
}

/// Rounds after which a task with a bound that still grows counts as late: a quick bound must be quick.
const MAX_GROWTH_ROUNDS: usize = 100;

/// Number of rounds between two looks at the cancellation.
const POLL: usize = 16;

/// Number of times since a tick above which the phase of a task is not used.
const MAX_PHASES: u64 = 64;

/// The work of the system in a window of time.
#[derive(Default)]
struct Window {
    /// The requests that can play a part in it.
    requests: Requests,
    /// Sets of automata that can have turns in the same job, by task.
    parties: TiVec<TaskId, Vec<Vec<AutomatonId>>>,
    /// Work that can keep each codel waiting for its locks.
    of_codel: TiVec<CodelId, Rivals>,
    /// Work that can keep the codels of each party waiting.
    of_party: TiVec<TaskId, Vec<Rivals>>,
}

struct Analysis<'s> {
    system: &'s TimedSystem,
    /// Turns in jobs, by automaton.
    turns: TiVec<AutomatonId, Ways>,
    /// The same, without the beginning of an activity.
    later: TiVec<AutomatonId, Ways>,
    /// The work of the whole run.
    whole: Window,
    /// The windows of jobs of tasks with this period.
    windows: Vec<(Ticks, Vec<Window>)>,
    /// Latest end of the start-up of each task, in base units.
    started: TiVec<TaskId, Option<u64>>,
    /// Tasks that may have a tick waiting when a job ends.
    late: TiVec<TaskId, bool>,
    /// Lower limits of the bounds, raised until they are fixed.
    bounds: TiVec<TaskId, Option<Bound>>,
}

/// Bounds on the times of a job, from its release.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Bound {
    /// Until its end.
    response: Ticks,
    /// Until it gets its core.
    wait: Ticks,
}

impl<'s> Analysis<'s> {
    fn new(system: &'s TimedSystem) -> Self {
        let tasks = system.tasks.keys();
        let mut analysis = Analysis {
            system,
            turns: (system.automata.keys())
                .map(|automaton| turns_in_jobs(system, automaton, true))
                .collect(),
            later: (system.automata.keys())
                .map(|automaton| turns_in_jobs(system, automaton, false))
                .collect(),
            whole: Window::default(),
            windows: Vec::new(),
            started: TiVec::new(),
            late: tasks.clone().map(|task| may_be_late(system, task)).collect(),
            bounds: ti_vec![Some(Bound::default()); system.tasks.len()],
        };
        let excluded = excluded(system);
        let situations = situations(system);
        let parties = tasks.clone().map(|task| automata_of_parties(system, &situations, task));
        let parties: TiVec<TaskId, _> = parties.collect();
        analysis.whole = analysis.window(whole_run(system), &parties, &excluded);
        analysis.started = tasks.map(|task| analysis.started(task, &excluded)).collect();
        let mut periods: Vec<Ticks> = system.tasks.iter().filter_map(|task| task.period).collect();
        periods.sort_unstable();
        periods.dedup();
        analysis.windows = (periods.into_iter())
            .map(|period| {
                let all = windows(system, &situations, period).into_iter();
                let all = all.map(|window| analysis.window(window.requests, &parties, &excluded));
                (period, all.collect())
            })
            .collect();
        analysis
    }

    fn window(
        &self,
        requests: Requests,
        parties: &TiSlice<TaskId, Vec<Vec<AutomatonId>>>,
        excluded: &TiSlice<CodelId, CodelSet>,
    ) -> Window {
        let system = self.system;
        let takes_part = |automaton: &AutomatonId| {
            let service = system.automata[*automaton].service;
            service.is_none_or(|service| requests[service] != Some(0))
        };
        let parties = parties.iter().map(|parties| {
            let parties = parties.iter();
            let mut parties: Vec<Vec<AutomatonId>> =
                parties.map(|party| party.iter().copied().filter(takes_part).collect()).collect();
            parties.sort_unstable();
            parties.dedup();
            parties
        });
        let mut out = Window {
            requests: requests.clone(),
            parties: parties.collect(),
            of_codel: TiVec::new(),
            of_party: TiVec::new(),
        };
        let mut owner: TiVec<CodelId, _> = ti_vec![None; system.codels.len()];
        for automaton in &system.automata {
            for state in &system.machines[automaton.machine].states {
                owner[state.codel] = Some(automaton.task);
            }
        }
        out.of_codel = (excluded.iter().zip(owner))
            .map(|(codel_set, owner)| self.rivals(&out, codel_set, owner, &|_| true))
            .collect();
        let of_party = |task: TaskId, party: &[AutomatonId]| {
            let mut all = CodelSet::default();
            for &automaton in party {
                let machine = system.machine_of(automaton);
                for state in self.turns[automaton].states() {
                    let codel = machine.states[state].codel;
                    excluded[codel].iter().for_each(|other| all.insert(other));
                }
            }
            self.rivals(&out, &all, Some(task), &|_| true)
        };
        out.of_party = (out.parties.iter_enumerated())
            .map(|(task, parties)| parties.iter().map(|party| of_party(task, party)).collect())
            .collect();
        out
    }

    /// Returns the latest end of the start-up of a task. The start-up comes after that of earlier tasks of
    /// the component, and waits for other tasks in their start-up and in their first jobs.
    fn started(&self, task: TaskId, excluded: &TiSlice<CodelId, CodelSet>) -> Option<u64> {
        let system = self.system;
        let definition = &system.tasks[task];
        let mut work = 0u64;
        let mut all = CodelSet::default();
        let mut add =
            |codel: CodelId| excluded[codel].iter().for_each(|codel_set| all.insert(codel_set));
        let tasks = system.components[definition.component].tasks.iter();
        let before = tasks.take_while(|&&index| index != task);
        for a in before.filter_map(|&task| system.tasks[task].permanent) {
            let machine = system.machine_of(a);
            let codel = machine.states[machine.start].codel;
            work = work.checked_add(self.upper(codel)?)?;
            add(codel);
        }
        let mut more = false;
        if let Some(a) = definition.permanent {
            let machine = system.machine_of(a);
            let states: Vec<usize> = match definition.period {
                Some(_) => Ways::turns(machine, [machine.start]).states().collect(),
                // An aperiodic task is past its start-up after the first codel.
                None => vec![machine.start],
            };
            more = states.iter().any(|&state| state != machine.start);
            for &state in &states {
                add(machine.states[state].codel);
            }
            let own = match definition.period {
                Some(_) => self.start_up(a, &|codel| self.upper(codel)),
                None => self.upper(machine.states[machine.start].codel),
            };
            work = work.checked_add(own?)?;
        }
        // Until the first codel ends, later tasks of the component wait, and there are no requests.
        let waits = |other: TaskId| {
            let component = system.tasks[other].component;
            let own_cycles = other == task && definition.period.is_none();
            component == definition.component && (own_cycles || (other >= task && !more))
        };
        let rivals = self.rivals(&self.whole, &all, None, &|other| !waits(other));
        let mut demand = Demand {
            jobs: Vec::new(),
            stretches: rivals.stretches.into_iter().collect::<Option<_>>()?,
            once: work.checked_add(rivals.control?)?,
        };
        for job in rivals.jobs {
            if job.task != task {
                demand.once = demand.once.checked_add(job.start?)?;
            }
            demand.jobs.push(Jobs {
                period: system.tasks[job.task].period?,
                work: job.job?,
                once: 0,
                kind: Kind::First(self.first_tick(job.task)),
                released: Some(u64::MAX),
            });
        }
        demand.jobs.retain(|job| job.work > 0);
        demand.longest_busy(1)
    }

    /// Improves the bounds once. Returns, by task, whether a bound was found.
    fn improve(&mut self) -> TiVec<TaskId, bool> {
        let bounds = self.next_bounds();
        let late = |task: TaskId| {
            !meets_deadlines(self.system, task, bounds[task].map(|bound| bound.response))
        };
        let growing =
            |task: TaskId| (!self.late[task] && late(task)) || bounds[task] != self.bounds[task];
        let growing = bounds.keys().map(growing).collect();
        for (task, now) in self.late.iter_mut_enumerated() {
            *now |= late(task);
        }
        self.bounds = bounds;
        growing
    }

    /// Returns the greatest bound of all windows, by task. A job that may take longer than its period is
    /// bounded by the work of the whole run.
    fn next_bounds(&self) -> TiVec<TaskId, Option<Bound>> {
        let system = self.system;
        let in_window = |window: &Window| -> TiVec<TaskId, Option<Bound>> {
            let held: TiVec<TaskId, Held> =
                system.tasks.keys().map(|task| self.held(window, task)).collect();
            let bound = |task: TaskId| {
                let wait = u32::try_from(self.core_wait(window, task, &held)?).ok()?;
                let response = u32::try_from(held[task].longest?).ok()?.checked_add(wait)?;
                (response < FOREVER).then_some(Bound { response, wait })
            };
            system.tasks.keys().map(bound).collect()
        };
        let mut out = in_window(&self.whole);
        for (period, windows) in &self.windows {
            let all: Vec<_> = windows.iter().map(in_window).collect();
            for task in system.tasks.keys().filter(|&it| system.tasks[it].period == Some(*period)) {
                let greatest = all.iter().try_fold(Bound::default(), |most, bounds| {
                    let bound = bounds[task].filter(|bound| bound.response < *period)?;
                    Some(Bound {
                        response: most.response.max(bound.response),
                        wait: most.wait.max(bound.wait),
                    })
                });
                out[task] = greatest.or(out[task]);
            }
        }
        out
    }

    /// Returns the greatest duration of all turns of one job.
    fn held(&self, window: &Window, task: TaskId) -> Held {
        let alone = self.alone(task);
        let waits: TiVec<CodelId, _> = ti_vec![OnceCell::new(); self.system.codels.len()];
        let with_wait = |codel: CodelId| {
            let rivals = &window.of_codel[codel];
            let wait: &Option<u64> =
                waits[codel].get_or_init(|| self.longest_busy(task, rivals, 0, alone, false));
            self.upper(codel)?.checked_add((*wait)?)
        };
        let parties = &window.parties[task];
        let of_party = |(party, rivals): (&Vec<AutomatonId>, &Rivals)| {
            let one_by_one = self.turns(party, &with_wait);
            let together = (self.turns(party, &|codel| self.upper(codel)))
                .and_then(|work| self.longest_busy(task, rivals, work, alone, true));
            one_by_one.into_iter().chain(together).min()
        };
        let all = parties.iter().zip(&window.of_party[task]).map(of_party);
        Held {
            longest: all.into_iter().try_fold(0, |most, time| Some(time?.max(most))),
            split: self.split_work(window, parties, &with_wait),
        }
    }

    /// Returns the greatest duration of turns of these automata in one job, together, with the given cost of
    /// each codel.
    fn turns(&self, party: &[AutomatonId], cost: &dyn Fn(CodelId) -> Option<u64>) -> Option<u64> {
        party.iter().try_fold(0u64, |sum, &automaton| {
            let machine = self.system.machine_of(automaton);
            let cost = |state: usize| cost(machine.states[state].codel);
            sum.checked_add(self.turns[automaton].costliest(&cost)?)
        })
    }

    /// Returns the greatest duration of the first turn of a permanent activity, with the given cost of each
    /// codel.
    fn start_up(
        &self,
        automaton: AutomatonId,
        cost: &dyn Fn(CodelId) -> Option<u64>,
    ) -> Option<u64> {
        let machine = self.system.machine_of(automaton);
        let cost = |state: usize| cost(machine.states[state].codel);
        Ways::turns(machine, [machine.start]).costliest(&cost)
    }

    /// Returns the longest time for which `work` and rivals can keep a job of a task busy. `alone`: no job of
    /// another periodic task can be under way. `from_grant`: the window begins when the job gets its core.
    fn longest_busy(
        &self,
        task: TaskId,
        rivals: &Rivals,
        work: u64,
        alone: bool,
        from_grant: bool,
    ) -> Option<u64> {
        let demands = [false, true].map(|split| {
            let mut demand = self.demand(task, rivals, alone, from_grant, split)?;
            demand.once = demand.once.checked_add(work)?;
            demand.longest_busy(1)
        });
        demands.into_iter().flatten().min()
    }

    /// Returns the demand of rivals. `split`: jobs count with their [split work](SplitWork).
    fn demand(
        &self,
        task: TaskId,
        rivals: &Rivals,
        alone: bool,
        from_grant: bool,
        split: bool,
    ) -> Option<Demand> {
        let mut demand = Demand {
            jobs: Vec::new(),
            stretches: rivals.stretches.iter().copied().collect::<Option<_>>()?,
            once: rivals.control?,
        };
        for job in &rivals.jobs {
            let started = self.started[job.task];
            let starting = started.is_none_or(|number| number > self.first_tick(task));
            let (mut work, mut over) = (job.job?, 0);
            if starting {
                match started.filter(|&over| over <= self.first_tick(job.task)) {
                    // Its start-up counts like a job before the first one.
                    Some(by) if !alone && work > 0 => (work, over) = (work.max(job.start?), by),
                    _ => demand.once = demand.once.checked_add(job.start?)?,
                }
            }
            if !alone && work > 0 {
                let jobs = self.jobs(job.task, work, over)?;
                let least = if over > 0 { job.start? } else { 0 };
                let split = job.split.filter(|_| split);
                let jobs =
                    jobs.with(split.map(|work| SplitWork { each: work.each.max(least), ..work }));
                let wait = self.bounds[task].filter(|_| from_grant).map(|bound| bound.wait);
                let in_phase = |wait| self.in_phase(task, job.task, jobs.clone(), u64::from(wait));
                demand.jobs.push(wait.map_or_else(|| jobs.clone(), in_phase));
            }
        }
        Some(demand)
    }

    /// Returns the jobs of a task with this much work in each, if the task is periodic. Each job takes at
    /// most its bound, or `over`.
    fn jobs(&self, task: TaskId, work: u64, over: u64) -> Option<Jobs> {
        let period = self.system.tasks[task].period?;
        let bound = self.bounds[task].map(|bound| over.max(work).max(u64::from(bound.response)));
        let kind = match bound {
            Some(bound) if !self.late[task] && bound < u64::from(period) => Kind::Punctual(bound),
            // A codel of a separate thread may still run during the next job.
            _ if self.system.runs_apart(task) => Kind::Late(3),
            _ => Kind::Late(2),
        };
        Some(Jobs { period, work, once: 0, kind, released: Some(u64::MAX) })
    }

    /// Returns the jobs of another task in a window that begins at most `width` after the release of a job.
    /// If both tasks are released at their ticks, the times since the last tick of the other one are known,
    /// as far as the starts of their timers are. A start-up has no tick, so that it must be over.
    fn in_phase(&self, task: TaskId, other: TaskId, jobs: Jobs, width: u64) -> Jobs {
        let (Kind::Punctual(response), Some(period)) = (jobs.kind, self.system.tasks[task].period)
        else {
            return jobs;
        };
        let starting = self.started[other].is_none_or(|over| over > self.first_tick(task));
        let starts = self.timer_starts(task).zip(self.timer_starts(other));
        let Some((own, others_start)) =
            starts.filter(|_| !self.late[task] && other != task && !starting)
        else {
            return jobs;
        };
        let (period, others) = (u64::from(period), u64::from(jobs.period));
        // Times of ticks differ by the difference of the first ones, and multiples of this.
        let every = greatest_common_divisor(period, others);
        if others / every > MAX_PHASES {
            return jobs;
        }
        let first = self.first_tick(task) + others - self.first_tick(other) % others;
        // The other timer may start as much later, and the own one as well.
        let first = (first + every - others_start % every) % every;
        let width = width + own + others_start;
        Jobs { kind: Kind::InPhase { response, first, every, width }, ..jobs }
    }

    /// Returns the latest time at which the timer of a task starts: after the first codels of the tasks
    /// before it in its component.
    fn timer_starts(&self, task: TaskId) -> Option<u64> {
        let system = self.system;
        let tasks = system.components[system.tasks[task].component].tasks.iter();
        let before = tasks.take_while(|&&other| other != task);
        before.filter_map(|&other| Some((other, system.tasks[other].permanent?))).try_fold(
            0,
            |latest: u64, (other, automaton)| {
                let machine = system.machine_of(automaton);
                let first = machine.states[machine.start].codel;
                if system.codels[first].conflicts.is_empty() {
                    return latest.checked_add(self.upper(first)?);
                }
                // The whole start-up, with what its codels wait for.
                Some(latest.max(self.started[other]?))
            },
        )
    }

    /// Returns the time before which no job of a task begins.
    fn first_tick(&self, task: TaskId) -> u64 {
        let task = &self.system.tasks[task];
        u64::from(task.period.unwrap_or(0)) + u64::from(task.delay)
    }
}

/// Returns sets of automata. All automata of a task that have a turn in one job belong to one of these sets.
fn automata_of_parties(
    system: &TimedSystem,
    situations: &[Situations],
    task: TaskId,
) -> Vec<Vec<AutomatonId>> {
    let definition = &system.tasks[task];
    let permanent: Vec<AutomatonId> = definition.permanent.into_iter().collect();
    let Some(parties) = instances::of_one_job(system, situations, task) else {
        return vec![[&permanent[..], &definition.slots[..]].concat()];
    };
    let automata = |party: &Vec<ServiceId>| {
        let mut out = permanent.clone();
        for &service in party {
            let slots = system.services[service].slots.iter();
            let mut own = slots.filter(|slot| system.automata[**slot].task == task);
            let free = own.find(|slot| !out.contains(slot)).copied();
            out.extend(free);
        }
        out.sort_unstable();
        out
    };
    parties.iter().map(automata).collect()
}

fn greatest_common_divisor(one: u64, other: u64) -> u64 {
    if other == 0 { one } else { greatest_common_divisor(other, one % other) }
}

/// Returns the turns of an automaton in jobs; `begins`: also those that begin an activity.
fn turns_in_jobs(system: &TimedSystem, automaton: AutomatonId, begins: bool) -> Ways {
    let entry = &system.automata[automaton];
    let machine = system.machine_of(automaton);
    if system.tasks[entry.task].period.is_none() || system.runs_apart(entry.task) {
        return Ways::turns(machine, 0..machine.states.len());
    }
    let anew = entry.service.filter(|_| begins).map(|_| machine.start);
    let stop = entry.service.and(machine.stop);
    let begins = anew.into_iter().chain(stop);
    Ways::turns(machine, begins.chain(resumed(machine)))
}

/// Returns true if more than one job of a task may be under way, whatever bound is known.
fn may_be_late(system: &TimedSystem, task: TaskId) -> bool {
    let definition = &system.tasks[task];
    definition.keep_idle_tick || definition.period.is_none() || system.runs_apart(task)
}
