//! Resting places: states in which an endless activity waits for the outside world.
//!
//! A polling loop `poll → work → poll` whose `poll` takes at least *l* and has no upper bound is never ready
//! earlier after another round: a `poll` that has lasted longer can end whenever a later one can. So while
//! the loop rests there, rounds before the next hard moment *m* need not be followed. If the loop is back at
//! rest at *m*, it might as well have stayed: all other codels of its group have lower bound 0, and the
//! rounds only took locks that can delay no other executor before *m*. (An executor that could want these
//! locks would first have to end a codel, which is postponed as well.) If the loop is elsewhere at *m*, it
//! can go there at *m* in no time.
//!
//! The conditions are: the other states of the machine have lower bound 0; no other executor wants the locks
//! of the resting codel (after start-up); and the visits counted for a loop limit are always the same there.

use rustc_hash::FxHashSet;
use typed_index_collections::TiSlice;

use crate::system::{AutomatonId, CodelId, FOREVER, Machine, TimedSystem, Yield};

/// Upper limit on the combinations of state and visits that are examined.
const COMBINATIONS: usize = 10_000;

/// Returns the resting place of the machine of an automaton. `owner` gives the thread of each codel.
pub(super) fn place(
    system: &TimedSystem,
    automaton: AutomatonId,
    owner: &TiSlice<CodelId, usize>,
) -> Option<usize> {
    let machine = system.machine_of(automaton);
    let mut slow =
        machine.states.iter().enumerate().filter(|(_, state)| system.codels[state.codel].lower > 0);
    let (place, state) = slow.next()?;
    let codel = &system.codels[state.codel];
    let task = usize::from(system.automata[automaton].task);
    let undisturbed = codel.conflicts.iter().all(|conflict| {
        owner[conflict] == task || owner[conflict] == usize::MAX || start_up_only(system, conflict)
    });
    (slow.next().is_none()
        && codel.upper == FOREVER
        && undisturbed
        && place != machine.start
        && always_same_visits(machine, place))
    .then_some(place)
}

/// Returns true if a codel is executed only at the start of its task. Nothing is lazy before that is over.
pub(super) fn start_up_only(system: &TimedSystem, codel: CodelId) -> bool {
    let mut uses = system.automata.keys().flat_map(|a| {
        let machine = system.machine_of(a);
        let states = machine.states.iter().enumerate();
        states.filter(move |state| state.1.codel == codel).map(move |(state, _)| (a, state))
    });
    uses.all(|(a, state)| {
        let machine = system.machine_of(a);
        let mut yields = machine.states.iter().flat_map(|state| &state.yields);
        system.automata[a].service.is_none()
            && state == machine.start
            && !yields.any(|transition| matches!(*transition, Yield::Next(to) | Yield::Pause(to) if to == state))
    })
}

/// Returns true if the counted visits are the same whenever the machine enters `place`.
fn always_same_visits(machine: &Machine, place: usize) -> bool {
    let Some(limit) = machine.loop_limit else {
        return true;
    };
    let enter = |visits: &[u16], state: usize| {
        let mut visits = visits.to_vec();
        visits[state] += 1;
        (state, visits)
    };
    let fresh = vec![0; machine.states.len()];
    // The start-up codel comes before the first turn.
    let mut stack: Vec<(usize, Vec<u16>)> = machine.states[machine.start]
        .yields
        .iter()
        .filter_map(|transition| match *transition {
            Yield::Next(next) => Some(enter(&fresh, next)),
            _ => None,
        })
        .collect();
    let mut seen = FxHashSet::default();
    let mut there: Option<Vec<u16>> = None;
    while let Some((state, visits)) = stack.pop() {
        if !seen.insert((state, visits.clone())) {
            continue;
        }
        if seen.len() > COMBINATIONS {
            return false;
        }
        if state == place && *there.get_or_insert_with(|| visits.clone()) != visits {
            return false;
        }
        let yields =
            machine.states[state].yields.iter().filter_map(|transition| match *transition {
                Yield::Next(next) => Some(next),
                _ => None,
            });
        let allowed: Vec<usize> = yields.clone().filter(|&next| visits[next] < limit).collect();
        if allowed.is_empty() && machine.rounds {
            stack.extend(yields.filter(|&next| next != state).map(|next| enter(&fresh, next)));
        } else {
            stack.extend(allowed.into_iter().map(|next| enter(&visits, next)));
        }
    }
    true
}
