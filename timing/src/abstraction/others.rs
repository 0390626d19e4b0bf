//! Threads outside the abstraction that take tickets: control tasks, tasks without a period, and tasks that
//! cannot be followed.
//!
//! The times of their tickets are left open. Each of these threads has at most one ticket at a time. So when
//! a codel takes a ticket, at most one codel of each thread is before it: executing, or ahead in the queue.

use typed_index_collections::{TiSlice, TiVec, ti_vec};

use crate::system::{CodelId, CodelSet, ComponentId, FOREVER, TaskId, TimedSystem};

/// The codels of a control task, or of a task that is not followed.
#[derive(Debug, Clone)]
pub(super) struct OtherThread {
    pub(super) component: ComponentId,
    pub(super) codels: CodelSet,
}

impl OtherThread {
    /// Returns true if one of its codels waits for one of `codels`, or the other way round.
    pub(super) fn meets(&self, system: &TimedSystem, codels: &CodelSet) -> bool {
        waits(system, &self.codels, codels) || waits(system, codels, &self.codels)
    }
}

/// Returns true if some codel of `first` waits for some codel of `second`.
pub(super) fn waits(system: &TimedSystem, first: &CodelSet, second: &CodelSet) -> bool {
    let mut first = first.iter();
    first.any(|codel_set| system.codels[codel_set].conflicts.intersects(second))
}

/// Returns all of these threads. `codels` are the codels that each task may execute, and `followed` the tasks
/// that are followed.
pub(super) fn others(
    system: &TimedSystem,
    codels: &TiSlice<TaskId, CodelSet>,
    followed: impl Fn(TaskId) -> bool,
) -> Vec<OtherThread> {
    let requested = system.requested();
    let mut out: Vec<OtherThread> = Vec::new();
    for (component, entry) in system.components.iter_enumerated() {
        let mut handled = CodelSet::default();
        for &service in entry.services.iter().filter(|service| requested[**service]) {
            let service = &system.services[service];
            let own = service.validate.iter().chain(&service.simple);
            own.for_each(|&validate| handled.insert(validate));
        }
        let tasks = entry.tasks.iter().filter(|task| !followed(**task));
        let all = tasks.map(|&task| codels[task].clone()).chain([handled]);
        let all = all.filter(|codel| !codel.is_empty());
        out.extend(all.map(|codels| OtherThread { component, codels }));
    }
    out
}

/// The interference of other threads with the tasks of a group.
#[derive(Debug, Clone, Default)]
pub(super) struct Interference {
    /// Codels for which a codel of another thread, at the head of the queue, may wait.
    pub(super) waits_for: CodelSet,
    /// Longest wait of each codel for other threads, after all other codels before it have begun or ended;
    /// `None`: for ever.
    pub(super) longest: TiVec<CodelId, Option<i64>>,
}

/// Returns the interference of other threads of a component with its tasks; `None` if there are none.
pub(super) fn interference(system: &TimedSystem, others: &[OtherThread]) -> Option<Interference> {
    if others.is_empty() {
        return None;
    }
    let mut out = Interference {
        waits_for: CodelSet::default(),
        longest: ti_vec![Some(0); system.codels.len()],
    };
    for thread in others {
        for codel in thread.codels.iter() {
            let conflicts = system.codels[codel].conflicts.iter();
            conflicts.for_each(|conflict| out.waits_for.insert(conflict));
        }
    }
    for (number, thread) in others.iter().enumerate() {
        let awaited = |codel: CodelId| {
            let mut rest = others.iter().enumerate().filter(|(other, _)| *other != number);
            let mut one = CodelSet::default();
            one.insert(codel);
            rest.any(|(_, other)| waits(system, &other.codels, &one))
        };
        let own: Vec<(CodelId, bool)> =
            thread.codels.iter().map(|codel| (codel, awaited(codel))).collect();
        for (codel, longest) in out.longest.iter_mut_enumerated() {
            let conflicts = &system.codels[codel].conflicts;
            let waits =
                own.iter().filter(|(index, awaited)| *awaited || conflicts.contains(*index));
            let longest_of_it = waits.map(|wait| system.codels[wait.0].upper).max().unwrap_or(0);
            *longest = longest
                .filter(|_| longest_of_it != FOREVER)
                .map(|number| number + i64::from(longest_of_it));
        }
    }
    Some(out)
}
