//! The report of a run, as data. The JSON form is part of the interface of `dotgen run`.

use std::hash::{DefaultHasher, Hash, Hasher};

use dotgen_analysis::model::Seconds;
use dotgen_timing::property::PropertyKind;
use dotgen_timing::report::{TimeUnit, Value};
use dotgen_timing::system::{ClientId, CodelId, TaskId, Ticks};
use dotgen_timing::verify::Prepared;
use serde::{Deserialize, Serialize};

use crate::checker::{Idle, Moment, RunChecker, Verdict, Violation};
use crate::counts::{MachineCounts, PortCounts, TaskCounts, machines, tasks};
use crate::decide::Durations;
use crate::engine::End;
use crate::estimate::{CONFIDENCE, Estimate};
use crate::port_writes::Port;
use crate::simulation::{Plan, SimulationResult};
use crate::tally::Tally;
use crate::watch::CodelViolation;

/// Version of the JSON form: raised when a field changes its meaning or is removed.
pub const FORMAT: u32 = 1;

/// The report of a run. All times are in the unit of the report.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct RunReport {
    /// Version of the JSON form.
    pub format: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// Semantics of the model.
    pub semantics: String,
    pub unit: TimeUnit,
    /// Seed of the random choices.
    pub seed: u64,
    /// Choice of execution times.
    pub durations: Durations,
    /// Checksum of the system, its times and the weights of its yields: runs of one sample have the same.
    pub model: String,
    /// Number of runs, each from the start.
    pub runs: u64,
    /// Time at which each run ends at the latest, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<Value>,
    /// Total time of all runs.
    pub time: Value,
    /// End of the last run.
    pub end: End,
    /// Codels that were still executed when a run had to end, or else components that had not ended.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unfinished: Vec<String>,
    /// Neither a violation nor the user could end the runs early, so that counts of runs are a sample.
    pub is_sample: bool,
    /// What the run says of its checks together.
    pub verdict: Verdict,
    /// Tasks, in order of declaration.
    pub tasks: Vec<TaskCounts>,
    /// Requests that no client of the scenario sends. The verified model does not have them.
    pub requests_outside_model: u64,
    /// Output ports of the components that were executed.
    pub ports: Vec<PortCounts>,
    /// Services, in order of declaration.
    pub services: Vec<ServiceCounts>,
    /// Codels, in order of declaration.
    pub codels: Vec<CodelCounts>,
    /// State machines, with all their transitions.
    pub machines: Vec<MachineCounts>,
    /// Checks, in order of the scenario.
    pub checks: Vec<CheckOutcome>,
    /// First violation of each kind.
    pub violations: Vec<ViolationReport>,
    /// Number of all violations.
    pub violation_count: u64,
    /// Assumptions of the model.
    pub assumptions: Vec<String>,
    /// Further notes.
    pub notes: Vec<String>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct ServiceCounts {
    /// `component.service`
    pub service: String,
    /// Requests taken.
    pub requests: u64,
    /// Requests refused by `after` or `before`, for lack of a slot, or by a codel or its exception.
    pub refused: u64,
    /// Activities that have ended.
    pub ended: u64,
    /// False for an attribute or a function, which has no end of its own.
    #[serde(skip_serializing, default)]
    pub is_activity: bool,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct CodelCounts {
    /// `component.owner.state`
    pub codel: String,
    /// Number of runs.
    pub runs: u64,
    /// Greatest execution time.
    pub greatest: Value,
    /// Greatest wait for its locks.
    pub waited: Value,
}

/// The result of a check.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct CheckOutcome {
    /// Name, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    pub check: PropertyKind,
    /// The task, or the predicates, in words.
    pub of: String,
    /// Verdict of the run.
    pub verdict: Verdict,
    /// The reason why the check was not exercised, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
    /// Greatest time measured for the check.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub greatest: Option<Value>,
    /// Limit of this time: the stated one, or else the period of the task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<Value>,
    /// True if the greatest time is above the limit. Beyond a period, nothing is violated.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub exceeded: bool,
    /// First moment at which the verdict was known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<RunMoment>,
    /// Number of violations.
    pub violations: u64,
    /// Number of runs that violated it, or showed the expected event.
    pub in_runs: u64,
    /// Of several runs with random choices that exercised the check: the probability that a run violates it,
    /// or shows the expected event. It is about the choices as they are drawn. `None` if a violation, or the
    /// user, could end the runs early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probability: Option<Estimate>,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct RunMoment {
    /// Number of the run, from 1.
    pub run: u64,
    /// Seed that makes this run the first one.
    pub seed: u64,
    /// Time since the start of the run.
    pub time: Value,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct ViolationReport {
    /// First moment.
    pub at: RunMoment,
    /// Number of occurrences.
    pub times: u64,
    /// Kind and details.
    #[serde(flatten)]
    pub what: Violated,
}

/// The kind and details of a violation.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Violated {
    /// A violated check.
    Check {
        /// Index of the check.
        check: usize,
    },
    /// A response time beyond its proved bound.
    BeyondBound {
        /// `component.task`
        task: String,
        /// Response time when the violation was seen.
        response: Value,
        bound: Value,
    },
    /// A codel ended with an undeclared event.
    Undeclared {
        /// `component.owner.state`
        codel: String,
        function: String,
        /// Full name of the event; empty if the value is not an event.
        event: String,
    },
    /// The process of a component has ended.
    Lost {
        component: String,
        /// Codel that it executed.
        #[serde(skip_serializing_if = "Option::is_none")]
        codel: Option<String>,
        /// Function of the codel.
        #[serde(skip_serializing_if = "Option::is_none")]
        function: Option<String>,
        /// Reason, in words.
        why: String,
    },
    /// A codel took longer than its stated execution time.
    Overrun {
        /// `component.owner.state`
        codel: String,
        function: String,
        /// Greatest execution time.
        took: Value,
        /// Stated execution time.
        limit: Value,
    },
}

