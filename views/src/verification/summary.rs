//! Results as text: times with units, deadlines, slack.

pub use dotgen_analysis::quantity::percent;
use dotgen_timing::derive::{Extreme, MinimumCores, NextToBreak, Quantity};
use dotgen_timing::report::{TimeUnit, Value, Verdict};
use dotgen_timing::scn::ast::{CheckKind, Durations, Path};
use dotgen_timing::system::settings::Settings;

/// `4 cores, edf, durations interval`
pub fn platform(settings: &Settings) -> String {
    let policy = settings.policy().name();
    let durations = match settings.durations {
        Durations::Interval => "interval",
        Durations::Fixed => "fixed",
        Durations::Open => "open",
    };
    let semantics = settings.semantics().text();
    let cores = match settings.cores {
        None => "any number of cores".to_owned(),
        Some(1) => format!("1 core, policy {policy}"),
        Some(n) => format!("{n} cores, policy {policy}"),
    };
    format!("{cores}, durations {durations}, semantics {semantics}")
}

/// The comparison with an extreme value for a system that does not hold at its present value.
fn side(limit: &Extreme) -> &'static str {
    match (limit.extreme, limit.now) {
        (Some(Value::Time(extreme)), Value::Time(now)) if extreme > now => "from",
        _ => "up to",
    }
}

/// The extreme of a value as text, and its restriction if it is not exact.
pub fn extreme(limit: &Extreme, unit: TimeUnit) -> (String, String) {
    let extreme = match limit.extreme {
        Some(extreme) if limit.fails_now => {
            format!("holds {} {}", side(limit), unit.show_value(extreme))
        }
        Some(extreme) => unit.show_value(extreme),
        None if limit.fails_now => "missed already".to_owned(),
        None => "not known".to_owned(),
    };
    let remark = match (limit.extreme, limit.incomplete, limit.exact) {
        (Some(Value::Unbounded), ..) => "tried up to the longest period".to_owned(),
        // No value that was tried holds.
        (None, false, true) => String::new(),
        (_, true, _) => "given up there".to_owned(),
        (_, false, false) => "not known to be the limit".to_owned(),
        (_, false, true) => format!("to {}", unit.show(limit.resolution)),
    };
    (extreme, remark)
}

/// The smallest number of cores as text, and its restriction if it is not certain.
pub fn cores(minimum: &MinimumCores) -> (String, String) {
    let given_up = minimum.tried.iter().filter(|(_, verdict)| *verdict == Verdict::Unknown);
    let given_up: Vec<String> = given_up.map(|(cores, _)| cores.to_string()).collect();
    let remark = match &given_up[..] {
        [] => String::new(),
        [one] if one == "1" => "given up with 1 core".to_owned(),
        some => format!("given up with {} cores", some.join(", ")),
    };
    let cores = match (minimum.cores, minimum.tried.last()) {
        (Some(cores), _) => cores.to_string(),
        (None, Some(_)) if given_up.is_empty() => "no number is enough".to_owned(),
        (None, _) => "not known".to_owned(),
    };
    (cores, remark)
}

/// The deadlines that limits concern: `every deadline`, or those that the checks name.
pub fn deadlines(settings: &Settings) -> String {
    let checks = dotgen_timing::derive::deadlines(settings);
    let tasks = checks.iter().map(|check| match &check.kind {
        CheckKind::Schedulable(task) => task.as_ref().map(Path::text),
        _ => None,
    });
    match tasks.collect::<Option<Vec<String>>>().as_deref() {
        None => "every deadline".to_owned(),
        Some([one]) => format!("the deadline of {one}"),
        Some(some) => format!("the deadlines of {}", some.join(", ")),
    }
}

/// `the WCET of lift.report.start, above 5 ms (now 4 ms)`
pub fn next_to_break(stop: &NextToBreak, unit: TimeUnit) -> String {
    let (what, side) = match stop.quantity {
        Quantity::Wcet => ("WCET", "above"),
        Quantity::Period => ("period", "below"),
    };
    let (now, extreme) = (unit.show_value(stop.now), unit.show_value(stop.extreme));
    format!("the {what} of {}, {side} {extreme} (now {now})", stop.of)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_given_up_qualifies_the_number_of_cores() {
        use Verdict::{Proved, Refuted, Unknown};
        let text = |cores, tried: &[(u32, Verdict)]| {
            let (cores, remark) = super::cores(&MinimumCores { cores, tried: tried.to_vec() });
            format!("{cores}; {remark}")
        };
        assert_eq!(text(Some(2), &[(1, Refuted), (2, Proved)]), "2; ");
        assert_eq!(text(Some(2), &[(1, Unknown), (2, Proved)]), "2; given up with 1 core");
        let some = [(1, Unknown), (2, Unknown), (3, Proved)];
        assert_eq!(text(Some(3), &some), "3; given up with 1, 2 cores");
        assert_eq!(text(None, &[(1, Refuted), (2, Refuted)]), "no number is enough; ");
        assert_eq!(text(None, &[(1, Refuted), (2, Unknown)]), "not known; given up with 2 cores");
        assert_eq!(text(None, &[]), "not known; ");
    }

    #[test]
    fn limits_name_the_deadlines_that_they_concern() {
        let text = |checks: &str| {
            let parsed = dotgen_timing::scn::parse(&format!("scenario s {{ {checks} }}"));
            deadlines(&Settings::new(&parsed.scenario))
        };
        assert_eq!(text("check deadlock;"), "every deadline");
        assert_eq!(text("check schedulable *; check schedulable a.t;"), "every deadline");
        assert_eq!(text("check schedulable a.t; check deadlock;"), "the deadline of a.t");
        let two = "check schedulable a.t; check schedulable b.t;";
        assert_eq!(text(two), "the deadlines of a.t, b.t");
    }
}
