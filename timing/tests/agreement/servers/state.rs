//! States, and the initial state.

use std::collections::BTreeSet;

use dotgen_timing::scn::semantics::TickRule;

use super::model::{Action, System};
use super::patterns::Memory;

/// Age above which a time counts as unbounded.
pub(crate) const CAP: u32 = 150;

/// An activity in its slot.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Instance {
    /// Service; `None` for the permanent activity.
    pub(super) service: Option<usize>,
    pub(super) status: Status,
    /// State of its machine.
    pub(super) at: usize,
    pub(super) paused: bool,
    /// The activity is interrupted, and has not noticed yet.
    pub(super) mark: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Status {
    /// Its request is being handled.
    Asked,
    /// Waiting to begin. `true`: it may.
    Init(bool),
    Run,
    Stop,
    /// Ended and not yet reported. `true`: it has succeeded.
    Ended(bool),
}

/// The progress of a task or control task with its codel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Doing {
    /// It has no ticket yet.
    Nothing,
    Queued,
    Executing(u32),
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Phase {
    Idle,
    WaitingForCore,
    /// Between two passes of a cycle.
    Between,
    /// The slots with a turn in this pass, and the one whose turn it is.
    Pass(Vec<usize>, usize, Doing),
}

/// The progress of a task with its first cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum First {
    NotStarted,
    Started,
    InCycle,
    Over,
}

/// A tick that was not served yet, or the tick that a job serves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Since {
    /// Time since the tick.
    pub(super) tick: u32,
    /// Measured part of this time.
    pub(super) measured: u32,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Task {
    /// Time to the next tick.
    pub(super) timer: Option<u32>,
    pub(super) flag: Option<Since>,
    /// Flag of an aperiodic task.
    pub(super) runnable: bool,
    pub(super) phase: Phase,
    pub(super) first: First,
    pub(super) job: Option<Since>,
    pub(super) slots: Vec<Option<Instance>>,
    /// Events of this pass: a transition without a pause or an end; the end of an activity.
    pub(super) event: bool,
    pub(super) ended: bool,
    /// The permanent activity has thrown an exception in its first pass.
    pub(super) failed: bool,
    /// The other tasks must be woken.
    pub(super) wake: bool,
    /// The task was granted a core, and its last pass and the wake-ups after it are not over.
    pub(super) on_core: bool,
    /// It has ended with its component.
    pub(super) gone: bool,
}

