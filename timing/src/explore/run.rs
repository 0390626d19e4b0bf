//! Runs: what happened, and when.

use rustc_hash::FxHashMap;

use super::observe::{self, Observer};
use super::state::{Layout, State, TaskStatus, control, phase};
use super::step::{Action, Stepper};
use crate::cancel::Cancel;
use crate::system::{FOREVER, Ticks, TimedSystem, Yield};

/// Steps of a run that is made longer by repetition, at most.
const PROLONGED: usize = 10_000;

/// A run from time 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Run {
    /// Actions with their times, in order.
    pub steps: Vec<(u64, Action)>,
    /// When the run ends; later than the last action if the point is that time passed.
    pub end: u64,
    /// From this step on the run repeats itself for ever.
    pub cycle: Option<usize>,
    /// There is such a run, but there was no time to find its steps.
    pub left_out: bool,
}

/// One line of a run for readers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Moment {
    /// Time in base units.
    pub time: u64,
    /// The component, or the client.
    pub component: String,
    /// The task; `None` for the control task and clients.
    pub task: Option<usize>,
    /// The executing codel that the line is about.
    pub codel: Option<usize>,
    /// Words.
    pub what: String,
    /// Its kind, for timelines.
    pub kind: MomentKind,
}

/// Kinds of [`Moment`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MomentKind {
    /// A timer has wrapped.
    Tick,
    /// A task asks for a core.
    Release,
    /// A task got its core.
    Grant,
    /// A codel waits for locks.
    Wait,
    /// A codel begins.
    Begin,
    /// A codel ends.
    End,
    /// A task has ended its job.
    Complete,
    /// A client or control task did something.
    Request,
    /// A limit is exceeded.
    Excess,
}

impl Run {
    pub(crate) fn extend(&mut self, time: u64, actions: Vec<Action>) {
        self.steps
            .extend(actions.into_iter().map(|action| (time, action)));
        self.end = time;
    }

    /// Two moments of the last `recent` units of the run with the same state just before time passes,
    /// observation clocks apart: what is between them can go on for ever.
    pub(crate) fn repetition(
        &self,
        stepper: &Stepper,
        (observers, recent): (&[Observer], Ticks),
        cancel: &Cancel,
    ) -> Option<(u64, u64)> {
        let from = self.end.checked_sub(u64::from(recent))?;
        let mut seen = FxHashMap::default();
        let mut found = None;
        self.replay(stepper, observers, |time, s, began| {
            if time < from {
                return !(time.is_multiple_of(64) && cancel.is_abandoned());
            }
            // Elapsed instead of remaining times.
            let elapsed: Vec<u64> = (0..stepper.layout.executors())
                .map(|e| {
                    if stepper.layout.phase(s, e) & !phase::ASYNC != phase::EXECUTING {
                        return 0;
                    }
                    let (lower, upper) = bounds(stepper, s, e);
                    let elapsed = time - began[e];
                    if upper == FOREVER {
                        elapsed.min(u64::from(lower))
                    } else {
                        elapsed
                    }
                })
                .collect();
            let key = (s.d.clone(), stepper.layout.key_times(s).to_vec(), elapsed);
            found = seen.insert(key, time).map(|before| (before, time));
            found.is_none() && !(time.is_multiple_of(64) && cancel.is_abandoned())
        });
        found
    }

    /// The run up to the second of two moments, after which it goes on for ever as it did since the first.
    pub(crate) fn repeating(&self, (from, to): (u64, u64)) -> Run {
        let steps = self.steps.iter().copied();
        let steps: Vec<_> = steps.take_while(|it| it.0 <= to).collect();
        Run {
            cycle: steps.iter().position(|it| it.0 > from),
            steps,
            end: to,
            left_out: false,
        }
    }

    /// The run with what is between two moments repeated, until it is longer by `more`; `None` if that
    /// takes too many steps to be of use to anybody.
    pub(crate) fn prolonged(&self, (from, to): (u64, u64), more: Ticks) -> Option<Run> {
        let end = self.end + u64::from(more);
        let within = |a: u64, b: u64| {
            let steps = self.steps.iter().copied();
            steps.filter(move |it| a < it.0 && it.0 <= b)
        };
        let mut run = Run {
            steps: self.steps.iter().copied().filter(|it| it.0 <= to).collect(),
            end,
            cycle: None,
            left_out: false,
        };
        let rounds = (end - to).div_ceil(to - from);
        for round in 1..=rounds {
            let shift = round * (to - from);
            let again = within(from, to).map(|(time, action)| (time + shift, action));
            run.steps.extend(again.filter(|it| it.0 < end));
            if run.steps.len() > PROLONGED {
                return None;
            }
        }
        Some(run)
    }

