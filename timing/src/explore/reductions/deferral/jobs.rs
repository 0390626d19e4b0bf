//! Lazy groups with jobs.
//!
//! A group is a set of tasks, control tasks and clients connected by codels that exclude each other, by
//! activities and by requests. It is lazy if all its codels and delays have lower bound 0 and its
//! periodic tasks do not keep ticks. An aperiodic task can belong to a lazy group if it asks for a core
//! at most once, or never (else waiting changes its place in the queue), and if its response time is not
//! measured (which would begin later).
//!
//! Groups meet only at cores: while a task of another group waits for a core no end can be postponed. (A
//! lazy task that waits loses nothing by a later grant: its release is past, and its codels have wider
//! windows.) Start-up is lazy only if no timer starts at its end, and if there are clients (its
//! overtaking, see [`sleep_sets`](super::super::sleep_sets), is not examined). No group is lazy while a
//! lazy task has a pending tick: its next job is released, and measured, from the end of the present one.
//! The order of steps of different groups is not preserved, so groups that a predicate observes are not
//! lazy. And there has to be a next hard moment: some task is periodic.

use smallvec::SmallVec;
use typed_index_collections::{TiSlice, ti_vec};

use super::rest;
use crate::explore::reductions::{Deferrable, Kind, Reason, Setting};
use crate::explore::rules::Rules;
use crate::explore::rules::status::permanent;
use crate::explore::state::{State, phase};
use crate::system::{
    AutomatonId, ClientAction, ClientId, ComponentId, ServiceId, TaskId, TimedSystem,
};

/// The lazy groups. Tasks, control tasks and clients are numbered as *members*, in this order.
#[derive(Debug)]
pub(crate) struct LazyMembers {
    members: Vec<bool>,
    /// Group of each member.
    group: Vec<usize>,
    /// Automata with a resting place, and the state.
    pub(super) rest: Vec<(AutomatonId, usize)>,
    /// Tasks whose start-up is lazy.
    starts: Vec<bool>,
}

impl LazyMembers {
    /// Returns the lazy groups of a system, or the reason why there are none.
    pub(super) fn of(setting: &Setting) -> Result<Self, Reason> {
        if (setting.system().tasks.iter()).all(|task| task.period.is_none()) {
            return Err(Reason::NothingPeriodic);
        }
        let groups = LazyMembers::new(setting);
        if groups.members.contains(&true) { Ok(groups) } else { Err(Reason::NothingToPutOff) }
    }

