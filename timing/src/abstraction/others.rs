//! Threads outside the abstraction that take tickets: control tasks, tasks without a period, and tasks that
//! cannot be followed.
//!
//! The times of their tickets are left open. Each of these threads has at most one ticket at a time. So when
//! a codel takes a ticket, at most one codel of each thread is before it: executing, or ahead in the queue.

use crate::system::{CodelSet, FOREVER, TimedSystem};

/// The codels of a control task, or of a task that is not followed.
#[derive(Debug, Clone)]
pub(super) struct OtherThread {
    pub(super) component: usize,
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
    first.any(|it| system.codels[it].conflicts.intersects(second))
}

/// Returns all of these threads. `codels` are the codels that each task may execute, and `followed` the tasks
/// that are followed.
pub(super) fn others(
    system: &TimedSystem,
    codels: &[CodelSet],
    followed: impl Fn(usize) -> bool,
) -> Vec<OtherThread> {
    let requested = system.requested();
    let mut out: Vec<OtherThread> = Vec::new();
    for (component, it) in system.components.iter().enumerate() {
        let mut handled = CodelSet::default();
        for &service in it.services.iter().filter(|it| requested[**it]) {
            let service = &system.services[service];
            let own = service.validate.iter().chain(&service.simple);
            own.for_each(|&it| handled.insert(it));
        }
        let tasks = it.tasks.iter().filter(|it| !followed(**it));
        let all = tasks.map(|&it| codels[it].clone()).chain([handled]);
        let all = all.filter(|it| !it.is_empty());
        out.extend(all.map(|codels| OtherThread { component, codels }));
    }
    out
}

/// The interference of other threads with the tasks of a group.
#[derive(Debug, Default)]
pub(super) struct Interference {
    /// Codels for which a codel of another thread, at the head of the queue, may wait.
    pub(super) waits_for: CodelSet,
    /// Longest wait of each codel for other threads, after all other codels before it have begun or ended;
    /// `None`: for ever.
    pub(super) longest: Vec<Option<i64>>,
}

/// Returns the interference of other threads of a component with its tasks; `None` if there are none.
pub(super) fn interference(system: &TimedSystem, others: &[OtherThread]) -> Option<Interference> {
    if others.is_empty() {
        return None;
    }
    let mut out = Interference {
        waits_for: CodelSet::default(),
        longest: vec![Some(0); system.codels.len()],
    };
    for it in others {
        for codel in it.codels.iter() {
            let conflicts = system.codels[codel].conflicts.iter();
            conflicts.for_each(|it| out.waits_for.insert(it));
        }
    }
    for (number, it) in others.iter().enumerate() {
        let awaited = |codel: usize| {
            let mut rest = others.iter().enumerate().filter(|it| it.0 != number);
            let mut one = CodelSet::default();
            one.insert(codel);
            rest.any(|(_, other)| waits(system, &other.codels, &one))
        };
        let own: Vec<(usize, bool)> = it.codels.iter().map(|it| (it, awaited(it))).collect();
        for (codel, longest) in out.longest.iter_mut().enumerate() {
            let conflicts = &system.codels[codel].conflicts;
            let waits = own
                .iter()
                .filter(|(it, awaited)| *awaited || conflicts.contains(*it));
            let longest_of_it = waits.map(|it| system.codels[it.0].upper).max().unwrap_or(0);
            *longest = longest
                .filter(|_| longest_of_it != FOREVER)
                .map(|it| it + i64::from(longest_of_it));
        }
    }
    Some(out)
}
