//! The parts of a system, and the local states that each part can reach on its own.

use crate::property::{Atom, SlotStatus, StatePhase, TaskState};
use crate::scn::semantics::TickRule;
use crate::system::{
    AutomatonId, ClientId, CodelId, ComponentId, Machine, MachineId, Policy, ServiceId, TaskId,
    TimedSystem, Yield,
};

/// A part of a system, which always is in one local state.
#[derive(Debug)]
pub(super) struct Part {
    kind: PartKind,
    /// The local states that its own rules can reach.
    pub(super) locals: Vec<Local>,
}

/// The kinds of parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PartKind {
    /// The thread of a task that executes passes: its status, and its codel.
    Thread(TaskId),
    /// The status of a task that executes jobs.
    Status(TaskId),
    /// An automaton of a task that executes jobs.
    Automaton(AutomatonId),
    /// The slots of a service.
    Slots(ServiceId),
    /// The control task of a component.
    Control(ComponentId),
    /// A client.
    Client(ClientId),
}

/// A local state.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Local {
    /// A task without a codel.
    Task(TaskId, TaskState),
    /// A codel of a state machine: waiting for locks, or executing.
    Codel {
        task: TaskId,
        machine: MachineId,
        state: usize,
        codel: CodelId,
        executes: bool,
    },
    /// An automaton without a codel.
    Rest,
    /// The slots of a service: all free, or not.
    Slots { service: ServiceId, void: bool },
    /// A control task that is ready for a message.
    Ready,
    /// A control task before its first message, or between codels.
    Busy,
    /// A control task with a codel: waiting for locks, or executing.
    Handling {
        service: ServiceId,
        codel: CodelId,
        executes: bool,
    },
    /// A step of a client.
    At(ClientId, usize),
}

impl Local {
    /// Returns true if a codel is executed.
    pub(super) fn executes(&self) -> bool {
        matches!(
            self,
            Local::Codel { executes: true, .. } | Local::Handling { executes: true, .. }
        )
    }

    fn codel(&self) -> Option<CodelId> {
        match *self {
            Local::Codel { codel, .. } | Local::Handling { codel, .. } => Some(codel),
            _ => None,
        }
    }

    /// Returns true if a service has no activity.
    pub(super) fn is_void(&self, of: ServiceId) -> bool {
        matches!(*self, Local::Slots { service, void: true } if service == of)
    }
}

/// The parts of a system.
pub(super) struct Parts<'s> {
    system: &'s TimedSystem,
    /// Tasks execute jobs, see sections 3 to 9 of the timed semantics.
    jobs: bool,
    parts: Vec<Part>,
}

impl<'s> Parts<'s> {
    /// Returns the parts of a system.
    pub(super) fn of(system: &'s TimedSystem) -> Self {
        let jobs = system.platform.semantics.is_published();
        let requested = system.requested();
        let mut out = Parts {
            system,
            jobs,
            parts: Vec::new(),
        };
        let executed = |&automaton: &AutomatonId| {
            let service = system.automata[automaton].service;
            service.is_none_or(|service| requested[service])
        };
        for (task, it) in system.tasks.iter_enumerated() {
            let automata = it.permanent.iter().chain(&it.slots).copied();
            let automata: Vec<AutomatonId> = automata.filter(executed).collect();
            let states = [TaskState::Idle, TaskState::Waiting, TaskState::Running];
            let mut locals: Vec<Local> = states.map(|state| Local::Task(task, state)).into();
            if jobs {
                out.push(PartKind::Status(task), locals);
                for automaton in automata {
                    let mut locals = vec![Local::Rest];
                    locals.extend(out.codels(automaton));
                    out.push(PartKind::Automaton(automaton), locals);
                }
            } else {
                let codels = automata
                    .into_iter()
                    .flat_map(|automaton| out.codels(automaton));
                locals.extend(codels);
                out.push(PartKind::Thread(task), locals);
            }
        }
        for (service, &requested) in requested.iter_enumerated() {
            let mut locals = vec![Local::Slots {
                service,
                void: true,
            }];
            locals.extend(requested.then_some(Local::Slots {
                service,
                void: false,
            }));
            out.push(PartKind::Slots(service), locals);
        }
        for (component, it) in system.components.iter_enumerated() {
            let mut locals = vec![Local::Ready, Local::Busy];
            for &service in it.services.iter().filter(|&&service| requested[service]) {
                let of = &system.services[service];
                let codels = of.validate.iter().chain(&of.simple);
                let each = codels.flat_map(|&codel| [(codel, false), (codel, true)]);
                locals.extend(each.map(|(codel, executes)| Local::Handling {
                    service,
                    codel,
                    executes,
                }));
            }
            out.push(PartKind::Control(component), locals);
        }
        for (client, it) in system.clients.iter_enumerated() {
            // Before the first step, the steps, and after the last one.
            let steps = 0..=it.done() + 1;
            out.push(
                PartKind::Client(client),
                steps.map(|step| Local::At(client, step)).collect(),
            );
        }
        out
    }

    fn push(&mut self, kind: PartKind, locals: Vec<Local>) {
        self.parts.push(Part { kind, locals });
    }

