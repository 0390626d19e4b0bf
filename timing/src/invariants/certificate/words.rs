//! Names and words of certificates.

use std::collections::HashMap;

use typed_index_collections::TiVec;

use crate::invariants::parts::{Local, Part, PartKind, Parts};
use crate::property::{Atom, SlotStatus, StatePhase, TaskState};
use crate::system::{CodelId, TimedSystem, Yield};

/// Names of which each is given once.
#[derive(Default)]
pub(super) struct Unique {
    used: HashMap<String, usize>,
}

impl Unique {
    /// Returns a name, with a number if it was given before.
    pub(super) fn name(&mut self, name: String) -> String {
        let mut out = name.clone();
        loop {
            let used = self.used.entry(out.clone()).or_default();
            *used += 1;
            if *used == 1 {
                return out;
            }
            out = format!("{name} #{used}");
        }
    }
}

/// The names of parts and codels.
pub(super) struct PartNames {
    pub(super) parts: Vec<String>,
    codels: TiVec<CodelId, String>,
}

impl PartNames {
    pub(super) fn of(parts: &Parts) -> PartNames {
        let (mut of_parts, mut of_codels) = (Unique::default(), Unique::default());
        let codels = parts.system.codels.iter();
        PartNames {
            parts: (parts.parts.iter())
                .map(|part| of_parts.name(self::part(parts.system, part.kind)))
                .collect(),
            codels: codels.map(|codel| of_codels.name(codel.path.to_string())).collect(),
        }
    }

    pub(super) fn codel(&self, codel: CodelId) -> &str {
        &self.codels[codel]
    }

    /// Returns the names of the local states of a part.
    pub(super) fn states(&self, parts: &Parts, part: &Part) -> Vec<String> {
        let mut unique = Unique::default();
        let names = part.locals.iter();
        names.map(|local| unique.name(self.state(parts.system, local))).collect()
    }

    fn state(&self, system: &TimedSystem, local: &Local) -> String {
        match *local {
            Local::Task(_, state) => of_task(state).to_owned(),
            Local::Codel { machine, state, executes, .. } => {
                let machine = &system.machines[machine];
                let state = &machine.states[state].name;
                format!("{}.{state} {}", machine.name, phase(executes))
            }
            Local::Rest => "no codel".to_owned(),
            Local::Slots { void: true, .. } => "no activity".to_owned(),
            Local::Slots { void: false, .. } => "an activity".to_owned(),
            Local::Ready => "ready".to_owned(),
            Local::Busy => "busy".to_owned(),
            Local::Handling { codel, executes, .. } => {
                format!("{} {}", self.codel(codel), phase(executes))
            }
            Local::At(client, step) => {
                let client = &system.clients[client];
                match client.steps.get(step) {
                    Some(of) => of.label.clone().unwrap_or_else(|| format!("step {step}")),
                    None if step > client.done() => "before the first step".to_owned(),
                    None => "after the last step".to_owned(),
                }
            }
        }
    }
}

fn part(system: &TimedSystem, kind: PartKind) -> String {
    match kind {
        PartKind::Thread(task) | PartKind::Status(task) => system.task_path(task),
        PartKind::Automaton(automaton) => format!("activity {}", system.machine_of(automaton).name),
        PartKind::Slots(service) => format!("slots of {}", system.service_path(service)),
        PartKind::Control(component) => {
            format!("control task of {}", system.components[component].name)
        }
        PartKind::Client(client) => format!("client {}", system.clients[client].name),
    }
}

fn of_task(state: TaskState) -> &'static str {
    match state {
        TaskState::Idle => "idle",
        TaskState::Waiting => "waiting",
        TaskState::Running => "running",
        TaskState::Active => "active",
    }
}

fn phase(executes: bool) -> &'static str {
    if executes { "executes" } else { "waits" }
}

