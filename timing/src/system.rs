//! The timed system: one or several components, a platform and clients as small integers.
//!
//! Everything the explorer needs and nothing else: tables indexed by plain numbers, times in
//! base units. It is built from specifications and a scenario by [`build`]; tests build it by
//! hand. Rules referred to as "section N" are those of the timed semantics of GenoM3 components,
//! described for users in `docs/verification.md`.

pub mod build;
pub mod built;
pub mod chain;
pub(crate) mod flow;
mod locks;
pub(crate) mod loops;
mod patience;
mod program;
pub mod settings;
pub(crate) mod units;

use dotgen_analysis::model::{CodelRef, Seconds, Src};

use crate::scn::semantics::Semantics;

pub use locks::{SharedPorts, sources};
pub use loops::{loop_contradictions, pauseless_cycles};

/// A number of base units.
pub type Ticks = u32;

/// No upper bound.
pub const FOREVER: Ticks = u32::MAX;

/// The priority of tasks that state none, where others do; that of PocoLibs servers.
const UNSTATED: u32 = 255;

/// A system of components on one platform.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimedSystem {
    /// The base unit, in seconds.
    pub unit: Seconds,
    /// Components.
    pub components: Vec<Component>,
    /// Execution tasks; those of one component are consecutive and in order of declaration.
    pub tasks: Vec<Task>,
    /// State machines of permanent activities and activities.
    pub machines: Vec<Machine>,
    /// Places where a machine is executed: one per permanent activity and one per slot.
    pub automata: Vec<Automaton>,
    /// Codels in their places of use.
    pub codels: Vec<Codel>,
    /// Services.
    pub services: Vec<Service>,
    /// Clients.
    pub clients: Vec<Client>,
    /// Cores, policies and lock order.
    pub platform: Platform,
}

/// What tasks run on and how shared things are given out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Platform {
    /// Number of cores; `None`: no limit.
    pub cores: Option<u32>,
    /// Order in which waiting tasks get cores.
    pub policy: Policy,
    /// Order in which waiting codels get locks.
    pub locks: LockOrder,
    /// What the model follows. (Its `locks` are those above.)
    pub semantics: Semantics,
    /// Asynchronous codels are executed by a separate thread and need no core.
    pub async_free: bool,
    /// Aperiodic tasks need a core.
    pub aperiodic_core: bool,
}

/// Order in which cores are granted (section 9).
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Policy {
    /// In order of release.
    Fifo,
    /// Earliest absolute deadline first, ties in order of release; never preempting.
    Edf,
    /// Any waiting task.
    Any,
    /// The ready tasks of highest priority, preempting others.
    Priority,
    /// Any ready tasks, preempting others, as long as no core idles.
    Fair,
}

/// Order in which codels that wait for a common lock get it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LockOrder {
    /// Any of them may win, also repeatedly.
    Free,
    /// In order of arrival, among codels that exclude each other.
    Fifo,
    /// One queue per component; who is behind its head waits, conflicting or not.
    Queue,
}

/// A component: its tasks are started one after the other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Component {
    /// Its name.
    pub name: String,
    /// Its tasks, in order of declaration.
    pub tasks: Vec<usize>,
    /// Its services, in order of declaration.
    pub services: Vec<usize>,
}

/// An execution task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Task {
    /// Its name, without the component.
    pub name: String,
    /// Its component.
    pub component: usize,
    /// `None`: aperiodic.
    pub period: Option<Ticks>,
    /// The first tick comes one period and this much after the timer has started.
    pub delay: Ticks,
    /// With nothing to do, keep the tick instead of dropping it (section 4).
    pub keep_idle_tick: bool,
    /// The automaton of the permanent activity (one that has a `start` codel).
    pub permanent: Option<usize>,
    /// Automata of its slots, in slot order. (Under the semantics of the servers: one per activity, whatever
    /// the number of instances.)
    pub slots: Vec<usize>,
    /// How many activities it can have at the same time, the permanent one included (servers).
    pub places: u32,
    /// Its `priority`; the lower number goes first.
    pub priority: Option<u32>,
    /// The core it is tied to, from 0.
    pub affinity: Option<u32>,
    /// Where it was declared: component of the specification and name.
    pub src: Option<(usize, Src)>,
}

