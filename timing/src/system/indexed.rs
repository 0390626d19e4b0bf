//! The result of a build: a [`TimedSystem`], its connection to the specifications, and its assumptions.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use dotgen_analysis::model::{self, Owner, Seconds};

use super::{Automaton, TimedSystem};
use crate::diagnostic::{Diagnostic, Severity};
use crate::scn::ast::Path;
use crate::system::data::DataFact;
use crate::system::ground::Condition;
use crate::system::{ClientId, ComponentId, MachineId, ServiceId, TaskId};

/// A task of a specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DeclaredTask {
    /// Component, as in [`Names::components`](crate::scn::names::Names::components).
    pub component: usize,
    /// Index in the component.
    pub index: model::TaskId,
}

/// A system, with tables that find its parts.
#[derive(Debug, Clone)]
pub struct Built {
    pub system: TimedSystem,
    /// Tasks, by declaration.
    pub tasks: HashMap<DeclaredTask, TaskId>,
    /// Services, by component and index.
    pub services: HashMap<(usize, model::ServiceId), ServiceId>,
    /// Machines of tasks and activities.
    pub machines: HashMap<(usize, Owner), MachineId>,
    /// Components, by index in the scenario.
    pub components: HashMap<usize, ComponentId>,
    /// Activities that no client requests, and that have no slots therefore.
    pub unrequested: Vec<Unrequested>,
    pub measures: Vec<Measure>,
    /// The comparisons of data in checks; `None` where no run supplies data.
    pub data: Option<Vec<DataFact>>,
    /// Problems found. Without errors, verification goes on.
    pub diagnostics: Vec<Diagnostic>,
    /// Assumptions on which the result depends, in words.
    pub assumptions: Vec<String>,
    /// What the result rests on although it is not stated.
    pub conditions: Vec<Condition>,
    /// Codels whose times were rounded, because they are not multiples of the unit of the scenario.
    pub rounded: Vec<Rounded>,
    /// The coarsest unit in which no time has to be rounded, in seconds; `None` if the scenario states no
    /// unit.
    pub exact_unit: Option<Seconds>,
    /// The system as the runs of its checks keep it, once one does.
    pub(crate) shared: OnceLock<Arc<TimedSystem>>,
}

/// A client that waits for an event of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Measure {
    pub client: ClientId,
    /// Events, any of which begins it.
    pub events: Vec<MeasureEvent>,
    /// The run ends after its last step.
    pub stops: bool,
}

/// An event that begins a measure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MeasureEvent {
    /// A codel takes longer than its time: `component.owner.state`.
    LateCodel(String),
    /// A codel of the task takes longer than its time, or the task misses a deadline: `component.task`.
    LateTask(String),
    /// A check is violated: its name.
    Violation(String),
    /// The process of a component has ended.
    Lost(String),
    /// An output port was written once, and then not for some time.
    Stale {
        component: ComponentId,
        /// Port, by number.
        port: model::PortId,
        /// That time, in seconds.
        after: Seconds,
    },
}

/// An activity that no client requests, with what its slots would be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unrequested {
    /// The activity.
    pub service: ServiceId,
    /// The automaton of each slot.
    pub automaton: Automaton,
    /// Number of slots.
    pub slots: u32,
}

/// The rounded time of a codel, in seconds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rounded {
    /// Path of the codel.
    pub codel: String,
    /// Stated time.
    pub exact: Seconds,
    /// Time used for verification.
    pub taken: Seconds,
}

impl Built {
    /// Returns the system for runs that are kept. It is copied once, so the system must not change
    /// afterwards.
    pub(crate) fn shared(&self) -> Arc<TimedSystem> {
        Arc::clone(self.shared.get_or_init(|| Arc::new(self.system.clone())))
    }

    /// Gives the activities that no client requests their slots, for requests that the scenario does not
    /// foresee.
    pub fn add_slots(&mut self) {
        for Unrequested { service, automaton, slots } in std::mem::take(&mut self.unrequested) {
            for _ in 0..slots {
                let slot = self.system.automata.push_and_get_key(automaton);
                self.system.services[service].slots.push(slot);
                self.system.tasks[automaton.task].slots.push(slot);
            }
        }
    }

    /// Returns true if an error prevents verification.
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }
}

/// Returns the error for a path that leads to something other than `what`.
pub(crate) fn not_a(what: &str, path: &Path) -> Diagnostic {
    let message = format!("`{}` is no {what}", path.text());
    Diagnostic::error("scn-wrong-kind", path.range(), message)
}
