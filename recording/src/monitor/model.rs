//! Queries of log lines to the verified system.

use dotgen_analysis::model::Owner;
use dotgen_timing::scn::names::Names;
use dotgen_timing::system::{
    CodelId, ComponentId, FOREVER, MachineId, Policy, Service, ServiceId, TaskId, Ticks,
    TimedSystem, Yield,
};
use num_rational::Ratio;
use rustc_hash::FxHashMap;

use super::UntakenTransition;
use crate::log::LineKind;
use crate::matching::{Mismatch, event, site};

/// The verified system. See the [module](self).
#[derive(Debug)]
pub(super) struct Model<'s> {
    pub(super) system: &'s TimedSystem,
    names: &'s Names<'s>,
    bounds: Vec<Option<Ticks>>,
    /// Every codel of the specifications has an execution time.
    timed: bool,
    /// No codel has an execution time.
    untimed: bool,
    preempts: bool,
    /// Priorities, by task.
    priorities: Vec<u64>,
}

/// The subject of a kind of lines.
#[derive(Debug, Clone, Copy)]
pub(super) enum ResolvedKind {
    Mismatch(Mismatch),
    State(StateOutcome),
    Control {
        codel: CodelId,
        component: ComponentId,
        service: ServiceId,
        instance: u32,
        /// The event after the run is declared.
        declared: bool,
    },
}

/// A state of a machine, and the outcome of its codel.
#[derive(Debug, Clone, Copy)]
pub(super) struct StateOutcome {
    pub(super) instance: u32,
    pub(super) task: usize,
    pub(super) machine: MachineId,
    pub(super) permanent: bool,
    pub(super) state: usize,
    pub(super) start: usize,
    pub(super) stop: Option<usize>,
    pub(super) codel: CodelId,
    pub(super) is_async: bool,
    pub(super) to: CodelOutcome,
    /// Next state, and whether it belongs to the next turn.
    pub(super) next: Option<(usize, bool)>,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum CodelOutcome {
    /// One of its yields.
    Outcome(usize),
    /// An exception that it may throw.
    Exception,
    /// An undeclared event.
    Undeclared,
}

/// The times of a task, in nanoseconds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub(super) period: Option<i64>,
    pub(super) bound: Option<i64>,
    /// Greatest time from a tick to the beginning of its turn, if no tick is lost.
    pub(super) latest: Option<i64>,
}

/// Returns true if threads are preempted while they execute.
pub(super) fn preempts(system: &TimedSystem) -> bool {
    let platform = &system.platform;
    platform.cores.is_some() && matches!(platform.policy, Policy::Priority | Policy::Fair)
}

impl<'s> Model<'s> {
    pub(super) fn new(
        system: &'s TimedSystem,
        names: &'s Names<'s>,
        bounds: Vec<Option<Ticks>>,
    ) -> Self {
        Model {
            timed: (system.codels.iter()).all(|codel| codel.upper > 0 || codel.site.is_none()),
            untimed: system.codels.iter().all(|codel| codel.upper == 0),
            preempts: preempts(system),
            priorities: system.priorities(),
            system,
            names,
            bounds,
        }
    }

    fn nanos(&self, ticks: Ticks) -> i64 {
        let nanos = self.system.unit * Ratio::from_integer(i128::from(ticks) * 1_000_000_000);
        i64::try_from(nanos.round().to_integer()).unwrap_or(i64::MAX)
    }

    pub(super) fn of_task(&self, task: usize) -> Limits {
        let period = self.system.tasks.get(TaskId::from(task)).and_then(|task| task.period);
        let period = period.map(|period| self.nanos(period));
        let known = self.bounds.get(task).copied().flatten();
        let known = known.map(|bound| self.nanos(bound));
        // If codels have no times, no bound is meaningful. A job is assumed to end within its period.
        let latest = match (known, period) {
            (Some(bound), Some(period)) if bound <= period && self.timed => Some(bound),
            (Some(bound), Some(period)) if bound <= period => Some(period),
            _ if self.untimed => period,
            // Ticks can be lost, and turns can be arbitrarily late.
            _ => None,
        };
        Limits { period, bound: known.filter(|_| self.timed), latest }
    }

    /// Returns the least and greatest time of a codel in nanoseconds, if its runs show them.
    pub(super) fn limits(&self, codel: CodelId) -> (Option<i64>, Option<i64>) {
        let Some(definition) = self.system.codels.get(codel).filter(|_| !self.preempts) else {
            return (None, None);
        };
        (Some(self.nanos(definition.lower)), self.declared(codel))
    }

