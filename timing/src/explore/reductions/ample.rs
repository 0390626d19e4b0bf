//! Ample sets: the partial-order reduction within one moment.
//!
//! Where actions commute, following them in one order is enough. A set of actions of a state is *ample* if
//! (1) every action that can happen before one of them, at this moment, commutes with all of them and leaves
//! them possible; (2) one of them has to happen at this moment; (3) none of them changes anything observed;
//! (4) they cannot happen for ever without time passing. Then only the ample set is followed. (These are the
//! conditions of persistent and ample sets: D. Peled, *Combining partial order reductions with on-the-fly
//! model-checking*, CAV 1994.) As time waits for urgent actions, "at this moment" ends any path to be
//! considered.
//!
//! There are four kinds of ample sets. All concern *plain* tasks: tasks past their start-up, without
//! activities, kept ticks or separate threads, so that neither control tasks nor clients interact with them.
//!
//! * **A tick** of an idle task, if the task gets a core whatever happens before: there is no limit on cores,
//!   or there are more free cores than tasks that can ask at this moment.
//! * **All ticks** that are due, under FIFO, if no other task can ask for a core at this moment. The order of
//!   ticks matters, so all of them are in the set. Giving a core back commutes with a tick: the queue is the
//!   same, and its head is granted, whichever comes first. A task that has nothing to do delays no other
//!   task, so it is enough that its own tick comes last, which makes it wait longest. (Unless its response
//!   time is measured: after a miss the next job would be measured from a later moment.)
//! * **The end** of a codel whose window is over. It only releases locks, which no other executor can do, and
//!   begins to wait for the next ones. If it can end the cycle, no tick of the same task may be due, because
//!   their order matters for `schedulable`. If another task can be waiting for the core then, this needs FIFO
//!   for the same reason as ticks; and all tasks that can be waiting must be plain and not have their own
//!   tick due, as a job with nothing to do ends in the step that grants its core.
//! * **Acquisitions** of codels that exclude each other, if no other executor can want any of their locks at
//!   this moment.
//!
//! With locks in order of arrival there are no ample sets, because every request for a lock counts. With
//! passes there are none inside a component, see [`super::components`].

use super::facts::{Facts, Owner};
use super::{Kind, Reason, Reduction, Setting};
use crate::explore::rules::layout::Layout;
use crate::explore::rules::points::Cycle;
use crate::explore::rules::status::permanent;
use crate::explore::rules::{Action, Enabled, Rules};
use crate::explore::state::{State, TaskStatus, phase};
use crate::scn::semantics::LockRule;
use crate::system::{CodelId, Policy, TaskId, TimedSystem, Yield};

/// The ample sets of systems with jobs.
#[derive(Debug)]
pub(crate) struct Ample;

impl Reduction for Ample {
    const KIND: Kind = Kind::PersistentSets;

    fn applies(setting: &Setting) -> Result<Self, Reason> {
        if setting.rules.points.cycle == Cycle::Passes {
            return Err(Reason::OneQueue);
        }
        if setting.system().platform.semantics.locks != LockRule::Free {
            return Err(Reason::LocksInOrder);
        }
        Ok(Ample)
    }
}

impl Ample {
    /// Writes an ample set of a state to `out`, or all enabled actions.
    pub(crate) fn select(
        (rules, facts): (&Rules, &Facts),
        s: &State,
        enabled: &Enabled,
        out: &mut Vec<Action>,
    ) {
        out.clear();
        if !enabled.committed && enabled.actions.len() > 1 {
            let moment = AmpleState { facts, rules, s, enabled };
            if moment.select(out) {
                return;
            }
            out.clear();
        }
        out.extend(&enabled.actions);
    }
}

/// One state, with the actions that can happen in it before time passes.
struct AmpleState<'m, 's> {
    facts: &'m Facts,
    rules: &'m Rules<'s>,
    s: &'m State,
    enabled: &'m Enabled,
}

impl AmpleState<'_, '_> {
    fn select(&self, out: &mut Vec<Action>) -> bool {
        let actions = &self.enabled.actions;
        for &action in actions {
            match action {
                Action::Tick { task } if self.tick_alone(task) => {
                    out.push(action);
                    return true;
                }
                Action::Finish { executor, .. } if self.end_alone(executor) => {
                    self.with_outcomes(executor, out);
                    return true;
                }
                _ => {}
            }
        }
        for &action in actions {
            if let Action::Acquire { executor } = action
                && self.acquisitions(executor, out)
            {
                return true;
            }
        }
        out.clear();
        self.all_ticks(out)
    }

    fn layout(&self) -> &Layout {
        &self.rules.layout
    }

    fn system(&self) -> &TimedSystem {
        self.rules.system
    }

    /// Returns true if the timer of a task has expired.
    fn due(&self, task: usize) -> bool {
        let definition = &self.system().tasks[TaskId::from(task)];
        definition.period.is_some()
            && self.layout().started(self.s, task)
            && self.layout().timer(self.s, task) == 0
    }

