//! The causes of refuted checks and their remedies, as data of a report and as text.

use std::time::Duration;

use dotgen_analysis::phrase::Phrase;
use dotgen_timing::advice::{Change, remedy};
use dotgen_timing::report::{
    Awaited, CheckReport, Delay, Holder, Limit, Report, Stretch, StretchKind, TimeUnit, Verdict,
};
use dotgen_timing::system::{CodelName, ThreadName};
use dotgen_timing::verify::{Cancel, Options, SystemInput};
use rustc_hash::FxHashMap;
use serde::Serialize;

use super::Problem;
use super::blocking::{self, Row, function};
use super::changes;
use super::endless::EndlessCause;

/// Maximum duration of a verification, in seconds, after which remedies are searched: each needs several
/// verifications.
const QUICK_SECONDS: f64 = 1.0;

/// Longest search for the remedy of one check: a longer search is not worth a hint.
const REMEDY_TIME: Duration = Duration::from_secs(1);

/// Longest search for all remedies of a report.
const REMEDIES_TIME: Duration = Duration::from_secs(3);

/// The cause of a refuted check, and the remedy. It has a `cause`, or says what is `endless`, or both.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FailureCause {
    /// What the time at the end of the run is spent on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) cause: Option<Cause>,
    /// What goes on for ever, if a time has no bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) endless: Option<EndlessCause>,
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
    /// The late task, if the check is about one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) task: Option<ThreadName>,
    /// Time to the end of the run, in the unit of the report: from the tick of the job, the first datum or
    /// the first event. It is the sum of the parts.
    pub(crate) time: f64,
    /// What happened meanwhile, the longest first.
    pub(crate) parts: Vec<Part>,
    #[serde(skip)]
    end: End,
}

/// What is wrong at the end of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    /// The tick comes that is the deadline of the job.
    Deadline,
    /// The job has exceeded its limit.
    Job,
    /// The measured time has exceeded the limit, in the unit of the report; `None`: it has no bound.
    Limit(Option<f64>),
}

/// A part of a late time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Part {
    /// The thread, if the check is not about a single task.
    #[serde(rename = "task", skip_serializing_if = "Option::is_none")]
    pub(crate) thread: Option<ThreadName>,
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
    /// Its next job has not begun: it waits for its tick, or to be woken.
    Between,
    /// No request for the service, with its component, is accepted.
    Unrequested { service: String },
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

/// The causes of all refuted checks of a report; if `remedies` is set, also the remedies of tasks.
pub fn of_report(
    problem: &Problem,
    options: &Options,
    report: &Report,
    remedies: Option<&Cancel>,
) -> Vec<Option<FailureCause>> {
    if !report.checks.iter().any(|check| check.verdict == Verdict::Refuted) {
        return vec![None; report.checks.len()];
    }
    let table = blocking::table(problem, options);
    let input = SystemInput { specs: problem.specs() };
    let remedies = remedies.filter(|_| report.seconds <= QUICK_SECONDS);
    let remedies = remedies.map(|remedy| remedy.part(REMEDIES_TIME));
    // A remedy makes all checks of a task hold.
    let mut known: FxHashMap<ThreadName, Change> = FxHashMap::default();
    let why = |check: &CheckReport| {
        if check.verdict != Verdict::Refuted {
            return None;
        }
        let endless = check.endless.as_ref();
        let endless = endless.and_then(|endless| EndlessCause::new(endless, problem, &table));
        let Some(task) = check.task.clone() else {
            let cause = spent(check, &table);
            return (cause.is_some() || endless.is_some()).then_some(FailureCause {
                cause,
                endless,
                remedy: None,
                function: None,
            });
        };
        let remedy = remedies.as_ref().and_then(|cancel| {
            let cancel = cancel.part(REMEDY_TIME);
            let of_task = || remedy(&input, &problem.scenario, options, (report, check), &cancel);
            known.get(&task).cloned().or_else(of_task)
        });
        if let Some(remedy) = &remedy {
            known.insert(task.clone(), remedy.clone());
        }
        let function = match &remedy {
            Some(Change::Wcet { codel, .. }) => Some(function(&table, codel)),
            _ => None,
        };
        Some(FailureCause { cause: Some(cause(task, check, &table)), endless, remedy, function })
    };
    report.checks.iter().map(why).collect()
}