    /// Returns the greatest time of a codel in nanoseconds, if it has one.
    pub(super) fn declared(&self, codel: CodelId) -> Option<i64> {
        let codel = self.system.codels.get(codel)?;
        (codel.upper != FOREVER && codel.upper > 0).then(|| self.nanos(codel.upper))
    }

    pub(super) fn path(&self, codel: CodelId) -> String {
        let codel = self.system.codels.get(codel);
        codel.map_or(String::new(), |codel| codel.path.to_string())
    }

    pub(super) fn last_name(&self, codel: CodelId) -> String {
        let codel = self.system.codels.get(codel);
        codel.map_or(String::new(), |codel| codel.path.own().to_owned())
    }

    pub(super) fn state_name(&self, machine: MachineId, state: usize) -> String {
        let machine = self.system.machines.get(machine);
        let state = machine.and_then(|machine| machine.states.get(state));
        state.map_or(String::new(), |state| state.name.clone())
    }

    /// Returns the thread of a task; `None` for an asynchronous codel with a thread of its own.
    pub(super) fn thread(&self, task: usize, is_async: bool) -> Option<usize> {
        (!(is_async && self.system.platform.async_free)).then_some(task)
    }

    /// Returns the thread of the control task of a component.
    pub(super) fn control(&self, component: ComponentId) -> Option<usize> {
        Some(self.system.tasks.len() + usize::from(component))
    }

    pub(super) fn core(&self, task: usize, is_async: bool) -> Option<Option<u32>> {
        let own = is_async && self.system.platform.async_free;
        let needs = !own && !self.preempts && self.system.needs_core(TaskId::from(task));
        needs.then(|| self.system.tasks.get(TaskId::from(task)).and_then(|task| task.affinity))
    }

    /// If threads with priorities are preempted, returns the core to which a task is bound, and its priority.
    pub(super) fn core_and_priority(&self, task: usize, is_async: bool) -> Option<(u32, u64)> {
        let own = is_async && self.system.platform.async_free;
        let priorities = self.preempts && self.system.platform.policy == Policy::Priority;
        let core = self.system.tasks.get(TaskId::from(task))?.affinity;
        let core = core.filter(|_| priorities && !own)?;
        Some((core, self.priorities.get(task).copied()?))
    }

    pub(super) fn resolve(&self, kind: &LineKind, instance: u32) -> ResolvedKind {
        let site = match site(self.names, kind) {
            Ok(site) => site,
            Err(Mismatch::NoCodel) => return self.attribute(kind, instance),
            Err(stray) => return ResolvedKind::Mismatch(stray),
        };
        let none = ResolvedKind::Mismatch(Mismatch::State);
        let Some(member) = self.names.components.get(site.component) else {
            return none;
        };
        let components = &self.system.components;
        let named = components
            .iter_enumerated()
            .find(|(_, component)| member.component.name == component.name);
        let Some((component, parts)) = named else {
            return ResolvedKind::Mismatch(Mismatch::Component);
        };
        if let Some(state) = &site.state {
            let (automaton, permanent) = match site.codel.owner {
                Owner::Task(task) => {
                    let task = parts.tasks.get(usize::from(task));
                    let task = task.and_then(|&task| self.system.tasks.get(task));
                    (task.and_then(|task| task.permanent), true)
                }
                Owner::Service(service) => {
                    let service = parts.services.get(usize::from(service));
                    let service = service.and_then(|&service| self.system.services.get(service));
                    (service.and_then(|service| service.slots.first().copied()), false)
                }
            };
            let automaton = automaton.and_then(|automaton| self.system.automata.get(automaton));
            let Some(automaton) = automaton else {
                return none;
            };
            let at = self.at(usize::from(automaton.task), automaton.machine, state, kind);
            at.map_or(none, |at| ResolvedKind::State(StateOutcome { instance, permanent, ..at }))
        } else {
            let Owner::Service(service) = site.codel.owner else {
                return none;
            };
            let service = parts.services.get(usize::from(service));
            let Some(&number) = service else { return none };
            let Some(service) = self.system.services.get(number) else { return none };
            let mut all = service.validate.iter().chain(&service.simple).copied();
            let is = |index: &CodelId| {
                let codel = self.system.codels.get(*index);
                codel.is_some_and(|codel| codel.site.is_some_and(|other| other.1 == site.codel))
            };
            let Some(codel) = all.find(is) else {
                return none;
            };
            ResolvedKind::Control {
                codel,
                component,
                service: number,
                instance,
                declared: kind.to == "::genom::ok" || self.throws(codel, &kind.to),
            }
        }
    }

