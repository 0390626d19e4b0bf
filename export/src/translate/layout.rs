//! The integers and clocks of a network, and their names.

use std::collections::BTreeMap;

use dotgen_analysis::model::Seconds;
use dotgen_timing::explore::Action;
use dotgen_timing::report::TimeUnit;
use dotgen_timing::scn::semantics::Cycle;
use dotgen_timing::system::indexed::Built;
use dotgen_timing::system::{
    AutomatonId, ClientAction, ClientId, ClientStep, CodelId, ComponentId, FOREVER, Machine,
    Policy, ServiceId, TaskId, Ticks, TimedSystem, Yield,
};
use dotgen_timing::verify::Prepared;

use super::Place;
use super::unique::Unique;
use crate::model::{Guard, Term, all, any, var};

/// Values of the status of an activity.
pub(super) mod status {
    pub(crate) const FREE: usize = 0;
    pub(crate) const ACCEPTED: usize = 1;
    pub(crate) const RUNS: usize = 2;
    pub(crate) const STOPS: usize = 3;
    pub(crate) const ENDED: usize = 4;
    /// No activity, but the end of the places of a task.
    pub(crate) const LAST: usize = 5;
}

/// Values of the position of a task.
pub(super) mod position {
    pub(crate) const IDLE: usize = 1;
    pub(crate) const WAITS: usize = 2;
    pub(crate) const CYCLE: usize = 3;
}

/// Values of the step of a control task.
pub(super) mod step {
    pub(crate) const READY: usize = 1;
    pub(crate) const CODELS: usize = 2;
    pub(crate) const REPLIES: usize = 3;
}

/// Values of what a client follows. Places begin at `PLACE`.
pub(super) mod tracked {
    pub(crate) const NOTHING: usize = 0;
    pub(crate) const HANDLED: usize = 1;
    /// The request has ended without success; only if the client depends on the outcome.
    pub(crate) const FAILED: usize = 2;
    pub(crate) const PLACE: usize = 3;
}

/// The names of the parts of a system.
pub(super) struct Layout<'s> {
    pub(super) system: &'s TimedSystem,
    /// The system whose loops are not unfolded.
    original: &'s TimedSystem,
    place: &'s Place<'s>,
    /// The published models: see [`jobs`](super::jobs).
    pub(super) jobs: bool,
    pub(super) parts: Vec<Part>,
    /// By codel, the names of its executors: one at most, but for jobs.
    executors: Vec<Vec<String>>,
    /// By automaton, the name of its process; with jobs only.
    automata: Vec<String>,
    /// By client, and by service.
    clients: Vec<String>,
    services: Vec<String>,
    /// Channels of requests.
    requests: BTreeMap<(ClientId, ServiceId), String>,
    /// Sentences about parts with another name than in the system.
    pub(super) renamed: Vec<String>,
}

/// A component.
pub(super) struct Part {
    pub(super) id: ComponentId,
    pub(super) name: String,
    pub(super) tasks: Vec<TaskPart>,
    pub(super) kinds: Vec<Kind>,
    /// Number of places of activities with the marks of their ends.
    pub(super) size: usize,
    /// Number of the first place among those of all components.
    pub(super) offset: usize,
    /// Clients request services.
    pub(super) control: bool,
    /// Clients request activities.
    pub(super) activities: bool,
    /// Codels wait for each other.
    pub(super) queue: bool,
    /// Services that clients request, with their codels in order.
    pub(super) services: Vec<(ServiceId, Vec<CodelId>)>,
}

/// A task.
pub(super) struct TaskPart {
    pub(super) id: TaskId,
    /// Index in the component.
    pub(super) index: usize,
    /// Component and name.
    pub(super) name: String,
    /// First place of its activities in the component, and their number.
    pub(super) base: usize,
    pub(super) count: usize,
    /// Period, in base units.
    pub(super) period: Option<i64>,
    pub(super) needs_core: bool,
    /// The component has other tasks without a period, which this task wakes.
    pub(super) wakes: bool,
}

