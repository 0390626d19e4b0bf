//! The time for which a job waits for cores, while all of them are at work for others.
//!
//! If the job waits *x*, another thread has a core for at most min(*W*, *x*) meanwhile, since it occupies one
//! core at a time; *W* is the greatest time for which it has cores. So *x* is at most the greatest solution
//! of *m x* ≤ Σ min(*W*, *x*). A thread that may work for ever occupies a core. *W* depends on the policy:
//!
//! * `fifo`: every other task has at most one cycle ahead, waiting or under way, also if deadlines are
//!   missed.
//! * `edf`: a task with a longer period has one cycle ahead at most, and one of a kept tick. Of the tasks
//!   whose cycles go after the job, as many as there are cores have one already.
//! * `any`, `edf` otherwise: the cycles of the window.
//! * `priority`, `fair`: the job can lose its core at any time, so the window is the whole response. At each
//!   moment of it the job executes, or a thread that goes before the job or before a thread that is ahead in
//!   the lock queue. So the response is at most the work of all of them, also if threads are bound to cores.
//!   Otherwise the equation counts, with the same threads, while the job has no core or a thread ahead has
//!   none. If one thread ahead goes after the job, it has no core then (M. Bertogna, M. Cirinei,
//!   *Response-time analysis for globally scheduled symmetric multiprocessor platforms*, RTSS 2007, also for
//!   min(*W*, *x*)).
//!
//! Without preemption a cycle keeps its core while it waits for a lock. Let *m* - 1 threads be apart. While
//! one of the others waits for one of the others, two of the others have cores, so one of the *m* - 1 has
//! none. The *m* cores are at work for *m x*: at most (*m* - 1) *x* for the threads apart, less those waits.
//! So *x* is at most the work of the others, with their waits for the threads apart and for threads that need
//! no core.
//!
//! In a window of length *w*, a periodic task executes the cycles of the ticks that come in it or that came
//! less than *R* before it, if each ends by *R* after its tick; the first cycle and the ticks after it, if
//! that can be under way; and one cycle more on each side if it can be late. An aperiodic task executes every
//! codel at most as often as its instances can.
//!
//! If the tick of the job is known, the ticks of the others are known as well: of the cycle under way, what
//! its bound leaves counts, and the cycles of the ticks in the window. A late task has one raised flag at
//! most, and one more for each tick.

use std::cmp::Reverse;

use super::jobs::Single;
use super::{Cycle, Known, Knowns, Window, chain, executed_once};
use crate::analytic::demand::longest_wait;
use crate::system::{CodelId, ComponentId, Policy, TaskId};

/// A thread that can have a core while a job waits.
struct Rival {
    /// Its index, see [`Window::rivals`].
    thread: usize,
    /// The greatest time for which it has a core; `None` if there is no bound.
    time: Option<u64>,
}

/// A job that waits for a core.
#[derive(Clone, Copy)]
struct Waiting<'j> {
    task: TaskId,
    cycle: Cycle,
    /// Length of the window.
    window: u64,
    /// The only job, if it is not any job.
    single: Option<Single<'j>>,
}

/// The work of another task, given the tick of the job that waits.
struct Phase {
    /// The work of the only cycle that can be ahead under `fifo`.
    ahead: u64,
    /// The work of the cycle under way when the window begins.
    carried: u64,
    /// Number of other ticks whose cycles play a part.
    later: u64,
    /// Number of later ticks with a deadline that is not later than that of the job.
    before: u64,
    /// The cycle of the last tick has a later deadline than the job, if that is known.
    goes_after: Option<bool>,
}