/// A sum of times below this is noise of binary fractions, in the unit of the report.
const NOISE: f64 = 1e-6;

/// Parts of a time, each kind of each thread once.
#[derive(Default)]
struct Parts(Vec<Part>);

impl Parts {
    fn add(&mut self, time: f64, thread: Option<ThreadName>, kind: PartKind) {
        let same = |part: &&mut Part| part.thread == thread && part.kind == kind;
        match self.0.iter_mut().find(same) {
            Some(part) => part.time += time,
            None => self.0.push(Part { thread, time, kind }),
        }
    }

    /// Returns the parts that take time, the longest first.
    fn sorted(mut self) -> Vec<Part> {
        self.0.retain(|part| part.time > NOISE);
        self.0.sort_by(|a, b| b.time.total_cmp(&a.time));
        self.0
    }
}

fn cause(task: ThreadName, check: &CheckReport, table: &[Row]) -> Cause {
    let mut parts = Parts::default();
    let executed = check.job.iter().flat_map(|job| &job.executed);
    for work in executed {
        let (codel, times) = (work.codel.clone(), work.times);
        let function = function(table, &work.codel);
        parts.add(work.time, None, PartKind::Executes { codel, times, function });
        parts.add(work.preempted, None, PartKind::Preempted);
    }
    for delay in &check.reason {
        parts.add(delay.until - delay.from, None, wait(delay, table));
    }
    if let Some(job) = &check.job {
        parts.add(job.begun - job.from, None, PartKind::Previous);
    }
    let sum: f64 = parts.0.iter().map(|part| part.time).sum();
    let time = check.job.as_ref().map_or(sum, |job| job.until - job.from);
    parts.add(time - sum, None, PartKind::Idle);
    let end = if check.kind.is_deadline() { End::Deadline } else { End::Job };
    Cause { task: Some(task), time, parts: parts.sorted(), end }
}

/// The cause of a late datum or response: its intervals, added up.
fn spent(check: &CheckReport, table: &[Row]) -> Option<Cause> {
    let mut parts = Parts::default();
    for stretch in &check.spent {
        parts.add(
            stretch.until - stretch.from,
            stretch.thread.clone(),
            part_of(stretch, check, table),
        );
    }
    if parts.0.iter().all(|part| part.kind == PartKind::Idle) {
        return None;
    }
    let time = check.spent.iter().map(|stretch| stretch.until - stretch.from).sum();
    let end = End::Limit(check.limit.map(Limit::time));
    Some(Cause { task: None, time, parts: parts.sorted(), end })
}

fn part_of(stretch: &Stretch, check: &CheckReport, table: &[Row]) -> PartKind {
    match &stretch.kind {
        StretchKind::Executes(codel) => {
            let executions = check.spent.iter().filter(|other| {
                let own = matches!(&other.kind,
                    StretchKind::Executes(other) | StretchKind::Preempted(other) if other == codel);
                own && other.begins
            });
            // An execution that began before the time counts as well.
            let times = executions.count().max(1) as u32;
            PartKind::Executes { codel: codel.clone(), times, function: function(table, codel) }
        }
        StretchKind::Preempted(_) => PartKind::Preempted,
        StretchKind::Locks { codel, holder } => PartKind::Waits {
            awaited: Awaited::Lock,
            through: holder.as_ref().map_or(Vec::new(), |holder| shared(codel, holder, table)),
            held_by: holder.clone().map(HolderName::Codel),
            holder: holder.as_ref().map(|holder| function(table, holder)),
        },
        StretchKind::Core => PartKind::Waits {
            awaited: Awaited::Core,
            through: Vec::new(),
            held_by: None,
            holder: None,
        },
        StretchKind::Between => PartKind::Between,
        StretchKind::Unrequested(service) => PartKind::Unrequested { service: service.clone() },
        StretchKind::Client | StretchKind::Nothing => PartKind::Idle,
    }
}

