//! Independent components: persistent sets of systems with passes.
//!
//! Where ports are copied, components meet only through clients and at cores. So at one moment all actions
//! of one *group* of components that has to act before time passes are a persistent set: no action of
//! other groups can prevent, enable or delay them. Components belong to one group if a
//! client that is not done addresses both, or if a watched property is about both. On cores without
//! preemption, actions that free a core, or let a task ask for one, are followed in every order, as the
//! order of the queue depends on them. So are the actions of a group of which a task waits for a core.
//!
//! The reduction is off under preemption, which lets threads wait for each other across components, and with
//! locks on ports.
//!
//! Inside a component no reduction is used. The end of a codel leads to the ticket of the next one in the
//! lock queue of the component, and the end of an activity to a step of the control task, which examines
//! all activities. So the order of two actions of a component is nearly always visible to a third.

use smallvec::SmallVec;
use typed_index_collections::{TiSlice, TiVec, ti_vec};

use super::{Kind, Reason, Reduction, Setting, Watched};
use crate::explore::rules::{Action, Enabled, Rules};
use crate::explore::state::State;
use crate::property::{Atom, Predicate};
use crate::scn::semantics::PortRule;
use crate::system::{ClientAction, ClientId, ComponentId, TimedSystem};

/// The components of a system, and what connects them.
#[derive(Debug)]
pub(crate) struct Components {
    /// Components that a watched property is about, if the property is about several components or clients.
    asked: TiVec<ComponentId, bool>,
    /// Components that each client addresses.
    addressed: TiVec<ClientId, Vec<ComponentId>>,
}

/// Groups of components: one number for each component.
pub(super) struct Groups(SmallVec<[usize; 16]>);

impl Groups {
    /// Returns as many groups as components.
    pub(super) fn new(components: usize) -> Self {
        Groups((0..components).collect())
    }

    /// Returns the group of a component.
    pub(super) fn of(&self, component: ComponentId) -> usize {
        self.0[usize::from(component)]
    }

    /// Puts components into one group.
    pub(super) fn join(&mut self, mut members: impl Iterator<Item = ComponentId>) {
        let Some(first) = members.next() else { return };
        for member in members {
            let (from, to) = (self.of(member), self.of(first));
            let moved = self.0.iter_mut().filter(|group| **group == from);
            moved.for_each(|group| *group = to);
        }
    }
}

impl Reduction for Components {
    const KIND: Kind = Kind::PersistentSets;

    fn applies(setting: &Setting) -> Result<Self, Reason> {
        independent(setting)?;
        let system = setting.system();
        Ok(Components { asked: asked(system, setting.asked), addressed: addressed(system) })
    }
}

impl Components {
    /// Writes the actions of a group that can be followed alone, or all enabled actions.
    pub(super) fn select(
        &self,
        rules: &Rules,
        s: &State,
        enabled: &Enabled,
        out: &mut Vec<Action>,
    ) {
        if !self.one_group(rules, s, enabled, out) {
            out.clone_from(&enabled.actions);
        }
    }

    /// Returns the groups of components in a state.
    fn groups(&self, rules: &Rules, s: &State) -> Groups {
        let mut groups = Groups::new(self.asked.len());
        let asked = self.asked.iter_enumerated().filter(|(_, asked)| **asked);
        groups.join(asked.map(|(component, _)| component));
        for (client, addressed) in self.addressed.iter_enumerated() {
            if rules.is_active(s, client) {
                groups.join(addressed.iter().copied());
            }
        }
        groups
    }

    /// Writes the actions of a group that can be followed alone; returns true if there is one.
    fn one_group(
        &self,
        rules: &Rules,
        s: &State,
        enabled: &Enabled,
        out: &mut Vec<Action>,
    ) -> bool {
        if enabled.committed || enabled.is_calm() {
            return false;
        }
        let groups = self.groups(rules, s);
        // A step of a client alone, such as the end of a delay, makes a request possible at the same moment:
        // it belongs to the group that the client addresses.
        let component = |action: Action| {
            let own = rules.component_of_action(s, action);
            own.or_else(|| self.addressed[rules.client_of_action(action)?].first().copied())
        };
        let group = |action: Action| component(action).map(|component| groups.of(component));
        let mut tried: SmallVec<[usize; 16]> = SmallVec::new();
        for &action in &enabled.actions {
            let Some(own) = group(action).filter(|group| !tried.contains(group)) else {
                continue;
            };
            tried.push(own);
            out.clear();
            out.extend(enabled.actions.iter().filter(|&&action| group(action) == Some(own)));
            let acts = out.iter().any(|&action| rules.has_to_act(s, action));
            let at_cores = rules.waits_for_core(s, |component| groups.of(component) == own)
                || out.iter().any(|&action| rules.is_about_cores(s, action));
            if acts && !at_cores && out.len() < enabled.actions.len() {
                return true;
            }
        }
        false
    }
}

/// Returns the reason why components are not independent of each other.
pub(super) fn independent(setting: &Setting) -> Result<(), Reason> {
    let system = setting.system();
    if system.has_builtin(|_| true) {
        Err(Reason::Builtins)
    } else if setting.rules.preempts() {
        Err(Reason::Preemption)
    } else if system.platform.semantics.ports != PortRule::Copy {
        Err(Reason::LockedPorts)
    } else {
        Ok(())
    }
}

/// Returns the components that each client addresses.
pub(super) fn addressed(system: &TimedSystem) -> TiVec<ClientId, Vec<ComponentId>> {
    let component = |action: &ClientAction| match *action {
        ClientAction::Send { service, .. } => Some(system.services[service].component),
        _ => None,
    };
    let clients = system.clients.iter();
    let of_client = clients.map(|client| client.steps.iter());
    of_client.map(|steps| steps.filter_map(|step| component(&step.action)).collect()).collect()
}

/// Returns, by component, whether a predicate is about it.
pub(super) fn asked(system: &TimedSystem, asked: &Watched) -> TiVec<ComponentId, bool> {
    let mut about = ti_vec![false; system.components.len()];
    for predicate in &asked.predicates {
        mark(system, predicate, &mut about);
    }
    about
}

fn mark(system: &TimedSystem, predicate: &Predicate, about: &mut TiSlice<ComponentId, bool>) {
    predicate.atoms(&mut |atom| match *atom {
        Atom::Task(task, _) | Atom::Tick(task) => about[system.tasks[task].component] = true,
        Atom::State { machine, .. } => {
            for automaton in system.automata.iter().filter(|automaton| automaton.machine == machine)
            {
                about[system.tasks[automaton.task].component] = true;
            }
        }
        Atom::Slot(service, _) | Atom::Handling { service, .. } => {
            about[system.services[service].component] = true;
        }
        Atom::ControlBusy(component) => about[component] = true,
        Atom::Client(..) => about.fill(true),
        // The predicates of the monitor are asked as well.
        Atom::Data { .. } | Atom::Violated(_) => {}
    });
}
