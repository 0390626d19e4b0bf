//! Descriptions of actions.

use super::points::{Cycle, Handling};
use super::status::{flag, slot, thread};
use super::{Action, Moment, MomentKind, Rules};
use crate::explore::details::{Blocker, Executing, MomentDetails};
use crate::explore::state::{State, TaskStatus, phase};
use crate::scn::semantics::LockRule;
use crate::system::{ClientAction, CodelId, ComponentId, TaskId, Yield};

impl Rules<'_> {
    /// Describes the effects of an action; without an action, those of the initial state.
    pub(super) fn moments(
        &self,
        (before, after): (&State, &State),
        action: Option<Action>,
        time: u64,
        out: &mut Vec<Moment>,
    ) {
        if let Some(action) = action {
            self.describe_action(before, after, action, time, out);
        }
        let l = &self.layout;
        for executor in 0..l.threads + l.components {
            self.describe_executor((before, after), action, executor, time, out);
        }
        for task in 0..l.tasks {
            // A cycle without codels begins and ends in one step.
            let begun = self.in_cycle(before, task)
                || match action {
                    Some(Action::Begin { task: other }) => other == task && self.is_periodic(task),
                    Some(Action::Release { task: other }) => other == task,
                    _ => false,
                };
            if begun && !self.in_cycle(after, task) {
                let what = if l.has(before, task, flag::FIRST) {
                    "start-up complete"
                } else {
                    "job complete"
                };
                out.push(self.of_task(task, MomentKind::Complete, time, what.to_owned()));
            }
        }
    }

    fn of_task(&self, task: usize, kind: MomentKind, time: u64, what: String) -> Moment {
        let component = self.system.tasks[TaskId::from(task)].component;
        Moment {
            time,
            component: self.system.components[component].name.clone(),
            task: Some(TaskId::from(task)),
            codel: None,
            what,
            kind,
            about: MomentDetails::Nothing,
            action: None,
        }
    }

    fn of_component(&self, component: ComponentId, time: u64, what: String) -> Moment {
        Moment {
            time,
            component: self.system.components[component].name.clone(),
            task: None,
            codel: None,
            what,
            kind: MomentKind::Request,
            about: MomentDetails::Nothing,
            action: None,
        }
    }

    fn of_codel(
        &self,
        codel: CodelId,
        executor: usize,
        time: u64,
        kind: MomentKind,
        what: String,
    ) -> Moment {
        let component = self.system.codels[codel].component;
        Moment {
            time,
            component: self.system.components[component].name.clone(),
            task: self.task_of_executor(executor).map(TaskId::from),
            codel: Some(codel),
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
        let l = &self.layout;
        match action {
            Action::Tick { task } => {
                let what = if l.thread_of(before, task) == thread::OFF {
                    "tick before the task is started: kept"
                } else if l.has(before, task, flag::TICK) {
                    "tick, the previous one is still kept"
                } else if l.thread_of(before, task) == thread::WAITING {
                    "tick while waiting for a core: kept"
                } else if self.in_cycle(before, task) {
                    if l.has(before, task, flag::FIRST) {
                        "tick during start-up: kept"
                    } else {
                        "tick before the job has ended: kept"
                    }
                } else {
                    "tick"
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
                let what = "gets a core".to_owned();
                out.push(self.of_task(task, MomentKind::Grant, time, what));
                self.passing(before, after, task, time, out);
            }
            Action::Begin { task } => {
                if l.thread_of(before, task) == thread::IDLE {
                    let what = if self.is_periodic(task) { "begins a cycle" } else { "wakes up" };
                    out.push(self.of_task(task, MomentKind::Release, time, what.to_owned()));
                }
                self.passing(before, after, task, time, out);
            }
            Action::Finish { executor, outcome } => {
                self.describe_end(before, executor, outcome, time, out);
            }
            Action::Signal { component } => {
                let what = "reports ended activities".to_owned();
                out.push(self.of_component(component, time, what));
                self.reported(before, after, component, time, out);
            }
            Action::Request { client: k, .. } => {
                let client = &self.system.clients[k];
                let step = &client.steps[l.position(before, k) as usize];
                if let ClientAction::Send { service, .. } = step.action {
                    let component = self.system.services[service].component;
                    let mut what = format!(
                        "takes the request {} of client {}",
                        self.system.service_path(service),
                        client.name
                    );
                    if l.refused(after, component) != 0 {
                        let allowed = l.given(after, component) != 0
                            || !self.system.services[service].activity;
                        what.push_str(if allowed {
                            ": refused, because of `after` or `before`"
                        } else {
                            ": rejected, because its task has no free slot"
                        });
                    }
                    out.push(Moment {
                        about: MomentDetails::Requested { client: k, service },
                        ..self.of_component(component, time, what)
                    });
                }
            }
            Action::Mark { .. } => {}
            Action::Reply { component } => {
                let Some(service) = l.handled(before, component) else {
                    return;
                };
                let path = self.system.service_path(service);
                let what = match (l.refused(before, component) != 0, l.given(before, component)) {
                    (true, _) => format!("refuses {path}"),
                    (false, 0) => format!("{path} has succeeded"),
                    (false, _) => format!("accepts {path}"),
                };
                out.push(self.of_component(component, time, what));
                self.reported(before, after, component, time, out);
            }
            Action::Preempt { executor, by } => {
                let name = |task: usize| {
                    if task < l.tasks {
                        self.system.task_path(TaskId::from(task))
                    } else {
                        self.system.components[ComponentId::from(task - l.tasks)].name.clone()
                    }
                };
                let what = format!("takes the core of {}", name(executor));
                let moment = if by < l.tasks {
                    self.of_task(by, MomentKind::Grant, time, what)
                } else {
                    self.of_component((by - l.tasks).into(), time, what)
                };
                out.push(Moment {
                    about: MomentDetails::Preempted(self.executing(executor)),
                    ..moment
                });
            }
            Action::Shut { component } => {
                let what = "shuts down".to_owned();
                out.push(self.of_component(component, time, what));
                self.reported(before, after, component, time, out);
                for &task in &self.system.components[component].tasks {
                    let ended = |s: &State| l.thread_of(s, usize::from(task)) == thread::ENDED;
                    if ended(after) && !ended(before) {
                        let what = "ends with its component".to_owned();
                        out.push(self.of_task(usize::from(task), MomentKind::Complete, time, what));
                    }
                }
            }
            Action::Proceed { .. }
            | Action::Acquire { .. }
            | Action::Ticket { .. }
            | Action::Ready { .. }
            | Action::Wake { .. } => {}
        }
    }

    fn slot_name(&self, s: &State, task: usize, index: usize) -> String {
        match self.machine(s, index) {
            Some(machine) => machine.name.clone(),
            None => self.system.task_path(TaskId::from(task)),
        }
    }

    /// Describes the effects of the beginning of a pass on activities that execute nothing.
    fn passing(
        &self,
        before: &State,
        after: &State,
        task: usize,
        time: u64,
        out: &mut Vec<Moment>,
    ) {
        let l = &self.layout;
        if self.points.cycle == Cycle::Jobs {
            return;
        }
        for &slot in l.slots(task) {
            let (was, now) = (l.activity(before, slot), l.activity(after, slot));
            let marked = l.mode(before, slot) & slot::MARK != 0;
            let what = match (was, now) {
                (slot::INIT, slot::ETHER) if marked => "ends before its first codel: interrupted",
                (slot::RUN, slot::STOP) => "notices the interruption",
                (slot::RUN, slot::ETHER) if marked => "ends: interrupted",
                _ => continue,
            };
            let what = format!("{} {what}", self.slot_name(before, task, slot));
            out.push(self.of_task(task, MomentKind::Release, time, what));
        }
    }

    /// Describes activities that are interrupted, released or reported by the control task.
    fn reported(
        &self,
        before: &State,
        after: &State,
        component: ComponentId,
        time: u64,
        out: &mut Vec<Moment>,
    ) {
        let l = &self.layout;
        if self.points.handling == Handling::AtOnce {
            return;
        }
        for &task in &self.system.components[component].tasks {
            for &slot in l.slots(usize::from(task)) {
                let (was, now) = (l.mode(before, slot), l.mode(after, slot));
                let new = now & !was;
                let name = || self.slot_name(before, usize::from(task), slot);
                if new & slot::MARK != 0 && now & slot::STATUS != slot::VOID {
                    out.push(self.of_component(component, time, format!("interrupts {}", name())));
                }
                if new & slot::START != 0 {
                    let what = format!("releases {}", name());
                    out.push(Moment {
                        about: MomentDetails::Released { task },
                        ..self.of_component(component, time, what)
                    });
                }
                if was & slot::STATUS == slot::ETHER && now & slot::STATUS == slot::VOID {
                    out.push(self.of_component(component, time, format!("reports {}", name())));
                }
            }
        }
    }

    fn describe_end(
        &self,
        before: &State,
        executor: usize,
        outcome: usize,
        time: u64,
        out: &mut Vec<Moment>,
    ) {
        let l = &self.layout;
        let Some(codel) = self.codel(before, executor) else {
            return;
        };
        let path = &self.system.codels[codel].path;
        let what = if let Some(slot) = self.slot_of(before, executor) {
            let (Some(machine), Some(state)) =
                (self.machine(before, slot), self.machine_state(before, slot))
            else {
                return;
            };
            match state.yields.get(outcome) {
                Some(&Yield::Next(to)) => {
                    format!("{path} ends, yields {}", machine.states[to].name)
                }
                Some(&Yield::Pause(to)) => {
                    format!("{path} ends, yields pause::{}", machine.states[to].name)
                }
                Some(Yield::End) => format!("{path} ends, yields ether"),
                None => format!("{path} ends by an exception"),
            }
        } else {
            let validates = self.validates(before, (executor - l.threads).into());
            match (validates, outcome) {
                (true, 0) => format!("{path} accepts"),
                (true, _) => format!("{path} refuses"),
                (false, 0) => format!("{path} ends"),
                (false, _) => format!("{path} ends by an exception"),
            }
        };
        out.push(self.of_codel(codel, executor, time, MomentKind::End, what));
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
        let l = &self.layout;
        let phase_in = |s: &State| l.phase(s, executor) & !phase::ASYNC;
        let (was, now) = (phase_in(before), phase_in(after));
        if now == phase::REST {
            return;
        }
        let Some(codel) = self.codel(after, executor) else {
            return;
        };
        let path = &self.system.codels[codel].path;
        let again =
            matches!(action, Some(Action::Finish { executor: ended, .. }) if ended == executor);
        if was == now && !again {
            if let Some(faster) = self.overtaker(after, action, executor) {
                let by = &self.system.codels[faster.codel].path;
                let what = format!("{path} goes on waiting: {by} was faster");
                out.push(Moment {
                    about: MomentDetails::Blocked(vec![faster]),
                    ..self.of_codel(codel, executor, time, MomentKind::Wait, what)
                });
            }
            return;
        }
        if now == phase::EXECUTING {
            let what = format!("{path} begins");
            out.push(self.of_codel(codel, executor, time, MomentKind::Begin, what));
            return;
        }
        // An executor without a wait takes its locks in a step of its own at the same moment, which needs no
        // line.
        let blockers = self.blockers(after, executor, codel);
        if !blockers.is_empty() {
            let named = blockers.iter().map(|blocker| {
                let queued = if blocker.ahead { " (ahead in the queue)" } else { "" };
                format!("{}{queued}", self.system.codels[blocker.codel].path)
            });
            let named: Vec<String> = named.collect();
            let what = format!("{path} waits for {}", named.join(", "));
            out.push(Moment {
                about: MomentDetails::Blocked(blockers),
                ..self.of_codel(codel, executor, time, MomentKind::Wait, what)
            });
        }
    }

    /// Returns the executor that has just taken locks that were free for a moment, and for which this
    /// executor goes on waiting.
    fn overtaker(&self, s: &State, action: Option<Action>, executor: usize) -> Option<Blocker> {
        let Some(Action::Acquire { executor: faster }) = action else {
            return None;
        };
        let waiting = &self.system.codels[self.codel(s, executor)?];
        let overtakes = self.points.locks == LockRule::Free
            && faster != executor
            && !self.layout.is_executing(s, executor)
            && self.blocks(s, waiting, faster);
        overtakes.then(|| self.blocker(s, faster, false)).flatten()
    }

    /// Returns the executors for which an executor waits with its codel.
    fn blockers(&self, s: &State, executor: usize, codel: CodelId) -> Vec<Blocker> {
        let l = &self.layout;
        let waiting = &self.system.codels[codel];
        let holders = l.executing(s).filter(|&other| self.blocks(s, waiting, other));
        let mut out: Vec<Blocker> =
            (holders).filter_map(|other| self.blocker(s, other, false)).collect();
        if let Some(component) = self.component_of(executor) {
            let queue = l.lock_queue(s, component).iter();
            let ahead =
                (queue.map(|&other| other as usize)).take_while(|&other| other != executor).filter(
                    |&other| self.points.locks == LockRule::Queue || self.blocks(s, waiting, other),
                );
            out.extend(ahead.filter_map(|other| self.blocker(s, other, true)));
        }
        out
    }

    /// Returns the codel with the locks for which an executor waits. Of executors ahead in its queue, the
    /// codel for which they wait.
    pub(crate) fn lock_holder(&self, s: &State, executor: usize) -> Option<CodelId> {
        let l = &self.layout;
        let holder = |waiting: usize| {
            let waiting = &self.system.codels[self.codel(s, waiting)?];
            l.executing(s).find(|&other| self.blocks(s, waiting, other))
        };
        let ahead = || {
            let waiting = &self.system.codels[self.codel(s, executor)?];
            let queue = l.lock_queue(s, self.component_of(executor)?).iter();
            let ahead = queue.map(|&other| other as usize).take_while(|&other| other != executor);
            let blocks = |&other: &usize| {
                self.points.locks == LockRule::Queue || self.blocks(s, waiting, other)
            };
            ahead.filter(blocks).find_map(holder)
        };
        self.codel(s, holder(executor).or_else(ahead)?)
    }

    /// Returns the work of an executor, as a codel that keeps others waiting.
    fn blocker(&self, s: &State, executor: usize, ahead: bool) -> Option<Blocker> {
        Some(Blocker { codel: self.codel(s, executor)?, by: self.executing(executor), ahead })
    }

    /// Returns the thread of an executor: a task, or a control task.
    fn executing(&self, executor: usize) -> Executing {
        match self.task_of_executor(executor) {
            Some(task) => Executing::Task(TaskId::from(task)),
            None => Executing::Control((executor - self.layout.threads).into()),
        }
    }
}
