//! The control task: handling of requests and of the end of activities (section 7).

use super::Published;
use super::layout::{control, slot, tracker};
use crate::explore::state::{State, phase};
use crate::system::ClientAction;

impl Published<'_> {
    pub(super) fn request(&self, s: &mut State, client: usize, next: usize) {
        let l = &self.layout;
        let position = l.position(s, client) as usize;
        let ClientAction::Send {
            service,
            ref trackers,
            ..
        } = self.system.clients[client].steps[position].action
        else {
            return;
        };
        let component = self.system.services[service].component;
        l.set_outstanding(s, client, 1);
        for &t in trackers {
            l.set_tracker(s, client, t, tracker::HANDLED);
        }
        l.set_request(s, component, Some((service, client)));
        self.client_to(s, client, next);
        if self.system.services[service].validate.is_some() {
            l.set_control(s, component, control::VALIDATE);
            self.begin_control_codel(s, component);
        } else {
            self.accept(s, component);
        }
    }

    fn begin_control_codel(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        let executor = l.control_executor(component);
        l.set_phase(s, executor, phase::LOCKING);
        if self
            .codel(s, executor)
            .is_some_and(|codel| self.lockless[codel])
        {
            self.execute(s, executor);
        } else {
            l.lock_queue_push(s, executor);
        }
    }

    pub(super) fn finish_control(&self, s: &mut State, component: usize, outcome: usize) {
        let l = &self.layout;
        l.set_phase(s, l.control_executor(component), phase::REST);
        if l.control(s, component) == control::VALIDATE {
            if outcome == 0 {
                self.accept(s, component)
            } else {
                self.end_of_message(s, component)
            }
            return;
        }
        let Some((service, _)) = l.request(s, component) else {
            return;
        };
        let service = &self.system.services[service];
        let next = l.simple(s, component) + 1;
        if (next as usize) < service.simple.len() {
            l.set_simple(s, component, next);
            self.begin_control_codel(s, component);
        } else {
            self.end_of_message(s, component);
        }
    }

    /// Accepts the request, which has passed validation.
    fn accept(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        let Some((number, client)) = l.request(s, component) else {
            return;
        };
        let service = &self.system.services[number];
        if service.activity {
            match service.slots.iter().find(|&&a| l.mode(s, a) == slot::VOID) {
                Some(&a) => {
                    l.set_mode(s, a, slot::WAIT);
                    for t in 0..self.system.clients[client].trackers {
                        if l.tracker(s, client, t) == tracker::HANDLED {
                            l.set_tracker(s, client, t, tracker::SLOT + a as u16);
                        }
                    }
                    self.interrupt(s, number, Some(a));
                }
                None => self.refused[number].set(true),
            }
            self.end_of_message(s, component);
            return;
        }
        self.interrupt(s, number, None);
        if service.simple.is_empty() {
            self.end_of_message(s, component);
        } else {
            l.set_control(s, component, control::SIMPLE);
            l.set_simple(s, component, 0);
            self.begin_control_codel(s, component);
        }
    }

    fn interrupt(&self, s: &mut State, service: usize, except: Option<usize>) {
        for &interrupted in &self.system.services[service].interrupts {
            for &a in &self.system.services[interrupted].slots {
                if Some(a) == except {
                    continue;
                }
                self.interrupt_one(s, a);
            }
        }
    }

    pub(super) fn interrupt_one(&self, s: &mut State, a: usize) {
        match self.layout.mode(s, a) {
            slot::WAIT => self.end_slot(s, a),
            slot::RUN => self.layout.set_mode(s, a, slot::STOP),
            _ => {}
        }
    }

    /// Ends the message: the request is accepted or refused. Its trackers are reset, unless the request
    /// occupies a slot.
    fn end_of_message(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        let Some((_, client)) = l.request(s, component) else {
            return;
        };
        for t in 0..self.system.clients[client].trackers {
            if l.tracker(s, client, t) == tracker::HANDLED {
                l.set_tracker(s, client, t, tracker::NONE);
            }
        }
        l.set_outstanding(s, client, 0);
        self.finish_message(s, component);
    }

    /// Reports ended activities, lets waiting ones run, and prepares for the next message.
    pub(super) fn finish_message(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        l.set_request(s, component, None);
        l.set_simple(s, component, 0);
        l.set_control(s, component, control::READY);

        let services = &self.system.components[component].services;
        for &service in services {
            for &a in &self.system.services[service].slots {
                if l.mode(s, a) == slot::ETHER {
                    self.reset_slot(s, a);
                    for (k, client) in self.system.clients.iter().enumerate() {
                        for t in 0..client.trackers {
                            if l.tracker(s, k, t) == tracker::SLOT + a as u16 {
                                l.set_tracker(s, k, t, tracker::NONE);
                            }
                        }
                    }
                }
            }
        }
        for &task in &self.system.components[component].tasks {
            for &a in &self.system.tasks[task].slots {
                if l.mode(s, a) != slot::WAIT {
                    continue;
                }
                let service = self.system.automata[a]
                    .service
                    .expect("slots belong to services");
                let held = self.system.services[service]
                    .interrupts
                    .iter()
                    .any(|&other| {
                        let slots = &self.system.services[other].slots;
                        slots.iter().any(|&b| b != a && l.mode(s, b) != slot::VOID)
                    });
                if !held {
                    l.set_mode(s, a, slot::RUN);
                }
            }
        }
    }
}
