//! One run, step by step, for whoever chooses what happens.
//!
//! A [`Stepper`] holds one state and does what the explorer does with each of its states: it asks the same
//! rules what is possible, performs what it is told, and lets time pass. So whatever is done with it is a
//! run of the verified system. What it sees on the way (jobs that end, ticks that come too early,
//! predicates that are reached) it tells as [`Seen`].

use super::observe::{self, Observer};
use super::rules::{Action, Enabled, Rules, Work, with_rules};
use super::state::{Clocks, Stages, State, TaskStatus, phase};
use crate::property::Predicate;
use crate::system::{Ticks, TimedSystem};

/// What is looked at along a run, beside jobs and ticks.
#[derive(Debug, Clone, Default)]
pub struct Watched {
    /// Predicates that may become true.
    pub reach: Vec<Predicate>,
    /// Whenever the first becomes true, the others are awaited, one after the other; there is at least one.
    pub within: Vec<(Predicate, Vec<Predicate>)>,
}

/// What was seen in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// An executor asks for the locks of a codel; often it gets them at the same moment.
    Asked {
        /// The executor.
        executor: usize,
        /// What it is about to do.
        work: Work,
    },
    /// An executor begins something that takes time.
    Begun {
        /// The executor.
        executor: usize,
        /// What.
        work: Work,
        /// Least and greatest time that it takes.
        time: (Ticks, Ticks),
    },
    /// What an executor did has ended.
    Ended {
        /// The executor.
        executor: usize,
        /// What it did.
        work: Work,
        /// As in [`Action::Finish`].
        outcome: usize,
    },
    /// A control task has taken a request.
    Requested {
        /// The client that sent it.
        client: usize,
        /// The service.
        service: usize,
    },
    /// A job has ended that is measured.
    Job {
        /// Its task.
        task: usize,
        /// Its response time.
        response: Ticks,
    },
    /// A tick has come before the job of the one before has ended.
    Missed {
        /// The task.
        task: usize,
    },
    /// A job waits for a core for as long as the period of its task.
    Overdue {
        /// The task.
        task: usize,
    },
    /// A predicate of [`Watched::reach`] has become true.
    Reached {
        /// Which.
        predicate: usize,
    },
    /// The second predicate of a pair of [`Watched::within`] has followed the first.
    Answered {
        /// Which pair.
        within: usize,
        /// How long afterwards.
        after: Ticks,
    },
}

/// What can happen in a state.
#[derive(Debug, Default)]
pub struct Possible {
    enabled: Enabled,
}

impl Possible {
    /// The actions. Where there are several any of them may be next.
    pub fn actions(&self) -> &[Action] {
        &self.enabled.actions
    }

    /// Whether they are part of the step that made them possible: nothing else may come between.
    pub fn is_committed(&self) -> bool {
        self.enabled.committed
    }

    /// Whether time may pass first.
    pub fn may_wait(&self) -> bool {
        self.enabled.is_calm()
    }
}

/// See the [module](self).
pub struct Stepper<'s> {
    walk: Box<dyn Walk + 's>,
}

impl<'s> Stepper<'s> {
    /// For runs of a system. [`Stepper::begin`] begins the first.
    pub fn new(system: &'s TimedSystem, watched: &Watched) -> Self {
        with_rules!(system, walk(watched))
    }

    /// Begins a run at time 0, and adds what is to be seen there.
    pub fn begin(&mut self, seen: &mut Vec<Seen>) {
        self.walk.begin(seen);
    }

    /// Base units since the start.
    pub fn now(&self) -> u64 {
        self.walk.now()
    }

    /// Lists what can happen.
    pub fn possible(&self, out: &mut Possible) {
        self.walk.possible(&mut out.enabled);
    }

    /// Does one of the possible actions, and adds what is to be seen of it.
    pub fn perform(&mut self, action: Action, seen: &mut Vec<Seen>) {
        self.walk.perform(action, seen);
    }

    /// Decides how long what an executor has just begun takes: it must be one of the times it may take.
    pub fn decide(&mut self, executor: usize, time: Ticks) {
        self.walk.decide(executor, time);
    }

    /// What an executor takes a ticket or waits for, or executes; `None` if that is nothing.
    pub fn work(&self, executor: usize) -> Option<Work> {
        self.walk.work(executor)
    }

    /// The service that a client requests next, if its next step is a request.
    pub fn requests(&self, client: usize) -> Option<usize> {
        self.walk.requests(client)
    }

    /// How many executors there are.
    pub fn executors(&self) -> usize {
        self.walk.executors()
    }

    /// The least and the greatest time until what an executor executes may end, and must; `None` if it
    /// executes nothing.
    pub fn window(&self, executor: usize) -> Option<(Ticks, Ticks)> {
        self.walk.window(executor)
    }

    /// Decides anew when what an executor executes may end, and must: nothing of the system does that, but
    /// whoever follows another run may have to. Within the [window](Self::window) it had the run stays one of
    /// the system.
    pub fn set_window(&mut self, executor: usize, window: (Ticks, Ticks)) {
        self.walk.set_window(executor, window);
    }

