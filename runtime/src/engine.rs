//! The loop of a run on the virtual clock: discrete events, waiting only for codels that hosts execute.

use dotgen_timing::explore::{Action, Possible, Seen, Stepper, Work};
use dotgen_timing::system::Ticks;

use crate::decide::Decide;
pub use crate::end::End;
use crate::ending::Ending;
use crate::live::Live;
use crate::watch::RunObserver;

/// Number of actions at one moment after which the run counts as a standstill. A system has some actions for
/// each task, codel and client.
pub(crate) const MAX_ACTIONS_AT_ONE_MOMENT: u64 = 1_000_000;

/// Number of steps between two polls for an interruption or the end of a run.
const STEPS_PER_POLL: u64 = 256;

/// Runs a system from time 0 until a time, in base units. Hosts execute the codels of `live`; `decide`
/// chooses the rest.
pub fn run(
    stepper: &mut Stepper,
    decide: &mut dyn Decide,
    until: u64,
    watch: &mut dyn RunObserver,
    mut live: Option<&mut Live<'_>>,
    interrupted: &dyn Fn() -> bool,
) -> End {
    let mut possible = Possible::default();
    let (mut outcomes, mut kept) = (Vec::new(), Vec::new());
    let mut seen = Vec::new();
    let mut works: Vec<Option<Work>> = Vec::new();
    let (mut steps, mut at_once) = (0u64, 0u64);
    stepper.begin(&mut seen);
    if let Some(live) = live.as_deref_mut()
        && !live.begin(stepper)
    {
        return End::NotStarted;
    }
    let mut ending: Option<Ending> = None;
    loop {
        if let Some(live) = live.as_deref_mut() {
            live.step(stepper, &seen);
        }
        for observation in &seen {
            note_begun(stepper, observation, &mut works, decide, watch);
            watch.on_event(stepper, observation);
        }
        if let Some(live) = live.as_deref_mut() {
            forward_violations(stepper, live, watch);
        }
        seen.clear();
        if let (Some(ending), Some(live)) = (&mut ending, live.as_deref_mut())
            && let Some(end) = ending.proceed(stepper, watch, live)
        {
            return end;
        }
        steps += 1;
        // A step that executes a codel may take long.
        let polls = live.is_some() || steps.is_multiple_of(STEPS_PER_POLL);
        let interrupt = || (polls && interrupted()).then_some(End::Interrupted);
        let mut reason = watch.is_over(stepper).or_else(interrupt);
        stepper.possible(&mut possible);
        let measure = |executor: usize| measure(&works, executor, watch);
        let (actions, begins) = allowed(possible.actions(), &measure, &mut kept);
        let waits = possible.may_wait() && !begins && (actions.is_empty() || decide.waits());
        let left = match &ending {
            Some(ending) => ending.left(stepper),
            None => until.saturating_sub(stepper.now()),
        };
        let open = |executor: usize| measure(executor) == Some(false);
        let next = stepper.next_moment_but(&open).filter(|_| waits);
        if waits && reason.is_none() {
            reason = match next {
                _ if left == 0 => Some(End::Done),
                None => Some(End::NothingLeft),
                Some(_) => None,
            };
        }
        if let Some(reason) = reason.filter(|_| ending.is_none()) {
            // Codels that were executed may have to stop something.
            let Some(live) = live.as_deref_mut() else { return reason };
            ending = Some(Ending::request(reason, stepper, live));
            continue;
        }
        if waits {
            let jump = u64::from(next.unwrap_or(Ticks::MAX)).min(left).max(1);
            stepper.pass(u32::try_from(jump).unwrap_or(u32::MAX), &mut seen);
            watch.moment(stepper);
            at_once = 0;
            continue;
        }
        at_once += 1;
        if actions.is_empty() || at_once > MAX_ACTIONS_AT_ONE_MOMENT {
            return End::Standstill;
        }
        let action = choose(actions, &works, decide, live.as_deref_mut(), &mut outcomes);
        watch.on_action(stepper, action, None);
        if let Some(live) = live.as_deref() {
            live.set_facts(action, stepper);
        }
        stepper.perform(action, &mut seen);
    }
}

