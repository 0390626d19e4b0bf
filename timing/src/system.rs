//! The timed system: components, a platform and clients as small integers.
//!
//! It holds only the data that the explorer needs: tables, and times in base units. Components, state
//! machines, their instances, services, codels, clients and tasks have index types of their own
//! ([`ComponentId`], [`MachineId`], [`AutomatonId`], [`ServiceId`], [`CodelId`], [`ClientId`], [`TaskId`]).
//! [`build`] makes it from specifications and a scenario; tests make it by hand. "Section N" refers to the
//! timed semantics of GenoM3 components, described for users in `docs/verification.md`.

pub mod build;
pub mod chain;
pub mod data;
pub(crate) mod flow;
pub mod ground;
mod ids;
pub mod indexed;
mod locks;
pub(crate) mod loops;
mod name;
pub mod settings;
pub(crate) mod units;
mod waiting_clients;

use dotgen_analysis::model::{CodelRef, Seconds, Src};
use typed_index_collections::{TiSlice, TiVec, ti_vec};

use crate::scn::semantics::Semantics;

pub use crate::scn::semantics::Policy;
pub use ids::{AutomatonId, ClientId, CodelId, ComponentId, MachineId, ServiceId, TaskId};
pub use locks::{SharedPorts, sources};
pub use loops::{loop_contradictions, pauseless_cycles, unfolded};
pub use name::{CodelName, ThreadName};

/// A number of base units.
pub type Ticks = u32;

/// The absence of an upper bound.
pub const FOREVER: Ticks = u32::MAX;

/// The priority of tasks that state none, if other tasks state one. PocoLibs servers use the same value.
const UNSTATED: u32 = 255;

/// A system of components on one platform.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimedSystem {
    /// The base unit, in seconds.
    pub unit: Seconds,
    pub components: TiVec<ComponentId, Component>,
    /// Execution tasks. Those of one component are consecutive, in order of declaration.
    pub tasks: TiVec<TaskId, Task>,
    /// State machines of permanent activities and activities.
    pub machines: TiVec<MachineId, Machine>,
    /// The instances of machines: one per permanent activity and one per slot.
    pub automata: TiVec<AutomatonId, Automaton>,
    /// Codels, one for each place of use.
    pub codels: TiVec<CodelId, Codel>,
    pub services: TiVec<ServiceId, Service>,
    pub clients: TiVec<ClientId, Client>,
    /// Cores, policies and lock order.
    pub platform: Platform,
}

/// The cores and locks, and the rules by which they are granted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Platform {
    /// Number of cores; `None`: no limit.
    pub cores: Option<u32>,
    /// Order in which waiting tasks get cores.
    pub policy: Policy,
    /// The semantics of the model, with the order in which waiting codels get locks.
    pub semantics: Semantics,
    /// Asynchronous codels are executed by a separate thread and need no core.
    pub async_free: bool,
    /// Aperiodic tasks need a core.
    pub aperiodic_core: bool,
}

/// A component. Its tasks are started one after the other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Component {
    pub name: String,
    /// Tasks, in order of declaration.
    pub tasks: Vec<TaskId>,
    /// Services, in order of declaration.
    pub services: Vec<ServiceId>,
}

/// An execution task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Task {
    /// Name, without the component.
    pub name: String,
    pub component: ComponentId,
    /// Period, in base units; `None` if the task is aperiodic.
    pub period: Option<Ticks>,
    /// Offset, in base units: the first tick comes one period and this offset after the start of the timer.
    pub delay: Ticks,
    /// Without work, the task keeps the tick instead of dropping it (section 4).
    pub keep_idle_tick: bool,
    /// The automaton of the permanent activity (one that has a `start` codel).
    pub permanent: Option<AutomatonId>,
    /// Automata of the slots, in slot order. Under the semantics of the servers there is one automaton per
    /// activity, whatever the number of instances.
    pub slots: Vec<AutomatonId>,
    /// Number of activities that can run at the same time, including the permanent one (servers).
    pub places: u32,
    /// The `priority`; the lower number goes first.
    pub priority: Option<u32>,
    /// The core that the task is bound to, counted from 0.
    pub affinity: Option<u32>,
    /// The declaration: component of the specification, and name.
    pub src: Option<(usize, Src)>,
}

