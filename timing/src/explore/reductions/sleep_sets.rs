//! Sleep sets: the partial-order reduction for ends while locks and cores are due.
//!
//! An action that is *due* at a moment (a lock that can be taken, a tick, the end of a window) happens before
//! time passes. A codel that may end, but need not yet, can as well end when no action is due any more. The
//! exception is an end that makes a difference to a due action: another executor takes the lock first, or the
//! job ends before its next tick. So in a state with due actions, ends that are not due are followed only in
//! order that **all** due actions are *overtaken*; until then the due actions are *held back*. If some due
//! action cannot be overtaken at this moment, ends that are not due are not followed at all.
//!
//! Proof sketch. Take the steps of one moment that lead to a calm state, as a partial order of dependent
//! steps, and the smallest initial part of it that leads to a calm state; the rest can follow from there.
//! Perform the due steps of that part first, as long as there are any. When only ends that are not due are
//! left, some other step is due (else the part would not be the smallest), and no due step can come before a
//! step it depends on. The rule follows exactly these steps. (Held-back steps are sleep sets: P. Godefroid,
//! *Partial-Order Methods for the Verification of Concurrent Systems*, 1996.)
//!
//! The dependencies among *plain* tasks are as follows (see [`super::facts`]; the rule is not used if there
//! are other tasks, or predicates):
//!
//! * taking locks depends on taking others that exclude these;
//! * a tick depends on the end of the current job, or of the start-up, of its task. With fewer cores than
//!   tasks it also depends on every task that can join the queue, also by a tick that must come after the
//!   task's own start-up. Except under FIFO it also depends on every task that can release a core;
//! * the end of a cycle after which the task joins the queue again depends on other ends of this kind.

use super::facts::Facts;
use super::{Kind, Reason, Reduction, Setting, SleepSet};
use crate::explore::rules::points::Cycle;
use crate::explore::rules::status::permanent;
use crate::explore::rules::{Action, Enabled, Rules};
use crate::explore::state::{State, TaskStatus, phase};
use crate::scn::semantics::LockRule;
use crate::system::{CodelSet, Policy, TaskId, TimedSystem};

const TICKS: usize = 64;

/// Sets of tasks.
type Tasks = u64;

/// A state and its possible actions.
#[derive(Clone, Copy)]
pub(crate) struct Now<'n, 's> {
    pub(crate) rules: &'n Rules<'s>,
    pub(crate) facts: &'n Facts,
    pub(crate) s: &'n State,
    pub(crate) enabled: &'n Enabled,
}

/// Static facts about a system.
#[derive(Debug)]
pub(crate) struct Overtake {
    /// Some tasks may have to wait for a core.
    limited: bool,
    /// By task, all codels of its permanent activity, and of the permanent activities started after it.
    all: Vec<CodelSet>,
    /// By task, all codels of the permanent activities started after it.
    started_after: Vec<CodelSet>,
}

impl Reduction for Overtake {
    const KIND: Kind = Kind::SleepSets;

    fn applies(setting: &Setting) -> Result<Self, Reason> {
        let system = setting.system();
        let tasks = 0..system.tasks.len();
        if setting.rules.points.cycle == Cycle::Passes {
            Err(Reason::OneQueue)
        } else if system.platform.semantics.locks != LockRule::Free {
            Err(Reason::LocksInOrder)
        } else if system.automata.len() > TICKS || tasks.len() > TICKS {
            Err(Reason::TooMany)
        } else if !system.clients.is_empty() {
            Err(Reason::Clients)
        } else if setting.facts.observed() {
            Err(Reason::Predicates)
        } else if !tasks.clone().all(|task| setting.facts.plain(task)) {
            Err(Reason::NotPlain)
        } else {
            Ok(Overtake::new(system))
        }
    }
}

impl Overtake {
    fn new(system: &TimedSystem) -> Self {
        let n = system.tasks.len();
        let own = |task: usize, out: &mut CodelSet| {
            if let Some(a) = system.tasks[TaskId::from(task)].permanent {
                let states = &system.machine_of(a).states;
                for state in states {
                    out.insert(state.codel);
                }
            }
        };
        let mut started_after = vec![CodelSet::default(); n];
        for component in &system.components {
            for (at, &task) in component.tasks.iter().enumerate() {
                for &later in &component.tasks[at + 1..] {
                    own(usize::from(later), &mut started_after[usize::from(task)]);
                }
            }
        }
        let mut all = started_after.clone();
        (0..n).for_each(|task| own(task, &mut all[task]));
        Overtake { limited: system.platform.cores.is_some(), all, started_after }
    }

    /// Writes the actions to follow in a state, each with the actions that it holds back. `first` is an ample
    /// set, or all enabled actions.
    pub(crate) fn select(
        &self,
        now: Now,
        held: SleepSet,
        first: &[Action],
        out: &mut Vec<(Action, SleepSet)>,
    ) {
        out.clear();
        let enabled = now.enabled;
        let moment = DueState { overtake: self, now, held };
        if enabled.committed || enabled.is_calm() {
            out.extend(first.iter().map(|&action| (action, held)));
        } else if moment.may_depend_on_order() {
            out.extend(enabled.actions.iter().map(|&action| (action, 0)));
        } else {
            let whole = first.len() == enabled.actions.len();
            moment.select(first, whole, out);
        }
    }

