//! Reductions that are proved sound under the rules of the servers.
//!
//! *Independent components.* Where ports are copied, components meet only through clients and at cores. At
//! one moment it is enough to follow all actions of one *group* of components that has to act before time
//! passes: no action of other groups can prevent, enable or delay them (a persistent set). Components belong
//! to one group if a client that is not done addresses both, or if a watched property is about both. On cores
//! without preemption, actions that free a core, or let a task ask for one, are followed in every order, as
//! the order of the queue depends on them. So are the actions of a group of which a task waits for a core.
//!
//! *Deferral.* As for the published rules (see [`super::deferral`]): with least times of 0, an end that no
//! other executor waits for gains nothing before the next tick or end of a window. All that follows the end
//! can follow there, in the same order and in no time. Tickets are taken in that order, so that the queue is
//! the same, and codels begun later have wider windows. A group is *lazy* if all its codels and delays have
//! lower bound 0, no predicate is about it, and the response time of none of its aperiodic tasks is measured.
//! No end is postponed while a first cycle has a tick that is kept: the next job is measured from the end of
//! that cycle. Because of the queue for cores either all groups are lazy or, with limited cores, none is. A
//! polling loop may rest, as for the published rules, if its rounds could wake no other aperiodic task of its
//! component.
//!
//! Both are off under preemption, which lets threads wait for each other across components, and with locks on
//! ports.
//!
//! *Symmetry*, as for the published rules (see [`super::symmetry`]).
//!
//! Inside a component no reduction is used. The end of a codel leads to the ticket of the next one in the
//! lock queue of the component, and the end of an activity to a step of the control task, which examines all
//! activities. So the order of two actions of a component is nearly always visible to a third.

use rustc_hash::FxHashSet;
use smallvec::SmallVec;

use super::deferral::rest;
use super::facts::Facts;
use super::symmetry::Symmetry;
use super::{
    Activity, Deferrable, Kind, Kinds, Orbits, Reason, Reduced, Reduction, Reductions, Renaming,
    Setting, SleepSet, Watched,
};
use crate::explore::rules::servers::Servers;
use crate::explore::rules::{Action, Enabled, Rules};
use crate::explore::state::State;
use crate::explore::store::{Encoded, encode};
use crate::property::{Atom, Predicate};
use crate::scn::semantics::{PauseRule, PortRule, TickRule};
use crate::system::{ClientAction, Ticks, TimedSystem};

/// Upper limit on the states of a lazy closure. Larger closures are truncated, and fewer states are dropped.
const CLOSURE: usize = 1024;

/// The reductions for the rules of the servers.
#[derive(Debug)]
pub(crate) struct OfServers {
    symmetry: Option<Symmetry>,
    /// Orbits without symmetry.
    alone: Orbits,
    /// Groups are followed one after the other.
    apart: bool,
    activities: Vec<Activity>,
    /// Components that a watched property is about, if the property is about several components or clients.
    asked: Vec<bool>,
    /// Components that each client addresses.
    addressed: Vec<Vec<usize>>,
    /// Executors of lazy groups, by executor.
    lazy: Vec<bool>,
    /// Tasks with a polling loop that may rest, and the resting place.
    rest: Vec<(usize, usize)>,
}

/// One number for each component.
type Groups = SmallVec<[usize; 16]>;

impl OfServers {
    fn group_of(groups: &mut Groups, members: impl Iterator<Item = usize>) {
        let mut members = members;
        let Some(first) = members.next() else { return };
        for member in members {
            let (from, to) = (groups[member], groups[first]);
            groups
                .iter_mut()
                .filter(|group| **group == from)
                .for_each(|group| *group = to);
        }
    }

    /// Returns the groups of components in a state.
    fn groups(&self, rules: &Servers, s: &State) -> Groups {
        let mut groups: Groups = (0..self.asked.len()).collect();
        let asked = self.asked.iter().enumerate().filter(|pair| *pair.1);
        Self::group_of(&mut groups, asked.map(|pair| pair.0));
        for (client, addressed) in self.addressed.iter().enumerate() {
            if rules.is_active(s, client) {
                Self::group_of(&mut groups, addressed.iter().copied());
            }
        }
        groups
    }

