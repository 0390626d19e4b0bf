//! What a run found, as data. The JSON form is part of the interface of `dotgen run`.

use dotgen_timing::property::PropertyKind;
use dotgen_timing::report::Value;
use dotgen_timing::system::Ticks;
use dotgen_timing::verify::Prepared;
use serde::Serialize;

use crate::counted::{OfMachine, OfTask, machines, tasks};
use crate::decide::Durations;
use crate::engine::End;
use crate::judge::{Moment, Verdict, Violation};
use crate::simulation::{Outcome, Plan};
use crate::watch::Broken;

/// Version of the JSON form: raised when a field changes its meaning or goes.
pub const FORMAT: u32 = 1;

/// What a run found. All times are in the unit of the report.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct RunReport {
    /// Version of the form.
    pub format: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// What the model follows.
    pub semantics: String,
    /// Unit of all times.
    pub unit: String,
    /// What chance depended on.
    pub seed: u64,
    /// How long codels took.
    pub durations: Durations,
    /// How many runs there were, each from the start.
    pub runs: u64,
    /// Time that all runs took together.
    pub time: Value,
    /// How the last run ended.
    pub end: End,
    /// Tasks, in order of declaration.
    pub tasks: Vec<OfTask>,
    /// Services likewise.
    pub services: Vec<OfService>,
    /// Codels likewise.
    pub codels: Vec<OfCodel>,
    /// State machines, with all their transitions.
    pub machines: Vec<OfMachine>,
    /// Checks, in order of the scenario.
    pub checks: Vec<OfCheck>,
    /// The first of each kind.
    pub violations: Vec<OfViolation>,
    /// All of them.
    pub violation_count: u64,
    /// What the model assumes.
    pub assumptions: Vec<String>,
    /// What else is worth knowing.
    pub notes: Vec<String>,
}

/// A service.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct OfService {
    /// `component.service`
    pub service: String,
    /// Requests taken.
    pub requests: u64,
    /// Refused by a codel, or ended by its exception.
    pub refused: u64,
    /// Activities that have ended.
    pub ended: u64,
}

/// A codel.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct OfCodel {
    /// `component.owner.state`
    pub codel: String,
    /// How often it was executed.
    pub runs: u64,
    /// The greatest time of that.
    pub greatest: Value,
    /// The greatest time it waited for its locks.
    pub waited: Value,
}

/// A check.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct OfCheck {
    /// Its name, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What kind of property it asks for.
    pub check: PropertyKind,
    /// The task, or the predicates, in words.
    pub of: String,
    /// What the run says.
    pub verdict: Verdict,
    /// The greatest time that it asks for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub greatest: Option<Value>,
    /// The limit of that: the stated one, or else the period of the task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<Value>,
    /// Whether the greatest time is beyond the limit. Beyond a period, nothing is violated.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub exceeded: bool,
    /// When the verdict was known first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<At>,
    /// How often it was violated.
    pub violations: u64,
}

/// A moment.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct At {
    /// Which run, from 1.
    pub run: u64,
    /// The seed with which this run is the first.
    pub seed: u64,
    /// Time since its start.
    pub time: Value,
}

/// A violation.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct OfViolation {
    /// When.
    pub at: At,
    /// Of what.
    #[serde(flatten)]
    pub what: Violated,
}

/// What was violated.
#[derive(Debug, Clone, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Violated {
    /// A check.
    Check {
        /// Its place in the list of checks.
        check: usize,
    },
    /// A proved bound.
    BeyondBound {
        /// `component.task`
        task: String,
        /// The response time when that was seen.
        response: Value,
        /// The bound.
        bound: Value,
    },
    /// A codel ended with something that it does not declare.
    Undeclared {
        /// `component.owner.state`
        codel: String,
        /// The function.
        function: String,
        /// Full name of the event; empty where it is none at all.
        event: String,
    },
    /// A component is gone.
    Lost {
        /// The component.
        component: String,
        /// The codel that it executed.
        #[serde(skip_serializing_if = "Option::is_none")]
        codel: Option<String>,
        /// Its function.
        #[serde(skip_serializing_if = "Option::is_none")]
        function: Option<String>,
        /// How it ended.
        why: String,
    },
    /// A codel took longer than it states.
    Overrun {
        /// `component.owner.state`
        codel: String,
        /// The function.
        function: String,
        /// The greatest time that it took.
        took: Value,
        /// What it states.
        limit: Value,
    },
}

