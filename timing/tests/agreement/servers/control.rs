//! The actions of the control task.

use super::state::{Control, Doing, Handled, Instance, Request, State, Status, Tracked};
use super::{Interpreter, Results};

impl Interpreter<'_> {
    /// Takes a request: its slot, `after` and `before`.
    pub(super) fn accept(
        &self,
        s: &mut State,
        (client, node): (usize, usize),
        (c, service): (usize, usize),
        out: &mut Results,
    ) {
        let model = &self.system.components[c].services[service];
        let awaits = self.system.clients[client].awaits;
        let tracked = &mut s.clients[client].tracked;
        tracked.retain(|&(d, other, _)| (d, other) != (c, service));
        if awaits {
            tracked.push((c, service, Tracked::Handled));
        }
        let component = &mut s.components[c];
        let mut request = Request {
            client,
            service,
            slot: None,
            node: if self.system.clients[client].aborts { node } else { 0 },
        };
        if let Some((task, _)) = model.activity {
            let slots = &mut component.tasks[task].slots;
            let Some(free) = slots.iter().position(Option::is_none) else {
                out.refused[c][service] = true;
                component.control = Control::Rest(request, Handled::Refused);
                return;
            };
            request.slot = Some((task, free));
            slots[free] = Some(Instance {
                service: Some(service),
                status: Status::Asked,
                at: 0,
                paused: false,
                mark: false,
            });
        }
        let succeeded = |&index: &usize| component.succeeded[index];
        let in_order = model.after.iter().all(succeeded) && !model.before.iter().any(succeeded);
        if self.system.order && !in_order {
            component.control = Control::Rest(request, Handled::Refused);
            self.wake(s, c, None);
        } else if model.control.is_empty() {
            component.control = Control::Rest(request, Handled::Accepted);
            self.wake(s, c, None);
        } else {
            component.control = Control::Codel(request, 0, Doing::Nothing);
        }
    }

    /// Ends a codel of the control task; after the last one all tasks are woken.
    pub(super) fn handled(&self, s: &mut State, c: usize, goes_on: bool) {
        let Control::Codel(request, at, _) = s.components[c].control else {
            unreachable!("it executes a codel");
        };
        let codels = &self.system.components[c].services[request.service].control;
        let handled = match goes_on {
            true if at + 1 < codels.len() => {
                s.components[c].control = Control::Codel(request, at + 1, Doing::Nothing);
                return;
            }
            true => {
                let builtin = self.system.components[c].services[request.service].builtin;
                let done = builtin.is_none_or(|builtin| self.builtin(s, c, request, builtin));
                if done { Handled::Accepted } else { Handled::Refused }
            }
            false => Handled::Refused,
        };
        s.components[c].control = Control::Rest(request, handled);
        self.wake(s, c, None);
    }

    /// Interrupts for a function, records its success, replies; then handles ended and waiting activities.
    pub(super) fn rest(&self, s: &mut State, c: usize) {
        let Control::Rest(request, handled) = s.components[c].control else {
            unreachable!("there is no request");
        };
        s.components[c].control = Control::Ready;
        let asks = self.system.clients[request.client].outcomes;
        let mut tracked = Tracked::Over(handled == Handled::Accepted || !asks);
        match (handled, request.slot) {
            (Handled::Accepted, Some((task, slot))) => {
                if let Some(slot) = &mut s.components[c].tasks[task].slots[slot]
                    && slot.status == Status::Asked
                {
                    slot.status = Status::Init(false);
                }
                tracked = Tracked::Slot(task, slot);
                if self.system.clients[request.client].aborts {
                    let instances = &mut s.clients[request.client].instances;
                    let (service, node) = (request.service, request.node);
                    instances.retain(|instance| {
                        (instance.0, instance.1, instance.2) != (c, service, node)
                    });
                    instances.push((c, service, node, Some((task, slot))));
                }
            }
            (Handled::Accepted, None) => {
                for (task, slot) in self.interrupted(s, c, request.service, None) {
                    self.mark(s, c, task, slot);
                }
                s.components[c].succeeded[request.service] = true;
            }
            (Handled::Refused, Some((task, slot))) => {
                s.components[c].tasks[task].slots[slot] = None;
            }
            (Handled::Refused, None) => {}
        }
        let client = &mut s.clients[request.client];
        client.outstanding = false;
        for triple in &mut client.tracked {
            if triple.2 == Tracked::Handled {
                triple.2 = tracked;
            }
        }
        self.report(s, c);
    }

    /// Reports ended activities, and releases waiting ones.
    pub(super) fn report(&self, s: &mut State, c: usize) {
        s.components[c].signal = false;
        for t in 0..s.components[c].tasks.len() {
            for slot in 0..s.components[c].tasks[t].slots.len() {
                let place = &mut s.components[c].tasks[t].slots[slot];
                let Some(Status::Ended(succeeded)) = place.as_ref().map(|place| place.status)
                else {
                    continue;
                };
                let service = place.take().and_then(|place| place.service);
                let Some(service) = service else { continue };
                s.components[c].succeeded[service] |= succeeded;
                for (k, client) in s.clients.iter_mut().enumerate() {
                    let asks = self.system.clients[k].outcomes;
                    for triple in &mut client.tracked {
                        if (triple.0, triple.2) == (c, Tracked::Slot(t, slot)) {
                            triple.2 = Tracked::Over(succeeded || !asks);
                        }
                    }
                    for instance in &mut client.instances {
                        if (instance.0, instance.3) == (c, Some((t, slot))) {
                            instance.3 = None;
                        }
                    }
                }
            }
        }
        for client in &mut s.clients {
            // Only the last one of the finished requests can still be awaited.
            let last = client.tracked.len().saturating_sub(1);
            let mut at = 0;
            client.tracked.retain(|(.., tracked)| {
                at += 1;
                *tracked != Tracked::Over(true) || at > last
            });
        }
        for t in 0..s.components[c].tasks.len() {
            for slot in 0..s.components[c].tasks[t].slots.len() {
                let Some(instance) = &s.components[c].tasks[t].slots[slot] else {
                    continue;
                };
                let (Some(service), Status::Init(false)) = (instance.service, instance.status)
                else {
                    continue;
                };
                let others = self.interrupted(s, c, service, Some((t, slot)));
                for &(task, other) in &others {
                    self.mark(s, c, task, other);
                }
                let status = |&(task, other): &(usize, usize)| {
                    let slot = s.components[c].tasks[task].slots[other].as_ref();
                    slot.map(|slot| slot.status)
                };
                let at_work = |place| matches!(status(place), Some(Status::Run | Status::Stop));
                if others.iter().any(at_work) {
                    continue;
                }
                if let Some(slot) = &mut s.components[c].tasks[t].slots[slot] {
                    slot.status = Status::Init(true);
                }
                self.set_runnable(s, c, t);
            }
        }
    }

    /// Returns the instances of the services that a service interrupts, except one.
    fn interrupted(
        &self,
        s: &State,
        c: usize,
        service: usize,
        but: Option<(usize, usize)>,
    ) -> Vec<(usize, usize)> {
        let list = &self.system.components[c].services[service].interrupts;
        let mut out = Vec::new();
        for (t, task) in s.components[c].tasks.iter().enumerate() {
            for (slot, instance) in task.slots.iter().enumerate() {
                let of = instance.as_ref().and_then(|instance| instance.service);
                if of.is_some_and(|service| list.contains(&service)) && Some((t, slot)) != but {
                    out.push((t, slot));
                }
            }
        }
        out
    }

    fn mark(&self, s: &mut State, c: usize, t: usize, slot: usize) {
        let Some(slot) = &mut s.components[c].tasks[t].slots[slot] else {
            return;
        };
        match slot.status {
            Status::Init(_) => slot.mark = true,
            Status::Run => {
                slot.mark = true;
                self.set_runnable(s, c, t);
            }
            Status::Asked | Status::Stop | Status::Ended(_) => {}
        }
    }
}
