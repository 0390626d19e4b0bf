//! Lints: state machines, data flow, locks, timing, services, style.
//!
//! Each rule is a pure function of one component of the model. Each rule has a code; `codes` describes them,
//! and the manual pages are generated from there. The defaults are quiet on healthy specifications: a warning
//! must be something its author would want to change, a hint may be a matter of taste.

mod data_flow;
mod locks;
mod services;
mod state_machine;
mod style;
mod timing;
mod unused;

use crate::config::LintConfig;
use crate::finding::{
    Finding,
    lints::{CodelName, LintWarning},
};
use crate::model::{
    Codel, CodelRef, Component, ComponentKind, Owner, OwnerName, Seconds, Spec, Src, TaskId,
};

pub use unused::unused;

/// Checks one component. Interfaces are incomplete by nature and never reported.
pub fn component(spec: &Spec, component: &Component, config: &LintConfig) -> Vec<Finding> {
    let mut lint = Lint { spec, component, config, found: Vec::new() };
    if component.kind == ComponentKind::Component {
        state_machine::check(&mut lint);
        data_flow::check(&mut lint);
        locks::check(&mut lint);
        timing::check(&mut lint);
        services::check(&mut lint);
    }
    style::check(&mut lint);
    lint.found
}

/// One component under examination.
struct Lint<'a> {
    spec: &'a Spec,
    component: &'a Component,
    config: &'a LintConfig,
    found: Vec<Finding>,
}

impl<'a> Lint<'a> {
    /// Reports a finding with the default severity of its code.
    fn report(&mut self, at: Src, kind: LintWarning) -> &mut Finding {
        self.found.push(Finding::new(kind, at));
        let last = self.found.len() - 1;
        &mut self.found[last]
    }

    fn owner_name(&self, owner: Owner) -> OwnerName {
        OwnerName::of(self.component, owner)
    }

    /// The task in which the machine of an owner runs.
    fn task_of(&self, owner: Owner) -> Option<TaskId> {
        match owner {
            Owner::Task(i) => Some(i),
            Owner::Service(i) => self.component.services[i].task,
        }
    }

    /// The period of the task in which the machine of an owner runs.
    fn period_of(&self, owner: Owner) -> Option<Seconds> {
        let task = &self.component.tasks[self.task_of(owner)?];
        task.period.as_ref().map(|p| p.value)
    }

    fn codel(&self, codel: CodelRef) -> &'a Codel {
        self.component.codel(codel)
    }

    fn codel_name(&self, codel: CodelRef) -> CodelName {
        CodelName { name: self.codel(codel).name.clone(), owner: self.owner_name(codel.owner) }
    }

    /// Returns true if any codel of the component has an execution time.
    fn has_timing(&self) -> bool {
        self.component.all_codels().any(|codel| self.codel(codel).wcet.is_some())
    }
}
