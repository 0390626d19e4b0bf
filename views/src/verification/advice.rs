//! Advice on checks that gave up.

use dotgen_timing::explore::Stop;
use dotgen_timing::report::{GaveUp, Report, Verdict};
use dotgen_timing::scn::ast::{Item, Scenario};

use super::Problem;

/// The names of the limits of a verification, by the way in which it was started.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitNames {
    /// Options of the command line.
    Options,
    /// Settings of the editor and `dotgen.toml`.
    Settings,
}

impl LimitNames {
    fn of(self, reason: Stop) -> Option<&'static str> {
        match (reason, self) {
            (Stop::States, LimitNames::Options) => Some("--max-states"),
            (Stop::States, LimitNames::Settings) => Some("verification.max-states"),
            (Stop::Memory, LimitNames::Options) => Some("--max-memory"),
            (Stop::Memory, LimitNames::Settings) => Some("verification.max-memory"),
            (Stop::Time, LimitNames::Options) => Some("--timeout"),
            (Stop::Time, LimitNames::Settings) => Some("verification.time-limit"),
            (Stop::Cancelled | Stop::Interrupted | Stop::Answered, _) => None,
        }
    }
}

/// Advice on all checks of a report that gave up; none if there are no such checks.
pub fn of_report(report: &Report, problem: &Problem, names: LimitNames) -> Option<String> {
    let open = report.checks.iter();
    let open = open.filter(|check| check.verdict == Verdict::Unknown);
    let reasons = open.filter_map(|check| Some(check.gave_up?.reason));
    of(reasons, problem, names)
}

/// Advice on explorations that ended for these reasons.
pub fn of(
    reasons: impl IntoIterator<Item = Stop>,
    problem: &Problem,
    names: LimitNames,
) -> Option<String> {
    let mut limits: Vec<String> = Vec::new();
    for reason in reasons.into_iter().filter_map(|reason| names.of(reason)) {
        let format = format!("`{reason}`");
        if !limits.contains(&format) {
            limits.push(format);
        }
    }
    let limits = match &limits[..] {
        [] => return None,
        [limit] => limit.clone(),
        [all @ .., last] => format!("{} and {last}", all.join(", ")),
    };
    let place = match names {
        LimitNames::Options => "",
        LimitNames::Settings => " in the settings",
    };
    let smaller = smaller(&problem.scenario, problem.is_written());
    // Without a scenario, a longer time limit rarely helps.
    Some(if problem.is_written() {
        format!("raise {limits}{place}, or {smaller}")
    } else {
        format!("{smaller}, or raise {limits}{place}")
    })
}

/// The limit that an exploration exceeded: `in 10 s`.
pub fn within(gave_up: &GaveUp) -> String {
    match (gave_up.reason, gave_up.seconds) {
        (Stop::Time, Some(seconds)) => format!("in {seconds} s"),
        (Stop::Memory, _) => format!("in {} MB of memory", gave_up.memory >> 20),
        (Stop::States, _) => "within the limit of states".to_owned(),
        _ => "before it was ended".to_owned(),
    }
}

/// True if the scenario has clients that send requests.
pub fn has_clients(scenario: &Scenario) -> bool {
    let mut items = scenario.items.iter();
    items.any(|item| matches!(item, Item::Client(_)))
}

/// A way to explore less.
fn smaller(scenario: &Scenario, written: bool) -> &'static str {
    match (written, has_clients(scenario)) {
        (false, true) => "write a scenario whose client sends only the requests that matter",
        (true, true) => "let the clients of the scenario send less",
        (_, false) => {
            "explore less: `loop once`, `durations fixed` for worst cases only, or a coarser `unit`, to which \
             a first exploration rounds durations"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotgen_timing::scn::parse;

    fn problem(path: &str, text: &str) -> Problem {
        Problem {
            path: path.into(),
            text: text.to_owned(),
            scenario: parse(text).scenario,
            units: Vec::new(),
            errors: Vec::new(),
            ..Problem::default()
        }
    }

    #[test]
    fn every_reason_has_a_way_out() {
        let sending = "scenario s { use \"c.gen\"; client k { send c.a; } check deadlock; }";
        let quiet = "scenario s { use \"c.gen\"; check deadlock; }";
        let say = |path, text, reasons: &[Stop], names| {
            of(reasons.iter().copied(), &problem(path, text), names).unwrap_or_default()
        };
        let all = [
            say("c.gen", sending, &[Stop::States], LimitNames::Options),
            say("s.scn", sending, &[Stop::Memory], LimitNames::Options),
            say("s.scn", quiet, &[Stop::Time, Stop::Time], LimitNames::Settings),
            say("s.scn", quiet, &[Stop::Time, Stop::States], LimitNames::Settings),
            say("s.scn", quiet, &[Stop::Cancelled], LimitNames::Settings),
        ];
        expect_test::expect![[r"
            write a scenario whose client sends only the requests that matter, or raise `--max-states`
            raise `--max-memory`, or let the clients of the scenario send less
            raise `verification.time-limit` in the settings, or explore less: `loop once`, `durations fixed` for worst cases only, or a coarser `unit`, to which a first exploration rounds durations
            raise `verification.time-limit` and `verification.max-states` in the settings, or explore less: `loop once`, `durations fixed` for worst cases only, or a coarser `unit`, to which a first exploration rounds durations
        "]]
        .assert_eq(&all.join("\n"));
    }
}
