//! Bounds of single jobs, for tasks that have no bound otherwise.
//!
//! The ticks of all tasks are known, and so are the times of clients, as far as all that they await has a
//! bound ([`latest`]). So for each job, the other ticks near it and the requests that can play a part are
//! known. After the last time that counts, everything repeats with the hyperperiod. The bounds are the least
//! fixed point of the equations of all jobs: no job can be the first to exceed its own bound.

use rustc_hash::FxHashMap;
use typed_index_collections::{TiVec, ti_vec};

use super::control::Control;
use super::{Bound, Cycle, Facts, Known, Knowns, Turns, Window, known};
use crate::analytic::greatest_common_divisor;
use crate::analytic::latest::{NEVER, latest};
use crate::analytic::situations::Situations;
use crate::analytic::windows::{ClientWindow, Requests, requests_at, timed_windows};
use crate::cancel::Cancel;
use crate::system::{TaskId, Ticks, TimedSystem};

/// Number of jobs above which none has a bound of its own.
const MAX_JOBS: usize = 10_000;

/// Length of a hyperperiod, in base units, from which on no job has a bound of its own.
const LONGEST: u64 = 1 << 40;

/// Number of rounds with better times of clients.
const MAX_IMPROVEMENTS: usize = 3;

/// Number of rounds until the bounds of jobs are fixed.
const ROUNDS: usize = 200;

/// Number of evaluations of jobs, in all, after which no better bounds are looked for: a quick bound must be
/// quick. An evaluation takes up to 0.1 ms.
const MAX_EVALUATIONS: usize = 20_000;

/// A job that begins between two times: at its tick, if they are the same.
#[derive(Clone, Copy)]
pub(super) struct Single<'j> {
    pub(super) jobs: &'j Jobs,
    pub(super) from: u64,
    pub(super) to: u64,
}

/// The jobs of some tasks.
pub(super) struct Jobs {
    hyperperiod: u64,
    /// The times at which requests begin or end to play a part, in ascending order. From each one to the next
    /// one, the same requests do.
    times: Vec<u64>,
    /// The jobs of each periodic task: one hyperperiod of each interval, in order of time.
    of: TiVec<TaskId, Vec<Job>>,
}

#[derive(Clone)]
struct Job {
    tick: u64,
    /// Numbers of the windows that can begin at its tick.
    windows: Vec<usize>,
    /// Greatest time until its end, so far.
    bound: u64,
}

impl Jobs {
    /// Returns the greatest time from a tick of a task to the end of its cycle. `seen_from`: the tick of the
    /// job that asks, which may stand for later ones.
    pub(super) fn after_tick(
        &self,
        task: TaskId,
        tick: u64,
        seen_from: u64,
        known: &Knowns,
    ) -> Option<u64> {
        let Known { ends, after_tick, .. } = known[task];
        let usual = after_tick?;
        if ends.is_none_or(|ends| tick <= ends) {
            // A kept tick.
            return Some(usual);
        }
        let of_task = &self.of[task];
        let bound = |tick: u64| {
            let tick = self.representative(tick);
            let at = of_task.binary_search_by_key(&tick, |job| job.tick).ok()?;
            Some(of_task[at].bound)
        };
        let Some(own) = bound(tick) else {
            return Some(usual);
        };
        let later = tick + self.hyperperiod;
        let repeats = self.interval(later) == self.interval(seen_from);
        let later = repeats.then(|| bound(later).unwrap_or(usual));
        Some(own.max(later.unwrap_or(0)))
    }

    /// Returns the number of the interval of a time.
    fn interval(&self, time: u64) -> usize {
        self.times.partition_point(|&begins| begins <= time).saturating_sub(1)
    }

    /// Returns the tick that stands for a tick.
    fn representative(&self, tick: u64) -> u64 {
        let begins = self.times[self.interval(tick)];
        begins + (tick - begins) % self.hyperperiod
    }
}

/// The windows of jobs, each with its requests.
struct Windows<'s> {
    turns: &'s Turns<'s>,
    numbers: FxHashMap<(Requests, Ticks), usize>,
    all: Vec<Window<'s>>,
}

impl Windows<'_> {
    fn number(&mut self, requests: Requests, length: Ticks) -> usize {
        let turns = self.turns;
        *self.numbers.entry((requests, length)).or_insert_with_key(|(requests, length)| {
            let client = ClientWindow::any_time(requests.clone());
            self.all.push(Window::new(turns, client, Some(*length)));
            self.all.len() - 1
        })
    }
}

