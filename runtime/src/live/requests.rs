//! Requests of clients of the scenario and from outside, from start to answer.

use dotgen_timing::explore::{Stepper, Work};

use super::{Instance, Live};
use crate::hosts::{Call, Message, OutsideRequest, ReplyError, RequestReply};
use dotgen_timing::system::{ClientId, ClientStep, ComponentId, ServiceId};

/// Marks the numbers of requests by codels.
const CODEL_REQUEST_BIT: u64 = 1 << 63;

/// The exception of a request to a run that is ending.
pub(super) const STOPPING: &str = "::dotgen::stopping";

/// The exception of an activity whose codel took too long.
const OVERRUN: &str = "::dotgen::overrun";

/// The exception of a request to a component that is lost.
pub(super) const COMPONENT_LOST: &str = "::dotgen::lost";

impl Live<'_> {
    /// Begins and ends the requests and activities that the stepper has begun and ended.
    pub(super) fn begin_and_end_requests(&mut self, stepper: &Stepper) {
        for place in 0..self.places.len() {
            let service = stepper.activity(place);
            let service = service.and_then(|service| self.system.automata[service].service);
            let component = service.map(|service| self.system.services[service].component);
            match (&self.places[place], component) {
                (Some(_), None) => {
                    if let Some(place) = self.places[place].take() {
                        self.finish(place);
                    }
                }
                (None, Some(component)) => self.places[place] = self.pending[component].take(),
                _ => {}
            }
        }
        for component in self.system.components.keys() {
            match stepper.handling(component) {
                Some((service, refused)) => {
                    // An activity may have its place before it is accepted: it is the youngest one of its
                    // service.
                    let places = self.places.iter_mut().flatten();
                    let youngest = places
                        .filter(|place| {
                            place.service == service && self.system.services[service].activity
                        })
                        .max_by_key(|place| place.number);
                    if let Some(instance) = self.pending[component].as_mut().or(youngest) {
                        instance.refused |= refused;
                    }
                }
                None => {
                    if let Some(instance) = self.pending[component].take() {
                        self.finish(instance);
                    }
                }
            }
        }
    }

    pub(super) fn requested(&mut self, client: ClientId, service: ServiceId) {
        let component = self.system.services[service].component;
        let number = self.next_instance;
        self.next_instance += 1;
        // Clients for requests from outside follow the clients of the scenario.
        let outside = self.parts.outside(client) == Some(component);
        let wanted = if outside {
            let all = &mut self.wanted[component];
            let first = all.front().is_some_and(|request| request.service == service);
            first.then(|| all.pop_front()).flatten()
        } else {
            None
        };
        let (_, index) = self.parts.services[service];
        let inputs = match &wanted {
            Some(request) => request.inputs.as_slice(),
            None => self.parts.inputs[service].as_slice(),
        };
        let declared = self.system.services[service].builtin.is_none();
        if declared && self.alive[component] && self.parts.of(component).is_some() {
            self.hosts.make(component, index.0, number, inputs);
        }
        self.pending[component] = Some(Instance {
            wanted: wanted.map(|request| request.id),
            failed: None,
            state: None,
            ended: false,
            refused: false,
            number,
            service,
        });
    }

    /// Ends a request.
    fn finish(&mut self, instance: Instance) {
        let service = &self.system.services[instance.service];
        let component = service.component;
        let (_, index) = self.parts.services[instance.service];
        let hosted = service.builtin.is_none()
            && self.alive[component]
            && self.parts.of(component).is_some();
        let well =
            !instance.refused && instance.failed.is_none() && (!service.activity || instance.ended);
        let mut outputs = Some(Vec::new());
        if hosted {
            if let (true, Some(copies)) = (well, self.parts.copies[instance.service]) {
                self.copy(component, copies, instance.number);
            }
            outputs = if self.alive[component] {
                self.hosts.end(component, index.0, instance.number)
            } else {
                None
            };
        }
        let Some(id) = instance.wanted else { return };
        let answer = match (instance.failed, outputs) {
            (_, None) => return self.answer_failed(id, COMPONENT_LOST),
            (_, Some(outputs)) if well => RequestReply::Done(outputs),
            (Some((exception, detail)), _) => RequestReply::Failed { exception, detail },
            (None, _) if instance.refused => RequestReply::Failed {
                exception: "::genom::disallowed".to_owned(),
                detail: Vec::new(),
            },
            (None, _) => RequestReply::Failed {
                exception: "::genom::interrupted".to_owned(),
                detail: Vec::new(),
            },
        };
        self.answer(id, answer);
    }

    /// Copies the values of an attribute.
    fn copy(&mut self, component: ComponentId, codel: u32, instance: u32) {
        let ticket = u32::MAX;
        self.hosts.run(&Call { lane: u32::MAX, component, ticket, codel, instance, core: None });
        let until = self.work_deadline_nanos();
        while let Some(message) = self.hosts.wait(until) {
            match message {
                Message::CodelResult(of, ran) if of == component && ran.ticket == ticket => return,
                Message::Lost { component: of, why } => {
                    self.lost(of, why);
                    if of == component {
                        return;
                    }
                }
                other => self.message(other),
            }
        }
        if self.hosts.now() >= until {
            self.hosts.kill(component);
            self.lost(component, "did not answer within 10 s".to_owned());
        }
    }

    /// Returns true for the delay of a client that stands for requests from outside.
    pub fn is_outside(&self, work: &Work) -> bool {
        matches!(work, Work::Delay { client } if self.parts.outside(*client).is_some())
    }

    /// Returns true if a client may proceed to a step after a delay. A client that stands for requests from
    /// outside waits for such a request.
    pub(crate) fn may_proceed(&self, client: ClientId, step: usize) -> bool {
        let Some(component) = self.parts.outside(client) else {
            return true;
        };
        let wanted = self.wanted.get(component).and_then(|requests| requests.front());
        let steps = &self.system.clients[client].steps;
        let requests = steps.get(step).and_then(ClientStep::requests);
        !self.ending && wanted.is_some_and(|request| requests == Some(request.service))
    }

    /// Interrupts aborted outside requests, and activities whose codels take too long. `tell` gets the place
    /// of each one before the interruption.
    pub fn abort(&mut self, stepper: &mut Stepper, tell: &mut dyn FnMut(&Stepper, usize)) {
        for place in std::mem::take(&mut self.overrun) {
            if let Some(Some(instance)) = self.places.get_mut(place) {
                instance.failed.get_or_insert_with(|| (OVERRUN.to_owned(), Vec::new()));
                tell(stepper, place);
                stepper.interrupt(place);
            }
        }
        for id in std::mem::take(&mut self.aborts) {
            let of = |instance: &Option<Instance>| {
                instance.as_ref().is_some_and(|instance| instance.wanted == Some(id))
            };
            if let Some(place) = self.places.iter().position(of) {
                tell(stepper, place);
                stepper.interrupt(place);
            }
            let mut waiting = None;
            for all in &mut self.wanted {
                if let Some(at) = all.iter().position(|request| request.id == id) {
                    waiting = all.remove(at);
                }
            }
            if waiting.is_some() {
                self.answer_failed(id, "::genom::interrupted");
            }
        }
    }

    /// Reports the state of an activity from outside, if the activity was in another state before.
    pub(super) fn report_state(&mut self, work: &Work) {
        let Work::State { automaton, state, .. } = *work else {
            return;
        };
        let Some(instance) = self.instance(work) else {
            return;
        };
        let changed = instance.state.replace(state) != Some(state);
        // A codel that requested the activity gets no reports.
        let wanted = instance.wanted.filter(|id| id & CODEL_REQUEST_BIT == 0);
        if let (true, Some(id)) = (changed, wanted) {
            let machine = &self.system.machines[self.system.automata[automaton].machine];
            self.hosts.entered(id, &machine.states[state].name);
        }
    }

    /// Answers that activities were accepted. Must be called after each step. `told` holds the numbers of
    /// activities already answered.
    pub fn accept(&mut self, stepper: &Stepper, told: &mut Vec<u32>) {
        for place in 0..self.places.len() {
            let Some(place) = &self.places[place] else {
                continue;
            };
            let component = self.system.services[place.service].component;
            let handled = stepper.handling(component).is_some();
            if let (Some(id), false) = (place.wanted, handled)
                && !told.contains(&place.number)
            {
                told.push(place.number);
                self.answer(id, RequestReply::Accepted);
            }
        }
        told.retain(|number| self.places.iter().flatten().any(|place| place.number == *number));
    }

    /// Handles the call of a remote service by a codel. On the virtual clock there is no answer, because no
    /// time passes while a codel runs.
    pub(super) fn call_remote(
        &mut self,
        component: ComponentId,
        ask: u32,
        remote: u32,
        inputs: Vec<u8>,
    ) {
        let service = self.parts.remote(component, remote);
        let Some(service) = service.filter(|_| !self.waits) else {
            return self.hosts.reply(component, ask, Err(ReplyError::NoService));
        };
        self.next_ask += 1;
        let id = CODEL_REQUEST_BIT | self.next_ask;
        self.asks.insert(id, (component, ask));
        self.message(Message::OutsideRequest(OutsideRequest { id, service, inputs }));
    }

    /// Sends an answer to its destination: outside, or a codel.
    fn answer(&mut self, id: u64, answer: RequestReply) {
        if id & CODEL_REQUEST_BIT == 0 {
            return self.hosts.answer(id, answer);
        }
        let outputs = match answer {
            RequestReply::Accepted => return,
            RequestReply::Done(outputs) => Ok(outputs),
            RequestReply::Failed { exception, .. } if exception == COMPONENT_LOST => {
                Err(ReplyError::Lost)
            }
            RequestReply::Failed { .. } => Err(ReplyError::Failed),
        };
        if let Some((component, ask)) = self.asks.remove(&id) {
            self.hosts.reply(component, ask, outputs);
        }
    }

    pub(super) fn answer_failed(&mut self, id: u64, exception: &str) {
        let answer = RequestReply::Failed { exception: exception.to_owned(), detail: Vec::new() };
        self.answer(id, answer);
    }
}