    /// Returns the actions still held back after an action that led from one state to another.
    pub(crate) fn after(
        &self,
        rules: &Rules,
        before: &State,
        action: Action,
        s: &State,
        held: SleepSet,
    ) -> SleepSet {
        if held == 0 {
            return 0;
        }
        let l = &rules.layout;
        let joined = self.limited && matches!(action, Action::Release { .. });
        let given = self.limited
            && rules.system.platform.policy != Policy::Fifo
            && matches!(action, Action::Grant { .. });
        let mut left = held;
        for bit in bits(held) {
            let stays = match bit.checked_sub(TICKS) {
                Some(task) => {
                    let needs = rules.system.needs_core(TaskId::from(task));
                    let overtaken = contested(rules, before, task) && !contested(rules, s, task);
                    !overtaken && !(needs && (joined || given))
                }
                None => match l.phase(s, bit) {
                    phase::LOCKING => rules.may_leave(s, bit),
                    phase::EXECUTING => l.window(s, bit).1 == 0 && !joined,
                    _ => false,
                },
            };
            if !stays {
                left &= !(1 << bit);
            }
        }
        left
    }
}

/// Returns true if the job or the start-up of a task continues, so that its end and the next tick depend on
/// their order.
fn contested(rules: &Rules, s: &State, task: usize) -> bool {
    rules.layout.status(s, task) != TaskStatus::Idle || !settled(rules, s, task)
}

/// Returns true if the start-up of a task is over.
fn settled(rules: &Rules, s: &State, task: usize) -> bool {
    rules.layout.started(s, task)
        && rules.system.tasks[TaskId::from(task)].permanent.is_none_or(|a| {
            matches!(
                rules.layout.mode(s, rules.layout.number_of(a)),
                permanent::NORMAL | permanent::ENDED
            )
        })
}

fn bits(mut held: SleepSet) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = (held != 0).then(|| held.trailing_zeros() as usize)?;
        held &= held - 1;
        Some(bit)
    })
}

fn members(tasks: Tasks) -> impl Iterator<Item = usize> {
    bits(SleepSet::from(tasks))
}

/// One state in which some action is due.
struct DueState<'m, 's> {
    overtake: &'m Overtake,
    now: Now<'m, 's>,
    held: SleepSet,
}

impl<'m, 's> std::ops::Deref for DueState<'m, 's> {
    type Target = Now<'m, 's>;

    fn deref(&self) -> &Now<'m, 's> {
        &self.now
    }
}

impl DueState<'_, '_> {
    /// Returns true if orders beyond the known dependencies may matter: a job that waits for a core may have
    /// work or not, depending on its start-up.
    fn may_depend_on_order(&self) -> bool {
        (0..self.rules.layout.tasks).any(|task| {
            self.rules.layout.status(self.s, task) == TaskStatus::Waiting
                && !settled(self.rules, self.s, task)
        })
    }

    fn select(&self, first: &[Action], whole: bool, out: &mut Vec<(Action, SleepSet)>) {
        let mut due: SleepSet = 0;
        for &action in &self.enabled.actions {
            due |= self.bit(action);
        }
        // Tasks that can help to overtake a due action; none if some due action cannot be overtaken.
        let mut useful: Tasks = 0;
        let mut all = true;
        if self.held != 0 || whole {
            for bit in bits(due) {
                let by = self.progress(self.rivals(bit));
                if members(by).any(|task| self.can_act(task)) {
                    useful |= by;
                    continue;
                }
                if self.held >> bit & 1 == 1 {
                    return;
                }
                all = false;
            }
        }
        for &action in first {
            let bit = self.bit(action);
            if bit == 0 {
                let Action::Finish { executor, .. } = action else {
                    continue;
                };
                let task =
                    self.rules.system.automata[self.rules.layout.automaton_numbered(executor)].task;
                if all && useful >> usize::from(task) & 1 == 1 {
                    out.push((action, due));
                }
            } else if self.held & bit == 0 {
                out.push((action, self.held));
            }
        }
    }

    /// Returns the bit of a due action, or 0 for an end that is not due.
    fn bit(&self, action: Action) -> SleepSet {
        match action {
            Action::Tick { task } => 1 << (TICKS + task),
            Action::Acquire { executor } => 1 << executor,
            Action::Finish { executor, .. }
                if self.rules.layout.window(self.s, executor).1 == 0 =>
            {
                1 << executor
            }
            _ => 0,
        }
    }

