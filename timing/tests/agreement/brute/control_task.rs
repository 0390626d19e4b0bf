//! The actions of the control task.

use super::state::{Doing, Mode, State, Step, Tracked};
use super::{Brute, Results};
use dotgen_timing::scn::semantics::LockRule;
use dotgen_timing::system::{ClientId, ComponentId, ServiceId};

impl Brute<'_> {
    pub(super) fn control_codel(&self, s: &mut State, c: ComponentId) {
        let e = s.automata.len() + usize::from(c);
        if self.system.codels[self.codel(s, e)].conflicts.is_empty() {
            s.controls[c].doing = Doing::Executing(0);
        } else {
            s.controls[c].doing = Doing::Locking;
            if self.system.platform.semantics.locks == LockRule::Fifo {
                s.lock_queue.push(e);
            }
        }
    }

    pub(super) fn end_control(
        &self,
        s: &mut State,
        c: ComponentId,
        outcome: usize,
        results: &mut Results,
    ) {
        s.controls[c].doing = Doing::Nothing;
        match s.controls[c].step.clone() {
            Step::Validate(service, client) => {
                if outcome == 0 {
                    self.accepted(s, c, service, client, results);
                } else {
                    self.replied(s, c, client);
                }
            }
            Step::Simple(service, client, i) => {
                if i + 1 < self.system.services[service].simple.len() {
                    s.controls[c].step = Step::Simple(service, client, i + 1);
                    self.control_codel(s, c);
                } else {
                    self.replied(s, c, client);
                }
            }
            _ => panic!("no codel"),
        }
    }

    pub(super) fn accepted(
        &self,
        s: &mut State,
        c: ComponentId,
        service: ServiceId,
        client: ClientId,
        results: &mut Results,
    ) {
        let definition = &self.system.services[service];
        let mut own = None;
        if definition.activity {
            own = definition.slots.iter().copied().find(|&a| s.automata[a].mode == Mode::Void);
            let Some(a) = own else {
                results.refused[usize::from(service)] = true;
                self.replied(s, c, client);
                return;
            };
            s.automata[a].mode = Mode::Wait;
            for t in &mut s.clients[client].tracked {
                if *t == Tracked::Handled {
                    *t = Tracked::Slot(a);
                }
            }
        }
        for &other in &definition.interrupts {
            for &a in &self.system.services[other].slots {
                if Some(a) != own {
                    match s.automata[a].mode {
                        Mode::Wait => self.to_ether(s, a),
                        Mode::Run => s.automata[a].mode = Mode::Stop,
                        _ => {}
                    }
                }
            }
        }
        if !definition.activity && !definition.simple.is_empty() {
            s.controls[c].step = Step::Simple(service, client, 0);
            self.control_codel(s, c);
        } else {
            self.replied(s, c, client);
        }
    }

    fn replied(&self, s: &mut State, c: ComponentId, client: ClientId) {
        s.clients[client].outstanding = false;
        for t in &mut s.clients[client].tracked {
            if *t == Tracked::Handled {
                *t = Tracked::Over;
            }
        }
        self.finish(s, c);
    }

    pub(super) fn finish(&self, s: &mut State, c: ComponentId) {
        s.controls[c].step = Step::Ready;
        for &service in &self.system.components[c].services {
            for &a in &self.system.services[service].slots {
                if s.automata[a].mode == Mode::Ether {
                    self.to_void(s, a);
                    for client in &mut s.clients {
                        for t in &mut client.tracked {
                            if *t == Tracked::Slot(a) {
                                *t = Tracked::Over;
                            }
                        }
                    }
                }
            }
        }
        for &t in &self.system.components[c].tasks {
            for &a in &self.system.tasks[t].slots {
                if s.automata[a].mode == Mode::Wait {
                    let service = self.system.automata[a].service.unwrap();
                    let free = self.system.services[service].interrupts.iter().all(|&other| {
                        let slots = &self.system.services[other].slots;
                        slots.iter().all(|&b| b == a || s.automata[b].mode == Mode::Void)
                    });
                    if free {
                        s.automata[a].mode = Mode::Run;
                    }
                }
            }
        }
    }
}
