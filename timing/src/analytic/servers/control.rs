//! Bounds on the times of requests, from those of the tasks that execute them.
//!
//! A control task is busy for at most the time of all requests that ever come. An activity without pause
//! ends with the cycle that begins it: the next one of a periodic task, and of an aperiodic one the cycle
//! under way or the next one. Before that it waits, at most, for the end of an activity that it interrupts.

use typed_index_collections::{TiVec, ti_vec};

use super::{Cycle, Facts, Turns, Window};
use crate::analytic::demand::longest_wait;
use crate::analytic::latest::{NEVER, Requested};
use crate::analytic::windows::{ClientWindow, Requests, shuts_down, whole_run};
use crate::system::{CodelId, ComponentId, FOREVER, Policy, ServiceId, TaskId, TimedSystem, Yield};

/// Number of rounds until the time of a control task is fixed.
const ROUNDS: usize = 100;

/// The times of requests, in base units; [`NEVER`] if none is known.
pub(super) struct Control<'s> {
    system: &'s TimedSystem,
    /// Latest end of the start-up, by component.
    starts: TiVec<ComponentId, u64>,
    /// Longest time until the control task has handled all messages, by component.
    handles: TiVec<ComponentId, u64>,
    /// Latest end of the start-up of the task of an activity, by service.
    begins: TiVec<ServiceId, u64>,
    /// Longest time of an activity after that, by service.
    lasts: TiVec<ServiceId, u64>,
}

impl Requested for Control<'_> {
    fn handled(&self, service: ServiceId, sent: u64) -> u64 {
        let component = self.system.services[service].component;
        sent.max(self.starts[component]).saturating_add(self.handles[component])
    }

    fn over(&self, service: ServiceId, handled: u64) -> u64 {
        let component = self.system.services[service].component;
        let ends = handled.max(self.begins[service]).saturating_add(self.lasts[service]);
        ends.saturating_add(self.handles[component])
    }
}