    /// Writes the actions of a group that can be followed alone; returns true if there is one.
    fn one_group(
        &self,
        rules: &Servers,
        s: &State,
        enabled: &Enabled,
        out: &mut Vec<Action>,
    ) -> bool {
        if !self.apart || enabled.committed || enabled.is_calm() {
            return false;
        }
        let groups = self.groups(rules, s);
        // A step of a client alone, such as the end of a delay, makes a request possible at the same moment:
        // it belongs to the group that the client addresses.
        let component = |action: Action| {
            let own = rules.component_of_action(s, action);
            own.or_else(|| {
                self.addressed[rules.client_of_action(action)?]
                    .first()
                    .copied()
            })
        };
        let group = |action: Action| component(action).map(|component| groups[component]);
        let mut tried: SmallVec<[usize; 16]> = SmallVec::new();
        for &action in &enabled.actions {
            let Some(own) = group(action).filter(|group| !tried.contains(group)) else {
                continue;
            };
            tried.push(own);
            out.clear();
            out.extend(
                enabled
                    .actions
                    .iter()
                    .filter(|&&action| group(action) == Some(own)),
            );
            let acts = out.iter().any(|&action| rules.has_to_act(s, action));
            let at_cores = rules.waits_for_core(s, |component| groups[component] == own)
                || out.iter().any(|&action| rules.is_about_cores(s, action));
            if acts && !at_cores && out.len() < enabled.actions.len() {
                return true;
            }
        }
        false
    }

    /// Returns true if the ends of lazy executors can be postponed in a calm state.
    fn can_defer_ends(&self, rules: &Servers, s: &State) -> bool {
        self.lazy.contains(&true)
            && !rules.keeps_first_tick(s, |task| self.lazy[task])
            && (self.rest.iter()).all(|&(task, state)| rules.rests(s, task, state))
    }
}

impl Reduced for Servers<'_> {
    type Reductions = OfServers;
}

