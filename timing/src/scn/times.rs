//! Files of execution times, as laboratories keep them beside a specification: for each codel a line with its
//! function and its worst case in seconds (`NAME.wcet`).

use std::ops::Range;

use dotgen_analysis::model::Seconds;
use num_rational::Ratio;

/// Extension of such files.
pub const EXTENSION: &str = "wcet";

/// Greatest size of such a file, in bytes.
pub const MAX_BYTES: usize = 1 << 20;

/// Part of the names of the codels that GenoM3 adds to each component.
const INTERNAL: &str = "genom_";

/// Most digits of a time, and greatest power of ten.
const MAX_DIGITS: usize = 18;
const MAX_EXPONENT: i32 = 9;

/// A file of execution times that a scenario uses, or that lies beside a specification.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimesFile {
    /// Its path as written, or its name.
    pub name: String,
    /// The string in the scenario; empty if the scenario does not name the file.
    pub range: Range<usize>,
    /// The specification that it lies beside, in the order of `use`; `None` if the scenario names the file,
    /// which then applies to all specifications.
    pub beside: Option<usize>,
    pub times: Vec<GivenTime>,
}

/// The worst case of a codel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GivenTime {
    pub function: String,
    pub time: Seconds,
    /// Line of the file, from 1.
    pub line: usize,
}

impl GivenTime {
    /// Returns true for a codel that GenoM3 adds to each component: specifications do not declare it.
    pub fn is_internal(&self) -> bool {
        self.function.starts_with(INTERNAL) || self.function.contains(&format!("_{INTERNAL}"))
    }
}

/// The place where a text is no list of execution times.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Malformed {
    /// Line, from 1.
    pub line: usize,
    pub what: String,
}

/// Reads the functions and their times: words in pairs, with comments after `#`.
///
/// # Errors
/// A word without a time, a time that is no number of seconds from 0, or a function with two times.
pub fn parse(text: &str) -> Result<Vec<GivenTime>, Malformed> {
    let mut out: Vec<GivenTime> = Vec::new();
    let mut known = rustc_hash::FxHashMap::default();
    let mut open: Option<(usize, &str)> = None;
    for (line, content) in (1..).zip(text.lines()) {
        let content = content.split('#').next().unwrap_or_default();
        for word in content.split_whitespace() {
            let Some((_, function)) = open.take() else {
                open = Some((line, word));
                continue;
            };
            let malformed = |what| Err(Malformed { line, what });
            let Some(time) = seconds(word) else {
                return malformed(format!(
                    "`{word}` after `{function}` is no time in seconds, as in `{function} 0.003`"
                ));
            };
            if let Some(before) = known.insert(function, time)
                && before != time
            {
                return malformed(format!("`{function}` has a second, different time"));
            }
            out.push(GivenTime { function: function.to_owned(), time, line });
        }
    }
    match open {
        Some((line, function)) => {
            Err(Malformed { line, what: format!("`{function}` has no time") })
        }
        None => Ok(out),
    }
}

/// Parses a number of seconds: `0.003`, `3e-3`.
fn seconds(word: &str) -> Option<Seconds> {
    let (mantissa, exponent) = match word.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
        None => (word, 0),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = format!("{whole}{fraction}");
    let is_number = !digits.is_empty()
        && digits.len() <= MAX_DIGITS
        && digits.bytes().all(|digit| digit.is_ascii_digit());
    if !is_number || exponent.abs() > MAX_EXPONENT {
        return None;
    }
    let number = Ratio::from_integer(digits.parse::<i128>().ok()?);
    let power = exponent - i32::try_from(fraction.len()).ok()?;
    let factor = Ratio::from_integer(10_i128.pow(power.unsigned_abs()));
    Some(if power < 0 { number / factor } else { number * factor })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(text: &str) -> Result<Vec<(String, Seconds)>, (usize, String)> {
        let all = parse(text).map_err(|error| (error.line, error.what))?;
        Ok(all.into_iter().map(|given| (given.function, given.time)).collect())
    }

    #[test]
    fn times_are_numbers_of_seconds() {
        let expected = [("a", 3, 1000), ("b", 3, 1000), ("c", 2, 1), ("d", 1, 8)];
        let expected = expected.map(|(name, a, b)| (name.to_owned(), Ratio::new(a, b)));
        assert_eq!(pairs("a 0.003 # measured\n\nb 3e-3\nc 2 d .125\n").unwrap(), expected);
        assert_eq!(pairs("").unwrap(), []);
    }

    #[test]
    fn what_is_no_time_is_told_with_its_line() {
        for (text, line) in [
            ("a 1\nb\n", 2),
            ("a 1\nb c\n", 2),
            ("a -1\n", 1),
            ("a 1e99\n", 1),
            ("a nan\n", 1),
            ("a 1\na 2\n", 2),
        ] {
            assert_eq!(pairs(text).unwrap_err().0, line, "{text:?}");
        }
        assert!(pairs("a 1\na 1\n").is_ok());
    }

    #[test]
    fn codels_of_genom_are_recognised() {
        let is_internal = |function: &str| {
            GivenTime { function: function.to_owned(), time: Ratio::new(1, 1), line: 1 }
                .is_internal()
        };
        assert!(is_internal("CT_robot_genom_kill_codel") && is_internal("genom_connect_port"));
        assert!(!is_internal("CT_robot_ComputeSpeed"));
    }
}
