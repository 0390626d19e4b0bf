//! Tasks that certainly have jobs, because a run shows one.

use crate::cancel::Cancel;
use crate::explore::{Possible, RunState as _, Stepper, Watched};
use crate::system::{TaskId, TimedSystem};
use typed_index_collections::{TiSlice, TiVec, ti_vec};

/// Upper limit on the steps of the run.
const STEPS: usize = 10_000;

/// Number of steps between two looks at the cancellation.
const POLL: usize = 500;

/// By task: true if a run of the system has a job of it. Three runs are tried, with choices that have no
/// pattern: codels end as early as they may, as late, and now early, now late. If `cancel` is over, later
/// jobs are not seen.
pub(super) fn tasks_with_jobs(system: &TimedSystem, cancel: &Cancel) -> TiVec<TaskId, bool> {
    let mut released = ti_vec![false; system.tasks.len()];
    let late: [fn(usize) -> bool; 3] =
        [|_| false, |_| true, |step| pseudo_random(step) & 0x80 == 0];
    for late in late {
        run(system, late, &mut released, cancel);
    }
    released
}

fn run(
    system: &TimedSystem,
    late: fn(usize) -> bool,
    released: &mut TiSlice<TaskId, bool>,
    cancel: &Cancel,
) {
    let mut stepper = Stepper::new(system, &Watched::default());
    let (mut seen, mut possible) = (Vec::new(), Possible::default());
    stepper.begin(&mut seen);
    for step in 0..STEPS {
        for (task, released) in released.iter_mut_enumerated() {
            *released |= stepper.job(task.into()).is_some();
        }
        if !released.contains(&false) || step % POLL == POLL - 1 && cancel.is_over() {
            return;
        }
        seen.clear();
        stepper.possible(&mut possible);
        let actions = possible.actions();
        if actions.is_empty() || late(step) && possible.may_wait() {
            let moment = stepper.next_moment();
            if let Some(time) = moment.filter(|&moment| moment > 0) {
                stepper.pass(time, &mut seen);
                continue;
            }
        }
        match actions.get(pseudo_random(step) % actions.len().max(1)) {
            Some(&action) => stepper.perform(action, &mut seen),
            None => return,
        }
    }
}

/// A number without a pattern, the same for the same step.
fn pseudo_random(step: usize) -> usize {
    (step.wrapping_mul(0x9e37_79b9) >> 12) & 0xffff
}
