//! What the threads of interest do during a measured time at the end of a run: intervals without gaps, which
//! add up to that time.

use std::cell::Cell;

use super::observe::{self, Observer, Observers};
use super::rules::{Action, Rules, Work};
use super::run::{Run, advance};
use super::state::{Clocks, Stages, State, TaskStatus};
use super::watch::Within;
use crate::property::{Atom, Predicate};
use crate::system::{
    ClientId, CodelId, ComponentId, MachineId, ServiceId, TaskId, Ticks, TimedSystem,
};

/// Intervals of the runs of a chain. See [`Span`].
#[derive(Debug, Clone, Default)]
pub struct ChainSpans {
    /// The measured time, up to the end of the run that exceeds the limit, or else of the longest run.
    pub late: Vec<Span>,
    /// The part of the longest run that repeats for ever.
    pub cycle: Vec<Span>,
    /// The codels that the thread that has to act at its end executes in that part.
    pub codels: Vec<CodelId>,
}

/// An interval of a run, and how it is spent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Span {
    /// Start, in base units.
    pub from: u64,
    /// End, in base units.
    pub until: u64,
    pub spent: Spent,
    /// An execution begins with the interval; false if it goes on after a preemption.
    pub begins: bool,
}

/// How an interval is spent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spent {
    Executes(CodelId),
    /// The codel has begun, and other threads have its core.
    Preempted(CodelId),
    /// The codel waits for its locks, which the `holder` has.
    Locks {
        codel: CodelId,
        holder: Option<CodelId>,
    },
    /// The job of the task waits for a core.
    Core(TaskId),
    /// The task is between two jobs.
    Between(TaskId),
    /// No request for the service is accepted.
    Unrequested(ServiceId),
    /// The control task of the component handles nothing.
    Control(ComponentId),
    /// The client has not come to the awaited step.
    Client(ClientId),
    /// Nothing that the run names.
    Nothing,
}

/// The subject of a codel or of an atom: what has to act.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Subject {
    /// A task, with all that it executes.
    Job(TaskId),
    /// A task, for its permanent activity, or for an activity of the service.
    Task(TaskId, Option<ServiceId>),
    Service(ServiceId),
    Component(ComponentId),
    Client(ClientId),
}

impl Subject {
    /// Returns the subject of a codel; `None` if nothing executes the codel.
    pub(super) fn of_codel(system: &TimedSystem, codel: CodelId) -> Option<Subject> {
        let mut machines = system.machines.iter_enumerated();
        let machine =
            machines.find(|(_, machine)| machine.states.iter().any(|state| state.codel == codel));
        if let Some((machine, _)) = machine {
            return Subject::of_machine(system, machine);
        }
        let mut services = system.services.iter_enumerated();
        let service = services.find(|(_, service)| {
            service.validate == Some(codel) || service.simple.contains(&codel)
        });
        service.map(|(service, _)| Subject::Service(service))
    }

    fn of_machine(system: &TimedSystem, machine: MachineId) -> Option<Subject> {
        let automaton = system.automata.iter().find(|automaton| automaton.machine == machine)?;
        Some(Subject::Task(automaton.task, automaton.service))
    }

    /// Returns the subject of a predicate; `None` if it is about several subjects.
    fn of_predicate(system: &TimedSystem, predicate: &Predicate) -> Option<Subject> {
        let of_atom = |atom: &Atom| match *atom {
            Atom::Task(task, _) => Some(Subject::Job(task)),
            Atom::State { machine, .. } => Subject::of_machine(system, machine),
            Atom::Slot(service, _) => {
                let slot = system.services[service].slots.first()?;
                Some(Subject::Task(system.automata[*slot].task, Some(service)))
            }
            Atom::Handling { service, .. } => Some(Subject::Service(service)),
            Atom::ControlBusy(component) => Some(Subject::Component(component)),
            Atom::Client(client, _) => Some(Subject::Client(client)),
            Atom::Tick(task) => Some(Subject::Job(task)),
            Atom::Data { .. } | Atom::Violated(_) => None,
        };
        let mut all = Vec::new();
        predicate.atoms(&mut |atom| all.push(of_atom(atom)));
        all.dedup();
        match all[..] {
            [subject] => subject,
            _ => None,
        }
    }