/// The stage of the shutdown of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Kill {
    No,
    /// The activities of a task are interrupted.
    Activities(usize),
    /// The permanent activity of a task must be interrupted, or has been.
    Permanent(usize),
    Stopping(usize),
    /// A task ends, and at last the control task.
    Task(usize),
    Control,
    Over,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Control {
    /// Tasks are being started.
    Starting,
    Ready,
    /// At a codel of a request.
    Codel(Request, usize, Doing),
    /// The handling of a request after its codels.
    Rest(Request, Handled),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Request {
    pub(super) client: usize,
    pub(super) service: usize,
    /// Task and slot of an activity.
    pub(super) slot: Option<(usize, usize)>,
    /// Step that sent the request, if it matters.
    pub(super) node: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Handled {
    Accepted,
    Refused,
}

/// A thread that takes tickets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Who {
    Task(usize),
    Control,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Component {
    pub(super) control: Control,
    /// Some activity has ended.
    pub(super) signal: bool,
    pub(super) tickets: Vec<Who>,
    /// Success of services, by service.
    pub(super) succeeded: Vec<bool>,
    pub(super) tasks: Vec<Task>,
    pub(super) kill: Kill,
}

/// A request whose end is awaited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Tracked {
    /// The request has ended. `true`: with success, if a client depends on it.
    Over(bool),
    Handled,
    /// Task and slot.
    Slot(usize, usize),
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Client {
    /// Node; `None` before the first step.
    pub(super) at: Option<usize>,
    pub(super) clock: u32,
    pub(super) outstanding: bool,
    /// The last request for each service, and the last request of all.
    pub(super) tracked: Vec<(usize, usize, Tracked)>,
    /// Instances that it may abort, in order of acceptance.
    pub(super) instances: Vec<Accepted>,
}

/// An instance that was accepted: component, service, node, and task and slot until it is reported.
pub(super) type Accepted = (usize, usize, usize, Option<(usize, usize)>);

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct State {
    pub(super) components: Vec<Component>,
    pub(super) clients: Vec<Client>,
    /// Tasks that wait for a core, in order.
    pub(super) queue: Vec<(usize, usize)>,
    /// Under preemption with priorities, threads in the order in which they became ready.
    pub(super) ready: Vec<(usize, Who)>,
    /// Under preemption without priorities, threads that have a core.
    pub(super) on: Vec<(usize, Who)>,
    /// Open obligations of each observer: number of responses so far, and age.
    pub(super) obligations: Vec<BTreeSet<(usize, u32)>>,
    pub(super) patterns: Vec<Memory>,
}

impl State {
    pub(super) fn initial(system: &System, observers: usize) -> State {
        let component = |component: &super::model::Component| {
            let task = |task: &super::model::Task| Task {
                timer: (task.period.filter(|_| system.semantics.ticks == TickRule::Component)).map(
                    |period| match task.delay {
                        0 => period,
                        delay => delay,
                    },
                ),
                flag: None,
                runnable: task.period.is_none(),
                phase: Phase::Idle,
                first: First::NotStarted,
                job: None,
                slots: (0..task.slots)
                    .map(|slot| {
                        (slot == 0).then_some(Instance {
                            service: None,
                            status: Status::Init(true),
                            at: 0,
                            paused: false,
                            mark: false,
                        })
                    })
                    .collect(),
                event: false,
                ended: false,
                failed: false,
                wake: false,
                on_core: false,
                gone: false,
            };
            let tasks: Vec<Task> = component.tasks.iter().map(task).collect();
            Component {
                control: if tasks.is_empty() { Control::Ready } else { Control::Starting },
                signal: false,
                tickets: Vec::new(),
                succeeded: vec![false; component.services.len()],
                tasks,
                kill: Kill::No,
            }
        };
        State {
            components: system.components.iter().map(component).collect(),
            clients: (system.clients.iter())
                .map(|_| Client {
                    at: None,
                    clock: 0,
                    outstanding: false,
                    tracked: Vec::new(),
                    instances: Vec::new(),
                })
                .collect(),
            queue: Vec::new(),
            ready: Vec::new(),
            on: Vec::new(),
            obligations: vec![BTreeSet::new(); observers],
            patterns: Vec::new(),
        }
    }

    /// Returns the progress of a thread of a component with its codel.
    pub(super) fn doing(&self, c: usize, who: Who) -> Option<Doing> {
        let component = &self.components[c];
        match who {
            Who::Control => match &component.control {
                Control::Codel(.., doing) => Some(*doing),
                _ => None,
            },
            Who::Task(t) => match &component.tasks[t].phase {
                Phase::Pass(.., doing) => Some(*doing),
                _ => None,
            },
        }
    }

    pub(super) fn set_doing(&mut self, c: usize, who: Who, to: Doing) {
        let component = &mut self.components[c];
        match who {
            Who::Control => {
                if let Control::Codel(.., doing) = &mut component.control {
                    *doing = to;
                }
            }
            Who::Task(t) => {
                if let Phase::Pass(.., doing) = &mut component.tasks[t].phase {
                    *doing = to;
                }
            }
        }
    }

    /// Returns the present codel of a thread.
    pub(super) fn codel(&self, system: &System, c: usize, who: Who) -> Option<usize> {
        let model = &system.components[c];
        match who {
            Who::Control => match &self.components[c].control {
                Control::Codel(request, at, _) => {
                    Some(model.services[request.service].control[*at].codel)
                }
                _ => None,
            },
            Who::Task(t) => {
                let Phase::Pass(slots, at, _) = &self.components[c].tasks[t].phase else {
                    return None;
                };
                let instance = self.components[c].tasks[t].slots[slots[*at]].as_ref()?;
                let machine = machine(system, c, t, instance);
                Some(machine.states.get(instance.at)?.codel)
            }
        }
    }

    /// Returns the slot whose turn a task executes.
    pub(super) fn slot(&self, c: usize, t: usize) -> Option<usize> {
        match &self.components[c].tasks[t].phase {
            Phase::Pass(slots, at, _) => slots.get(*at).copied(),
            _ => None,
        }
    }

    /// Returns all threads of a component that may be at a codel.
    pub(super) fn everybody(&self, c: usize) -> impl Iterator<Item = Who> + use<> {
        let tasks = 0..self.components[c].tasks.len();
        tasks.map(Who::Task).chain([Who::Control])
    }

    /// Returns the present delay of a client.
    pub(super) fn delay(&self, system: &System, k: usize) -> Option<(u32, u32)> {
        match system.clients[k].nodes[self.clients[k].at?].action {
            Action::Delay(lower, upper) => Some((lower, upper)),
            _ => None,
        }
    }
}

/// Returns the machine of an instance in a slot of a task.
pub(super) fn machine<'s>(
    system: &'s System,
    c: usize,
    t: usize,
    instance: &Instance,
) -> &'s super::model::Machine {
    let component = &system.components[c];
    match instance.service {
        None => &component.tasks[t].machine,
        Some(s) => match &component.services[s].activity {
            Some((_, machine)) => machine,
            None => unreachable!("only activities have slots"),
        },
    }
}
