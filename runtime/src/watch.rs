//! The interface for observers of a run.

use dotgen_analysis::model::PortId;
use dotgen_timing::explore::{Action, Seen, Stepper, Work};
use dotgen_timing::system::ComponentId;

use crate::end::End;

/// Observes a run.
pub trait RunObserver {
    /// Receives an event. The stepper has performed it.
    fn on_event(&mut self, stepper: &Stepper, seen: &Seen);

    /// Receives an action before it is performed; for the end of a codel that a host has executed on the real
    /// clock, with its execution time in nanoseconds: without what the exchange of messages takes.
    fn on_action(&mut self, stepper: &Stepper, action: Action, executed: Option<u64>);

    /// Receives an interruption of an activity from outside, by the place of the activity.
    fn interrupt(&mut self, stepper: &Stepper, place: usize);

    /// Receives the beginning of the end of the run, with its reason: components are shut down from here on,
    /// and no check is observed any more. Comes again when the shutdown goes on past tasks that were never
    /// started.
    fn on_ending(&mut self, stepper: &Stepper, end: End);

    /// Is called after time has passed.
    fn moment(&mut self, stepper: &Stepper);

    /// Receives a write of an output port.
    fn on_port_write(&mut self, _stepper: &Stepper, _component: ComponentId, _port: PortId) {}

    /// Receives new data of an output port.
    fn on_port_update(&mut self, stepper: &Stepper, written: &PortUpdate);

    /// Receives a violation by a codel.
    fn on_violation(&mut self, stepper: &Stepper, broken: CodelViolation);

    /// Returns why the run must end, if it must.
    fn is_over(&self, stepper: &Stepper) -> Option<End>;

    /// Returns whether the event of a measure has come, if the work is its wait for it; `None` for other
    /// work.
    fn measure(&self, _work: &Work) -> Option<bool> {
        None
    }
}

#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum CodelViolation {
    /// A codel ended with an undeclared event.
    Undeclared {
        /// `component.owner.state`
        codel: String,
        function: String,
        /// Full name of the event; empty if the value is not an event.
        event: String,
    },
    /// The process of a component has ended, with its codels.
    Lost {
        component: String,
        /// Codel and function under way.
        codel: Option<(String, String)>,
        /// Reason, in words.
        why: String,
    },
    /// A codel took longer than its stated execution time.
    Overrun {
        /// `component.owner.state`
        codel: String,
        function: String,
        /// Execution time, in nanoseconds.
        took: u64,
        /// Stated execution time, in nanoseconds.
        limit: u64,
        /// The same execution was reported before it ended.
        #[serde(skip)]
        known: bool,
    },
}

/// New data of an output port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortUpdate {
    /// Component of the system.
    pub component: ComponentId,
    /// Port, by number in the model of the component.
    pub port: PortId,
    /// Instance, if the port is `multiple`.
    pub id: String,
    /// Bytes of the value.
    pub data: Vec<u8>,
}
