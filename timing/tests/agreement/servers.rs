//! An independent interpreter of the servers (timed semantics, sections 8, 17, 18, 21 and 22), written from
//! that description by the obvious method: states are plain structures, time passes unit by unit, every order
//! of simultaneous atomic steps is followed, and no states are merged. It shares neither the system tables
//! nor the rules of the verifier, and reads specifications and scenarios itself.

pub(crate) mod chains;
mod control;
mod cores;
pub(crate) mod model;
pub(crate) mod patterns;
mod perform;
mod possible;
mod predicates;
pub(crate) mod random;
mod shutdown;
mod state;

use std::collections::HashSet;

pub(crate) use self::predicates::{Predicate, predicate};
pub(crate) use self::state::CAP;

use dotgen_timing::scn::semantics::TickRule;

use self::model::System;
use self::patterns::{Memory, Pattern};
use self::state::{Phase, State};

/// A trigger, and the responses that must follow in order.
pub(crate) type Sequence = (Predicate, Vec<Predicate>);

pub(crate) struct Interpreter<'s> {
    system: &'s System,
    within: &'s [Sequence],
    reach: &'s [Predicate],
    patterns: &'s [Pattern],
    /// Number of cores. `None`: as many as there are tasks that need one.
    cores: Option<usize>,
}

/// All results, tasks by component and task.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Results {
    pub(crate) missed: Vec<Vec<bool>>,
    pub(crate) overdue: Vec<Vec<bool>>,
    /// `Some(CAP)`: unbounded.
    pub(crate) response: Vec<Vec<Option<u32>>>,
    pub(crate) within: Vec<Option<u32>>,
    pub(crate) reached: Vec<bool>,
    /// By pattern.
    pub(crate) violated: Vec<bool>,
    pub(crate) deadlock: bool,
    /// Services with a request that found no slot.
    pub(crate) refused: Vec<Vec<bool>>,
    pub(crate) states: usize,
}

impl Results {
    fn took(&mut self, c: usize, t: usize, time: u32) {
        let response = &mut self.response[c][t];
        *response = (*response).max(Some(time));
    }
}

impl<'s> Interpreter<'s> {
    pub(crate) fn new(system: &'s System, within: &'s [Sequence], reach: &'s [Predicate]) -> Self {
        let tasks = system.components.iter().enumerate();
        let tasks = tasks.flat_map(|(c, task)| (0..task.tasks.len()).map(move |t| (c, t)));
        let needing = tasks.filter(|&(c, t)| system.needs_core(c, t)).count();
        // Under preemption there are never "enough" cores: if a task is bound to one of them, others do not
        // help.
        let limits = |cores: &usize| system.preempts() || *cores < needing;
        Interpreter { system, within, reach, patterns: &[], cores: system.cores.filter(limits) }
    }

    pub(crate) fn with_patterns(self, patterns: &'s [Pattern]) -> Self {
        Interpreter { patterns, ..self }
    }

    fn needs_core(&self, c: usize, t: usize) -> bool {
        self.cores.is_some() && self.system.needs_core(c, t)
    }

    /// Returns true if a task waits for a core before its cycles. A task with a timer of its own needs none
    /// for the first cycle.
    fn asks_for_core(&self, s: &State, c: usize, t: usize) -> bool {
        let first = s.components[c].tasks[t].first != state::First::Over;
        let start_up = first && self.system.semantics.ticks == TickRule::Task;
        self.needs_core(c, t) && !self.preempts() && !start_up
    }

    fn blank(&self) -> Results {
        let all = self.system.components.iter();
        let tasks = all.map(|component| vec![false; component.tasks.len()]);
        let missed: Vec<Vec<bool>> = tasks.collect();
        let all = self.system.components.iter();
        let services = all.map(|component| vec![false; component.services.len()]);
        Results {
            overdue: missed.clone(),
            response: missed.iter().map(|task| vec![None; task.len()]).collect(),
            missed,
            within: vec![None; self.within.len()],
            reached: vec![false; self.reach.len()],
            violated: vec![false; self.patterns.len()],
            refused: services.collect(),
            ..Results::default()
        }
    }

    fn inspect(&self, s: &State, out: &mut Results) {
        for (c, component) in s.components.iter().enumerate() {
            for (t, task) in component.tasks.iter().enumerate() {
                // An idle task with a tick has begun its job, and waits if it has no core.
                let idle = task.phase == Phase::Idle;
                let waiting = task.flag.filter(|_| idle);
                let (Some(job), true) = (task.job.or(waiting), task.first.is_over()) else {
                    continue;
                };
                let period = self.system.components[c].tasks[t].period;
                let no_core = idle && !self.may_get_core(s, c, state::Who::Task(t));
                let waits = task.phase == Phase::WaitingForCore || no_core;
                out.overdue[c][t] |= waits && period.is_some_and(|period| job.measured >= period);
                out.took(c, t, job.measured);
            }
        }
        for (longest, open) in out.within.iter_mut().zip(&s.obligations) {
            *longest = (*longest).max(open.iter().map(|(_, age)| *age).max());
        }
    }

    fn reach(&self, before: Option<&State>, now: &State, out: &mut Results) {
        for (predicate, reached) in self.reach.iter().zip(&mut out.reached) {
            *reached = *reached || self.holds(before, now, predicate);
        }
        for (memory, violated) in now.patterns.iter().zip(&mut out.violated) {
            *violated |= memory.violated;
        }
        // An obligation that is met at once takes no time, which is a measured time.
        for ((trigger, _), longest) in self.within.iter().zip(&mut out.within) {
            let was = before.is_some_and(|state| self.holds(Some(state), state, trigger));
            if !was && self.holds(before, now, trigger) {
                *longest = (*longest).max(Some(0));
            }
        }
    }

    /// Returns all results, or `None` above `limit` states.
    pub(crate) fn explore(&self, limit: usize) -> Option<Results> {
        let mut out = self.blank();
        let mut initial = State::initial(self.system, self.within.len());
        for (c, component) in self.system.components.iter().enumerate() {
            if !component.tasks.is_empty() {
                self.start(&mut initial, c, 0);
            }
        }
        initial.patterns = self.patterns.iter().map(|_| Memory::default()).collect();
        self.watch(None, &mut initial);
        self.reach(None, &initial, &mut out);
        let mut seen: HashSet<State> = HashSet::new();
        seen.insert(initial.clone());
        let mut todo = vec![initial];
        while let Some(s) = todo.pop() {
            if seen.len() > limit {
                return None;
            }
            self.inspect(&s, &mut out);
            let (steps, urgent) = self.possible(&s);
            let mut next: Vec<State> = Vec::new();
            for step in steps {
                let state = self.perform(&s, step, &mut out);
                self.reach(Some(&s), &state, &mut out);
                next.push(state);
            }
            if !urgent {
                out.deadlock |= self.dead(&s);
                next.push(self.pass(&s));
            }
            for state in next {
                if seen.insert(state.clone()) {
                    todo.push(state);
                }
            }
        }
        out.states = seen.len();
        Some(out)
    }
}