/// Returns the event that a step of a part stands for.
pub(super) fn step(parts: &Parts, names: &PartNames, part: &str, step: (&Local, &Local)) -> String {
    let waiting = |codel: CodelId| format!("{part} asks for the locks of {}", names.codel(codel));
    let ends = |codel: CodelId, next: &str| format!("codel {} ends{next}", names.codel(codel));
    match step {
        (Local::Task(..), Local::Task(_, state)) => match state {
            TaskState::Idle => format!("{part} ends its cycle"),
            TaskState::Waiting => format!("{part} is released, and waits for a core"),
            _ => format!("{part} begins its cycle"),
        },
        (&Local::Codel { codel, executes: false, .. }, Local::Task(..) | Local::Rest) => {
            format!("codel {} is not executed", names.codel(codel))
        }
        (&Local::Codel { codel, machine, state, .. }, Local::Task(..) | Local::Rest) => {
            let states = &parts.system.machines[machine].states;
            let each = states[state].yields.iter().filter_map(|successor| match *successor {
                Yield::Next(_) => None,
                Yield::Pause(to) => Some(format!("pause::{}", states[to].name)),
                Yield::End => Some("ether".to_owned()),
            });
            let mut each: Vec<String> = each.collect();
            each.push("is interrupted or fails".to_owned());
            ends(codel, &format!(": {}", each.join(", or ")))
        }
        (&Local::Codel { codel, .. } | &Local::Handling { codel, .. }, to) if to.executes() => {
            format!("codel {} gets its locks and begins", names.codel(codel))
        }
        (&Local::Codel { codel, .. }, &Local::Codel { machine, state, .. }) => {
            let next = &parts.system.machines[machine].states[state].name;
            ends(codel, &format!(" and yields {next}"))
        }
        (&Local::Handling { codel, .. }, &Local::Handling { codel: next, .. }) => {
            ends(codel, &format!("; {}", waiting(next)))
        }
        (&Local::Handling { codel, .. }, _) => ends(codel, ""),
        (_, &Local::Codel { codel, .. } | &Local::Handling { codel, .. }) => waiting(codel),
        (_, Local::Slots { void: true, .. }) => "the last activity ends".to_owned(),
        (_, Local::Slots { .. }) => "an activity is accepted".to_owned(),
        (_, Local::Busy) => format!("{part} takes a message"),
        (_, Local::Ready) => format!("{part} waits for a message"),
        (_, Local::At(..)) => format!("{part} proceeds"),
        _ => format!("{part} changes"),
    }
}

/// Returns an atom as scenarios write it.
pub(super) fn atom(system: &TimedSystem, names: &PartNames, atom: &Atom) -> String {
    let phase = |phase: StatePhase| match phase {
        StatePhase::Lock => ".lock",
        StatePhase::Exec => ".exec",
        StatePhase::Any => "",
    };
    match *atom {
        Atom::Task(task, state) => format!("{}.{}", system.task_path(task), of_task(state)),
        Atom::State { machine, state, phase: wanted } => {
            let machine = &system.machines[machine];
            let state = &machine.states[state].name;
            format!("{}.{state}{}", machine.name, phase(wanted))
        }
        Atom::Slot(service, status) => {
            let status = match status {
                SlotStatus::Void => "void",
                SlotStatus::Wait => "wait",
                SlotStatus::Run => "run",
                SlotStatus::Stop => "stop",
                SlotStatus::Active => "active",
            };
            format!("{}.{status}", system.service_path(service))
        }
        Atom::Handling { service, codel, phase: wanted } => {
            let of = codel.map_or_else(
                || system.service_path(service),
                |codel| names.codel(codel).to_owned(),
            );
            format!("{of}{}", phase(wanted))
        }
        Atom::ControlBusy(component) => format!("{}.busy", system.components[component].name),
        Atom::Tick(task) => format!("{}.tick", system.task_path(task)),
        Atom::Data { fact, .. } => format!("data {fact}"),
        Atom::Violated(monitor) => format!("pattern {monitor} is violated"),
        Atom::Client(client, ref steps) => {
            let client = &system.clients[client];
            let label = |&step: &usize| {
                let step = client.steps.get(step);
                step.and_then(|step| step.label.clone())
            };
            match steps.iter().find_map(label) {
                Some(label) => format!("{}.{label}", client.name),
                None => format!("{} at {steps:?}", client.name),
            }
        }
    }
}