/// A state machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Machine {
    /// `component.task` or `component.service`.
    pub name: String,
    /// Its states that have a codel.
    pub states: Vec<State>,
    /// Where it begins.
    pub start: usize,
    /// Where it goes when interrupted; `None`: it ends at once.
    pub stop: Option<usize>,
    /// How often one turn may enter the same state; `None`: no limit.
    pub loop_limit: Option<u16>,
    /// The limit counts rounds instead of turns, as no turn can ever end (see `system::loops`).
    pub rounds: bool,
}

impl Machine {
    /// Whether it goes on for ever, from state to state, without a pause.
    pub fn is_endless(&self) -> bool {
        let mut yields = self.states.iter().flat_map(|it| &it.yields);
        yields.all(|it| matches!(it, Yield::Next(_)))
    }
}

/// A state of a machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct State {
    /// Its name.
    pub name: String,
    /// What it executes.
    pub codel: usize,
    /// What can follow. Never empty.
    pub yields: Vec<Yield>,
    /// Declared `async`.
    pub is_async: bool,
}

/// What follows a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Yield {
    /// Another state, in the same turn.
    Next(usize),
    /// Another state, at the next turn.
    Pause(usize),
    /// The end of the activity.
    End,
}

/// One place where a machine is executed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Automaton {
    /// The task that executes it.
    pub task: usize,
    /// Its machine.
    pub machine: usize,
    /// The service, for a slot; `None` for a permanent activity.
    pub service: Option<usize>,
}

/// A codel in one place of use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Codel {
    /// `component.owner.state`, or `component.service.codel`.
    pub path: String,
    /// Its component.
    pub component: usize,
    /// Least time from getting its locks to releasing them.
    pub lower: Ticks,
    /// Greatest such time, or [`FOREVER`].
    pub upper: Ticks,
    /// Codels that must not be executing when this one begins. May hold the codel itself. Symmetric in the
    /// published models; in the servers a codel does not wait for those of an activity that interrupts its
    /// own.
    pub conflicts: CodelSet,
    /// It may throw an exception instead of each of its yields.
    pub throws: bool,
    /// Component of the specification and codel it stands for.
    pub site: Option<(usize, CodelRef)>,
    /// Where it was declared.
    pub src: Option<Src>,
}

/// A set of codels of one system.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CodelSet(Vec<u64>);

impl CodelSet {
    /// Adds one.
    pub fn insert(&mut self, codel: usize) {
        if self.0.len() <= codel / 64 {
            self.0.resize(codel / 64 + 1, 0);
        }
        self.0[codel / 64] |= 1 << (codel % 64);
    }

    /// Takes one away.
    pub fn remove(&mut self, codel: usize) {
        if let Some(word) = self.0.get_mut(codel / 64) {
            *word &= !(1 << (codel % 64));
        }
    }

    /// Whether it is there.
    #[inline]
    pub fn contains(&self, codel: usize) -> bool {
        self.0
            .get(codel / 64)
            .is_some_and(|word| word >> (codel % 64) & 1 == 1)
    }

    /// Whether the two have a member in common.
    pub fn intersects(&self, other: &CodelSet) -> bool {
        self.0
            .iter()
            .zip(&other.0)
            .any(|(one, other)| one & other != 0)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(|&word| word == 0)
    }

    /// Its members, ascending.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.0.len() * 64).filter(|&codel| self.contains(codel))
    }
}

