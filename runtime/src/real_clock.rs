//! The loop of a run on the real clock.
//!
//! The rules decide which actions are possible, as on the virtual clock. But the hosts provide the time, and
//! a codel ends when its execution ends. The model is never ahead of the clock. If it is late, it goes
//! through every moment that it has missed.

use dotgen_timing::explore::{Action, Possible, Seen, Stepper, Work};

use crate::decide::Decide;
use crate::engine::{self, End, MAX_ACTIONS_AT_ONE_MOMENT};
use crate::hosts::Message;
use crate::live::Live;
use crate::watch::RunObserver;

/// The conversion of the clock to base units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pace {
    /// Nanoseconds per base unit.
    pub nanos: u64,
}

/// Longest wait for an event, in nanoseconds. An interruption is noticed within this time.
const MAX_WAIT_NANOS: u64 = 50_000_000;

/// Runs a system from time 0 until a time, in base units.
pub fn run(
    stepper: &mut Stepper,
    decide: &mut dyn Decide,
    until: u64,
    watch: &mut dyn RunObserver,
    live: &mut Live<'_>,
    pace: Pace,
    interrupted: &dyn Fn() -> bool,
) -> End {
    let mut possible = Possible::default();
    let (mut allowed, mut outcomes, mut told) = (Vec::new(), Vec::new(), Vec::new());
    let mut seen = Vec::new();
    let mut works: Vec<Option<Work>> = Vec::new();
    let mut at_once = 0u64;
    stepper.begin(&mut seen);
    if !live.begin(stepper) {
        return End::NotStarted;
    }
    let start = live.hosts().now();
    let ticks = |nanos: u64| nanos.saturating_sub(start) / pace.nanos.max(1);
    loop {
        live.step(stepper, &seen);
        for observation in &seen {
            note_begun(stepper, observation, &mut works, decide, live);
            watch.on_event(stepper, observation);
        }
        seen.clear();
        live.accept(stepper, &mut told);
        live.abort(stepper, &mut |stepper, place| {
            watch.interrupt(stepper, place)
        });
        engine::forward_violations(stepper, live, watch);
        if watch.is_over() {
            return End::Stopped;
        }
        stepper.possible(&mut possible);
        allowed.clear();
        let actions = possible.actions().iter().copied();
        allowed.extend(actions.filter(|action| may_happen(action, &works, live)));
        let drawn = possible.may_wait() && only_preemptions(&allowed);
        if !(allowed.is_empty() || drawn && decide.waits()) {
            at_once += 1;
            if at_once > MAX_ACTIONS_AT_ONE_MOMENT {
                return End::Standstill;
            }
            let action = engine::choose(&allowed, &works, decide, Some(live), &mut outcomes);
            watch.on_action(stepper, action);
            stepper.perform(action, &mut seen);
            continue;
        }
        // A run that is always late must end as well.
        if interrupted() {
            return End::Interrupted;
        }
        let left = until.saturating_sub(stepper.now());
        if left == 0 {
            return End::Done;
        }
        let open = |executor: usize| {
            let work = works.get(executor).copied().flatten();
            live.is_running(executor) || work.is_some_and(|work| live.is_outside(&work))
        };
        let next = stepper.next_moment_but(&open);
        let due = next.map_or(u64::MAX, u64::from).min(left);
        let now = ticks(live.hosts().now());
        let late = now.saturating_sub(stepper.now()) >= due;
        let deadline = stepper.now().saturating_add(due);
        let deadline = start.saturating_add(deadline.saturating_mul(pace.nanos));
        let message = next_message(live, deadline, late);
        let now = ticks(live.hosts().now());
        let passed = now.saturating_sub(stepper.now()).min(due);
        if passed > 0 {
            at_once = 0;
            stepper.pass(u32::try_from(passed).unwrap_or(u32::MAX), &mut seen);
            watch.moment(stepper);
        }
        if let Some(message) = message {
            live.message(message);
        }
    }
}

/// Notes work that has begun, and draws its end unless a host decides it.
fn note_begun(
    stepper: &mut Stepper,
    observation: &Seen,
    works: &mut Vec<Option<Work>>,
    decide: &mut dyn Decide,
    live: &Live<'_>,
) {
    let Seen::Begun {
        executor,
        work,
        time: (least, greatest),
    } = *observation
    else {
        return;
    };
    engine::note(works, executor, work);
    // The end of real work, and requests from outside, come from the hosts.
    if !live.is_running(executor) && !live.is_outside(&work) {
        stepper.decide(executor, decide.time(&work, least, greatest));
    }
}

/// Returns the next message of the hosts until a deadline, in nanoseconds. Messages that have already arrived
/// come first: time never passes them. Without a message and without due actions (`late`), the thread waits
/// and yields the processor.
fn next_message(live: &mut Live<'_>, deadline: u64, late: bool) -> Option<Message> {
    match live.hosts().wait(0) {
        None if !late => {
            let until = live.hosts().now().saturating_add(MAX_WAIT_NANOS);
            live.hosts().wait(deadline.min(until))
        }
        other => other,
    }
}

/// Returns true under `fair` if all possible actions take a core from a thread.
fn only_preemptions(actions: &[Action]) -> bool {
    actions
        .iter()
        .all(|action| matches!(action, Action::Preempt { .. }))
}

/// Returns true if the host has reported the event of a possible action: the end of real work, or a request
/// from outside.
fn may_happen(action: &Action, works: &[Option<Work>], live: &Live<'_>) -> bool {
    let Action::Finish { executor, outcome } = *action else {
        return true;
    };
    if live.is_running(executor) {
        return false;
    }
    match works.get(executor).copied().flatten() {
        Some(Work::Delay { client }) => live.may_proceed(client, outcome),
        _ => true,
    }
}
