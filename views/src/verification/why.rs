//! The causes of missed deadlines and their remedies, as data of a report and as text.

use std::time::Duration;

use dotgen_analysis::phrase::Phrase;
use dotgen_timing::advice::{Change, remedy};
use dotgen_timing::report::{Awaited, CheckReport, Delay, Holder, Report, Verdict};
use dotgen_timing::system::{CodelName, ThreadName};
use dotgen_timing::verify::{Cancel, Options, SystemInput};
use rustc_hash::FxHashMap;
use serde::Serialize;

use super::Problem;
use super::blocking::{self, Row};
use super::changes;
use dotgen_timing::report::TimeUnit;

/// Maximum duration of a verification, in seconds, after which remedies are searched: each needs several
/// verifications.
const QUICK_SECONDS: f64 = 1.0;

/// Longest search for the remedy of one check: a longer search is not worth a hint.
const REMEDY_TIME: Duration = Duration::from_secs(1);

/// Longest search for all remedies of a report.
const REMEDIES_TIME: Duration = Duration::from_secs(3);

/// The cause of a task's failure, and the remedy.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FailureCause {
    /// What the job at the end of the run does with its time.
    pub(crate) cause: Cause,
    /// A simple change with which all checks of the task hold, if there is one. It was verified.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<Change>,
    /// The function of the codel that the remedy changes.
    #[serde(skip)]
    function: Option<String>,
}

/// See [`FailureCause::cause`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Cause {
    /// The late task.
    pub(crate) task: ThreadName,
    /// Time from the tick of the job to the end of the run, in the unit of the report: the sum of the parts.
    pub(crate) time: f64,
    /// What the job did meanwhile, the longest first.
    pub(crate) parts: Vec<Part>,
    /// The run ends at the tick that is the deadline.
    #[serde(skip)]
    deadline: bool,
}

/// A part of the time of a late job.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Part {
    /// Time, in the unit of the report.
    pub(crate) time: f64,
    #[serde(flatten)]
    pub(crate) kind: PartKind,
}

/// The kind of a part of a job.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "part", rename_all = "kebab-case")]
pub(crate) enum PartKind {
    /// It executes a codel.
    Executes {
        codel: CodelName,
        /// Number of executions.
        times: u32,
        /// The function of the codel.
        #[serde(skip)]
        function: String,
    },
    /// It waits for a core, or for the locks of a codel.
    Waits {
        #[serde(rename = "for")]
        awaited: Awaited,
        /// The shared data.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        through: Vec<Phrase>,
        /// The longest holder: a codel, or a task.
        #[serde(rename = "held-by", skip_serializing_if = "Option::is_none")]
        held_by: Option<HolderName>,
        /// The holder's name for users: the function of a codel.
        #[serde(skip)]
        holder: Option<String>,
    },
    /// Other threads have its core.
    Preempted,
    /// The job before has not ended.
    Previous,
    /// It neither executes nor waits for anything that the run names.
    Idle,
}

/// The holder of an awaited lock or core. In JSON its name alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub(crate) enum HolderName {
    /// A codel holds the lock.
    Codel(CodelName),
    /// A thread has the core.
    Thread(ThreadName),
}

/// The causes of all checks of a report that fail for a task; if `remedies` is set, also the remedies.
pub fn of_report(
    problem: &Problem,
    options: &Options,
    report: &Report,
    remedies: Option<&Cancel>,
) -> Vec<Option<FailureCause>> {
    let late = |report: &'_ CheckReport| match report.verdict {
        Verdict::Refuted => report.task.clone(),
        _ => None,
    };
    if !report.checks.iter().any(|check| late(check).is_some()) {
        return vec![None; report.checks.len()];
    }
    let table = blocking::table(problem, options);
    let input = SystemInput { specs: problem.specs() };
    let remedies = remedies.filter(|_| report.seconds <= QUICK_SECONDS);
    let remedies = remedies.map(|remedy| remedy.part(REMEDIES_TIME));
    // A remedy makes all checks of a task hold.
    let mut known: FxHashMap<ThreadName, Change> = FxHashMap::default();
    let why = |check| {
        late(check).map(|task| {
            let remedy = remedies.as_ref().and_then(|cancel| {
                let cancel = cancel.part(REMEDY_TIME);
                let of_task =
                    || remedy(&input, &problem.scenario, options, (report, check), &cancel);
                known.get(&task).cloned().or_else(of_task)
            });
            if let Some(remedy) = &remedy {
                known.insert(task.clone(), remedy.clone());
            }
            let function = match &remedy {
                Some(Change::Wcet { codel, .. }) => Some(function(&table, codel)),
                _ => None,
            };
            FailureCause { cause: cause(task, check, &table), remedy, function }
        })
    };
    report.checks.iter().map(why).collect()
}

fn function(table: &[Row], codel: &CodelName) -> String {
    let row = table.iter().find(|row| row.codel.path == *codel);
    row.map_or(&**codel, |row| &row.codel.function).to_owned()
}

/// A sum of times below this is noise of binary fractions, in the unit of the report.
const NOISE: f64 = 1e-6;

