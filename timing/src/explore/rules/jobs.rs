//! Jobs: in each cycle of a task, every automaton that can run has one turn, in the order of the slots. A
//! turn ends with a pause or the end of the automaton (section 4). The start of a task is its first codel
//! (section 3).

use super::Rules;
use super::status::{control, flag, permanent, slot, thread};
use crate::explore::state::{State, TaskStatus, phase};
use crate::system::{AutomatonId, CodelId, ComponentId, TaskId, Yield};

impl Rules<'_> {
    /// Starts tasks of a component, from the one in `starting` up to one that has to run its first codel.
    pub(super) fn start_tasks(&self, s: &mut State, component: ComponentId) {
        let l = &self.layout;
        let tasks = &self.system.components[component].tasks;
        let mut at = l.starting(s, component) as usize;
        while let Some(&task) = tasks.get(at) {
            l.set_starting(s, component, at as u16);
            l.set_thread(s, usize::from(task), thread::IDLE);
            if self.is_periodic(usize::from(task)) {
                l.set_timer(s, usize::from(task), self.first_tick(usize::from(task)));
            }
            if let Some(automaton) = self.system.tasks[task].permanent {
                l.set_mode(s, l.number_of(automaton), permanent::FIRST_CODEL);
                self.enter_turn(s, automaton, self.system.machine_of(automaton).start);
                return;
            }
            at += 1;
        }
        l.set_starting(s, component, 0);
        l.set_control(s, component, control::READY);
    }

    /// Returns true if a task is released now (section 4, with the rule for ticks without work).
    pub(super) fn is_released(&self, s: &State, task: usize) -> bool {
        let l = &self.layout;
        if l.status(s, task) != TaskStatus::Idle {
            return false;
        }
        let definition = &self.system.tasks[TaskId::from(task)];
        if definition.period.is_some() {
            l.pending(s, task)
                && (!definition.keep_idle_tick || self.next_turn(s, task, 0).is_some())
        } else {
            self.next_turn(s, task, 0).is_some()
        }
    }

    /// Releases a task: it takes its tick and waits for a core, or begins.
    pub(super) fn release_job(&self, s: &mut State, task: usize) {
        let l = &self.layout;
        l.lower(s, task, flag::TICK);
        if !self.system.needs_core(TaskId::from(task)) {
            self.run_job(s, task);
            return;
        }
        l.set_thread(s, task, thread::WAITING);
        self.queue_for_core(s, task);
    }

    /// Gives the first turn, after a task has got its core (or needs none).
    pub(super) fn run_job(&self, s: &mut State, task: usize) {
        self.layout.set_thread(s, task, thread::EXECUTING);
        self.give_turn(s, task, 0);
    }

    /// Returns the first slot, by index, at or after `from` whose automaton has work.
    fn next_turn(&self, s: &State, task: usize, from: usize) -> Option<usize> {
        let l = &self.layout;
        let slots = l.slots(task);
        (from..slots.len()).find(|&number| {
            let slot = slots[number];
            let can_run = match self.system.automata[l.automaton_numbered(slot)].service {
                None => l.mode(s, slot) == permanent::NORMAL,
                Some(_) => matches!(l.activity(s, slot), slot::RUN | slot::STOP),
            };
            can_run && l.phase(s, slot) == phase::REST
        })
    }

    /// Gives turns from a slot on, until an automaton executes or the cycle ends.
    fn give_turn(&self, s: &mut State, task: usize, mut from: usize) {
        let l = &self.layout;
        while let Some(index) = self.next_turn(s, task, from) {
            from = index + 1;
            let slot = l.slots(task)[index];
            let automaton = l.automaton_numbered(slot);
            let mut state = l.at(s, slot) as usize;
            if l.mode(s, slot) & slot::MARK != 0 {
                let Some(stop) = self.system.machine_of(automaton).stop else {
                    self.end_slot(s, slot);
                    continue;
                };
                l.set_mode(s, slot, slot::STOP);
                state = stop;
            }
            l.set_turn_number(s, task, 1 + index as u16);
            self.enter_turn(s, automaton, state);
            if l.phase(s, slot) & phase::ASYNC == 0 {
                return;
            }
        }
        // End of the cycle.
        l.set_turn_number(s, task, 0);
        l.set_thread(s, task, thread::IDLE);
        l.lower(s, task, flag::CORE);
        let definition = &self.system.tasks[TaskId::from(task)];
        if definition
            .slots
            .iter()
            .any(|&automaton| l.mode(s, l.number_of(automaton)) == slot::ETHER)
        {
            l.set_signal(s, definition.component, 1);
        }
        if let Some(clock) = l.response[task] {
            s.t[clock] = 0;
        }
    }

    /// Begins the turn of an automaton in a state.
    fn enter_turn(&self, s: &mut State, automaton: AutomatonId, state: usize) {
        let slot = self.layout.number_of(automaton);
        self.layout.set_at(s, slot, state as u16);
        self.begin_turn(s, slot);
        self.wait_for_locks(s, automaton);
    }

    /// Lets an automaton wait for the locks of its present codel, unless the codel excludes no other codel.
    fn wait_for_locks(&self, s: &mut State, automaton: AutomatonId) {
        let l = &self.layout;
        let number = l.number_of(automaton);
        let entry = &self.system.automata[automaton];
        let state = &self.system.machine_of(automaton).states[l.at(s, number) as usize];
        let first_turn = entry.service.is_none() && l.mode(s, number) != permanent::NORMAL;
        let separate = state.is_async && self.system.platform.async_free && !first_turn;
        let flag = if separate { phase::ASYNC } else { 0 };
        l.set_phase(s, number, phase::LOCKING | flag);
        self.lock(s, number, state.codel);
    }

    /// Begins the present codel of an executor if it excludes no other codel, else queues for its locks.
    pub(super) fn lock(&self, s: &mut State, executor: usize, codel: CodelId) {
        if self.lockless[codel] {
            self.execute(s, executor);
        } else if let Some(component) = self.component_of(executor) {
            self.layout.lock_queue_push(s, component, executor);
        }
    }

    /// Ends a codel of the automaton that has the number `a`.
    pub(super) fn finish_state(&self, s: &mut State, a: usize, outcome: usize) {
        let l = &self.layout;
        let id = l.automaton_numbered(a);
        let automaton = &self.system.automata[id];
        let machine = self.system.machine_of(id);
        let successor = machine.states[l.at(s, a) as usize].yields[outcome];
        let is_permanent = automaton.service.is_none();
        let first_codel = is_permanent && l.mode(s, a) == permanent::FIRST_CODEL;
        let first_turn = is_permanent && l.mode(s, a) != permanent::NORMAL;
        let separate = l.phase(s, a) & phase::ASYNC != 0;
        let component = self.system.tasks[automaton.task].component;

        l.set_phase(s, a, phase::REST);
        match successor {
            // An aperiodic task has a core for all but its start-up codel (section 8): its first cycle
            // follows.
            Yield::Next(state) if first_codel && !self.is_periodic(usize::from(automaton.task)) => {
                self.clear_visits(s, a);
                l.set_at(s, a, state as u16);
                l.set_mode(s, a, permanent::NORMAL);
            }
            Yield::Next(state) if !separate => {
                if first_codel {
                    l.set_mode(s, a, permanent::FIRST_TURN);
                }
                self.enter(s, a, state, &successor);
                self.wait_for_locks(s, id);
            }
            Yield::Next(state) | Yield::Pause(state) => {
                self.clear_visits(s, a);
                l.set_at(s, a, state as u16);
                if first_turn {
                    l.set_mode(s, a, permanent::NORMAL);
                }
            }
            Yield::End if is_permanent => {
                self.clear_visits(s, a);
                l.set_at(s, a, 0);
                l.set_mode(s, a, permanent::ENDED);
            }
            Yield::End => {
                self.end_slot(s, a);
                if separate {
                    l.set_signal(s, component, 1);
                }
            }
        }
        if first_codel {
            let next = l.starting(s, component) + 1;
            l.set_starting(s, component, next);
            self.start_tasks(s, component);
        }
        let turn_over =
            l.phase(s, a) == phase::REST || (l.phase(s, a) & phase::ASYNC != 0 && !separate);
        if turn_over && !first_turn && !separate {
            let next = l.turn_number(s, usize::from(automaton.task)) as usize;
            self.give_turn(s, usize::from(automaton.task), next);
        }
    }

    /// Ends an activity: it is to be reported.
    pub(super) fn end_slot(&self, s: &mut State, slot: usize) {
        self.clear_visits(s, slot);
        self.layout.set_at(s, slot, 0);
        self.layout.set_mode(s, slot, slot::ETHER);
    }
}