    /// Returns true if the subject executes a codel.
    fn executes(self, system: &TimedSystem, codel: CodelId) -> bool {
        match (self, Subject::of_codel(system, codel)) {
            (Subject::Job(task), Some(Subject::Task(of, _))) => task == of,
            (subject, of) => of == Some(subject),
        }
    }

    /// Returns what the subject does in a state in which time passes.
    pub(super) fn spends(self, rules: &Rules, s: &State) -> Spent {
        let executing = |is_own: &dyn Fn(Work) -> bool| {
            let own = (0..rules.frame().executors())
                .filter_map(|executor| Some((executor, rules.work(s, executor)?)))
                .filter(|(_, work)| is_own(*work));
            let spent =
                own.filter_map(|(executor, work)| Some(work_of(rules, s, executor, work.codel()?)));
            let spent: Vec<Spent> = spent.collect();
            let executes = spent.iter().find(|spent| !matches!(spent, Spent::Locks { .. }));
            executes.or(spent.first()).copied()
        };
        match self {
            Subject::Task(_, Some(service)) if !is_active(rules, s, service) => {
                Subject::Service(service).spends(rules, s)
            }
            Subject::Job(task) | Subject::Task(task, _) => {
                let number = usize::from(task);
                let status = rules.job(s, number);
                if status == TaskStatus::Waiting {
                    return Spent::Core(task);
                }
                let own = |work: Work| matches!(work, Work::State { task, .. } if task == number);
                executing(&own).unwrap_or(Spent::Between(task))
            }
            Subject::Service(service) => {
                let own =
                    |work: Work| matches!(work, Work::Control { service: of, .. } if of == service);
                executing(&own).unwrap_or(Spent::Unrequested(service))
            }
            Subject::Component(component) => {
                let of = |service: ServiceId| rules.system().services[service].component;
                let own = |work: Work| matches!(work, Work::Control { service, .. } if of(service) == component);
                executing(&own).unwrap_or(Spent::Control(component))
            }
            Subject::Client(client) => Spent::Client(client),
        }
    }
}

/// Returns what an executor does with a codel.
pub(super) fn work_of(rules: &Rules, s: &State, executor: usize, codel: CodelId) -> Spent {
    match (rules.frame().is_executing(s, executor), rules.progresses(s, executor)) {
        (false, _) => Spent::Locks { codel, holder: rules.lock_holder(s, executor) },
        (true, true) => Spent::Executes(codel),
        (true, false) => Spent::Preempted(codel),
    }
}

fn is_active(rules: &Rules, s: &State, service: ServiceId) -> bool {
    let automata = &rules.system().automata;
    let mut active = (0..rules.places()).filter_map(|place| rules.activity(s, place));
    active.any(|automaton| automata[automaton].service == Some(service))
}

impl Run {
    /// Returns the intervals of the last time that the run measures, up to its end. `age` returns that time
    /// in the last state.
    pub(super) fn spans(
        &self,
        rules: &Rules,
        observers: &Observers,
        age: &dyn Fn(&State) -> u64,
        spent: &dyn Fn(&State) -> Spent,
    ) -> Vec<Span> {
        let mut s = rules.initial();
        observe::observe(rules, observers, None, &mut s);
        let mut out: Vec<Span> = Vec::new();
        let mut now = 0;
        // The codels whose executions have begun.
        let mut open: Vec<CodelId> = Vec::new();
        for step in self.steps.iter().map(Some).chain([None]) {
            let time = step.map_or(self.end, |&(time, _)| time);
            if time > now {
                let spent = spent(&s);
                let mut begins = false;
                if let Spent::Executes(codel) | Spent::Preempted(codel) = spent
                    && !open.contains(&codel)
                {
                    open.push(codel);
                    begins = true;
                }
                out.push(Span { from: now, until: time, spent, begins });
                advance(rules, &mut s, Ticks::try_from(time - now).unwrap_or(Ticks::MAX));
                now = time;
            }
            let Some(&(_, action)) = step else { break };
            if let Action::Finish { executor, .. } = action {
                let ended = rules.work(&s, executor).and_then(|work| work.codel());
                open.retain(|codel| Some(*codel) != ended);
            }
            let before = s.clone();
            rules.apply(&mut s, action);
            observe::observe(rules, observers, Some(&before), &mut s);
        }
        let from = self.end.saturating_sub(age(&s));
        out.retain(|span| span.until > from);
        if let Some(first) = out.first_mut() {
            first.from = first.from.max(from);
        }
        out
    }