    /// Returns the lazy groups of a system, possibly none.
    fn new(setting: &Setting) -> Self {
        let system = setting.system();
        let (visible, measured) = (&setting.facts.visible, &setting.facts.measured);
        let rests = !setting.without.contains(Kind::RestingLoops);
        let tasks = system.tasks.len();
        let control = |component: ComponentId| tasks + usize::from(component);
        let client = |client: ClientId| tasks + system.components.len() + usize::from(client);
        let n = client(system.clients.next_key());
        let mut owner = ti_vec![usize::MAX; system.codels.len()];
        let mut lazy = vec![true; n];
        let mut group: Vec<usize> = (0..n).collect();
        let mut join = |one: usize, other: usize| {
            let (from, to) = (group[one], group[other]);
            let members = group.iter_mut().filter(|group| **group == from);
            members.for_each(|member| *member = to);
        };
        let requested = system.requested();
        let live =
            |a: AutomatonId| system.automata[a].service.is_none_or(|service| requested[service]);
        for (a, automaton) in system.automata.iter_enumerated() {
            if live(a) {
                for state in &system.machine_of(a).states {
                    owner[state.codel] = usize::from(automaton.task);
                }
                if automaton.service.is_some() {
                    join(
                        usize::from(automaton.task),
                        control(system.tasks[automaton.task].component),
                    );
                }
            }
        }
        for (service, entry) in system.services.iter_enumerated() {
            if requested[service] {
                for &codel in entry.validate.iter().chain(&entry.simple) {
                    owner[codel] = control(entry.component);
                    lazy[control(entry.component)] &= system.codels[codel].lower == 0;
                }
            }
        }
        for (k, definition) in system.clients.iter_enumerated() {
            for step in &definition.steps {
                match step.action {
                    ClientAction::Send { service, .. } => {
                        join(client(k), control(system.services[service].component));
                    }
                    ClientAction::Delay(lower, _) => lazy[client(k)] &= lower == 0,
                    ClientAction::AwaitAccepted
                    | ClientAction::AwaitEnded(_)
                    | ClientAction::AwaitAny
                    | ClientAction::AwaitOutcome(..) => {}
                }
            }
        }
        if visible.others {
            lazy[tasks..].fill(false);
        }
        let mut rest = Vec::new();
        for (a, automaton) in system.automata.iter_enumerated() {
            if !live(a) {
                continue;
            }
            let task = automaton.task;
            let place = rest::place(system, a, &owner).filter(|_| {
                rests
                    && !measured[usize::from(task)]
                    && endless(system, usize::from(task), &requested)
            });
            rest.extend(place.map(|state| (a, state)));
            for (number, state) in system.machine_of(a).states.iter().enumerate() {
                let separate = state.is_async && system.platform.async_free;
                let slow = system.codels[state.codel].lower > 0 && place != Some(number);
                if separate || slow {
                    lazy[usize::from(task)] = false;
                }
            }
        }
        for (task, entry) in system.tasks.iter().enumerate() {
            let fits = if entry.period.is_some() {
                !entry.keep_idle_tick
            } else {
                !measured[task]
                    && (!system.needs_core(TaskId::from(task)) || endless(system, task, &requested))
            };
            lazy[task] &= fits && !visible.tasks[task];
        }
        for (one, codel) in system.codels.iter_enumerated() {
            for other in codel.conflicts.iter() {
                let (Some(&a), Some(&b)) = (owner.get(one), owner.get(other)) else {
                    continue;
                };
                if a < n && b < n {
                    join(a, b);
                }
            }
        }
        let not_lazy: Vec<usize> =
            (0..n).filter(|&part| !lazy[part]).map(|part| group[part]).collect();
        let members: Vec<bool> = (0..n).map(|part| !not_lazy.contains(&group[part])).collect();
        rest.retain(|&(a, _)| members[usize::from(system.automata[a].task)]);
        // The end of start-up lets the control task begin, so the group of the control task must be lazy as
        // well.
        let can_start = |task: usize| {
            let control = control(system.tasks[TaskId::from(task)].component);
            let mut resting =
                rest.iter().map(|&(a, _)| group[usize::from(system.automata[a].task)]);
            members[control] && resting.all(|group_of| group_of != group[control])
        };
        LazyMembers {
            starts: (0..system.tasks.len())
                .map(|task| {
                    !system.clients.is_empty() && starts_no_timer(system, task) && can_start(task)
                })
                .collect(),
            members,
            group,
            rest,
        }
    }

    /// Returns the members whose ends can be postponed in a calm state, if there are any.
    pub(crate) fn waiters(&self, rules: &Rules, s: &State) -> Option<Deferrable> {
        let l = &rules.layout;
        let settled = rules.system.tasks.iter().zip(&self.members).enumerate().all(
            |(task, (entry, &lazy))| {
                let normal = |a| match l.mode(s, l.number_of(a)) {
                    permanent::NORMAL | permanent::ENDED => true,
                    permanent::FIRST_CODEL | permanent::FIRST_TURN => self.starts[task],
                    _ => false,
                };
                !lazy || (!l.pending(s, task) && entry.permanent.is_none_or(normal))
            },
        );
        if !settled {
            return None;
        }
        let mut out: SmallVec<[bool; 24]> = SmallVec::from_slice(&self.members);
        for &(a, state) in &self.rest {
            let number = l.number_of(a);
            let resting =
                l.phase(s, number) == phase::EXECUTING && l.at(s, number) as usize == state;
            if !resting {
                let group = self.group[usize::from(rules.system.automata[a].task)];
                for (member, slice) in out.iter_mut().enumerate() {
                    *slice &= self.group[member] != group;
                }
            }
        }
        let queue = l.core_queue(s);
        let all = queue.iter().all(|&task| out[task as usize]);
        all.then_some(Deferrable { members: out, automata: true })
    }
}

/// Returns true if no timer starts when a periodic task has been started.
fn starts_no_timer(system: &TimedSystem, task: usize) -> bool {
    let definition = &system.tasks[TaskId::from(task)];
    let mut later = (system.components[definition.component].tasks.iter())
        .skip_while(|&&index| index != TaskId::from(task));
    later.next();
    definition.period.is_some()
        && later.all(|&task| {
            system.tasks[task].period.is_none() && system.tasks[task].permanent.is_none()
        })
}

/// Returns true for an aperiodic task whose cycle never ends.
fn endless(system: &TimedSystem, task: usize, requested: &TiSlice<ServiceId, bool>) -> bool {
    let definition = &system.tasks[TaskId::from(task)];
    definition.period.is_none()
        && !system.has_activities(TaskId::from(task), requested)
        && definition.permanent.is_some_and(|a| system.machine_of(a).is_endless())
}
