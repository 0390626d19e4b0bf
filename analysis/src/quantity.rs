//! Formatting of times and loads for display.

use crate::model::Seconds;

/// A time in the unit that gives a short text: `6.38 ms`, `500 µs`, `2 s`, at most three digits after the
/// point.
pub fn time(seconds: Seconds) -> String {
    let exact = |per_second: i128| seconds * Seconds::from_integer(per_second);
    // A fraction of milliseconds is easier to compare than thousands of microseconds.
    let whole_seconds = exact(1).is_integer() && *seconds.numer() != 0;
    if whole_seconds {
        return format!("{} s", exact(1).to_integer());
    }
    time_of(*seconds.numer() as f64 / *seconds.denom() as f64)
}

/// Like [`time`], for seconds as a float. Rounding errors of binary fractions are not visible.
pub fn time_of(seconds: f64) -> String {
    let (number, unit) = number_and_unit(seconds);
    format!("{number} {unit}")
}

/// A share of a time, both in seconds, with one unit if both have the same: `8 of 10 ms`, `500 µs of 10 ms`.
pub fn share_of(seconds: f64, whole: f64) -> String {
    let (part, whole) = (number_and_unit(seconds), number_and_unit(whole));
    if part.1 == whole.1 {
        format!("{} of {} {}", part.0, whole.0, whole.1)
    } else {
        format!("{} {} of {} {}", part.0, part.1, whole.0, whole.1)
    }
}

/// A time as a number, and the unit that gives a short text.
fn number_and_unit(seconds: f64) -> (String, &'static str) {
    let micros = seconds * 1e6;
    match micros.abs() {
        number if number >= 6e8 => (decimal(micros / 6e7), "min"),
        number if number >= 1e7 || number >= 1e6 && is_whole(number / 1e5) => {
            (decimal(micros / 1e6), "s")
        }
        number if number >= 1e3 || number == 0.0 => (decimal(micros / 1e3), "ms"),
        number if number >= 1.0 => (decimal(micros), "µs"),
        _ => (decimal(micros * 1e3), "ns"),
    }
}

fn is_whole(number: f64) -> bool {
    (number - number.round()).abs() < 1e-6
}

/// At most three digits after the point.
fn decimal(number: f64) -> String {
    let text = format!("{number:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A share of a processor core or of a limit, as a percentage: `45 %`, `0.4 %`; never `0 %` for a positive
/// share.
pub fn load(share: Seconds) -> String {
    percent(*share.numer() as f64 / *share.denom() as f64 * 100.0)
}

/// Like [`load`], for a number of percent.
pub fn percent(percent: f64) -> String {
    match percent.abs() {
        number if number >= 10.0 || is_whole(number) => format!("{percent:.0} %"),
        number if number >= 0.1 => {
            let text = format!("{percent:.1}");
            format!("{} %", text.strip_suffix(".0").unwrap_or(&text))
        }
        _ if percent < 0.0 => ">-0.1 %".to_owned(),
        _ => "<0.1 %".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_the_unit_that_suits() {
        let us = |count| time(Seconds::new(count, 1_000_000));
        let all = [0, 1, 500, 999, 1_000, 6_380, 47_000, 100_000, 1_500_000, 2_000_000];
        assert_eq!(
            all.map(us),
            [
                "0 ms", "1 µs", "500 µs", "999 µs", "1 ms", "6.38 ms", "47 ms", "100 ms", "1.5 s",
                "2 s"
            ]
        );
        assert_eq!(time(Seconds::new(1, 3_000)), "333.333 µs");
        assert_eq!(time(Seconds::new(1, 4_000_000)), "250 ns");
        assert_eq!(time_of(0.1 + 0.2), "300 ms");
        assert_eq!(share_of(0.008, 0.01), "8 of 10 ms");
        assert_eq!(share_of(0.000_5, 0.01), "500 µs of 10 ms");
    }

    #[test]
    fn what_is_not_nothing_is_not_shown_as_nothing() {
        let all = [0.0, 0.04, 0.4, 0.96, 3.04, 9.96, 10.4, 45.0, 100.000_000_000_000_01, -30.0];
        assert_eq!(
            all.map(percent),
            ["0 %", "<0.1 %", "0.4 %", "1 %", "3 %", "10 %", "10 %", "45 %", "100 %", "-30 %"]
        );
        assert_eq!(load(Seconds::new(1, 250)), "0.4 %");
    }
}
