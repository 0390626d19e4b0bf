//! The rules of a system, for every reading of the points of its semantics.
//!
//! Every *atomic step* is one action (sections 3 to 9, and 21). With passes: a tick for one task; the
//! beginning of a pass up to its first codel; taking a ticket; leaving the queue; the end of a codel; waking
//! the other tasks; taking a request; the end of a control codel; the rest of the handling. With jobs: a
//! tick; the release of a task; taking locks; the end of a codel, up to the locks of the next codel; a
//! message. Between them any other action may happen. There are four ranks: clients that proceed, tasks that
//! ask for a core, granting cores, and all other actions.
//!
//! [`Points`] has the reading of each point. The code names the point wherever readings differ.

use std::cell::Cell;

use typed_index_collections::{TiVec, ti_vec};

use super::layout::Layout;
use super::points::{Cycle, Points, StartUp};
use super::status::{control, flag, permanent, slot, thread};
use super::token::Token;
use super::{Action, Enabled, Moment, Work};
use crate::explore::state::{Clocks, Frame, State, TaskStatus, phase};
use crate::scn::semantics::TickRule;
use crate::system::{
    AutomatonId, ClientAction, ClientId, Codel, CodelId, ComponentId, Machine, ServiceId,
    State as MachineState, TaskId, Ticks, TimedSystem,
};

/// The rules applied to one system. The [module](super) contains their contract.
#[derive(Debug)]
pub(crate) struct Rules<'s> {
    pub(crate) system: &'s TimedSystem,
    pub(crate) points: Points,
    pub(crate) layout: Layout,
    /// Priority of every executor that needs a core; the lower number goes first.
    pub(super) priorities: Vec<u64>,
    /// Services with a request that was rejected for lack of a slot.
    pub(super) rejected: TiVec<ServiceId, Cell<bool>>,
    /// Service of the last request that was refused, for any reason.
    pub(super) refusal: Cell<Option<ServiceId>>,
    /// Services of which two waiting instances have interrupted each other.
    pub(super) restarts: TiVec<ServiceId, Cell<bool>>,
    /// By codel, whether it excludes no other codel.
    pub(super) lockless: TiVec<CodelId, bool>,
    /// Follows the data of a chain.
    pub(in crate::explore) token: Option<Token<'s>>,
}

impl<'s> Rules<'s> {
    /// Creates the rules for a system, without clocks.
    pub(crate) fn new(system: &'s TimedSystem) -> Self {
        Rules::with(system, &Clocks::none(system.tasks.len()))
    }

    /// Creates the rules for a system, with clocks for measured times.
    pub(in crate::explore) fn with(system: &'s TimedSystem, clocks: &Clocks) -> Self {
        let points = Points::of(system);
        Rules {
            layout: Layout::new(system, &points, clocks),
            points,
            priorities: system.priorities(),
            rejected: ti_vec![Cell::new(false); system.services.len()],
            refusal: Cell::new(None),
            restarts: ti_vec![Cell::new(false); system.services.len()],
            lockless: (system.codels.iter()).map(|codel| codel.conflicts.is_empty()).collect(),
            token: None,
            system,
        }
    }

    /// Returns the task of an executor of state machines; `None` for control tasks and clients.
    #[inline]
    pub(crate) fn task_of_executor(&self, executor: usize) -> Option<usize> {
        match self.points.cycle {
            Cycle::Passes => (executor < self.layout.tasks).then_some(executor),
            Cycle::Jobs => {
                let automaton = self.layout.automaton_numbered(executor);
                let automaton = self.system.automata.get(automaton);
                automaton.map(|automaton| automaton.task.into())
            }
        }
    }

    /// Returns the component of an executor; `None` for clients.
    #[inline]
    pub(super) fn component_of(&self, executor: usize) -> Option<ComponentId> {
        if let Some(task) = self.task_of_executor(executor) {
            Some(self.system.tasks[TaskId::from(task)].component)
        } else {
            let component = executor - self.layout.threads;
            (component < self.layout.components).then(|| component.into())
        }
    }

    pub(super) fn is_periodic(&self, task: usize) -> bool {
        self.system.tasks[TaskId::from(task)].period.is_some()
    }

