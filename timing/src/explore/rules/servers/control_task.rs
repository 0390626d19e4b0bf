//! The control task: requests, and the interruption, release and end of activities.

use super::Servers;
use super::layout::{control, slot, tracker};
use crate::explore::state::{State, phase};
use crate::system::ClientAction;

impl Servers<'_> {
    /// Takes a request: assigns a slot to an activity, then checks `after` and `before`.
    pub(super) fn request(&self, s: &mut State, client: usize, next: usize) {
        let l = &self.layout;
        let at = l.position(s, client) as usize;
        let step = &self.system.clients[client].steps[at];
        let ClientAction::Send {
            service,
            ref trackers,
            ..
        } = step.action
        else {
            return;
        };
        for &t in trackers {
            l.set_tracker(s, client, t, tracker::HANDLED);
        }
        self.client_to(s, client, next);
        let sent = if l.follows[client] { at as u16 + 1 } else { 1 };
        l.set_outstanding(s, client, sent);
        let definition = &self.system.services[service];
        let component = definition.component;
        l.set_handled_number(s, component, service as u16 + 1);
        l.set_sender(s, component, client as u16 + 1);
        l.set_codel_number(s, component, 0);
        if let Some(&automaton) = definition.slots.first() {
            let task = self.system.automata[automaton].task;
            let free = l.slots(task).find(|&slot| l.status(s, slot) == slot::VOID);
            let Some(free) = free else {
                // Rejected: nothing is validated, and no task is woken.
                self.rejected[service].set(true);
                l.set_refused(s, component, 1);
                l.set_control(s, component, control::REST);
                return;
            };
            l.set_mode(s, free, slot::INIT);
            l.set_automaton(s, free, automaton as u16 + 1);
            l.set_at(s, free, 0);
            l.set_given(s, component, free as u16 + 1);
        }
        let succeeded = |index: &usize| l.success[*index].is_some_and(|place| s.d[place] != 0);
        let allowed =
            definition.after.iter().all(succeeded) && !definition.before.iter().any(succeeded);
        if allowed {
            self.next_codel(s, component);
        } else {
            self.refuse(s, component);
        }
    }

    fn refuse(&self, s: &mut State, component: usize) {
        self.layout.set_refused(s, component, 1);
        self.codels_done(s, component);
    }

    /// Proceeds to the control codel with the present number, if there is one.
    fn next_codel(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        let Some(service) = l.handled(s, component) else {
            return;
        };
        let service = &self.system.services[service];
        let count = usize::from(service.validate.is_some()) + service.simple.len();
        if (l.codel_number(s, component) as usize) < count {
            l.set_control(s, component, control::TICKET);
        } else {
            self.codels_done(s, component);
        }
    }

    /// Ends a control codel: by an exception (or a refusal) if the outcome is 1.
    pub(super) fn finish_control(&self, s: &mut State, component: usize, outcome: usize) {
        let l = &self.layout;
        if outcome == 1 {
            return self.refuse(s, component);
        }
        let number = l.codel_number(s, component);
        let Some(service) = l.handled(s, component) else {
            return;
        };
        let service = &self.system.services[service];
        let last = number as usize + 1 == service.simple.len();
        if let Some(which) = service.builtin.filter(|_| last)
            && !self.do_builtin(s, component, which)
        {
            return self.refuse(s, component);
        }
        l.set_codel_number(s, component, number + 1);
        self.next_codel(s, component);
    }

    /// Makes all tasks runnable after the last control codel, also for a refused request.
    fn codels_done(&self, s: &mut State, component: usize) {
        for &task in &self.system.components[component].tasks {
            self.make_runnable(s, task);
        }
        self.layout.set_codel_number(s, component, 0);
        self.layout.set_control(s, component, control::REST);
    }

    /// Performs the rest of the handling: a function interrupts and succeeds; the control task replies; then
    /// it examines all activities.
    pub(super) fn reply(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        let Some(service) = l.handled(s, component) else {
            return;
        };
        let client = l.sender(s, component) as usize - 1;
        let refused = l.refused(s, component) != 0;
        let given = (l.given(s, component) as usize).checked_sub(1);
        let mut tracked = tracker::NONE;
        match given {
            Some(difference) if refused => self.make_void(s, difference),
            Some(difference) => tracked = tracker::SLOT + difference as u16,
            None if refused => {}
            None => {
                if !self.system.services[service].activity {
                    self.interrupt(s, service, usize::MAX);
                }
                self.has_succeeded(s, service);
            }
        }
        for t in 0..self.system.clients[client].trackers {
            if l.tracker(s, client, t) == tracker::HANDLED {
                let failed = refused && l.outcomes[client][t];
                l.set_tracker(s, client, t, if failed { tracker::FAILED } else { tracked });
            }
        }
        if tracked != tracker::NONE
            && let Some(ClientAction::Send { accepted, .. }) = self.sent(s, client)
        {
            for &t in accepted {
                l.set_tracker(s, client, t, tracked);
            }
        }
        l.set_outstanding(s, client, 0);
        l.set_handled_number(s, component, 0);
        l.set_sender(s, component, 0);
        l.set_given(s, component, 0);
        l.set_refused(s, component, 0);
        l.set_phase(s, l.control_executor(component), phase::REST);
        l.set_control(s, component, control::READY);
        self.look_at_all(s, component);
    }

    fn has_succeeded(&self, s: &mut State, service: usize) {
        if let Some(place) = self.layout.success[service] {
            s.d[place] = 1;
        }
    }

    /// Marks all other instances of the services that a service interrupts. Returns true if some of them
    /// still run.
    fn interrupt(&self, s: &mut State, service: usize, itself: usize) -> bool {
        let l = &self.layout;
        let service = &self.system.services[service];
        let mut delay = false;
        for &task in &self.system.components[service.component].tasks {
            for other in l.slots(task) {
                let listed = || {
                    let of = self.service(s, other);
                    of.is_some_and(|of| service.interrupts.contains(&of))
                };
                if other == itself || l.status(s, other) == slot::VOID || !listed() {
                    continue;
                }
                delay |= self.mark(s, task, other);
            }
        }
        delay
    }

    /// Marks an instance of a task as interrupted. Returns true if the instance still runs.
    pub(super) fn mark(&self, s: &mut State, task: usize, path: usize) -> bool {
        let l = &self.layout;
        let mode = l.mode(s, path);
        match mode & slot::STATUS {
            slot::INIT => l.set_mode(s, path, mode | slot::MARK),
            slot::RUN => {
                l.set_mode(s, path, mode | slot::MARK);
                self.make_runnable(s, task);
                return true;
            }
            slot::STOP => return true,
            _ => {}
        }
        false
    }

    /// Reports the activities that have ended, and releases those that have nothing to wait for any more.
    pub(super) fn look_at_all(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        l.set_signal(s, component, 0);
        for &task in &self.system.components[component].tasks {
            for slot in l.slots(task) {
                let mode = l.mode(s, slot);
                match mode & slot::STATUS {
                    slot::INIT if mode & slot::START == 0 => {
                        let service = self.service(s, slot);
                        let delay = service.is_some_and(|of| self.interrupt(s, of, slot));
                        if !delay {
                            let mode = l.mode(s, slot);
                            l.set_mode(s, slot, mode | slot::START);
                            self.make_runnable(s, task);
                        }
                    }
                    slot::ETHER => {
                        if let (Some(of), true) = (self.service(s, slot), mode & slot::SUCCESS != 0)
                        {
                            self.has_succeeded(s, of);
                        }
                        self.make_void(s, slot);
                    }
                    _ => {}
                }
            }
            self.note_restarts(s, task);
        }
    }

    /// Records services that interrupt themselves, if two interrupted instances wait: both end.
    fn note_restarts(&self, s: &State, task: usize) {
        let l = &self.layout;
        let waits_marked = |path: usize| {
            let mode = l.mode(s, path);
            (mode & slot::STATUS == slot::INIT && mode & slot::MARK != 0)
                .then(|| self.service(s, path))
                .flatten()
                .filter(|&service| self.system.services[service].interrupts.contains(&service))
        };
        for slot in l.slots(task) {
            let Some(service) = waits_marked(slot) else {
                continue;
            };
            let mut others = l.slots(task).filter(|&other| other < slot);
            if others.any(|other| waits_marked(other) == Some(service)) {
                self.restarts[service].set(true);
            }
        }
    }

    /// Frees a slot, and ends all waits for its activity.
    fn make_void(&self, s: &mut State, automaton: usize) {
        let l = &self.layout;
        self.clear_visits(s, automaton);
        let success = l.mode(s, automaton) & slot::SUCCESS != 0;
        l.set_mode(s, automaton, slot::VOID);
        l.set_automaton(s, automaton, 0);
        l.set_at(s, automaton, 0);
        for (k, client) in self.system.clients.iter().enumerate() {
            for t in 0..client.trackers {
                if l.tracker(s, k, t) == tracker::SLOT + automaton as u16 {
                    let failed = !success && l.outcomes[k][t];
                    let value = if failed {
                        tracker::FAILED
                    } else {
                        tracker::NONE
                    };
                    l.set_tracker(s, k, t, value);
                }
            }
        }
    }
}