/// Improves bounds by those of single jobs.
pub(super) fn improve(
    turns: &Turns,
    situations: &[Situations],
    windows: &TiVec<TaskId, Vec<Window>>,
    mut bounds: TiVec<TaskId, Bound>,
    cancel: &Cancel,
) -> TiVec<TaskId, Bound> {
    let system = turns.system;
    let mut evaluations = 0;
    for _ in 0..MAX_IMPROVEMENTS {
        let facts = known(system, &bounds);
        let open = |&task: &TaskId| {
            system.tasks[task].period.is_some() && facts[task].after_tick.is_none()
        };
        let has_period = |&task: &TaskId| system.tasks[task].period.is_some();
        let all: Vec<TaskId> = system.tasks.keys().filter(has_period).collect();
        let open: Vec<TaskId> = system.tasks.keys().filter(open).collect();
        if open.is_empty() {
            break;
        }
        let mut client_windows = Windows { turns, numbers: FxHashMap::default(), all: Vec::new() };
        let Some(jobs) = jobs(situations, &facts, &all, &bounds, &mut client_windows) else {
            break;
        };
        let single = SingleJobs {
            system,
            at_any_time: windows,
            windows: client_windows.all,
            open,
            all,
            jobs,
            evaluations: &mut evaluations,
            cancel,
        };
        match single.bounds(&bounds).filter(|improved| *improved != bounds) {
            Some(improved) => bounds = improved,
            None => break,
        }
    }
    bounds
}

/// The jobs of tasks without a bound.
struct SingleJobs<'w, 's, 'e> {
    system: &'s TimedSystem,
    /// The windows of each task at any time.
    at_any_time: &'w TiVec<TaskId, Vec<Window<'s>>>,
    /// The windows of jobs.
    windows: Vec<Window<'s>>,
    /// Tasks without a bound.
    open: Vec<TaskId>,
    /// All tasks with a period.
    all: Vec<TaskId>,
    jobs: Jobs,
    /// Number of evaluations of jobs, in each of their windows, so far.
    evaluations: &'e mut usize,
    cancel: &'e Cancel,
}

impl SingleJobs<'_, '_, '_> {
    /// Returns bounds with those of the jobs, given those at any time; `None` if there are none.
    fn bounds(mut self, bounds: &TiVec<TaskId, Bound>) -> Option<TiVec<TaskId, Bound>> {
        let mut out = bounds.clone();
        for &task in &self.open {
            out[task] = Bound::LEAST;
        }
        for _ in 0..ROUNDS {
            let before = out.clone();
            let mut changed = false;
            for task in self.all.clone() {
                let facts = known(self.system, &out);
                if !self.open.contains(&task) {
                    changed |= self.jobs_of(task, bounds[task].other, &facts, true).1;
                    continue;
                }
                let Bound { pass, first, start_up, other, second } = out[task];
                let Known { begins, latest, ends, next, .. } = facts[task];
                let Known { leader_begins, leader_latest, .. } = facts[task];
                let leader = leader_latest.map(|latest| (leader_begins, latest));
                let first_from_to = latest.map(|latest| (begins, latest));
                out[task].pass = self.at(task, Cycle::FirstPass, pass, first_from_to, &facts);
                out[task].first = self.at(task, Cycle::First, first, first_from_to, &facts);
                out[task].start_up = self.at(task, Cycle::StartUp, start_up, leader, &facts);
                out[task].second = match ends {
                    Some(ends) if ends < next => second,
                    _ => {
                        self.at(task, Cycle::Other, second, ends.map(|ends| (begins, ends)), &facts)
                    }
                };
                let (greatest, more) = self.jobs_of(task, other, &facts, false);
                out[task].other = greatest;
                changed |= more;
            }
            if self.is_over() {
                return None;
            }
            if !changed && out == before {
                for &task in &self.open {
                    // Bounds at any time hold as well.
                    let (old, new) = (bounds[task], &mut out[task]);
                    new.pass = new.pass.or(old.pass);
                    new.first = new.first.or(old.first);
                    new.start_up = new.start_up.or(old.start_up);
                }
                return Some(out);
            }
        }
        None
    }

    /// Returns true if the limit on evaluations is exceeded, or the verification is cancelled. The values
    /// found until then are not bounds.
    fn is_over(&self) -> bool {
        *self.evaluations > MAX_EVALUATIONS || self.cancel.is_over()
    }

    /// Returns the greatest time of a cycle that begins between two times.
    fn at(
        &self,
        task: TaskId,
        cycle: Cycle,
        least: Option<u64>,
        between: Option<(u64, u64)>,
        facts: &Knowns,
    ) -> Option<u64> {
        let (from, to) = between?;
        let single = Single { jobs: &self.jobs, from, to: to.max(from + 1) };
        let begins = |window: &&Window| window.client.begins <= to;
        let windows = self.at_any_time[task].iter().filter(begins);
        let each = windows.map(|window| {
            let bound = window.response(task, cycle, least?, facts, Some(single))?;
            Some(bound).filter(|bound| {
                self.system.tasks[task].period.is_some_and(|period| *bound < u64::from(period))
            })
        });
        each.collect::<Option<Vec<u64>>>()?.into_iter().max()
    }

    /// Returns the greatest time of the jobs of a task, and if that of any of them has changed. `is_bound`:
    /// none takes longer than that time.
    fn jobs_of(
        &mut self,
        task: TaskId,
        time: Option<u64>,
        facts: &Knowns,
        is_bound: bool,
    ) -> (Option<u64>, bool) {
        let Some(most) = time else {
            return (None, false);
        };
        let period = self.system.tasks[task].period.map_or(0, u64::from);
        let mut facts_of_job = facts.clone();
        let (mut greatest, mut changed) = (0, false);
        for at in 0..self.jobs.of[task].len() {
            if self.is_over() {
                return (None, true);
            }
            let Job { tick, ref windows, bound: least } = self.jobs.of[task][at];
            let until = self.jobs.times.get(self.jobs.interval(tick) + 1);
            if until.zip(facts[task].ends).is_some_and(|(&until, ends)| until <= ends) {
                // The tick comes in the first cycle.
                continue;
            }
            *self.evaluations += windows.len();
            facts_of_job[task].next = tick;
            let single = Single { jobs: &self.jobs, from: tick, to: tick };
            let times = windows.iter().map(|&window| {
                let window = &self.windows[window];
                window.response(task, Cycle::Other, least, &facts_of_job, Some(single))
            });
            let mut bound =
                times.collect::<Option<Vec<u64>>>().and_then(|all| all.into_iter().max());
            if is_bound {
                bound = Some(bound.map_or(most, |bound| bound.min(most)));
            }
            let Some(bound) = bound.filter(|bound| *bound < period) else {
                self.jobs.of[task].clear();
                return (None, true);
            };
            changed |= bound != least;
            self.jobs.of[task][at].bound = bound;
            greatest = greatest.max(bound);
        }
        (Some(greatest), changed)
    }
}

