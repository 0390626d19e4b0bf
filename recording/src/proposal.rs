//! Proposals of execution times, from measured times.

use dotgen_analysis::model::Seconds;
use num_rational::Ratio;

/// Nanoseconds per microsecond.
const MICRO: i128 = 1_000;

/// The factor of a proposal over the greatest measured time; at least 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Margin(Ratio<i128>);

impl Margin {
    /// Reads a decimal number of at least 1.
    ///
    /// # Errors
    ///
    /// Returns a message if the text is not such a number.
    pub fn parse(text: &str) -> Result<Margin, String> {
        let wrong = || "give a number of at least 1, for example 1.2".to_owned();
        let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
        let digits = format!("{whole}{fraction}");
        let short = digits.len() <= 12 && !whole.is_empty();
        if !short || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(wrong());
        }
        let scale = 10i128.pow(u32::try_from(fraction.len()).map_err(|_| wrong())?);
        let number: i128 = digits.parse().map_err(|_| wrong())?;
        let margin = Ratio::new(number, scale);
        if margin >= Ratio::from_integer(1) { Ok(Margin(margin)) } else { Err(wrong()) }
    }
}

/// Returns the proposed time in microseconds for a greatest time in nanoseconds: multiplied by the margin,
/// rounded up to two digits, at least one microsecond.
pub fn micros(greatest: i64, margin: Margin) -> u64 {
    let exact = Ratio::from_integer(i128::from(greatest.max(1))) * margin.0;
    let micros = (exact / Ratio::from_integer(MICRO)).ceil().to_integer();
    let mut step = 1;
    while micros > step * 100 {
        step *= 10;
    }
    let rounded = (micros + step - 1) / step * step;
    u64::try_from(rounded).unwrap_or(u64::MAX).max(1)
}

/// Returns microseconds in readable form: a whole number of the largest possible unit.
pub fn written(micros: u64) -> String {
    match micros {
        number if number % 1_000_000 == 0 => format!("{} s", number / 1_000_000),
        number if number % 1_000 == 0 => format!("{} ms", number / 1_000),
        number => format!("{number} us"),
    }
}

/// Converts microseconds to seconds.
pub fn seconds(micros: u64) -> Seconds {
    Ratio::new(i128::from(micros), 1_000_000)
}

/// The decision about the execution time of a codel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Decision {
    /// Without a time, the codel gets the proposed one.
    New,
    /// A smaller time is replaced by the proposed one.
    Raised,
    /// A time that is not smaller is kept.
    Kept,
    /// A greater time is replaced, on request.
    Lowered,
    /// The codel was never seen: there is no proposal.
    NeverSeen,
}

/// Decides. An execution time is lowered only on request (`replace`), because runs that were not recorded may
/// take longer.
pub fn decide(declared: Option<Seconds>, proposed: Option<u64>, replace: bool) -> Decision {
    match (declared, proposed.map(seconds)) {
        (_, None) => Decision::NeverSeen,
        (None, Some(_)) => Decision::New,
        (Some(declared), Some(proposed)) if declared < proposed => Decision::Raised,
        (Some(declared), Some(proposed)) if declared > proposed && replace => Decision::Lowered,
        _ => Decision::Kept,
    }
}

impl Decision {
    /// Returns true if a time must be written.
    pub fn must_write(self) -> bool {
        matches!(self, Decision::New | Decision::Raised | Decision::Lowered)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn proposals_are_never_less_than_what_was_measured_with_its_margin() {
        let margin = |text| Margin::parse(text).expect("a margin");
        let of = |nanos, text| written(micros(nanos, margin(text)));
        assert_eq!(of(1_312_323, "1.2"), "1600 us");
        assert_eq!(of(1_312_323, "1"), "1400 us");
        assert_eq!(of(0, "1.2"), "1 us");
        assert_eq!(of(999, "1"), "1 us");
        assert_eq!(of(1_001, "1"), "2 us");
        assert_eq!(of(10_000_000, "1"), "10 ms");
        assert_eq!(of(9_990_000, "1.0"), "10 ms");
        assert_eq!(of(1_000_000_001, "1"), "1100 ms");
        assert_eq!(of(2_000_000_000, "1"), "2 s");
        for nanos in (1..200_000_000).step_by(7_919) {
            for text in ["1", "1.2", "3.75"] {
                let exact = Ratio::from_integer(i128::from(nanos)) * margin(text).0;
                let micros = micros(nanos, margin(text));
                let proposed = Ratio::from_integer(i128::from(micros) * MICRO);
                assert!(proposed >= exact, "{nanos} {text}");
                // At most ten per cent and one microsecond more.
                let most = exact * Ratio::new(11, 10) + Ratio::from_integer(MICRO);
                assert!(proposed <= most, "{nanos} {text}: {micros}");
            }
        }
    }

    #[test]
    fn margins_are_numbers_from_one_on() {
        for text in ["0.9", "", "x", "-1", "1.2.3", ".5", "1e3", "99999999999999"] {
            assert!(Margin::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn nothing_is_lowered_unasked() {
        let ms = |ratio| Some(Ratio::new(ratio, 1_000));
        assert_eq!(decide(None, Some(1_000), false), Decision::New);
        assert_eq!(decide(ms(2), Some(1_000), false), Decision::Kept);
        assert_eq!(decide(ms(2), Some(1_000), true), Decision::Lowered);
        assert_eq!(decide(ms(2), Some(3_000), false), Decision::Raised);
        assert_eq!(decide(ms(2), Some(2_000), true), Decision::Kept);
        assert_eq!(decide(ms(2), None, true), Decision::NeverSeen);
    }
}
