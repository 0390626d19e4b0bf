//! The activities that can be under way at the same time, according to the order of requests.

use rustc_hash::FxHashSet;

use super::situations::Situations;
use crate::scn::semantics::Cycle;
use crate::system::{ServiceId, TaskId, TimedSystem};

/// Number of combinations of activities of a task above which they are not told apart.
const COMBINATIONS: usize = 32;

/// Services, in order; one occurs as often as it has instances.
pub(super) type Party = Vec<ServiceId>;

/// Returns parties of a task. All activities that have a turn in one job belong to one of them. `None`: no
/// such parties are known.
///
/// With `semantics published`, an activity that has had a turn in a job keeps its slot until the job has
/// ended. With `semantics servers`, the first pass of a cycle begins the activities, and reports those that
/// have ended only after it. So at one moment, the client has not seen the end of any of them. An aperiodic
/// task begins activities in any pass.
pub(super) fn of_one_job(
    system: &TimedSystem,
    situations: &[Situations],
    task: TaskId,
) -> Option<Vec<Party>> {
    let has_jobs = system.platform.semantics.fixed().cycle == Cycle::Jobs;
    // An activity with threads of its own frees its slot at its end, independently of jobs.
    if system.runs_apart(task) || !has_jobs && system.tasks[task].period.is_none() {
        return None;
    }
    let is_own = |service: ServiceId| {
        let slots = &system.services[service].slots;
        slots.iter().any(|&slot| system.automata[slot].task == task)
    };
    let mut parties = vec![Party::new()];
    for situations in situations {
        let of_client = situations.as_ref()?.iter().map(|(_, under_way)| {
            let services = under_way.iter().map(|(service, ..)| *service);
            services.filter(|service| is_own(*service)).collect()
        });
        let of_client = greatest(of_client.collect());
        let both = |one: &Party, other: &Party| {
            let mut both = [&one[..], other].concat();
            both.sort_unstable();
            both
        };
        let all =
            parties.iter().flat_map(|one| of_client.iter().map(move |other| both(one, other)));
        parties = greatest(all.collect());
        if parties.len() > COMBINATIONS {
            return None;
        }
    }
    Some(parties)
}

/// Leaves out the parties that are part of others.
fn greatest(all: FxHashSet<Party>) -> Vec<Party> {
    let is_part = |one: &Party, whole: &Party| {
        let mut rest = whole.iter();
        one.len() < whole.len() && one.iter().all(|service| rest.any(|other| other == service))
    };
    let mut out: Vec<Party> =
        all.iter().filter(|one| !all.iter().any(|whole| is_part(one, whole))).cloned().collect();
    out.sort_unstable();
    out
}
