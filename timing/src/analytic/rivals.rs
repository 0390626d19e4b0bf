//! The work that can keep a codel waiting for its locks.

use typed_index_collections::TiVec;

use super::demand::{SplitWork, Stretches};
use super::ways::Ways;
use super::windows::Requests;
use super::{Analysis, Window};
use crate::scn::semantics::LockRule;
use crate::system::{
    AutomatonId, CodelId, CodelSet, FOREVER, Machine, ServiceId, TaskId, TimedSystem,
};

/// Number of instances of an activity in a window above which its work is unknown.
const MAX_INSTANCES: u32 = 64;

/// The work that can keep codels waiting for their locks.
#[derive(Debug, Default)]
pub(super) struct Rivals {
    /// Periodic tasks.
    pub(super) jobs: Vec<Rival>,
    /// Tasks without a period; `None` if the work of a task is unknown.
    pub(super) stretches: Vec<Option<Stretches>>,
    /// Total work of control tasks, if it is limited.
    pub(super) control: Option<u64>,
}

/// A periodic task, and its work that keeps others waiting.
#[derive(Debug)]
pub(super) struct Rival {
    pub(super) task: TaskId,
    /// Work in its start-up.
    pub(super) start: Option<u64>,
    /// Work in one job.
    pub(super) job: Option<u64>,
    /// The work of the jobs, split.
    pub(super) split: Option<SplitWork>,
}

/// Returns, by codel, the codels whose execution can keep it waiting. With locks in order of arrival it also
/// waits for the codels that earlier ones wait for.
pub(super) fn excluded(system: &TimedSystem) -> TiVec<CodelId, CodelSet> {
    let mut sets: TiVec<CodelId, CodelSet> =
        system.codels.iter().map(|codel| codel.conflicts.clone()).collect();
    let mut changed = system.platform.semantics.locks == LockRule::Fifo;
    while std::mem::take(&mut changed) {
        for i in system.codels.keys() {
            let members: Vec<CodelId> = sets[i].iter().collect();
            for member in members {
                let more: Vec<CodelId> = sets[member].iter().collect();
                for conflict in more {
                    if !sets[i].contains(conflict) {
                        sets[i].insert(conflict);
                        changed = true;
                    }
                }
            }
        }
    }
    sets
}

