//! Cores that are held for ever.
//!
//! A task holds its core until its cycle ends. A permanent activity that can neither pause nor end has a
//! cycle that never ends. If such tasks hold all cores, no other task gets one any more. So a task that has
//! not completed its start-up, and has no core, never has a job: questions about its deadlines and response
//! times have no further answer.

use super::rules::Rules;
use super::state::State;
use super::watch::Watch;
use crate::scn::semantics::Cycle;
use crate::system::{Machine, Policy, TaskId, loops};

/// The tasks that hold a core for ever, in a system where this ends all questions.
#[derive(Debug)]
pub(super) struct HeldCores {
    cores: usize,
    endless: Vec<TaskId>,
    /// Tasks with questions.
    asked: Vec<TaskId>,
}

impl HeldCores {
    /// Returns `None` if cores can be taken away or set free, if too few tasks hold one for ever, or if there
    /// are other questions than those about jobs.
    pub(super) fn of(rules: &Rules, watch: &Watch) -> Option<HeldCores> {
        let system = rules.system();
        let cores = system.platform.cores? as usize;
        let responses = watch.response.iter().map(|response| &response.task);
        let asked = watch.schedulable.iter().chain(&watch.overdue).chain(responses);
        let asked: Vec<TaskId> = asked.copied().collect();
        let preempts = matches!(system.platform.policy, Policy::Priority | Policy::Fair);
        let others = !watch.reach.is_empty() || !watch.within.is_empty() || watch.deadlock;
        if preempts
            || others
            || asked.is_empty()
            || rules.token.is_some()
            || rules.points.cycle != Cycle::Passes
            || system.platform.async_free
            || system.has_builtin(|_| true)
        {
            return None;
        }
        let is_endless = |&task: &TaskId| {
            let throws = |machine: &Machine, states: Vec<usize>| {
                states.iter().any(|&state| system.codels[machine.states[state].codel].throws)
            };
            system.needs_core(task)
                && system.tasks[task].permanent.is_some_and(|permanent| {
                    let machine = system.machine_of(permanent);
                    let states = loops::states_of_endless_run(machine);
                    states.is_some_and(|states| !throws(machine, states))
                })
        };
        let endless: Vec<TaskId> = system.tasks.keys().filter(is_endless).collect();
        let ends = endless.len() >= cores && asked.iter().all(|&task| system.needs_core(task));
        ends.then_some(HeldCores { cores, endless, asked })
    }

    /// Returns the tasks that hold all cores for ever, if no job of a task with a question can follow.
    pub(super) fn holders(&self, rules: &Rules, s: &State) -> Vec<TaskId> {
        let held = self.endless.iter().copied().filter(|&task| rules.has_core(s, task));
        // A holder may still complete its own first pass, and start the next task.
        let waits = |&task: &TaskId| {
            let awaited = rules.awaits_start_up(s, task);
            awaited.is_some_and(|awaited| !rules.has_core(s, awaited) && !rules.has_core(s, task))
        };
        if held.clone().count() >= self.cores && self.asked.iter().all(waits) {
            held.collect()
        } else {
            Vec::new()
        }
    }
}
