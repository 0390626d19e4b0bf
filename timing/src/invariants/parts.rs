//! The parts of a system, and the local states that each part can reach on its own.

mod steps;

use typed_index_collections::TiVec;

use crate::property::{Atom, SlotStatus, StatePhase, TaskState};
use crate::scn::semantics::{Cycle, TickRule};
use crate::system::{
    AutomatonId, ClientId, CodelId, ComponentId, MachineId, Policy, ServiceId, TaskId, TimedSystem,
};

/// A part of a system, which always is in one local state.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) kind: PartKind,
    /// The local states that its own rules can reach; the initial one is the first.
    pub(super) locals: Vec<Local>,
    /// The steps of its own rules, as indices of local states.
    pub(super) steps: Vec<(usize, usize)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PartKind {
    /// The thread of a task that executes passes: its status, and its codel.
    Thread(TaskId),
    /// The status of a task that executes jobs.
    Status(TaskId),
    /// An automaton of a task that executes jobs.
    Automaton(AutomatonId),
    Slots(ServiceId),
    /// The control task of a component.
    Control(ComponentId),
    Client(ClientId),
}

/// A local state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Local {
    /// A task without a codel.
    Task(TaskId, TaskState),
    /// A codel of a state machine: waiting for locks, or executing.
    Codel { task: TaskId, machine: MachineId, state: usize, codel: CodelId, executes: bool },
    /// An automaton without a codel.
    Rest,
    /// The slots of a service: all free, or not.
    Slots { service: ServiceId, void: bool },
    /// A control task that is ready for a message.
    Ready,
    /// A control task before its first message, or between codels.
    Busy,
    /// A control task with a codel: waiting for locks, or executing.
    Handling { service: ServiceId, codel: CodelId, executes: bool },
    /// A step of a client.
    At(ClientId, usize),
}

impl Local {
    /// Returns true if a codel is executed.
    pub(super) fn executes(&self) -> bool {
        matches!(self, Local::Codel { executes: true, .. } | Local::Handling { executes: true, .. })
    }

    /// Returns the codel, waiting or executing.
    pub(super) fn codel(&self) -> Option<CodelId> {
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
    pub(super) system: &'s TimedSystem,
    /// Tasks execute jobs, see sections 3 to 9 of the timed semantics.
    jobs: bool,
    /// By service, whether some client requests it.
    requested: TiVec<ServiceId, bool>,
    pub(super) parts: Vec<Part>,
}

impl<'s> Parts<'s> {
    /// Returns the parts of a system.
    pub(super) fn of(system: &'s TimedSystem) -> Self {
        let jobs = system.platform.semantics.fixed().cycle == Cycle::Jobs;
        let mut out = Parts { system, jobs, requested: system.requested(), parts: Vec::new() };
        for task in system.tasks.keys() {
            if jobs {
                out.push(PartKind::Status(task));
                for automaton in out.automata(task) {
                    out.push(PartKind::Automaton(automaton));
                }
            } else {
                out.push(PartKind::Thread(task));
            }
        }
        system.services.keys().for_each(|service| out.push(PartKind::Slots(service)));
        let components = system.components.keys();
        components.for_each(|component| out.push(PartKind::Control(component)));
        let clients = system.clients.keys();
        clients.for_each(|client| out.push(PartKind::Client(client)));
        out
    }

    /// Returns the automata of a task that can run.
    fn automata(&self, task: TaskId) -> Vec<AutomatonId> {
        let it = &self.system.tasks[task];
        let executed = |&automaton: &AutomatonId| {
            let service = self.system.automata[automaton].service;
            service.is_none_or(|service| self.requested[service])
        };
        let all = it.permanent.iter().chain(&it.slots).copied();
        all.filter(executed).collect()
    }

    /// Returns true if a local state of a part decides an atom, alone or with other parts.
    pub(super) fn is_about(&self, part: &Part, atom: &Atom) -> bool {
        match *atom {
            Atom::Task(task, _) => {
                matches!(part.kind, PartKind::Thread(of) | PartKind::Status(of) if of == task)
            }
            Atom::State { machine, .. } => {
                let runs =
                    |&automaton: &AutomatonId| self.system.automata[automaton].machine == machine;
                match part.kind {
                    PartKind::Automaton(automaton) => runs(&automaton),
                    PartKind::Thread(task) => {
                        let it = &self.system.tasks[task];
                        it.permanent.iter().chain(&it.slots).any(runs)
                    }
                    _ => false,
                }
            }
            Atom::Slot(service, _) => part.kind == PartKind::Slots(service),
            Atom::Handling { service, .. } => {
                part.kind == PartKind::Control(self.system.services[service].component)
            }
            Atom::ControlBusy(component) => part.kind == PartKind::Control(component),
            Atom::Client(client, _) => part.kind == PartKind::Client(client),
            Atom::Tick(_) | Atom::Data { .. } | Atom::Violated(_) => false,
        }
    }

    /// Returns the parts that an atom restricts if it has a value.
    pub(super) fn about(&self, atom: &Atom, holds: bool) -> Vec<&Part> {
        let all = self.parts.iter();
        let parts: Vec<&Part> = all.filter(|part| self.is_about(part, atom)).collect();
        let tells = if holds { parts.len() == 1 } else { is_exact(atom) };
        if tells { parts } else { Vec::new() }
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
                Atom::State { machine, state, phase },
                Local::Codel { machine: own, state: at, executes, .. },
            ) => machine == own && state == at && in_phase(*executes, *phase),
            (Atom::Slot(_, status), Local::Slots { void, .. }) => {
                *void == (*status == SlotStatus::Void)
            }
            (
                Atom::Handling { service, codel, phase },
                Local::Handling { service: own, codel: at, executes },
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

    /// Returns the number of cores, if it limits the tasks that have codels. (With preemption, a codel that
    /// has begun may be without a core. With jobs, the first codel of a task needs none.)
    pub(super) fn cores(&self) -> Option<u32> {
        let platform = &self.system.platform;
        let held = matches!(platform.policy, Policy::Fifo | Policy::Edf | Policy::Any)
            && platform.semantics.ticks == TickRule::Component
            && !self.jobs;
        platform.cores.filter(|_| held)
    }

    /// Returns true if a part in a local state has a core.
    pub(super) fn has_core(&self, part: &Part, local: &Local) -> bool {
        match part.kind {
            PartKind::Thread(task) => {
                self.system.needs_core(task) && matches!(local, Local::Codel { .. })
            }
            _ => false,
        }
    }

    /// Returns true if more tasks have codels than there are cores.
    pub(super) fn are_too_many(&self, present: &[(&Part, Vec<&Local>)]) -> bool {
        let on_core = (present.iter())
            .filter(|(part, locals)| locals.iter().all(|local| self.has_core(part, local)));
        self.cores().is_some_and(|cores| on_core.count() > cores as usize)
    }

    /// Returns the service whose codel a local state has, if the codel is one of an activity.
    pub(super) fn service(&self, local: &Local) -> Option<ServiceId> {
        let Local::Codel { machine, .. } = *local else {
            return None;
        };
        let mut automata = self.system.automata.iter();
        automata.find(|automaton| automaton.machine == machine)?.service
    }
}

/// Returns true if the local states in which an atom may hold imply the atom. (Activities may have another
/// status than these.)
pub(super) fn is_exact(atom: &Atom) -> bool {
    let Atom::Slot(_, status) = atom else {
        return true;
    };
    matches!(status, SlotStatus::Void | SlotStatus::Active)
}