impl Window<'_> {
    /// Returns a bound on the length of a job, from its tick or the beginning of the start-up, given a lower
    /// one and what is known of all tasks.
    pub(super) fn response(
        &self,
        task: TaskId,
        cycle: Cycle,
        least: u64,
        known: &Knowns,
        single: Option<Single>,
    ) -> Option<u64> {
        let work = self.without_waits(Waiting { task, cycle, window: least, single }, known);
        if cycle == Cycle::StartUp {
            return Some(least.max(work?));
        }
        let length = u64::from(self.length(task, cycle, Some(known), &|_| true)?);
        let platform = &self.system.platform;
        let enough = platform.cores.is_none_or(|cores| cores as usize >= self.system.tasks.len());
        if !self.system.needs_core(task) || enough && !self.system.preempts() {
            return Some(least.max(length));
        }
        let window = match platform.policy {
            Policy::Priority | Policy::Fair => least.max(length),
            Policy::Fifo | Policy::Edf | Policy::Any => least.saturating_sub(length),
        };
        let response = self.with_core_wait(Waiting { task, cycle, window, single }, length, known);
        Some(least.max(response.into_iter().chain(work).min()?))
    }

    /// Returns the work of a job that can lose its core, and of all threads for which it can wait: one of
    /// them executes at any time. Waits for threads that need no core count as such.
    fn without_waits(&self, job: Waiting, known: &Knowns) -> Option<u64> {
        if !self.system.preempts() {
            return None;
        }
        let chain = chain(self.system, job.task);
        if job.cycle == Cycle::StartUp && !chain.iter().all(|&task| self.system.needs_core(task)) {
            return None;
        }
        let tasks = self.system.tasks.len();
        let waits_for =
            |thread: usize| thread < tasks && !self.system.needs_core(TaskId::from(thread));
        let length = self.length(job.task, job.cycle, Some(known), &waits_for)?;
        let rivals = self.rivals_for_cores(job, known, &|_| true);
        let own = [job.task];
        let waiting = if job.cycle == Cycle::StartUp { chain } else { &own };
        let last = waiting.iter().map(|&task| self.last_priority(task)).max();
        let mut rivals =
            rivals.iter().filter(|rival| last.is_some_and(|last| self.goes_first(rival, last)));
        rivals.try_fold(u64::from(length), |sum, rival| sum.checked_add(rival.time?))
    }

    /// Returns the priority of the last thread that can have a core while a job has none, or while a thread
    /// ahead of the job in the lock queue has none.
    fn last_priority(&self, task: TaskId) -> u64 {
        let threads = self.threads_ahead(task).into_iter().chain([usize::from(task)]);
        threads.map(|thread| self.priorities[thread]).max().unwrap_or(u64::MAX)
    }

    /// Returns true if a rival does not go after all threads of a priority.
    fn goes_first(&self, rival: &Rival, last: u64) -> bool {
        self.system.platform.policy != Policy::Priority || self.priorities[rival.thread] <= last
    }

    /// Returns the longest time of a job and its wait for cores; `length` is the time without that wait.
    fn with_core_wait(&self, job: Waiting, length: u64, known: &Knowns) -> Option<u64> {
        let cores = u64::from(self.system.platform.cores?);
        if self.system.tasks.iter().any(|task| task.affinity.is_some()) {
            return None;
        }
        let mut rivals = self.rivals_for_cores(job, known, &|_| true);
        let last = self.last_priority(job.task);
        rivals.retain(|rival| self.goes_first(rival, last));
        let waits = |rivals: &[Rival]| {
            let works: Vec<u64> = rivals.iter().filter_map(|rival| rival.time).collect();
            let endless = (rivals.len() - works.len()) as u64;
            longest_wait(cores.checked_sub(endless)?, works)?.checked_add(length)
        };
        if self.system.preempts() {
            if self.system.platform.policy == Policy::Priority {
                let own = self.priorities[usize::from(job.task)];
                let mut ahead = self.threads_ahead(job.task);
                ahead.retain(|&thread| self.priorities[thread] > own);
                rivals.retain(|rival| ahead != [rival.thread]);
            }
            return waits(&rivals);
        }
        let together = waits(&rivals);
        rivals.sort_by_key(|rival| Reverse(rival.time.unwrap_or(u64::MAX)));
        // Threads without a bound are apart, and all choices of the last thread are tried.
        let (last, apart) = (cores as usize)
            .checked_sub(2)
            .map_or((0..0, 0), |apart| (apart..rivals.len(), apart.min(rivals.len())));
        let apart: Vec<usize> = rivals[..apart].iter().map(|rival| rival.thread).collect();
        let choices = last.map(|last| [&apart[..], &[rivals[last].thread]].concat());
        let one_by_one =
            choices.chain([apart.clone()]).filter_map(|apart| self.one_by_one(job, &apart, known));
        together.into_iter().chain(one_by_one).min()
    }

    /// Returns true if the cycles of a task that are ahead of a job have later deadlines, so that only those
    /// that have a core already keep the job waiting.
    fn goes_after(&self, other: TaskId, job: Waiting, known: &Knowns) -> bool {
        let period = |task: TaskId| self.system.tasks[task].period.map(u64::from);
        match (period(job.task), period(other), known[other].after_tick) {
            (Some(_), None, _) => true,
            (Some(own), Some(period), Some(response)) => {
                let phase = self.phase(other, job, (0, 0), known);
                if let Some(after) = phase.and_then(|phase| phase.goes_after) {
                    return after;
                }
                let first_tick = self.system.first_tick(other).unwrap_or(0);
                let first = if self.is_started(other, job.task, job.cycle, known) {
                    Some(0)
                } else {
                    known[other].ends.map(|ends| ends.saturating_sub(first_tick))
                };
                first.is_some_and(|first| period > own + response.max(first))
            }
            _ => false,
        }
    }

    /// Returns the longest time of a job if certain threads have a core for as long as it waits for one.
    fn one_by_one(&self, job: Waiting, apart: &[usize], known: &Knowns) -> Option<u64> {
        let has_core = |thread: usize| {
            thread < self.system.tasks.len() && self.system.needs_core(TaskId::from(thread))
        };
        let waits_for = |thread: usize| apart.contains(&thread) || !has_core(thread);
        let others = self.rivals_for_cores(job, known, &waits_for);
        let mut others = others.iter().filter(|rival| !apart.contains(&rival.thread));
        let has_same_ticks = |thread: usize| {
            let other = Some(TaskId::from(thread)).filter(|_| thread < self.system.tasks.len());
            other.is_some_and(|other| self.has_same_ticks(job.task, job.cycle, other, known))
        };
        let waits_for = |thread: usize| waits_for(thread) || !has_same_ticks(thread);
        let length = self.length(job.task, job.cycle, Some(known), &waits_for)?;
        others.try_fold(u64::from(length), |sum, rival| sum.checked_add(rival.time?))
    }

    /// Returns true if another task executes exactly one cycle from the tick of a job to the next tick.
    pub(super) fn has_same_ticks(
        &self,
        task: TaskId,
        cycle: Cycle,
        other: TaskId,
        known: &Knowns,
    ) -> bool {
        let (own, entry) = (&self.system.tasks[task], &self.system.tasks[other]);
        own.component == entry.component
            && (own.period, own.delay) == (entry.period, entry.delay)
            && known[other].after_tick.is_some()
            && cycle == Cycle::Other
            && self.is_started(other, task, cycle, known)
    }

    /// Returns the threads that can have a core while a job waits for one, with their waits for certain
    /// threads.
    fn rivals_for_cores(
        &self,
        job: Waiting,
        known: &Knowns,
        waits_for: &dyn Fn(usize) -> bool,
    ) -> Vec<Rival> {
        let system = self.system;
        let tasks =
            system.tasks.keys().filter(|&other| other != job.task && system.needs_core(other));
        // A first cycle is over before some other tasks begin.
        let ends = known[job.task].ends.filter(|_| job.cycle != Cycle::Other).unwrap_or(u64::MAX);
        let tasks = tasks.filter(|&other| known[other].begins < ends);
        let tasks = tasks.map(|other| Rival {
            thread: usize::from(other),
            time: self.time_with_core(other, job, known, waits_for),
        });
        let controls = system.components.keys().filter(|_| system.preempts()).map(|component| {
            let thread = system.tasks.len() + usize::from(component);
            Rival { thread, time: self.control_work(component) }
        });
        let all = tasks.chain(controls).filter(|rival| rival.time != Some(0));
        let after = |rival: &Rival| {
            system.platform.policy == Policy::Edf
                && self.goes_after(TaskId::from(rival.thread), job, known)
        };
        let (mut after, mut rivals): (Vec<Rival>, Vec<Rival>) = all.partition(after);
        after.sort_by_key(|rival| Reverse(rival.time.unwrap_or(u64::MAX)));
        after.truncate(system.platform.cores.unwrap_or(0) as usize);
        rivals.append(&mut after);
        rivals
    }

    pub(super) fn control_work(&self, component: ComponentId) -> Option<u64> {
        let services = self.system.components[component].services.iter();
        let each = services.map(|&service| {
            let times = self.control_codels(service);
            let time: u64 = times.map(|codel| u64::from(self.system.codels[codel].upper)).sum();
            match self.client.requests[service] {
                Some(count) => time.checked_mul(u64::from(count)),
                None => (time == 0).then_some(0),
            }
        });
        each.sum()
    }

    /// Returns the threads that can be ahead of a task in the lock queue of its component. A thread at the
    /// head of the queue may wait for a core, so that all others wait behind it, whatever the locks.
    fn threads_ahead(&self, task: TaskId) -> Vec<usize> {
        self.threads_beside(task).filter(|&thread| self.takes_tickets[thread]).collect()
    }

    /// Returns the greatest time for which another task has a core while a job waits for one.
    fn time_with_core(
        &self,
        other: TaskId,
        job: Waiting,
        known: &Knowns,
        waits_for: &dyn Fn(usize) -> bool,
    ) -> Option<u64> {
        let system = self.system;
        if job.single.is_some_and(|single| known[other].begins > single.to + job.window) {
            return Some(0);
        }
        // A task that waits for a lock keeps its core, unless it can lose the core.
        let waits_for = |thread: usize| !system.preempts() && waits_for(thread);
        let is_started = self.is_started(other, job.task, job.cycle, known);
        let Some(period) = system.tasks[other].period.map(u64::from) else {
            return self.work_in_window(other, is_started, &waits_for);
        };
        let cycle = |of| Some(u64::from(self.length(other, of, Some(known), &waits_for)?));
        let each = cycle(Cycle::Other)?;
        let cycles = |number| self.lengths((other, Cycle::Other, number), Some(known), &waits_for);
        let Known { begins, next, ends, after_tick, .. } = known[other];
        let starts = !is_started;
        let first = if starts { cycle(Cycle::First)? } else { 0 };
        let phased = self.phase(other, job, (first, each), known).and_then(|phase| {
            let later = match system.platform.policy {
                Policy::Fifo => return Some(phase.ahead),
                Policy::Edf => phase.before,
                Policy::Any | Policy::Priority | Policy::Fair => phase.later,
            };
            cycles(later)?.checked_add(phase.carried)
        });
        let is_later = system.tasks[job.task].period.is_some_and(|own| period >= u64::from(own));
        let window = job.window;
        // Each cycle has a tick of its own, at most its response time before its end. That of the first cycle
        // is the last one before it can begin.
        let of_ticks = |response: u64| {
            let of_first = if starts { (ends? + period).saturating_sub(next) } else { 0 };
            let count = (window + response.max(of_first)).div_ceil(period);
            cycles(count.saturating_sub(1))?.checked_add(each.max(first))
        };
        let at_any_time = match (system.platform.policy, after_tick) {
            (Policy::Fifo, _) => Some(each.max(first)),
            (Policy::Edf, None) if is_later => each.max(first).checked_mul(2),
            (Policy::Edf, Some(response)) if is_later => {
                first.checked_add(each).into_iter().chain(of_ticks(response)).min()
            }
            (_, None) => cycles(window / period + 3)?.checked_add(first),
            (_, Some(response)) => {
                let usual = cycles((window + response).div_ceil(period))?;
                // The ticks from the beginning of the first cycle to the end of the window.
                let count = match ends {
                    Some(ends) => (ends + window).saturating_sub(begins).div_ceil(period),
                    None => window / period + 2,
                };
                let start = if starts { first.checked_add(cycles(count)?)? } else { 0 };
                of_ticks(response).into_iter().chain([usual.max(start)]).min()
            }
        };
        phased.into_iter().chain(at_any_time).min()
    }

    /// Returns the work of another task, if the time of the job is known. `first` and `each` are the greatest
    /// work in the first cycle and in another one.
    fn phase(
        &self,
        other: TaskId,
        job: Waiting,
        (first, each): (u64, u64),
        known: &Knowns,
    ) -> Option<Phase> {
        let Single { jobs, from, to } = job.single?;
        let period = u64::from(self.system.tasks[other].period?);
        let first_tick = self.system.first_tick(other)?;
        let Known { begins, next, ends, after_tick, .. } = known[other];
        let is_started = ends.is_some_and(|ends| ends <= from);
        let ticks = |time: u64| time.checked_sub(first_tick).map_or(0, |time| time / period + 1);
        let until = ticks(to + job.window);
        let Some(response) = after_tick else {
            // After the ticks of that moment at most one flag is raised, and each later tick raises one.
            let before = if begins < from { ticks(from).saturating_sub(1) } else { ticks(begins) };
            let under_way = match (begins < from, is_started) {
                (true, true) => each,
                (true, false) => each.max(first),
                (false, _) => first,
            };
            let later = until.saturating_sub(before);
            let ahead = each.max(first);
            return Some(Phase {
                ahead,
                carried: under_way,
                later,
                before: later,
                goes_after: None,
            });
        };
        if from < to || !is_started {
            let over = from.checked_sub(response).map_or(0, ticks);
            let over = if is_started { over } else { over.max(ticks(next - 1)) };
            let left = ends.map_or(first, |ends| ends.saturating_sub(from));
            let start = if is_started { 0 } else { first.min(left) };
            let ahead = if ticks(to) > over { each } else { 0 };
            let later = until.saturating_sub(over);
            return Some(Phase {
                ahead: start.max(ahead),
                carried: start,
                later,
                before: later,
                goes_after: None,
            });
        }
        let own = u64::from(self.system.tasks[job.task].period?);
        let last = first_tick + from.checked_sub(first_tick)? / period * period;
        let left = (last + jobs.after_tick(other, last, from, known)?).saturating_sub(from);
        let later = (from + job.window - last) / period;
        let before = (from + own).checked_sub(last + period);
        Some(Phase {
            ahead: each.min(left),
            carried: each.min(left),
            later,
            before: before.map_or(0, |before| (before / period).min(later)),
            goes_after: Some(last + period > from + own),
        })
    }

    /// Returns true if the start-up of another task is over before a job of a task begins.
    pub(super) fn is_started(
        &self,
        other: TaskId,
        task: TaskId,
        cycle: Cycle,
        known: &Knowns,
    ) -> bool {
        let own = &known[task];
        let begins = match cycle {
            Cycle::Other => own.next,
            Cycle::StartUp => own.leader_begins,
            Cycle::First | Cycle::FirstPass => own.begins,
        };
        let begins = begins.max(self.client.begins);
        known[other].ends.is_some_and(|ends| ends <= begins)
    }

    /// Returns the greatest time for which an aperiodic task executes codels in the window, or waits for
    /// certain threads; `None` if it can execute a codel again and again.
    pub(super) fn work_in_window(
        &self,
        task: TaskId,
        is_started: bool,
        waits_for: &dyn Fn(usize) -> bool,
    ) -> Option<u64> {
        let definition = &self.system.tasks[task];
        let automata = definition.permanent.iter().chain(&definition.slots);
        let codels = automata.flat_map(|&automaton| {
            let machine = self.system.machine_of(automaton);
            let is_over = is_started && definition.permanent == Some(automaton);
            // The first codel is over, unless the machine returns to it.
            let first = executed_once(machine).filter(|_| is_over);
            let codels = self.codels_of(automaton).into_iter();
            codels.filter(move |(codel, _)| Some(*codel) != first)
        });
        let codels: Vec<(CodelId, Option<u32>)> = codels.collect();
        if codels.iter().all(|(codel, _)| self.system.codels[*codel].upper == 0) {
            return Some(0);
        }
        codels.into_iter().try_fold(0u64, |sum, (codel, often)| {
            let threads = self.threads_beside(task).filter(|&thread| waits_for(thread));
            let waits = threads.map(|thread| self.most(self.ahead(task, codel, thread)));
            let time = waits.fold(self.upper(codel), |sum, wait| sum?.checked_add(wait))?;
            sum.checked_add(u64::from(time).checked_mul(u64::from(often?))?)
        })
    }
}
