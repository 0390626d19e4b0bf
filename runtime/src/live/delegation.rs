//! Cycles that the threads of tasks execute without the engine, on the real clock.
//!
//! A round trip to the engine takes longer than many codels. So the engine delegates a task whose next cycles
//! can contain only one automaton: the thread of the task waits for its ticks, and executes the codels of the
//! automaton by a table of its machine, until the engine recalls it or the automaton leaves the table. The
//! engine follows the reports: every result has its time, and the model ends the codel when it reaches that
//! time. So the rules remain one: what the thread has done is a run of the model, step by step.
//!
//! The model stays a little behind the clock, but decides as before. Three rules keep thread and model
//! together:
//!
//! - *Locks.* While a task is delegated, no codel begins that excludes one of its codels: the engine recalls
//!   the task first. The model may begin the codel earlier than its host does; the difference counts as
//!   execution time.
//! - *Requests.* A request from outside that can change the work of the task waits until the task is
//!   recalled, and until the model has reached the end of its reports.
//! - *Ticks.* Several ticks during a cycle count as one, in the thread as in the model. The model passes such
//!   a tick only if the thread has reported that its cycle lasted longer.

use std::collections::VecDeque;

use dotgen_timing::explore::{IdleTurn, Stepper, Work};
use dotgen_timing::system::{
    AutomatonId, ClientId, CodelId, ComponentId, ServiceId, TaskId, Ticks, Yield,
};
use typed_index_collections::TiVec;

use super::{Live, lane};
use crate::hosts::{
    Call, CodelResult, DelegatedState, DelegatedYield, Delegation, Message, OutsideRequest,
};

/// Least time between a delegation and its first tick, in nanoseconds.
const MIN_NOTICE_NANOS: u64 = 50_000;

/// Number of periods for which a task is not delegated after a codel excluded one of its codels.
const PAUSE_PERIODS: u64 = 50;

/// The conversion of the time of hosts to that of the model.
#[derive(Debug, Clone, Copy)]
struct ModelTime {
    /// Time of the start, in nanoseconds.
    start: u64,
    /// Nanoseconds per base unit.
    unit: u64,
}

impl ModelTime {
    fn ticks(self, nanos: u64) -> u64 {
        nanos.saturating_sub(self.start) / self.unit
    }

    fn nanos(self, ticks: u64) -> u64 {
        self.start.saturating_add(ticks.saturating_mul(self.unit))
    }
}

/// A task that its thread executes by itself.
#[derive(Debug)]
struct Delegated {
    executor: usize,
    task: TaskId,
    component: ComponentId,
    /// Codels that the thread may execute.
    codels: Vec<CodelId>,
    /// The engine has asked the thread to stop.
    recalled: bool,
    /// The thread has stopped.
    over: bool,
    /// Its component is lost, which the model has not reached yet.
    lost: bool,
    /// Time, in base units, until which the thread has reported all.
    known: u64,
    /// The answer to a probe is awaited.
    probed: bool,
    /// Results that the model has not reached yet.
    results: VecDeque<CodelResult>,
}

/// The state of all delegations.
#[derive(Debug)]
pub(super) struct Delegations {
    /// `None`: nothing is delegated.
    time: Option<ModelTime>,
    /// Present time of the model, in base units.
    now: u64,
    tasks: Vec<Delegated>,
    /// Tasks that may be delegated, because one of their codels has ended.
    candidates: Vec<TaskId>,
    /// Tasks that are not delegated before a time, in base units.
    not_before: Vec<(TaskId, u64)>,
    /// Calls that wait for recalls, with the executors that are recalled.
    postponed: Vec<(Call, Vec<usize>)>,
    /// Messages from outside that wait for recalls.
    deferred: TiVec<ComponentId, VecDeque<Message>>,
}

impl Delegations {
    pub(super) fn new(components: usize) -> Delegations {
        Delegations {
            time: None,
            now: 0,
            tasks: Vec::new(),
            candidates: Vec::new(),
            not_before: Vec::new(),
            postponed: Vec::new(),
            deferred: (0..components).map(|_| VecDeque::new()).collect(),
        }
    }

    fn of(&mut self, executor: usize) -> Option<&mut Delegated> {
        self.tasks
            .iter_mut()
            .find(|delegated| delegated.executor == executor)
    }
}

