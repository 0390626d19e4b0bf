//! A single run, step by step, with free choice of the actions.
//!
//! A [`Stepper`] holds one state and treats it like the explorer: the same rules determine the possible
//! actions, perform the chosen action, and let time pass. So every sequence of steps is a run of the verified
//! system. The stepper reports events on the way (jobs that end, deadlines that are missed, predicates that
//! are reached) as [`Seen`].

mod seen;

pub use self::seen::{RunState, Seen};
use super::observe::{self, Observers};
use super::rules::{Action, Enabled, IdleTurn, Rules, Work};
use super::state::{Clocks, Stages, State, TaskStatus, phase};
use crate::property::{Monitor, Predicate, monitor};
use crate::system::{
    AutomatonId, ClientId, ClientStep, ComponentId, ServiceId, TaskId, Ticks, TimedSystem,
};

/// The predicates to watch along a run, in addition to jobs and ticks.
#[derive(Debug, Clone, Default)]
pub struct Watched {
    /// Predicates that may become true.
    pub reach: Vec<Predicate>,
    /// Pairs of predicates: whenever the first becomes true, the others are awaited in order. There is at
    /// least one other.
    pub within: Vec<(Predicate, Vec<Predicate>)>,
    pub monitors: Vec<Monitor>,
    /// Number of comparisons of data.
    pub facts: usize,
}

/// The possible actions in a state.
#[derive(Debug, Default)]
pub struct Possible {
    enabled: Enabled,
}

impl Possible {
    /// Returns the actions. Any of them may be next.
    pub fn actions(&self) -> &[Action] {
        &self.enabled.actions
    }

    /// Returns true if the actions are part of the step that made them possible: no other action may come
    /// between.
    pub fn is_committed(&self) -> bool {
        self.enabled.committed
    }

    /// Returns true if time may pass first.
    pub fn may_wait(&self) -> bool {
        self.enabled.is_calm()
    }
}

/// A run under way. See the [module](self).
pub struct Stepper<'s> {
    rules: Rules<'s>,
    observers: Observers,
    reach: Vec<Predicate>,
    /// Comparisons of data that change with the next action.
    new_facts: Vec<(usize, bool)>,
    s: State,
    /// The state before the last action.
    before: State,
    /// Tasks that were reported as overdue.
    overdue: Vec<bool>,
    /// Components are being shut down, and take no requests.
    ending: bool,
    now: u64,
}

impl<'s> Stepper<'s> {
    /// Creates a stepper for runs of a system. [`Stepper::begin`] begins the first run.
    pub fn new(system: &'s TimedSystem, watched: &Watched) -> Self {
        let clocks = Clocks {
            response: vec![true; system.tasks.len()],
            within: (watched.within.iter())
                .map(|(_, responses)| Stages { count: responses.len(), measured: true })
                .collect(),
            monitors: watched.monitors.iter().map(|monitor| monitor.time > 0).collect(),
            facts: watched.facts,
            token: 0,
            ends: true,
        };
        let rules = Rules::new(system).with_clocks(&clocks);
        let within = watched.within.iter();
        let within = within.map(|(trigger, responses)| (trigger, &**responses));
        Stepper {
            observers: Observers::of(within, &watched.monitors),
            reach: watched.reach.clone(),
            new_facts: Vec::new(),
            overdue: vec![false; system.tasks.len()],
            s: rules.initial(),
            before: rules.initial(),
            ending: false,
            now: 0,
            rules,
        }
    }

    /// Begins a run at time 0, and appends its first events.
    pub fn begin(&mut self, seen: &mut Vec<Seen>) {
        self.s = self.rules.initial();
        self.new_facts.clear();
        self.ending = false;
        self.now = 0;
        self.overdue.fill(false);
        let mut met = Vec::new();
        self.observe(None, &mut met);
        self.beginnings(None, None, seen);
        for (predicate, entry) in self.reach.iter().enumerate() {
            if observe::predicate(&self.rules, None, &self.s, entry) {
                seen.push(Seen::Reached { predicate });
            }
        }
        seen.append(&mut met);
    }

