//! The variables of components and tasks, and the updates and conditions made of them.

use dotgen_timing::system::TaskId;

use crate::model::{Guard, Term, Update, all, any, var};

use super::layout::{Part, TaskPart, position, status};

impl Part {
    pub(super) fn task(&self, id: TaskId) -> &TaskPart {
        // Tasks of a component are consecutive.
        &self.tasks[usize::from(id) - self.tasks.first().map_or(0, |task| usize::from(task.id))]
    }

    /// Returns an element of an array of places.
    fn place(&self, array: &str, index: impl Into<Term>) -> Term {
        Term::element(&format!("{array}_{}", self.name), index)
    }

    pub(super) fn status(&self, index: impl Into<Term>) -> Term {
        self.place("status", index)
    }

    pub(super) fn kind(&self, index: impl Into<Term>) -> Term {
        self.place("kind", index)
    }

    pub(super) fn state(&self, index: impl Into<Term>) -> Term {
        self.place("state", index)
    }

    pub(super) fn paused(&self, index: impl Into<Term>) -> Term {
        self.place("paused", index)
    }

    pub(super) fn success(&self, index: impl Into<Term>) -> Term {
        self.place("success", index)
    }

    pub(super) fn permanent(&self, index: impl Into<Term>) -> Term {
        self.place("permanent", index)
    }

    pub(super) fn released(&self, index: impl Into<Term>) -> Term {
        self.place("released", index)
    }

    pub(super) fn interrupted(&self, index: impl Into<Term>) -> Term {
        self.place("interrupted", index)
    }

    pub(super) fn lock_queue(&self, index: impl Into<Term>) -> Term {
        self.place("queue", index)
    }

    pub(super) fn own(&self, variable: &str) -> Term {
        var(&format!("{variable}_{}", self.name))
    }

    pub(super) fn step(&self) -> Term {
        self.own("control")
    }

    pub(super) fn clock(&self) -> String {
        format!("x_{}", self.name)
    }

    pub(super) fn has_control_codels(&self) -> bool {
        self.services.iter().any(|(_, codels)| !codels.is_empty())
    }

    /// Returns true if the start of the component takes several steps that the network must count.
    pub(super) fn starts(&self) -> bool {
        self.tasks.len() + usize::from(self.control) > 1
    }

    /// Returns true if the network knows when the component has started.
    pub(super) fn notes_start(&self) -> bool {
        self.control || self.tasks.is_empty() || self.starts()
    }

    /// Returns the updates that clear the marks of a place.
    pub(super) fn clear(&self, index: &Term) -> Vec<Update> {
        let mut out = vec![self.paused(index.clone()).set(0_usize)];
        out.push(self.success(index.clone()).set(0_usize));
        if self.activities {
            out.push(self.released(index.clone()).set(0_usize));
            out.push(self.interrupted(index.clone()).set(0_usize));
        }
        out
    }

    /// Returns the updates that append an executor to the lock queue.
    pub(super) fn push(&self, executor: usize) -> Vec<Update> {
        if !self.queue {
            return Vec::new();
        }
        let length = self.own("queued");
        vec![self.lock_queue(length.clone()).set(executor), length.clone().set(length.plus(1))]
    }

    /// Returns the updates that remove the first executor of the lock queue.
    pub(super) fn pop(&self) -> Vec<Update> {
        if !self.queue {
            return Vec::new();
        }
        let length = self.own("queued");
        let shift = |index: usize| self.lock_queue(index).set(self.lock_queue(index + 1));
        let mut out: Vec<Update> = (0..=self.tasks.len()).map(shift).collect();
        out.push(length.clone().set(length.plus(-1)));
        out
    }

    /// Returns the updates that make aperiodic tasks runnable, except one.
    pub(super) fn wake(&self, except: Option<TaskId>) -> Vec<Update> {
        let woken = self.tasks.iter().filter(|task| task.period.is_none());
        let woken = woken.filter(|task| Some(task.id) != except);
        woken.map(|task| task.due().set(1_usize)).collect()
    }
}

impl TaskPart {
    fn own(&self, variable: &str) -> Term {
        var(&format!("{variable}_{}", self.name))
    }

    pub(super) fn position(&self) -> Term {
        self.own("position")
    }

    /// Returns the flag that begins a cycle.
    pub(super) fn due(&self) -> Term {
        self.own("due")
    }

    pub(super) fn first(&self) -> Term {
        self.own("first")
    }

    pub(super) fn flag(&self, name: &str) -> Term {
        self.own(name)
    }

    pub(super) fn clock(&self) -> String {
        format!("x_{}", self.name)
    }

    pub(super) fn timer(&self) -> String {
        format!("t_{}", self.name)
    }

    /// Returns the number in the lock queue.
    pub(super) fn executor(&self) -> usize {
        self.index + 1
    }

    /// Returns the condition that the task has made the wake-ups that follow its last pass.
    pub(super) fn is_awake(&self) -> Guard {
        if self.wakes { self.flag("wakes").is(0_usize) } else { Guard::always() }
    }

    /// Returns the condition under which the task can begin a cycle.
    pub(super) fn begins(&self) -> Guard {
        all([self.position().is(position::IDLE), self.due().is(1_usize), self.is_awake()])
    }

    /// Returns the condition under which a cycle needs a core: something could run.
    pub(super) fn could_run(&self, part: &Part) -> Guard {
        let place = |index: usize| {
            let status = |value: usize| part.status(index).is(value);
            let mut some = vec![status(status::RUNS), status(status::STOPS)];
            some.push(if part.activities {
                let marks = [part.released(index).is(1_usize), part.interrupted(index).is(1_usize)];
                all([status(status::ACCEPTED), any(marks)])
            } else {
                status(status::ACCEPTED)
            });
            any(some)
        };
        any((self.base..self.base + self.count).map(place))
    }
}