impl Reductions<Servers<'_>> for OfServers {
    fn new(rules: &Servers, asked: &Watched, without: Kinds) -> Self {
        let system = rules.system();
        let mut about = vec![false; system.components.len()];
        for predicate in &asked.predicates {
            mark(system, predicate, &mut about);
        }
        let addressed: Vec<Vec<usize>> = (system.clients.iter())
            .map(|client| {
                let sends = client.steps.iter().filter_map(|step| match step.action {
                    ClientAction::Send { service, .. } => Some(system.services[service].component),
                    _ => None,
                });
                sends.collect()
            })
            .collect();
        let off = |kind: Kind| without.contains(kind).then_some(Reason::SwitchedOff);
        let together = match () {
            () if system.has_builtin(|_| true) => Some(Reason::Builtins),
            () if rules.preempts() => Some(Reason::Preemption),
            () if system.platform.semantics.ports != PortRule::Copy => Some(Reason::LockedPorts),
            () => None,
        };
        let apart = together.is_none();
        let (mut lazy, rest) = match apart && off(Kind::Deferral).is_none() {
            true => lazy_groups(system, asked, &about, &addressed),
            false => (vec![false; rules.frame().executors()], Vec::new()),
        };
        if !rest.is_empty() && off(Kind::RestingLoops).is_some() {
            lazy.fill(false);
        }
        let nothing = (!lazy.contains(&true)).then_some(Reason::NothingToPutOff);
        let deferral = off(Kind::Deferral).or(together).or(nothing);
        let resting = match deferral {
            Some(_) => Some(Reason::Without(Kind::Deferral)),
            None => rest.is_empty().then_some(Reason::NothingRests),
        };
        let persistent = off(Kind::PersistentSets).or(together);
        let note = |kind, off| Activity { kind, off };
        let mut activities = vec![
            note(Kind::PersistentSets, persistent),
            note(Kind::PersistentRequests, Some(Reason::OneQueue)),
            note(Kind::SleepSets, Some(Reason::OneQueue)),
            note(Kind::Deferral, deferral),
            note(Kind::RestingLoops, off(Kind::RestingLoops).or(resting)),
        ];
        let facts = Facts::new(system, asked);
        let setting = Setting {
            rules,
            asked,
            facts: &facts,
            without,
        };
        let symmetry = Symmetry::examine(&setting, &mut activities);
        OfServers {
            alone: Orbits::none(rules),
            symmetry,
            apart: persistent.is_none(),
            activities,
            asked: about,
            addressed,
            lazy,
            rest,
        }
    }

    fn activities(&self) -> &[Activity] {
        &self.activities
    }

    fn persistent(&self, rules: &Servers, s: &State, enabled: &Enabled, out: &mut Vec<Action>) {
        if !self.one_group(rules, s, enabled, out) {
            out.clone_from(&enabled.actions);
        }
    }

    fn follow(
        &self,
        rules: &Servers,
        (s, held): (&State, SleepSet),
        enabled: &Enabled,
        first: &mut Vec<Action>,
        out: &mut Vec<(Action, SleepSet)>,
    ) {
        self.persistent(rules, s, enabled, first);
        out.clear();
        out.extend(first.iter().map(|&action| (action, held)));
        if enabled.is_calm() && self.can_defer_ends(rules, s) {
            out.retain(
                |pair| !matches!(pair.0, Action::Finish { executor, .. } if self.lazy[executor]),
            );
        }
    }

    fn sleep_set_after(
        &self,
        _: &Servers,
        _: &State,
        _: Action,
        _: &State,
        _: SleepSet,
    ) -> SleepSet {
        0
    }

    fn waiters(&self, _: &Servers, _: &State) -> Option<Deferrable> {
        None
    }

    fn closure(
        &self,
        rules: &Servers,
        s: &State,
        budget: &mut usize,
        mut found: impl FnMut(&Encoded),
    ) {
        if !self.can_defer_ends(rules, s) {
            return;
        }
        let mut seen: FxHashSet<Encoded> = FxHashSet::default();
        let mut stack = vec![s.clone()];
        let mut enabled = Enabled::default();
        let mut encoding = Encoded::default();
        while let Some(s) = stack.pop() {
            rules.enabled(&s, &mut enabled);
            *budget = budget.saturating_sub(1);
            if seen.len() > CLOSURE || *budget == 0 {
                break;
            }
            for &action in &enabled.actions {
                let follows = match action {
                    Action::Tick { .. } | Action::Mark { .. } => false,
                    Action::Release { task }
                    | Action::Grant { task }
                    | Action::Begin { task }
                    | Action::Wake { task } => self.lazy[task],
                    Action::Finish { executor, .. }
                    | Action::Acquire { executor }
                    | Action::Ticket { executor }
                    | Action::Ready { executor }
                    | Action::Preempt { executor, .. } => self.lazy[executor],
                    Action::Signal { component }
                    | Action::Reply { component }
                    | Action::Shut { component } => self.lazy[system_executor(rules, component)],
                    Action::Request { client, .. } | Action::Proceed { client, .. } => {
                        self.lazy[client_executor(rules, client)]
                    }
                };
                if !follows {
                    continue;
                }
                let mut next = s.clone();
                rules.apply(&mut next, action);
                encode(rules.frame(), &next, &mut encoding);
                if seen.insert(encoding.clone()) {
                    found(&encoding);
                    stack.push(next);
                }
            }
        }
    }

    fn order(&self, rules: &Servers, s: &mut State) -> Option<Renaming> {
        self.symmetry.as_ref()?.order(rules, s)
    }

    fn orbits(&self) -> &Orbits {
        self.symmetry.as_ref().map_or(&self.alone, Symmetry::orbits)
    }

    fn next_moment(&self, rules: &Servers, s: &State) -> Option<Ticks> {
        let can_defer_ends = self.can_defer_ends(rules, s);
        rules.next_moment(s, &|executor| can_defer_ends && self.lazy[executor])
    }
}

fn system_executor(rules: &Servers, component: usize) -> usize {
    rules.system().tasks.len() + component
}

fn client_executor(rules: &Servers, client: usize) -> usize {
    system_executor(rules, rules.system().components.len()) + client
}

/// Marks the components that a predicate is about.
fn mark(system: &TimedSystem, predicate: &Predicate, about: &mut [bool]) {
    predicate.atoms(&mut |atom| match *atom {
        Atom::Task(task, _) => about[system.tasks[task].component] = true,
        Atom::State { machine, .. } => {
            for automaton in system
                .automata
                .iter()
                .filter(|automaton| automaton.machine == machine)
            {
                about[system.tasks[automaton.task].component] = true;
            }
        }
        Atom::Slot(service, _) | Atom::Handling { service, .. } => {
            about[system.services[service].component] = true;
        }
        Atom::ControlBusy(component) => about[component] = true,
        Atom::Client(..) => about.fill(true),
    });
}

