//! The checks of a scenario in a recorded run.

use std::collections::BTreeMap;
use std::io::Write;

use dotgen_analysis::terminal;
use dotgen_recording::record::{self, PortRecording, Recording};
use dotgen_recording::replay::{Replay, ReplayReport};
use dotgen_runtime::checker::{Idle, RunChecker, Verdict};
use dotgen_timing::explore::{Seen, Stepper};
use dotgen_timing::property::DataFact;
use dotgen_timing::property::PropertyKind;
use dotgen_timing::system::{ClientId, TimedSystem};
use dotgen_timing::verify::Prepared;

use crate::run::check_title;

/// The checks, and the data of the recording.
pub(super) struct RecordedChecks<'p> {
    prepared: &'p Prepared,
    facts: &'p [DataFact],
    recorded: PortRecording,
}

/// The result of a check.
#[derive(Debug, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) struct CheckResult {
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    check: PropertyKind,
    of: String,
    verdict: Verdict,
    #[serde(skip_serializing_if = "Option::is_none")]
    why: Option<String>,
    /// First moment at which the verdict was known, in units of the system.
    #[serde(skip_serializing_if = "Option::is_none")]
    at: Option<u64>,
    pub(super) violations: u64,
    #[serde(skip)]
    title: String,
}

impl<'p> RecordedChecks<'p> {
    /// Reads the data of a recording, if a check compares data.
    pub(super) fn read(prepared: &'p Prepared, bytes: &[u8]) -> anyhow::Result<Self> {
        let facts = prepared.built.data.as_deref().unwrap_or_default();
        let recorded = match facts {
            [] => PortRecording::default(),
            _ => record::read_data(bytes).map_err(anyhow::Error::msg)?,
        };
        Ok(RecordedChecks { prepared, facts, recorded })
    }

    /// Replays a run with its data.
    pub(super) fn replay(
        &self,
        system: &TimedSystem,
        outside: Option<ClientId>,
        recorded: &Recording,
    ) -> (ReplayReport, RunChecker<'p>) {
        let verified = &self.prepared.built.system;
        let (watched, places) = self.prepared.watched();
        let mut judge = RunChecker::new(self.prepared, places, vec![None; verified.tasks.len()]);
        let topics = self.recorded.topics.iter();
        let facts: BTreeMap<u16, Vec<usize>> =
            topics.map(|(&channel, topic)| (channel, self.of_topic(topic))).collect();
        judge.find_data(&|fact| {
            facts.values().flatten().any(|&number| self.facts[number].path == fact.path)
        });
        let mut observe = |stepper: &Stepper<'_>, seen: Option<&Seen>| match seen {
            Some(seen) => judge.on_event(stepper, seen),
            None => judge.moment(stepper),
        };
        let mut replay = Replay::new(system, verified, outside, &watched, &mut observe);
        let mut messages = self.recorded.messages.iter().peekable();
        for (number, step) in (1..).zip(&recorded.steps) {
            // The step ends the codel that has written the data.
            while let Some(message) = messages.next_if(|message| message.after <= number) {
                let value = serde_json::from_slice(&message.text).unwrap_or_default();
                for &fact in &facts[&message.channel] {
                    replay.set_fact(fact, self.facts[fact].holds_in_message(&value));
                }
            }
            replay.step(step);
        }
        (replay.end(recorded.about.end), judge)
    }

    /// Returns the numbers of the comparisons of the data of a topic.
    fn of_topic(&self, topic: &str) -> Vec<usize> {
        let path = topic.trim_start_matches('/').replace('/', ".");
        (0..self.facts.len()).filter(|&fact| self.facts[fact].path == path).collect()
    }

    /// Returns the results of the checks. `simulated`: some codels were not executed.
    pub(super) fn results(&self, judge: &RunChecker<'_>, simulated: bool) -> Vec<CheckResult> {
        let checks = self.prepared.checks.iter().zip(&judge.answers).enumerate();
        let results = checks.map(|(number, (check, answer))| CheckResult {
            name: check.report.name.clone(),
            check: check.report.kind,
            of: check.report.of.clone(),
            verdict: match answer.verdict {
                Verdict::Kept | Verdict::Seen if simulated => Verdict::Simulated,
                verdict => verdict,
            },
            why: judge.idle(number).map(|idle| self.why(idle)),
            at: answer.at.map(|moment| moment.time),
            violations: answer.violations,
            title: check_title(&check.report),
        });
        results.collect()
    }

    fn why(&self, idle: Idle) -> String {
        match idle {
            Idle::NoData { fact } | Idle::NotWritten { fact } => {
                format!("the recording has no data of {}", self.facts[fact].path)
            }
            Idle::NoTrigger => "its first condition did not become true".to_owned(),
            Idle::NotSeen => "it did not become true".to_owned(),
            Idle::NoCodel { .. } | Idle::NothingExecuted => "no codel was executed".to_owned(),
        }
    }

    /// Prints the results.
    pub(super) fn print(&self, checks: &[CheckResult]) -> anyhow::Result<()> {
        let mut out = anstream::AutoStream::auto(std::io::stdout().lock());
        let unit = self.prepared.report.unit;
        for check in checks {
            let time = |at: u64| unit.show(self.prepared.time(at));
            let at = check.at.map_or(String::new(), |at| format!(" at {}", time(at)));
            let verdict = match check.verdict {
                Verdict::Violated => format!("violated{at}"),
                Verdict::Seen => format!("kept{at}"),
                Verdict::NotExercised | Verdict::NotSeen => "not exercised".to_owned(),
                Verdict::Kept => "kept".to_owned(),
                Verdict::Simulated => "kept by simulated codels:".to_owned(),
            };
            let why = check.why.as_ref().map_or(String::new(), |why| format!(": {why}"));
            writeln!(out, "{verdict} {}{why}", terminal::text(&check.title))?;
        }
        Ok(())
    }
}
