//! Ample sets of clients and activities, see [`super`].
//!
//! * **A request** that is handled in no time and whose activity, if it is one, runs at once on an idle task.
//!   No client may send another request at this moment that could make a difference: one for a service that
//!   interrupts this one or is interrupted by it, for a service of the same task, or one that keeps the
//!   control task busy.
//! * **The report of ended activities**, if no activity waits for their end in a slot. Later ends of this
//!   moment are reported later at this moment: no other order leads to another state.
//! * **The end** of an activity's codel whose window is over, if the turn goes on, or if the activity ends
//!   and its task has nothing else to do; again without requests at this moment that would make a difference.
//!   (After a pause the turn of an aperiodic task may begin at once, and shows whether the activity has been
//!   interrupted.)
//! * **The end of a codel of a control task** whose time is over, if the message has no other effect than
//!   such a request.
//! * **The end of a client's delay** whose time is over.
//!
//! These actions cannot follow each other for ever in no time if every round of a client has a delay that may
//! take time.

use typed_index_collections::{TiVec, ti_vec};

use super::AmpleState;
use crate::explore::reductions::facts::{Parts, loops_in_no_time};
use crate::explore::reductions::{Kind, Reason, Setting};
use crate::explore::rules::Action;
use crate::explore::rules::status::{control, permanent, slot, tracker};
use crate::explore::state::{TaskStatus, phase};
use crate::system::{
    AutomatonId, Client, ClientAction, ClientId, CodelId, ComponentId, ServiceId, TaskId, Yield,
};

/// A set of services.
type Services = u128;

/// Known facts about clients and services.
#[derive(Debug)]
pub(super) struct Requests {
    enabled: bool,
    /// Reason why they have no ample sets.
    pub(super) off: Option<Reason>,
    /// By client and step, the services that can be requested in no time after the step.
    after: TiVec<ClientId, Vec<Services>>,
    /// By service, the services that make a difference to it: they interrupt it, are interrupted by it or run
    /// on the same task.
    related: TiVec<ServiceId, Services>,
    /// Services handled in no time.
    instant: Services,
    of_component: TiVec<ComponentId, Services>,
    /// Automata of activities whose turns eventually take time, on tasks without separate threads.
    ordinary: TiVec<AutomatonId, bool>,
    /// Parts that predicates observe.
    visible: Parts,
}

fn bit(service: ServiceId) -> Services {
    1 << usize::from(service)
}

impl Requests {
    pub(super) fn new(setting: &Setting) -> Self {
        let system = setting.system();
        let services = &system.services;
        let off = if setting.without.contains(Kind::PersistentRequests) {
            Some(Reason::SwitchedOff)
        } else if services.len() > Services::BITS as usize {
            Some(Reason::TooMany)
        } else if !system.clients.iter().all(takes_time) {
            Some(Reason::HastyClient)
        } else {
            None
        };
        let enabled = off.is_none();
        let mut out = Requests {
            enabled,
            off: off.or(system.clients.is_empty().then_some(Reason::NoClients)),
            after: TiVec::new(),
            related: TiVec::new(),
            instant: 0,
            of_component: ti_vec![0; system.components.len()],
            ordinary: TiVec::new(),
            visible: setting.facts.visible.parts.clone(),
        };
        if !enabled {
            return out;
        }
        out.after = system.clients.iter().map(after).collect();
        let task = |service: ServiceId| {
            let slot = system.services[service].slots.first();
            slot.map(|&slot| system.automata[slot].task)
        };
        let related = |v: ServiceId, w: ServiceId| {
            v == w
                || system.services[v].interrupts.contains(&w)
                || system.services[w].interrupts.contains(&v)
                || (task(v).is_some() && task(v) == task(w))
        };
        for (v, service) in services.iter_enumerated() {
            let list = services.keys().filter(|&w| related(v, w));
            out.related.push(list.fold(0, |set, w| set | bit(w)));
            if service.validate.is_none() && service.simple.is_empty() {
                out.instant |= bit(v);
            }
            out.of_component[service.component] |= bit(v);
        }
        let separate = |task: usize| {
            let task = &system.tasks[TaskId::from(task)];
            let mut automata = task.permanent.iter().chain(&task.slots);
            system.platform.async_free
                && automata.any(|&a| system.machine_of(a).states.iter().any(|state| state.is_async))
        };
        out.ordinary = (system.automata.iter())
            .map(|automaton| {
                let machine = &system.machines[automaton.machine];
                let hasty = loops_in_no_time(system, machine, false);
                automaton.service.is_some() && !separate(usize::from(automaton.task)) && !hasty
            })
            .collect();
        out
    }
}