    /// Returns the time since the start, in base units.
    pub fn now(&self) -> u64 {
        self.now
    }

    /// Lists the possible actions.
    pub fn possible(&self, out: &mut Possible) {
        self.rules.enabled(&self.s, &mut out.enabled);
        if self.ending {
            out.enabled.without_requests();
        }
    }

    /// Performs one of the possible actions, and appends its events.
    pub fn perform(&mut self, action: Action, seen: &mut Vec<Seen>) {
        self.before.clone_from(&self.s);
        for (fact, holds) in self.new_facts.drain(..) {
            self.rules.frame().set_fact(&mut self.s, fact, holds);
        }
        let mut ended = None;
        match action {
            Action::Finish { executor, outcome } => {
                ended = Some(executor);
                if let Some(work) = self.rules.work(&self.before, executor) {
                    seen.push(Seen::Ended { executor, work, outcome });
                }
            }
            Action::Request { client, .. } => {
                let at = self.rules.position(&self.before, client);
                let step = self.rules.system().clients[client].steps.get(at);
                if let Some(service) = step.and_then(ClientStep::requests) {
                    seen.push(Seen::Requested { client, service });
                }
            }
            _ => {}
        }
        self.rules.take_refusal();
        self.rules.apply(&mut self.s, action);
        if let Some(service) = self.rules.take_refusal() {
            seen.push(Seen::Refused { service });
        }
        let before = std::mem::take(&mut self.before);
        let mut met = Vec::new();
        self.observe(Some(&before), &mut met);
        self.before = before;
        self.jobs(seen);
        for task in 0..self.overdue.len() {
            if self.rules.missed(&self.s, task) && !self.rules.missed(&self.before, task) {
                seen.push(Seen::Missed { task });
            }
        }
        for (predicate, entry) in self.reach.iter().enumerate() {
            if observe::predicate(&self.rules, Some(&self.before), &self.s, entry)
                && !entry.eval_still(&|atom| self.rules.atom(&self.before, atom))
            {
                seen.push(Seen::Reached { predicate });
            }
        }
        seen.append(&mut met);
        self.beginnings(Some(&self.before), ended, seen);
        self.note_overdue(seen);
    }

    /// Sets a comparison of data, from the next action on.
    pub fn set_fact(&mut self, fact: usize, holds: bool) {
        self.new_facts.push((fact, holds));
    }

    /// Sets the duration, in base units, of the work that an executor has just begun. It must be a possible
    /// duration.
    pub fn decide(&mut self, executor: usize, time: Ticks) {
        let l = self.rules.frame();
        let (a, b) = l.window(&self.s, executor);
        // A window within the present window: fewer runs, all of them runs of the system.
        let time = time.clamp(a, b);
        l.set_window(&mut self.s, executor, (time, time));
    }

    /// Returns the work of an executor: a codel for which it takes a ticket, waits or executes, or a delay.
    /// `None` if there is none.
    pub fn work(&self, executor: usize) -> Option<Work> {
        let known = executor < self.executors();
        known.then(|| self.rules.work(&self.s, executor)).flatten()
    }

    /// Returns the service that a client requests next, if its next step is a request.
    pub fn requests(&self, client: ClientId) -> Option<ServiceId> {
        let at = self.rules.position(&self.s, client);
        let client = self.rules.system().clients.get(client)?;
        client.steps.get(at)?.requests()
    }

    /// Returns the number of executors.
    pub fn executors(&self) -> usize {
        self.rules.frame().executors()
    }

    /// Returns the least and the greatest time until the end of an executor's work, in base units; `None` if
    /// it executes nothing.
    pub fn window(&self, executor: usize) -> Option<(Ticks, Ticks)> {
        let l = self.rules.frame();
        let executes = executor < l.executors() && l.is_executing(&self.s, executor);
        executes.then(|| l.window(&self.s, executor))
    }

    /// Changes the remaining time of an executor's work. A system has no such action, but a replay may need
    /// it. If the new window lies within the present [window](Self::window), the run remains one of the
    /// system.
    pub fn set_window(&mut self, executor: usize, window: (Ticks, Ticks)) {
        if self.window(executor).is_some() {
            let l = self.rules.frame();
            l.set_window(&mut self.s, executor, window);
        }
    }