    /// Looks up a service without a codel: the model has one in its place.
    fn attribute(&self, kind: &LineKind, instance: u32) -> ResolvedKind {
        let found = self.system.services.iter_enumerated().find(|(_, service)| {
            let component = self.system.components.get(service.component);
            let named = component.is_some_and(|of| of.name == kind.instance);
            named && service.name == kind.service
        });
        match found.and_then(|(number, service)| Some((number, service, *service.simple.first()?)))
        {
            Some((service, Service { component, .. }, codel)) => {
                let component = *component;
                ResolvedKind::Control { codel, component, service, instance, declared: true }
            }
            None => ResolvedKind::Mismatch(Mismatch::NoCodel),
        }
    }

    fn at(
        &self,
        task: usize,
        number: MachineId,
        state: &str,
        kind: &LineKind,
    ) -> Option<StateOutcome> {
        let machine = self.system.machines.get(number)?;
        let place = machine.states.iter().position(|candidate| candidate.name == state)?;
        let of = machine.states.get(place)?;
        let to = event(&kind.to);
        let is = |transition: &Yield| match *transition {
            Yield::Next(next) | Yield::Pause(next) => {
                let paused = matches!(transition, Yield::Pause(_));
                let name = machine.states.get(next).map(|state| state.name.as_str());
                paused == to.paused && name == Some(to.name)
            }
            Yield::End => !to.paused && to.name == "ether",
        };
        let outcome = of.yields.iter().position(is);
        let led = match outcome {
            Some(outcome) => CodelOutcome::Outcome(outcome),
            None if self.throws(of.codel, &kind.to) => CodelOutcome::Exception,
            None => CodelOutcome::Undeclared,
        };
        // The next state is expected, declared or not.
        let next = machine.states.iter().position(|state| state.name == to.name);
        let next = next.filter(|_| !matches!(led, CodelOutcome::Exception));
        Some(StateOutcome {
            instance: 0,
            task,
            machine: number,
            permanent: false,
            state: place,
            start: machine.start,
            stop: machine.stop,
            codel: of.codel,
            is_async: of.is_async,
            to: led,
            next: next.map(|state| (state, to.paused)),
        })
    }

    /// Returns true if an event can be an exception of a codel. Every server can throw exceptions of `genom`.
    fn throws(&self, codel: CodelId, to: &str) -> bool {
        let Some(codel) = self.system.codels.get(codel) else {
            return false;
        };
        if to.starts_with("::genom::") && to != "::genom::ok" {
            return true;
        }
        let Some((component, of)) = codel.site else {
            return false;
        };
        let Some(member) = self.names.components.get(component) else {
            return false;
        };
        let (own, task) = match of.owner {
            Owner::Task(task) => (None, Some(task)),
            Owner::Service(service) => {
                let service = member.component.services.get(service);
                (service, service.and_then(|service| service.task))
            }
        };
        let task = task.and_then(|task| member.component.tasks.get(task));
        let all = member.component.throws.iter();
        let all = all.chain(own.iter().flat_map(|service| &service.throws));
        let mut all = all.chain(task.iter().flat_map(|task| &task.throws));
        all.any(|&exception| member.spec.full_name(exception).as_deref() == Some(to))
    }

    /// Returns the codels in their states, and those of control tasks.
    pub(super) fn codels_of_threads(&self) -> impl Iterator<Item = CodelId> + '_ {
        let machines = self.system.automata.iter();
        let machines = machines.filter_map(|machine| self.system.machines.get(machine.machine));
        let states = machines.flat_map(|machine| machine.states.iter().map(|state| state.codel));
        let services = self.system.services.iter();
        let services =
            services.flat_map(|service| service.validate.iter().chain(&service.simple).copied());
        let real = |index: &CodelId| {
            self.system.codels.get(*index).is_some_and(|codel| codel.site.is_some())
        };
        states.chain(services).filter(real)
    }

    /// Returns the transitions that were not taken.
    pub(super) fn untaken_transitions(
        &self,
        taken: &FxHashMap<(MachineId, usize, usize), u64>,
    ) -> Vec<UntakenTransition> {
        let mut out = Vec::new();
        for automaton in &self.system.automata {
            let number = automaton.machine;
            let Some(machine) = self.system.machines.get(number) else {
                continue;
            };
            for (state, entry) in machine.states.iter().enumerate() {
                for (outcome, to) in entry.yields.iter().enumerate() {
                    if taken.contains_key(&(number, state, outcome)) {
                        continue;
                    }
                    let to = match *to {
                        Yield::Next(to) => self.state_name(number, to),
                        Yield::Pause(to) => format!("pause::{}", self.state_name(number, to)),
                        Yield::End => "ether".to_owned(),
                    };
                    out.push(UntakenTransition {
                        machine: machine.name.clone(),
                        from: entry.name.clone(),
                        to,
                    });
                }
            }
        }
        out.sort();
        out.dedup();
        out
    }
}
