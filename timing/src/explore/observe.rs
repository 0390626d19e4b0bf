//! Evaluation of predicates on states, observers of bounded response, and monitors of patterns.

use super::rules::Rules;
use super::state::State;
use crate::property::{Monitor, Predicate, monitor};
use crate::system::Ticks;

/// An observer: whenever `trigger` becomes true, the `responses` are awaited in order. Each may hold at the
/// same moment as the previous one.
#[derive(Debug, Clone)]
pub(crate) struct Observer {
    pub(crate) trigger: Predicate,
    /// At least one response.
    pub(crate) responses: Vec<Predicate>,
}

/// The observers and monitors of a run.
#[derive(Debug, Clone, Default)]
pub(crate) struct Observers {
    pub(crate) responses: Vec<Observer>,
    pub(crate) monitors: Vec<Monitor>,
}

impl Observers {
    /// Returns the observers of a list of predicates, each with its responses.
    pub(crate) fn of<'p>(
        within: impl Iterator<Item = (&'p Predicate, &'p [Predicate])>,
        monitors: &[Monitor],
    ) -> Observers {
        let responses = within.map(|(trigger, responses)| Observer {
            trigger: trigger.clone(),
            responses: responses.to_vec(),
        });
        Observers { responses: responses.collect(), monitors: monitors.to_vec() }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.responses.is_empty() && self.monitors.is_empty()
    }
}

/// Evaluates a predicate in a state entered from `before` (`None`: the initial state).
pub(crate) fn predicate(
    rules: &Rules,
    before: Option<&State>,
    now: &State,
    predicate: &Predicate,
) -> bool {
    match before {
        Some(before) => {
            predicate.eval(&|a, is_now| rules.atom(if is_now { now } else { before }, a))
        }
        None => predicate.eval_still(&|a| rules.atom(now, a)),
    }
}

/// Opens and closes the obligations of observers after a step, and moves the monitors.
pub(crate) fn observe(
    rules: &Rules,
    observers: &Observers,
    before: Option<&State>,
    now: &mut State,
) {
    observe_with_reports(rules, observers, before, now, |_, _| {});
}

/// Opens and closes the obligations of observers and moves the monitors, as [`observe`] does. `met` gets the
/// observer of each obligation that is met, and the time for which the obligation was open.
///
/// Among obligations at the same stage, only the oldest is kept: the event that meets it meets the others as
/// well. An obligation at a later stage is older than one at an earlier stage, because the event that
/// advanced it would have advanced the younger one, too.
pub(crate) fn observe_with_reports(
    rules: &Rules,
    observers: &Observers,
    before: Option<&State>,
    now: &mut State,
    mut met: impl FnMut(usize, Ticks),
) {
    let l = rules.frame();
    for (i, monitor) in observers.monitors.iter().enumerate() {
        move_monitor(rules, (i, monitor), before, now);
    }
    for (i, observer) in observers.responses.iter().enumerate() {
        let stages = l.stages(i);
        // Age of the obligation that enters the stage.
        let mut coming = None;
        let triggers = !l.is_open_at(now, stages.start)
            && predicate(rules, before, now, &observer.trigger)
            && !before
                .is_some_and(|before| observer.trigger.eval_still(&|a| rules.atom(before, a)));
        if triggers {
            coming = Some(0);
        }
        for (stage, response) in stages.zip(&observer.responses) {
            let clock = l.stage_clock(stage);
            let open = l.is_open_at(now, stage);
            if !open && coming.is_none() {
                continue;
            }
            let age = match (open, clock) {
                (true, Some(clock)) => now.t[clock],
                (true, None) => 0,
                (false, _) => coming.unwrap_or(0),
            };
            let is_met = predicate(rules, before, now, response);
            coming = is_met.then_some(age);
            l.set_open_at(now, stage, !is_met);
            if let Some(clock) = clock {
                now.t[clock] = if is_met { 0 } else { age };
            }
        }
        if let Some(age) = coming {
            met(i, age);
        }
    }
}

/// Moves a monitor after a step.
fn move_monitor(
    rules: &Rules,
    (number, monitor): (usize, &Monitor),
    before: Option<&State>,
    now: &mut State,
) {
    let l = rules.frame();
    let location = l.monitor(now, number);
    let clock = l.monitor_clock(number);
    let mut left = clock.map_or(0, |clock| now.t[clock]);
    let first = &monitor.predicates[0];
    let rises = predicate(rules, before, now, first)
        && !before.is_some_and(|before| first.eval_still(&|a| rules.atom(before, a)));
    let holds = |index: usize| predicate(rules, before, now, &monitor.predicates[index]);
    let next = monitor.next(location, rises, &mut left, holds);
    // What is violated watches nothing more.
    let left = if next == monitor::VIOLATED { 0 } else { left };
    l.set_monitor(now, number, next);
    if let Some(clock) = clock {
        now.t[clock] = left;
    }
}