    /// How long nothing new is possible. `None`: nothing will ever happen again.
    pub fn next_moment(&self) -> Option<Ticks> {
        self.walk.next_moment(&|_| false)
    }

    /// Likewise, where some executors may end at any time, which is no new possibility.
    pub fn next_moment_but(&self, can_wait: &dyn Fn(usize) -> bool) -> Option<Ticks> {
        self.walk.next_moment(can_wait)
    }

    /// Lets time pass, at most until the next moment, and adds what is to be seen then.
    pub fn pass(&mut self, time: Ticks, seen: &mut Vec<Seen>) {
        self.walk.pass(time, seen);
    }

    /// How long a task's job has lasted, if it has one that is measured.
    pub fn job(&self, task: usize) -> Option<Ticks> {
        self.walk.job(task)
    }

    /// How long the second predicate of a pair has been awaited, if it is.
    pub fn awaited(&self, within: usize) -> Option<Ticks> {
        self.walk.awaited(within)
    }

    /// How many places for activities there are. They are numbered as in [`Work::State`].
    pub fn places(&self) -> usize {
        self.walk.places()
    }

    /// The automaton of the activity that has a place: accepted, running, or ended and not yet reported.
    pub fn activity(&self, place: usize) -> Option<usize> {
        self.walk.activity(place)
    }

    /// Interrupts the activity that has a place, as a service that interrupts it would: nothing of the system
    /// does that, but whoever runs it may.
    pub fn interrupt(&mut self, place: usize) {
        self.walk.interrupt(place);
    }

    /// The service whose request the control task of a component is handling, and whether it is already
    /// refused. (Under the published semantics only the end of a codel that validates tells that.)
    pub fn handling(&self, component: usize) -> Option<(usize, bool)> {
        self.walk.handling(component)
    }

    /// Whether a request for a service was ever refused for want of a slot.
    pub fn has_refused(&self, service: usize) -> bool {
        self.walk.has_refused(service)
    }
}

impl std::fmt::Debug for Stepper<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Stepper")
            .field("now", &self.now())
            .finish_non_exhaustive()
    }
}

/// A stepper, whatever the rules.
trait Walk {
    fn begin(&mut self, seen: &mut Vec<Seen>);
    fn now(&self) -> u64;
    fn possible(&self, out: &mut Enabled);
    fn perform(&mut self, action: Action, seen: &mut Vec<Seen>);
    fn decide(&mut self, executor: usize, time: Ticks);
    fn work(&self, executor: usize) -> Option<Work>;
    fn requests(&self, client: usize) -> Option<usize>;
    fn executors(&self) -> usize;
    fn window(&self, executor: usize) -> Option<(Ticks, Ticks)>;
    fn set_window(&mut self, executor: usize, window: (Ticks, Ticks));
    fn next_moment(&self, can_wait: &dyn Fn(usize) -> bool) -> Option<Ticks>;
    fn pass(&mut self, time: Ticks, seen: &mut Vec<Seen>);
    fn job(&self, task: usize) -> Option<Ticks>;
    fn awaited(&self, within: usize) -> Option<Ticks>;
    fn places(&self) -> usize;
    fn activity(&self, place: usize) -> Option<usize>;
    fn interrupt(&mut self, place: usize);
    fn handling(&self, component: usize) -> Option<(usize, bool)>;
    fn has_refused(&self, service: usize) -> bool;
}

fn walk<'s, R: Rules + 's>(rules: &R, watched: &Watched) -> Stepper<'s> {
    let clocks = Clocks {
        response: vec![true; rules.system().tasks.len()],
        within: (watched.within.iter())
            .map(|(_, responses)| Stages {
                count: responses.len(),
                measured: true,
            })
            .collect(),
        token: 0,
    };
    let rules = rules.with_clocks(&clocks);
    let observers = watched.within.iter().map(|(trigger, responses)| Observer {
        trigger: trigger.clone(),
        responses: responses.clone(),
    });
    let walker = Walker {
        observers: observers.collect(),
        reach: watched.reach.clone(),
        overdue: vec![false; rules.system().tasks.len()],
        s: rules.initial(),
        before: rules.initial(),
        now: 0,
        rules,
    };
    Stepper {
        walk: Box::new(walker),
    }
}

struct Walker<R: Rules> {
    rules: R,
    observers: Vec<Observer>,
    reach: Vec<Predicate>,
    s: State,
    /// The state before the last action.
    before: State,
    /// Tasks that are known to be overdue.
    overdue: Vec<bool>,
    now: u64,
}