    /// Calls `calm` with the state before every unit of time that passes, the time, and when each
    /// executor began. Ends when it says so.
    fn replay(
        &self,
        stepper: &Stepper,
        observers: &[Observer],
        mut calm: impl FnMut(u64, &State, &[u64]) -> bool,
    ) {
        let mut s = stepper.initial();
        observe::observe(stepper, observers, None, &mut s);
        let mut now = 0;
        let mut began = vec![0; stepper.layout.executors()];
        for &(time, action) in &self.steps {
            while now < time {
                if !calm(now, &s, &began) {
                    return;
                }
                advance(stepper, &mut s, 1);
                now += 1;
            }
            let before = s.clone();
            stepper.apply(&mut s, action);
            observe::observe(stepper, observers, Some(&before), &mut s);
            for (e, began) in began.iter_mut().enumerate() {
                if began_in_step(stepper, &before, &s, action, e) {
                    *began = now;
                }
            }
        }
        while now < self.end {
            if !calm(now, &s, &began) {
                return;
            }
            advance(stepper, &mut s, 1);
            now += 1;
        }
    }

    /// The run in words.
    pub fn moments(&self, system: &TimedSystem) -> Vec<Moment> {
        let layout = Layout::new(system, &vec![false; system.tasks.len()], &[]);
        let stepper = Stepper::new(system, layout);
        let mut s = stepper.initial();
        let mut out = Vec::new();
        let blank = stepper.layout.blank();
        for e in 0..stepper.layout.executors() {
            executor_moment(&stepper, &blank, &s, None, e, 0, &mut out);
        }
        let mut now = 0;
        for &(time, action) in &self.steps {
            if time > now {
                advance(&stepper, &mut s, (time - now) as Ticks);
                now = time;
            }
            let before = s.clone();
            stepper.apply(&mut s, action);
            moments_of(&stepper, &before, &s, action, now, &mut out);
        }
        out
    }
}

/// Lets time pass although windows may end early: only their outcome matters here.
fn advance(stepper: &Stepper, s: &mut State, time: Ticks) {
    for e in 0..stepper.layout.executors() {
        let (a, b) = stepper.layout.window(s, e);
        if b < time {
            stepper.layout.set_window(s, e, (a, time));
        }
    }
    stepper.elapse(s, time);
}

fn bounds(stepper: &Stepper, s: &State, executor: usize) -> (Ticks, Ticks) {
    if let Some(codel) = stepper.codel(s, executor) {
        let codel = &stepper.system.codels[codel];
        return (codel.lower, codel.upper);
    }
    let l = &stepper.layout;
    let client = executor - l.automata - l.components;
    let position = l.position(s, client) as usize;
    match stepper.system.clients[client]
        .steps
        .get(position)
        .map(|it| &it.action)
    {
        Some(&crate::system::ClientAction::Delay(lower, upper)) => (lower, upper),
        _ => (0, 0),
    }
}

fn began_in_step(
    stepper: &Stepper,
    before: &State,
    after: &State,
    action: Action,
    executor: usize,
) -> bool {
    let executing = |s| stepper.layout.phase(s, executor) & !phase::ASYNC == phase::EXECUTING;
    executing(after)
        && (!executing(before)
            || matches!(action, Action::Finish { executor: it, .. } if it == executor))
}

