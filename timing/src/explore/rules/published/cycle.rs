//! The cycle of a task: its start, its release, the turns of its automata, and the consequences of the end of
//! a codel.

use super::Published;
use super::layout::{control, mode, slot};
use crate::explore::state::{State, TaskStatus, phase};
use crate::system::{FOREVER, Policy, Yield};

impl Published<'_> {
    /// Starts tasks of a component, from the one in `starting` up to one that has to run its first codel
    /// (section 3).
    pub(super) fn start_tasks(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        let tasks = &self.system.components[component].tasks;
        let mut at = l.starting(s, component) as usize;
        while let Some(&task) = tasks.get(at) {
            l.set_starting(s, component, at as u16);
            l.set_started(s, task);
            l.set_timer(s, task, 0);
            if let Some(a) = self.system.tasks[task].permanent {
                l.set_mode(s, a, mode::FIRST_CODEL);
                self.begin_turn_at(s, a, self.system.machine_of(a).start);
                return;
            }
            at += 1;
        }
        l.set_starting(s, component, 0);
        l.set_control(s, component, control::READY);
    }

    pub(super) fn release(&self, s: &mut State, task: usize) {
        let l = &self.layout;
        l.set_pending(s, task, false);
        if !self.system.needs_core(task) {
            self.run(s, task);
            return;
        }
        l.set_status(s, task, TaskStatus::Waiting);
        let deadline = self.system.tasks[task].period.unwrap_or(FOREVER);
        let position = if l.has_slack() {
            l.queue(s)
                .iter()
                .position(|&queue| l.slack(s, queue as usize) > deadline)
        } else {
            None
        };
        let position = match (position, self.system.platform.policy) {
            (Some(position), _) => position,
            // Any of the tasks may be chosen, so their order is irrelevant.
            (None, Policy::Any) => l.queue(s).partition_point(|&queue| (queue as usize) < task),
            (None, _) => l.queue(s).len(),
        };
        l.queue_insert(s, position, task as u16);
        l.set_slack(s, task, deadline);
    }

    /// Gives the first turn, after a task has got its core (or needs none).
    pub(super) fn run(&self, s: &mut State, task: usize) {
        self.layout.set_status(s, task, TaskStatus::Running);
        self.give_turn(s, task, 0);
    }

    /// Returns the first position at or after `from` whose automaton has work.
    pub(super) fn next_turn(&self, s: &State, task: usize, from: usize) -> Option<usize> {
        let l = &self.layout;
        let task = &self.system.tasks[task];
        if from == 0
            && let Some(a) = task.permanent
            && l.mode(s, a) == mode::NORMAL
            && l.phase(s, a) == phase::REST
        {
            return Some(0);
        }
        (from.max(1)..=task.slots.len()).find(|&position| {
            let a = task.slots[position - 1];
            matches!(l.mode(s, a), slot::RUN | slot::STOP | slot::STOPPING)
                && l.phase(s, a) == phase::REST
        })
    }

    /// Gives turns from a position on, until an automaton executes or the cycle ends.
    fn give_turn(&self, s: &mut State, task: usize, mut from: usize) {
        let l = &self.layout;
        let definition = &self.system.tasks[task];
        while let Some(position) = self.next_turn(s, task, from) {
            from = position + 1;
            let a = match position {
                0 => definition
                    .permanent
                    .expect("position 0 is the permanent activity"),
                _ => definition.slots[position - 1],
            };
            let mut state = l.at(s, a) as usize;
            if position > 0 && l.mode(s, a) == slot::STOP {
                let Some(stop) = self.system.machine_of(a).stop else {
                    self.end_slot(s, a);
                    continue;
                };
                l.set_mode(s, a, slot::STOPPING);
                state = stop;
            }
            l.set_turn(s, task, 1 + position as u16);
            self.begin_turn_at(s, a, state);
            if l.phase(s, a) & phase::ASYNC == 0 {
                return;
            }
        }
        // End of the cycle.
        l.set_turn(s, task, 0);
        l.set_status(s, task, TaskStatus::Idle);
        if definition
            .slots
            .iter()
            .any(|&a| l.mode(s, a) == slot::ETHER)
        {
            l.set_signal(s, definition.component, 1);
        }
        if let Some(clock) = l.response[task] {
            s.t[clock] = 0;
        }
    }

    fn begin_turn_at(&self, s: &mut State, automaton: usize, state: usize) {
        self.clear_visits(s, automaton);
        self.enter(s, automaton, state);
    }

    fn clear_visits(&self, s: &mut State, automaton: usize) {
        if let Some(base) = self.layout.visits[automaton] {
            let states = self.system.machine_of(automaton).states.len();
            s.d[base..base + states].fill(0);
        }
    }

    /// Enters a codel state: the automaton waits for locks if its codel excludes any other codel.
    fn enter(&self, s: &mut State, automaton: usize, state: usize) {
        let l = &self.layout;
        if let Some(base) = l.visits[automaton] {
            s.d[base + state] += 1;
        }
        l.set_at(s, automaton, state as u16);
        let state = &self.system.machine_of(automaton).states[state];
        let first_run = self.system.automata[automaton].service.is_none()
            && l.mode(s, automaton) != mode::NORMAL;
        let separate = state.is_async && self.system.platform.async_free && !first_run;
        let flag = if separate { phase::ASYNC } else { 0 };
        l.set_phase(s, automaton, phase::LOCKING | flag);
        if self.lockless[state.codel] {
            self.execute(s, automaton);
        } else {
            l.lock_queue_push(s, automaton);
        }
    }

    pub(super) fn finish_state(&self, s: &mut State, a: usize, outcome: usize) {
        let l = &self.layout;
        let automaton = &self.system.automata[a];
        let machine = self.system.machine_of(a);
        let transition = machine.states[l.at(s, a) as usize].yields[outcome];
        let permanent = automaton.service.is_none();
        let first_codel = permanent && l.mode(s, a) == mode::FIRST_CODEL;
        let first_run = permanent && l.mode(s, a) != mode::NORMAL;
        let separate = l.phase(s, a) & phase::ASYNC != 0;
        let new_round = machine.rounds && !self.within_limit(s, a, &transition);

        l.set_phase(s, a, phase::REST);
        match transition {
            // An aperiodic task has a core for all but its start-up codel (section 8): its first cycle
            // follows.
            Yield::Next(state)
                if first_codel && self.system.tasks[automaton.task].period.is_none() =>
            {
                self.clear_visits(s, a);
                l.set_at(s, a, state as u16);
                l.set_mode(s, a, mode::NORMAL);
            }
            Yield::Next(state) if !separate => {
                if new_round {
                    self.clear_visits(s, a);
                }
                if first_codel {
                    l.set_mode(s, a, mode::FIRST_RUN);
                }
                self.enter(s, a, state);
            }
            Yield::Next(state) | Yield::Pause(state) => {
                self.clear_visits(s, a);
                l.set_at(s, a, state as u16);
                if first_run {
                    l.set_mode(s, a, mode::NORMAL);
                }
            }
            Yield::End => {
                if permanent {
                    self.clear_visits(s, a);
                    l.set_at(s, a, 0);
                    l.set_mode(s, a, mode::ENDED);
                } else {
                    self.end_slot(s, a);
                    if separate {
                        l.set_signal(s, self.system.tasks[automaton.task].component, 1);
                    }
                }
            }
        }
        if first_codel {
            let component = self.system.tasks[automaton.task].component;
            let next = l.starting(s, component) + 1;
            l.set_starting(s, component, next);
            self.start_tasks(s, component);
        }
        let turn_over =
            l.phase(s, a) == phase::REST || (l.phase(s, a) & phase::ASYNC != 0 && !separate);
        if turn_over && !first_run && !separate {
            let position = l.turn(s, automaton.task) as usize;
            self.give_turn(s, automaton.task, position);
        }
    }

    pub(super) fn end_slot(&self, s: &mut State, a: usize) {
        self.reset_slot(s, a);
        self.layout.set_mode(s, a, slot::ETHER);
    }

    /// Resets a slot: void, and ready to begin at `start`.
    pub(super) fn reset_slot(&self, s: &mut State, a: usize) {
        let l = &self.layout;
        self.clear_visits(s, a);
        l.set_mode(s, a, slot::VOID);
        l.set_at(s, a, self.system.machine_of(a).start as u16);
        l.set_phase(s, a, phase::REST);
    }
}
