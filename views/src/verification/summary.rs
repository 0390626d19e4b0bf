//! Results as text: times with units, deadlines, slack.

pub use dotgen_analysis::quantity::percent;
use dotgen_timing::derive::{Extreme, NextToBreak, Quantity};
use dotgen_timing::report::{TimeUnit, Value};
use dotgen_timing::scn::ast::Durations;
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

/// `the WCET of lift.report.start, above 5 ms (now 4 ms)`
pub fn next_to_break(stop: &NextToBreak, unit: TimeUnit) -> String {
    let (what, side) = match stop.quantity {
        Quantity::Wcet => ("WCET", "above"),
        Quantity::Period => ("period", "below"),
    };
    let (now, extreme) = (unit.show_value(stop.now), unit.show_value(stop.extreme));
    format!("the {what} of {}, {side} {extreme} (now {now})", stop.of)
}