/// A service, as the control task handles it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Service {
    /// Its name, without the component.
    pub name: String,
    /// Its component.
    pub component: usize,
    /// Codel that accepts or refuses requests.
    pub validate: Option<usize>,
    /// Codels the control task executes, in order (functions and attributes).
    pub simple: Vec<usize>,
    /// Automata of its slots; empty unless it is an activity.
    pub slots: Vec<usize>,
    /// It is an activity.
    pub activity: bool,
    /// Services it interrupts.
    pub interrupts: Vec<usize>,
    /// Services that must have succeeded before it is accepted.
    pub after: Vec<usize>,
    /// Services that must not have succeeded when it is accepted.
    pub before: Vec<usize>,
    /// It is a request that every component understands.
    pub builtin: Option<Builtin>,
    /// Where it was declared.
    pub src: Option<Src>,
}

/// A request that every component understands (section 18).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Builtin {
    /// Interrupts one instance of an activity.
    Abort,
    /// Waits until no task executes a codel.
    Connect,
    /// Ends the component.
    Kill,
}

impl Builtin {
    /// Its name in GenoM3.
    pub fn name(self) -> &'static str {
        match self {
            Builtin::Abort => "abort_activity",
            Builtin::Connect => "connect_port",
            Builtin::Kill => "kill",
        }
    }
}

/// A client: a graph of steps. Which step follows is the client's free choice.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Client {
    /// Its name.
    pub name: String,
    /// Steps.
    pub steps: Vec<ClientStep>,
    /// Possible first steps; [`Client::done`] stands for none.
    pub first: Vec<usize>,
    /// Number of requests whose end is awaited somewhere.
    pub trackers: usize,
}

impl Client {
    /// The position after the last step.
    pub fn done(&self) -> usize {
        self.steps.len()
    }

    /// Whether it matters to this client how the requests that a tracker follows end.
    pub(crate) fn asks_outcome(&self, tracker: usize) -> bool {
        let mut steps = self.steps.iter();
        steps.any(|it| matches!(it.action, ClientAction::AwaitOutcome(t, _) if t == tracker))
    }

    /// Whether it can come to a step more than once.
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

/// One step of a client.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClientStep {
    /// What is done.
    pub action: ClientAction,
    /// Possible next steps.
    pub next: Vec<usize>,
    /// Name of the step in predicates.
    pub label: Option<String>,
}

impl ClientStep {
    /// The service that is requested.
    pub fn requests(&self) -> Option<usize> {
        match self.action {
            ClientAction::Send { service, .. } => Some(service),
            _ => None,
        }
    }
}

/// What a client does in one step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ClientAction {
    /// Waits until its previous request has been accepted or refused and the control task takes this one.
    Send {
        /// The service requested.
        service: usize,
        /// Trackers that follow this request from now on.
        trackers: Vec<usize>,
        /// Trackers that follow it once it is accepted: instances that can be aborted.
        accepted: Vec<usize>,
        /// The tracker of the instance that it aborts.
        aborts: Option<usize>,
    },
    /// Waits until its last request has been accepted or refused.
    AwaitAccepted,
    /// Waits until the tracked request has ended or was refused; at once if there was none.
    AwaitEnded(usize),
    /// Waits until one of the steps that follow, all of them [`AwaitOutcome`](Self::AwaitOutcome), has
    /// nothing to wait for.
    AwaitAny,
    /// Waits until the tracked request has succeeded, or (`false`) has not.
    AwaitOutcome(usize, bool),
    /// Lets time pass.
    Delay(Ticks, Ticks),
}

impl TimedSystem {
    /// `component.task`.
    pub fn task_path(&self, task: usize) -> String {
        let task = &self.tasks[task];
        format!("{}.{}", self.components[task.component].name, task.name)
    }

    /// `component.service`.
    pub fn service_path(&self, service: usize) -> String {
        let service = &self.services[service];
        format!(
            "{}.{}",
            self.components[service.component].name, service.name
        )
    }

    /// The machine of an automaton.
    pub fn machine_of(&self, automaton: usize) -> &Machine {
        &self.machines[self.automata[automaton].machine]
    }

    /// Whether a task needs a core to run.
    pub fn needs_core(&self, task: usize) -> bool {
        self.platform.cores.is_some()
            && (self.tasks[task].period.is_some() || self.platform.aperiodic_core)
    }