impl RunReport {
    /// Of runs that are over.
    pub fn new(
        prepared: &Prepared,
        plan: &Plan,
        outcome: &Outcome,
        bounds: &[Option<Ticks>],
    ) -> RunReport {
        let make = Maker { prepared, plan };
        let system = &prepared.built.system;
        let services = (0..system.services.len()).map(|service| {
            let counted = &outcome.tally.services[service];
            OfService {
                service: system.service_path(service),
                requests: counted.requests,
                refused: counted.refused,
                ended: counted.ended,
            }
        });
        let codels = system.codels.iter().zip(&outcome.tally.codels);
        let codels = codels.map(|(it, counted)| OfCodel {
            codel: it.path.clone(),
            runs: counted.runs.count,
            greatest: make.value(counted.runs.greatest),
            waited: make.value(counted.waits.greatest),
        });
        let mut notes = prepared.report.notes.clone();
        notes.extend(outcome.refused.iter().map(|&it| {
            let path = system.service_path(it);
            format!("a request of {path} was refused because all its slots were in use")
        }));
        RunReport {
            format: FORMAT,
            scenario: prepared.report.scenario.clone(),
            semantics: prepared.report.semantics.clone(),
            unit: prepared.report.unit.clone(),
            seed: plan.seed,
            durations: plan.durations,
            runs: outcome.runs,
            time: Value::Time(prepared.time(outcome.time)),
            end: outcome.end,
            tasks: tasks(prepared, &outcome.tally, bounds, outcome.time),
            services: services.collect(),
            codels: codels.collect(),
            machines: machines(prepared, &outcome.tally),
            checks: make.checks(outcome),
            violations: make.violations(outcome),
            violation_count: outcome.judge.count,
            assumptions: prepared.report.assumptions.clone(),
            notes,
        }
    }

    /// Whether something was violated.
    pub fn violated(&self) -> bool {
        self.violation_count > 0
    }
}

struct Maker<'r> {
    prepared: &'r Prepared,
    plan: &'r Plan,
}

impl Maker<'_> {
    fn value(&self, ticks: Ticks) -> Value {
        Value::Time(self.prepared.time(u64::from(ticks)))
    }

    fn nanos(&self, nanos: u64) -> Value {
        let unit = *self.prepared.unit.numer() as f64 / *self.prepared.unit.denom() as f64;
        Value::Time(nanos as f64 / 1e9 / unit)
    }

    fn at(&self, it: Moment) -> At {
        At {
            run: it.run + 1,
            seed: self.plan.seed.wrapping_add(it.run),
            time: Value::Time(self.prepared.time(it.time)),
        }
    }

    fn checks(&self, outcome: &Outcome) -> Vec<OfCheck> {
        let checks = self.prepared.checks.iter().zip(&outcome.judge.answers);
        let checks = checks.map(|(asked, answer)| {
            let greatest = answer.greatest.map(|it| self.value(it));
            let limit = asked.report.limit;
            OfCheck {
                name: asked.report.name.clone(),
                check: asked.report.kind,
                of: asked.report.of.clone(),
                verdict: answer.verdict,
                greatest,
                limit: limit.map(|it| Value::Time(it.time())),
                exceeded: (limit.zip(greatest)).is_some_and(|it| it.0.is_exceeded_by(it.1)),
                at: answer.at.map(|it| self.at(it)),
                violations: answer.violations,
            }
        });
        checks.collect()
    }

    fn violations(&self, outcome: &Outcome) -> Vec<OfViolation> {
        let system = &self.prepared.built.system;
        let all = outcome.judge.violations.iter();
        let all = all.map(|&(at, it)| OfViolation {
            at: self.at(at),
            what: match it {
                Violation::Check(check) => Violated::Check { check },
                Violation::BeyondBound {
                    task,
                    response,
                    bound,
                } => Violated::BeyondBound {
                    task: system.task_path(task),
                    response: self.value(response),
                    bound: self.value(bound),
                },
                Violation::Broken(at) => match &outcome.judge.broken[at] {
                    Broken::Undeclared {
                        codel,
                        function,
                        event,
                    } => Violated::Undeclared {
                        codel: codel.clone(),
                        function: function.clone(),
                        event: event.clone(),
                    },
                    Broken::Lost {
                        component,
                        codel,
                        why,
                    } => Violated::Lost {
                        component: component.clone(),
                        codel: codel.as_ref().map(|it| it.0.clone()),
                        function: codel.as_ref().map(|it| it.1.clone()),
                        why: why.clone(),
                    },
                    Broken::Overrun {
                        codel,
                        function,
                        took,
                        limit,
                    } => Violated::Overrun {
                        codel: codel.clone(),
                        function: function.clone(),
                        took: self.nanos(*took),
                        limit: self.nanos(*limit),
                    },
                },
            },
        });
        all.collect()
    }
}