impl<'s> Control<'s> {
    pub(super) fn new(turns: &Turns<'s>, facts: &Facts) -> Control<'s> {
        let system = turns.system;
        let requests = whole_run(system);
        let ends = |task: TaskId| facts.known[task].ends.unwrap_or(NEVER);
        let starts = (system.components.iter())
            .map(|component| component.tasks.iter().map(|&task| ends(task)).max().unwrap_or(0));
        let window = Window::new(turns, ClientWindow::any_time(requests.clone()), None);
        let handles = system.components.keys().map(|component| {
            let work = work(system, &requests, component)?;
            if system.preempts() {
                window.control_response(component, work, facts)
            } else {
                Some(work)
            }
        });
        let mut out = Control {
            system,
            starts: starts.collect(),
            handles: handles.map(|time| time.unwrap_or(NEVER)).collect(),
            begins: ti_vec![0; system.services.len()],
            lasts: ti_vec![0; system.services.len()],
        };
        let alone: TiVec<ServiceId, Option<u64>> =
            system.services.keys().map(|service| alone(system, service, facts)).collect();
        for (service, entry) in
            system.services.iter_enumerated().filter(|(_, entry)| entry.activity)
        {
            let slot = entry.slots.first().map(|&slot| system.automata[slot].task);
            out.begins[service] = slot.map_or(NEVER, ends);
            out.lasts[service] = lasts(system, &requests, service, &alone).unwrap_or(NEVER);
        }
        out
    }
}

/// Returns the work of a control task in the whole run, with its waits in the lock queue.
fn work(system: &TimedSystem, requests: &Requests, component: ComponentId) -> Option<u64> {
    let upper = |codel: CodelId| {
        Some(u64::from(system.codels[codel].upper)).filter(|time| *time < u64::from(FOREVER))
    };
    let of_machine = |task: TaskId| {
        let task = &system.tasks[task];
        let automata = task.permanent.iter().chain(&task.slots);
        let states = automata.flat_map(|&automaton| &system.machine_of(automaton).states);
        states.map(|state| upper(state.codel)).try_fold(0, |most, time| Some(time?.max(most)))
    };
    let tasks = system.components[component].tasks.iter();
    let waits = tasks.map(|&task| of_machine(task)).sum::<Option<u64>>();
    let each = system.components[component].services.iter().map(|&service| {
        let entry = &system.services[service];
        let mut codels = entry.validate.iter().chain(&entry.simple).peekable();
        if codels.peek().is_none() || requests[service] == Some(0) {
            return Some(0);
        }
        let time = codels.map(|&codel| upper(codel)?.checked_add(waits?)).sum::<Option<u64>>()?;
        time.checked_mul(u64::from(requests[service]?))
    });
    each.sum()
}

/// Returns the longest time of an activity that waits for no other one, after it has been accepted.
fn alone(system: &TimedSystem, service: ServiceId, facts: &Facts) -> Option<u64> {
    let entry = &system.services[service];
    let automaton = &system.automata[*entry.slots.first()?];
    let task = automaton.task;
    let mut states = system.machines[automaton.machine].states.iter();
    let pauses = states.any(|state| state.yields.iter().any(|to| matches!(to, Yield::Pause(_))));
    if pauses || shuts_down(system, entry.component) || system.runs_apart(task) {
        return None;
    }
    match system.tasks[task].period {
        Some(period) => facts.known[task].after_tick?.checked_add(u64::from(period)),
        None => facts.bounds[task].other?.checked_mul(2),
    }
}

/// Returns the longest time of an activity, after it has been accepted.
fn lasts(
    system: &TimedSystem,
    requests: &Requests,
    service: ServiceId,
    alone: &TiVec<ServiceId, Option<u64>>,
) -> Option<u64> {
    let own = alone[service]?;
    let entry = &system.services[service];
    let interferes = |&(other, of): &(ServiceId, &crate::system::Service)| {
        let related = entry.interrupts.contains(&other) || of.interrupts.contains(&service);
        let often = requests[other];
        related && often != Some(0) && (other != service || often != Some(1))
    };
    let mut others = system.services.iter_enumerated().filter(interferes).peekable();
    if others.peek().is_none() {
        return Some(own);
    }
    // An aperiodic task need not notice soon that an activity has been interrupted before it began.
    let slot = entry.slots.first()?;
    system.tasks[system.automata[*slot].task].period?;
    let mut waits = others.map(|(other, of)| if of.activity { alone[other] } else { Some(0) });
    own.checked_add(waits.try_fold(0, |most, time| Some(time?.max(most)))?)
}

impl Window<'_> {
    /// Returns the longest time until a control task has done some work, if it can lose its core.
    fn control_response(&self, component: ComponentId, work: u64, facts: &Facts) -> Option<u64> {
        let system = self.system;
        let cores = u64::from(system.platform.cores?);
        let own = system.tasks.len() + usize::from(component);
        let waits_for = (system.components[component].tasks.iter())
            .map(|&task| usize::from(task))
            .filter(|&thread| self.takes_tickets[thread] && work > 0);
        let last = waits_for.chain([own]).map(|thread| self.priorities[thread]).max()?;
        let goes_first = |thread: usize| {
            thread != own
                && (system.platform.policy != Policy::Priority || self.priorities[thread] <= last)
        };
        let mut response = work;
        for _ in 0..ROUNDS {
            let mut works = Vec::new();
            for task in system.tasks.keys().filter(|&task| system.needs_core(task)) {
                if goes_first(usize::from(task)) {
                    works.push(self.work_beside_control(task, response, facts)?);
                }
            }
            for other in system.components.keys() {
                if goes_first(system.tasks.len() + usize::from(other)) {
                    works.push(self.control_work(other)?);
                }
            }
            let tied = system.tasks.iter().any(|task| task.affinity.is_some());
            let wait = if tied { works.iter().sum() } else { longest_wait(cores, works)? };
            let next = work.checked_add(wait)?;
            if next <= response {
                return Some(response);
            }
            response = next;
        }
        None
    }

    /// Returns the greatest work of a task in a window of any length.
    fn work_beside_control(&self, task: TaskId, window: u64, facts: &Facts) -> Option<u64> {
        let Some(period) = self.system.tasks[task].period.map(u64::from) else {
            return self.work_in_window(task, true, &|_| false);
        };
        let upper = |codel: CodelId| self.upper(codel);
        let each = self.work(task, Cycle::Other, &upper)?;
        let each = u64::from(each.max(self.work(task, Cycle::First, &upper)?));
        let count = match facts.known[task].after_tick {
            Some(response) => (window + response) / period + 1,
            None => window / period + 3,
        };
        each.checked_mul(count)
    }
}
