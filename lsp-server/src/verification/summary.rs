//! Answers in the words of users: times with units, deadlines, slack.

use dotgen_analysis::model::Seconds;
use dotgen_analysis::quantity;
pub use dotgen_analysis::quantity::percent;
use dotgen_timing::derive::Extreme;
use dotgen_timing::report::Value;
use dotgen_timing::scn::ast::{Durations, Policy, Unit};
use dotgen_timing::system::settings::Settings;

/// The unit of a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scale {
    count: u64,
    unit: Unit,
}

impl Scale {
    /// That of the reports of these settings.
    pub fn of(settings: &Settings) -> Scale {
        let (count, unit) = settings.unit.unwrap_or((1, Unit::Milliseconds));
        Scale { count, unit }
    }

    /// A time of the report, with a unit that suits it.
    pub fn show(self, time: f64) -> String {
        quantity::time_of(time * self.count as f64 * to_f64(self.unit.seconds()))
    }

    /// Likewise, for a value.
    pub fn show_value(self, value: Value) -> String {
        match value {
            Value::Time(it) => self.show(it),
            Value::Unbounded => "unbounded".to_owned(),
        }
    }

    /// Seconds in the unit of the report.
    pub fn from_seconds(self, seconds: Seconds) -> f64 {
        let unit = self.unit.seconds() * Seconds::from_integer(i128::from(self.count));
        to_f64(seconds / unit)
    }
}

fn to_f64(it: Seconds) -> f64 {
    *it.numer() as f64 / *it.denom() as f64
}

/// `4 cores, edf, durations interval`
pub fn platform(settings: &Settings) -> String {
    let policy = match settings.policy {
        Policy::Fifo => "fifo",
        Policy::Edf => "edf",
        Policy::Any => "any",
    };
    let durations = match settings.durations {
        Durations::Interval => "interval",
        Durations::Fixed => "fixed",
        Durations::Open => "open",
    };
    match settings.cores {
        None => format!("any number of cores, durations {durations}"),
        Some(1) => format!("1 core, policy {policy}, durations {durations}"),
        Some(n) => format!("{n} cores, policy {policy}, durations {durations}"),
    }
}

/// How far a value can go, in words, and what that is worth if it is not exact.
pub(crate) fn extreme(it: &Extreme, scale: Scale) -> (String, &'static str) {
    let extreme = match it.extreme {
        Some(extreme) => scale.show_value(extreme),
        None => "missed already".to_owned(),
    };
    let remark = match (it.extreme, it.incomplete, it.exact) {
        (Some(Value::Unbounded), ..) => "tried up to the longest period",
        (_, true, _) => "given up there",
        (_, false, false) => "not known to be the limit",
        (_, false, true) => "",
    };
    (extreme, remark)
}
