//! Descriptions of actions under the published rules.

use super::Published;
use super::layout::control;
use crate::explore::details::{Blocker, Executing, MomentDetails};
use crate::explore::rules::Action;
use crate::explore::rules::{Moment, MomentKind};
use crate::explore::state::{State, TaskStatus, phase};
use crate::system::{ClientAction, Yield};

impl Published<'_> {
    /// Describes the effects of an action; without an action, those of the initial state.
    pub(super) fn describe(
        &self,
        before: &State,
        after: &State,
        action: Option<Action>,
        time: u64,
        out: &mut Vec<Moment>,
    ) {
        if let Some(action) = action {
            self.describe_action(before, after, action, time, out);
        }
        let l = &self.layout;
        for e in 0..l.executors() {
            self.describe_executor((before, after), action, e, time, out);
        }
        for task in 0..l.tasks {
            let ended = l.status(before, task) != TaskStatus::Idle
                && l.status(after, task) == TaskStatus::Idle;
            let empty = matches!(action, Some(Action::Release { task: t }) if t == task)
                && l.status(after, task) == TaskStatus::Idle;
            if ended || empty {
                out.push(self.of_task(task, MomentKind::Complete, time, "job complete".to_owned()));
            }
        }
    }

    fn of_task(&self, task: usize, kind: MomentKind, time: u64, what: String) -> Moment {
        let system = self.system;
        Moment {
            time,
            component: system.components[system.tasks[task].component].name.clone(),
            task: Some(task),
            codel: None,
            what,
            kind,
            about: MomentDetails::Nothing,
            action: None,
        }
    }

    fn describe_action(
        &self,
        before: &State,
        after: &State,
        action: Action,
        time: u64,
        out: &mut Vec<Moment>,
    ) {
        let system = self.system;
        let l = &self.layout;
        let of_component = |component: usize, what: String, about: MomentDetails| Moment {
            time,
            component: system.components[component].name.clone(),
            task: None,
            codel: None,
            what,
            kind: MomentKind::Request,
            about,
            action: None,
        };
        match action {
            Action::Tick { task } => {
                let what = match (l.status(before, task), l.pending(before, task)) {
                    (TaskStatus::Idle, false) => "tick",
                    (TaskStatus::Idle, true) => "tick, the previous one is still kept",
                    (TaskStatus::Waiting, _) => "tick while waiting for a core",
                    (TaskStatus::Running, _) => "tick before the job has ended",
                };
                out.push(self.of_task(task, MomentKind::Tick, time, what.to_owned()));
            }
            Action::Release { task } => {
                let (what, about) = match l.status(after, task) {
                    TaskStatus::Waiting => ("released, asks for a core", MomentDetails::AwaitsCore),
                    _ => ("released", MomentDetails::Nothing),
                };
                out.push(Moment {
                    about,
                    ..self.of_task(task, MomentKind::Release, time, what.to_owned())
                });
            }
            Action::Grant { task } => {
                out.push(self.of_task(task, MomentKind::Grant, time, "gets a core".to_owned()));
            }
            Action::Finish { executor, outcome } => {
                let codel = self.codel(before, executor);
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
                        about: MomentDetails::Nothing,
                        action: None,
                    });
                }
            }
            Action::Signal { component } => {
                out.push(of_component(
                    component,
                    "reports ended activities".to_owned(),
                    MomentDetails::Nothing,
                ));
            }
            Action::Request { client, .. } => {
                let step = &system.clients[client].steps[l.position(before, client) as usize];
                if let ClientAction::Send { service, .. } = step.action {
                    let component = system.services[service].component;
                    out.push(of_component(
                        component,
                        format!(
                            "takes the request {} of client {}",
                            system.service_path(service),
                            system.clients[client].name
                        ),
                        MomentDetails::Requested { client, service },
                    ));
                }
            }
            Action::Proceed { .. } | Action::Acquire { .. } => {}
            // Actions of other rules.
            Action::Begin { .. }
            | Action::Preempt { .. }
            | Action::Ready { .. }
            | Action::Ticket { .. }
            | Action::Wake { .. }
            | Action::Shut { .. }
            | Action::Mark { .. }
            | Action::Reply { .. } => {}
        }
    }

    /// Describes a codel that begins, or begins to wait.
    fn describe_executor(
        &self,
        (before, after): (&State, &State),
        action: Option<Action>,
        executor: usize,
        time: u64,
        out: &mut Vec<Moment>,
    ) {
        let system = self.system;
        let l = &self.layout;
        if executor >= l.automata + l.components {
            return;
        }
        let now = self.layout.phase(after, executor) & !phase::ASYNC;
        if now == phase::REST {
            return;
        }
        let was = self.layout.phase(before, executor) & !phase::ASYNC;
        let again = matches!(action, Some(Action::Finish { executor: finished, .. }) if finished == executor);
        let Some(codel) = self.codel(after, executor) else {
            return;
        };
        let path = &system.codels[codel].path;
        // Locks that were free for a moment, and were taken by another executor.
        let faster = match action {
            Some(Action::Acquire { executor: index }) if index != executor => {
                self.blocker(after, index)
            }
            _ => None,
        };
        let conflicts = &system.codels[codel].conflicts;
        let faster =
            faster.filter(|blocker| now != phase::EXECUTING && conflicts.contains(blocker.codel));
        if was == now && !again && faster.is_none() {
            return;
        }
        let (kind, what, about) = if let Some(blocker) = faster.filter(|_| was == now) {
            let faster = &system.codels[blocker.codel].path;
            (
                MomentKind::Wait,
                format!("{path} goes on waiting: {faster} was faster"),
                MomentDetails::Blocked(vec![blocker]),
            )
        } else if now == phase::EXECUTING {
            (
                MomentKind::Begin,
                format!("{path} begins"),
                MomentDetails::Nothing,
            )
        } else {
            // Free locks are taken in a step of their own at the same moment, which needs no line.
            let holders: Vec<Blocker> = (0..l.automata + l.components)
                .filter(|&e| self.layout.phase(after, e) & !phase::ASYNC == phase::EXECUTING)
                .filter_map(|e| self.blocker(after, e))
                .filter(|blocker| conflicts.contains(blocker.codel))
                .collect();
            if holders.is_empty() {
                return;
            }
            let paths = holders
                .iter()
                .map(|holder| &*system.codels[holder.codel].path);
            let paths: Vec<&str> = paths.collect();
            (
                MomentKind::Wait,
                format!("{path} waits for {}", paths.join(", ")),
                MomentDetails::Blocked(holders),
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
            about,
            action: None,
        });
    }

    /// Returns the work of an executor, as a codel that keeps others waiting.
    fn blocker(&self, s: &State, executor: usize) -> Option<Blocker> {
        let automata = self.layout.automata;
        Some(Blocker {
            codel: self.codel(s, executor)?,
            by: match executor < automata {
                true => Executing::Task(self.system.automata[executor].task),
                false => Executing::Control(executor - automata),
            },
            ahead: false,
        })
    }
}
