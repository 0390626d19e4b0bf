//! Lazy groups with passes.
//!
//! Tickets are taken in the order of the postponed ends, so that the queue is the same. A group of
//! components is *lazy* if all its codels and delays have lower bound 0, no predicate is about it, and
//! the response time of none of its aperiodic tasks is measured. No end is postponed while a first cycle
//! has a tick that is kept: the next job is measured from the end of that cycle. Because of the queue for
//! cores either all groups are lazy or, with limited cores, none is. A polling loop may rest if its
//! rounds could wake no other aperiodic task of its component.
//!
//! The reduction is off where components are not independent, see [`components`].

use smallvec::SmallVec;
use typed_index_collections::{TiVec, ti_vec};

use super::rest;
use crate::explore::reductions::components::{self, Groups};
use crate::explore::reductions::{Deferrable, Kind, Reason, Setting, Watched};
use crate::explore::rules::Rules;
use crate::explore::state::State;
use crate::scn::semantics::{PauseRule, TickRule};
use crate::system::{ClientAction, CodelId, ComponentId, TimedSystem};

/// The lazy groups of components.
#[derive(Debug)]
pub(crate) struct LazyComponents {
    /// Executors of lazy groups, by executor.
    lazy: SmallVec<[bool; 24]>,
    /// Tasks with a polling loop that may rest, and the resting place.
    pub(super) rest: Vec<(usize, usize)>,
}

impl LazyComponents {
    /// Returns the lazy groups of a system, or the reason why there are none.
    pub(super) fn of(setting: &Setting) -> Result<Self, Reason> {
        components::independent(setting)?;
        let (lazy, rest) = lazy_groups(setting.system(), setting.asked);
        let without_rest = setting.without.contains(Kind::RestingLoops) && !rest.is_empty();
        if without_rest || !lazy.contains(&true) {
            return Err(Reason::NothingToPutOff);
        }
        Ok(LazyComponents { lazy: SmallVec::from_vec(lazy), rest })
    }

    /// Returns the executors whose ends can be postponed in a calm state, if there are any.
    pub(super) fn waiters(&self, rules: &Rules, s: &State) -> Option<Deferrable> {
        let can_defer_ends = !rules.keeps_first_tick(s, |task| self.lazy[task])
            && (self.rest.iter()).all(|&(task, state)| rules.rests(s, task, state));
        can_defer_ends.then(|| Deferrable { members: self.lazy.clone(), automata: false })
    }
}

/// Returns the executors of lazy groups, and the polling loops that may rest: task and state.
fn lazy_groups(system: &TimedSystem, asked: &Watched) -> (Vec<bool>, Vec<(usize, usize)>) {
    let addressed = components::addressed(system);
    let about = components::asked(system, asked);
    let (tasks, components) = (system.tasks.len(), system.components.len());
    let executors = tasks + components + system.clients.len();
    let none = || (vec![false; executors], Vec::new());
    let periodic = system.tasks.iter().any(|task| task.period.is_some());
    let semantics = system.platform.semantics;
    // If timers start when another task has been started, a postponed end moves all ticks.
    if !periodic || semantics.pause == PauseRule::Turns || semantics.ticks == TickRule::Task {
        return none();
    }
    let mut groups = Groups::new(components);
    for components in &addressed {
        groups.join(components.iter().copied());
    }
    let requested = system.requested();
    let mut lazy: TiVec<ComponentId, bool> = about.iter().map(|about| !about).collect();
    let mut resting = Vec::new();
    let mut owner = ti_vec![usize::MAX; system.codels.len()];
    for automaton in &system.automata {
        for state in &system.machines[automaton.machine].states {
            owner[state.codel] = usize::from(automaton.task);
        }
    }
    for (number, component) in system.components.iter_enumerated() {
        for &task in &component.tasks {
            let definition = &system.tasks[task];
            lazy[number] &= definition.period.is_some() || !asked.measured[usize::from(task)];
            for &a in definition.permanent.iter().chain(&definition.slots) {
                let machine = system.machine_of(a);
                let slow = |codel: CodelId| system.codels[codel].lower > 0;
                if !machine.states.iter().any(|state| slow(state.codel)) {
                    continue;
                }
                // The rounds of the loop are events: there must be no other task to be woken by them.
                let others = component.tasks.iter().filter(|&&other| other != task);
                let alone = others.clone().all(|&task| system.tasks[task].period.is_some())
                    && definition.slots.is_empty()
                    && definition.period.is_none()
                    && machine.is_endless()
                    && !component.services.iter().any(|&service| requested[service]);
                // After all threads have begun, no executor waits for the resting codel. Before that, no end
                // is postponed.
                let unwaited = |&state: &usize| {
                    let codel = machine.states[state].codel;
                    let mut others = system.codels.iter_enumerated();
                    others.all(|(index, other)| {
                        let own = owner[index] == usize::from(task) || owner[index] == usize::MAX;
                        own || !other.conflicts.contains(codel)
                            || rest::start_up_only(system, index)
                    })
                };
                match rest::place(system, a, &owner).filter(|place| alone && unwaited(place)) {
                    Some(place) => resting.push((number, usize::from(task), place)),
                    None => lazy[number] = false,
                }
            }
        }
        for &service in component.services.iter().filter(|&&service| requested[service]) {
            let service = &system.services[service];
            let mut codels = service.validate.iter().chain(&service.simple);
            lazy[number] &= codels.all(|&codel| system.codels[codel].lower == 0);
        }
    }
    for (client, addressed) in system.clients.iter().zip(&addressed) {
        let slow =
            |action: &ClientAction| matches!(*action, ClientAction::Delay(lower, _) if lower > 0);
        if client.steps.iter().any(|step| slow(&step.action)) {
            for &index in addressed {
                lazy[index] = false;
            }
        }
    }
    let of_group: TiVec<ComponentId, bool> = (lazy.keys())
        .map(|component| {
            (lazy.iter_enumerated())
                .all(|(other, lazy)| groups.of(other) != groups.of(component) || *lazy)
        })
        .collect();
    if system.platform.cores.is_some() && of_group.contains(&false) {
        return none();
    }
    let mut out: Vec<bool> = (system.tasks.iter()).map(|task| of_group[task.component]).collect();
    out.extend(&of_group);
    let clients = addressed.iter();
    out.extend(clients.map(|client| client.iter().all(|&client| of_group[client])));
    let resting = (resting.into_iter())
        .filter(|(component, ..)| of_group[*component])
        .map(|(_, task, place)| (task, place))
        .collect();
    (out, resting)
}