    /// Returns the intervals of the time for which a response is late, and the stage that is awaited at the
    /// end.
    pub(crate) fn spans_of_response(
        &self,
        system: &TimedSystem,
        within: &Within,
    ) -> (Vec<Span>, Option<usize>) {
        let clocks = Clocks {
            within: vec![Stages { count: within.responses.len(), measured: true }],
            ..Clocks::none(system.tasks.len())
        };
        let rules = Rules::new(system).with_clocks(&clocks);
        let (trigger, responses) = (within.trigger.clone(), within.responses.clone());
        let subjects = responses.iter().map(|response| Subject::of_predicate(system, response));
        let subjects: Vec<Option<Subject>> = subjects.collect();
        let frame = rules.frame();
        // A later stage is older.
        let open = |s: &State| {
            let mut stages = frame.stages(0).enumerate().rev();
            stages.find(|(_, stage)| frame.is_open_at(s, *stage)).map(|(number, _)| number)
        };
        let last = Cell::new(None);
        let age = |s: &State| {
            last.set(open(s));
            frame.observer_clock(s, 0).map_or(0, |clock| u64::from(s.t[clock]))
        };
        let spent = |s: &State| {
            let subject = open(s).and_then(|number| subjects[number]);
            subject.map_or(Spent::Nothing, |subject| subject.spends(&rules, s))
        };
        let responses = vec![Observer { trigger, responses }];
        let observers = Observers { responses, monitors: Vec::new() };
        let spans = self.spans(&rules, &observers, &age, &spent);
        (spans, last.get())
    }

    /// Returns the intervals of the part that repeats for ever, for a response that never comes.
    pub(crate) fn spans_of_cycle(&self, system: &TimedSystem, response: &Predicate) -> Vec<Span> {
        let rules = Rules::new(system);
        let subject = Subject::of_predicate(system, response);
        let spent = |s: &State| subject.map_or(Spent::Nothing, |subject| subject.spends(&rules, s));
        let length = self.length_of_cycle();
        self.spans(&rules, &Observers::default(), &|_| length, &spent)
    }

    /// Returns the codels that the subject of a response executes in the part that repeats for ever, also
    /// those that take no time.
    pub(crate) fn codels_of_cycle(
        &self,
        system: &TimedSystem,
        response: &Predicate,
    ) -> Vec<CodelId> {
        let rules = Rules::new(system);
        let subject = Subject::of_predicate(system, response);
        subject.map_or(Vec::new(), |subject| self.executed_in_cycle(&rules, subject))
    }

    /// Returns the codels that a subject executes in the part that repeats for ever.
    pub(super) fn executed_in_cycle(&self, rules: &Rules, subject: Subject) -> Vec<CodelId> {
        let is_own = |codel: CodelId| subject.executes(rules.system(), codel);
        let (mut s, mut now, mut out) = (rules.initial(), 0, Vec::new());
        for (number, &(time, action)) in self.steps.iter().enumerate() {
            if time > now {
                advance(rules, &mut s, Ticks::try_from(time - now).unwrap_or(Ticks::MAX));
                now = time;
            }
            if let Action::Finish { executor, .. } = action
                && self.cycle.is_some_and(|cycle| number >= cycle)
                && let Some(codel) = rules.work(&s, executor).and_then(|work| work.codel())
                && is_own(codel)
                && !out.contains(&codel)
            {
                out.push(codel);
            }
            rules.apply(&mut s, action);
        }
        out
    }

    /// Returns the duration of the part that repeats for ever, in base units.
    pub(super) fn length_of_cycle(&self) -> u64 {
        let before = |cycle: usize| cycle.checked_sub(1).map_or(0, |step| self.steps[step].0);
        self.cycle.map_or(0, |cycle| self.end - before(cycle))
    }
}