/// A state machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Machine {
    /// `component.task` or `component.service`.
    pub name: String,
    /// States that have a codel.
    pub states: Vec<State>,
    /// Initial state.
    pub start: usize,
    /// State after an interruption; `None` if the machine ends at once.
    pub stop: Option<usize>,
    /// Number of times that one turn may enter the same state; `None`: no limit.
    pub loop_limit: Option<u16>,
    /// The limit counts rounds instead of turns, because no turn can ever end (see `system::loops`).
    pub rounds: bool,
}

impl Machine {
    /// Returns true if the machine runs for ever, from state to state, without a pause.
    pub(crate) fn is_endless(&self) -> bool {
        let mut yields = self.states.iter().flat_map(|state| &state.yields);
        yields.all(|state| matches!(state, Yield::Next(_)))
    }
}

/// A state of a machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct State {
    pub name: String,
    /// Codel that it executes.
    pub codel: CodelId,
    /// Possible successors. Never empty.
    pub yields: Vec<Yield>,
    /// Declared `async`.
    pub is_async: bool,
}

/// The successor of a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Yield {
    /// Another state, in the same turn.
    Next(usize),
    /// Another state, at the next turn.
    Pause(usize),
    /// The end of the activity.
    End,
}

/// One instance of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Automaton {
    /// Task that executes it.
    pub task: TaskId,
    pub machine: MachineId,
    /// Service of the slot; `None` for a permanent activity.
    pub service: Option<ServiceId>,
}

/// A codel in one place of use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Codel {
    /// Name, with its component and owner.
    pub path: CodelName,
    pub component: ComponentId,
    /// Least time from the grant of its locks to their release, in base units.
    pub lower: Ticks,
    /// Greatest time from the grant of its locks to their release, in base units, or [`FOREVER`].
    pub upper: Ticks,
    /// Codels that must not be executing when this codel begins, possibly itself. Symmetric in the published
    /// models. In the servers, a codel does not wait for codels of an activity that interrupts its own
    /// activity.
    pub conflicts: CodelSet,
    /// The codel may throw an exception instead of each of its yields.
    pub throws: bool,
    /// Component of the specification, and codel there.
    pub site: Option<(usize, CodelRef)>,
    /// Place of its declaration.
    pub src: Option<Src>,
}

/// A set of codels of one system.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CodelSet(Vec<u64>);

impl CodelSet {
    /// Returns the index of the word that holds the bit of a codel, and this bit.
    #[inline]
    fn place(codel: CodelId) -> (usize, u64) {
        let index = usize::from(codel);
        (index / 64, 1 << (index % 64))
    }

    /// Adds a codel.
    pub fn insert(&mut self, codel: CodelId) {
        let (word, bit) = CodelSet::place(codel);
        if self.0.len() <= word {
            self.0.resize(word + 1, 0);
        }
        self.0[word] |= bit;
    }

    pub fn remove(&mut self, codel: CodelId) {
        let (word, bit) = CodelSet::place(codel);
        if let Some(word) = self.0.get_mut(word) {
            *word &= !bit;
        }
    }

    /// Returns true if the set contains a codel.
    #[inline]
    pub fn contains(&self, codel: CodelId) -> bool {
        let (word, bit) = CodelSet::place(codel);
        self.0.get(word).is_some_and(|word| word & bit != 0)
    }

    /// Returns true if the two sets have a codel in common.
    pub(crate) fn intersects(&self, other: &CodelSet) -> bool {
        self.0.iter().zip(&other.0).any(|(one, other)| one & other != 0)
    }

