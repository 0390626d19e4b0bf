//! The activities that each task may execute, according to the requests of clients.

use super::cycle_automaton::Activity;
use super::refusal::Refusal;
use crate::system::{ServiceId, TaskId, TimedSystem};
use typed_index_collections::{TiSlice, TiVec, ti_vec};

/// Number of instances of one activity above which its task is not followed.
const INSTANCES: usize = 3;

/// Returns, by task, the permanent activity and the activities that clients may request. Tasks with too many
/// instances are added to `left`.
pub(super) fn activities(
    system: &TimedSystem,
    left: &mut TiSlice<TaskId, Option<Refusal>>,
) -> TiVec<TaskId, Vec<Activity>> {
    let mut out: TiVec<TaskId, Vec<Activity>> = ti_vec![Vec::new(); system.tasks.len()];
    for (task, entry) in system.tasks.iter_enumerated() {
        let permanent = entry.permanent.map(|automaton| Activity {
            machine: system.automata[automaton].machine,
            permanent: true,
            again: false,
            interrupted: false,
        });
        out[task].extend(permanent);
    }
    let requested = system.requested();
    for (service, entry) in system.services.iter_enumerated() {
        if !requested[service] || !entry.activity {
            continue;
        }
        let interrupts =
            |by: ServiceId| requested[by] && system.services[by].interrupts.contains(&service);
        let often = requests(system, service);
        // At most one instance of an activity that interrupts itself has begun and not ended.
        let (instances, again) = match (entry.interrupts.contains(&service), often) {
            (true, often) => (1, often != Some(1)),
            (false, often) => (often.unwrap_or(usize::MAX), false),
        };
        let Some(&slot) = entry.slots.first() else {
            continue;
        };
        let automaton = &system.automata[slot];
        if instances > INSTANCES {
            left[automaton.task].get_or_insert(Refusal::Requests);
        }
        let activity = Activity {
            machine: automaton.machine,
            permanent: false,
            again,
            interrupted: system.services.keys().any(interrupts),
        };
        let of_task = &mut out[automaton.task];
        of_task.extend(std::iter::repeat_n(activity, instances.min(INSTANCES)));
    }
    out
}

/// Returns the greatest number of requests for a service; `None` if there is no limit.
fn requests(system: &TimedSystem, service: ServiceId) -> Option<usize> {
    let mut often = 0;
    for client in &system.clients {
        for (step, entry) in client.steps.iter().enumerate() {
            if entry.requests() != Some(service) {
                continue;
            }
            if client.comes_again(step) {
                return None;
            }
            often += 1;
        }
    }
    Some(often)
}