/// Returns the report of one of the violations of a run that goes on.
pub fn violation(
    prepared: &Prepared,
    plan: &Plan,
    judge: &RunChecker<'_>,
    number: usize,
) -> ViolationReport {
    ReportBuilder { prepared, seed: plan.seed }.violation(judge, number)
}

/// Returns the assumptions of the model, with what the choices of the runs are drawn by.
fn assumptions(prepared: &Prepared, plan: &Plan) -> Vec<String> {
    let mut out = prepared.report.assumptions.clone();
    if plan.weights.is_some() {
        out.push("yields of simulated codels: drawn by weights".to_owned());
    }
    out
}

fn checksum(prepared: &Prepared, plan: &Plan) -> String {
    let mut hasher = DefaultHasher::new();
    format!("{:?} {:?}", prepared.built.system, plan.weights).hash(&mut hasher);
    format!("{:016x}", hasher.finish())
}

/// Returns the results of the checks of one run. `simulated`: some codels were not executed.
pub fn checks(prepared: &Prepared, judge: &RunChecker<'_>, simulated: bool) -> Vec<CheckOutcome> {
    ReportBuilder { prepared, seed: 0 }.checks(judge, simulated)
}

impl RunReport {
    /// Creates the report of finished runs. `executes` tells codels that are executed from simulated ones.
    pub fn new(
        prepared: &Prepared,
        plan: &Plan,
        outcome: &SimulationResult,
        bounds: &[Option<Ticks>],
        executes: &dyn Fn(CodelId) -> bool,
    ) -> RunReport {
        let make = ReportBuilder { prepared, seed: plan.seed };
        let system = &prepared.built.system;
        let ran = outcome.tally.codels.iter().map(|counted| counted.runs.count > 0);
        // What every component does by itself, as to interrupt an activity, is not simulated.
        let declared = system.codels.iter_enumerated().zip(ran);
        let simulated = declared
            .into_iter()
            .any(|((id, codel), ran)| ran && codel.site.is_some() && !executes(id));
        let checks = make.checks(&outcome.judge, simulated);
        let services = system.services.keys().map(|service| {
            let counted = &outcome.tally.services[service];
            ServiceCounts {
                service: system.service_path(service),
                requests: counted.requests,
                refused: counted.refused,
                ended: counted.ended,
                is_activity: system.services[service].activity,
            }
        });
        let codels = system.codels.iter().zip(&outcome.tally.codels);
        let codels = codels.map(|(codel, counted)| CodelCounts {
            codel: codel.path.to_string(),
            runs: counted.runs.count,
            greatest: make.value(counted.runs.greatest),
            waited: make.value(counted.waits.greatest),
        });
        let mut notes = prepared.report.notes.clone();
        notes.extend(outcome.refused.iter().map(|&service| {
            let path = system.service_path(service);
            format!("a request of {path} was refused because all its slots were in use")
        }));
        let mut report = RunReport {
            format: FORMAT,
            scenario: prepared.report.scenario.clone(),
            semantics: prepared.report.semantics.clone(),
            unit: prepared.report.unit,
            seed: plan.seed,
            durations: plan.durations,
            model: checksum(prepared, plan),
            runs: outcome.runs,
            until: (plan.until < u64::MAX).then(|| Value::Time(prepared.time(plan.until))),
            time: Value::Time(prepared.time(outcome.time)),
            end: outcome.end,
            unfinished: outcome.unfinished.clone(),
            tasks: tasks(prepared, &outcome.tally, bounds, outcome.time),
            requests_outside_model: 0,
            ports: Vec::new(),
            services: services.collect(),
            codels: codels.collect(),
            machines: machines(prepared, &outcome.tally),
            verdict: together(outcome.judge.count, &checks),
            checks,
            violations: (0..outcome.judge.violations.len())
                .map(|number| make.violation(&outcome.judge, number))
                .collect(),
            violation_count: outcome.judge.count,
            assumptions: assumptions(prepared, plan),
            notes,
            // If what is counted decides when to stop, or a run was cut off, the count is no sample.
            is_sample: outcome.runs == plan.runs
                && !plan.stop_at_violation
                && !outcome.end.ends_all(),
        };
        report.estimate();
        report
    }