/// Returns the executors of lazy groups, and the polling loops that may rest: task and state.
fn lazy_groups(
    system: &TimedSystem,
    asked: &Watched,
    about: &[bool],
    addressed: &[Vec<usize>],
) -> (Vec<bool>, Vec<(usize, usize)>) {
    let (tasks, components) = (system.tasks.len(), system.components.len());
    let executors = tasks + components + system.clients.len();
    let none = || (vec![false; executors], Vec::new());
    let periodic = system.tasks.iter().any(|task| task.period.is_some());
    let semantics = system.platform.semantics;
    // If timers start when another task has been started, a postponed end moves all ticks.
    if !periodic || semantics.pause == PauseRule::Turns || semantics.ticks == TickRule::Task {
        return none();
    }
    let mut groups: Groups = (0..components).collect();
    for services in addressed {
        OfServers::group_of(&mut groups, services.iter().copied());
    }
    let requested = system.requested();
    let mut lazy: Vec<bool> = about.iter().map(|flag| !flag).collect();
    let mut resting = Vec::new();
    let mut owner = vec![usize::MAX; system.codels.len()];
    for automaton in &system.automata {
        for state in &system.machines[automaton.machine].states {
            owner[state.codel] = automaton.task;
        }
    }
    for (number, component) in system.components.iter().enumerate() {
        for &task in &component.tasks {
            let definition = &system.tasks[task];
            lazy[number] &= definition.period.is_some() || !asked.measured[task];
            for &a in definition.permanent.iter().chain(&definition.slots) {
                let machine = system.machine_of(a);
                let slow = |codel: usize| system.codels[codel].lower > 0;
                if !machine.states.iter().any(|state| slow(state.codel)) {
                    continue;
                }
                // The rounds of the loop are events: there must be no other task to be woken by them.
                let others = component.tasks.iter().filter(|&&other| other != task);
                let alone = others
                    .clone()
                    .all(|&task| system.tasks[task].period.is_some())
                    && definition.slots.is_empty()
                    && definition.period.is_none()
                    && machine.is_endless()
                    && !component.services.iter().any(|&service| requested[service]);
                // After all threads have begun, no executor waits for the resting codel. Before that, no end
                // is postponed.
                let unwaited = |&state: &usize| {
                    let codel = machine.states[state].codel;
                    let mut others = system.codels.iter().enumerate();
                    others.all(|(index, other)| {
                        let own = owner[index] == task || owner[index] == usize::MAX;
                        own || !other.conflicts.contains(codel)
                            || rest::start_up_only(system, index)
                    })
                };
                match rest::place(system, a, &owner).filter(|place| alone && unwaited(place)) {
                    Some(place) => resting.push((number, task, place)),
                    None => lazy[number] = false,
                }
            }
        }
        for &service in component
            .services
            .iter()
            .filter(|&&service| requested[service])
        {
            let service = &system.services[service];
            let mut codels = service.validate.iter().chain(&service.simple);
            lazy[number] &= codels.all(|&codel| system.codels[codel].lower == 0);
        }
    }
    for (client, addressed) in system.clients.iter().zip(addressed) {
        let slow =
            |action: &ClientAction| matches!(*action, ClientAction::Delay(lower, _) if lower > 0);
        if client.steps.iter().any(|step| slow(&step.action)) {
            addressed.iter().for_each(|&index| lazy[index] = false);
        }
    }
    let of_group: Vec<bool> = (0..components)
        .map(|component| {
            (0..components).all(|other| groups[other] != groups[component] || lazy[other])
        })
        .collect();
    if system.platform.cores.is_some() && of_group.contains(&false) {
        return none();
    }
    let mut out: Vec<bool> = (system.tasks.iter())
        .map(|task| of_group[task.component])
        .collect();
    out.extend(&of_group);
    let clients = addressed.iter();
    out.extend(clients.map(|client| client.iter().all(|&client| of_group[client])));
    let resting = (resting.into_iter())
        .filter(|triple| of_group[triple.0])
        .map(|(_, task, place)| (task, place))
        .collect();
    (out, resting)
}