/// Returns true if every round of a client has a delay that may take time.
fn takes_time(client: &Client) -> bool {
    let hasty = |step: usize| {
        let step = &client.steps[step];
        !matches!(step.action, ClientAction::Delay(_, upper) if upper > 0)
    };
    !(0..client.steps.len()).filter(|&step| hasty(step)).any(|start| {
        let mut seen = vec![false; client.steps.len()];
        let mut stack = client.steps[start].next.clone();
        while let Some(at) = stack.pop() {
            if at == start {
                return true;
            }
            if at < seen.len() && hasty(at) && !std::mem::replace(&mut seen[at], true) {
                stack.extend(&client.steps[at].next);
            }
        }
        false
    })
}

/// Returns, by step, the services that a client can request in no time after it, if every awaited event has
/// happened.
fn after(client: &Client) -> Vec<Services> {
    let mut out: Vec<Services> = vec![0; client.steps.len()];
    loop {
        let mut changed = false;
        for (at, step) in client.steps.iter().enumerate() {
            let set = step.next.iter().fold(out[at], |set, &next| {
                set | match client.steps.get(next).map(|step| &step.action) {
                    Some(&ClientAction::Send { service, .. }) => bit(service) | out[next],
                    Some(&ClientAction::Delay(lower, _)) if lower > 0 => 0,
                    Some(_) => out[next],
                    None => 0,
                }
            });
            changed |= set != out[at];
            out[at] = set;
        }
        if !changed {
            return out;
        }
    }
}

impl AmpleState<'_, '_> {
    /// Returns true if a request can be handled before anything else.
    pub(super) fn request_alone(&self, client: ClientId) -> bool {
        let known = &self.ample.requests;
        let l = self.layout();
        let system = self.system();
        let step = &system.clients[client].steps[l.position(self.s, client) as usize];
        let ClientAction::Send { service, .. } = step.action else {
            return false;
        };
        if !known.enabled
            || known.instant & bit(service) == 0
            || known.visible.clients[client]
            || known.visible.slots[service]
        {
            return false;
        }
        let others = self.requested_now(|index| index != client);
        let others = others & known.of_component[system.services[service].component];
        others & known.related[service] == 0
            && others & !known.instant == 0
            && self.accepted_alone(service)
    }

    /// Returns true if no other action before the acceptance of a request makes a difference: the request
    /// interrupts no present activity, keeps none waiting, and its activity runs at once, on an idle task.
    fn accepted_alone(&self, service: ServiceId) -> bool {
        let known = &self.ample.requests;
        let l = self.layout();
        let system = self.system();
        let definition = &system.services[service];
        let all = |service: ServiceId, is: &dyn Fn(u16) -> bool| {
            let mut slots = system.services[service].slots.iter();
            slots.all(|&a| is(l.mode(self.s, l.number_of(a))))
        };
        let void = |service: ServiceId| all(service, &|void| void == slot::VOID);
        let waits_for_it =
            |other: &ServiceId| system.services[*other].interrupts.contains(&service);
        let mut waiting = system.components[definition.component].services.iter();
        void(service)
            && definition.interrupts.iter().all(|&interrupt| void(interrupt))
            && waiting.all(|other| !waits_for_it(other) || all(*other, &|init| init != slot::INIT))
            && definition.slots.first().is_none_or(|&a| {
                known.ordinary[a]
                    && !known.visible.machines[system.automata[a].machine]
                    && self.is_free(usize::from(system.automata[a].task))
            })
    }

    /// Returns true if no action of a task can happen at this moment before a request, and no other task
    /// waits for a core.
    fn is_free(&self, task: usize) -> bool {
        let l = self.layout();
        let definition = &self.system().tasks[TaskId::from(task)];
        !self.ample.requests.visible.statuses[task]
            && self.started_up(task)
            && l.status(self.s, task) == TaskStatus::Idle
            && !self.due(task)
            && !l.pending(self.s, task)
            && definition.slots.iter().all(|&a| l.mode(self.s, l.number_of(a)) == slot::VOID)
            && (!self.system().needs_core(TaskId::from(task)) || self.cores_for_all())
    }

    /// Returns the services that clients may request at this moment.
    fn requested_now(&self, counts: impl Fn(ClientId) -> bool) -> Services {
        let known = &self.ample.requests;
        let l = self.layout();
        let later = |executor: usize| {
            let executing = l.phase(self.s, executor) & phase::EXECUTING != 0;
            executing && l.window(self.s, executor).0 > 0
        };
        let of = |client: ClientId| {
            let at = l.position(self.s, client) as usize;
            let Some(step) = self.system().clients[client].steps.get(at) else {
                return 0;
            };
            let after = known.after[client][at];
            match step.action {
                ClientAction::Send { service, .. } => bit(service) | after,
                ClientAction::Delay(..) if later(l.client_executor(client)) => 0,
                ClientAction::AwaitEnded(t) => {
                    let slot = l.tracker(self.s, client, t).checked_sub(tracker::SLOT);
                    match slot {
                        Some(a) if later(a as usize) => 0,
                        _ => after,
                    }
                }
                ClientAction::Delay(..)
                | ClientAction::AwaitAccepted
                | ClientAction::AwaitAny
                | ClientAction::AwaitOutcome(..) => after,
            }
        };
        let clients = self.system().clients.keys().filter(|&client| counts(client));
        clients.fold(0, |set, client| set | of(client))
    }

