//! The checks of a scenario along a log.

use std::collections::BTreeMap;

use dotgen_recording::log::{Origin, origin};
use dotgen_recording::monitor::{LogWatch, Monitor, MonitorReport, Noted};
use dotgen_runtime::checker::{RunChecker, Verdict};
use dotgen_runtime::report::{self, CheckOutcome};
use dotgen_timing::property::{Atom, Predicate};
use dotgen_timing::report::Value;
use dotgen_timing::system::TimedSystem;
use dotgen_timing::verify::{Prepared, Question};
use num_rational::Ratio;
use serde_json::json;

use crate::run::text::check_title;

/// A monitor, with the checks of the scenario.
pub(super) struct LogChecks<'p> {
    pub(super) monitor: Monitor<'p>,
    prepared: &'p Prepared,
    watch: LogWatch,
    judge: RunChecker<'p>,
    places: Vec<Option<usize>>,
    /// Checks whose violation was reported.
    violated: Vec<bool>,
    /// Some codels were simulated: nothing is known about the program.
    simulated: bool,
    /// The last line has no line break.
    is_cut: bool,
}

impl<'p> LogChecks<'p> {
    pub(super) fn new(prepared: &'p Prepared, monitor: Monitor<'p>) -> Self {
        let system = &prepared.built.system;
        let (watched, places) = prepared.watched();
        LogChecks {
            monitor,
            watch: LogWatch::new(system, watched),
            judge: RunChecker::new(prepared, places.clone(), vec![None; system.tasks.len()]),
            violated: vec![false; places.len()],
            places,
            simulated: false,
            is_cut: false,
            prepared,
        }
    }

    /// Reads a line of the log. `ended`: the line has its line break.
    pub(super) fn line(&mut self, number: u64, text: &[u8], ended: bool) {
        self.is_cut = !ended;
        self.simulated |= matches!(origin(text), Some(Origin::Simulated | Origin::Codel(_)));
        let executed = self.monitor.line(number, text, ended);
        // Without checks, nothing needs the order of events.
        if let Some(executed) = executed.filter(|_| !self.prepared.checks.is_empty()) {
            self.follow(|watch, note| watch.add(&executed, note));
        }
    }

    fn follow(&mut self, steps: impl FnOnce(&mut LogWatch, &mut dyn FnMut(&LogWatch, Noted))) {
        let LogChecks { monitor, prepared, watch, judge, violated, .. } = self;
        let system = &prepared.built.system;
        steps(watch, &mut |watch, noted| {
            match &noted.seen {
                Some(seen) => judge.on_event(watch, seen),
                None => judge.moment(watch),
            }
            for (check, answer) in judge.answers.iter().enumerate() {
                let is_new = answer.violations > 0 && !violated[check];
                let asked = &prepared.checks[check];
                if is_new && unshown(system, &asked.question).is_none() {
                    violated[check] = true;
                    monitor.violated(noted.line, noted.at, check_title(&asked.report));
                }
            }
        });
    }