    /// Estimates the probabilities of the checks that were exercised, from the counts of several runs.
    pub(crate) fn estimate(&mut self) {
        let (runs, is_sample) = (self.runs, self.is_sample && self.runs > 1);
        for check in &mut self.checks {
            check.probability = (is_sample && check.verdict != Verdict::NotExercised)
                .then(|| Estimate::of(check.in_runs, runs, CONFIDENCE));
        }
    }

    /// Counts the writes of output ports, each with its name `component/port`.
    pub fn count_writes(
        &mut self,
        prepared: &Prepared,
        outcome: &SimulationResult,
        ports: impl Iterator<Item = (Port, String)>,
    ) {
        let age = |ticks: u64| Value::Time(prepared.time(ticks));
        self.ports = ports
            .map(|(port, name)| PortCounts {
                port: name,
                writes: outcome.ports.count(port),
                greatest_age: outcome.ports.greatest_age(port).map(age),
            })
            .collect();
    }

    /// Counts the requests of clients that are not of the scenario, from `first` on.
    pub fn count_outside_model(&mut self, tally: &Tally, first: ClientId) {
        let clients = tally.clients.iter_enumerated();
        let outside = clients.filter(|(client, _)| *client >= first);
        self.requests_outside_model = outside.map(|(_, requests)| requests).sum();
    }

    /// Returns true if there was a violation.
    pub fn violated(&self) -> bool {
        self.violation_count > 0
    }
}

/// Returns what the exercised checks of a run say together.
pub(crate) fn together(violations: u64, checks: &[CheckOutcome]) -> Verdict {
    let has = |verdict: Verdict| checks.iter().any(|check| check.verdict == verdict);
    if violations > 0 {
        Verdict::Violated
    } else if has(Verdict::Simulated) {
        Verdict::Simulated
    } else if has(Verdict::Kept) || has(Verdict::Seen) {
        Verdict::Kept
    } else {
        Verdict::NotExercised
    }
}

struct ReportBuilder<'r> {
    prepared: &'r Prepared,
    /// Seed of the first run.
    seed: u64,
}