impl Analysis<'_> {
    /// Returns the work of certain tasks, and of control tasks, in some codels, while a codel of the `own`
    /// task waits. The waiting job does not block itself, unless separate threads execute its codels; its
    /// start-up may.
    pub(super) fn rivals(
        &self,
        window: &Window,
        excluded: &CodelSet,
        own: Option<TaskId>,
        of: &dyn Fn(TaskId) -> bool,
    ) -> Rivals {
        let mut out = Rivals { control: Some(0), ..Rivals::default() };
        if excluded.is_empty() {
            return out;
        }
        let cost =
            |codel: CodelId| if excluded.contains(codel) { self.upper(codel) } else { Some(0) };
        for (task, entry) in self.system.tasks.iter_enumerated().filter(|task| of(task.0)) {
            let is_beside = own.is_none_or(|own| self.may_work_beside(own, task));
            if entry.period.is_some() {
                let start = entry.permanent.map_or(Some(0), |a| self.start_up(a, &cost));
                let is_same = own == Some(task) && !self.system.runs_apart(task);
                let parties = if is_beside && !is_same { &window.parties[task][..] } else { &[] };
                let jobs = parties.iter().map(|party| self.turns(party, &cost));
                let most = jobs.max_by_key(|job| job.unwrap_or(u64::MAX));
                let job = most.unwrap_or(Some(0));
                if (start, job) != (Some(0), Some(0)) {
                    let split = self.split_work(window, parties, &cost);
                    out.jobs.push(Rival { task, start, job, split });
                }
                continue;
            }
            let activities = entry.slots.iter().filter(|_| is_beside);
            for &automaton in entry.permanent.iter().chain(activities) {
                out.stretches.extend(self.stretches_of(automaton, window, &cost));
            }
        }
        out.control = self.control_work(&window.requests, excluded);
        out
    }

    /// Returns the greatest work in jobs with these parties, given the cost of each codel. Each request
    /// begins an activity in one job; if it pauses, it has later turns in other jobs.
    pub(super) fn split_work(
        &self,
        window: &Window,
        parties: &[Vec<AutomatonId>],
        cost: &dyn Fn(CodelId) -> Option<u64>,
    ) -> Option<SplitWork> {
        let turn = |automaton: AutomatonId| self.turns(&[automaton], cost);
        let limited = |automaton: AutomatonId| {
            window.requests[self.system.automata[automaton].service?].map(u64::from)
        };
        let later = |automaton: AutomatonId| match limited(automaton) {
            Some(_) => {
                let machine = self.system.machine_of(automaton);
                self.later[automaton].costliest(&|state| cost(machine.states[state].codel))
            }
            None => turn(automaton),
        };
        let mut each = parties.iter().map(|party| {
            party.iter().try_fold(0u64, |sum, &automaton| sum.checked_add(later(automaton)?))
        });
        let mut begins = 0u64;
        let mut services: Vec<(ServiceId, AutomatonId)> = (parties.iter().flatten())
            .filter_map(|&automaton| Some((self.system.automata[automaton].service?, automaton)))
            .collect();
        services.sort_unstable();
        services.dedup_by_key(|(service, _)| *service);
        for (_, automaton) in services {
            if let Some(often) = limited(automaton) {
                let more = turn(automaton)?.checked_sub(later(automaton)?)?;
                begins = begins.checked_add(more.checked_mul(often)?)?;
            }
        }
        Some(SplitWork { each: each.try_fold(0, |most, each| Some(each?.max(most)))?, begins })
    }

    /// Returns the longest execution time of a codel, unless it is unlimited.
    pub(super) fn upper(&self, codel: CodelId) -> Option<u64> {
        let upper = self.system.codels[codel].upper;
        (upper != FOREVER).then_some(u64::from(upper))
    }

    /// Returns the stretches of an automaton of an aperiodic task. An activity has those of each of its
    /// requests: one until it is interrupted, and one from then on.
    fn stretches_of(
        &self,
        automaton: AutomatonId,
        window: &Window,
        cost: &dyn Fn(CodelId) -> Option<u64>,
    ) -> Vec<Option<Stretches>> {
        let machine = self.system.machine_of(automaton);
        if machine.states.iter().all(|state| cost(state.codel) == Some(0)) {
            return Vec::new();
        }
        let count = match self.system.automata[automaton].service {
            None => Some(1),
            // The first slot counts for all of them.
            Some(service) if self.system.services[service].slots[0] != automaton => Some(0),
            Some(service) => {
                let parts = 1 + u32::from(machine.stop.is_some());
                window.requests[service].map(|requests| requests.saturating_mul(parts))
            }
        };
        match count.filter(|&count| count <= MAX_INSTANCES) {
            Some(count) => vec![self.stretches(machine, cost); count as usize],
            None => vec![None],
        }
    }

    /// Returns the stretches of work of one instance of an activity without a period, given the work of each
    /// codel.
    fn stretches(
        &self,
        machine: &Machine,
        cost: &dyn Fn(CodelId) -> Option<u64>,
    ) -> Option<Stretches> {
        let lower = |state: usize| self.system.codels[machine.states[state].codel].lower;
        let cost = |state: usize| cost(machine.states[state].codel);
        let breaks = |state: usize| cost(state) == Some(0) && lower(state) > 0;
        let gaps = (0..machine.states.len()).filter(|&state| breaks(state));
        Some(Stretches {
            work: Ways::stretches(machine, &|state| !breaks(state)).costliest(&cost)?,
            gap: gaps.map(|gap| u64::from(lower(gap))).min(),
        })
    }

    /// Returns the work of control tasks in some codels, unless it is unlimited.
    fn control_work(&self, requests: &Requests, excluded: &CodelSet) -> Option<u64> {
        let mut sum = 0u64;
        for (service, &count) in self.system.services.iter().zip(requests) {
            let codels = service.validate.iter().chain(&service.simple);
            let mut codels = codels.filter(|&&codel| excluded.contains(codel));
            let work = codels.try_fold(0u64, |sum, &codel| sum.checked_add(self.upper(codel)?))?;
            if work > 0 {
                sum = sum.checked_add(work.checked_mul(u64::from(count?))?)?;
            }
        }
        Some(sum)
    }
}