    /// Returns the machine of a slot; `None` for a permanent activity without codels.
    #[inline]
    pub(super) fn machine(&self, s: &State, slot: usize) -> Option<&'s Machine> {
        let automaton = self.layout.automaton(s, slot)?;
        Some(self.system.machine_of(automaton))
    }

    /// Returns the machine state of a slot; `None` if no codel runs there: the default `start` and `stop`.
    #[inline]
    pub(super) fn machine_state(&self, s: &State, slot: usize) -> Option<&'s MachineState> {
        (self.machine(s, slot)?.states).get(self.layout.at(s, slot) as usize)
    }

    /// Returns the service of a slot; `None` for a permanent activity.
    pub(super) fn service(&self, s: &State, slot: usize) -> Option<ServiceId> {
        self.system.automata[self.layout.automaton(s, slot)?].service
    }

    /// Returns the slot whose codel an executor takes a ticket for, waits for or executes; with jobs, also
    /// the slot of an automaton at rest.
    #[inline]
    pub(super) fn slot_of(&self, s: &State, executor: usize) -> Option<usize> {
        let l = &self.layout;
        if executor >= l.threads {
            return None;
        }
        match self.points.cycle {
            Cycle::Jobs => Some(executor),
            Cycle::Passes => {
                let at_codel = thread::TICKET..=thread::EXECUTING;
                (at_codel.contains(&l.thread_of(s, executor)))
                    .then(|| l.turn(s, executor))
                    .flatten()
            }
        }
    }

    /// Returns the codel for which an executor takes a ticket, waits or executes; with jobs, also the present
    /// codel of an automaton at rest.
    #[inline]
    pub(crate) fn codel(&self, s: &State, executor: usize) -> Option<CodelId> {
        let l = &self.layout;
        if executor < l.threads {
            let slot = self.slot_of(s, executor)?;
            return self.machine_state(s, slot).map(|state| state.codel);
        }
        let component = executor - l.threads;
        if component >= l.components {
            return None;
        }
        let component = ComponentId::from(component);
        let at_codel = control::TICKET..=control::EXECUTING;
        if !at_codel.contains(&l.control(s, component)) {
            return None;
        }
        let service = &self.system.services[l.handled(s, component)?];
        let mut codels = service.validate.iter().chain(&service.simple);
        codels.nth(l.codel_number(s, component) as usize).copied()
    }

    /// Returns true if a control task validates a request.
    #[inline]
    pub(crate) fn validates(&self, s: &State, component: ComponentId) -> bool {
        let service = self.layout.handled(s, component);
        service.is_some_and(|service| self.system.services[service].validate.is_some())
            && self.layout.codel_number(s, component) == 0
    }

    /// Returns true if an executor executes a codel that blocks the waiting one.
    pub(super) fn blocks(&self, s: &State, waiting: &Codel, executor: usize) -> bool {
        (self.codel(s, executor)).is_some_and(|codel| waiting.conflicts.contains(codel))
    }

    pub(super) fn in_cycle(&self, s: &State, task: usize) -> bool {
        self.layout.status(s, task) != TaskStatus::Idle
    }

    /// Returns the state at time 0, with the first task of every component started.
    pub(crate) fn initial(&self) -> State {
        let l = &self.layout;
        let mut s = l.blank();
        for component in self.system.components.keys() {
            match self.points.start_up {
                StartUp::FirstCodel => self.start_tasks(&mut s, component),
                StartUp::FirstPass => {
                    self.prepare_tasks(&mut s, component);
                    l.set_starting(&mut s, component, u16::MAX);
                    self.start_next(&mut s, component);
                }
            }
        }
        for (k, client) in self.system.clients.iter_enumerated() {
            // One past the end: the position before the first step.
            l.set_position(&mut s, k, client.done() as u16 + 1);
        }
        self.list_ready(&mut s);
        if let Some(token) = &self.token {
            self.follow_data(token, None, &mut s);
        }
        s
    }

    /// Sets the flags and the timers of the tasks of a component before they are started with a first pass.
    fn prepare_tasks(&self, s: &mut State, component: ComponentId) {
        let l = &self.layout;
        for &task in &self.system.components[component].tasks {
            let definition = &self.system.tasks[task];
            l.raise(s, usize::from(task), flag::FIRST);
            if definition.period.is_none() {
                l.raise(s, usize::from(task), flag::RUNNABLE);
            } else if self.points.ticks == TickRule::Component {
                l.set_timer(s, usize::from(task), self.first_tick(usize::from(task)));
            }
            let first = l.slots(usize::from(task))[0];
            l.set_mode(s, first, slot::INIT | slot::START | slot::PERMANENT);
            l.set_automaton(s, first, definition.permanent);
        }
    }

    /// Returns the time from the start of a clock to the first tick in base units.
    pub(super) fn first_tick(&self, task: usize) -> Ticks {
        let task = &self.system.tasks[TaskId::from(task)];
        match (self.points.ticks, task.delay) {
            (TickRule::Component, 0) => task.period.unwrap_or(0),
            (TickRule::Component, delay) => delay,
            (TickRule::Task, delay) => task.period.unwrap_or(0) + delay,
        }
    }

    /// Starts the next task of a component, or the control task after all other tasks.
    pub(super) fn start_next(&self, s: &mut State, component: ComponentId) {
        let l = &self.layout;
        let next = l.starting(s, component).wrapping_add(1);
        l.set_starting(s, component, next);
        let Some(&task) = self.system.components[component].tasks.get(next as usize) else {
            l.set_control(s, component, control::READY);
            return;
        };
        l.set_thread(s, usize::from(task), thread::IDLE);
        if self.points.ticks == TickRule::Task && self.is_periodic(usize::from(task)) {
            // Its timer starts now, and its first pass needs no tick.
            l.set_timer(s, usize::from(task), self.first_tick(usize::from(task)));
            l.raise(s, usize::from(task), flag::TICK);
        }
    }
}