impl ReportBuilder<'_> {
    fn value(&self, ticks: Ticks) -> Value {
        Value::Time(self.prepared.time(u64::from(ticks)))
    }

    fn nanos(&self, nanos: u64) -> Value {
        let unit = self.prepared.report.unit;
        Value::Time(unit.from_seconds(Seconds::new(i128::from(nanos), 1_000_000_000)))
    }

    fn at(&self, moment: Moment) -> RunMoment {
        RunMoment {
            run: moment.run + 1,
            seed: self.seed.wrapping_add(moment.run),
            time: Value::Time(self.prepared.time(moment.time)),
        }
    }

    fn checks(&self, judge: &RunChecker<'_>, simulated: bool) -> Vec<CheckOutcome> {
        let checks = self.prepared.checks.iter().zip(&judge.answers);
        let checks = checks.enumerate().map(|(number, (asked, answer))| {
            let greatest = answer.greatest.map(|number| self.value(number));
            let limit = asked.report.limit;
            CheckOutcome {
                name: asked.report.name.clone(),
                check: asked.report.kind,
                of: asked.report.of.clone(),
                verdict: match answer.verdict {
                    Verdict::Kept | Verdict::Seen if simulated => Verdict::Simulated,
                    verdict => verdict,
                },
                why: judge.idle(number).map(|idle| self.why(idle)),
                greatest,
                limit: limit.map(|limit| Value::Time(limit.time())),
                exceeded: limit.zip(greatest).is_some_and(|(limit, it)| limit.is_exceeded_by(it)),
                at: answer.at.map(|moment| self.at(moment)),
                violations: answer.violations,
                in_runs: answer.in_runs,
                probability: None,
            }
        });
        checks.collect()
    }

    fn why(&self, idle: Idle) -> String {
        let system = &self.prepared.built.system;
        let data = |fact: usize| {
            let fact = self.prepared.built.data.as_ref().and_then(|facts| facts.get(fact));
            fact.map_or("", |fact| &fact.path)
        };
        match idle {
            Idle::NoCodel { task } => {
                format!("{} executed no codel", system.task_path(TaskId::from(task)))
            }
            Idle::NoData { fact } => {
                format!("{} has no data: no codel that writes it is executed", data(fact))
            }
            Idle::NotWritten { fact } => format!("{} was not written", data(fact)),
            Idle::NothingExecuted => "no codel was executed".to_owned(),
            Idle::NoTrigger => "its first condition did not become true".to_owned(),
            Idle::NoPattern => "nothing happened that the pattern is about".to_owned(),
            Idle::NotAnswered => "the run ended before its second condition became true".to_owned(),
            Idle::NotSeen => "it did not become true".to_owned(),
        }
    }

    fn violation(&self, judge: &RunChecker<'_>, number: usize) -> ViolationReport {
        let system = &self.prepared.built.system;
        let (at, violation) = judge.violations[number];
        ViolationReport {
            at: self.at(at),
            times: judge.times[number],
            what: match violation {
                Violation::Check(check) => Violated::Check { check },
                Violation::BeyondBound { task, response, bound } => Violated::BeyondBound {
                    task: system.task_path(TaskId::from(task)),
                    response: self.value(response),
                    bound: self.value(bound),
                },
                Violation::CodelViolation(at) => match &judge.broken[at] {
                    CodelViolation::Undeclared { codel, function, event } => Violated::Undeclared {
                        codel: codel.clone(),
                        function: function.clone(),
                        event: event.clone(),
                    },
                    CodelViolation::Lost { component, codel, why } => Violated::Lost {
                        component: component.clone(),
                        codel: codel.as_ref().map(|codel| codel.0.clone()),
                        function: codel.as_ref().map(|codel| codel.1.clone()),
                        why: why.clone(),
                    },
                    CodelViolation::Overrun { codel, function, took, limit, .. } => {
                        Violated::Overrun {
                            codel: codel.clone(),
                            function: function.clone(),
                            took: self.nanos(*took),
                            limit: self.nanos(*limit),
                        }
                    }
                },
            },
        }
    }
}