    /// Returns true if the start-up of a task is over.
    fn started_up(&self, task: usize) -> bool {
        let l = self.layout();
        let permanent = self.system().tasks[TaskId::from(task)].permanent;
        l.started(self.s, task)
            && permanent.is_none_or(|a| {
                matches!(l.mode(self.s, l.number_of(a)), permanent::NORMAL | permanent::ENDED)
            })
    }

    /// Returns true for a plain task past its start-up.
    fn settled(&self, task: usize) -> bool {
        self.facts.plain[task] && self.started_up(task)
    }

    /// Returns true for a settled task that takes its tick as soon as it comes.
    fn ready(&self, task: usize) -> bool {
        self.settled(task)
            && !self.facts.visible.tasks[task]
            && self.layout().status(self.s, task) == TaskStatus::Idle
            && !self.layout().pending(self.s, task)
    }

    /// Returns true if a task that is not due can ask for a core at this moment.
    fn may_ask(&self, task: usize) -> bool {
        let l = self.layout();
        if !self.system().needs_core(TaskId::from(task)) || self.due(task) {
            return false;
        }
        let status = l.status(self.s, task);
        if self.system().tasks[TaskId::from(task)].period.is_some() {
            return l.pending(self.s, task);
        }
        if status != TaskStatus::Idle {
            return !self.facts.endless[task];
        }
        let definition = &self.system().tasks[TaskId::from(task)];
        self.facts.active[task]
            || definition
                .permanent
                .is_some_and(|a| l.mode(self.s, l.number_of(a)) != permanent::ENDED)
    }

    /// Returns true if no task has to wait for a core at this moment, whatever happens.
    fn cores_for_all(&self) -> bool {
        let Some(cores) = self.system().platform.cores else {
            return true;
        };
        let l = self.layout();
        if !l.core_queue(self.s).is_empty() {
            return false;
        }
        let tasks = 0..self.system().tasks.len();
        let wanted = tasks.filter(|&t| {
            self.system().needs_core(TaskId::from(t))
                && (l.status(self.s, t) != TaskStatus::Idle || self.due(t) || self.may_ask(t))
        });
        wanted.count() <= cores as usize
    }

    fn tick_alone(&self, task: usize) -> bool {
        self.ready(task) && self.cores_for_all()
    }

    fn all_ticks(&self, out: &mut Vec<Action>) -> bool {
        if self.system().platform.policy != Policy::Fifo {
            return false;
        }
        let mut tasks = 0..self.system().tasks.len();
        if tasks.any(|t| if self.due(t) { !self.ready(t) } else { self.may_ask(t) }) {
            return false;
        }
        let ticks = self.enabled.actions.iter();
        out.extend(ticks.filter(|tick| matches!(tick, Action::Tick { .. })));
        let last = |action: &Action| matches!(*action, Action::Tick { task } if self.has_nothing_to_do(task));
        if !out.iter().all(last) {
            out.retain(|action| !last(action));
        }
        !out.is_empty()
    }

    /// Returns true if the jobs of a plain task end as soon as they get a core, and their response time is
    /// not measured.
    fn has_nothing_to_do(&self, task: usize) -> bool {
        let l = self.layout();
        let permanent = self.system().tasks[TaskId::from(task)].permanent;
        !self.facts.measured[task]
            && permanent.is_none_or(|a| l.mode(self.s, l.number_of(a)) == permanent::ENDED)
    }

    fn end_alone(&self, executor: usize) -> bool {
        let l = self.layout();
        let id = l.automaton_numbered(executor);
        let Some(automaton) = self.system().automata.get(id) else {
            return false;
        };
        let task = automaton.task;
        if l.window(self.s, executor).1 > 0
            || automaton.service.is_some()
            || !self.settled(usize::from(task))
            || self.facts.visible.tasks[usize::from(task)]
            || l.mode(self.s, executor) != permanent::NORMAL
        {
            return false;
        }
        let state = &self.system().machine_of(id).states[l.at(self.s, executor) as usize];
        if state.yields.iter().all(|transition| matches!(transition, Yield::Next(_))) {
            return true;
        }
        self.system().tasks[task].period.is_some()
            && !self.due(usize::from(task))
            && !l.pending(self.s, usize::from(task))
            && (self.cores_for_all() || self.hand_over_commutes())
    }

    /// Returns true if a core released now could as well be released later at this moment. The next task to
    /// get the core may end in the same step: its activities must not change meanwhile, nor its tick come.
    fn hand_over_commutes(&self) -> bool {
        let l = self.layout();
        self.system().platform.policy == Policy::Fifo
            && !self.facts.visible_on_cores
            && (0..self.system().tasks.len()).all(|t| {
                let waits = l.status(self.s, t) == TaskStatus::Waiting;
                !self.system().needs_core(TaskId::from(t))
                    || !(waits || self.due(t) || self.may_ask(t))
                    || (self.settled(t) && !(waits && self.due(t)))
            })
    }

