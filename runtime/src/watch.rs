//! What a run tells to whoever watches it.

use dotgen_timing::explore::{Action, Seen, Stepper};

/// Whoever watches a run.
pub trait Watch {
    /// Something was seen; the stepper is past it.
    fn see(&mut self, stepper: &Stepper, seen: &Seen);

    /// Something is about to be done.
    fn act(&mut self, stepper: &Stepper, action: Action);

    /// Somebody outside interrupts the activity that has a place.
    fn interrupt(&mut self, stepper: &Stepper, place: usize);

    /// Time has passed.
    fn moment(&mut self, stepper: &Stepper);

    /// An output port of a component has new data.
    fn wrote(&mut self, stepper: &Stepper, written: &Published);

    /// A codel that is executed did what it must not.
    fn broke(&mut self, stepper: &Stepper, broken: Broken);

    /// Whether to end the run.
    fn is_over(&self) -> bool;
}

/// Something that codels did and must not.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Broken {
    /// A codel ended with something that it does not declare.
    Undeclared {
        /// `component.owner.state`
        codel: String,
        /// The function.
        function: String,
        /// Full name of the event; empty where it is none at all.
        event: String,
    },
    /// A component is gone, with its codel.
    Lost {
        /// The component.
        component: String,
        /// What it executed: the codel and its function.
        codel: Option<(String, String)>,
        /// How it ended.
        why: String,
    },
    /// A codel took longer than it states.
    Overrun {
        /// `component.owner.state`
        codel: String,
        /// The function.
        function: String,
        /// Nanoseconds that it took.
        took: u64,
        /// Nanoseconds that it states.
        limit: u64,
    },
}

/// New data of an output port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Published {
    /// The component of the system.
    pub component: usize,
    /// The port, by number in its model.
    pub port: u32,
    /// Its instance, for a port that is `multiple`.
    pub id: String,
    /// The bytes of the value.
    pub data: Vec<u8>,
}
