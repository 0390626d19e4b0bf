//! Cycles that the threads of tasks execute without the engine, on the real clock.
//!
//! A round trip to the engine takes longer than many codels. So the engine delegates a task whose next cycles
//! can contain only one automaton: the thread of the task waits for its ticks, and executes the codels of the
//! automaton by a table of its machine, until the engine recalls it or the automaton leaves the table. The
//! engine follows the reports: every result has its time, and the model ends the codel when it reaches that
//! time, or at once if it is already past it. So the rules remain one: what the thread has done is a run of
//! the model, step by step.
//!
//! The model stays a little behind the clock, but decides as before. Four rules keep thread and model
//! together:
//!
//! - *Locks.* Before a codel begins that excludes one of the codels of a delegated task, the engine recalls
//!   the task. The model begins the codel earlier than its host does; the difference counts as execution
//!   time. Of two codels that exclude each other and become ready within the time of a message, the model may
//!   have the other one first.
//! - *Waits.* If a delegated task waits for locks in the model, its thread is ahead of the model: the engine
//!   recalls it.
//! - *Requests.* A request from outside that can change the work of the task waits until the task is
//!   recalled, and until the model has reached the end of its reports.
//! - *Ticks.* Several ticks during a cycle count as one, in the thread as in the model. The model passes such
//!   a tick only if it knows the results of the thread until then.

mod follow;
mod recall;

use std::collections::VecDeque;

use dotgen_timing::explore::{IdleTurn, Stepper, Work};
use dotgen_timing::system::{
    AutomatonId, ClientId, CodelId, ComponentId, ServiceId, TaskId, Yield,
};
use typed_index_collections::TiVec;

use super::{Live, lane};
use crate::hosts::{Call, CodelResult, DelegatedState, DelegatedYield, Delegation, Message};
use crate::model_time::ModelTime;

/// Least time between a delegation and its first tick, in nanoseconds.
const MIN_NOTICE_NANOS: u64 = 50_000;

/// Number of periods for which a task is not delegated after a codel excluded one of its codels.
const PAUSE_PERIODS: u64 = 50;

/// Number of results that may wait for the model.
const MAX_RESULTS: usize = 10_000;

/// A task that its thread executes by itself.
#[derive(Debug)]
struct Delegated {
    executor: usize,
    task: TaskId,
    component: ComponentId,
    /// Codels that the thread may execute.
    codels: Vec<CodelId>,
    recall: Recall,
    /// Its component is lost, which the model has not reached yet.
    lost: bool,
    /// Time at which the model began the present codel, in base units.
    begun: u64,
    /// Time, in base units, until which the thread has reported all.
    known: u64,
    /// The number of the probe whose answer is awaited, and its time, in nanoseconds.
    probed: Option<(u32, u64)>,
    /// Results that the model has not reached yet.
    results: VecDeque<CodelResult>,
}

/// The progress of a recall.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Recall {
    /// The thread goes on.
    None,
    /// The engine has asked the thread to stop.
    Asked,
    /// The host has passed it on: the thread begins no further codel.
    PassedOn,
    /// The thread has stopped.
    Over,
}

/// The state of all delegations.
#[derive(Debug)]
pub(super) struct Delegations {
    /// `None`: nothing is delegated.
    time: Option<ModelTime>,
    /// Present time of the model, in base units.
    now: u64,
    tasks: Vec<Delegated>,
    /// Number of probes so far.
    probes: u32,
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
            probes: 0,
            candidates: Vec::new(),
            not_before: Vec::new(),
            postponed: Vec::new(),
            deferred: (0..components).map(|_| VecDeque::new()).collect(),
        }
    }

    fn of(&mut self, executor: usize) -> Option<&mut Delegated> {
        self.tasks.iter_mut().find(|delegated| delegated.executor == executor)
    }
}

impl Live<'_> {
    /// Permits delegations: the run is on the real clock.
    pub(crate) fn permit_delegations(&mut self, time: ModelTime) {
        // Under a debugger a thread may stand still for any time, and a violation may end an activity.
        let allowed = !self.stops_activities && self.hosts.blocked_after_nanos().is_some();
        self.delegations.time = allowed.then_some(time);
    }

    /// Returns true if some thread executes cycles by itself.
    pub(crate) fn has_delegations(&self) -> bool {
        !self.delegations.tasks.is_empty()
    }

    /// Returns true if the thread of a task executes its cycles by itself.
    pub(crate) fn is_delegated(&self, task: TaskId) -> bool {
        let mut tasks = self.delegations.tasks.iter();
        tasks.any(|delegated| delegated.task == task)
    }

    /// Returns true if the codels of an executor are executed by a thread by itself.
    pub(crate) fn is_delegated_executor(&self, executor: usize) -> bool {
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

    /// Delegates the tasks that can be, at a moment without possible actions, and recalls those that wait.
    pub fn delegate(&mut self, stepper: &Stepper) {
        let Some(time) = self.delegations.time else {
            return;
        };
        self.recall_waiting(stepper);
        if self.ending {
            return;
        }
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
        let mut codels_running = running.filter_map(|running| running.work.codel());
        let handled = stepper.handling(component).map(|(service, _)| service);
        // The model sends a request even if it was aborted meanwhile.
        let sent = self.parts.client_of(component);
        let sent = sent.and_then(|client| stepper.requests(client));
        self.is_alive(component)
            // A codel that waits for another component must not keep its results back.
            && !self.parts.has_remotes(component)
            && !codels_running.any(excludes)
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
            period: time.duration(period.into()),
            state: turn.state,
            states,
        });
        let codels = self.codels_of(turn.automaton);
        self.delegations.tasks.push(Delegated {
            executor: turn.executor,
            task,
            component: definition.component,
            codels,
            recall: Recall::None,
            lost: false,
            begun: first_tick,
            known: first_tick,
            probed: None,
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
                let transition = self.parts.yield_of(state.codel, machine, event)?;
                let next = match transition {
                    Yield::Next(to) => DelegatedYield::Next(to),
                    Yield::Pause(to) => DelegatedYield::Pause(to),
                    Yield::End => return None,
                };
                let known = state.yields.contains(&transition);
                known.then(|| (event.clone(), next))
            };
            let next = self.parts.events(state.codel).iter().filter_map(follows);
            Some(DelegatedState { codel, next: next.collect() })
        });
        states.collect()
    }

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
}