impl<R: Rules> Walker<R> {
    /// What executors began in a step; `ended` is the one whose work has ended in it.
    fn beginnings(&self, before: Option<&State>, ended: Option<usize>, seen: &mut Vec<Seen>) {
        let l = self.rules.frame();
        for executor in 0..l.executors() {
            let now = l.phase(&self.s, executor);
            let was = before.map_or(phase::REST, |it| l.phase(it, executor));
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
                seen.push(Seen::Begun {
                    executor,
                    work,
                    time,
                });
            }
        }
    }

    fn observe(&mut self, before: Option<&State>, seen: &mut Vec<Seen>) {
        let met = |within, after| seen.push(Seen::Answered { within, after });
        observe::observe_telling(&self.rules, &self.observers, before, &mut self.s, met);
    }

    fn jobs(&self, seen: &mut Vec<Seen>) {
        let l = self.rules.frame();
        let (before, now) = (&self.before, &self.s);
        for (task, clock) in l.response.iter().enumerate() {
            let Some(clock) = *clock else { continue };
            if self.rules.job(before, task) == TaskStatus::Idle {
                continue;
            }
            // A tick that was kept begins the next job at once: its clock shows less.
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

impl<R: Rules> Walk for Walker<R> {
    fn begin(&mut self, seen: &mut Vec<Seen>) {
        self.s = self.rules.initial();
        self.now = 0;
        self.overdue.fill(false);
        let mut met = Vec::new();
        self.observe(None, &mut met);
        self.beginnings(None, None, seen);
        for (predicate, it) in self.reach.iter().enumerate() {
            if observe::predicate(&self.rules, None, &self.s, it) {
                seen.push(Seen::Reached { predicate });
            }
        }
        seen.append(&mut met);
    }

    fn now(&self) -> u64 {
        self.now
    }

    fn possible(&self, out: &mut Enabled) {
        self.rules.enabled(&self.s, out);
    }

    fn perform(&mut self, action: Action, seen: &mut Vec<Seen>) {
        self.before.clone_from(&self.s);
        let mut ended = None;
        match action {
            Action::Finish { executor, outcome } => {
                ended = Some(executor);
                if let Some(work) = self.rules.work(&self.before, executor) {
                    seen.push(Seen::Ended {
                        executor,
                        work,
                        outcome,
                    });
                }
            }
            Action::Request { client, .. } => {
                let at = self.rules.position(&self.before, client);
                let step = self.rules.system().clients[client].steps.get(at);
                if let Some(service) = step.and_then(|it| it.requests()) {
                    seen.push(Seen::Requested { client, service });
                }
            }
            _ => {}
        }
        self.rules.apply(&mut self.s, action);
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
        for (predicate, it) in self.reach.iter().enumerate() {
            if observe::predicate(&self.rules, Some(&self.before), &self.s, it)
                && !it.eval_still(&|atom| self.rules.atom(&self.before, atom))
            {
                seen.push(Seen::Reached { predicate });
            }
        }
        seen.append(&mut met);
        self.beginnings(Some(&self.before), ended, seen);
        self.note_overdue(seen);
    }

    fn decide(&mut self, executor: usize, time: Ticks) {
        let l = self.rules.frame();
        let (a, b) = l.window(&self.s, executor);
        // A window within the window: fewer runs, all of them runs of the system.
        let time = time.clamp(a, b);
        l.set_window(&mut self.s, executor, (time, time));
    }

    fn work(&self, executor: usize) -> Option<Work> {
        let known = executor < self.executors();
        known.then(|| self.rules.work(&self.s, executor)).flatten()
    }

    fn requests(&self, client: usize) -> Option<usize> {
        let at = self.rules.position(&self.s, client);
        let client = self.rules.system().clients.get(client)?;
        client.steps.get(at)?.requests()
    }

    fn executors(&self) -> usize {
        self.rules.frame().executors()
    }

    fn window(&self, executor: usize) -> Option<(Ticks, Ticks)> {
        let l = self.rules.frame();
        let executes = executor < l.executors() && l.is_executing(&self.s, executor);
        executes.then(|| l.window(&self.s, executor))
    }

    fn set_window(&mut self, executor: usize, window: (Ticks, Ticks)) {
        if self.window(executor).is_some() {
            let l = self.rules.frame();
            l.set_window(&mut self.s, executor, window);
        }
    }

    fn next_moment(&self, can_wait: &dyn Fn(usize) -> bool) -> Option<Ticks> {
        self.rules.next_moment(&self.s, can_wait)
    }

    fn pass(&mut self, time: Ticks, seen: &mut Vec<Seen>) {
        self.rules.elapse(&mut self.s, time);
        self.now += u64::from(time);
        self.note_overdue(seen);
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

    fn places(&self) -> usize {
        self.rules.places()
    }

    fn activity(&self, place: usize) -> Option<usize> {
        self.rules.activity(&self.s, place)
    }

    fn interrupt(&mut self, place: usize) {
        self.rules.interrupt_activity(&mut self.s, place);
    }

    fn handling(&self, component: usize) -> Option<(usize, bool)> {
        self.rules.handling(&self.s, component)
    }

    fn has_refused(&self, service: usize) -> bool {
        self.rules.has_refused(service)
    }
}