impl Live<'_> {
    /// Permits delegations: the run is on the real clock. `start` is the time of its start, in nanoseconds,
    /// and `unit` the number of nanoseconds per base unit.
    pub fn permit_delegations(&mut self, start: u64, unit: u64) {
        // Under a debugger a thread may stand still for any time, and a violation may end an activity.
        let allowed = !self.stops_activities && self.hosts.blocked_after_nanos().is_some();
        let time = ModelTime {
            start,
            unit: unit.max(1),
        };
        self.delegations.time = allowed.then_some(time);
    }

    /// Returns true if the thread of a task executes its cycles by itself.
    pub fn is_delegated(&self, task: TaskId) -> bool {
        let mut tasks = self.delegations.tasks.iter();
        tasks.any(|delegated| delegated.task == task)
    }

    /// Returns true if the codels of an executor are executed by a thread by itself.
    pub fn is_delegated_executor(&self, executor: usize) -> bool {
        let mut tasks = self.delegations.tasks.iter();
        tasks.any(|delegated| delegated.executor == executor)
    }

    /// Notes that a codel of a task has ended.
    pub(super) fn note_candidate(&mut self, work: &Work) {
        if let (Some(_), Work::State { task, .. }) = (self.delegations.time, *work) {
            let (task, candidates) = (TaskId::from(task), &mut self.delegations.candidates);
            if !candidates.contains(&task) {
                candidates.push(task);
            }
        }
    }

    /// Delegates the tasks that can be, at a moment without possible actions.
    pub fn delegate(&mut self, stepper: &Stepper) {
        let Some(time) = self.delegations.time else {
            return;
        };
        let candidates = std::mem::take(&mut self.delegations.candidates);
        for task in candidates {
            if self.is_delegated(task) {
                continue;
            }
            let paused = (self.delegations.not_before.iter())
                .any(|&(of, until)| of == task && stepper.now() < until);
            match stepper.idle_turn(task).filter(|_| !paused) {
                Some(turn) if self.may_delegate(stepper, task, &turn) => {
                    self.delegate_task(stepper, time, task, &turn);
                }
                _ => self.delegations.candidates.push(task),
            }
        }
    }

    /// Returns true if nothing that is under way excludes that a task executes its cycles by itself.
    fn may_delegate(&self, stepper: &Stepper, task: TaskId, turn: &IdleTurn) -> bool {
        let component = self.system.tasks[task].component;
        let codels = self.codels_of(turn.automaton);
        let excludes = |other: CodelId| self.excludes_any(other, &codels);
        let is_free = |service: ServiceId| !self.disturbs(service, &codels);
        let running = self.running.iter().flatten();
        let running = running.filter_map(|running| running.work.codel());
        let handled = stepper.handling(component).map(|(service, _)| service);
        // The model sends a request even if it was aborted meanwhile.
        let sent = self.parts.client_of(component);
        let sent = sent.and_then(|client| stepper.requests(client));
        self.is_alive(component)
            && !running.into_iter().any(excludes)
            && !(self.delegations.tasks.iter())
                .any(|other| other.codels.iter().any(|&codel| excludes(codel)))
            && handled.into_iter().chain(sent).all(is_free)
            && self.pending[component].is_none()
            && self.delegations.deferred[component].is_empty()
            && (self.wanted[component].iter()).all(|request| is_free(request.service))
            && !self.is_addressed(stepper, component, &codels)
    }

    /// Returns true if a client of the scenario may still send a request that disturbs codels.
    fn is_addressed(&self, stepper: &Stepper, component: ComponentId, codels: &[CodelId]) -> bool {
        let may_send = |client: ClientId| {
            let mut steps = self.system.clients[client].steps.iter();
            steps.any(|step| {
                step.requests().is_some_and(|service| {
                    self.system.services[service].component == component
                        && self.disturbs(service, codels)
                })
            })
        };
        (self.system.clients.keys())
            .filter(|&client| self.parts.outside(client).is_none())
            .any(|client| !stepper.has_ended(client) && may_send(client))
    }

    fn delegate_task(&mut self, stepper: &Stepper, time: ModelTime, task: TaskId, turn: &IdleTurn) {
        let definition = &self.system.tasks[task];
        let first_tick = stepper.now() + u64::from(turn.tick);
        let notice = time.nanos(first_tick).saturating_sub(self.hosts.now());
        let (Some(period), true) = (definition.period, notice >= MIN_NOTICE_NANOS) else {
            return self.delegations.candidates.push(task);
        };
        let Some(states) = self.table(turn.automaton) else {
            return;
        };
        let instance = self.places.get(turn.slot).and_then(Option::as_ref);
        let call = Call {
            component: definition.component,
            lane: lane(task),
            ticket: u32::try_from(turn.executor).unwrap_or(u32::MAX),
            codel: states[turn.state].codel,
            instance: instance.map_or(0, |instance| instance.number),
            core: definition.affinity,
        };
        self.hosts.delegate(&Delegation {
            call,
            first_tick: time.nanos(first_tick),
            period: u64::from(period).saturating_mul(time.unit),
            state: turn.state,
            states,
        });
        let codels = self.codels_of(turn.automaton);
        self.delegations.tasks.push(Delegated {
            executor: turn.executor,
            task,
            component: definition.component,
            codels,
            recalled: false,
            over: false,
            lost: false,
            known: first_tick,
            probed: false,
            results: VecDeque::new(),
        });
    }

    fn codels_of(&self, automaton: AutomatonId) -> Vec<CodelId> {
        let states = self.system.machine_of(automaton).states.iter();
        states.map(|state| state.codel).collect()
    }

    /// Returns the table of a machine; `None` if a host cannot execute all of its codels in one thread.
    fn table(&self, automaton: AutomatonId) -> Option<Vec<DelegatedState>> {
        let machine = self.system.machine_of(automaton);
        let states = machine.states.iter().map(|state| {
            let codel = self.parts.codel(state.codel).filter(|_| !state.is_async)?;
            let follows = |event: &String| {
                let transition = self.yield_of(state.codel, machine, event)?;
                let next = match transition {
                    Yield::Next(to) => DelegatedYield::Next(to),
                    Yield::Pause(to) => DelegatedYield::Pause(to),
                    Yield::End => return None,
                };
                let known = state.yields.contains(&transition);
                known.then(|| (event.clone(), next))
            };
            let next = self.parts.events(state.codel).iter().filter_map(follows);
            Some(DelegatedState {
                codel,
                next: next.collect(),
            })
        });
        states.collect()
    }

    /// Returns true if a codel and one of others exclude each other.
    fn excludes_any(&self, codel: CodelId, others: &[CodelId]) -> bool {
        let own = &self.system.codels[codel];
        others.iter().any(|&other| {
            own.conflicts.contains(other) || self.system.codels[other].conflicts.contains(codel)
        })
    }

    /// Returns true if a request for a service can change the work of a task, or exclude its codels.
    fn disturbs(&self, service: ServiceId, codels: &[CodelId]) -> bool {
        let service = &self.system.services[service];
        let mut own = service.validate.iter().chain(&service.simple);
        service.activity
            || !service.interrupts.is_empty()
            || service.builtin.is_some()
            || own.any(|&codel| self.excludes_any(codel, codels))
    }

    /// Executes a codel in its host, unless the thread of its task does so by itself. Tasks whose codels it
    /// excludes are recalled first.
    pub(super) fn run_unless_delegated(&mut self, codel: CodelId, call: Call) {
        let executor = call.ticket as usize;
        if self.delegations.of(executor).is_some() {
            // The result comes without a call, or its delegation ends.
            return;
        }
        let blocking: Vec<usize> = (self.delegations.tasks.iter())
            .filter(|other| !other.over && self.excludes_any(codel, &other.codels))
            .map(|other| other.executor)
            .collect();
        if blocking.is_empty() {
            return self.hosts.run(&call);
        }
        for &executor in &blocking {
            self.recall(executor);
            let Some(task) = self.delegations.of(executor).map(|other| other.task) else {
                continue;
            };
            let period = self.system.tasks[task].period.unwrap_or(0);
            let until = self.delegations.now + PAUSE_PERIODS * u64::from(period);
            let pauses = &mut self.delegations.not_before;
            pauses.retain(|&(of, _)| of != task);
            pauses.push((task, until));
        }
        self.delegations.postponed.push((call, blocking));
    }

    fn recall(&mut self, executor: usize) {
        if let Some(delegated) = self.delegations.of(executor)
            && !std::mem::replace(&mut delegated.recalled, true)
        {
            let (component, task) = (delegated.component, delegated.task);
            self.hosts.recall(component, lane(task));
        }
    }

    /// Handles the end of a delegation.
    pub(super) fn recalled(&mut self, component: ComponentId, ticket: u32) {
        let executor = ticket as usize;
        let Some(delegated) = self.delegations.of(executor) else {
            return;
        };
        if delegated.component != component {
            return;
        }
        delegated.over = true;
        self.settle(executor);
        let mut ready = Vec::new();
        self.delegations.postponed.retain_mut(|(call, blocking)| {
            blocking.retain(|&other| other != executor);
            if blocking.is_empty() {
                ready.push(*call);
            }
            !blocking.is_empty()
        });
        for call in ready {
            self.hosts.run(&call);
        }
    }

    /// Removes a delegation that is over, as soon as the model has reached its end.
    fn settle(&mut self, executor: usize) {
        let Some(delegated) = self.delegations.of(executor) else {
            return;
        };
        if !delegated.over || !delegated.results.is_empty() {
            return;
        }
        let component = delegated.component;
        self.delegations
            .tasks
            .retain(|other| other.executor != executor);
        if self.is_running(executor) {
            // The thread has stopped before this codel.
            let running = self.running.get(executor).and_then(Option::as_ref);
            let call = running.map(|running| running.work);
            if let Some((codel, call)) = call.and_then(|work| self.call(executor, &work)) {
                self.run_unless_delegated(codel, call);
            }
        }
        let mut left = self.delegations.tasks.iter();
        if !left.any(|other| other.component == component && other.recalled) {
            for message in std::mem::take(&mut self.delegations.deferred[component]) {
                self.message(message);
            }
        }
    }

    /// Keeps the result of a codel that a thread has executed by itself, until the model reaches its time.
    /// Returns any other result.
    pub(super) fn keep_delegated(
        &mut self,
        component: ComponentId,
        ran: CodelResult,
    ) -> Option<CodelResult> {
        let (time, executor) = (self.delegations.time, ran.ticket as usize);
        let (Some(time), Some(delegated)) = (time, self.delegations.of(executor)) else {
            return Some(ran);
        };
        if delegated.component == component && !delegated.over {
            delegated.known = delegated.known.max(time.ticks(ran.ended));
            delegated.results.push_back(ran);
        }
        None
    }

    pub(super) fn probed(&mut self, component: ComponentId, ticket: u32, until: u64) {
        let time = self.delegations.time;
        if let (Some(time), Some(delegated)) = (time, self.delegations.of(ticket as usize))
            && delegated.component == component
        {
            delegated.probed = false;
            delegated.known = delegated.known.max(time.ticks(until));
        }
    }

    /// Ends codels that threads have executed by themselves, if the model has reached their times. `now` is
    /// the time of the model, in base units.
    pub fn deliver(&mut self, now: u64) {
        self.delegations.now = now;
        let Some(time) = self.delegations.time else {
            return;
        };
        let executors: Vec<usize> = (self.delegations.tasks.iter())
            .map(|delegated| delegated.executor)
            .collect();
        for executor in executors {
            if !self.is_running(executor) {
                continue;
            }
            let due = |ran: &&CodelResult| time.ticks(ran.ended) <= now;
            let Some(delegated) = self.delegations.of(executor) else {
                continue;
            };
            let component = delegated.component;
            if delegated.results.front().filter(due).is_none() {
                continue;
            }
            let Some(ran) = delegated.results.pop_front() else {
                continue;
            };
            let Some(Some(running)) = self.running.get_mut(executor) else {
                continue;
            };
            let wanted = running.work.codel();
            if wanted.and_then(|codel| self.parts.codel(codel)) != Some(ran.codel) {
                self.hosts.kill(component);
                let why = "executed another codel than the model: this is a defect of dotgen";
                self.lost(component, why.to_owned());
                continue;
            }
            running.ran = Some(ran);
            self.measure(executor);
            self.settle(executor);
        }
    }

    /// Returns the time, in base units, until the model ends the next codel that a thread has executed by
    /// itself.
    pub fn next_result(&self) -> Option<u64> {
        let time = self.delegations.time?;
        let tasks = self.delegations.tasks.iter();
        let running = tasks.filter(|delegated| self.is_running(delegated.executor));
        let ends = running.filter_map(|delegated| Some(delegated.results.front()?.ended));
        let least = ends.map(|ended| time.ticks(ended)).min()?;
        Some(least.saturating_sub(self.delegations.now))
    }

    /// Returns the greatest time that may pass in the model, in base units: it must not pass a tick that
    /// counts together with an earlier one before the thread has reported that its cycle lasted so long.
    pub fn hold(&mut self, stepper: &Stepper) -> Option<Ticks> {
        let (time, now) = (self.delegations.time?, self.hosts.now());
        let mut most = None;
        for delegated in &mut self.delegations.tasks {
            if delegated.over || delegated.lost || !delegated.results.is_empty() {
                continue;
            }
            let Some((until, true)) = stepper.tick(delegated.task) else {
                continue;
            };
            let tick = stepper.now() + u64::from(until);
            if tick <= delegated.known {
                continue;
            }
            let before = until.saturating_sub(1);
            most = Some(most.map_or(before, |most: Ticks| most.min(before)));
            if now >= time.nanos(tick) && !std::mem::replace(&mut delegated.probed, true) {
                self.hosts.probe(delegated.component, lane(delegated.task));
            }
        }
        most
    }

    /// Expects no further reports of the threads of a component.
    pub fn expect_loss(&mut self, component: ComponentId) {
        for delegated in &mut self.delegations.tasks {
            delegated.lost |= delegated.component == component;
        }
    }

    /// Returns the request, if it may be handled now. Otherwise it is kept until the tasks that it disturbs
    /// are recalled.
    pub(super) fn defer_request(&mut self, request: OutsideRequest) -> Option<OutsideRequest> {
        let component = self.system.services[request.service].component;
        let disturbed: Vec<usize> = (self.delegations.tasks.iter())
            .filter(|delegated| delegated.component == component)
            .filter(|delegated| self.disturbs(request.service, &delegated.codels))
            .map(|delegated| delegated.executor)
            .collect();
        if disturbed.is_empty() && self.delegations.deferred[component].is_empty() {
            return Some(request);
        }
        disturbed
            .into_iter()
            .for_each(|executor| self.recall(executor));
        self.delegations.deferred[component].push_back(Message::OutsideRequest(request));
        None
    }

    /// Aborts an outside request, as soon as the tasks of its component are recalled.
    pub(super) fn defer_abort(&mut self, id: u64) {
        let Some(component) = self.component_of_request(id) else {
            return self.aborts.push(id);
        };
        let all: Vec<usize> = (self.delegations.tasks.iter())
            .filter(|delegated| delegated.component == component)
            .map(|delegated| delegated.executor)
            .collect();
        if all.is_empty() && self.delegations.deferred[component].is_empty() {
            return self.aborts.push(id);
        }
        all.into_iter().for_each(|executor| self.recall(executor));
        self.delegations.deferred[component].push_back(Message::Abort(id));
    }

    fn component_of_request(&self, id: u64) -> Option<ComponentId> {
        let instances = self.places.iter().chain(&self.pending).flatten();
        let mut of_instances = instances.filter(|instance| instance.wanted == Some(id));
        if let Some(instance) = of_instances.next() {
            return Some(self.system.services[instance.service].component);
        }
        let waits = |component: &ComponentId| {
            let mut wanted = self.wanted[*component].iter();
            let mut deferred = self.delegations.deferred[*component].iter();
            wanted.any(|request| request.id == id)
                || deferred.any(|message| {
                    matches!(message, Message::OutsideRequest(request) if request.id == id)
                })
        };
        self.system.components.keys().find(waits)
    }

    /// Returns the requests from outside that wait for recalls of a component.
    pub(super) fn take_deferred(&mut self, component: ComponentId) -> Vec<u64> {
        let deferred = std::mem::take(&mut self.delegations.deferred[component]);
        let ids = deferred.into_iter().filter_map(|message| match message {
            Message::OutsideRequest(request) => Some(request.id),
            _ => None,
        });
        ids.collect()
    }

    /// Ends the delegations of a lost component. Returns their executors, and the codel that one of their
    /// threads was executing, with its function.
    pub(super) fn end_delegations(
        &mut self,
        component: ComponentId,
    ) -> (Vec<usize>, Option<(String, String)>) {
        let tasks = &self.delegations.tasks;
        let own = || tasks.iter().filter(|task| task.component == component);
        let culprit = own().filter(|task| !task.over).find_map(|task| {
            let number = self.hosts.executing(component, lane(task.task))?;
            let is_it = |codel: &&CodelId| self.parts.codel(**codel) == Some(number);
            let codel = *task.codels.iter().find(is_it)?;
            let path = self.system.codels[codel].path.to_string();
            Some((path, self.parts.function(codel)))
        });
        let executors = own().map(|task| task.executor).collect();
        let delegations = &mut self.delegations;
        delegations.tasks.retain(|task| task.component != component);
        delegations
            .postponed
            .retain(|(call, _)| call.component != component);
        (executors, culprit)
    }
}