    /// Returns true if the ends of activities can be reported before anything else.
    pub(super) fn report_alone(&self, component: ComponentId) -> bool {
        let known = &self.ample.requests;
        let l = self.layout();
        let system = self.system();
        let ended = |client: ClientId| {
            let values = l.trackers(self.s, client).iter();
            let mut slots = values.filter_map(|tracker| tracker.checked_sub(tracker::SLOT));
            slots.any(|a| l.mode(self.s, a as usize) == slot::ETHER)
        };
        known.enabled
            && system.components[component].services.iter().all(|&service| {
                let mut slots =
                    system.services[service].slots.iter().map(|&a| l.mode(self.s, l.number_of(a)));
                slots.all(|it_is| match it_is {
                    slot::INIT => false,
                    slot::ETHER => !known.visible.slots[service],
                    _ => true,
                })
            })
            && system.clients.keys().all(|client| !known.visible.clients[client] || !ended(client))
    }

    /// Returns true if the end of an activity's codel can come before anything else.
    pub(super) fn activity_end_alone(&self, executor: usize) -> bool {
        let known = &self.ample.requests;
        let l = self.layout();
        let system = self.system();
        let id = l.automaton_numbered(executor);
        let Some(automaton) = system.automata.get(id) else {
            return false;
        };
        let Some(service) = automaton.service else {
            return false;
        };
        let task = automaton.task;
        if !known.enabled
            || !known.ordinary[id]
            || l.window(self.s, executor).1 > 0
            || known.visible.machines[automaton.machine]
            || known.visible.statuses[usize::from(task)]
        {
            return false;
        }
        let state = &system.machine_of(id).states[l.at(self.s, executor) as usize];
        if state.yields.iter().all(|transition| matches!(transition, Yield::Next(_))) {
            return true;
        }
        let definition = &system.tasks[task];
        let component = definition.component;
        // The beginning of the next turn shows whether the activity has been interrupted.
        let ends = (definition.period.is_some()
            || state.yields.iter().all(|transition| !matches!(transition, Yield::Pause(_))))
            && !known.visible.slots[service];
        let nothing_else = (definition.slots.iter())
            .all(|&a| a == id || self.cannot_change(a, service))
            && !self.due(usize::from(task))
            && !l.pending(self.s, usize::from(task))
            && definition.permanent.is_none_or(|a| match l.mode(self.s, l.number_of(a)) {
                permanent::ENDED => true,
                permanent::NORMAL => definition.period.is_some(),
                _ => false,
            })
            && (!system.needs_core(task) || self.cores_for_all());
        let waits = |client: ClientId| {
            let at = l.position(self.s, client) as usize;
            let step = system.clients[client].steps.get(at).map(|step| &step.action);
            matches!(step, Some(&ClientAction::AwaitEnded(t))
                if l.tracker(self.s, client, t) == tracker::SLOT + executor as u16)
        };
        let requested = self.requested_now(|client| !waits(client)) & known.of_component[component];
        ends && nothing_else
            && l.control(self.s, component) == control::READY
            && requested & known.related[service] == 0
            && requested & !known.instant == 0
    }

    /// Returns true if a slot of the activity's task does not change, as the task sees it, until that
    /// activity has ended, provided that no client requests a related service.
    fn cannot_change(&self, slot: AutomatonId, activity: ServiceId) -> bool {
        let l = self.layout();
        let system = self.system();
        let automaton = &system.automata[slot];
        match l.mode(self.s, l.number_of(slot)) {
            slot::VOID | slot::ETHER => true,
            slot::INIT => (automaton.service)
                .is_some_and(|service| system.services[service].interrupts.contains(&activity)),
            _ => {
                self.ample.requests.ordinary[slot]
                    && !self.ample.requests.visible.machines[automaton.machine]
            }
        }
    }

