//! Conversion between base units, the unit of the report, and words.

use dotgen_analysis::model::Seconds;
use dotgen_analysis::quantity;
use num_rational::Ratio;

use super::Group;
use crate::report::Value;
use crate::scn::ast::{Bound, Unit};
use crate::system::Ticks;

impl Group<'_> {
    pub(super) fn time(&self, ticks: Ticks) -> Value {
        let time = self.built.system.unit * Ratio::from_integer(i128::from(ticks));
        Value::Time(to_f64(time / self.unit))
    }

    pub(super) fn describe(&self, ticks: Ticks) -> String {
        self.with_unit(self.time(ticks))
    }

    pub(super) fn with_unit(&self, time: Value) -> String {
        match time {
            Value::Time(time) => quantity::time_of(time * to_f64(self.unit)),
            Value::Unbounded => "unbounded".to_owned(),
        }
    }

    /// Returns a limit in base units, rounded down, as times are whole. `None` if the limit is beyond the
    /// range of [`Ticks`].
    pub(super) fn ticks(&self, limit: Bound) -> Option<Ticks> {
        let ticks = (seconds(limit?) / self.built.system.unit).to_integer();
        Ticks::try_from(ticks).ok().filter(|&it| it < Ticks::MAX)
    }
}

pub(super) fn seconds((count, unit): (u64, Unit)) -> Seconds {
    unit.seconds() * Ratio::from_integer(i128::from(count))
}

pub(super) fn limit_text((count, unit): (u64, Unit)) -> String {
    format!("{count} {}", unit.name())
}

pub(crate) fn to_f64(time: Seconds) -> f64 {
    *time.numer() as f64 / *time.denom() as f64
}