    /// Returns the report of the log, up to its end.
    pub(super) fn finish(mut self) -> (MonitorReport, CheckResults) {
        self.follow(|watch, note| watch.finish(note));
        let report = self.monitor.report_so_far();
        let unit = self.prepared.report.unit;
        let time = |nanos: i64| {
            Value::Time(unit.from_seconds(Ratio::new(i128::from(nanos), 1_000_000_000)))
        };
        let mut results = CheckResults::default();
        let unknown = report.counts.get("unknown").copied().unwrap_or(0);
        // The last line of a log may be cut, and hides nothing that came before.
        let cut = report.left.cut.saturating_sub(u64::from(self.is_cut));
        let unused = unknown + self.watch.late() + report.left.clock_steps + cut;
        let missed = match unused {
            0 => None,
            1 => Some("1 line of the log could not be used".to_owned()),
            count => Some(format!("{count} lines of the log could not be used")),
        };
        if !self.prepared.chains.is_empty() {
            results.unshown.insert(CHAINS, self.prepared.chains.clone());
        }
        let all = report::checks(self.prepared, &self.judge, self.simulated);
        for (check, mut result) in all.into_iter().enumerate() {
            let asked = &self.prepared.checks[check];
            if let Some(why) = unshown(&self.prepared.built.system, &asked.question) {
                results.unshown.entry(why).or_default().push(check_title(&asked.report));
                continue;
            }
            // What was seen stays; what was not seen may have been missed.
            let looks_for =
                matches!(asked.question, Question::Reachable(_) | Question::Eventually(_));
            let is_kept = matches!(result.verdict, Verdict::Kept | Verdict::Simulated);
            if let (Some(why), true) = (&missed, is_kept && !looks_for) {
                result.verdict = Verdict::NotExercised;
                result.why = Some(why.clone());
            }
            if let (Question::Within(..) | Question::LeadsTo(..), Some(place)) =
                (&asked.question, self.places[check])
            {
                let longest = self.watch.longest(place);
                result.greatest = longest.map(time);
                results.longest.push(longest);
            } else {
                results.longest.push(None);
            }
            results.checks.push(result);
        }
        (report, results)
    }
}

/// The results of the checks of a scenario along a log.
#[derive(Debug, Default)]
pub(super) struct CheckResults {
    pub(super) checks: Vec<CheckOutcome>,
    /// Greatest time of each check, in nanoseconds.
    longest: Vec<Option<i64>>,
    /// Titles of the checks that no log answers, by the reason.
    pub(super) unshown: BTreeMap<&'static str, Vec<String>>,
}

impl CheckResults {
    /// Returns the results as JSON, with times in nanoseconds.
    pub(super) fn json(&self) -> serde_json::Value {
        let checks = self.checks.iter().zip(&self.longest).map(|(check, longest)| {
            let mut out = json!({
                "check": check.check,
                "of": check.of,
                "verdict": check.verdict,
                "violations": check.violations,
            });
            let parts = [
                ("name", json!(check.name)),
                ("why", json!(check.why)),
                ("greatest", json!(longest)),
            ];
            for (name, value) in parts.into_iter().filter(|part| !part.1.is_null()) {
                out[name] = value;
            }
            out
        });
        checks.collect()
    }
}

impl CheckResults {
    /// Returns the checks that no log answers, each with the reason.
    pub(super) fn unshown_json(&self) -> serde_json::Value {
        let all = self.unshown.iter();
        let all = all.flat_map(|(why, checks)| {
            checks.iter().map(move |check| json!({ "check": check, "why": why }))
        });
        all.collect()
    }
}

/// The reason why no log answers a check of a chain.
const CHAINS: &str = "logs have no data, `dotgen verify` answers these checks";

/// Returns the reason why no log answers a question, in words; `None` if a log can.
fn unshown(system: &TimedSystem, question: &Question) -> Option<&'static str> {
    let predicates: Vec<&Predicate> = match question {
        Question::Schedulable(_) | Question::NoOverdue(_) | Question::Response(..) => {
            return Some("a log has no releases of jobs, so that response times are not certain");
        }
        Question::Deadlock => return Some("a log does not show what could follow"),
        Question::Within(p, list, _) => std::iter::once(p).chain(list).collect(),
        Question::LeadsTo(p, q) => vec![p, q],
        Question::Eventually(p) | Question::Always(p) | Question::Reachable(p) => vec![p],
        Question::Pattern(monitor) => monitor.predicates.iter().collect(),
    };
    let (mut has_data, mut has_others) = (false, false);
    for predicate in predicates {
        predicate.atoms(&mut |atom| match atom {
            Atom::Data { .. } => has_data = true,
            atom => has_others |= !LogWatch::shows(system, atom),
        });
    }
    if has_data {
        Some("logs have no data, `dotgen run --record` and `dotgen replay` check this")
    } else if has_others {
        Some("a log shows codels one by one, not tasks, activities and clients")
    } else {
        None
    }
}