    /// Returns the tasks that can overtake a due action.
    fn rivals(&self, bit: usize) -> Tasks {
        let tasks = 0..self.rules.layout.tasks;
        let set = |contains: &dyn Fn(usize) -> bool| {
            tasks.clone().filter(|&task| contains(task)).fold(0, |set, task| set | 1 << task)
        };
        let system = self.rules.system;
        if let Some(task) = bit.checked_sub(TICKS) {
            let needs = system.needs_core(TaskId::from(task));
            return set(&|q| {
                (q == task && contested(self.rules, self.s, task))
                    || (needs && self.may_join(q))
                    || (needs && system.platform.policy != Policy::Fifo && self.on_core(q))
            });
        }
        let own: usize = system.automata[self.rules.layout.automaton_numbered(bit)].task.into();
        if self.rules.layout.phase(self.s, bit) == phase::EXECUTING {
            let joins = self.may_join(own);
            return set(&|q| joins && q != own && self.may_join(q));
        }
        let codel = self.rules.codel(self.s, bit).expect("it waits for locks");
        let conflicts = &system.codels[codel].conflicts;
        set(&|q| q != own && self.can_come_to(q, conflicts))
    }

    /// Returns true if a task can join the queue at this moment, other than by an independent tick. A tick
    /// during the start-up finds no work; a tick held back until the end of the start-up makes the task join.
    fn may_join(&self, task: usize) -> bool {
        let system = self.rules.system;
        if !system.needs_core(TaskId::from(task)) {
            return false;
        }
        if system.tasks[TaskId::from(task)].period.is_some() {
            let released = self.held != 0 && self.held >> (TICKS + task) & 1 == 0;
            let joins = released || !settled(self.rules, self.s, task);
            return self.rules.layout.pending(self.s, task) || (self.due(task) && joins);
        }
        !settled(self.rules, self.s, task)
            || (self.rules.layout.status(self.s, task) != TaskStatus::Idle
                && !self.facts.endless(task))
    }

    fn on_core(&self, task: usize) -> bool {
        self.rules.layout.status(self.s, task) == TaskStatus::Running
            && self.rules.system.needs_core(TaskId::from(task))
    }

    /// Returns true if a task can want to execute one of these codels at this moment, or wants to now.
    fn can_come_to(&self, task: usize, codels: &CodelSet) -> bool {
        let l = &self.rules.layout;
        let system = self.rules.system;
        let Some(automaton) = system.tasks[TaskId::from(task)].permanent else {
            return false;
        };
        let a = l.number_of(automaton);
        if !settled(self.rules, self.s, task)
            && self.overtake.started_after[task].intersects(codels)
        {
            return true;
        }
        // Another job may begin at this moment.
        let again = system.tasks[TaskId::from(task)].period.is_none() && !self.facts.endless(task);
        if again || l.pending(self.s, task) || self.due(task) {
            return self.overtake.all[task].intersects(codels);
        }
        let at = l.at(self.s, a) as usize;
        let here = codels.contains(system.machine_of(automaton).states[at].codel);
        let later = || self.facts.later(automaton, at).intersects(codels);
        match l.phase(self.s, a) {
            phase::EXECUTING => l.window(self.s, a).0 == 0 && later(),
            phase::LOCKING => here || later(),
            _ => {
                l.status(self.s, task) == TaskStatus::Waiting
                    && l.mode(self.s, a) != permanent::ENDED
                    && (here || later())
            }
        }
    }

    fn due(&self, task: usize) -> bool {
        self.enabled.actions.contains(&Action::Tick { task })
    }

    /// Returns true if an action of a task can happen next.
    fn can_act(&self, task: usize) -> bool {
        let l = &self.rules.layout;
        if self.due(task) && self.held >> (TICKS + task) & 1 == 0 {
            return true;
        }
        let permanent = self.rules.system.tasks[TaskId::from(task)].permanent;
        permanent.map(|automaton| l.number_of(automaton)).is_some_and(|a| {
            match l.phase(self.s, a) {
                phase::EXECUTING => l.window(self.s, a).0 == 0,
                phase::LOCKING => self.held >> a & 1 == 0 && self.rules.may_leave(self.s, a),
                _ => false,
            }
        })
    }

    /// Returns the tasks whose progress can let other tasks, and finally some of `wanted`, proceed.
    fn progress(&self, wanted: Tasks) -> Tasks {
        let l = &self.rules.layout;
        let system = self.rules.system;
        let mut out = wanted;
        let mut todo = wanted;
        while todo != 0 {
            let task = todo.trailing_zeros() as usize;
            todo &= !(1 << task);
            let mut add = |index: usize| {
                if out >> index & 1 == 0 {
                    out |= 1 << index;
                    todo |= 1 << index;
                }
            };
            // Holders of the locks that the task wants or will want.
            for holder in l.executing(self.s) {
                let Some(codel) = self.rules.codel(self.s, holder) else {
                    continue;
                };
                let other = system.automata[l.automaton_numbered(holder)].task;
                if other != TaskId::from(task)
                    && self.can_come_to(task, &system.codels[codel].conflicts)
                {
                    add(usize::from(other));
                }
            }
            let status = l.status(self.s, task);
            let wants_core = system.needs_core(TaskId::from(task))
                && (status == TaskStatus::Waiting
                    || self.due(task)
                    || l.pending(self.s, task)
                    || self.may_join(task));
            if wants_core {
                (0..l.tasks).filter(|&task| self.on_core(task)).for_each(add);
            }
        }
        out
    }
}
