//! The model follows the reports of the threads that execute their cycles by themselves.

use dotgen_timing::explore::Stepper;
use dotgen_timing::system::{CodelId, ComponentId, Ticks};

use super::{Live, MAX_RESULTS, Recall, lane};
use crate::hosts::CodelResult;

impl Live<'_> {
    /// Keeps the result of a codel that a thread has executed by itself, until the model reaches its time.
    /// Returns any other result.
    pub(in crate::live) fn keep_delegated(
        &mut self,
        component: ComponentId,
        ran: CodelResult,
    ) -> Option<CodelResult> {
        let (time, executor) = (self.delegations.time, ran.ticket as usize);
        let (Some(time), Some(delegated)) = (time, self.delegations.of(executor)) else {
            return Some(ran);
        };
        if delegated.component == component && delegated.recall != Recall::Over {
            delegated.known = delegated.known.max(time.ticks(ran.ended));
            delegated.results.push_back(ran);
            if delegated.results.len() > MAX_RESULTS {
                self.end_component(component, "sent more results than it had ticks");
            }
        }
        None
    }

    fn end_component(&mut self, component: ComponentId, why: &str) {
        self.hosts.kill(component);
        self.lost(component, why.to_owned());
    }

    /// Handles the answer to a probe.
    pub(in crate::live) fn probed(&mut self, component: ComponentId, probe: u32, until: u64) {
        let Some(time) = self.delegations.time else {
            return;
        };
        let mut tasks = self.delegations.tasks.iter_mut();
        let asked = tasks.find(|task| {
            task.component == component && task.probed.is_some_and(|(number, _)| number == probe)
        });
        let Some(delegated) = asked else { return };
        delegated.probed = None;
        delegated.known = delegated.known.max(time.ticks(until));
        if delegated.recall == Recall::Asked {
            delegated.recall = Recall::PassedOn;
        }
        self.admit(component);
    }

    /// Ends codels that threads have executed by themselves, if the model has reached their times. `now` is
    /// the time of the model, in base units.
    pub(crate) fn deliver(&mut self, now: u64) {
        self.delegations.now = now;
        let Some(time) = self.delegations.time else {
            return;
        };
        let tasks = self.delegations.tasks.iter();
        let executors: Vec<usize> = tasks.map(|delegated| delegated.executor).collect();
        for executor in executors {
            if !self.is_running(executor) {
                continue;
            }
            let Some(delegated) = self.delegations.of(executor) else {
                continue;
            };
            let component = delegated.component;
            let due = |ran: &mut CodelResult| time.ticks(ran.ended) <= now;
            let Some(ran) = delegated.results.pop_front_if(due) else {
                continue;
            };
            let Some(Some(running)) = self.running.get_mut(executor) else {
                continue;
            };
            let wanted = running.work.codel();
            if wanted.and_then(|codel| self.parts.codel(codel)) != Some(ran.codel) {
                let why = "executed another codel than the model: this is a defect of dotgen";
                self.end_component(component, why);
                continue;
            }
            running.ran = Some(ran);
            self.measure(executor);
            self.settle(executor);
        }
    }

    /// Returns the time, in base units, until the model ends the next codel that a thread has executed by
    /// itself.
    pub(crate) fn next_result(&self) -> Option<u64> {
        let time = self.delegations.time?;
        let tasks = self.delegations.tasks.iter();
        let running = tasks.filter(|delegated| self.is_running(delegated.executor));
        let ends = running.filter_map(|delegated| Some(delegated.results.front()?.ended));
        let least = ends.map(|ended| time.ticks(ended)).min()?;
        Some(least.saturating_sub(self.delegations.now))
    }

    /// Recalls the tasks that wait for locks in the model, at a moment without possible actions: their
    /// threads do not wait.
    pub(super) fn recall_waiting(&mut self, stepper: &Stepper) {
        let tasks = self.delegations.tasks.iter();
        let waiting = tasks.filter(|task| {
            let executor = task.executor;
            stepper.work(executor).is_some() && stepper.window(executor).is_none()
        });
        let waiting: Vec<usize> = waiting.map(|task| task.executor).collect();
        for executor in waiting {
            self.recall_for_a_while(executor);
        }
    }

    /// Asks a thread for its results if its present codel began more than `after` nanoseconds before the
    /// present time of the hosts, `now`. Returns true if such a question will be due.
    pub(crate) fn probe_long(&mut self, now: u64, after: u64) -> bool {
        let Some(time) = self.delegations.time else {
            return false;
        };
        let mut due = false;
        let mut late = Vec::new();
        for task in &self.delegations.tasks {
            let from = time.nanos(task.begun).saturating_add(after);
            let is_known = time.nanos(task.known) >= from || !task.results.is_empty();
            let is_asked = task.probed.is_some() || task.recall == Recall::Over || task.lost;
            if is_known || is_asked || !self.is_running(task.executor) {
                continue;
            }
            due = true;
            if now >= from {
                late.push(task.executor);
            }
        }
        for executor in late {
            self.probe(executor);
        }
        due
    }

    /// Asks a thread for its results.
    pub(super) fn probe(&mut self, executor: usize) {
        let now = self.hosts.now();
        self.delegations.probes = self.delegations.probes.wrapping_add(1);
        let probe = self.delegations.probes;
        if let Some(task) = self.delegations.of(executor) {
            task.probed = Some((probe, now));
            let (component, lane) = (task.component, lane(task.task));
            self.hosts.probe(component, lane, probe);
        }
    }

    /// Returns the greatest time that may pass in the model, in base units: it must not pass a tick that
    /// counts together with an earlier one before the thread has reported all until then. `now` is the time
    /// of the hosts, in nanoseconds. A component whose host does not answer is ended.
    pub fn hold(&mut self, stepper: &Stepper, now: u64) -> Option<Ticks> {
        let time = self.delegations.time?;
        // Meanwhile the model may stand still.
        let within = u64::try_from(self.host_within.as_nanos()).unwrap_or(u64::MAX);
        let mut most = None;
        let (mut silent, mut unknown) = (Vec::new(), Vec::new());
        for task in &self.delegations.tasks {
            if task.recall == Recall::Over || task.lost {
                continue;
            }
            let overdue = |(_, since): (u32, u64)| now.saturating_sub(since) >= within;
            if task.probed.is_some_and(overdue) {
                silent.push(task.component);
                continue;
            }
            let Some((until, true)) = stepper.tick(task.task) else {
                continue;
            };
            let tick = stepper.now() + u64::from(until);
            if tick <= task.known || !task.results.is_empty() {
                continue;
            }
            let before = until.saturating_sub(1);
            most = Some(most.map_or(before, |most: Ticks| most.min(before)));
            if now >= time.nanos(tick) && task.probed.is_none() {
                unknown.push(task.executor);
            }
        }
        for executor in unknown {
            self.probe(executor);
        }
        for component in silent {
            let why = format!("did not answer within {} s", self.host_within.as_secs_f64());
            self.end_component(component, &why);
        }
        most
    }

    /// Expects no further reports of the threads of a component.
    pub(crate) fn expect_loss(&mut self, component: ComponentId) {
        for delegated in &mut self.delegations.tasks {
            delegated.lost |= delegated.component == component;
        }
    }

    /// Ends the delegations of a lost component. Returns their executors, and the codel that one of their
    /// threads was executing, with its function.
    pub(in crate::live) fn end_delegations(
        &mut self,
        component: ComponentId,
    ) -> (Vec<usize>, Option<(String, String)>) {
        let tasks = &self.delegations.tasks;
        let own = || tasks.iter().filter(|task| task.component == component);
        let mut active = own().filter(|task| task.recall != Recall::Over);
        let culprit = active.find_map(|task| {
            let (number, _) = self.hosts.executing(component, lane(task.task))?;
            let is_it = |codel: &&CodelId| self.parts.codel(**codel) == Some(number);
            let codel = *task.codels.iter().find(is_it)?;
            let path = self.system.codels[codel].path.to_string();
            Some((path, self.parts.function(codel)))
        });
        let executors: Vec<usize> = own().map(|task| task.executor).collect();
        let delegations = &mut self.delegations;
        delegations.tasks.retain(|task| task.component != component);
        let postponed = &mut delegations.postponed;
        postponed.retain(|(call, _)| call.component != component);
        // Calls of other components no longer wait for its tasks.
        self.unblock(&executors);
        (executors, culprit)
    }
}
