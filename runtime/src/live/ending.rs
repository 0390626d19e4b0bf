//! The end of a run, as far as it concerns requests and hosts.

use std::time::Duration;

use dotgen_timing::explore::Stepper;
use dotgen_timing::system::ComponentId;
use num_rational::Ratio;

use super::{Live, requests};

impl Live<'_> {
    /// Sets the longest end of a run.
    pub fn set_stop_within(&mut self, within: Duration) {
        self.stop_within = within;
    }

    /// Sets the time in which a host that executes cycles must answer. One that does not is ended.
    pub fn set_host_within(&mut self, within: Duration) {
        self.host_within = within;
    }

    /// Returns the longest end of a run.
    pub(crate) fn stop_within(&self) -> Duration {
        self.stop_within
    }

    /// Converts a time to base units, at least one.
    pub(crate) fn base_units(&self, time: Duration) -> u64 {
        let nanos = i128::try_from(time.as_nanos()).unwrap_or(i128::MAX / 2);
        let units = Ratio::new(nanos, 1_000_000_000) / self.system.unit;
        u64::try_from(units.to_integer()).unwrap_or(u64::MAX).max(1)
    }

    /// Returns what has not ended within the bound.
    pub fn unfinished(&self) -> &[String] {
        &self.unfinished
    }

    /// Refuses further requests, and recalls the threads that execute cycles by themselves.
    pub(crate) fn begin_ending(&mut self) {
        self.ending = true;
        let components: Vec<ComponentId> = self.system.components.keys().collect();
        for component in components {
            let mut refused: Vec<u64> =
                self.wanted[component].drain(..).map(|request| request.id).collect();
            refused.extend(self.take_deferred(component));
            for id in refused {
                self.answer_failed(id, requests::STOPPING);
            }
        }
        self.recall_all();
    }

    /// Returns true if every component with executed codels has been shut down, or is lost. Simulated ones
    /// have nothing to stop.
    pub(crate) fn has_ended(&self, stepper: &Stepper) -> bool {
        self.system.components.keys().all(|component| !self.has_to_end(component, stepper))
    }

    fn has_to_end(&self, component: ComponentId, stepper: &Stepper) -> bool {
        self.parts.of(component).is_some()
            && self.is_alive(component)
            && !stepper.is_shut_down(component)
    }

    /// Notes the codels that are executed, or else the components that have not ended.
    pub(crate) fn note_unfinished(&mut self, stepper: &Stepper) {
        let running = self.running.iter().flatten();
        let running = running.filter(|running| running.real && running.ran.is_none());
        let codels = running.filter_map(|running| running.work.codel());
        let mut out: Vec<String> =
            codels.map(|codel| self.system.codels[codel].path.to_string()).collect();
        if out.is_empty() {
            let components = self.system.components.iter_enumerated();
            let left = components.filter(|(id, _)| self.has_to_end(*id, stepper));
            out.extend(left.map(|(_, component)| component.name.clone()));
        }
        self.unfinished.append(&mut out);
        self.unfinished.sort_unstable();
        self.unfinished.dedup();
    }
}
