//! Recalls of delegated tasks, and the calls and requests that wait for them.

use dotgen_timing::system::{CodelId, ComponentId};

use super::{Delegated, Live, PAUSE_PERIODS, Recall, lane};
use crate::hosts::{Call, Message, OutsideRequest};

impl Live<'_> {
    /// Executes a codel in its host, unless the thread of its task does so by itself. Tasks whose codels it
    /// excludes are recalled first.
    pub(in crate::live) fn run_unless_delegated(&mut self, codel: CodelId, call: Call) {
        let (executor, now) = (call.ticket as usize, self.delegations.now);
        if let Some(delegated) = self.delegations.of(executor) {
            // The result comes without a call, or its delegation ends.
            delegated.begun = now;
            let component = delegated.component;
            return self.admit(component);
        }
        let blocking: Vec<usize> = (self.delegations.tasks.iter())
            .filter(|other| other.recall != Recall::Over)
            .filter(|other| self.excludes_any(codel, &other.codels))
            .map(|other| other.executor)
            .collect();
        if blocking.is_empty() {
            return self.hosts.run(&call);
        }
        for &executor in &blocking {
            self.recall_for_a_while(executor);
        }
        self.delegations.postponed.push((call, blocking));
    }

    /// Recalls a task, and leaves it to the engine for some periods.
    pub(super) fn recall_for_a_while(&mut self, executor: usize) {
        self.recall(executor);
        let Some(task) = self.delegations.of(executor).map(|other| other.task) else {
            return;
        };
        let period = self.system.tasks[task].period.unwrap_or(0);
        let until = self.delegations.now + PAUSE_PERIODS * u64::from(period);
        let pauses = &mut self.delegations.not_before;
        pauses.retain(|&(of, _)| of != task);
        pauses.push((task, until));
    }

    /// Recalls all tasks.
    pub(in crate::live) fn recall_all(&mut self) {
        let executors: Vec<usize> =
            self.delegations.tasks.iter().map(|delegated| delegated.executor).collect();
        for executor in executors {
            self.recall(executor);
        }
    }

    fn recall(&mut self, executor: usize) {
        if let Some(delegated) = self.delegations.of(executor)
            && delegated.recall == Recall::None
        {
            delegated.recall = Recall::Asked;
            let (component, lane) = (delegated.component, lane(delegated.task));
            self.hosts.recall(component, lane);
            // The answer to this probe shows that the thread begins no further codel.
            self.probe(executor);
        }
    }

    /// Handles the end of a delegation.
    pub(in crate::live) fn recalled(&mut self, component: ComponentId, ticket: u32) {
        let executor = ticket as usize;
        let Some(delegated) = self.delegations.of(executor) else {
            return;
        };
        if delegated.component != component {
            return;
        }
        delegated.recall = Recall::Over;
        self.settle(executor);
        self.unblock(&[executor]);
    }

    /// Executes the calls that have waited for executors.
    pub(super) fn unblock(&mut self, executors: &[usize]) {
        let mut ready = Vec::new();
        self.delegations.postponed.retain_mut(|(call, blocking)| {
            blocking.retain(|other| !executors.contains(other));
            if blocking.is_empty() {
                ready.push(*call);
            }
            !blocking.is_empty()
        });
        for call in ready {
            self.hosts.run(&call);
        }
    }

    /// Removes a delegation that is over, as soon as the model has reached its end.
    pub(super) fn settle(&mut self, executor: usize) {
        let Some(delegated) = self.delegations.of(executor) else {
            return;
        };
        let component = delegated.component;
        if delegated.recall == Recall::Over && delegated.results.is_empty() {
            let tasks = &mut self.delegations.tasks;
            tasks.retain(|other| other.executor != executor);
            let running = self.running.get(executor).and_then(Option::as_ref);
            let work = running.map(|running| running.work);
            if let Some(work) = work.filter(|_| self.is_running(executor)) {
                // The thread has stopped before this codel.
                if let Some((codel, call)) = self.call(executor, &work) {
                    self.run_unless_delegated(codel, call);
                }
            }
        }
        self.admit(component);
    }

    /// Handles the requests from outside that have waited for the tasks of a component.
    pub(super) fn admit(&mut self, component: ComponentId) {
        let mut tasks = self.delegations.tasks.iter();
        let waits = |task: &Delegated| {
            task.component == component && task.recall != Recall::None && self.goes_on(task)
        };
        if tasks.any(waits) {
            return;
        }
        for message in std::mem::take(&mut self.delegations.deferred[component]) {
            self.message(message);
        }
    }

    /// Returns true if a thread may begin a codel, or has begun one that the model has not begun.
    fn goes_on(&self, task: &Delegated) -> bool {
        let last = task.recall >= Recall::PassedOn && task.results.is_empty();
        !(last && self.is_running(task.executor))
    }

    /// Returns the request, if it may be handled now. Otherwise it is kept until the tasks that it disturbs
    /// are recalled.
    pub(in crate::live) fn defer_request(
        &mut self,
        request: OutsideRequest,
    ) -> Option<OutsideRequest> {
        let component = self.system.services[request.service].component;
        let disturbed: Vec<usize> = (self.delegations.tasks.iter())
            .filter(|task| task.component == component && self.goes_on(task))
            .filter(|task| self.disturbs(request.service, &task.codels))
            .map(|task| task.executor)
            .collect();
        if disturbed.is_empty() && self.delegations.deferred[component].is_empty() {
            return Some(request);
        }
        for executor in disturbed {
            self.recall(executor);
        }
        self.delegations.deferred[component].push_back(Message::OutsideRequest(request));
        None
    }

    /// Aborts an outside request, as soon as the tasks of its component are recalled.
    pub(in crate::live) fn defer_abort(&mut self, id: u64) {
        let Some(component) = self.component_of_request(id) else {
            return self.aborts.push(id);
        };
        let all: Vec<usize> = (self.delegations.tasks.iter())
            .filter(|task| task.component == component && self.goes_on(task))
            .map(|task| task.executor)
            .collect();
        if all.is_empty() && self.delegations.deferred[component].is_empty() {
            return self.aborts.push(id);
        }
        for executor in all {
            self.recall(executor);
        }
        self.delegations.deferred[component].push_back(Message::Abort(id));
    }

    fn component_of_request(&self, id: u64) -> Option<ComponentId> {
        let instances = self.places.iter().chain(&self.pending).flatten();
        let mut of_instances = instances.filter(|instance| instance.wanted == Some(id));
        if let Some(instance) = of_instances.next() {
            return Some(self.system.services[instance.service].component);
        }
        let waits = |component: &ComponentId| {
            let mut wanted = self.wanted[*component].iter();
            let mut deferred = self.delegations.deferred[*component].iter();
            wanted.any(|request| request.id == id)
                || deferred.any(|message| {
                    matches!(message, Message::OutsideRequest(request) if request.id == id)
                })
        };
        self.system.components.keys().find(waits)
    }

    /// Returns the requests from outside that wait for recalls of a component.
    pub(in crate::live) fn take_deferred(&mut self, component: ComponentId) -> Vec<u64> {
        let deferred = std::mem::take(&mut self.delegations.deferred[component]);
        let ids = deferred.into_iter().filter_map(|message| match message {
            Message::OutsideRequest(request) => Some(request.id),
            _ => None,
        });
        ids.collect()
    }
}