/// Returns the data for whose locks a codel waits, held by another one.
fn shared(waiting: &CodelName, holder: &CodelName, table: &[Row]) -> Vec<Phrase> {
    let row = table.iter().find(|row| row.codel.path == *waiting);
    let by = row.and_then(|row| row.by.iter().find(|blocker| blocker.codel.path == *holder));
    by.map(|row| row.through.clone()).unwrap_or_default()
}

/// The wait of a job, with the thread or codel that keeps it waiting for the longest time.
fn wait(delay: &Delay, table: &[Row]) -> PartKind {
    let had = |holder: &&Holder| holder.until - holder.from;
    let holder = delay.held.iter().max_by(|a, b| had(a).total_cmp(&had(b)));
    let codel = holder.and_then(|holder| holder.codel.as_ref());
    let both = delay.codel.as_ref().zip(codel);
    PartKind::Waits {
        awaited: delay.awaited,
        through: both.map_or(Vec::new(), |(waiting, holder)| shared(waiting, holder, table)),
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
            PartKind::Between => Phrase::words(format!("is between its jobs for {time}")),
            PartKind::Unrequested { service } => {
                Phrase::words(format!("waits {time} for a request of ")).and_name(service.as_str())
            }
            PartKind::Idle => Phrase::words(format!("does nothing for {time}")),
        }
    }
}

impl Cause {
    /// `` `filter` waits 906 µs for a core, held by `comm`; executes `filter_main` for 94 µs: together 1 ms,
    /// and the job has not ended when its next tick comes ``
    fn in_words(&self, unit: TimeUnit) -> String {
        let (named, others) = self.parts.split_at(self.parts.len().min(NAMED));
        let mut thread = self.task.as_ref();
        let mut said = match thread {
            Some(task) => Phrase::name(task.own()).and(" "),
            None => Phrase::words(""),
        };
        for (number, part) in named.iter().enumerate() {
            if number > 0 {
                said = said.and("; ");
            }
            if part.thread.is_some() && part.thread.as_ref() != thread {
                thread = part.thread.as_ref();
                let name = thread.map(ThreadName::to_string).unwrap_or_default();
                said = said.and_name(name.as_str()).and(" ");
            }
            said = said.and_phrase(&part.in_words(unit));
        }
        if !others.is_empty() {
            let rest: f64 = others.iter().map(|part| part.time).sum();
            said = said.and(format!("; {} in smaller parts", unit.show(rest)));
        }
        if self.parts.len() > 1 {
            said = said.and(format!(": together {}", unit.show(self.time)));
        }
        let end = match self.end {
            End::Deadline => ", and the job has not ended when its next tick comes".to_owned(),
            End::Job => ", and the job has not ended".to_owned(),
            End::Limit(Some(limit)) => format!(", more than the limit of {}", unit.show(limit)),
            End::Limit(None) => String::new(),
        };
        said.and(end).to_string()
    }
}

impl FailureCause {
    /// The cause in words, and what is endless.
    pub fn cause_in_words(&self, unit: TimeUnit) -> String {
        let cause = self.cause.as_ref().map(|cause| cause.in_words(unit));
        let endless = self.endless.as_ref().map(|endless| endless.in_words().to_string());
        let all: Vec<String> = cause.into_iter().chain(endless).collect();
        all.join("; ")
    }

    /// `` waits 6 ms for `level` of the ids, held by `report_start` ``: the longest part.
    pub fn wait_in_words(&self, unit: TimeUnit) -> Phrase {
        match self.cause.iter().flat_map(|cause| &cause.parts).next() {
            Some(part) => part.in_words(unit),
            None => Phrase::words("its run is left out"),
        }
    }

    /// `` it holds if `report_start` takes at most 4 ms ``
    pub fn remedy_in_words(&self, unit: TimeUnit) -> Option<String> {
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
