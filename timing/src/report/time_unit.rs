//! The unit of the times of a report, and times in it as text.

use dotgen_analysis::model::Seconds;
use dotgen_analysis::quantity;
use serde::de::{Deserializer, Error as _};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::Value;
use crate::scn::ast::Unit;
use crate::system::settings::Settings;

/// The unit of all times of a report: a number of units of a scenario. As text and in JSON: `ms`, `10 us`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeUnit {
    /// Number of base units.
    pub count: u64,
    pub base: Unit,
}

impl Default for TimeUnit {
    fn default() -> Self {
        TimeUnit { count: 1, base: Unit::Milliseconds }
    }
}

impl TimeUnit {
    /// Returns the unit of the reports with these settings.
    pub fn of(settings: &Settings) -> TimeUnit {
        let stated = settings.unit.map(|(count, base)| TimeUnit { count, base });
        stated.unwrap_or_default()
    }

    /// Returns the unit in seconds.
    pub fn seconds(self) -> Seconds {
        self.base.seconds() * Seconds::from_integer(i128::from(self.count))
    }

    /// Returns the number of these units in a time.
    pub fn from_seconds(self, time: Seconds) -> f64 {
        to_f64(time / self.seconds())
    }

    /// Returns a time in this unit, converted to a base unit.
    pub fn in_base(self, time: f64, base: Unit) -> f64 {
        time * to_f64(self.seconds() / base.seconds())
    }

    /// Returns a time in this unit as text for readers, in the base unit that gives a short text.
    pub fn show(self, time: f64) -> String {
        quantity::time_of(time * to_f64(self.seconds()))
    }

    /// Returns a share of a time, both in this unit, as text for readers: `8 of 10 ms`.
    pub fn show_share(self, time: f64, whole: f64) -> String {
        let unit = to_f64(self.seconds());
        quantity::share_of(time * unit, whole * unit)
    }

    /// Returns a value in this unit as text for readers.
    pub fn show_value(self, value: Value) -> String {
        match value {
            Value::Time(time) => self.show(time),
            Value::Unbounded => "unbounded".to_owned(),
        }
    }
}

impl std::fmt::Display for TimeUnit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.count {
            1 => f.write_str(self.base.name()),
            count => write!(f, "{count} {}", self.base.name()),
        }
    }
}

impl Serialize for TimeUnit {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for TimeUnit {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<TimeUnit, D::Error> {
        let text = String::deserialize(from)?;
        let (count, base) = text.split_once(' ').unwrap_or(("1", &text));
        let base = [Unit::Seconds, Unit::Milliseconds, Unit::Microseconds]
            .into_iter()
            .find(|unit| unit.name() == base);
        let unit = base.zip(count.parse().ok().filter(|&count| count > 0));
        let unit = unit.map(|(base, count)| TimeUnit { count, base });
        unit.ok_or_else(|| D::Error::custom(format!("`{text}` is no unit of time")))
    }
}

/// Returns an exact time as the nearest float.
pub(crate) fn to_f64(time: Seconds) -> f64 {
    *time.numer() as f64 / *time.denom() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_of_one_base_unit_has_no_number() {
        let unit = TimeUnit::default();
        assert_eq!(unit.to_string(), "ms");
        let unit = TimeUnit { count: 10, base: Unit::Microseconds };
        assert_eq!(serde_json::to_string(&unit).ok().as_deref(), Some("\"10 us\""));
        assert_eq!(serde_json::from_str::<TimeUnit>("\"10 us\"").ok(), Some(unit));
        assert!(serde_json::from_str::<TimeUnit>("\"0 us\"").is_err());
        assert_eq!(unit.in_base(150.0, Unit::Milliseconds), 1.5);
        assert_eq!(unit.show(5.0), "50 µs");
    }
}
