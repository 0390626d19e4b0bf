//! Evaluation of predicates on states, and observers of bounded response.

use super::rules::Rules;
use super::state::State;
use crate::property::Predicate;
use crate::system::Ticks;

/// Whenever `trigger` becomes true, the `responses` are awaited, one after the other. Each may hold at the
/// moment at which the one before does.
#[derive(Debug, Clone)]
pub(crate) struct Observer {
    pub(crate) trigger: Predicate,
    /// At least one.
    pub(crate) responses: Vec<Predicate>,
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
    observe_telling(rules, observers, before, now, |_, _| {});
}

/// The same. `met` is told the observer of each obligation that is met, and how long it was open.
///
/// Of the obligations that await the same, the oldest is kept: what meets it meets the others. One that has
/// come further is older than one that has not, as it has seen something that would have brought the other
/// further as well.
pub(crate) fn observe_telling<R: Rules>(
    rules: &R,
    observers: &[Observer],
    before: Option<&State>,
    now: &mut State,
    mut met: impl FnMut(usize, Ticks),
) {
    let l = rules.frame();
    for (i, observer) in observers.iter().enumerate() {
        let stages = l.stages(i);
        // How long the obligation has been open that comes to the stage in question.
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
