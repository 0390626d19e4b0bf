//! All derived questions about a scenario, the most useful first.

use serde::Serialize;

use super::{DerivationContext, DerivedValue, Extreme, MinimumCores, Parameter};
use crate::analytic::response_bounds;
use crate::diagnostic::Diagnostic;
use crate::questions;
use crate::report::Value;
use crate::scn::ast::{Path, Scenario};
use crate::scn::names::Names;
use crate::system::build::build;
use crate::system::{CodelId, FOREVER, MachineId, TaskId, TimedSystem};
use crate::verify::{Cancel, Options, SystemInput, settings};

/// The sensitivity of a system: its distance from missing a deadline, or from meeting all of them.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Sensitivity {
    /// The smallest number of cores.
    pub minimum_cores: MinimumCores,
    /// The largest WCET of each codel that has a bound, with all others unchanged.
    pub wcet: Vec<Extreme>,
    /// The smallest period of each periodic task, with all others unchanged.
    pub period: Vec<Extreme>,
    /// The most critical value, among those that hold now.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_to_break: Option<NextToBreak>,
    /// The analysis was cancelled: answers are missing.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub incomplete: bool,
}

/// The value that needs the smallest factor to miss a deadline.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NextToBreak {
    /// Kind of value.
    pub quantity: Quantity,
    /// Codel or task.
    pub of: String,
    /// Present value, in the unit of the report.
    pub now: Value,
    /// Last value with which every deadline is known to be met.
    pub extreme: Value,
    /// The greater of the two values divided by the smaller.
    pub factor: f64,
}

/// The kind of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Quantity {
    /// The longest execution time of a codel.
    Wcet,
    /// The period of a task.
    Period,
}

/// The progress of [`sensitivity`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Progress {
    /// Number of questions answered.
    pub done: usize,
    /// Number of all questions.
    pub of: usize,
    /// Present question, in words.
    pub asking: String,
}

/// An intermediate result of [`sensitivity`].
#[derive(Debug, Clone, Copy)]
pub enum InterimResult<'a> {
    /// The next question.
    Asking(&'a Progress),
    /// An answer about cores.
    Cores(&'a MinimumCores),
    /// An answer about the WCET of a codel.
    Wcet(&'a Extreme),
    /// An answer about the period of a task.
    Period(&'a Extreme),
}

/// Answers every derived question about a scenario, the most useful first: the tasks that are nearest to
/// their deadlines by response-time analysis, and their codels, the longest first. Codels that are never
/// executed are left out. The analysis takes as long as a few dozen verifications for each codel and task; as
/// many run at the same time as there are threads. Answers are reported in this order, each as soon as
/// possible.
pub fn sensitivity(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    cancel: &Cancel,
    tell: &(dyn Fn(InterimResult) + Sync),
) -> Result<Sensitivity, Vec<Diagnostic>> {
    let names = Names::new(&input.specs);
    let system = build(&names, &settings(scenario, options), &|_| true).system;
    let questions = questions(&system, cancel);
    let asked = DerivationContext::of(questions.len(), &names, scenario, options, cancel);
    let answers = questions::all(
        &questions,
        asked.together,
        cancel,
        &|done, parameter| {
            tell(InterimResult::Asking(&Progress {
                done,
                of: questions.len(),
                asking: parameter.describe(),
            }));
        },
        &|parameter| asked.one(parameter),
        &|derived_value| match derived_value {
            Ok(DerivedValue::Cores(core)) => tell(InterimResult::Cores(core)),
            Ok(DerivedValue::Wcet(wcet)) => tell(InterimResult::Wcet(wcet)),
            Ok(DerivedValue::Period(period)) => tell(InterimResult::Period(period)),
            Err(_) => {}
        },
    );
    let mut out = Sensitivity {
        minimum_cores: MinimumCores { cores: None, tried: Vec::new() },
        wcet: Vec::new(),
        period: Vec::new(),
        next_to_break: None,
        incomplete: false,
    };
    for answer in answers.into_iter().flatten() {
        match answer? {
            DerivedValue::Cores(core) => out.minimum_cores = core,
            DerivedValue::Wcet(wcet) => out.wcet.push(wcet),
            DerivedValue::Period(period) => out.period.push(period),
        }
    }
    out.next_to_break = out.next_to_break();
    out.incomplete = cancel.is_over();
    Ok(out)
}

/// Returns the questions, in the order of [`sensitivity`].
fn questions(system: &TimedSystem, cancel: &Cancel) -> Vec<Parameter> {
    let bounds = response_bounds(system, cancel);
    // The part of its period that a task may take; a task without a bound comes first.
    let near = |task: TaskId| match (system.tasks[task].period, bounds[task]) {
        (None, _) => 0.0,
        (Some(_), None) => f64::INFINITY,
        (Some(period), Some(bound)) => f64::from(bound) / f64::from(period),
    };
    let mut tasks: Vec<TaskId> = system.tasks.keys().collect();
    tasks.sort_by(|&a, &b| near(b).total_cmp(&near(a)));
    let executed = system.executed();
    let asked = |id: &CodelId| {
        let codel = &system.codels[*id];
        executed[*id] && codel.site.is_some() && codel.upper != FOREVER
    };
    let mut codels: Vec<CodelId> = system.codels.keys().filter(asked).collect();
    codels.sort_by_key(|&codel| std::cmp::Reverse(system.codels[codel].upper));
    let mut out = vec![Parameter::Cores];
    for task in tasks {
        if system.tasks[task].period.is_some() {
            out.push(Parameter::Period(Path::of(&system.task_path(task))));
        }
        let automata = system.automata.iter().filter(|automaton| automaton.task == task);
        let machines: Vec<MachineId> = automata.map(|automaton| automaton.machine).collect();
        let is_own = |codel: &CodelId| {
            let mut states = machines.iter().flat_map(|&machine| &system.machines[machine].states);
            states.any(|state| state.codel == *codel)
        };
        let (own, others) = codels.into_iter().partition(is_own);
        codels = others;
        let own: Vec<CodelId> = own;
        let of = |codel: &CodelId| Parameter::Wcet(Path::of(&system.codels[*codel].path));
        out.extend(own.iter().map(of));
    }
    // Codels of control tasks.
    let rest = codels.iter();
    out.extend(rest.map(|&codel| Parameter::Wcet(Path::of(&system.codels[codel].path))));
    out
}

impl Sensitivity {
    /// Returns the most critical value, among those that hold now and have a limit: the WCET or the period
    /// that can change by the smallest factor.
    fn next_to_break(&self) -> Option<NextToBreak> {
        let factor = |limit: &Extreme| match (limit.now, limit.extreme) {
            (Value::Time(now), Some(Value::Time(extreme))) if !limit.fails_now && now > 0.0 => {
                Some((extreme / now).max(now / extreme.max(f64::MIN_POSITIVE)))
            }
            _ => None,
        };
        let wcet = self.wcet.iter().map(|wcet| (wcet, Quantity::Wcet));
        let period = self.period.iter().map(|period| (period, Quantity::Period));
        let known = wcet.chain(period).filter_map(|(extreme, quantity)| {
            Some(NextToBreak {
                quantity,
                of: extreme.of.clone(),
                now: extreme.now,
                extreme: extreme.extreme?,
                factor: factor(extreme)?,
            })
        });
        known.min_by(|a, b| a.factor.total_cmp(&b.factor))
    }
}
