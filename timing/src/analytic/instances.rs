//! The activities that can be under way at the same time, according to the order of requests.

use rustc_hash::FxHashSet;
use typed_index_collections::TiVec;

use super::windows::{Situations, UnderWay};
use crate::system::{AutomatonId, TaskId, TimedSystem};

/// Number of combinations of activities of a task above which all slots are assumed to be in use.
const COMBINATIONS: usize = 32;

/// Returns, by task, sets of automata. All automata that have a turn in one job belong to one of these sets.
///
/// An activity that has had a turn in a job keeps its slot until the job has ended, so all of these slots are
/// in use at its end.
pub(super) fn of_one_job(
    system: &TimedSystem,
    situations: &[Situations],
) -> TiVec<TaskId, Vec<Vec<AutomatonId>>> {
    let live = |situations: &Situations| {
        let all = situations.as_ref()?.iter();
        Some(all.map(|situation| situation.1.clone()).collect())
    };
    let live: Vec<Option<FxHashSet<UnderWay>>> = situations.iter().map(live).collect();
    let of_task = |task: TaskId| {
        let definition = &system.tasks[task];
        let permanent: Vec<AutomatonId> = definition.permanent.into_iter().collect();
        let all = || FxHashSet::from_iter([[&permanent[..], &definition.slots[..]].concat()]);
        // An activity with threads of its own frees its slot at its end, independently of jobs.
        if system.runs_apart(task) {
            return all().into_iter().collect();
        }
        let mut sets = FxHashSet::from_iter([permanent.clone()]);
        for live in &live {
            let with = |set: &Vec<AutomatonId>| -> Option<Vec<Vec<AutomatonId>>> {
                let live = live.as_ref()?.iter();
                let more = live.map(|live| with_slots(system, task, set, live));
                Some(more.collect())
            };
            let next: Option<Vec<Vec<Vec<AutomatonId>>>> = sets.iter().map(with).collect();
            let Some(next) = next else {
                sets = all();
                break;
            };
            sets = next.into_iter().flatten().collect();
            let within = |one: &Vec<AutomatonId>, other: &Vec<AutomatonId>| {
                one.len() < other.len() && one.iter().all(|index| other.contains(index))
            };
            let most = sets.iter().filter(|&names| !sets.iter().any(|other| within(names, other)));
            sets = most.cloned().collect();
            if sets.len() > COMBINATIONS {
                sets = all();
                break;
            }
        }
        sets.into_iter().collect()
    };
    system.tasks.keys().map(of_task).collect()
}

/// Adds slots for the live instances.
fn with_slots(
    system: &TimedSystem,
    task: TaskId,
    set: &[AutomatonId],
    live: &UnderWay,
) -> Vec<AutomatonId> {
    let mut out = set.to_vec();
    for &(service, _) in live {
        let slots = system.services[service].slots.iter();
        let mut free = slots.filter(|&&a| system.automata[a].task == task && !out.contains(&a));
        if let Some(&slot) = free.next() {
            out.push(slot);
        }
    }
    out.sort_unstable();
    out
}