    /// Returns true if the end of a codel of a control task can come before anything else.
    pub(super) fn control_end_alone(&self, executor: usize) -> bool {
        let known = &self.ample.requests;
        let l = self.layout();
        let system = self.system();
        let Some(component) = executor
            .checked_sub(l.threads)
            .filter(|&component| component < l.components)
            .map(ComponentId::from)
        else {
            return false;
        };
        let (Some(service), Some(client)) =
            (l.handled(self.s, component), l.sender(self.s, component))
        else {
            return false;
        };
        if !known.enabled
            || l.window(self.s, executor).1 > 0
            || known.visible.controls[component]
            || known.visible.clients[client]
            || known.visible.slots[service]
        {
            return false;
        }
        let validates = self.rules.validates(self.s, component);
        let definition = &system.services[service];
        let last = usize::from(definition.validate.is_some()) + definition.simple.len();
        let goes_on = !validates && l.codel_number(self.s, component) as usize + 1 < last;
        // Interruptions take place before the service's own codels.
        let ends = !validates && self.reports_nothing(component);
        goes_on
            || ends
            || (validates && self.reports_nothing(component) && self.accepted_alone(service))
    }

    /// Returns true if the end of a message changes nothing in slots.
    fn reports_nothing(&self, component: ComponentId) -> bool {
        let l = self.layout();
        let mut services = self.system().components[component].services.iter();
        services.all(|&service| {
            let slots = &self.system().services[service].slots;
            slots
                .iter()
                .all(|&a| !matches!(l.mode(self.s, l.number_of(a)), slot::INIT | slot::ETHER))
        })
    }

    /// Returns true if an acquisition by an activity or a control task changes nothing that is observed, and
    /// cannot be repeated for ever in no time.
    pub(super) fn may_acquire_for_request(&self, executor: usize) -> bool {
        let known = &self.ample.requests;
        if !known.enabled {
            return false;
        }
        let id = self.layout().automaton_numbered(executor);
        if let Some(automaton) = self.system().automata.get(id) {
            known.ordinary[id]
                && !known.visible.machines[automaton.machine]
                && self.started_up(usize::from(automaton.task))
        } else {
            let component = executor - self.system().automata.len();
            known.visible.controls.get(ComponentId::from(component)) == Some(&false)
        }
    }

    /// Returns true if a task with activities may want a lock of a codel at this moment.
    pub(super) fn task_may_want(&self, task: usize, codel: CodelId) -> bool {
        let l = self.layout();
        let system = self.system();
        let definition = &system.tasks[TaskId::from(task)];
        let automata = || definition.permanent.iter().chain(&definition.slots).copied();
        let separate = system.platform.async_free
            && automata().any(|a| system.machine_of(a).states.iter().any(|state| state.is_async));
        let settled = self.started_up(task);
        // While a task executes a codel that does not end yet, no other action of the task is possible.
        let executes = (l.turn(self.s, task))
            .is_some_and(|a| l.phase(self.s, a) == phase::EXECUTING && l.window(self.s, a).0 > 0);
        let rests = l.status(self.s, task) == TaskStatus::Idle
            && definition.period.is_some()
            && !self.due(task)
            && !l.pending(self.s, task);
        if !separate && settled && (executes || rests) {
            return false;
        }
        let conflicts = &system.codels[codel].conflicts;
        automata().any(|a| {
            let mut states = system.machine_of(a).states.iter();
            states.any(|state| conflicts.contains(state.codel))
        })
    }

    /// Returns true if a control task may want a lock of a codel at this moment.
    pub(super) fn control_may_want(&self, component: ComponentId, codel: CodelId) -> bool {
        let l = self.layout();
        let executor = l.control_executor(component);
        if !self.ample.requests.enabled {
            return true;
        }
        if l.phase(self.s, executor) == phase::EXECUTING && l.window(self.s, executor).0 > 0 {
            return false;
        }
        let conflicts = &self.system().codels[codel].conflicts;
        let wants = |service: ServiceId| {
            let service = &self.system().services[service];
            service
                .validate
                .iter()
                .chain(&service.simple)
                .any(|&validate| conflicts.contains(validate))
        };
        let requested = self.requested_now(|_| true);
        let handled = l.handled(self.s, component);
        (self.system().components[component].services.iter()).any(|&service| {
            let now = requested & bit(service) != 0 || handled == Some(service);
            now && wants(service)
        })
    }

    /// Returns true if the end of a client's delay can come before anything else.
    pub(super) fn delay_alone(&self, executor: usize) -> bool {
        let l = self.layout();
        let client = l.client_of_executor(executor);
        client.is_some_and(|client| {
            self.ample.requests.enabled
                && l.window(self.s, executor).1 == 0
                && !self.ample.requests.visible.clients[client]
        })
    }

    /// Writes a request or an end with all its outcomes.
    pub(super) fn with_outcomes(&self, action: Action, out: &mut Vec<Action>) {
        let same = |other: &&Action| match (**other, action) {
            (Action::Finish { executor: e, .. }, Action::Finish { executor, .. }) => e == executor,
            (Action::Request { client: k, .. }, Action::Request { client, .. }) => k == client,
            _ => false,
        };
        out.extend(self.enabled.actions.iter().filter(same));
    }
}
