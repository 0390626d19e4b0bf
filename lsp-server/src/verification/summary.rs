//! Answers in the words of users: times with units, deadlines, slack.

use dotgen_analysis::model::Seconds;
use dotgen_timing::derive::Extreme;
use dotgen_timing::report::{CheckReport, Value};
use dotgen_timing::scn::ast::{Durations, Unit};
use dotgen_timing::scn::names::Names;
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
        if self.count == 1 && self.unit != Unit::Microseconds {
            return format!("{} {}", decimal(time), self.unit.name());
        }
        let micros = time * self.count as f64 * to_f64(self.unit.seconds()) * 1e6;
        show_micros(micros)
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
        to_f64(seconds) / (to_f64(self.unit.seconds()) * self.count as f64)
    }
}

fn show_micros(micros: f64) -> String {
    match micros {
        it if it >= 1e6 && (it / 1e5).fract() == 0.0 => format!("{} s", decimal(it / 1e6)),
        it if it >= 1000.0 || it == 0.0 => format!("{} ms", decimal(it / 1e3)),
        it => format!("{} us", decimal(it)),
    }
}

/// At most three decimals.
fn decimal(it: f64) -> String {
    let text = format!("{it:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    text.to_owned()
}

fn to_f64(it: Seconds) -> f64 {
    *it.numer() as f64 / *it.denom() as f64
}

/// What the value of a check must not exceed: its bound, or the period of the task.
pub fn limit(check: &CheckReport, names: &Names, scale: Scale) -> Option<f64> {
    if let Some(Value::Time(bound)) = check.bound {
        return Some(bound);
    }
    if check.check != "response" {
        return None;
    }
    let (component, task) = check.of.split_once('.')?;
    let mut members = names.components.iter();
    let member = members.find(|it| it.component.name == component)?;
    let task = member.component.tasks.iter().find(|it| it.name == task)?;
    Some(scale.from_seconds(task.period.as_ref()?.value))
}

/// How much of the limit is left, in percent; below 0 when it is exceeded.
pub fn slack(value: f64, limit: f64) -> f64 {
    (limit - value) / limit * 100.0
}

/// `24 %`; never `0 %` for what is not 0.
pub fn percent(slack: f64) -> String {
    match slack.abs() {
        it if it >= 1.0 || it == 0.0 => format!("{slack:.0} %"),
        _ => format!("{slack:.1} %"),
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_the_unit_that_suits() {
        let ms = Scale {
            count: 1,
            unit: Unit::Milliseconds,
        };
        assert_eq!(ms.show(47.0), "47 ms");
        assert_eq!(ms.show(0.76), "0.76 ms");
        let tens = Scale {
            count: 10,
            unit: Unit::Microseconds,
        };
        assert_eq!(tens.show(76.0), "760 us");
        assert_eq!(tens.show(560.0), "5.6 ms");
        assert_eq!(tens.show(200_000.0), "2 s");
        assert_eq!(tens.show(0.0), "0 ms");
    }

    #[test]
    fn slack_is_never_rounded_to_nothing() {
        assert_eq!(percent(slack(0.76, 1.0)), "24 %");
        assert_eq!(percent(slack(0.999, 1.0)), "0.1 %");
        assert_eq!(percent(slack(1.0, 1.0)), "0 %");
        assert_eq!(percent(slack(65.0, 50.0)), "-30 %");
    }
}
