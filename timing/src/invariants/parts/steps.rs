//! The rules of parts: the steps from each local state, and their closure.

use std::collections::HashMap;

use super::{Local, Part, PartKind, Parts};
use crate::property::TaskState;
use crate::system::{AutomatonId, ComponentId, Machine, TaskId, Yield};

impl Parts<'_> {
    /// Adds a part with the local states that its rules reach from the initial one.
    pub(super) fn push(&mut self, kind: PartKind) {
        let mut locals = vec![self.initial(kind)];
        let mut numbers = HashMap::from([(locals[0], 0)]);
        let mut steps = Vec::new();
        let mut from = 0;
        while let Some(local) = locals.get(from).copied() {
            for next in self.next(kind, local) {
                let to = *numbers.entry(next).or_insert_with(|| {
                    locals.push(next);
                    locals.len() - 1
                });
                steps.push((from, to));
            }
            from += 1;
        }
        self.parts.push(Part { kind, locals, steps });
    }

    fn initial(&self, kind: PartKind) -> Local {
        match kind {
            PartKind::Thread(task) | PartKind::Status(task) => Local::Task(task, TaskState::Idle),
            PartKind::Automaton(_) => Local::Rest,
            PartKind::Slots(service) => Local::Slots { service, void: true },
            PartKind::Control(_) if self.jobs => Local::Ready,
            PartKind::Control(_) => Local::Busy,
            // Before the first step.
            PartKind::Client(client) => Local::At(client, self.system.clients[client].done() + 1),
        }
    }

    /// Returns the local states after one step from a local state.
    fn next(&self, kind: PartKind, from: Local) -> Vec<Local> {
        match (kind, from) {
            (PartKind::Thread(task) | PartKind::Status(task), Local::Task(_, state)) => {
                let mut out = of_task(task, state);
                if matches!((kind, state), (PartKind::Thread(_), TaskState::Running)) {
                    let automata = self.automata(task).into_iter();
                    out.extend(automata.flat_map(|automaton| self.begun(automaton)));
                }
                out
            }
            (PartKind::Thread(task), Local::Codel { .. }) => {
                self.after_codel(from, Local::Task(task, TaskState::Running))
            }
            (PartKind::Automaton(automaton), Local::Rest) => self.begun(automaton),
            (PartKind::Automaton(_), Local::Codel { .. }) => self.after_codel(from, Local::Rest),
            (PartKind::Slots(service), Local::Slots { void, .. }) if self.requested[service] => {
                vec![Local::Slots { service, void: !void }]
            }
            (PartKind::Control(_), Local::Ready) => vec![Local::Busy],
            (PartKind::Control(component), Local::Busy) => self.taken(component),
            (PartKind::Control(_), Local::Handling { .. }) => self.after_handling(from),
            (PartKind::Client(client), Local::At(_, step)) => {
                let it = &self.system.clients[client];
                let next = match it.steps.get(step) {
                    Some(step) => &step.next,
                    None if step > it.done() => &it.first,
                    None => return Vec::new(),
                };
                next.iter().map(|&step| Local::At(client, step)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Returns a state of an automaton's machine, waiting for locks.
    fn waiting(&self, automaton: AutomatonId, state: usize) -> Local {
        let it = &self.system.automata[automaton];
        Local::Codel {
            task: it.task,
            machine: it.machine,
            state,
            codel: self.system.machines[it.machine].states[state].codel,
            executes: false,
        }
    }

    /// Returns the states of an automaton with which a part can go on: other activities may be executed
    /// between any two codels.
    fn begun(&self, automaton: AutomatonId) -> Vec<Local> {
        let states = reachable(self.system.machine_of(automaton)).into_iter();
        states.map(|state| self.waiting(automaton, state)).collect()
    }

    /// Returns the local states after a codel of a machine, which gets its locks, or ends. At the end of a
    /// turn the part is at `rest`.
    fn after_codel(&self, from: Local, rest: Local) -> Vec<Local> {
        let Local::Codel { task, machine, state, codel, executes } = from else {
            return Vec::new();
        };
        let at =
            |state: usize, codel, executes| Local::Codel { task, machine, state, codel, executes };
        if !executes {
            return vec![at(state, codel, true), rest];
        }
        let states = &self.system.machines[machine].states;
        let mut out = vec![rest];
        for successor in &states[state].yields {
            if let Yield::Next(to) = *successor {
                out.push(at(to, states[to].codel, false));
            }
        }
        out
    }

    /// Returns the local states of a control task that has taken a message: the first codel of a service,
    /// or none.
    fn taken(&self, component: ComponentId) -> Vec<Local> {
        let services = self.system.components[component].services.iter();
        let requested = services.filter(|&&service| self.requested[service]);
        let first = requested.filter_map(|&service| {
            let it = &self.system.services[service];
            let codel = *it.validate.iter().chain(&it.simple).next()?;
            Some(Local::Handling { service, codel, executes: false })
        });
        std::iter::once(Local::Ready).chain(first).collect()
    }

    /// Returns the local states after a codel of a control task.
    fn after_handling(&self, from: Local) -> Vec<Local> {
        let Local::Handling { service, codel, executes } = from else {
            return Vec::new();
        };
        let at = |codel, executes| Local::Handling { service, codel, executes };
        if !executes {
            return vec![at(codel, true)];
        }
        let it = &self.system.services[service];
        let mut after = (it.validate.iter().chain(&it.simple)).skip_while(|&&other| other != codel);
        let next = after.nth(1).map(|&next| at(next, false));
        std::iter::once(Local::Busy).chain(next).collect()
    }
}

/// Returns the local states after a state of a task without a codel.
fn of_task(task: TaskId, state: TaskState) -> Vec<Local> {
    let next: &[TaskState] = match state {
        TaskState::Idle => &[TaskState::Waiting, TaskState::Running],
        TaskState::Waiting => &[TaskState::Running],
        TaskState::Running | TaskState::Active => &[TaskState::Idle],
    };
    next.iter().map(|&state| Local::Task(task, state)).collect()
}

/// Returns the states that a machine can reach, from `start` or by an interruption.
fn reachable(machine: &Machine) -> Vec<usize> {
    let mut out = vec![machine.start];
    out.extend(machine.stop.filter(|stop| *stop != machine.start));
    let mut at = 0;
    while let Some(&state) = out.get(at) {
        at += 1;
        for successor in &machine.states[state].yields {
            if let Yield::Next(to) | Yield::Pause(to) = *successor
                && !out.contains(&to)
            {
                out.push(to);
            }
        }
    }
    out
}