impl<'s> Rules<'s> {
    /// Returns the same rules for the same system, with clocks for measured times.
    pub(crate) fn with_clocks(&self, clocks: &Clocks) -> Self {
        match &self.token {
            Some(token) => Rules::for_chain(self.system, token.chain, clocks),
            None => Rules::with(self.system, clocks),
        }
    }

    #[inline]
    pub(crate) fn system(&self) -> &'s TimedSystem {
        self.system
    }

    /// Returns the places of the common parts of a state.
    #[inline]
    pub(crate) fn frame(&self) -> &Frame {
        &self.layout
    }

    /// Lists the actions of a state.
    #[inline]
    pub(crate) fn enabled(&self, s: &State, out: &mut Enabled) {
        if self.token.as_ref().is_none_or(|token| self.list_marks(token, s, out)) {
            self.list_enabled(s, out);
        }
    }

    /// Performs an action that is enabled.
    pub(crate) fn apply(&self, s: &mut State, action: Action) {
        match &self.token {
            Some(token) => self.act_with_data(token, s, action),
            None => self.act(s, action),
        }
    }

    /// Performs an action of the system.
    pub(in crate::explore) fn act(&self, s: &mut State, action: Action) {
        self.perform(s, action);
        self.list_ready(s);
    }

    /// Returns the time after a calm state for which no state needs to be examined, in base units: until the
    /// next moment at which an action may become possible or, for executors whose end `can_be_deferred`, must
    /// happen. `None`: for ever.
    pub(crate) fn next_moment(
        &self,
        s: &State,
        can_be_deferred: &dyn Fn(usize) -> bool,
    ) -> Option<Ticks> {
        if self.token.as_ref().is_some_and(|token| token.is_over(s)) {
            return None;
        }
        self.next_moment_without_ticks(s, can_be_deferred, &|_| false)
    }

    /// Lets time pass, at most until the next moment.
    pub(crate) fn elapse(&self, s: &mut State, time: Ticks) {
        self.pass_time(s, time);
        if let Some(token) = &self.token {
            self.age(token, s, time);
        }
    }

    /// Returns true if time brings an executor nearer to the end of its work.
    pub(crate) fn progresses(&self, s: &State, executor: usize) -> bool {
        !self.preempts() || self.executes_on(s, self.running(s), executor)
    }

    // ---- Observation -----------------------------------------------------------------------

    /// Returns whether a task has a job whose response time is measured, and whether the job waits for a
    /// core.
    #[inline]
    pub(crate) fn job(&self, s: &State, task: usize) -> TaskStatus {
        let l = &self.layout;
        match l.status(s, task) {
            // The first cycle of a task is not measured.
            _ if l.has(s, task, flag::FIRST) => TaskStatus::Idle,
            TaskStatus::Idle if self.points.cycle == Cycle::Passes => match l.thread_of(s, task) {
                _ if self.waits_to_begin(s, task) => TaskStatus::Waiting,
                // A job begins with its tick.
                thread::IDLE if l.has(s, task, flag::TICK) => TaskStatus::Running,
                _ => TaskStatus::Idle,
            },
            status => status,
        }
    }

    /// Returns the task whose start-up a task awaits before its first job: an earlier one of its component,
    /// or itself. `None`: the start-up is over.
    pub(crate) fn awaits_start_up(&self, s: &State, task: TaskId) -> Option<TaskId> {
        let l = &self.layout;
        let number = usize::from(task);
        let component = self.system.tasks[task].component;
        let tasks = &self.system.components[component].tasks;
        let starting = tasks.get(l.starting(s, component) as usize).copied();
        match self.points.start_up {
            StartUp::FirstPass => {
                let first = l.has(s, number, flag::FIRST).then_some(task);
                starting.filter(|&earlier| earlier < task).or(first)
            }
            StartUp::FirstCodel if !l.started(s, number) => starting,
            StartUp::FirstCodel => {
                let in_first_turn = |&automaton: &AutomatonId| {
                    let mode = l.mode(s, l.number_of(automaton));
                    mode == permanent::FIRST_CODEL || mode == permanent::FIRST_TURN
                };
                let own = self.system.tasks[task].permanent;
                own.filter(in_first_turn).map(|_| task)
            }
        }
    }

    /// Returns true if a tick of a task has come before its job has ended.
    #[inline]
    pub(crate) fn missed(&self, s: &State, task: usize) -> bool {
        let flags = self.layout.flags(s, task);
        let in_cycle = || flags & flag::TICK != 0 && self.in_cycle(s, task);
        flags & (flag::TICK | flag::LATE) != 0
            && flags & flag::FIRST == 0
            && self.is_periodic(task)
            && (flags & flag::LATE != 0 || in_cycle())
    }

    /// Returns true if a job waits for a core for at least the period of its task. The response time of the
    /// task must be measured.
    pub(crate) fn overdue(&self, s: &State, task: usize) -> bool {
        let (period, clock) =
            (self.system.tasks[TaskId::from(task)].period, self.layout.response[task]);
        let (Some(period), Some(clock)) = (period, clock) else {
            return false;
        };
        self.job(s, task) == TaskStatus::Waiting && s.t[clock] >= period
    }

    /// Returns true if a task may begin to wait for a core with an action.
    pub(crate) fn may_begin_to_wait(&self, action: Action, task: usize) -> bool {
        // Under preemption any thread that becomes ready may take a core.
        self.preempts() || action == Action::Release { task }
    }

    /// Returns true if [`Rules::apply`] ever refused a request for a service for lack of a slot.
    pub(crate) fn has_refused(&self, service: ServiceId) -> bool {
        self.rejected[service].get()
    }

    /// Returns true if two waiting instances of a service ever interrupted each other in [`Rules::apply`].
    pub(crate) fn has_ended_restarts(&self, service: ServiceId) -> bool {
        self.restarts[service].get()
    }

    /// Returns the task of an action; `None` for actions of control tasks and clients.
    pub(crate) fn task_of(&self, action: Action) -> Option<usize> {
        let of_executor = |executor: usize| self.task_of_executor(executor);
        match action {
            Action::Release { task }
            | Action::Grant { task }
            | Action::Tick { task }
            | Action::Begin { task }
            | Action::Wake { task } => Some(task),
            Action::Ticket { executor }
            | Action::Acquire { executor }
            | Action::Ready { executor }
            | Action::Finish { executor, .. } => of_executor(executor),
            Action::Preempt { by, .. } => of_executor(by),
            Action::Signal { .. }
            | Action::Request { .. }
            | Action::Reply { .. }
            | Action::Shut { .. }
            | Action::Mark { .. }
            | Action::Proceed { .. } => None,
        }
    }

    /// Returns the least and greatest time of an executor's work, in base units.
    pub(crate) fn duration(&self, s: &State, executor: usize) -> (Ticks, Ticks) {
        if let Some(codel) = self.codel(s, executor) {
            let codel = &self.system.codels[codel];
            return (codel.lower, codel.upper);
        }
        let l = &self.layout;
        let Some(client) = l.client_of_executor(executor) else {
            return (0, 0);
        };
        let steps = &self.system.clients[client].steps;
        let step = steps.get(l.position(s, client) as usize);
        match step.map(|step| &step.action) {
            Some(&ClientAction::Delay(lower, upper)) => (lower, upper),
            _ => (0, 0),
        }
    }

    /// Returns the work of an executor: a codel for which it takes a ticket, waits or executes, or a delay.
    /// `None` if there is none.
    pub(crate) fn work(&self, s: &State, executor: usize) -> Option<Work> {
        let l = &self.layout;
        if let Some(client) = l.client_of_executor(executor) {
            let waits = l.is_executing(s, executor);
            return waits.then_some(Work::Delay { client });
        }
        if self.points.cycle == Cycle::Jobs && l.phase(s, executor) == phase::REST {
            return None;
        }
        let codel = self.codel(s, executor)?;
        if let Some(component) = executor.checked_sub(l.threads).map(ComponentId::from) {
            return Some(Work::Control {
                codel,
                service: l.handled(s, component)?,
                number: l.codel_number(s, component) as usize,
            });
        }
        let slot = self.slot_of(s, executor)?;
        Some(Work::State {
            codel,
            task: self.task_of_executor(executor)?,
            automaton: l.automaton(s, slot)?,
            state: l.at(s, slot) as usize,
            slot,
        })
    }

    /// Returns the number of places for activities, including permanent activities. They are numbered as in
    /// [`Work::State`].
    pub(crate) fn places(&self) -> usize {
        self.layout.all_slots()
    }

    /// Returns the automaton of the activity in a place: accepted, running, or ended and not yet reported.
    pub(crate) fn activity(&self, s: &State, place: usize) -> Option<AutomatonId> {
        let l = &self.layout;
        match l.activity(s, place) {
            slot::VOID => None,
            _ => l.automaton(s, place),
        }
    }

    /// Returns an action in words. The action led from the first state to the second. `None`: the initial
    /// state.
    pub(crate) fn tell(
        &self,
        change: (&State, &State),
        action: Option<Action>,
        time: u64,
        out: &mut Vec<Moment>,
    ) {
        if !matches!(action, Some(Action::Mark { .. })) {
            self.moments(change, action, time, out);
        }
    }
}

