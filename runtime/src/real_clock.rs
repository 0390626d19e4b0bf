//! The loop of a run on the real clock.
//!
//! The rules decide which actions are possible, as on the virtual clock. But the hosts provide the time, and
//! a codel ends when its execution ends. The model is never ahead of the clock. If it is late, it goes
//! through every moment that it has missed.

use std::collections::VecDeque;

use dotgen_timing::explore::{Action, Possible, Seen, Stepper, Work};
use dotgen_timing::system::Ticks;

use crate::decide::Decide;
use crate::ending::Ending;
use crate::engine::{self, End, MAX_ACTIONS_AT_ONE_MOMENT};
use crate::hosts::Message;
use crate::live::Live;
use crate::model_time::ModelTime;
use crate::watch::RunObserver;

/// The conversion of the clock to base units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pace {
    /// Nanoseconds per base unit.
    pub nanos: u64,
}

/// Longest wait for an event, in nanoseconds. An interruption is noticed within this time.
const MAX_WAIT_NANOS: u64 = 50_000_000;

/// Number of messages that are received before the model proceeds.
const MAX_MESSAGES_AT_ONCE: usize = 1_000;

/// Time for which the model may stay behind the ticks of delegated tasks, in nanoseconds: their threads need
/// no engine, and report once per cycle.
const FOLLOW_NANOS: u64 = 1_000_000;

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
    let mut clock = Clock::start(live, pace);
    live.permit_delegations(clock.time);
    let mut ending: Option<Ending> = None;
    loop {
        live.step(stepper, &seen);
        for observation in &seen {
            note_begun(stepper, observation, &mut works, decide, live, watch);
            watch.on_event(stepper, observation);
        }
        seen.clear();
        clock.deliver(stepper, live);
        live.accept(stepper, &mut told);
        live.abort(stepper, &mut |stepper, place| watch.interrupt(stepper, place));
        let late = live.note_late();
        engine::forward_violations(stepper, live, watch);
        // A run that is always late must end as well.
        let interrupt = || interrupted().then_some(End::Interrupted);
        let reason = watch.is_over(stepper).or_else(interrupt);
        if let (None, Some(reason)) = (&ending, reason) {
            ending = Some(Ending::request(reason, stepper, live));
        }
        if let Some(end) = ending.as_mut().and_then(|end| end.proceed(stepper, watch, live)) {
            return end;
        }
        stepper.possible(&mut possible);
        allowed.clear();
        let actions = possible.actions().iter().copied();
        allowed.extend(actions.filter(|action| may_happen(action, &works, live, watch)));
        put_ticks_before_ends(&mut allowed, live);
        let drawn = possible.may_wait() && only_preemptions(&allowed);
        if !(allowed.is_empty() || drawn && decide.waits()) {
            at_once += 1;
            if at_once > MAX_ACTIONS_AT_ONE_MOMENT {
                return End::Standstill;
            }
            let action = engine::choose(&allowed, &works, decide, Some(live), &mut outcomes);
            watch.on_action(stepper, action, live.executed(action));
            live.set_facts(action, stepper);
            stepper.perform(action, &mut seen);
            continue;
        }
        let left = match &ending {
            Some(ending) => ending.left(stepper),
            None => until.saturating_sub(stepper.now()),
        };
        if left == 0 {
            ending.get_or_insert_with(|| Ending::request(End::Done, stepper, live));
            continue;
        }
        live.delegate(stepper);
        let passed = clock.wait(stepper, live, &works, watch, (left, late));
        if passed > 0 {
            at_once = 0;
            stepper.pass(passed, &mut seen);
            watch.moment(stepper);
        }
    }
}

/// The clock of the hosts, and the messages that the model has not reached yet.
struct Clock {
    time: ModelTime,
    /// Messages with their times, in base units.
    messages: VecDeque<(u64, Message)>,
}

impl Clock {
    fn start(live: &mut Live<'_>, pace: Pace) -> Clock {
        Clock { time: ModelTime::new(live.hosts().now(), pace.nanos), messages: VecDeque::new() }
    }

    /// Returns the time in base units.
    fn now(&self, live: &mut Live<'_>) -> u64 {
        self.time.ticks(live.hosts().now())
    }

    /// Passes on the messages whose time the model has reached.
    fn deliver(&mut self, stepper: &Stepper, live: &mut Live<'_>) {
        let now = stepper.now();
        while let Some((_, message)) = self.messages.pop_front_if(|(time, _)| *time <= now) {
            live.message(message);
        }
        live.deliver(now);
    }

