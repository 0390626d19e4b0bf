//! The checks of a scenario in a recorded run.

use std::collections::BTreeMap;
use std::io::Write;

use dotgen_analysis::terminal;
use dotgen_recording::record::{self, PortRecording, Recording};
use dotgen_recording::replay::{Observed, Replay, ReplayReport};
use dotgen_runtime::checker::RunChecker;
use dotgen_runtime::engine::End;
use dotgen_runtime::report::{self, CheckOutcome};
use dotgen_timing::explore::Stepper;
use dotgen_timing::property::DataFact;
use dotgen_timing::system::{ClientId, TimedSystem};
use dotgen_timing::verify::Prepared;
use serde_json::{Value, json};

use crate::run::text;

/// The checks, and the data of the recording.
pub(super) struct RecordedChecks<'p> {
    prepared: &'p Prepared,
    facts: &'p [DataFact],
    recorded: PortRecording,
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
        let mut observe = |stepper: &Stepper<'_>, observed: Observed| match observed {
            Observed::Event(seen) => judge.on_event(stepper, seen),
            Observed::Moment => judge.moment(stepper),
            Observed::NothingLeft => judge.end_checks(stepper, End::NothingLeft),
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
    pub(super) fn results(&self, judge: &RunChecker<'_>, simulated: bool) -> Vec<CheckOutcome> {
        report::checks(self.prepared, judge, simulated)
    }

    /// Returns the results as JSON, with moments in units of the system.
    pub(super) fn json(checks: &[CheckOutcome], judge: &RunChecker<'_>) -> Value {
        let checks = checks.iter().zip(&judge.answers).map(|(check, answer)| {
            let mut out = json!({
                "check": check.check,
                "of": check.of,
                "verdict": check.verdict,
                "violations": check.violations,
            });
            if let Some(name) = &check.name {
                out["name"] = name.as_str().into();
            }
            if let Some(why) = &check.why {
                out["why"] = why.as_str().into();
            }
            if check.exceeded {
                out["exceeded"] = true.into();
            }
            if let Some(at) = answer.at {
                out["at"] = at.time.into();
            }
            out
        });
        checks.collect()
    }

    /// Prints the results. `whole`: the run was compared up to its end.
    pub(super) fn print(&self, checks: &[CheckOutcome], whole: bool) -> anyhow::Result<()> {
        let mut out = anstream::AutoStream::auto(std::io::stdout().lock());
        let unit = self.prepared.report.unit;
        if !whole && !checks.is_empty() {
            writeln!(out, "checks, up to the last step that was followed:")?;
        }
        text::checks(&mut out, checks, unit)?;
        for check in checks.iter().filter(|check| check.violations > 0) {
            if let Some(at) = &check.at {
                let title = text::title(check);
                writeln!(
                    out,
                    "violated at {} {}",
                    unit.show_value(at.time),
                    terminal::text(&title)
                )?;
            }
        }
        Ok(())
    }
}