/// The rules as single runs need them.
impl Rules<'_> {
    /// Returns the service of the request that [`Rules::apply`] has refused since the last call: for lack of
    /// a slot, by `after` or `before`, by a codel, or because nothing is left to abort.
    pub(in crate::explore) fn take_refusal(&self) -> Option<ServiceId> {
        self.refusal.take()
    }

    /// Returns the step of a client; [`Client::done`](crate::system::Client::done) after the last step, one
    /// more before the first.
    pub(in crate::explore) fn position(&self, s: &State, client: ClientId) -> usize {
        self.layout.position(s, client) as usize
    }

    /// Returns the time until the next tick of a task, and whether an earlier tick is kept for the next
    /// cycle. `None` if the task has no timer that runs.
    pub(in crate::explore) fn next_tick(&self, s: &State, task: usize) -> Option<(Ticks, bool)> {
        let l = &self.layout;
        self.counts(s, task).then(|| (l.timer(s, task), l.pending(s, task)))
    }

    /// Interrupts the activity in a place, like a service that interrupts it.
    pub(in crate::explore) fn interrupt_activity(&self, s: &mut State, place: usize) {
        let l = &self.layout;
        if let Some(task) = (0..l.tasks).find(|&task| l.slots(task).contains(&place)) {
            self.mark(s, task, place);
        }
    }

    /// Begins the shutdown of a component, if the state has a place for it ([`Clocks::ends`]), or goes on
    /// with it if it [is stuck](Self::is_stuck).
    pub(in crate::explore) fn begin_shutdown(&self, s: &mut State, component: ComponentId) {
        self.kill(s, component);
        self.skip_unstarted(s, component);
    }

    /// Returns the service whose request a control task is handling, and whether the request is already
    /// refused.
    pub(in crate::explore) fn handling(
        &self,
        s: &State,
        component: ComponentId,
    ) -> Option<(ServiceId, bool)> {
        let l = &self.layout;
        let service = l.handled(s, component)?;
        Some((service, l.refused(s, component) != 0))
    }

    /// Returns the place of the activity whose request a control task is handling; `None` if there is none,
    /// or if the place is given later.
    pub(in crate::explore) fn requested_place(
        &self,
        s: &State,
        component: ComponentId,
    ) -> Option<usize> {
        (self.layout.given(s, component) as usize).checked_sub(1)
    }
}