fn moments_of(
    stepper: &Stepper,
    before: &State,
    after: &State,
    action: Action,
    time: u64,
    out: &mut Vec<Moment>,
) {
    let system = stepper.system;
    let l = &stepper.layout;
    let of_task = |task: usize, kind, what: String| Moment {
        time,
        component: system.components[system.tasks[task].component].name.clone(),
        task: Some(task),
        codel: None,
        what,
        kind,
    };
    let of_component = |component: usize, what: String| Moment {
        time,
        component: system.components[component].name.clone(),
        task: None,
        codel: None,
        what,
        kind: MomentKind::Request,
    };
    match action {
        Action::Tick { task } => {
            let what = match (l.status(before, task), l.pending(before, task)) {
                (TaskStatus::Idle, false) => "tick",
                (TaskStatus::Idle, true) => "tick, the previous one is still kept",
                (TaskStatus::Waiting, _) => "tick while waiting for a core",
                (TaskStatus::Running, _) => "tick before the job has ended",
            };
            out.push(of_task(task, MomentKind::Tick, what.to_owned()));
        }
        Action::Release { task } => {
            let what = if l.status(after, task) == TaskStatus::Waiting {
                "released, asks for a core"
            } else {
                "released"
            };
            out.push(of_task(task, MomentKind::Release, what.to_owned()));
        }
        Action::Grant { task } => {
            out.push(of_task(task, MomentKind::Grant, "gets a core".to_owned()));
        }
        Action::Finish { executor, outcome } => {
            let codel = stepper.codel(before, executor);
            if let Some(codel) = codel {
                let (task, what) = if executor < l.automata {
                    let machine = system.machine_of(executor);
                    let state = &machine.states[l.at(before, executor) as usize];
                    let to = match state.yields[outcome] {
                        Yield::Next(to) => machine.states[to].name.clone(),
                        Yield::Pause(to) => format!("pause::{}", machine.states[to].name),
                        Yield::End => "ether".to_owned(),
                    };
                    (
                        Some(system.automata[executor].task),
                        format!("{} ends, yields {to}", system.codels[codel].path),
                    )
                } else {
                    let verb = if outcome == 1 {
                        "refuses"
                    } else if l.control(before, executor - l.automata) == control::VALIDATE {
                        "accepts"
                    } else {
                        "ends"
                    };
                    (None, format!("{} {verb}", system.codels[codel].path))
                };
                out.push(Moment {
                    time,
                    component: system.components[system.codels[codel].component]
                        .name
                        .clone(),
                    task,
                    codel: Some(codel),
                    what,
                    kind: MomentKind::End,
                });
            }
        }
        Action::Signal { component } => {
            out.push(of_component(
                component,
                "reports ended activities".to_owned(),
            ));
        }
        Action::Request { client, .. } => {
            let step = &system.clients[client].steps[l.position(before, client) as usize];
            if let crate::system::ClientAction::Send { service, .. } = step.action {
                let component = system.services[service].component;
                out.push(of_component(
                    component,
                    format!(
                        "takes the request {} of client {}",
                        system.service_path(service),
                        system.clients[client].name
                    ),
                ));
            }
        }
        Action::Proceed { .. } | Action::Acquire { .. } => {}
    }
    for e in 0..l.executors() {
        executor_moment(stepper, before, after, Some(action), e, time, out);
    }
    for task in 0..l.tasks {
        let ended =
            l.status(before, task) != TaskStatus::Idle && l.status(after, task) == TaskStatus::Idle;
        let empty = matches!(action, Action::Release { task: t } if t == task)
            && l.status(after, task) == TaskStatus::Idle;
        if ended || empty {
            out.push(of_task(
                task,
                MomentKind::Complete,
                "job complete".to_owned(),
            ));
        }
    }
}

/// A codel begins, or begins to wait.
fn executor_moment(
    stepper: &Stepper,
    before: &State,
    after: &State,
    action: Option<Action>,
    executor: usize,
    time: u64,
    out: &mut Vec<Moment>,
) {
    let system = stepper.system;
    let l = &stepper.layout;
    if executor >= l.automata + l.components {
        return;
    }
    let now = stepper.layout.phase(after, executor) & !phase::ASYNC;
    if now == phase::REST {
        return;
    }
    let was = stepper.layout.phase(before, executor) & !phase::ASYNC;
    let again = matches!(action, Some(Action::Finish { executor: it, .. }) if it == executor);
    if was == now && !again {
        return;
    }
    let Some(codel) = stepper.codel(after, executor) else {
        return;
    };
    let path = &system.codels[codel].path;
    let (kind, what) = if now == phase::EXECUTING {
        (MomentKind::Begin, format!("{path} begins"))
    } else {
        // Free locks are taken in a step of their own at the same moment: not worth a line.
        let holders: Vec<&str> = (0..l.automata + l.components)
            .filter(|&e| stepper.layout.phase(after, e) & !phase::ASYNC == phase::EXECUTING)
            .filter_map(|e| stepper.codel(after, e))
            .filter(|&it| system.codels[codel].conflicts.contains(it))
            .map(|it| system.codels[it].path.as_str())
            .collect();
        if holders.is_empty() {
            return;
        }
        (
            MomentKind::Wait,
            format!("{path} waits for {}", holders.join(", ")),
        )
    };
    out.push(Moment {
        time,
        component: system.components[system.codels[codel].component]
            .name
            .clone(),
        task: (executor < l.automata).then(|| system.automata[executor].task),
        codel: Some(codel),
        what,
        kind,
    });
}
