//! Goals: properties of single states, one list for all that a watch asks for.

use crate::system::TaskId;
use std::ops::{Index, IndexMut};

use crate::explore::watch::Watch;
use crate::property::Predicate;

/// A property of a state, or of the step to it.
#[derive(Debug, Clone, Copy)]
pub(super) enum Goal<'w> {
    /// A tick of the task comes before its job has ended.
    Missed(usize),
    /// The task waits for a core for at least its period.
    Overdue(usize),
    /// The predicate holds.
    Reached(&'w Predicate),
}

/// The index of a goal in the list of its watch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct GoalId(usize);

/// All goals of a watch: missed deadlines, overdue tasks, reached predicates.
#[derive(Debug)]
pub(super) struct Goals<'w> {
    watch: &'w Watch,
}

/// One value for each goal of a list.
#[derive(Debug, Clone, Default)]
pub(super) struct PerGoal<T>(Vec<T>);

impl<'w> Goals<'w> {
    pub(super) fn of(watch: &'w Watch) -> Goals<'w> {
        Goals { watch }
    }

    /// Returns the number of goals of each kind, in the order of the list.
    fn counts(&self) -> [usize; 3] {
        let Watch { schedulable, overdue, reach, .. } = self.watch;
        [schedulable.len(), overdue.len(), reach.len()]
    }

    /// Returns all goals, in order.
    pub(super) fn ids(&self) -> impl Iterator<Item = GoalId> + use<> {
        (0..self.counts().iter().sum()).map(GoalId)
    }

    /// Returns the goals for missed deadlines, with their tasks.
    pub(super) fn missed(&self) -> impl Iterator<Item = (GoalId, usize)> + use<'w> {
        let tasks = self.watch.schedulable.iter().enumerate();
        tasks.map(|(i, &task)| (GoalId(i), usize::from(task)))
    }

    /// Returns the goals for overdue tasks, with the tasks.
    pub(super) fn overdue(&self) -> impl Iterator<Item = (GoalId, usize)> + use<'w> {
        let first = self.counts()[0];
        let tasks = self.watch.overdue.iter().enumerate();
        tasks.map(move |(i, &task)| (GoalId(first + i), usize::from(task)))
    }

    pub(super) fn reached(&self) -> impl Iterator<Item = (GoalId, &'w Predicate)> + use<'w> {
        let first = self.counts()[0] + self.counts()[1];
        let predicates = self.watch.reach.iter().enumerate();
        predicates.map(move |(i, predicate)| (GoalId(first + i), predicate))
    }

    /// Returns the goal with an index.
    pub(super) fn get(&self, GoalId(id): GoalId) -> Goal<'w> {
        let [missed, overdue, _] = self.counts();
        if id < missed {
            Goal::Missed(usize::from(self.watch.schedulable[id]))
        } else if id < missed + overdue {
            Goal::Overdue(usize::from(self.watch.overdue[id - missed]))
        } else {
            Goal::Reached(&self.watch.reach[id - missed - overdue])
        }
    }

    pub(super) fn each<T>(&self, of: impl FnMut(GoalId) -> T) -> PerGoal<T> {
        PerGoal(self.ids().map(of).collect())
    }

    /// Returns a watch for some of the goals, which must be in order. Their indices there are their positions
    /// in `some`.
    pub(super) fn only(&self, some: &[GoalId]) -> Watch {
        let Watch { stop_at_first, ref monitors, .. } = *self.watch;
        let mut watch = Watch { stop_at_first, monitors: monitors.clone(), ..Watch::default() };
        for &id in some {
            match self.get(id) {
                Goal::Missed(task) => watch.schedulable.push(TaskId::from(task)),
                Goal::Overdue(task) => watch.overdue.push(TaskId::from(task)),
                Goal::Reached(predicate) => watch.reach.push(predicate.clone()),
            }
        }
        watch
    }

    /// Splits a list into the parts for the lists of the watch: missed, overdue, reached.
    pub(super) fn split<T>(&self, PerGoal(mut all): PerGoal<T>) -> [Vec<T>; 3] {
        let [missed, overdue, _] = self.counts();
        let reached = all.split_off(missed + overdue);
        let overdue = all.split_off(missed);
        [all, overdue, reached]
    }
}

impl<T> PerGoal<T> {
    /// Returns the values, in the order of the goals.
    pub(super) fn values(&self) -> impl Iterator<Item = &T> {
        self.0.iter()
    }

    /// Returns the values for changes, in the order of the goals.
    pub(super) fn values_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.0.iter_mut()
    }

    /// Converts each value.
    pub(super) fn map<U>(self, function: impl FnMut(T) -> U) -> PerGoal<U> {
        PerGoal(self.0.into_iter().map(function).collect())
    }

    /// Returns the values, in the order of the goals.
    pub(super) fn into_values(self) -> impl Iterator<Item = T> {
        self.0.into_iter()
    }
}

impl<T> Index<GoalId> for PerGoal<T> {
    type Output = T;

    fn index(&self, GoalId(id): GoalId) -> &T {
        &self.0[id]
    }
}

impl<T> IndexMut<GoalId> for PerGoal<T> {
    fn index_mut(&mut self, GoalId(id): GoalId) -> &mut T {
        &mut self.0[id]
    }
}
