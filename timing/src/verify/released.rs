//! Tasks that have jobs for certain: a run shows it.

use crate::explore::{Possible, Stepper, Watched};
use crate::system::TimedSystem;

/// Steps of the run.
const STEPS: usize = 10_000;

/// By task, whether one run of the system, which does now this and now that of what is possible, has a job of it.
pub(crate) fn seen_released(system: &TimedSystem) -> Vec<bool> {
    let mut released = vec![false; system.tasks.len()];
    let mut stepper = Stepper::new(system, &Watched::default());
    let (mut seen, mut possible) = (Vec::new(), Possible::default());
    stepper.begin(&mut seen);
    for step in 0..STEPS {
        for (task, released) in released.iter_mut().enumerate() {
            *released |= stepper.job(task).is_some();
        }
        stepper.possible(&mut possible);
        let actions = possible.actions();
        let choices = actions.len() + usize::from(possible.may_wait());
        if choices == 0 || !released.contains(&false) {
            break;
        }
        match actions.get(mixed(step) % choices) {
            Some(&action) => stepper.perform(action, &mut seen),
            None => match stepper.next_moment_but(&|_| true) {
                Some(time) => stepper.pass(time, &mut seen),
                None if actions.is_empty() => break,
                None => {}
            },
        }
        seen.clear();
    }
    released
}

/// A number without a pattern, the same for the same step.
fn mixed(step: usize) -> usize {
    (step.wrapping_mul(0x9e37_79b9) >> 12) & 0xffff
}