fn cause(task: ThreadName, check: &CheckReport, table: &[Row]) -> Cause {
    let mut parts: Vec<Part> = Vec::new();
    let mut add = |time: f64, kind: PartKind| match parts.iter_mut().find(|part| part.kind == kind)
    {
        Some(part) => part.time += time,
        None => parts.push(Part { time, kind }),
    };
    let executed = check.job.iter().flat_map(|job| &job.executed);
    for work in executed {
        let (codel, times) = (work.codel.clone(), work.times);
        let function = function(table, &work.codel);
        add(work.time, PartKind::Executes { codel, times, function });
        add(work.preempted, PartKind::Preempted);
    }
    for delay in &check.reason {
        add(delay.until - delay.from, wait(delay, table));
    }
    if let Some(job) = &check.job {
        add(job.begun - job.from, PartKind::Previous);
    }
    let sum: f64 = parts.iter().map(|part| part.time).sum();
    let time = check.job.as_ref().map_or(sum, |job| job.until - job.from);
    parts.push(Part { time: time - sum, kind: PartKind::Idle });
    parts.retain(|part| part.time > NOISE);
    parts.sort_by(|a, b| b.time.total_cmp(&a.time));
    Cause { task, time, parts, deadline: check.kind.is_deadline() }
}

/// The wait of a job, with the thread or codel that keeps it waiting for the longest time.
fn wait(delay: &Delay, table: &[Row]) -> PartKind {
    let had = |holder: &&Holder| holder.until - holder.from;
    let holder = delay.held.iter().max_by(|a, b| had(a).total_cmp(&had(b)));
    let mut through = Vec::new();
    if let (Some(waiting), Some(codel)) =
        (&delay.codel, holder.and_then(|holder| holder.codel.as_ref()))
    {
        let row = table.iter().find(|row| row.codel.path == *waiting);
        let by = row.and_then(|row| row.by.iter().find(|blocker| blocker.codel.path == *codel));
        through = by.map(|row| row.through.clone()).unwrap_or_default();
    }
    PartKind::Waits {
        awaited: delay.awaited,
        through,
        held_by: holder.map(|holder| match &holder.codel {
            Some(codel) => HolderName::Codel(codel.clone()),
            None => HolderName::Thread(holder.by.clone()),
        }),
        holder: holder.map(|holder| match &holder.codel {
            Some(codel) => function(table, codel),
            None => holder.by.own().to_owned(),
        }),
    }
}

/// Number of parts that are named in a sentence; the others are summed.
const NAMED: usize = 3;

impl Part {
    /// `` waits 6 ms for `level` of the ids, held by `report_start` ``
    fn in_words(&self, unit: TimeUnit) -> Phrase {
        let time = unit.show(self.time);
        match &self.kind {
            PartKind::Executes { times: 1, function, .. } => {
                Phrase::words("executes ").and_name(function.as_str()).and(format!(" for {time}"))
            }
            PartKind::Executes { times, function, .. } => Phrase::words("executes ")
                .and_name(function.as_str())
                .and(format!(" {times} times, for {time}")),
            PartKind::Waits { awaited, through, holder, .. } => {
                let what = match (awaited, &through[..]) {
                    (Awaited::Core, _) => Phrase::words("a core"),
                    (Awaited::Lock, []) => Phrase::words("a lock"),
                    (Awaited::Lock, all) => Phrase::joined(all, " and "),
                };
                let wait = Phrase::words(format!("waits {time} for ")).and_phrase(&what);
                match holder {
                    Some(holder) => wait.and(", held by ").and_name(holder.as_str()),
                    None => wait,
                }
            }
            PartKind::Preempted => {
                Phrase::words(format!("is preempted for {time} by threads that go first"))
            }
            PartKind::Previous => {
                Phrase::words(format!("waits {time} for the end of the job before"))
            }
            PartKind::Idle => Phrase::words(format!("does nothing for {time}")),
        }
    }
}

impl FailureCause {
    /// `` `filter` waits 906 µs for a core, held by `comm`; executes `filter_main` for 94 µs: together 1 ms,
    /// and the job has not ended when its next tick comes ``
    pub(crate) fn cause_in_words(&self, unit: TimeUnit) -> String {
        let Cause { task, time, parts, deadline } = &self.cause;
        let (named, others) = parts.split_at(parts.len().min(NAMED));
        let mut all: Vec<Phrase> = named.iter().map(|part| part.in_words(unit)).collect();
        if !others.is_empty() {
            let rest: f64 = others.iter().map(|part| part.time).sum();
            all.push(Phrase::words(format!("{} in smaller parts", unit.show(rest))));
        }
        let sum = match all.len() {
            1 => String::new(),
            _ => format!(": together {}", unit.show(*time)),
        };
        let start = Phrase::name(task.own()).and(" ");
        let said = start.and_phrase(&Phrase::joined(&all, "; ")).and(sum);
        let end = if *deadline { " when its next tick comes" } else { "" };
        said.and(format!(", and the job has not ended{end}")).to_string()
    }

    /// `` waits 6 ms for `level` of the ids, held by `report_start` ``: the longest part.
    pub fn wait_in_words(&self, unit: TimeUnit) -> Phrase {
        match self.cause.parts.first() {
            Some(part) => part.in_words(unit),
            None => Phrase::words("its run is left out"),
        }
    }

    /// `` it holds if `report_start` takes at most 4 ms ``
    pub(crate) fn remedy_in_words(&self, unit: TimeUnit) -> Option<String> {
        let name = |codel: &CodelName| self.function.as_deref().unwrap_or(codel).to_owned();
        Some(changes::in_words(self.remedy.as_ref()?, unit, &name))
    }

    /// The cause and the remedy.
    pub fn in_words(&self, unit: TimeUnit) -> String {
        let cause = self.cause_in_words(unit);
        match self.remedy_in_words(unit) {
            Some(remedy) => format!("{cause}; {remedy}"),
            None => cause,
        }
    }
}