    /// Returns true if the set is empty.
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(|&word| word == 0)
    }

    /// Returns the codels, in ascending order.
    pub fn iter(&self) -> impl Iterator<Item = CodelId> + '_ {
        let codels = (0..self.0.len() * 64).map(CodelId::from);
        codels.filter(|&codel| self.contains(codel))
    }
}

/// A service, in the view of the control task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Service {
    /// Name, without the component.
    pub name: String,
    pub component: ComponentId,
    /// Codel that accepts or refuses requests.
    pub validate: Option<CodelId>,
    /// Codels that the control task executes, in order (functions and attributes).
    pub simple: Vec<CodelId>,
    /// Automata of the slots; empty unless the service is an activity.
    pub slots: Vec<AutomatonId>,
    /// The service is an activity.
    pub activity: bool,
    pub interrupts: Vec<ServiceId>,
    /// Services that must have succeeded before the service is accepted.
    pub after: Vec<ServiceId>,
    /// Services that must not have succeeded when the service is accepted.
    pub before: Vec<ServiceId>,
    /// The request that every component accepts, if the service is one.
    pub builtin: Option<Builtin>,
    /// Place of its declaration.
    pub src: Option<Src>,
}

/// A request that every component accepts (section 18).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Builtin {
    /// Interrupts one instance of an activity.
    Abort,
    /// Waits until no task executes a codel.
    Connect,
    /// Ends the component.
    Kill,
    /// Interrupts all instances of an activity, for a measure: [`Service::interrupts`] has it.
    Interrupt,
}

impl Builtin {
    /// Returns its name in GenoM3.
    pub fn name(self) -> &'static str {
        match self {
            Builtin::Abort | Builtin::Interrupt => "abort_activity",
            Builtin::Connect => "connect_port",
            Builtin::Kill => "kill",
        }
    }
}

/// A client: a graph of steps. The client chooses freely between the next steps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Client {
    pub name: String,
    pub steps: Vec<ClientStep>,
    /// Possible first steps; [`Client::done`] stands for none.
    pub first: Vec<usize>,
    /// Number of requests whose end some step awaits.
    pub trackers: usize,
    /// The step of a measure that waits for its event.
    pub awaits_event: Option<usize>,
}

impl Client {
    /// Returns the position after the last step.
    pub fn done(&self) -> usize {
        self.steps.len()
    }

    /// Returns true if the client depends on whether the requests of a tracker succeed.
    pub fn asks_outcome(&self, tracker: usize) -> bool {
        let mut steps = self.steps.iter();
        steps.any(|step| matches!(step.action, ClientAction::AwaitOutcome(t, _) if t == tracker))
    }

    /// Returns the steps that can follow a step with a label, [`Self::done`] included.
    pub(crate) fn after(&self, label: &str) -> Vec<usize> {
        let labelled = self.steps.iter().filter(|step| step.label.as_deref() == Some(label));
        let mut stack: Vec<usize> = labelled.flat_map(|step| step.next.iter().copied()).collect();
        let mut reached = vec![false; self.steps.len() + 1];
        while let Some(at) = stack.pop() {
            if !std::mem::replace(&mut reached[at], true) {
                stack.extend(self.steps.get(at).iter().flat_map(|step| &step.next));
            }
        }
        (0..reached.len()).filter(|&at| reached[at]).collect()
    }