/// A permanent activity or an activity: what can be in a place.
pub(super) struct Kind {
    /// Number in the variables, from 1.
    pub(super) number: usize,
    pub(super) name: String,
    /// Instance of its machine; `None` for a permanent activity without codels.
    pub(super) automaton: Option<AutomatonId>,
    /// `None` for a permanent activity.
    pub(super) service: Option<ServiceId>,
    pub(super) task: TaskId,
}

impl<'s> Layout<'s> {
    pub(super) fn new(
        prepared: &'s Prepared,
        original: &'s TimedSystem,
        place: &'s Place<'s>,
    ) -> Layout<'s> {
        let system = &prepared.built.system;
        let mut parts = Vec::new();
        let mut offset = 0;
        let (mut executors, mut services, mut channels) =
            (Unique::default(), Unique::default(), Unique::default());
        for id in system.components.keys() {
            let part = part(&prepared.built, id, offset, &mut executors);
            offset += part.size;
            parts.push(part);
        }
        let mut clients = Vec::new();
        let mut automata = Vec::new();
        for (id, automaton) in system.automata.iter_enumerated() {
            if system.platform.semantics.fixed().cycle == Cycle::Jobs {
                let name = &system.machine_of(id).name;
                let what = match automaton.service {
                    Some(_) => format!("a place of `{name}`"),
                    None => format!("the permanent activity of `{name}`"),
                };
                automata.push(executors.take(&format!("{name}_run"), &what));
            }
        }
        for client in &system.clients {
            clients.push(executors.take(&client.name, &format!("the client `{}`", client.name)));
        }
        let mut out = Layout {
            system,
            original,
            place,
            jobs: system.platform.semantics.fixed().cycle == Cycle::Jobs,
            parts,
            executors: vec![Vec::new(); system.codels.len()],
            automata,
            clients,
            services: Vec::new(),
            requests: BTreeMap::new(),
            renamed: Vec::new(),
        };
        for service in system.services.keys() {
            let path = system.service_path(service);
            out.services.push(services.take(&path, &format!("the service `{path}`")));
        }
        for (id, client) in system.clients.iter_enumerated() {
            for service in client.steps.iter().filter_map(ClientStep::requests) {
                if !out.requests.contains_key(&(id, service)) {
                    let name =
                        format!("request_{}_{}", out.client_name(id), out.service_name(service));
                    let part = format!("the channel from `{}`", client.name);
                    out.requests.insert((id, service), channels.take(&name, &part));
                }
            }
        }
        out.renamed =
            [executors, services, channels].into_iter().flat_map(|unique| unique.renamed).collect();
        let requested = system.requested();
        for (id, name) in system.automata.keys().zip(&out.automata) {
            if system.automata[id].service.is_some_and(|of| !requested[of]) {
                continue;
            }
            for state in &system.machine_of(id).states {
                out.executors[usize::from(state.codel)].push(name.clone());
            }
        }
        for part in &out.parts {
            for kind in part.kinds.iter().filter(|_| !out.jobs) {
                let machine = kind.automaton.map(|automaton| system.machine_of(automaton));
                let name = &part.task(kind.task).name;
                for state in machine.iter().flat_map(|machine| &machine.states) {
                    out.executors[usize::from(state.codel)] = vec![name.clone()];
                }
            }
            for &codel in part.services.iter().flat_map(|(_, codels)| codels) {
                out.executors[usize::from(codel)] = vec![part.name.clone()];
            }
        }
        let waits: Vec<bool> = out.parts.iter().map(|part| out.waits(part)).collect();
        for (part, waits) in out.parts.iter_mut().zip(waits) {
            part.queue = waits;
        }
        out
    }

    /// Returns a number of base units as a time in words.
    pub(super) fn time(&self, ticks: i64) -> String {
        in_words(self.system.unit, ticks)
    }

    /// Returns the times between two bounds in words.
    pub(super) fn interval(&self, lower: Ticks, upper: Ticks) -> String {
        let lower = self.time(i64::from(lower));
        if upper == FOREVER {
            return format!("at least {lower}");
        }
        format!("{lower} to {}", self.time(i64::from(upper)))
    }

    /// Returns the name of a codel, with the place of its declaration.
    pub(super) fn codel_in_words(&self, codel: CodelId) -> String {
        let codel = &self.system.codels[codel];
        let place = codel.site.zip(codel.src);
        let place = place.and_then(|((component, _), src)| (self.place)(component, src));
        with_place(&codel.path, place)
    }

    /// Returns the name of a task, with the place of its declaration.
    pub(super) fn task_in_words(&self, task: TaskId) -> String {
        let place = self.system.tasks[task].src;
        let place = place.and_then(|(component, src)| (self.place)(component, src));
        with_place(&self.system.task_path(task), place)
    }

    /// Returns true if codels of a component can wait for others.
    fn waits(&self, part: &Part) -> bool {
        let executors = part.tasks.len() + usize::from(part.has_control_codels());
        let codels = self.system.codels.iter_enumerated();
        let mut own = codels.filter(|(_, codel)| codel.component == part.id);
        executors > 1
            || own.any(|(codel, _)| {
                let executor = self.executors(codel).first();
                executor.is_some_and(|executor| !self.blocked(codel, executor).is_empty())
            })
    }

    /// Returns the conditions under which an executor must wait for the locks of a codel, once it is first in
    /// its queue.
    pub(super) fn blocked(&self, codel: CodelId, executor: &str) -> Vec<Guard> {
        let mut out = Vec::new();
        for other in self.system.codels[codel].conflicts.iter() {
            let others = self.executors(other).iter().filter(|name| *name != executor);
            out.extend(others.map(|name| executed(name).is(number(other))));
        }
        out
    }

    /// Returns the names of a codel's executors; none if the codel is never executed.
    pub(super) fn executors(&self, codel: CodelId) -> &[String] {
        &self.executors[usize::from(codel)]
    }

    pub(super) fn automaton_name(&self, id: AutomatonId) -> &str {
        &self.automata[usize::from(id)]
    }

    /// Returns the condition under which the first in a component's lock queue can begin its codel.
    pub(super) fn first_can_begin(&self, part: &Part) -> Guard {
        let mut out = Vec::new();
        for (executor, name, codels) in self.executors_of(part) {
            let mut guards = vec![part.lock_queue(0_usize).is(executor)];
            for codel in codels {
                let blocked = self.blocked(codel, &name);
                if !blocked.is_empty() {
                    let free = blocked.iter().map(Guard::negated);
                    guards.push(any([wanted(&name).is_not(number(codel)), all(free)]));
                }
            }
            out.push(all(guards));
        }
        any(out)
    }

    /// Returns the executors of a component, each with its number in the queue, its name and its codels.
    pub(super) fn executors_of(&self, part: &Part) -> Vec<(usize, String, Vec<CodelId>)> {
        let mut out = Vec::new();
        for task in &part.tasks {
            let kinds = part.kinds.iter().filter(|kind| kind.task == task.id);
            let machines = kinds.filter_map(|kind| self.machine(kind));
            let codels =
                machines.flat_map(|machine| machine.states.iter().map(|state| state.codel));
            out.push((task.executor(), task.name.clone(), codels.collect()));
        }
        if part.has_control_codels() {
            let codels = part.services.iter().flat_map(|(_, codels)| codels).copied();
            out.push((part.tasks.len() + 1, part.name.clone(), codels.collect()));
        }
        out
    }

    pub(super) fn machine(&self, kind: &Kind) -> Option<&'s Machine> {
        kind.automaton.map(|automaton| self.system.machine_of(automaton))
    }

    /// Returns the action that ends a codel with a yield, or without one by an exception. `state` is its
    /// state in the machine of an automaton, which is executed by the executor with a number.
    pub(super) fn end_of_codel(
        &self,
        (automaton, executor): (AutomatonId, usize),
        state: usize,
        by: Option<Yield>,
    ) -> Option<Action> {
        let machine = self.system.machine_of(automaton);
        let original = self.original.machine_of(automaton);
        let states = &original.states;
        // Copies of a state come after the states of the machine.
        let of = |state: usize| match states.get(state) {
            Some(_) => Some(state),
            None => states.iter().position(|other| other.codel == machine.states[state].codel),
        };
        let yields = &states[of(state)?].yields;
        let is_same = |own: &Yield| match (own, by) {
            (Yield::Next(own), Some(Yield::Next(to))) => Some(*own) == of(to),
            (own, by) => Some(*own) == by,
        };
        let outcome = by.map_or(Some(yields.len()), |_| yields.iter().position(is_same))?;
        Some(Action::Finish { executor, outcome })
    }

    /// Returns the number of the executor of a control task.
    pub(super) fn control_executor(&self, part: &Part) -> usize {
        self.threads() + usize::from(part.id)
    }

    /// Returns the number of executors of state machines.
    fn threads(&self) -> usize {
        if self.jobs { self.system.automata.len() } else { self.system.tasks.len() }
    }

    /// Returns the number of the executor of a client.
    pub(super) fn client_executor(&self, client: ClientId) -> usize {
        self.threads() + self.system.components.len() + usize::from(client)
    }

    /// Returns the component and the kind of a service's activities.
    pub(super) fn kind_of(&self, service: ServiceId) -> Option<(&Part, &Kind)> {
        let part = &self.parts[usize::from(self.system.services[service].component)];
        let kind = part.kinds.iter().find(|kind| kind.service == Some(service))?;
        Some((part, kind))
    }

    pub(super) fn part(&self, id: ComponentId) -> &Part {
        &self.parts[usize::from(id)]
    }

    pub(super) fn task(&self, id: TaskId) -> &TaskPart {
        self.part(self.system.tasks[id].component).task(id)
    }

    /// Returns the number of cores, if it is limited.
    pub(super) fn cores(&self) -> Option<usize> {
        self.system.platform.cores.map(|count| count as usize)
    }

    pub(super) fn is_fifo(&self) -> bool {
        self.system.platform.policy == Policy::Fifo
    }

    /// Returns true if tasks get cores in the order of a queue.
    pub(super) fn queues_for_cores(&self) -> bool {
        self.cores().is_some() && matches!(self.system.platform.policy, Policy::Fifo | Policy::Edf)
    }

    /// Returns true if some request is tested for the success of a service.
    pub(super) fn notes_success(&self, service: ServiceId) -> bool {
        let requested = self.system.requested();
        let mut others = self.system.services.iter().zip(&requested).filter(|service| *service.1);
        let names = |list: &[ServiceId]| list.contains(&service);
        requested[service] && others.any(|(other, _)| names(&other.after) || names(&other.before))
    }

    /// Returns the name of a service, with its component.
    pub(super) fn service_name(&self, service: ServiceId) -> &str {
        &self.services[usize::from(service)]
    }

    /// Returns the variable of the success of a service.
    pub(super) fn success(&self, service: ServiceId) -> Term {
        var(&format!("succeeded_{}", self.service_name(service)))
    }

    /// Returns every tracker: client and number.
    pub(super) fn trackers(&self) -> Vec<(ClientId, usize)> {
        let clients = self.system.clients.iter_enumerated();
        clients.flat_map(|(id, client)| (0..client.trackers).map(move |t| (id, t))).collect()
    }

    pub(super) fn tracker(&self, client: ClientId, tracker: usize) -> Term {
        var(&format!("follows_{}_{tracker}", self.client_name(client)))
    }

    /// Returns true if a client depends on the outcome of the request of a tracker.
    pub(super) fn asks_outcome(&self, client: ClientId, tracker: usize) -> bool {
        self.system.clients[client].asks_outcome(tracker)
    }

    /// Returns true if some client depends on the outcome of a request.
    pub(super) fn asks_outcomes(&self) -> bool {
        self.trackers().iter().any(|&(client, tracker)| self.asks_outcome(client, tracker))
    }

    pub(super) fn client_name(&self, client: ClientId) -> &str {
        &self.clients[usize::from(client)]
    }

    pub(super) fn client_step(&self, client: ClientId) -> Term {
        var(&format!("step_{}", self.client_name(client)))
    }

    /// Returns the variable that is 1 while a client's request is not answered.
    pub(super) fn outstanding(&self, client: ClientId) -> Term {
        var(&format!("asks_{}", self.client_name(client)))
    }

    /// Returns the channel of a client's requests for a service.
    pub(super) fn request(&self, client: ClientId, service: ServiceId) -> &str {
        &self.requests[&(client, service)]
    }
}

