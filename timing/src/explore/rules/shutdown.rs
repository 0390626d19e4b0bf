//! Requests that every component accepts (section 18): `abort`, and the shutdown by `kill`.
//!
//! The shutdown of a component has *stages*: first its tasks in order of declaration, while their activities
//! are interrupted; then in reverse order, while their permanent activities stop; then in order again, as
//! they end; and at last its control task. The thread of the shutdown needs no core and takes no time, and
//! each of its steps is an action.

use super::Rules;
use super::layout::EdfTimes;
use super::status::{control, flag, slot, thread, tracker};
use crate::explore::state::State;
use crate::system::{Builtin, ClientAction, ClientId, ComponentId, TaskId};

/// The stage of a shutdown. Tasks are numbered among all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// Activities of a task are interrupted.
    Activities(usize),
    /// The permanent activity of a task must be interrupted.
    Permanent(usize),
    /// The permanent activity of a task has been interrupted.
    Stopping(usize),
    /// A task ends.
    Task(usize),
    /// The control task ends.
    Control,
}

impl Rules<'_> {
    /// Performs a request that all components accept, after its last codel. Returns true if the request
    /// succeeded.
    pub(super) fn do_builtin(&self, s: &mut State, component: ComponentId, which: Builtin) -> bool {
        match which {
            Builtin::Abort => self.abort(s, component),
            // The reply interrupts.
            Builtin::Connect | Builtin::Interrupt => true,
            Builtin::Kill => {
                self.kill(s, component);
                true
            }
        }
    }

    /// Begins the shutdown of a component. Jobs have none: their activities are interrupted at once.
    pub(super) fn kill(&self, s: &mut State, component: ComponentId) {
        if let Some(place) = self.layout.shutdown[component] {
            s.d[place] = s.d[place].max(1);
            return;
        }
        for &task in &self.system.components[component].tasks {
            let places: Vec<usize> = self.running_jobs(s, usize::from(task)).collect();
            for place in places {
                self.mark(s, usize::from(task), place);
            }
        }
    }

    /// Returns true if the shutdown of a component waits for a task that was never started, because an
    /// earlier task of the component has failed in its start-up. Such a task has nothing to stop.
    pub(in crate::explore) fn is_stuck(&self, s: &State, component: ComponentId) -> bool {
        let Some(Stage::Permanent(task) | Stage::Stopping(task)) = self.stage(s, component) else {
            return false;
        };
        let awaited = self.awaits_start_up(s, TaskId::from(task)).map(usize::from);
        let ended = |task: usize| {
            let place = self.permanent(s, task);
            place.is_none_or(|place| self.layout.activity(s, place) == slot::ETHER)
        };
        awaited.is_some_and(|awaited| awaited != task && ended(awaited))
    }

    /// Goes on with a shutdown past tasks that were never started.
    pub(super) fn skip_unstarted(&self, s: &mut State, component: ComponentId) {
        while self.is_stuck(s, component)
            && let Some(place) = self.layout.shutdown[component]
        {
            s.d[place] += 1;
        }
    }

    /// Returns the activities of a task, except the permanent one, without a shutdown of its component.
    fn running_jobs(&self, s: &State, task: usize) -> impl Iterator<Item = usize> {
        let slots = self.layout.slots(task).iter().copied();
        slots.filter(move |&slot| {
            let automaton = self.activity(s, slot);
            automaton.is_some_and(|automaton| self.system.automata[automaton].service.is_some())
        })
    }

    /// Returns true if a component has shut down. Without a shutdown: if its activities have ended.
    pub(in crate::explore) fn is_shut_down(&self, s: &State, component: ComponentId) -> bool {
        let tasks = &self.system.components[component].tasks;
        match self.layout.shutdown[component] {
            Some(place) => s.d[place] != 0 && self.stage(s, component).is_none(),
            None => {
                tasks.iter().all(|&task| self.running_jobs(s, usize::from(task)).next().is_none())
            }
        }
    }

    /// Marks the instance that a client names. Returns true if there is one.
    fn abort(&self, s: &mut State, component: ComponentId) -> bool {
        let l = &self.layout;
        let Some(client) = l.sender(s, component) else {
            return false;
        };
        let aborted = self.sent(s, client).and_then(|sent| match sent {
            ClientAction::Send { aborts, .. } => *aborts,
            _ => None,
        });
        let value = aborted.map_or(tracker::NONE, |abort| l.tracker(s, client, abort));
        let Some(place) = value.checked_sub(tracker::SLOT) else {
            return false;
        };
        let mode = l.mode(s, place as usize);
        if matches!(mode & slot::STATUS, slot::INIT | slot::RUN) {
            l.set_mode(s, place as usize, mode | slot::MARK);
        }
        true
    }

    /// Returns the step by which a client sent the present request, if the step matters.
    pub(super) fn sent(&self, s: &State, client: ClientId) -> Option<&ClientAction> {
        let at = (self.layout.outstanding(s, client) as usize).checked_sub(1)?;
        let step = self.system.clients[client].steps.get(at)?;
        self.layout.follows[client].then_some(&step.action)
    }

    /// Returns the stage of a component that is being shut down.
    fn stage(&self, s: &State, component: ComponentId) -> Option<Stage> {
        let place = self.layout.shutdown[component]?;
        let number = (s.d[place] as usize).checked_sub(1)?;
        let tasks = &self.system.components[component].tasks;
        let count = tasks.len();
        if let Some(&task) = tasks.get(number) {
            return Some(Stage::Activities(usize::from(task)));
        }
        let number = number - count;
        if number < 2 * count {
            let task = tasks[count - 1 - number / 2];
            return Some(match number % 2 {
                0 => Stage::Permanent(usize::from(task)),
                _ => Stage::Stopping(usize::from(task)),
            });
        }
        match tasks.get(number - 2 * count) {
            Some(&task) => Some(Stage::Task(usize::from(task))),
            None if number == 3 * count => Some(Stage::Control),
            None => None,
        }
    }

    /// Returns the place of the permanent activity of a task, unless the activity has ended and the end was
    /// handled.
    fn permanent(&self, s: &State, task: usize) -> Option<usize> {
        let l = &self.layout;
        let mut slots = l.slots(task).iter().copied();
        slots.find(|&slot| {
            let mode = l.mode(s, slot);
            mode & slot::PERMANENT != 0 && mode & slot::STATUS != slot::VOID
        })
    }

    /// Returns the activities of a task except its permanent one, with their modes.
    fn activities(&self, s: &State, task: usize) -> impl Iterator<Item = (usize, u16)> {
        let l = &self.layout;
        let all = l.slots(task).iter().map(|&slot| (slot, l.mode(s, slot)));
        all.filter(|(_, mode)| mode & slot::PERMANENT == 0)
    }

    /// Returns true if the shutdown of a component can proceed.
    pub(super) fn can_shut_down(&self, s: &State, component: ComponentId) -> bool {
        let l = &self.layout;
        match self.stage(s, component) {
            None => false,
            Some(Stage::Activities(task)) => {
                let to_mark = |mode: u16| {
                    let begins_or_runs = matches!(mode & slot::STATUS, slot::INIT | slot::RUN);
                    begins_or_runs && mode & slot::MARK == 0
                };
                let at_work =
                    |mode: u16| (slot::INIT..=slot::STOP).contains(&(mode & slot::STATUS));
                self.activities(s, task).any(|activity| to_mark(activity.1))
                    || !self.activities(s, task).any(|activity| at_work(activity.1))
            }
            Some(Stage::Permanent(task)) => {
                let free = |&index: &usize| l.activity(s, index) == slot::VOID;
                self.permanent(s, task).is_some() || l.slots(task).iter().any(free)
            }
            Some(Stage::Stopping(task)) => (self.permanent(s, task))
                .is_none_or(|permanent| l.activity(s, permanent) == slot::ETHER),
            Some(Stage::Task(task)) => {
                l.thread_of(s, task) == thread::IDLE && !l.has(s, task, flag::WAKE)
            }
            Some(Stage::Control) => l.control(s, component) == control::READY,
        }
    }

    /// Performs one step of a shutdown.
    pub(super) fn shutdown_step(&self, s: &mut State, component: ComponentId) {
        let l = &self.layout;
        let (Some(stage), Some(place)) = (self.stage(s, component), l.shutdown[component]) else {
            return;
        };
        match stage {
            Stage::Activities(task) => {
                let mut marked = false;
                for &path in l.slots(task) {
                    let mode = l.mode(s, path);
                    let begins_or_runs = matches!(mode & slot::STATUS, slot::INIT | slot::RUN);
                    if begins_or_runs && mode & (slot::PERMANENT | slot::MARK) == 0 {
                        l.set_mode(s, path, mode | slot::MARK);
                        marked = true;
                    }
                }
                if marked {
                    return self.make_runnable(s, task);
                }
            }
            Stage::Permanent(task) => {
                let place = self.permanent(s, task);
                let mode = place.map_or(slot::VOID, |place| l.mode(s, place));
                match mode & slot::STATUS {
                    slot::STOP => {}
                    slot::INIT | slot::RUN => {
                        if let Some(place) = place {
                            l.set_mode(s, place, mode | slot::MARK);
                        }
                        self.make_runnable(s, task);
                    }
                    _ => {
                        let free = |&index: &usize| l.activity(s, index) == slot::VOID;
                        if let Some(place) =
                            place.or_else(|| l.slots(task).iter().copied().find(free))
                        {
                            l.set_automaton(
                                s,
                                place,
                                self.system.tasks[TaskId::from(task)].permanent,
                            );
                            l.set_at(s, place, 0);
                            l.set_mode(s, place, slot::INIT | slot::PERMANENT | slot::MARK);
                        }
                        self.make_runnable(s, task);
                    }
                }
            }
            Stage::Stopping(_) => {}
            Stage::Task(task) => {
                l.lower(s, task, flag::TICK | flag::LATE | flag::RUNNABLE);
                l.set_thread(s, task, thread::ENDED);
                l.set_timer(s, task, 0);
                if let Some(EdfTimes::Ages { tick, kept }) = l.edf {
                    s.t[tick + task] = 0;
                    s.t[kept + task] = 0;
                }
                for clock in [l.response[task], l.kept(task)].into_iter().flatten() {
                    s.t[clock] = 0;
                }
            }
            Stage::Control => l.set_control(s, component, control::OFF),
        }
        s.d[place] += 1;
    }
}
