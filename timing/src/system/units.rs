//! Conversion of exact times to integers (section 2).

use dotgen_analysis::model::Seconds;

use super::{FOREVER, Ticks};
use crate::scn::ast::Unit;
use num_rational::Ratio;

/// Returns the greatest unit of which all times are multiples, in seconds; one millisecond if all times are
/// zero.
pub(crate) fn base_unit(times: impl IntoIterator<Item = Seconds>) -> Seconds {
    let mut unit: Option<Seconds> = None;
    for time in times {
        if *time.numer() == 0 {
            continue;
        }
        unit = Some(match unit {
            None => time,
            Some(unit) => gcd(unit, time),
        });
    }
    unit.unwrap_or(Ratio::new(1, 1000))
}

/// gcd of a/b and c/d: gcd(ad, cb) / bd.
fn gcd(one: Seconds, other: Seconds) -> Seconds {
    let (a, b) = (*one.numer(), *one.denom());
    let (c, d) = (*other.numer(), *other.denom());
    let (mut x, mut y) = (a * d, c * b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    Ratio::new(x, b * d)
}

/// Returns a time in base units; `None` if the number is too large.
pub(crate) fn ticks(time: Seconds, unit: Seconds) -> Option<Ticks> {
    let count = time / unit;
    // The limit leaves room for sums.
    let count = u32::try_from(count.to_integer()).ok()?;
    (count < FOREVER / 4).then_some(count)
}

/// Returns a time as scenarios write it: a whole number of the greatest possible unit. `None` if no unit is
/// fine enough.
pub(crate) fn as_written(time: Seconds) -> Option<String> {
    [Unit::Seconds, Unit::Milliseconds, Unit::Microseconds].into_iter().find_map(|unit| {
        let count = time / unit.seconds();
        count.is_integer().then(|| format!("{} {}", count.to_integer(), unit.name()))
    })
}

/// Rounds up to a multiple of `unit`.
pub(crate) fn round_up(time: Seconds, unit: Seconds) -> Seconds {
    (time / unit).ceil() * unit
}

/// Rounds down to a multiple of `unit`.
pub(crate) fn round_down(time: Seconds, unit: Seconds) -> Seconds {
    (time / unit).floor() * unit
}
