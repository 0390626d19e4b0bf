//! The search for the last time that holds, such as the longest execution time with which a deadline is met.

use dotgen_analysis::model::Seconds;
use num_rational::Ratio;

use crate::report::Verdict;

/// A limit is found to a hundredth of the time that it is compared with.
const PARTS: i128 = 100;

/// The times that are tried: multiples of a part of the base unit of the system. The base unit is the greatest common
/// divisor of the stated times, and may be as coarse as the times themselves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    /// Distance of the times, in seconds.
    pub(crate) step: Seconds,
    /// Number of steps in the base unit: 1, 2 or 5 times a power of 10.
    parts: u32,
}

impl Grid {
    /// The grid for a system with a base unit, and for limits of times like `compared`.
    pub(crate) fn new(unit: Seconds, compared: Seconds) -> Grid {
        let wanted = compared / Ratio::from_integer(PARTS);
        let part = |parts: &u32| unit / Ratio::from_integer(i128::from(*parts));
        let nice = [1, 10, 100, 1000].into_iter().flat_map(|tens| [1, 2, 5].map(|n| n * tens));
        let parts = nice.clone().find(|parts| part(parts) <= wanted);
        let parts = parts.unwrap_or(1000);
        Grid { step: part(&parts), parts }
    }

    /// The time of a number of steps.
    pub(crate) fn time(self, steps: u32) -> Seconds {
        self.step * Ratio::from_integer(i128::from(steps))
    }

    /// The number of steps of a number of base units, at most the greatest number.
    pub(crate) fn steps(self, units: u32) -> u32 {
        units.saturating_mul(self.parts)
    }

    /// Returns the last number of steps that holds, between one that holds and one that does not, and the number of steps
    /// from there to one that is known not to hold: more than 1 if a verification was given up.
    ///
    /// Whole units come first: they are verified with the fewest states.
    pub(crate) fn last(
        self,
        mut good: u32,
        mut bad: u32,
        mut holds: impl FnMut(Seconds) -> Verdict,
    ) -> (u32, u32) {
        let mut unsure = None;
        for by in [self.parts, 1] {
            while good.abs_diff(bad) > by {
                let middle = good.midpoint(bad);
                let whole = middle - middle % by;
                // Between the ends, also if one of them is not a multiple.
                let middle = if whole > good.min(bad) { whole } else { whole + by };
                match holds(self.time(middle)) {
                    verdict if verdict.holds() => good = middle,
                    Verdict::Unknown => {
                        unsure.get_or_insert(bad);
                        bad = middle;
                    }
                    _ => bad = middle,
                }
            }
        }
        (good, unsure.unwrap_or(bad).abs_diff(good))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_found_between_the_multiples_of_the_unit() {
        let milliseconds = |n: i128, d: i128| Ratio::new(n, 1000 * d);
        let grid = Grid::new(milliseconds(2, 1), milliseconds(10, 1));
        assert_eq!(grid.step, milliseconds(1, 10));
        for tenths in 21..60 {
            let limit = milliseconds(tenths, 10);
            let holds = |time| if time <= limit { Verdict::Proved } else { Verdict::Refuted };
            let (last, unsure) = grid.last(grid.steps(1), grid.steps(3), holds);
            assert_eq!((grid.time(last), unsure), (limit, 1));
        }
    }

    #[test]
    fn what_is_given_up_is_not_taken_for_the_limit() {
        let grid = Grid::new(Ratio::new(1, 1000), Ratio::new(1, 10));
        let holds = |time: Seconds| {
            if time <= Ratio::new(1, 100) { Verdict::Proved } else { Verdict::Unknown }
        };
        let (last, unsure) = grid.last(5, 90, holds);
        assert_eq!((last, unsure), (10, 80));
    }
}
