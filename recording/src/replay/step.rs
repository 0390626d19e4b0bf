//! The steps of a recorded run, and the possible actions of a model, in common names.

use dotgen_timing::explore::{Action, Stepper, Work};
use dotgen_timing::system::{ClientId, ComponentId, TaskId, TimedSystem, Yield};

/// The outcome of a codel that throws an exception.
pub(super) const EXCEPTION: &str = "exception";

/// The rule of a step. The numbers are sections of the timed semantics.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// A tick comes (4, 21).
    Tick,
    /// A task is released (4).
    Release,
    /// A task gets a core (9).
    Grant,
    /// A thread takes the core of another (22).
    Preempt,
    /// Threads become ready in an order (22).
    Ready,
    /// A task begins a pass (21).
    Pass,
    /// A codel takes a ticket (21).
    Ticket,
    /// A codel gets its locks (6, 21).
    Locks,
    /// A codel ends, at some time and with an outcome (2, 5).
    End,
    /// A delay of a client ends (14).
    Delay,
    /// A task wakes the others of its component (21).
    Wake,
    /// A control task takes a request (7).
    Request,
    /// A control task has executed its codels, and replies (21).
    Reply,
    /// A control task handles the end of activities (7, 21).
    Signal,
    /// A killed component proceeds with its shutdown (18).
    Shut,
    /// A client proceeds to its next step (14).
    Proceed,
    /// An activity is interrupted from outside.
    Abort,
    /// The run ends: its components are shut down (18).
    Stop,
}

impl Rule {
    /// Returns the rule in words.
    pub fn describe(self) -> &'static str {
        match self {
            Rule::Tick => "ticks come each period, from the start of their clock",
            Rule::Release => "a task is released by its tick",
            Rule::Grant => "cores are granted by the policy",
            Rule::Preempt | Rule::Ready => "the operating system gives cores by the policy",
            Rule::Pass => "a task begins a pass when it is runnable",
            Rule::Ticket => "a codel takes a ticket when its turn has come",
            Rule::Locks => {
                "a codel gets its locks when no other codel has them, in the order of the queue"
            }
            Rule::End => "a codel ends within its time, with one of its yields",
            Rule::Delay => "a delay ends within its time",
            Rule::Wake => "a task wakes the others of its component when a pass ends",
            Rule::Request => "a control task takes what a client sends, one request at a time",
            Rule::Reply => "a control task replies when its codels have ended",
            Rule::Signal => "the end of an activity is handled by the control task",
            Rule::Shut => "a component that is killed ends what it executes",
            Rule::Proceed => "a client goes on when what it waits for has come",
            Rule::Abort => "an activity is interrupted by services that say so",
            Rule::Stop => "a run ends when its components are shut down",
        }
    }
}

#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Step {
    /// Time since the start, in units of the system.
    pub time: u64,
    pub rule: Rule,
    /// Subject: a task, a component or a client.
    pub of: String,
    /// Object: a codel, a service or a thread.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub what: String,
    /// Outcome: the yield of a codel, the next step of a client.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub to: String,
    /// Execution time of the codel that ends, in nanoseconds, if it was executed on the real clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub executed: Option<u64>,
}

impl Step {
    /// Returns the step that corresponds to a possible action.
    pub fn new(system: &TimedSystem, stepper: &Stepper, action: Action) -> Step {
        let task = |task: usize| system.task_path(TaskId::from(task));
        let component = |component: ComponentId| system.components[component].name.clone();
        let client = |client: ClientId| system.clients[client].name.clone();
        let thread = |executor: usize| match stepper.work(executor) {
            Some(work) => subject_name(system, &work),
            None => format!("#{executor}"),
        };
        let what = |executor: usize| {
            let work = stepper.work(executor);
            work.map_or(String::new(), |work| describe_work(system, &work))
        };
        let none = String::new;
        let (rule, of, what, to) = match action {
            Action::Tick { task: index } => (Rule::Tick, task(index), none(), none()),
            Action::Release { task: index } => (Rule::Release, task(index), none(), none()),
            Action::Grant { task: index } => (Rule::Grant, task(index), none(), none()),
            Action::Begin { task: index } => (Rule::Pass, task(index), none(), none()),
            Action::Wake { task: index } => (Rule::Wake, task(index), none(), none()),
            Action::Ticket { executor } => (Rule::Ticket, thread(executor), what(executor), none()),
            Action::Acquire { executor } => (Rule::Locks, thread(executor), what(executor), none()),
            Action::Finish { executor, outcome } => {
                let work = stepper.work(executor);
                let rule = match work {
                    Some(Work::Delay { .. }) => Rule::Delay,
                    _ => Rule::End,
                };
                let to = work.map_or(none(), |work| outcome_of(system, &work, outcome));
                (rule, thread(executor), what(executor), to)
            }
            Action::Preempt { executor, by } => {
                (Rule::Preempt, format!("#{by}"), format!("#{executor}"), none())
            }
            Action::Ready { executor } => (Rule::Ready, format!("#{executor}"), none(), none()),
            Action::Reply { component: index } => (Rule::Reply, component(index), none(), none()),
            Action::Shut { component: index } => (Rule::Shut, component(index), none(), none()),
            Action::Signal { component: index } => (Rule::Signal, component(index), none(), none()),
            Action::Proceed { client: index, next } => {
                (Rule::Proceed, client(index), none(), next.to_string())
            }
            Action::Request { client: index, next } => {
                let what = stepper.requests(index);
                let what = what.map_or(none(), |request| system.service_path(request));
                (Rule::Request, client(index), what, next.to_string())
            }
            // Not a step of a run.
            Action::Mark { .. } => (Rule::Proceed, none(), none(), none()),
        };
        Step { time: stepper.now(), rule, of, what, to, executed: None }
    }