/// Collects the names of a component.
fn part(built: &Built, id: ComponentId, offset: usize, names: &mut Unique) -> Part {
    let system = &built.system;
    let component = &system.components[id];
    let name = names.take(&component.name, &format!("the component `{}`", component.name));
    let requested = system.requested();
    let mut tasks = Vec::new();
    let mut kinds = Vec::new();
    let mut base = 0;
    let aperiodic =
        component.tasks.iter().copied().filter(|&task| system.tasks[task].period.is_none());
    for (index, &task) in component.tasks.iter().enumerate() {
        let definition = &system.tasks[task];
        let count = system.most_places(task);
        tasks.push(TaskPart {
            id: task,
            index,
            name: names.take(
                &format!("{name}_{}", definition.name),
                &format!("the task `{}`", system.task_path(task)),
            ),
            base,
            count,
            period: definition.period.map(i64::from),
            needs_core: system.needs_core(task),
            wakes: aperiodic.clone().any(|other| other != task),
        });
        base += count + 1;
        kinds.push(Kind {
            number: kinds.len() + 1,
            name: definition.name.clone(),
            automaton: definition.permanent,
            service: None,
            task,
        });
    }
    let mut services = Vec::new();
    for &service in component.services.iter().filter(|&&service| requested[service]) {
        let definition = &system.services[service];
        let codels = definition.validate.iter().chain(&definition.simple).copied().collect();
        services.push((service, codels));
        if let Some(&automaton) = definition.slots.first() {
            kinds.push(Kind {
                number: kinds.len() + 1,
                name: definition.name.clone(),
                automaton: Some(automaton),
                service: Some(service),
                task: system.automata[automaton].task,
            });
        }
    }
    let activities = kinds.iter().any(|kind| kind.service.is_some());
    let control = sends(system, id);
    Part { id, name, tasks, kinds, size: base, offset, control, activities, queue: false, services }
}

/// Returns true if a client requests a service of a component.
fn sends(system: &TimedSystem, component: ComponentId) -> bool {
    let mut steps = system.clients.iter().flat_map(|client| &client.steps);
    steps.any(|step| {
        matches!(step.action, ClientAction::Send { service, .. }
            if system.services[service].component == component)
    })
}

/// Returns the number of a codel in variables.
pub(super) fn number(codel: CodelId) -> usize {
    usize::from(codel) + 1
}

/// Returns the variable of the codel that an executor takes a ticket for, waits for or executes.
pub(super) fn wanted(executor: &str) -> Term {
    var(&format!("wants_{executor}"))
}

/// Returns the variable of the codel that an executor executes.
pub(super) fn executed(executor: &str) -> Term {
    var(&format!("codel_{executor}"))
}

/// Returns a number of base units, of that many seconds each, as a time in words.
pub(super) fn in_words(base: Seconds, ticks: i64) -> String {
    let unit = TimeUnit::default();
    unit.show(unit.from_seconds(base * Seconds::from_integer(i128::from(ticks))))
}

fn with_place(name: &str, place: Option<String>) -> String {
    match place {
        Some(place) => format!("{name} ({place})"),
        None => name.to_owned(),
    }
}
