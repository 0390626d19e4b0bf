//! All actions of a stepper are runs of the system, and its events are those of the run.

use dotgen_timing::explore::{
    Action, Possible, RunState as _, Seen, Stepper, Watched, Within, Work,
};
use dotgen_timing::system::TimedSystem;

use crate::agreement::brute::{Brute, CAP, Results};
use crate::agreement::systems::Dice;
use crate::agreement::{all_agree, cases, first, systems};

/// Runs end before ages are cut off.
const END: u64 = CAP as u64 - 10;

/// A walk: actions and events.
struct Walk {
    steps: Vec<(u64, Action)>,
    end: u64,
    seen: Vec<Seen>,
    /// Ages of unfinished jobs and obligations.
    open: (Vec<Option<u32>>, Vec<Option<u32>>),
    refused: Vec<bool>,
}

/// Returns a random walk: any possible action, durations within their intervals. There are at most a thousand
/// actions at one moment.
fn walk(system: &TimedSystem, watched: &Watched, dice: &mut Dice) -> Walk {
    let mut stepper = Stepper::new(system, watched);
    let (mut all, mut fresh) = (Vec::new(), Vec::new());
    let mut steps = Vec::new();
    let mut possible = Possible::default();
    let mut open = (vec![None; system.tasks.len()], vec![None; watched.within.len()]);
    stepper.begin(&mut fresh);
    loop {
        for observation in &fresh {
            if let &Seen::Begun { executor, time: (least, greatest), .. } = observation {
                let greatest = greatest.min(least + 20);
                let time = least + dice.below(greatest - least + 1);
                stepper.decide(executor, time);
            }
        }
        all.append(&mut fresh);
        for (task, since) in open.0.iter_mut().enumerate() {
            *since = (*since).max(stepper.job(task));
        }
        for (within, since) in open.1.iter_mut().enumerate() {
            *since = (*since).max(stepper.awaited(within));
        }
        stepper.possible(&mut possible);
        let now = stepper.now();
        if possible.may_wait() && (possible.actions().is_empty() || dice.in_ten(7)) {
            let Some(jump) = stepper.next_moment().filter(|_| now < END) else {
                break;
            };
            let left = u32::try_from(END - now).expect("small");
            stepper.pass(jump.min(left), &mut fresh);
            continue;
        }
        let actions = possible.actions();
        if actions.is_empty() || steps.len() > 20_000 {
            break;
        }
        let action = actions[dice.below(actions.len() as u32) as usize];
        steps.push((now, action));
        stepper.perform(action, &mut fresh);
    }
    Walk {
        steps,
        end: stepper.now(),
        seen: all,
        open,
        refused: (system.services.keys()).map(|service| stepper.has_refused(service)).collect(),
    }
}

fn compare(seed: u64) -> Option<Result<(), String>> {
    let mut dice = Dice::new(seed);
    let (system, within) = systems::random(&mut dice);
    let watched = Watched {
        reach: within.iter().flat_map(|(p, q)| [p, q]).cloned().collect(),
        within: (within.iter().cloned()).map(|(p, q)| (p, vec![q])).collect(),
        ..Watched::default()
    };
    Some(agrees(seed, &system, &watched, &mut dice))
}

/// Compares the events of walks with the interpreter.
pub(crate) fn agrees(
    seed: u64,
    system: &TimedSystem,
    watched: &Watched,
    dice: &mut Dice,
) -> Result<(), String> {
    let done = walk(system, watched, dice);
    let withins: Vec<Within> = (watched.within.iter().cloned())
        .map(|(trigger, responses)| Within { trigger, responses, limit: None })
        .collect();
    let brute = Brute { system, within: &withins, reach: &watched.reach };
    let agree = || -> Result<(), String> {
        let along = brute.along(&done.steps, done.end)?;
        let told = told(&along, &done);
        for (what, along, told) in [
            ("missed", format!("{:?}", along.missed), format!("{:?}", told.missed)),
            ("overdue", format!("{:?}", along.overdue), format!("{:?}", told.overdue)),
            ("response", format!("{:?}", along.response), format!("{:?}", told.response)),
            ("within", format!("{:?}", along.within), format!("{:?}", told.within)),
            ("reached", format!("{:?}", along.reached), format!("{:?}", told.reached)),
            ("refused", format!("{:?}", along.refused), format!("{:?}", told.refused)),
        ] {
            if along != told {
                return Err(format!("{what}: brute {along}, seen {told}"));
            }
        }
        runs_are_whole(&done.seen)
    };
    agree().map_err(|why| format!("seed {seed}: {why}\n{:?}\n{system:#?}", done.steps))
}

/// Returns the events in the form of the interpreter's results.
fn told(like: &Results, done: &Walk) -> Results {
    let mut out = Results {
        missed: vec![false; like.missed.len()],
        overdue: vec![false; like.overdue.len()],
        response: done.open.0.clone(),
        within: done.open.1.clone(),
        reached: vec![false; like.reached.len()],
        refused: done.refused.clone(),
        ..Results::default()
    };
    for observation in &done.seen {
        match *observation {
            Seen::Missed { task } => out.missed[task] = true,
            Seen::Overdue { task } => out.overdue[task] = true,
            Seen::Reached { predicate } => out.reached[predicate] = true,
            Seen::Job { task, response } => {
                out.response[task] = out.response[task].max(Some(response));
            }
            Seen::Answered { within, after } => {
                out.within[within] = out.within[within].max(Some(after));
            }
            _ => {}
        }
    }
    out
}

/// Checks that every executor asks, begins and ends in this order, with the same work.
fn runs_are_whole(seen: &[Seen]) -> Result<(), String> {
    let mut now: Vec<(u8, Option<Work>)> = Vec::new();
    for observation in seen {
        let (executor, work, stage) = match *observation {
            Seen::Asked { executor, work } => (executor, work, 1),
            Seen::Begun { executor, work, .. } => (executor, work, 2),
            Seen::Ended { executor, work, .. } => (executor, work, 0),
            _ => continue,
        };
        if now.len() <= executor {
            now.resize(executor + 1, (0, None));
        }
        let (was, of) = now[executor];
        let next = (was + 1) % 3;
        if next != stage || (stage != 1 && of != Some(work)) {
            return Err(format!("{observation:?} after stage {was} of {of:?}"));
        }
        now[executor] = (stage, Some(work));
    }
    Ok(())
}

#[test]
fn a_walk_is_a_run_of_the_system() {
    all_agree(first(), cases(), 1, compare);
}
