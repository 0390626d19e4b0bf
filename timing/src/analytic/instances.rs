//! The activities that can be under way at the same time, according to the order of requests.

use rustc_hash::FxHashSet;
use typed_index_collections::TiVec;

use crate::system::{AutomatonId, Client, ClientAction, ServiceId, TaskId, TimedSystem};

/// Number of situations of a client above which all slots are assumed to be in use.
const MAX_SITUATIONS: usize = 2_000;

/// Number of combinations of activities of a task above which all slots are assumed to be in use.
const COMBINATIONS: usize = 32;

/// Returns, by task, sets of automata. All automata that have a turn in one job belong to one of these sets.
///
/// An activity that has had a turn in a job keeps its slot until the job has ended, so all of these slots are
/// in use at its end.
pub(super) fn of_one_job(system: &TimedSystem) -> TiVec<TaskId, Vec<Vec<AutomatonId>>> {
    let live: Vec<Option<FxHashSet<ActiveInstances>>> =
        system.clients.iter().map(|client| situations(system, client)).collect();
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
    live: &ActiveInstances,
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

/// Instances of activities: the service and the trackers that follow it.
type ActiveInstances = Vec<(ServiceId, Vec<usize>)>;

/// Returns the instances that the requests of a client can have at the same time, one list for each situation
/// of the client.
///
/// Instances whose end is not awaited stay for ever here. Their end would not make another list longer: the
/// lists already contain as many more instances as would find a slot.
fn situations(system: &TimedSystem, client: &Client) -> Option<FxHashSet<ActiveInstances>> {
    let mut seen: FxHashSet<(usize, ActiveInstances)> = FxHashSet::default();
    let mut stack: Vec<(usize, ActiveInstances)> =
        client.first.iter().map(|&index| (index, Vec::new())).collect();
    while let Some((at, live)) = stack.pop() {
        if !seen.insert((at, live.clone())) {
            continue;
        }
        if seen.len() > MAX_SITUATIONS {
            return None;
        }
        let Some(step) = client.steps.get(at) else {
            continue;
        };
        let mut live = live;
        match step.action {
            ClientAction::Send { service, ref trackers, .. } => {
                for (_, instances) in &mut live {
                    instances.retain(|instance| !trackers.contains(instance));
                }
                let already = live.iter().filter(|entry| entry.0 == service).count();
                if already < system.services[service].slots.len() {
                    live.push((service, trackers.clone()));
                }
                live.sort_unstable();
            }
            ClientAction::AwaitEnded(tracker) | ClientAction::AwaitOutcome(tracker, _) => {
                live.retain(|pair| !pair.1.contains(&tracker));
            }
            ClientAction::AwaitAccepted | ClientAction::AwaitAny | ClientAction::Delay(..) => {}
        }
        stack.extend(step.next.iter().map(|&next| (next, live.clone())));
    }
    Some(seen.into_iter().map(|names| names.1).collect())
}