    /// Returns the codels of an automaton in the states that its machine can reach.
    fn codels(&self, automaton: AutomatonId) -> Vec<Local> {
        let it = &self.system.automata[automaton];
        let machine = &self.system.machines[it.machine];
        let states = reachable(machine).into_iter();
        let each = states.flat_map(|state| [(state, false), (state, true)]);
        each.map(|(state, executes)| Local::Codel {
            task: it.task,
            machine: it.machine,
            state,
            codel: machine.states[state].codel,
            executes,
        })
        .collect()
    }

    /// Returns the parts that an atom restricts if it has a value.
    pub(super) fn about(&self, atom: &Atom, holds: bool) -> Vec<&Part> {
        let of_kind = |kinds: &dyn Fn(PartKind) -> bool| -> Vec<&Part> {
            self.parts.iter().filter(|part| kinds(part.kind)).collect()
        };
        match *atom {
            Atom::Task(task, _) => {
                of_kind(&|kind| kind == PartKind::Thread(task) || kind == PartKind::Status(task))
            }
            Atom::State { machine, .. } => {
                let runs =
                    |automaton: AutomatonId| self.system.automata[automaton].machine == machine;
                let parts = of_kind(&|kind| match kind {
                    PartKind::Automaton(automaton) => runs(automaton),
                    PartKind::Thread(task) => {
                        let it = &self.system.tasks[task];
                        it.permanent
                            .iter()
                            .chain(&it.slots)
                            .any(|&automaton| runs(automaton))
                    }
                    _ => false,
                });
                // Any of several automata may be in the state.
                if holds && parts.len() > 1 {
                    return Vec::new();
                }
                parts
            }
            Atom::Slot(service, status) => match (status, holds) {
                (SlotStatus::Void | SlotStatus::Active, _) | (_, true) => {
                    of_kind(&|kind| kind == PartKind::Slots(service))
                }
                // Activities may have another status.
                (SlotStatus::Wait | SlotStatus::Run | SlotStatus::Stop, false) => Vec::new(),
            },
            Atom::Handling { service, .. } => {
                let component = self.system.services[service].component;
                of_kind(&|kind| kind == PartKind::Control(component))
            }
            Atom::ControlBusy(component) => of_kind(&|kind| kind == PartKind::Control(component)),
            Atom::Client(client, _) => of_kind(&|kind| kind == PartKind::Client(client)),
        }
    }

    /// Returns the value of an atom in a local state of a part that the atom restricts.
    pub(super) fn value(&self, local: &Local, atom: &Atom) -> bool {
        let in_phase = |executes: bool, phase: StatePhase| match phase {
            StatePhase::Any => true,
            StatePhase::Exec => executes,
            StatePhase::Lock => !executes,
        };
        match (atom, local) {
            (Atom::Task(_, wanted), Local::Task(_, state)) => {
                wanted == state || (*wanted == TaskState::Active && *state != TaskState::Idle)
            }
            (Atom::Task(_, wanted), Local::Codel { .. }) => {
                matches!(wanted, TaskState::Running | TaskState::Active)
            }
            (
                Atom::State {
                    machine,
                    state,
                    phase,
                },
                Local::Codel {
                    machine: own,
                    state: at,
                    executes,
                    ..
                },
            ) => machine == own && state == at && in_phase(*executes, *phase),
            (Atom::Slot(_, status), Local::Slots { void, .. }) => {
                *void == (*status == SlotStatus::Void)
            }
            (
                Atom::Handling {
                    service,
                    codel,
                    phase,
                },
                Local::Handling {
                    service: own,
                    codel: at,
                    executes,
                },
            ) => {
                service == own
                    && codel.is_none_or(|codel| codel == *at)
                    && in_phase(*executes, *phase)
            }
            (Atom::ControlBusy(_), local) => *local != Local::Ready,
            (Atom::Client(_, steps), Local::At(_, step)) => steps.contains(step),
            _ => false,
        }
    }

    /// Returns true if the codels of two local states are never executed at the same time.
    pub(super) fn exclude(&self, one: &Local, other: &Local) -> bool {
        let (Some(one), Some(other)) = (one.codel(), other.codel()) else {
            return false;
        };
        let blocks =
            |one: CodelId, other: CodelId| self.system.codels[one].conflicts.contains(other);
        blocks(one, other) && blocks(other, one)
    }

    /// Returns true if more tasks execute codels than there are cores. (With preemption, a codel that has
    /// begun may be without a core. With jobs, the first codel of a task needs none.)
    pub(super) fn are_too_many(&self, present: &[(&Part, Vec<&Local>)]) -> bool {
        let platform = &self.system.platform;
        let Some(cores) = platform.cores else {
            return false;
        };
        let held = matches!(platform.policy, Policy::Fifo | Policy::Edf | Policy::Any)
            && platform.semantics.ticks == TickRule::Component
            && !self.jobs;
        let on_core = present.iter().filter(|(part, locals)| match part.kind {
            PartKind::Thread(task) => {
                let codel = |local: &&Local| matches!(local, Local::Codel { .. });
                self.system.needs_core(task) && locals.iter().all(codel)
            }
            _ => false,
        });
        held && on_core.count() > cores as usize
    }

    /// Returns the service whose codel a local state has, if the codel is one of an activity.
    pub(super) fn service(&self, local: &Local) -> Option<ServiceId> {
        let Local::Codel { machine, .. } = *local else {
            return None;
        };
        let mut automata = self.system.automata.iter();
        automata
            .find(|automaton| automaton.machine == machine)?
            .service
    }
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