    /// Receives the messages that have arrived, so that time never passes them. If the model has reached the
    /// present time, waits for the next event, until `late` in nanoseconds: the thread yields the processor.
    /// Returns the time that passes in the model, in base units.
    fn wait(
        &mut self,
        stepper: &Stepper,
        live: &mut Live<'_>,
        works: &[Option<Work>],
        watch: &dyn RunObserver,
        (left, late): (u64, Option<u64>),
    ) -> Ticks {
        for _ in 0..MAX_MESSAGES_AT_ONCE {
            let Some(message) = live.hosts().wait(0) else {
                break;
            };
            self.receive(message, live);
        }
        let open = |executor: usize| {
            let work = works.get(executor).copied().flatten();
            live.is_running(executor)
                || work.is_some_and(|work| {
                    live.is_outside(&work) || watch.measure(&work) == Some(false)
                })
        };
        let is_delegated = |task: usize| live.is_delegated(task.into());
        let next = stepper.next_moment_but(&open);
        let own = stepper.next_moment_without_ticks(&open, &is_delegated);
        let first = self.messages.front();
        let message = first.map(|(time, _)| time.saturating_sub(stepper.now()));
        let events = [message, live.next_result(), Some(left)];
        let event = events.into_iter().flatten().min().unwrap_or(left);
        let due = next.map_or(event, |next| event.min(next.into()));
        let own = own.map_or(event, |own| event.min(own.into()));
        // One reading decides whether time passes or the thread waits.
        let now = live.hosts().now();
        let most = live.hold(stepper, now);
        let most = most.map_or(due, |hold| due.min(hold.into()));
        let passed = self.time.ticks(now).saturating_sub(stepper.now()).min(most);
        if passed > 0 && passed == most || due == 0 {
            return Ticks::try_from(passed).unwrap_or(Ticks::MAX);
        }
        let at = |after: u64| self.time.nanos(stepper.now().saturating_add(after));
        let until = at(own).min(at(due).saturating_add(FOLLOW_NANOS));
        let longest = if live.probe_long(now, FOLLOW_NANOS) {
            now.saturating_add(FOLLOW_NANOS)
        } else {
            now.saturating_add(MAX_WAIT_NANOS)
        };
        // If the time is over, the model waits for the report of a thread.
        let until = if until > now { until.min(longest) } else { longest };
        let until = late.map_or(until, |late| until.min(late.max(now)));
        if let Some(message) = live.hosts().wait(until) {
            self.receive(message, live);
            return 0;
        }
        let passed = self.now(live).saturating_sub(stepper.now()).min(most);
        Ticks::try_from(passed).unwrap_or(Ticks::MAX)
    }

    /// Passes on reports of delegated tasks, which have times of their own, and keeps other messages until
    /// the model reaches the present time.
    fn receive(&mut self, message: Message, live: &mut Live<'_>) {
        if let Message::Lost { component, .. } = message {
            live.expect_loss(component);
        }
        let is_report = match &message {
            Message::CodelResult(_, ran) => live.is_delegated_executor(ran.ticket as usize),
            Message::Recalled { .. } | Message::Probed { .. } => true,
            _ => false,
        };
        if is_report {
            live.message(message);
        } else {
            self.messages.push_back((self.now(live), message));
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
    watch: &dyn RunObserver,
) {
    let Seen::Begun { executor, work, time: (least, greatest) } = *observation else {
        return;
    };
    engine::note(works, executor, work);
    // The end of real work, and requests from outside, come from the hosts.
    let waits_for_event = live.is_outside(&work) || watch.measure(&work).is_some();
    if !live.is_running(executor) && !waits_for_event {
        stepper.decide(executor, decide.time(&work, least, greatest));
    }
}

/// If ticks are possible, removes the ends of codels of delegated tasks: their threads count a tick at the
/// end of a cycle as a tick during it.
fn put_ticks_before_ends(allowed: &mut Vec<Action>, live: &Live<'_>) {
    if !allowed.iter().any(|action| matches!(action, Action::Tick { .. })) {
        return;
    }
    allowed.retain(|action| match *action {
        Action::Finish { executor, .. } => !live.is_delegated_executor(executor),
        _ => true,
    });
}

/// Returns true under `fair` if all possible actions take a core from a thread.
fn only_preemptions(actions: &[Action]) -> bool {
    actions.iter().all(|action| matches!(action, Action::Preempt { .. }))
}

/// Returns true if the host has reported the event of a possible action: the end of real work, or a request
/// from outside.
fn may_happen(
    action: &Action,
    works: &[Option<Work>],
    live: &Live<'_>,
    watch: &dyn RunObserver,
) -> bool {
    let Action::Finish { executor, outcome } = *action else {
        return true;
    };
    if live.is_running(executor) {
        return false;
    }
    match works.get(executor).copied().flatten() {
        Some(work @ Work::Delay { client }) => {
            watch.measure(&work).unwrap_or_else(|| live.may_proceed(client, outcome))
        }
        _ => true,
    }
}