    /// Returns true if the client can reach a step more than once.
    pub(crate) fn comes_again(&self, step: usize) -> bool {
        let mut seen = vec![false; self.steps.len()];
        let mut stack = self.steps[step].next.clone();
        while let Some(at) = stack.pop() {
            if at == step {
                return true;
            }
            if at < seen.len() && !std::mem::replace(&mut seen[at], true) {
                stack.extend(&self.steps[at].next);
            }
        }
        false
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClientStep {
    pub action: ClientAction,
    /// Possible next steps.
    pub next: Vec<usize>,
    /// Name of the step in predicates.
    pub label: Option<String>,
}

impl ClientStep {
    /// Returns the service that the step requests.
    pub fn requests(&self) -> Option<ServiceId> {
        match self.action {
            ClientAction::Send { service, .. } => Some(service),
            _ => None,
        }
    }
}

/// The action of a client in one step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ClientAction {
    /// Waits until the previous request has been accepted or refused, and the control task takes this
    /// request.
    Send {
        /// The service requested.
        service: ServiceId,
        /// Trackers that follow this request from then on.
        trackers: Vec<usize>,
        /// Trackers that follow the request after its acceptance: instances that can be aborted.
        accepted: Vec<usize>,
        /// Tracker of the instance that the request aborts.
        aborts: Option<usize>,
    },
    /// Waits until the last request has been accepted or refused.
    AwaitAccepted,
    /// Waits until the tracked request has ended or was refused. Without a request, it does not wait.
    AwaitEnded(usize),
    /// Waits until one of the next steps can proceed. All of them are [`AwaitOutcome`](Self::AwaitOutcome).
    AwaitAny,
    /// Waits until the tracked request has succeeded (`true`) or has failed (`false`).
    AwaitOutcome(usize, bool),
    /// Lets time pass: at least and at most this long, in base units.
    Delay(Ticks, Ticks),
}

impl TimedSystem {
    /// Converts a time in base units.
    pub fn seconds(&self, ticks: impl Into<i128>) -> Seconds {
        self.unit * Seconds::from_integer(ticks.into())
    }

    /// Returns the first tick of a task with a period, under the semantics of the servers.
    pub fn first_tick(&self, task: TaskId) -> Option<u64> {
        let task = &self.tasks[task];
        Some(u64::from(if task.delay == 0 { task.period? } else { task.delay }))
    }

    /// Returns `component.task`.
    pub fn task_path(&self, task: TaskId) -> String {
        self.task_name(task).to_string()
    }

    /// Returns the name of a task, with its component.
    pub fn task_name(&self, task: TaskId) -> ThreadName {
        let task = &self.tasks[task];
        ThreadName::of_task(&self.components[task.component].name, &task.name)
    }

    /// Returns `component.service`.
    pub fn service_path(&self, service: ServiceId) -> String {
        let service = &self.services[service];
        format!("{}.{}", self.components[service.component].name, service.name)
    }

    pub fn machine_of(&self, automaton: AutomatonId) -> &Machine {
        &self.machines[self.automata[automaton].machine]
    }

    /// Returns true if a task needs a core to run.
    pub fn needs_core(&self, task: TaskId) -> bool {
        self.platform.cores.is_some()
            && (self.tasks[task].period.is_some() || self.platform.aperiodic_core)
    }

    /// Returns true if an operating system grants cores to threads and preempts them (section 22).
    pub fn preempts(&self) -> bool {
        let preempts = matches!(self.platform.policy, Policy::Priority | Policy::Fair);
        self.platform.cores.is_some() && preempts
    }

    /// Returns the priority of every task, then of every control task; the lower number goes first. If no
    /// task states one, the task with the shorter period goes first, and tasks without a period go last.
    pub fn priorities(&self) -> Vec<u64> {
        let stated = self.tasks.iter().any(|task| task.priority.is_some());
        let of_task = |task: &Task| {
            if stated {
                u64::from(task.priority.unwrap_or(UNSTATED))
            } else {
                task.period.map_or(u64::MAX, u64::from)
            }
        };
        let controls = self.components.iter().map(|component| {
            let own = component.tasks.iter().map(|&task| of_task(&self.tasks[task]));
            own.min().unwrap_or(0)
        });
        self.tasks.iter().map(of_task).chain(controls).collect()
    }

