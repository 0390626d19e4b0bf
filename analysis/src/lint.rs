//! Findings no compiler gives: state machines, data flow, locks, timing, services, style.
//!
//! Each rule is a pure function of one component of the model, so that an edit re-checks one
//! component only. A rule owns a code; [`codes`] says what each means, and the manual pages are
//! generated from there. The defaults are quiet on healthy specifications: a warning must be
//! something its author would want to change, a hint may be a matter of taste.

pub mod codes;
mod data_flow;
mod locks;
mod services;
mod state_machine;
mod style;
mod timing;
mod unused;

use num_rational::Ratio;

use crate::finding::{
    Finding,
    codels::OwnerName,
    lints::{CodelName, Noticing},
};
use crate::model::{Codel, CodelRef, Component, ComponentKind, Owner, Seconds, Spec, Src};

pub use unused::unused;

/// What the rules need to know besides the model.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct LintConfig {
    /// Cores of the platform, when known.
    pub cores: Option<u32>,
    /// Report codels without execution time even in components without any.
    pub always_missing_wcet: bool,
    /// Longest time the control task may be kept from other requests by one function, in seconds.
    pub control_task_budget: Seconds,
}

impl LintConfig {
    /// An exact time from a number of milliseconds in a configuration; `None` when it is not a time.
    pub fn milliseconds(value: f64) -> Option<Seconds> {
        let micros = (value * 1000.0).round();
        (micros.is_finite() && (0.0..1e15).contains(&micros))
            .then(|| Ratio::new(micros as i128, 1_000_000))
    }
}

impl Default for LintConfig {
    fn default() -> LintConfig {
        LintConfig {
            cores: None,
            always_missing_wcet: false,
            control_task_budget: Ratio::new(1, 100),
        }
    }
}

/// Checks one component (nothing is reported for interfaces, which are incomplete by nature).
pub fn component(spec: &Spec, component: &Component, config: &LintConfig) -> Vec<Finding> {
    let mut lint = Lint {
        spec,
        component,
        config,
        found: Vec::new(),
    };
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
    fn report(&mut self, at: Src, kind: Noticing) -> &mut Finding {
        self.found.push(Finding::new(kind, at));
        let last = self.found.len() - 1;
        &mut self.found[last]
    }

    /// Tasks, then services, of the component.
    fn owners(&self) -> impl Iterator<Item = Owner> + use<> {
        let tasks = (0..self.component.tasks.len() as u32).map(Owner::Task);
        tasks.chain((0..self.component.services.len() as u32).map(Owner::Service))
    }

    fn owner_name(&self, owner: Owner) -> OwnerName {
        OwnerName::of(self.component, owner)
    }

    /// The task in which the machine of an owner runs.
    fn task_of(&self, owner: Owner) -> Option<u32> {
        match owner {
            Owner::Task(i) => Some(i),
            Owner::Service(i) => self.component.services[i as usize].task,
        }
    }

    /// The period of the task in which the machine of an owner runs.
    fn period_of(&self, owner: Owner) -> Option<Seconds> {
        let task = &self.component.tasks[self.task_of(owner)? as usize];
        task.period.as_ref().map(|p| p.value)
    }

    fn codel(&self, it: CodelRef) -> &'a Codel {
        self.component.codel(it)
    }

    fn codel_name(&self, it: CodelRef) -> CodelName {
        CodelName {
            name: self.codel(it).name.clone(),
            owner: self.owner_name(it.owner),
        }
    }

    /// Whether any codel of the component has an execution time.
    fn has_timing(&self) -> bool {
        self.component
            .all_codels()
            .any(|it| self.codel(it).wcet.is_some())
    }
}

/// A duration as [`crate::quantity::time`] writes it.
pub fn duration(seconds: Seconds) -> String {
    crate::quantity::time(seconds)
}
