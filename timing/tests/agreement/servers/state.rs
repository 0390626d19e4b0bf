//! A state, and how it begins.

use std::collections::BTreeSet;

use dotgen_timing::scn::semantics::TickRule;

use super::model::{Action, System};

/// Ages beyond this are taken for unbounded.
pub(crate) const CAP: u32 = 150;

/// An activity in its slot.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Instance {
    /// None: the permanent activity.
    pub(super) service: Option<usize>,
    pub(super) status: Status,
    /// State of its machine.
    pub(super) at: usize,
    pub(super) paused: bool,
    /// Interrupted, and not noticed yet.
    pub(super) mark: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Status {
    /// Its request is being handled.
    Asked,
    /// Waiting to begin; whether it may.
    Init(bool),
    Run,
    Stop,
    /// Ended and not yet reported; whether it has succeeded.
    Ended(bool),
}

/// What a task or the control task does with its codel.
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
    /// The slots that have a turn in this pass, and which one has it.
    Pass(Vec<usize>, usize, Doing),
}

/// Where a task is with its first cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum First {
    NotStarted,
    Started,
    InCycle,
    Over,
}

/// A tick that was not served yet, or the one a job serves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Since {
    /// Since the tick.
    pub(super) tick: u32,
    /// What counts of it.
    pub(super) measured: u32,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Task {
    /// Time to the next tick.
    pub(super) timer: Option<u32>,
    pub(super) flag: Option<Since>,
    /// Of an aperiodic task.
    pub(super) runnable: bool,
    pub(super) phase: Phase,
    pub(super) first: First,
    pub(super) job: Option<Since>,
    pub(super) slots: Vec<Option<Instance>>,
    /// What happened in this pass: a transition without pause or an end; an activity that ended.
    pub(super) event: bool,
    pub(super) ended: bool,
    /// The permanent activity has thrown an exception in its first pass.
    pub(super) failed: bool,
    /// The other tasks have to be woken.
    pub(super) wake: bool,
    /// It was granted a core, and its last pass and the wake-ups after it are not over.
    pub(super) on_core: bool,
    /// It has ended with its component.
    pub(super) gone: bool,
}

/// Where the shutdown of a component is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Kill {
    No,
    /// The activities of a task are interrupted.
    Activities(usize),
    /// The permanent activity of a task is to be interrupted; it was.
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
    /// What follows the codels of a request.
    Rest(Request, Handled),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Request {
    pub(super) client: usize,
    pub(super) service: usize,
    /// Of an activity: task and slot.
    pub(super) slot: Option<(usize, usize)>,
    /// The step by which it was sent, where that matters.
    pub(super) node: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Handled {
    Accepted,
    Refused,
}

/// Who takes tickets.
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
    /// By service.
    pub(super) succeeded: Vec<bool>,
    pub(super) tasks: Vec<Task>,
    pub(super) kill: Kill,
}

/// A request whose end is awaited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Tracked {
    /// Whether it has succeeded; only where somebody asks.
    Over(bool),
    Handled,
    /// Task and slot.
    Slot(usize, usize),
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Client {
    /// None: before the first step.
    pub(super) at: Option<usize>,
    pub(super) clock: u32,
    pub(super) outstanding: bool,
    /// The last request for each service, and the last one of all.
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
    /// Under preemption without, threads that have a core.
    pub(super) on: Vec<(usize, Who)>,
    /// Of each observer, the open obligations: how many responses each has seen, and its age.
    pub(super) obligations: Vec<BTreeSet<(usize, u32)>>,
}

impl State {
    pub(super) fn initial(system: &System, observers: usize) -> State {
        let component = |it: &super::model::Component| {
            let task = |it: &super::model::Task| Task {
                timer: (it
                    .period
                    .filter(|_| system.semantics.ticks == TickRule::Component))
                .map(|period| match it.delay {
                    0 => period,
                    delay => delay,
                }),
                flag: None,
                runnable: it.period.is_none(),
                phase: Phase::Idle,
                first: First::NotStarted,
                job: None,
                slots: (0..it.slots)
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
            let tasks: Vec<Task> = it.tasks.iter().map(task).collect();
            Component {
                control: match tasks.is_empty() {
                    true => Control::Ready,
                    false => Control::Starting,
                },
                signal: false,
                tickets: Vec::new(),
                succeeded: vec![false; it.services.len()],
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
        }
    }

    /// What somebody of a component does with a codel.
    pub(super) fn doing(&self, c: usize, who: Who) -> Option<Doing> {
        let it = &self.components[c];
        match who {
            Who::Control => match &it.control {
                Control::Codel(.., doing) => Some(*doing),
                _ => None,
            },
            Who::Task(t) => match &it.tasks[t].phase {
                Phase::Pass(.., doing) => Some(*doing),
                _ => None,
            },
        }
    }

    pub(super) fn set_doing(&mut self, c: usize, who: Who, to: Doing) {
        let it = &mut self.components[c];
        match who {
            Who::Control => {
                if let Control::Codel(.., doing) = &mut it.control {
                    *doing = to;
                }
            }
            Who::Task(t) => {
                if let Phase::Pass(.., doing) = &mut it.tasks[t].phase {
                    *doing = to;
                }
            }
        }
    }

    /// The codel that somebody is at.
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

    /// The slot whose turn a task executes.
    pub(super) fn slot(&self, c: usize, t: usize) -> Option<usize> {
        match &self.components[c].tasks[t].phase {
            Phase::Pass(slots, at, _) => slots.get(*at).copied(),
            _ => None,
        }
    }

    /// Everybody of a component who may be at a codel.
    pub(super) fn everybody(&self, c: usize) -> impl Iterator<Item = Who> + use<> {
        let tasks = 0..self.components[c].tasks.len();
        tasks.map(Who::Task).chain([Who::Control])
    }

    /// The delay that a client is at.
    pub(super) fn delay(&self, system: &System, k: usize) -> Option<(u32, u32)> {
        match system.clients[k].nodes[self.clients[k].at?].action {
            Action::Delay(lower, upper) => Some((lower, upper)),
            _ => None,
        }
    }
}

/// The machine that an instance in a slot of a task executes.
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