    /// Returns true if a separate thread executes some codel of a task, possibly after the end of its job.
    pub(crate) fn runs_apart(&self, task: TaskId) -> bool {
        let task = &self.tasks[task];
        let mut automata = task.permanent.iter().chain(&task.slots);
        self.platform.async_free
            && automata.any(|&a| self.machine_of(a).states.iter().any(|state| state.is_async))
    }

    /// Returns the greatest number of activities of a task at the same time, including the permanent one: at
    /// most its places, and at most the requests.
    pub fn most_places(&self, task: TaskId) -> usize {
        let places = self.tasks[task].places as usize;
        let of_task = |service: ServiceId| {
            let mut slots = self.services[service].slots.iter();
            slots.any(|&automaton| self.automata[automaton].task == task)
        };
        let mut most = 1;
        for client in &self.clients {
            for (at, step) in client.steps.iter().enumerate() {
                let ClientAction::Send { service, .. } = step.action else {
                    continue;
                };
                if of_task(service) {
                    if client.comes_again(at) {
                        return places;
                    }
                    most += 1;
                }
            }
        }
        most.min(places)
    }

    /// Returns, by service, whether some client can request it. Other services never run.
    pub fn requested(&self) -> TiVec<ServiceId, bool> {
        let mut out = ti_vec![false; self.services.len()];
        for step in self.clients.iter().flat_map(|client| &client.steps) {
            if let ClientAction::Send { service, .. } = step.action {
                out[service] = true;
            }
        }
        out
    }

    /// Returns, by codel, whether it can run: as part of a permanent activity or of a service that is
    /// requested.
    pub fn executed(&self) -> TiVec<CodelId, bool> {
        let mut out = ti_vec![false; self.codels.len()];
        let requested = self.requested();
        for automaton in &self.automata {
            if automaton.service.is_none_or(|service| requested[service]) {
                let states = &self.machines[automaton.machine].states;
                for state in states {
                    out[state.codel] = true;
                }
            }
        }
        for (service, _) in self.services.iter().zip(&requested).filter(|(_, asked)| **asked) {
            let own = service.validate.iter().chain(&service.simple);
            own.for_each(|&validate| out[validate] = true);
        }
        out
    }

    /// Returns true if a client makes one of these requests that every component accepts.
    pub(crate) fn has_builtin(&self, which: impl Fn(Builtin) -> bool) -> bool {
        self.services.iter().any(|service| service.builtin.is_some_and(&which))
    }

    /// Returns true if clients request activities. Slots of activities are limited, so that their requests
    /// can be refused.
    pub(crate) fn may_refuse(&self) -> bool {
        let mut services = self.services.iter().zip(self.requested());
        services.any(|(service, requested)| requested && service.activity)
    }

    /// Returns true if some activity of a task can run, given the [`requested`](Self::requested) services.
    pub(crate) fn has_activities(
        &self,
        task: TaskId,
        requested: &TiSlice<ServiceId, bool>,
    ) -> bool {
        let mut slots = self.tasks[task].slots.iter();
        slots.any(|&a| self.automata[a].service.is_some_and(|service| requested[service]))
    }

    /// Makes two codels exclude each other.
    pub fn exclude(&mut self, one: CodelId, other: CodelId) {
        self.codels[one].conflicts.insert(other);
        self.codels[other].conflicts.insert(one);
    }

    /// Ends the mutual exclusion of the codels with these names.
    pub(crate) fn separate(&mut self, one: &CodelName, other: &CodelName) {
        for (from, to) in [(one, other), (other, one)] {
            let all = self.codels.iter_enumerated();
            let to = all.filter(|(_, codel)| codel.path == *to);
            let to: Vec<CodelId> = to.map(|(id, _)| id).collect();
            let from = self.codels.iter_mut().filter(|codel| codel.path == *from);
            from.for_each(|codel| to.iter().for_each(|&to| codel.conflicts.remove(to)));
        }
    }
}