    /// Returns the time for which no new action is possible, in base units. `None`: no action will ever be
    /// possible.
    pub fn next_moment(&self) -> Option<Ticks> {
        self.next_moment_but(&|_| false)
    }

    /// Returns the time for which no new action is possible, in base units, if the executors with
    /// `can_be_deferred` may end at any time.
    pub fn next_moment_but(&self, can_be_deferred: &dyn Fn(usize) -> bool) -> Option<Ticks> {
        self.rules.next_moment(&self.s, can_be_deferred)
    }

    /// The same, but ticks of the tasks that `is_skipped` selects do not count.
    pub fn next_moment_without_ticks(
        &self,
        can_be_deferred: &dyn Fn(usize) -> bool,
        is_skipped: &dyn Fn(usize) -> bool,
    ) -> Option<Ticks> {
        let rules = &self.rules;
        rules.next_moment_without_ticks(&self.s, can_be_deferred, is_skipped)
    }

    /// Returns the only work of a task in its next cycle; `None` if the task is in a cycle, may have to wait
    /// for a core, or if something else than this work may follow.
    pub fn idle_turn(&self, task: TaskId) -> Option<IdleTurn> {
        self.rules.idle_turn(&self.s, task.into())
    }

    /// Returns the time until the next tick of a task, in base units, and whether an earlier tick is kept for
    /// the next cycle. `None` if the task has no timer that runs.
    pub fn tick(&self, task: TaskId) -> Option<(Ticks, bool)> {
        self.rules.next_tick(&self.s, task.into())
    }

    /// Returns true if a client has taken its last step.
    pub fn has_ended(&self, client: ClientId) -> bool {
        let end = self.rules.system().clients[client].done();
        self.rules.position(&self.s, client) == end
    }

    /// Lets time pass, at most until the next moment, and appends the events of that moment.
    pub fn pass(&mut self, time: Ticks, seen: &mut Vec<Seen>) {
        self.rules.elapse(&mut self.s, time);
        self.now += u64::from(time);
        self.note_overdue(seen);
    }

    /// Returns the number of places for activities. They are numbered as in [`Work::State`].
    pub fn places(&self) -> usize {
        self.rules.places()
    }

    /// Returns the automaton of the activity in a place: accepted, running, or ended and not yet reported.
    pub fn activity(&self, place: usize) -> Option<AutomatonId> {
        self.rules.activity(&self.s, place)
    }

    /// Interrupts the activity in a place, like a service that interrupts it. A system has no such action,
    /// but a run on the real clock may need it.
    pub fn interrupt(&mut self, place: usize) {
        self.rules.interrupt_activity(&mut self.s, place);
    }

    /// Begins the shutdown of every component, as their clients' `kill` does: activities are interrupted,
    /// then the permanent activities. No more requests are taken. A system has no such action, but the end of
    /// a run needs it. Under the published semantics, which have no shutdown, activities are interrupted, and
    /// permanent ones go on. A shutdown that [is stuck](Self::is_stuck) goes on.
    pub fn shut_down(&mut self) {
        self.ending = true;
        for component in self.rules.system().components.keys() {
            self.rules.begin_shutdown(&mut self.s, component);
        }
    }

    /// Returns true if some shutdown waits for a task that was never started, because the start-up of an
    /// earlier task has failed.
    pub fn is_stuck(&self) -> bool {
        let mut components = self.rules.system().components.keys();
        components.any(|component| self.rules.is_stuck(&self.s, component))
    }

    /// Returns true if a component has ended after [`shut_down`](Self::shut_down).
    pub fn is_shut_down(&self, component: ComponentId) -> bool {
        self.rules.is_shut_down(&self.s, component)
    }

    /// Returns the service whose request the control task of a component is handling, and whether the request
    /// is already refused. (Under the published semantics only the end of the validation shows that.)
    pub fn handling(&self, component: ComponentId) -> Option<(ServiceId, bool)> {
        self.rules.handling(&self.s, component)
    }

