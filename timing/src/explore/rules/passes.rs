//! Passes: in each pass, every automaton that runs and is not paused executes one codel, in the order of the
//! slots (section 21). Also the counters of entered states, of every automaton with a loop limit.

use super::Rules;
use super::status::{flag, slot, thread};
use crate::explore::state::State;
use crate::scn::semantics::{PauseRule, TurnRule};
use crate::system::{Machine, TaskId, Yield};

impl Rules<'_> {
    /// Begins a pass, up to its first codel. `first`: the first pass of a cycle. Only the first pass of a
    /// periodic task begins activities and resumes paused automata.
    pub(super) fn begin_pass(&self, s: &mut State, task: usize, first: bool) {
        let l = &self.layout;
        let runnable = if self.is_periodic(task) { first } else { l.has(s, task, flag::RUNNABLE) };
        l.lower(s, task, flag::RUNNABLE);
        l.set_thread(s, task, thread::AGAIN);
        for &slot in l.slots(task) {
            self.update_activity(s, task, slot, runnable);
        }
        self.proceed(s, task, 0);
    }

    /// Updates an activity that was released, interrupted or resumed since the last pass.
    fn update_activity(&self, s: &mut State, task: usize, path: usize, runnable: bool) {
        let l = &self.layout;
        let mode = l.mode(s, path);
        let flags = mode & !slot::STATUS;
        let marked = mode & slot::MARK != 0;
        let stop =
            self.machine(s, path).and_then(|machine| machine.stop.or(Some(machine.states.len())));
        let to_stop = |s: &mut State| {
            l.set_at(s, path, stop.unwrap_or(1) as u16);
            self.begin_turn(s, path);
            l.set_mode(s, path, slot::STOP | flags & slot::PERMANENT);
        };
        match mode & slot::STATUS {
            slot::INIT if marked && flags & slot::PERMANENT != 0 => to_stop(s),
            slot::INIT if marked => {
                // The activity ends with the exception "interrupted": no codel is executed, and there is no
                // event.
                self.clear_visits(s, path);
                l.set_at(s, path, 0);
                l.set_mode(s, path, slot::ETHER);
                l.raise(s, task, flag::ENDED);
            }
            slot::INIT if runnable && flags & slot::START != 0 => {
                let start = self.machine(s, path).map_or(0, |machine| machine.start);
                l.set_at(s, path, start as u16);
                self.begin_turn(s, path);
                l.set_mode(s, path, slot::RUN | flags & slot::PERMANENT);
            }
            slot::RUN if marked => to_stop(s),
            slot::RUN | slot::STOP if runnable && flags & slot::PAUSED != 0 => {
                self.begin_turn(s, path);
                l.set_mode(s, path, mode & !slot::PAUSED);
            }
            _ => {}
        }
    }

    /// Proceeds to the first automaton of a pass from a slot (by index) on; ends the pass if there is none.
    fn proceed(&self, s: &mut State, task: usize, from: usize) {
        let l = &self.layout;
        for (index, &path) in l.slots(task).iter().enumerate().skip(from) {
            let mode = l.mode(s, path);
            let runs = matches!(mode & slot::STATUS, slot::RUN | slot::STOP);
            if !runs || mode & slot::PAUSED != 0 {
                continue;
            }
            if self.machine_state(s, path).is_some() {
                l.set_turn_number(s, task, 1 + index as u16);
                l.set_thread(s, task, thread::TICKET);
                return;
            }
            // The default `start` and `stop` take no time and no ticket. An activity without `stop` ends with
            // the exception "interrupted".
            self.end_activity(s, task, path, mode & slot::PERMANENT != 0);
        }
        self.end_pass(s, task);
    }

    fn end_activity(&self, s: &mut State, task: usize, path: usize, success: bool) {
        let l = &self.layout;
        self.clear_visits(s, path);
        l.set_at(s, path, 0);
        let permanent = l.mode(s, path) & slot::PERMANENT;
        let success = if success { slot::SUCCESS } else { 0 };
        l.set_mode(s, path, slot::ETHER | permanent | success);
        l.raise(s, task, flag::ENDED | flag::EVENT);
    }

    /// Ends a codel: its automaton moves on, and the pass with it.
    pub(super) fn finish_codel(&self, s: &mut State, task: usize, outcome: usize) {
        let l = &self.layout;
        let next = l.turn_number(s, task) as usize;
        let Some(turn) = l.turn(s, task) else {
            return;
        };
        let Some(state) = self.machine_state(s, turn) else {
            return;
        };
        match state.yields.get(outcome) {
            Some(&Yield::Next(to)) => {
                self.enter(s, turn, to, &state.yields[outcome]);
                l.raise(s, task, flag::EVENT);
                if self.points.turns == TurnRule::Pause {
                    l.set_thread(s, task, thread::TICKET);
                    return;
                }
                l.raise(s, task, flag::GOES_ON);
            }
            Some(&Yield::Pause(to)) => {
                self.clear_visits(s, turn);
                l.set_at(s, turn, to as u16);
                let mode = l.mode(s, turn);
                l.set_mode(s, turn, mode | slot::PAUSED);
            }
            Some(Yield::End) => self.end_activity(s, task, turn, true),
            None => self.end_activity(s, task, turn, false),
        }
        self.proceed(s, task, next);
    }

    /// Ends a pass: sets the flag of the task itself, and signals the control task.
    fn end_pass(&self, s: &mut State, task: usize) {
        let l = &self.layout;
        let component = self.system.tasks[TaskId::from(task)].component;
        let pass = l.flags(s, task) & flag::OF_PASS;
        l.lower(s, task, flag::OF_PASS);
        l.set_turn_number(s, task, 0);
        if pass & flag::EVENT != 0 {
            self.make_runnable(s, task);
            let mut others = self.system.components[component].tasks.iter();
            if others
                .any(|&other| other != TaskId::from(task) && !self.is_periodic(usize::from(other)))
            {
                l.raise(s, task, flag::WAKE);
            }
        }
        if self.points.pause == PauseRule::Turns {
            let paused = |path: usize| l.mode(s, path) & slot::PAUSED != 0;
            if l.slots(task).iter().copied().any(paused) {
                self.make_runnable(s, task);
            }
        }
        if pass & flag::ENDED != 0 {
            l.set_signal(s, component, 1);
        }
        if pass & flag::GOES_ON != 0 {
            l.set_thread(s, task, thread::AGAIN);
        } else {
            self.end_cycle(s, task);
        }
        let starting = l.starting(s, component) as usize;
        let tasks = &self.system.components[component].tasks;
        let first = l.mode(s, l.slots(task)[0]);
        let begun = first & slot::STATUS != slot::INIT || first & slot::PERMANENT == 0;
        // The end of a permanent activity that fails in its first pass is never handled: its component never
        // starts.
        let ended = slot::ETHER | slot::PERMANENT;
        let failed = first & (slot::STATUS | slot::PERMANENT | slot::SUCCESS) == ended;
        if tasks.get(starting) == Some(&TaskId::from(task)) && begun && !failed {
            self.start_next(s, component);
        }
    }

    fn end_cycle(&self, s: &mut State, task: usize) {
        let l = &self.layout;
        l.set_thread(s, task, thread::IDLE);
        let first = l.has(s, task, flag::FIRST);
        l.lower(s, task, flag::FIRST);
        self.free_core(s, task);
        if let (Some(clock), Some(kept)) = (l.response[task], l.kept(task)) {
            // A kept tick begins the next job; a tick kept from the first cycle counts from now.
            s.t[clock] = if first { 0 } else { s.t[kept] };
            s.t[kept] = 0;
        }
    }

    /// Begins the turn of an automaton in its present state.
    pub(super) fn begin_turn(&self, s: &mut State, index: usize) {
        self.clear_visits(s, index);
        let (base, most) = self.layout.visits[index];
        let limited = self.machine(s, index).is_some_and(|machine| machine.loop_limit.is_some());
        let at = self.layout.at(s, index) as usize;
        // The number of entries is irrelevant if the state is never entered from another state.
        let entered = |machine: &Machine| {
            let mut yields = machine.states.iter().flat_map(|state| &state.yields);
            yields.any(|state| *state == Yield::Next(at))
        };
        if limited && at < most && self.machine(s, index).is_some_and(entered) {
            s.d[base + at] = 1;
        }
    }

    /// Enters another state in the same turn. If no turn of the machine ends, a new round can begin.
    pub(super) fn enter(&self, s: &mut State, slot: usize, to: usize, by: &Yield) {
        let within = self.within_limit(s, slot, by);
        self.layout.set_at(s, slot, to as u16);
        if !within {
            return self.begin_turn(s, slot);
        }
        let limited = self.machine(s, slot).is_some_and(|machine| machine.loop_limit.is_some());
        if limited {
            s.d[self.layout.visits[slot].0 + to] += 1;
        }
    }

    pub(super) fn clear_visits(&self, s: &mut State, index: usize) {
        let (base, most) = self.layout.visits[index];
        s.d[base..base + most].fill(0);
    }
}