    /// Returns the step of an interruption from outside, by the place of the activity.
    pub fn abort(system: &TimedSystem, stepper: &Stepper, place: usize) -> Step {
        let service = stepper.activity(place);
        let service = service.and_then(|service| system.automata.get(service)?.service);
        Step {
            time: stepper.now(),
            rule: Rule::Abort,
            of: service.map_or(String::new(), |service| system.service_path(service)),
            what: place.to_string(),
            to: String::new(),
            executed: None,
        }
    }

    /// Returns the step that begins the end of a run.
    pub fn stop(stepper: &Stepper) -> Step {
        let none = String::new;
        Step {
            time: stepper.now(),
            rule: Rule::Stop,
            of: none(),
            what: none(),
            to: none(),
            executed: None,
        }
    }

    /// Returns true if both are the same step of the model, whatever a codel really took.
    pub(super) fn is_alike(&self, other: &Step) -> bool {
        let parts = |step: &Step| {
            let Step { time, rule, of, what, to, executed: _ } = step.clone();
            (time, rule, of, what, to)
        };
        parts(self) == parts(other)
    }

    /// Returns the step in words, without its time.
    pub fn describe(&self) -> String {
        let Step { of, what, to, .. } = self;
        match self.rule {
            Rule::Tick => format!("a tick of `{of}`"),
            Rule::Release => format!("`{of}` is released"),
            Rule::Grant => format!("`{of}` gets a core"),
            Rule::Preempt => format!("thread {of} takes the core of thread {what}"),
            Rule::Ready => format!("thread {of} is ready"),
            Rule::Pass => format!("`{of}` begins a pass"),
            Rule::Ticket => format!("`{what}` takes a ticket"),
            Rule::Locks => format!("`{what}` gets its locks"),
            Rule::End => format!("`{what}` ends with `{to}`"),
            Rule::Delay => format!("a delay of client `{of}` ends"),
            Rule::Wake => format!("`{of}` wakes the other tasks"),
            Rule::Request => format!("client `{of}` requests `{what}`"),
            Rule::Reply => format!("the control task of `{of}` replies"),
            Rule::Signal => format!("the control task of `{of}` handles what has ended"),
            Rule::Shut => format!("`{of}` gets on with its end"),
            Rule::Proceed => format!("client `{of}` goes on"),
            Rule::Abort => format!("a request from outside interrupts `{of}`"),
            Rule::Stop => "the run begins to end".to_owned(),
        }
    }
}

/// Returns the subject that executes some work.
fn subject_name(system: &TimedSystem, work: &Work) -> String {
    match *work {
        Work::State { task, .. } => system.task_path(TaskId::from(task)),
        Work::Control { service, .. } => {
            system.components[system.services[service].component].name.clone()
        }
        Work::Delay { client } => system.clients[client].name.clone(),
    }
}

/// Returns the work in words. The place distinguishes an activity from others of its service.
fn describe_work(system: &TimedSystem, work: &Work) -> String {
    match *work {
        Work::State { codel, slot, .. } => format!("{}#{slot}", system.codels[codel].path),
        Work::Control { codel, number, .. } => format!("{}#{number}", system.codels[codel].path),
        Work::Delay { .. } => String::new(),
    }
}

fn outcome_of(system: &TimedSystem, work: &Work, outcome: usize) -> String {
    match *work {
        Work::State { automaton, state, .. } => {
            let machine = system.machine_of(automaton);
            let name =
                |index: usize| machine.states.get(index).map_or("", |state| state.name.as_str());
            let yields = machine.states.get(state).map(|state| state.yields.as_slice());
            match yields.and_then(|state| state.get(outcome)) {
                Some(&Yield::Next(to)) => name(to).to_owned(),
                Some(&Yield::Pause(to)) => format!("pause::{}", name(to)),
                Some(Yield::End) => "ether".to_owned(),
                None => EXCEPTION.to_owned(),
            }
        }
        Work::Control { .. } if outcome == 0 => "ok".to_owned(),
        Work::Control { .. } => EXCEPTION.to_owned(),
        Work::Delay { .. } => outcome.to_string(),
    }
}
