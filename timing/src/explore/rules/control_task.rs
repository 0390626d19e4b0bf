//! The control task: requests, and the interruption, release and end of activities.
//!
//! In steps (section 21): the control task takes a request and gives an activity its slot; it takes a ticket
//! for each codel; then all tasks become runnable; then it replies, and examines all activities. At once
//! (section 7): it validates, accepts and interrupts in one step, except for codels.

use super::Rules;
use super::points::Handling;
use super::status::{control, slot, tracker};
use crate::explore::state::{State, phase};
use crate::system::{ClientAction, ClientId, ComponentId, ServiceId};

impl Rules<'_> {
    /// Takes a request.
    pub(super) fn request(&self, s: &mut State, client: ClientId, next: usize) {
        let l = &self.layout;
        let at = l.position(s, client) as usize;
        let step = &self.system.clients[client].steps[at];
        let ClientAction::Send { service, ref trackers, .. } = step.action else {
            return;
        };
        for &t in trackers {
            l.set_tracker(s, client, t, tracker::HANDLED);
        }
        self.client_to(s, client, next);
        let sent = if l.follows[client] { at as u16 + 1 } else { 1 };
        l.set_outstanding(s, client, sent);
        let component = self.system.services[service].component;
        l.set_handled_number(s, component, usize::from(service) as u16 + 1);
        l.set_sender_number(s, component, usize::from(client) as u16 + 1);
        l.set_codel_number(s, component, 0);
        match self.points.handling {
            Handling::InSteps => self.assign_slot(s, component, service),
            Handling::AtOnce if self.system.services[service].validate.is_some() => {
                self.begin_control_codel(s, component);
            }
            Handling::AtOnce => self.accept(s, component),
        }
    }

    /// Assigns a slot to a requested activity, then checks `after` and `before`.
    fn assign_slot(&self, s: &mut State, component: ComponentId, service: ServiceId) {
        let l = &self.layout;
        let definition = &self.system.services[service];
        if let Some(&automaton) = definition.slots.first() {
            let task = self.system.automata[automaton].task;
            let mut slots = l.slots(usize::from(task)).iter();
            let free = slots.find(|&&slot| l.activity(s, slot) == slot::VOID);
            let Some(&free) = free else {
                // Rejected: nothing is validated, and no task is woken.
                self.rejected[service].set(true);
                self.refusal.set(Some(service));
                l.set_refused(s, component, 1);
                l.set_control(s, component, control::REST);
                return;
            };
            l.set_mode(s, free, slot::INIT);
            l.set_automaton(s, free, Some(automaton));
            l.set_at(s, free, 0);
            l.set_given(s, component, free as u16 + 1);
        }
        let succeeded = |&of: &ServiceId| l.success[of].is_some_and(|place| s.d[place] != 0);
        let allowed =
            definition.after.iter().all(succeeded) && !definition.before.iter().any(succeeded);
        if allowed {
            self.next_codel(s, component);
        } else {
            self.refuse(s, component);
        }
    }

    fn refuse(&self, s: &mut State, component: ComponentId) {
        self.refusal.set(self.layout.handled(s, component));
        self.layout.set_refused(s, component, 1);
        self.codels_done(s, component);
    }

    /// Proceeds to the control codel with the present number, if there is one.
    fn next_codel(&self, s: &mut State, component: ComponentId) {
        let l = &self.layout;
        let Some(service) = l.handled(s, component) else {
            return;
        };
        let service = &self.system.services[service];
        let count = usize::from(service.validate.is_some()) + service.simple.len();
        let codels_left = (l.codel_number(s, component) as usize) < count;
        match (self.points.handling, codels_left) {
            (Handling::InSteps, true) => l.set_control(s, component, control::TICKET),
            (Handling::InSteps, false) => self.codels_done(s, component),
            (Handling::AtOnce, true) => self.begin_control_codel(s, component),
            (Handling::AtOnce, false) => self.end_of_message(s, component),
        }
    }

    /// Lets the control task wait for the locks of its present codel, unless the codel excludes no other
    /// codel.
    fn begin_control_codel(&self, s: &mut State, component: ComponentId) {
        let l = &self.layout;
        let executor = l.control_executor(component);
        l.set_control(s, component, control::EXECUTING);
        l.set_phase(s, executor, phase::LOCKING);
        if let Some(codel) = self.codel(s, executor) {
            self.lock(s, executor, codel);
        }
    }

    /// Ends a control codel: by an exception (or a refusal) if the outcome is 1.
    pub(super) fn finish_control(&self, s: &mut State, component: ComponentId, outcome: usize) {
        let l = &self.layout;
        if self.points.handling == Handling::AtOnce {
            if outcome != 0 {
                self.refusal.set(l.handled(s, component));
            }
            return match (self.validates(s, component), outcome) {
                (true, 0) => self.accept(s, component),
                (true, _) => self.end_of_message(s, component),
                (false, _) => {
                    let next = l.codel_number(s, component) + 1;
                    l.set_codel_number(s, component, next);
                    self.next_codel(s, component);
                }
            };
        }
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
    fn codels_done(&self, s: &mut State, component: ComponentId) {
        for &task in &self.system.components[component].tasks {
            self.make_runnable(s, usize::from(task));
        }
        self.layout.set_codel_number(s, component, 0);
        self.layout.set_control(s, component, control::REST);
    }

    /// Performs the rest of the handling: a function interrupts and succeeds; the control task replies; then
    /// it examines all activities.
    pub(super) fn reply(&self, s: &mut State, component: ComponentId) {
        let l = &self.layout;
        let (Some(service), Some(client)) = (l.handled(s, component), l.sender(s, component))
        else {
            return;
        };
        let refused = l.refused(s, component) != 0;
        let given = (l.given(s, component) as usize).checked_sub(1);
        let mut tracked = tracker::NONE;
        match given {
            Some(place) if refused => self.make_void(s, place),
            Some(place) => tracked = tracker::SLOT + place as u16,
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
        self.ready(s, component);
        self.examine_all(s, component);
    }

    /// Answers the client, and gets ready for the next message.
    fn ready(&self, s: &mut State, component: ComponentId) {
        let l = &self.layout;
        if let Some(client) = l.sender(s, component) {
            l.set_outstanding(s, client, 0);
        }
        l.set_handled_number(s, component, 0);
        l.set_codel_number(s, component, 0);
        l.set_sender_number(s, component, 0);
        l.set_given(s, component, 0);
        l.set_refused(s, component, 0);
        l.set_phase(s, l.control_executor(component), phase::REST);
        l.set_control(s, component, control::READY);
    }

    /// Accepts a request at once: gives an activity its slot, and interrupts.
    fn accept(&self, s: &mut State, component: ComponentId) {
        let l = &self.layout;
        let (Some(number), Some(client)) = (l.handled(s, component), l.sender(s, component)) else {
            return;
        };
        let service = &self.system.services[number];
        if service.activity {
            let mut slots = (service.slots.iter()).map(|&automaton| l.number_of(automaton));
            if let Some(slot) = slots.find(|&slot| l.mode(s, slot) == slot::VOID) {
                l.set_mode(s, slot, slot::INIT);
                for t in 0..self.system.clients[client].trackers {
                    if l.tracker(s, client, t) == tracker::HANDLED {
                        l.set_tracker(s, client, t, tracker::SLOT + slot as u16);
                    }
                }
                self.interrupt(s, number, slot);
            } else {
                self.rejected[number].set(true);
                self.refusal.set(Some(number));
            }
            return self.end_of_message(s, component);
        }
        self.interrupt(s, number, usize::MAX);
        l.set_codel_number(s, component, u16::from(service.validate.is_some()));
        self.next_codel(s, component);
    }

    /// Ends a message that is handled at once. Trackers are reset, unless the request has a slot.
    fn end_of_message(&self, s: &mut State, component: ComponentId) {
        let l = &self.layout;
        if let Some(client) = l.sender(s, component) {
            for t in 0..self.system.clients[client].trackers {
                if l.tracker(s, client, t) == tracker::HANDLED {
                    l.set_tracker(s, client, t, tracker::NONE);
                }
            }
        }
        self.ready(s, component);
        self.examine_all(s, component);
    }

    fn has_succeeded(&self, s: &mut State, service: ServiceId) {
        if let Some(place) = self.layout.success[service] {
            s.d[place] = 1;
        }
    }

    /// Marks all other instances of the services that a service interrupts. Returns true if some of them
    /// still run.
    fn interrupt(&self, s: &mut State, service: ServiceId, itself: usize) -> bool {
        let l = &self.layout;
        let service = &self.system.services[service];
        let mut delay = false;
        for &task in &self.system.components[service.component].tasks {
            for &other in l.slots(usize::from(task)) {
                let listed = || {
                    let of = self.service(s, other);
                    of.is_some_and(|of| service.interrupts.contains(&of))
                };
                if other == itself || l.activity(s, other) == slot::VOID || !listed() {
                    continue;
                }
                delay |= self.mark(s, usize::from(task), other);
            }
        }
        delay
    }

    /// Marks an instance of a task as interrupted. Returns true if the instance still runs.
    pub(super) fn mark(&self, s: &mut State, task: usize, slot: usize) -> bool {
        let l = &self.layout;
        let mode = l.mode(s, slot);
        match mode & slot::STATUS {
            // An activity that waits ends: at once, or in the next pass of its task.
            slot::INIT if self.points.handling == Handling::AtOnce => self.end_slot(s, slot),
            slot::INIT => l.set_mode(s, slot, mode | slot::MARK),
            slot::RUN => {
                l.set_mode(s, slot, mode | slot::MARK);
                self.make_runnable(s, task);
                return true;
            }
            slot::STOP => return true,
            _ => {}
        }
        false
    }

    /// Reports the activities that have ended, and releases those that have nothing to wait for any more.
    pub(super) fn examine_all(&self, s: &mut State, component: ComponentId) {
        let l = &self.layout;
        let tasks = &self.system.components[component].tasks;
        if self.points.handling == Handling::InSteps {
            l.set_signal(s, component, 0);
        } else {
            // Ends come first, so that no activity waits for one that has ended.
            let slots = tasks.iter().flat_map(|&task| l.slots(usize::from(task)));
            slots.for_each(|&slot| self.report(s, slot));
        }
        for &task in tasks {
            for &slot in l.slots(usize::from(task)) {
                self.report(s, slot);
                self.release_activity(s, usize::from(task), slot);
            }
            self.note_restarts(s, usize::from(task));
        }
    }

    /// Returns true for a permanent activity of which the control task knows nothing.
    fn is_exempt(&self, service: Option<ServiceId>) -> bool {
        service.is_none() && self.points.handling == Handling::AtOnce
    }

    /// Releases an accepted activity, unless it has to wait for activities that it interrupts.
    fn release_activity(&self, s: &mut State, task: usize, slot: usize) {
        let l = &self.layout;
        let mode = l.mode(s, slot);
        let service = self.service(s, slot);
        let accepted = mode & slot::STATUS == slot::INIT && mode & slot::START == 0;
        if !accepted || self.is_exempt(service) {
            return;
        }
        if self.points.handling == Handling::InSteps {
            let delay = service.is_some_and(|of| self.interrupt(s, of, slot));
            if !delay {
                let mode = l.mode(s, slot);
                l.set_mode(s, slot, mode | slot::START);
                self.make_runnable(s, task);
            }
        } else if !service.is_some_and(|of| self.is_held(s, of, slot)) {
            l.set_mode(s, slot, slot::RUN);
            let start = self.machine(s, slot).map_or(0, |machine| machine.start);
            l.set_at(s, slot, start as u16);
        }
    }

    /// Returns true if some other instance that a service interrupts is not reported yet.
    fn is_held(&self, s: &State, service: ServiceId, slot: usize) -> bool {
        let mut interrupted = self.system.services[service].interrupts.iter();
        interrupted.any(|&other| {
            let slots = self.system.services[other].slots.iter();
            let mut slots = slots.map(|&automaton| self.layout.number_of(automaton));
            slots.any(|instance| instance != slot && self.layout.mode(s, instance) != slot::VOID)
        })
    }

    /// Reports an activity that has ended.
    fn report(&self, s: &mut State, slot: usize) {
        let mode = self.layout.mode(s, slot);
        let service = self.service(s, slot);
        if mode & slot::STATUS != slot::ETHER || self.is_exempt(service) {
            return;
        }
        if let (Some(of), true) = (service, mode & slot::SUCCESS != 0) {
            self.has_succeeded(s, of);
        }
        self.make_void(s, slot);
    }

    /// Records services that interrupt themselves, if two interrupted instances wait: both end.
    fn note_restarts(&self, s: &State, task: usize) {
        let l = &self.layout;
        let waits_marked = |instance: usize| {
            let mode = l.mode(s, instance);
            (mode & slot::STATUS == slot::INIT && mode & slot::MARK != 0)
                .then(|| self.service(s, instance))
                .flatten()
                .filter(|&service| self.system.services[service].interrupts.contains(&service))
        };
        for &slot in l.slots(task) {
            let Some(service) = waits_marked(slot) else {
                continue;
            };
            let mut others = l.slots(task).iter().filter(|&&other| other < slot);
            if others.any(|&other| waits_marked(other) == Some(service)) {
                self.restarts[service].set(true);
            }
        }
    }

    /// Frees a slot, and ends all waits for its activity.
    fn make_void(&self, s: &mut State, slot: usize) {
        let l = &self.layout;
        self.clear_visits(s, slot);
        let success = l.mode(s, slot) & slot::SUCCESS != 0;
        l.set_mode(s, slot, slot::VOID);
        l.set_automaton(s, slot, None);
        l.set_at(s, slot, 0);
        for (k, client) in self.system.clients.iter_enumerated() {
            for t in 0..client.trackers {
                if l.tracker(s, k, t) == tracker::SLOT + slot as u16 {
                    let failed = !success && l.outcomes[k][t];
                    let value = if failed { tracker::FAILED } else { tracker::NONE };
                    l.set_tracker(s, k, t, value);
                }
            }
        }
    }
}
