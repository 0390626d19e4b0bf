//! Conversion between base units, the unit of the report, and words.

use dotgen_analysis::model::Seconds;
use num_rational::Ratio;

use super::group::Group;
use crate::report::Value;
use crate::scn::ast::{Bound, Unit};
use crate::system::Ticks;

impl Group<'_> {
    /// Converts a time from base units to the unit of the report.
    pub(super) fn at(&self, ticks: impl Into<i128>) -> f64 {
        self.unit.from_seconds(self.built.system.seconds(ticks))
    }

    pub(super) fn time(&self, ticks: Ticks) -> Value {
        Value::Time(self.at(ticks))
    }

    pub(super) fn describe(&self, ticks: Ticks) -> String {
        self.unit.show_value(self.time(ticks))
    }

    /// Returns a limit in base units, rounded down, as times are whole. `None` if the limit is beyond the
    /// range of [`Ticks`].
    pub(super) fn ticks(&self, limit: Bound) -> Option<Ticks> {
        let ticks = (seconds(limit?) / self.built.system.unit).to_integer();
        Ticks::try_from(ticks).ok().filter(|&tick| tick < Ticks::MAX)
    }

    /// Returns a least time in base units, rounded up: what keeps the rounded time keeps the stated one. 0 if
    /// there is none.
    pub(super) fn ticks_up(&self, least: Bound) -> Ticks {
        let Some(least) = least else { return 0 };
        let ticks = (seconds(least) / self.built.system.unit).ceil().to_integer();
        Ticks::try_from(ticks).map_or(Ticks::MAX - 1, |ticks| ticks.min(Ticks::MAX - 1))
    }
}

pub(super) fn seconds((count, unit): (u64, Unit)) -> Seconds {
    unit.seconds() * Ratio::from_integer(i128::from(count))
}

pub(super) fn limit_text((count, unit): (u64, Unit)) -> String {
    format!("{count} {}", unit.name())
}
