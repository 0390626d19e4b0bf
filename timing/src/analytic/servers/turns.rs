//! The turns of automata, and the activities that can have turns in the same cycle.

use typed_index_collections::TiVec;

use super::Cycle;
use crate::analytic::instances::{self, Party};
use crate::analytic::situations::Situations;
use crate::analytic::ways::{Ways, resumed};
use crate::analytic::windows::stops;
use crate::system::loops::pauseless_cycles;
use crate::system::{AutomatonId, CodelId, TaskId, Ticks, TimedSystem};

/// The turns of all automata: what does not depend on a window.
pub(in crate::analytic) struct Turns<'s> {
    pub(super) system: &'s TimedSystem,
    of: TiVec<AutomatonId, OwnTurns>,
    /// By task; see [`instances::of_one_job`].
    pub(super) parties: TiVec<TaskId, Option<Vec<Party>>>,
}

/// The turns of an automaton.
struct OwnTurns {
    /// A turn may never end.
    is_endless: bool,
    /// Of its beginning.
    first: Ways,
    /// Those that a cycle can begin with, but not the beginning of a permanent activity.
    other: Ways,
    /// Those after a pause.
    later: Ways,
    /// Those after an interruption, if there can be one.
    stop: Option<Ways>,
}

impl<'s> Turns<'s> {
    pub(in crate::analytic) fn new(system: &'s TimedSystem, situations: &[Situations]) -> Self {
        let stops = stops(system, situations);
        let of = system.automata.iter_enumerated().map(|(automaton, entry)| {
            let machine = system.machine_of(automaton);
            let begins = entry.service.map(|_| machine.start);
            let stop = machine.stop.filter(|_| stops[automaton]);
            let is_limited = machine.loop_limit.is_some() && !machine.rounds;
            OwnTurns {
                is_endless: !is_limited && !pauseless_cycles(machine).is_empty(),
                first: Ways::turns(machine, [machine.start]),
                other: Ways::turns(machine, resumed(machine).chain(begins)),
                later: Ways::turns(machine, resumed(machine)),
                stop: stop.map(|stop| Ways::turns(machine, [stop])),
            }
        });
        let tasks = system.tasks.keys();
        let parties = tasks.map(|task| instances::of_one_job(system, situations, task));
        Turns { system, of: of.collect(), parties: parties.collect() }
    }

    /// Returns the state of an automaton after an interruption, if there can be one.
    pub(super) fn stop_of(&self, automaton: AutomatonId) -> Option<usize> {
        let machine = self.system.machine_of(automaton);
        machine.stop.filter(|_| self.of[automaton].stop.is_some())
    }

    /// Returns the longest time of an automaton in a cycle, with this time for each codel. An interruption
    /// can come after every codel, also after a pause; then a turn with `stop` begins.
    pub(super) fn longest(
        &self,
        automaton: AutomatonId,
        cycle: Cycle,
        time: &dyn Fn(CodelId) -> Option<Ticks>,
    ) -> Option<Ticks> {
        let machine = self.system.machine_of(automaton);
        let own = &self.of[automaton];
        let cost = |state: usize| time(machine.states[state].codel).map(u64::from);
        let length = match (cycle, &own.stop) {
            (Cycle::FirstPass, _) => return time(machine.states[machine.start].codel),
            (Cycle::First | Cycle::StartUp, _) => own.first.costliest(&cost)?,
            (Cycle::Other, None) => own.other.costliest(&cost)?,
            (Cycle::Other, Some(stop)) => {
                own.other.costliest(&cost)?.checked_add(stop.costliest(&cost)?)?
            }
        };
        Ticks::try_from(length).ok().filter(|_| !own.is_endless)
    }

    /// Returns the longest time of an activity in a cycle in which it does not begin: none without a pause.
    pub(super) fn later(
        &self,
        automaton: AutomatonId,
        time: &dyn Fn(CodelId) -> Option<Ticks>,
    ) -> Option<Ticks> {
        let machine = self.system.machine_of(automaton);
        if resumed(machine).next().is_none() {
            return Some(0);
        }
        let own = &self.of[automaton];
        let cost = |state: usize| time(machine.states[state].codel).map(u64::from);
        let stop = own.stop.as_ref().map_or(Some(0), |stop| stop.costliest(&cost));
        let length = own.later.costliest(&cost)?.checked_add(stop?)?;
        Ticks::try_from(length).ok().filter(|_| !own.is_endless)
    }
}