    /// Whether cores are given to threads and taken away again by an operating system (section 22).
    pub(crate) fn preempts(&self) -> bool {
        let preempts = matches!(self.platform.policy, Policy::Priority | Policy::Fair);
        self.platform.cores.is_some() && preempts
    }

    /// The priority of every task, then of every control task; the lower number goes first. Where no task
    /// states one, the shorter period goes first, and what has none last.
    pub fn priorities(&self) -> Vec<u64> {
        let stated = self.tasks.iter().any(|it| it.priority.is_some());
        let of_task = |it: &Task| match stated {
            true => u64::from(it.priority.unwrap_or(UNSTATED)),
            false => it.period.map_or(u64::MAX, u64::from),
        };
        let controls = self.components.iter().map(|it| {
            let own = it.tasks.iter().map(|&task| of_task(&self.tasks[task]));
            own.min().unwrap_or(0)
        });
        self.tasks.iter().map(of_task).chain(controls).collect()
    }

    /// Whether some codel of a task is executed by a separate thread, also when its job has ended.
    pub(crate) fn runs_apart(&self, task: usize) -> bool {
        let it = &self.tasks[task];
        let mut automata = it.permanent.iter().chain(&it.slots);
        self.platform.async_free
            && automata.any(|&a| self.machine_of(a).states.iter().any(|it| it.is_async))
    }

    /// Services that some client can request. The others never run.
    pub fn requested(&self) -> Vec<bool> {
        let mut out = vec![false; self.services.len()];
        for step in self.clients.iter().flat_map(|it| &it.steps) {
            if let ClientAction::Send { service, .. } = step.action {
                out[service] = true;
            }
        }
        out
    }

    /// Codels that are executed at some time: those of permanent activities, and of services that are
    /// requested.
    pub fn executed(&self) -> Vec<bool> {
        let mut out = vec![false; self.codels.len()];
        let requested = self.requested();
        for automaton in &self.automata {
            if automaton.service.is_none_or(|it| requested[it]) {
                let states = &self.machines[automaton.machine].states;
                states.iter().for_each(|it| out[it.codel] = true);
            }
        }
        for (service, _) in self.services.iter().zip(&requested).filter(|it| *it.1) {
            let own = service.validate.iter().chain(&service.simple);
            own.for_each(|&it| out[it] = true);
        }
        out
    }

    /// Whether some component is asked for one of the requests that all understand.
    pub(crate) fn has_builtin(&self, which: impl Fn(Builtin) -> bool) -> bool {
        self.services
            .iter()
            .any(|it| it.builtin.is_some_and(&which))
    }

    /// Whether activities are requested. They have a limited number of slots, so that requests can be
    /// refused.
    pub(crate) fn may_refuse(&self) -> bool {
        let mut services = self.services.iter().zip(self.requested());
        services.any(|(it, requested)| requested && it.activity)
    }

    /// Whether some activity of a task can run, given which services are [`requested`](Self::requested).
    pub(crate) fn has_activities(&self, task: usize, requested: &[bool]) -> bool {
        let mut slots = self.tasks[task].slots.iter();
        slots.any(|&a| self.automata[a].service.is_some_and(|it| requested[it]))
    }

    /// Makes two codels exclude each other.
    pub fn exclude(&mut self, one: usize, other: usize) {
        self.codels[one].conflicts.insert(other);
        self.codels[other].conflicts.insert(one);
    }

    /// The codels of these paths do not exclude each other any more.
    pub(crate) fn separate(&mut self, one: &str, other: &str) {
        for (from, to) in [(one, other), (other, one)] {
            let to = (0..self.codels.len()).filter(|&it| self.codels[it].path == to);
            let to: Vec<usize> = to.collect();
            let from = self.codels.iter_mut().filter(|it| it.path == from);
            from.for_each(|it| to.iter().for_each(|&to| it.conflicts.remove(to)));
        }
    }
}
