//! Static facts about the tasks of a system, and about the watched properties. Several reductions use them.

use typed_index_collections::{TiVec, ti_vec};

use super::Watched;
use crate::property::Atom;
use crate::system::{AutomatonId, CodelId, CodelSet, Machine, TaskId, TimedSystem, Yield};

/// The parts of a system that predicates observe.
#[derive(Debug)]
pub(crate) struct Visible {
    /// Observed tasks.
    pub(super) tasks: Vec<bool>,
    /// Some control task or client is observed.
    pub(super) others: bool,
}

impl Visible {
    /// Returns the parts that these predicates observe.
    pub(crate) fn new<'p>(
        system: &TimedSystem,
        predicates: impl Iterator<Item = &'p crate::property::Predicate>,
    ) -> Self {
        let mut tasks = vec![false; system.tasks.len()];
        let mut others = false;
        for predicate in predicates {
            predicate.atoms(&mut |atom| match *atom {
                Atom::Task(task, _) | Atom::Tick(task) => tasks[usize::from(task)] = true,
                Atom::State { machine, .. } => {
                    for automaton in
                        system.automata.iter().filter(|automaton| automaton.machine == machine)
                    {
                        tasks[usize::from(automaton.task)] = true;
                    }
                }
                Atom::Slot(service, _) => {
                    for &a in &system.services[service].slots {
                        tasks[usize::from(system.automata[a].task)] = true;
                    }
                    others = true;
                }
                Atom::Handling { .. } | Atom::ControlBusy(_) | Atom::Client(..) => others = true,
                Atom::Data { .. } | Atom::Violated(_) => {}
            });
        }
        Visible { tasks, others }
    }
}

/// Static facts about the tasks of a system.
#[derive(Debug)]
pub(crate) struct Facts {
    /// Tasks without interaction with control tasks, clients or separate threads.
    pub(super) plain: Vec<bool>,
    /// Parts that predicates observe.
    pub(super) visible: Visible,
    /// Some observed task needs a core.
    pub(super) visible_on_cores: bool,
    /// Tasks whose permanent activity has a cycle that never ends, and that have no activities.
    pub(super) endless: Vec<bool>,
    /// Tasks whose response time or wait is measured.
    pub(super) measured: Vec<bool>,
    /// Thread of each codel.
    pub(super) owner: TiVec<CodelId, Owner>,
    /// Tasks with activities that can run.
    pub(super) active: Vec<bool>,
    /// By automaton and state, the codels that the same turn can reach after the state.
    pub(super) later: TiVec<AutomatonId, Vec<CodelSet>>,
}

impl Facts {
    /// Examines a system and its watched properties.
    pub(crate) fn new(system: &TimedSystem, asked: &Watched) -> Self {
        let visible = Visible::new(system, asked.predicates.iter().copied());
        let requested = system.requested();
        let plain = |task: usize| {
            let definition = &system.tasks[TaskId::from(task)];
            let simple = definition.permanent.is_none_or(|a| {
                let machine = system.machine_of(a);
                let separate =
                    system.platform.async_free && machine.states.iter().any(|state| state.is_async);
                !separate && !loops_in_no_time(system, machine, definition.period.is_none())
            });
            simple
                && !definition.keep_idle_tick
                && !system.has_activities(TaskId::from(task), &requested)
        };
        let endless = |task: usize| {
            let definition = &system.tasks[TaskId::from(task)];
            !system.has_activities(TaskId::from(task), &requested)
                && definition.permanent.is_some_and(|a| {
                    let machine = system.machine_of(a);
                    let mut states = machine.states.iter();
                    let separate = system.platform.async_free && states.any(|state| state.is_async);
                    !separate && machine.is_endless()
                })
        };
        let mut owner = ti_vec![Owner::Nobody; system.codels.len()];
        for automaton in &system.automata {
            if automaton.service.is_none_or(|service| requested[service]) {
                for state in &system.machines[automaton.machine].states {
                    owner[state.codel] = Owner::Task(usize::from(automaton.task));
                }
            }
        }
        for (service, entry) in system.services.iter_enumerated() {
            if requested[service] {
                for &codel in entry.validate.iter().chain(&entry.simple) {
                    owner[codel] = Owner::Control;
                }
            }
        }
        let tasks = 0..system.tasks.len();
        Facts {
            plain: tasks.clone().map(plain).collect(),
            visible_on_cores: tasks
                .clone()
                .any(|t| visible.tasks[t] && system.needs_core(TaskId::from(t))),
            visible,
            measured: asked.measured.clone(),
            endless: tasks.clone().map(endless).collect(),
            owner,
            active: tasks
                .clone()
                .map(|task| system.has_activities(TaskId::from(task), &requested))
                .collect(),
            later: (system.automata.keys()).map(|a| later(system.machine_of(a))).collect(),
        }
    }

    /// Returns true if a task has no interaction with control tasks, clients or separate threads.
    pub(super) fn plain(&self, task: usize) -> bool {
        self.plain[task]
    }

    /// Returns true if predicates observe any part.
    pub(super) fn observed(&self) -> bool {
        self.visible.others || self.visible.tasks.contains(&true)
    }

    /// Returns true if the cycle of a task never ends.
    pub(super) fn endless(&self, task: usize) -> bool {
        self.endless[task]
    }

    /// Returns the codels that the same turn of an automaton can reach after a state.
    pub(super) fn later(&self, automaton: AutomatonId, state: usize) -> &CodelSet {
        &self.later[automaton][state]
    }
}

/// The thread of a codel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Owner {
    Task(usize),
    Control,
    /// None: the codel belongs to a service without requests.
    Nobody,
}

/// Returns true if a turn can loop without time passing, through codels that take no time. The turns of an
/// aperiodic task follow each other at once.
pub(super) fn loops_in_no_time(system: &TimedSystem, machine: &Machine, aperiodic: bool) -> bool {
    if machine.loop_limit.is_some() && !machine.rounds && !aperiodic {
        return false;
    }
    let instant = |state: usize| system.codels[machine.states[state].codel].upper == 0;
    (0..machine.states.len()).any(|start| {
        let mut seen = vec![false; machine.states.len()];
        let mut stack = vec![start];
        while let Some(at) = stack.pop() {
            if !instant(at) {
                continue;
            }
            for transition in &machine.states[at].yields {
                let next = match *transition {
                    Yield::Next(next) => next,
                    Yield::Pause(next) if aperiodic => next,
                    _ => continue,
                };
                if next == start {
                    return true;
                }
                if !std::mem::replace(&mut seen[next], true) {
                    stack.push(next);
                }
            }
        }
        false
    })
}

/// Returns, by state, the codels of the states that the same turn can enter after it.
fn later(machine: &Machine) -> Vec<CodelSet> {
    (0..machine.states.len())
        .map(|start| {
            let mut out = CodelSet::default();
            let mut seen = vec![false; machine.states.len()];
            let mut stack = vec![start];
            while let Some(at) = stack.pop() {
                for transition in &machine.states[at].yields {
                    if let Yield::Next(next) = *transition
                        && !std::mem::replace(&mut seen[next], true)
                    {
                        out.insert(machine.states[next].codel);
                        stack.push(next);
                    }
                }
            }
            out
        })
        .collect()
}
