//! Evaluation of predicates on states, and observers of bounded response.

use super::rules::Rules;
use super::state::State;
use crate::property::Predicate;

/// Whenever `trigger` becomes true, `response` is awaited.
#[derive(Debug, Clone)]
pub(crate) struct Observer {
    pub(crate) trigger: Predicate,
    pub(crate) response: Predicate,
}

/// A predicate in a state entered from `before` (`None`: the initial state).
pub(crate) fn predicate<R: Rules>(
    rules: &R,
    before: Option<&State>,
    now: &State,
    it: &Predicate,
) -> bool {
    match before {
        Some(before) => it.eval(&|a, is_now| rules.atom(if is_now { now } else { before }, a)),
        None => it.eval_still(&|a| rules.atom(now, a)),
    }
}

/// Opens and closes the obligations of observers after a step.
pub(crate) fn observe<R: Rules>(
    rules: &R,
    observers: &[Observer],
    before: Option<&State>,
    now: &mut State,
) {
    let l = rules.frame();
    for (i, observer) in observers.iter().enumerate() {
        let open = l.is_open(now, i);
        let reset = |now: &mut State, value| {
            l.set_open(now, i, value);
            if let Some(clock) = l.observer_clock[i] {
                now.t[clock] = 0;
            }
        };
        if open {
            if predicate(rules, before, now, &observer.response) {
                reset(now, false);
            }
        } else if predicate(rules, before, now, &observer.trigger)
            && !before.is_some_and(|before| observer.trigger.eval_still(&|a| rules.atom(before, a)))
            && !predicate(rules, before, now, &observer.response)
        {
            reset(now, true);
        }
    }
}
