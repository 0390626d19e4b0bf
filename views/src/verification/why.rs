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
    /// The longest wait of the job at the end of the run.
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
    /// The awaited lock or core; none if the job was never blocked.
    #[serde(rename = "waits-for", skip_serializing_if = "Option::is_none")]
    pub(crate) awaited: Option<Awaited>,
    /// Duration of the wait, in the unit of the report.
    pub(crate) time: f64,
    /// The shared data.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) through: Vec<Phrase>,
    /// The holder: a codel, or a task.
    #[serde(rename = "held-by", skip_serializing_if = "Option::is_none")]
    pub(crate) held_by: Option<HolderName>,
    /// The holder's name for users: the function of a codel.
    #[serde(skip)]
    holder: Option<String>,
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

fn cause(task: ThreadName, check: &CheckReport, table: &[Row]) -> Cause {
    let mut out =
        Cause { task, awaited: None, time: 0.0, through: Vec::new(), held_by: None, holder: None };
    let length = |delay: &Delay| delay.until - delay.from;
    let longest = check.reason.iter();
    let Some(longest) = longest.max_by(|a, b| length(a).total_cmp(&length(b))) else {
        return out;
    };
    out.awaited = Some(longest.awaited);
    out.time = length(longest);
    let had = |holder: &Holder| holder.until - holder.from;
    let holders = longest.held.iter();
    let Some(holder) = holders.max_by(|a, b| had(a).total_cmp(&had(b))) else {
        return out;
    };
    out.held_by = Some(match &holder.codel {
        Some(codel) => HolderName::Codel(codel.clone()),
        None => HolderName::Thread(holder.by.clone()),
    });
    out.holder = Some(match &holder.codel {
        Some(codel) => function(table, codel),
        None => holder.by.own().to_owned(),
    });
    if let (Some(waiting), Some(codel)) = (&longest.codel, &holder.codel) {
        let row = table.iter().find(|row| row.codel.path == *waiting);
        let by = row.and_then(|row| row.by.iter().find(|blocker| blocker.codel.path == *codel));
        out.through = by.map(|row| row.through.clone()).unwrap_or_default();
    }
    out
}

impl FailureCause {
    /// `` `control` waits 6 ms for `level` of the ids, held by `report_start` ``
    pub(crate) fn cause_in_words(&self, unit: TimeUnit) -> String {
        let task = Phrase::name(self.cause.task.own()).and(" ");
        task.and_phrase(&self.wait_in_words(unit)).to_string()
    }

    /// `` waits 6 ms for `level` of the ids, held by `report_start` ``
    pub fn wait_in_words(&self, unit: TimeUnit) -> Phrase {
        let cause = &self.cause;
        let time = unit.show(cause.time);
        let what = match (cause.awaited, &cause.through[..]) {
            (None, _) => {
                // Where threads preempt each other, no queue holds a thread that has lost its core.
                return Phrase::words(
                    "never waits in a queue: its codels, preemption included, exceed the limit",
                );
            }
            (Some(Awaited::Core), _) => Phrase::words("a core"),
            (Some(Awaited::Lock), []) => Phrase::words("a lock"),
            (Some(Awaited::Lock), all) => Phrase::joined(all, " and "),
        };
        let wait = Phrase::words(format!("waits {time} for ")).and_phrase(&what);
        match &cause.holder {
            Some(holder) => wait.and(", held by ").and_name(holder.as_str()),
            None => wait,
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