/// Returns the jobs of some tasks, and the windows of each; `None` if there are too many.
fn jobs(
    situations: &[Situations],
    facts: &Knowns,
    tasks: &[TaskId],
    bounds: &TiVec<TaskId, Bound>,
    windows: &mut Windows,
) -> Option<Jobs> {
    let turns = windows.turns;
    let system = turns.system;
    let control = Control::new(turns, &Facts { bounds, known: facts });
    let latest: Vec<_> = (system.clients.iter().zip(situations))
        .map(|(client, situations)| latest(client, situations, &control))
        .collect();
    let mut of_clients = FxHashMap::default();
    for &task in tasks {
        let length = system.tasks[task].period?;
        of_clients
            .entry(length)
            .or_insert_with(|| timed_windows(system, situations, length, &latest));
    }
    let periods = system.tasks.iter().filter_map(|task| task.period);
    let hyperperiod = periods.map(u64::from).try_fold(1u64, |all, period| {
        let all = all / greatest_common_divisor(all, period);
        all.checked_mul(period).filter(|all| *all < LONGEST)
    })?;
    let windows_of_clients = of_clients.values().flatten().flatten();
    let times = times(windows_of_clients, facts, hyperperiod);
    let mut out = Jobs { hyperperiod, times, of: ti_vec![Vec::new(); system.tasks.len()] };
    let mut count = 0;
    for &task in tasks {
        let length = system.tasks[task].period?;
        let of_clients = &of_clients[&length];
        let (first, period) = (system.first_tick(task)?, u64::from(length));
        let next = out.times.iter().skip(1).copied().chain([NEVER]);
        for (&begins, next) in out.times.iter().zip(next) {
            let begins = begins.max(facts[task].next);
            let until = next.min(begins.saturating_add(hyperperiod));
            let mut tick = first + begins.saturating_sub(first).div_ceil(period) * period;
            let mut numbers: Option<Vec<usize>> = None;
            while tick < until {
                let numbers = numbers.get_or_insert_with(|| {
                    let requests = requests_at(system, of_clients, tick).into_iter();
                    requests.map(|requests| windows.number(requests, length)).collect()
                });
                out.of[task].push(Job { tick, windows: numbers.clone(), bound: 0 });
                tick += period;
                count += 1;
                if count > MAX_JOBS {
                    return None;
                }
            }
        }
    }
    Some(out)
}

/// Returns the times from which on other requests play a part, other tasks have started or other jobs begin.
fn times<'w>(
    windows: impl Iterator<Item = &'w ClientWindow>,
    facts: &Knowns,
    hyperperiod: u64,
) -> Vec<u64> {
    let mut times: Vec<u64> =
        windows.flat_map(|window| [window.begins, window.until.saturating_add(1)]).collect();
    times.push(0);
    // Start-ups are over, and jobs begin.
    times.extend(facts.iter().flat_map(|facts| [Some(facts.next), facts.ends]).flatten());
    times.retain(|time| *time != NEVER);
    times.sort_unstable();
    times.dedup();
    // Jobs near the beginning of an interval see those before it.
    let next = times.iter().skip(1).copied().chain([NEVER]);
    let split: Vec<u64> = (times.iter().zip(next))
        .filter(|&(&begins, next)| next - begins > 2 * hyperperiod)
        .map(|(&begins, _)| begins + hyperperiod)
        .collect();
    times.extend(split);
    times.sort_unstable();
    times
}