    /// Returns true if a request for a service was ever refused for lack of a slot.
    pub fn has_refused(&self, service: ServiceId) -> bool {
        self.rules.has_refused(service)
    }
}

impl Stepper<'_> {
    /// Appends the work that executors began in a step; `ended` is the executor whose work has ended in the
    /// step.
    fn beginnings(&self, before: Option<&State>, ended: Option<usize>, seen: &mut Vec<Seen>) {
        let l = self.rules.frame();
        for executor in 0..l.executors() {
            let now = l.phase(&self.s, executor);
            let was = before.map_or(phase::REST, |state| l.phase(state, executor));
            if now == phase::REST || (now == was && ended != Some(executor)) {
                continue;
            }
            let Some(work) = self.rules.work(&self.s, executor) else {
                continue;
            };
            if was == phase::REST || ended == Some(executor) {
                seen.push(Seen::Asked { executor, work });
            }
            if l.is_executing(&self.s, executor) {
                let time = self.rules.duration(&self.s, executor);
                seen.push(Seen::Begun { executor, work, time });
            }
        }
    }

    fn observe(&mut self, before: Option<&State>, seen: &mut Vec<Seen>) {
        let met = |within, after| seen.push(Seen::Answered { within, after });
        observe::observe_with_reports(&self.rules, &self.observers, before, &mut self.s, met);
        let l = self.rules.frame();
        for (number, monitor) in self.observers.monitors.iter().enumerate() {
            let was = before.is_some_and(|before| opens(&self.rules, monitor, before));
            let location = |s: &State| l.monitor(s, number);
            let step = (before.map_or(monitor::INITIAL, location), location(&self.s));
            if monitor.is_exercised(step, !was && opens(&self.rules, monitor, &self.s)) {
                seen.push(Seen::Opened { monitor: number });
            }
            // The monitor begins again: a run may violate it several times.
            if l.monitor(&self.s, number) == monitor::VIOLATED {
                l.set_monitor(&mut self.s, number, monitor::INITIAL);
                seen.push(Seen::Violated { monitor: number });
            }
        }
    }

    fn jobs(&self, seen: &mut Vec<Seen>) {
        let l = self.rules.frame();
        let (before, now) = (&self.before, &self.s);
        for (task, clock) in l.response.iter().enumerate() {
            let Some(clock) = *clock else { continue };
            if self.rules.job(before, task) == TaskStatus::Idle {
                continue;
            }
            // A kept tick begins the next job at once, with a smaller value of its clock.
            let over =
                self.rules.job(now, task) == TaskStatus::Idle || now.t[clock] < before.t[clock];
            if over {
                let response = before.t[clock];
                seen.push(Seen::Job { task, response });
            }
        }
    }

    fn note_overdue(&mut self, seen: &mut Vec<Seen>) {
        for task in 0..self.overdue.len() {
            let now = self.rules.overdue(&self.s, task);
            if now && !std::mem::replace(&mut self.overdue[task], now) {
                seen.push(Seen::Overdue { task });
            }
            self.overdue[task] = now;
        }
    }
}

impl RunState for Stepper<'_> {
    fn now(&self) -> u64 {
        self.now
    }

    fn knows_fact(&self, fact: usize) -> bool {
        self.rules.frame().fact(&self.s, fact).is_some()
    }

    fn job(&self, task: usize) -> Option<Ticks> {
        let clock = self.rules.frame().response[task]?;
        (self.rules.job(&self.s, task) != TaskStatus::Idle).then(|| self.s.t[clock])
    }

    fn awaited(&self, within: usize) -> Option<Ticks> {
        let l = self.rules.frame();
        let clock = l.observer_clock(&self.s, within)?;
        l.is_open(&self.s, within).then(|| self.s.t[clock])
    }
}

impl std::fmt::Debug for Stepper<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Stepper").field("now", &self.now()).finish_non_exhaustive()
    }
}

/// Returns true if what a monitor watches can begin in a state.
fn opens(rules: &Rules, monitor: &Monitor, s: &State) -> bool {
    monitor.opening().eval_still(&|atom| rules.atom(s, atom))
}