    /// Writes the acquisitions of `first` and of all executors that compete with it.
    fn acquisitions(&self, first: usize, out: &mut Vec<Action>) -> bool {
        out.clear();
        let mut members = vec![first];
        let mut at = 0;
        while let Some(&executor) = members.get(at) {
            at += 1;
            if !self.may_acquire_alone(executor) {
                return false;
            }
            let Some(codel) = self.rules.codel(self.s, executor) else {
                return false;
            };
            for other in self.system().codels[codel].conflicts.iter() {
                let rival = match self.facts.owner[other] {
                    Owner::Nobody => continue,
                    Owner::Control => return false,
                    Owner::Task(rival) => rival,
                };
                if members.iter().any(|&member| self.runs(member, rival)) {
                    continue;
                }
                match self.rivalry(rival, codel) {
                    Rivalry::None => {}
                    Rivalry::Now(executor) => members.push(executor),
                    Rivalry::Later => return false,
                }
            }
            out.push(Action::Acquire { executor });
        }
        true
    }

    fn runs(&self, executor: usize, task: usize) -> bool {
        let automaton = self.layout().automaton_numbered(executor);
        let automaton = self.system().automata.get(automaton);
        automaton.is_some_and(|automaton| automaton.task == TaskId::from(task))
    }

    /// Returns true if an acquisition by this executor changes nothing that is observed, and cannot be
    /// repeated for ever in no time.
    fn may_acquire_alone(&self, executor: usize) -> bool {
        let automaton = self.layout().automaton_numbered(executor);
        match self.system().automata.get(automaton) {
            Some(automaton) if automaton.service.is_none() => {
                self.settled(usize::from(automaton.task))
                    && !self.facts.visible.tasks[usize::from(automaton.task)]
            }
            _ => false,
        }
    }

    /// Writes an end with all its outcomes.
    fn with_outcomes(&self, end: usize, out: &mut Vec<Action>) {
        out.extend(
            self.enabled.actions.iter().filter(
                |other| matches!(**other, Action::Finish { executor, .. } if executor == end),
            ),
        );
    }

    /// Returns true if a task with activities may want a lock of a codel at this moment.
    fn task_may_want(&self, task: usize, codel: CodelId) -> bool {
        let l = self.layout();
        let system = self.system();
        let definition = &system.tasks[TaskId::from(task)];
        let automata = || definition.permanent.iter().chain(&definition.slots).copied();
        let separate = system.platform.async_free
            && automata().any(|a| system.machine_of(a).states.iter().any(|state| state.is_async));
        let settled = self.started_up(task);
        // While a task executes a codel that does not end yet, no other action of the task is possible.
        let executes = (l.turn(self.s, task))
            .is_some_and(|a| l.phase(self.s, a) == phase::EXECUTING && l.window(self.s, a).0 > 0);
        let rests = l.status(self.s, task) == TaskStatus::Idle
            && definition.period.is_some()
            && !self.due(task)
            && !l.pending(self.s, task);
        if !separate && settled && (executes || rests) {
            return false;
        }
        let conflicts = &system.codels[codel].conflicts;
        automata().any(|a| {
            let mut states = system.machine_of(a).states.iter();
            states.any(|state| conflicts.contains(state.codel))
        })
    }

    /// Returns how a task can want a lock of `codel` at this moment.
    fn rivalry(&self, task: usize, codel: CodelId) -> Rivalry {
        let l = self.layout();
        if !self.facts.plain[task] && !self.task_may_want(task, codel) {
            return Rivalry::None;
        }
        if !self.settled(task) || self.due(task) || l.pending(self.s, task) {
            return Rivalry::Later;
        }
        let Some(automaton) = self.system().tasks[TaskId::from(task)].permanent else {
            return Rivalry::None;
        };
        let a = l.number_of(automaton);
        let periodic = self.system().tasks[TaskId::from(task)].period.is_some();
        match l.status(self.s, task) {
            TaskStatus::Idle if periodic || l.mode(self.s, a) == permanent::ENDED => Rivalry::None,
            TaskStatus::Running if periodic || self.facts.endless[task] => {
                let conflicts = &self.system().codels[codel].conflicts;
                let state = l.at(self.s, a) as usize;
                let later = self.facts.later[automaton][state]
                    .iter()
                    .any(|codel| conflicts.contains(codel));
                match l.phase(self.s, a) {
                    phase::EXECUTING if !later || l.window(self.s, a).0 > 0 => Rivalry::None,
                    phase::LOCKING => {
                        let here = self.rules.codel(self.s, a);
                        let now = self.enabled.actions.contains(&Action::Acquire { executor: a });
                        if here.is_some_and(|codel| conflicts.contains(codel)) {
                            // Later actions belong to states after the set.
                            if now { Rivalry::Now(a) } else { Rivalry::Later }
                        } else if later {
                            Rivalry::Later
                        } else {
                            Rivalry::None
                        }
                    }
                    _ => Rivalry::Later,
                }
            }
            _ => Rivalry::Later,
        }
    }
}

enum Rivalry {
    /// The task cannot want it.
    None,
    /// This executor of the task can take one now.
    Now(usize),
    /// The task may want it after another action.
    Later,
}
