//! The work that can keep a codel waiting for its locks.

use typed_index_collections::TiVec;

use super::demand::Stretches;
use super::ways::Ways;
use super::windows::Requests;
use super::{Analysis, Window};
use crate::scn::semantics::LockRule;
use crate::system::{AutomatonId, CodelId, CodelSet, FOREVER, Machine, TaskId, TimedSystem};

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
        for (task, entry) in self.system.tasks.iter_enumerated().filter(|pair| of(pair.0)) {
            if entry.period.is_some() {
                let start = entry.permanent.map_or(Some(0), |a| self.start_up(a, &cost));
                let parties = if own == Some(task) && !self.system.runs_apart(task) {
                    &[]
                } else {
                    &window.parties[task][..]
                };
                let jobs = parties.iter().map(|party| self.turns(party, &cost));
                let most = jobs.max_by_key(|job| job.unwrap_or(u64::MAX));
                let job = most.unwrap_or(Some(0));
                if (start, job) != (Some(0), Some(0)) {
                    out.jobs.push(Rival { task, start, job });
                }
                continue;
            }
            let takes_part = |automaton: &&AutomatonId| {
                let service = self.system.automata[**automaton].service;
                service.is_none_or(|service| window.requests[service] != Some(0))
            };
            for &automaton in entry.permanent.iter().chain(&entry.slots).filter(takes_part) {
                let machine = self.system.machine_of(automaton);
                if machine.states.iter().any(|state| cost(state.codel) != Some(0)) {
                    // Activities begin again at any time.
                    let alone = entry.slots.is_empty();
                    let found = alone.then(|| self.stretches(machine, &cost));
                    out.stretches.push(found.flatten());
                }
            }
        }
        out.control = self.control_work(&window.requests, excluded);
        out
    }

    /// Returns the longest execution time of a codel, unless it is unlimited.
    pub(super) fn upper(&self, codel: CodelId) -> Option<u64> {
        let upper = self.system.codels[codel].upper;
        (upper != FOREVER).then_some(u64::from(upper))
    }

    /// Returns the stretches of work of a permanent activity without a period, given the work of each codel.
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
            work: Ways::stretches(machine, &|index| !breaks(index)).costliest(&cost)?,
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