/// Notes work that has begun, and draws its end unless it waits for an event.
fn note_begun(
    stepper: &mut Stepper,
    observation: &Seen,
    works: &mut Vec<Option<Work>>,
    decide: &mut dyn Decide,
    watch: &dyn RunObserver,
) {
    let Seen::Begun { executor, work, time: (least, greatest) } = *observation else {
        return;
    };
    note(works, executor, work);
    if watch.measure(&work).is_none() {
        stepper.decide(executor, decide.time(&work, least, greatest));
    }
}

/// Records the present work of an executor.
pub(crate) fn note(works: &mut Vec<Option<Work>>, executor: usize, work: Work) {
    if works.len() <= executor {
        works.resize(executor + 1, None);
    }
    works[executor] = Some(work);
}

/// Returns whether the event of a measure has come, if an executor waits for one.
fn measure(works: &[Option<Work>], executor: usize, watch: &dyn RunObserver) -> Option<bool> {
    watch.measure(works.get(executor)?.as_ref()?)
}

/// Returns the actions without those of measures whose events have not come, and whether some measure begins
/// now. `kept` is a buffer.
fn allowed<'a>(
    actions: &'a [Action],
    measure: &dyn Fn(usize) -> Option<bool>,
    kept: &'a mut Vec<Action>,
) -> (&'a [Action], bool) {
    let of = |action: &Action| match *action {
        Action::Finish { executor, .. } => measure(executor),
        _ => None,
    };
    if !actions.iter().any(|action| of(action).is_some()) {
        return (actions, false);
    }
    kept.clear();
    kept.extend(actions.iter().filter(|action| of(action) != Some(false)));
    (&kept[..], actions.iter().any(|action| of(action) == Some(true)))
}

/// Passes violations by codels and new port data to the observer.
pub(crate) fn forward_violations(
    stepper: &Stepper,
    live: &mut Live<'_>,
    watch: &mut dyn RunObserver,
) {
    for (component, port) in live.take_written() {
        watch.on_port_write(stepper, component, port);
    }
    for update in live.take_published() {
        watch.on_port_update(stepper, &update);
    }
    for violation in live.take_broken() {
        watch.on_violation(stepper, violation);
    }
}

/// Returns the executor or client of an action that chooses between several outcomes.
fn deciding_executor(action: &Action) -> Option<(u8, usize)> {
    match *action {
        Action::Finish { executor, .. } => Some((0, executor)),
        Action::Request { client, .. } => Some((1, client.into())),
        Action::Proceed { client, .. } => Some((2, client.into())),
        _ => None,
    }
}

/// Chooses first the executor or client, then its action. More possible outcomes do not make a choice more
/// likely.
pub(crate) fn choose(
    actions: &[Action],
    works: &[Option<Work>],
    decide: &mut dyn Decide,
    live: Option<&mut Live<'_>>,
    outcomes: &mut Vec<usize>,
) -> Action {
    let same = |a: &Action, b: &Action| {
        deciding_executor(a).is_some() && deciding_executor(a) == deciding_executor(b)
    };
    let groups = actions.chunk_by(same).count();
    let chosen = decide.order(groups);
    let group = actions.chunk_by(same).nth(chosen).unwrap_or(actions);
    let Some(&Action::Finish { executor, .. }) = group.first() else {
        return group[decide.order(group.len())];
    };
    let Some(work) = works.get(executor).copied().flatten() else {
        return group[decide.order(group.len())];
    };
    outcomes.clear();
    outcomes.extend(group.iter().filter_map(|action| match *action {
        Action::Finish { outcome, .. } => Some(outcome),
        _ => None,
    }));
    let executed = live.and_then(|live| live.outcome(executor, outcomes));
    let place = executed.unwrap_or_else(|| decide.outcome(&work, outcomes));
    group[place.min(group.len() - 1)]
}
