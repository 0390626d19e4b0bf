//! The search for the last time that holds, such as the longest execution time with which a deadline is met.

use dotgen_analysis::model::Seconds;
use num_rational::Ratio;

use crate::report::Verdict;
use crate::scn::ast::Durations;
use crate::system::settings::Settings;

/// Greatest number of steps in the base unit.
const MAX_PARTS: u32 = 1_000;

/// A limit is found to a hundredth of the time that it is compared with.
const PARTS: i128 = 100;

/// The times that are tried: multiples of a part of the base unit of the system. The base unit is the
/// greatest common divisor of the stated times, and may be as coarse as the times themselves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    /// Distance of the times, in seconds.
    pub(crate) step: Seconds,
    /// Number of steps in the base unit: 1, 2 or 5 times a power of 10.
    parts: u32,
}

impl Grid {
    /// The grid for a system with a base unit, and for limits of times like `compared`. With fixed durations
    /// a longer time can hold where a shorter one does not, and a stated unit is the one that is wanted:
    /// whole units are tried.
    pub(crate) fn of(settings: &Settings, unit: Seconds, compared: Seconds) -> Grid {
        if let Some((count, name)) = settings.unit {
            let stated = name.seconds() * Ratio::from_integer(i128::from(count));
            let parts = (unit / stated).to_integer();
            if let (true, Ok(parts @ 1..=MAX_PARTS)) =
                ((unit / stated).is_integer(), u32::try_from(parts))
            {
                return Grid { step: stated, parts };
            }
        }
        if settings.durations == Durations::Fixed {
            return Grid { step: unit, parts: 1 };
        }
        Grid::new(unit, compared)
    }

    fn new(unit: Seconds, compared: Seconds) -> Grid {
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

    /// Finds the last number of steps that holds, between one that holds and one that does not. Whole units
    /// come first: they are verified with the fewest states. `holds` gets the phase, because parts of a unit
    /// are worth less effort; one that is given up ends the search.
    pub(crate) fn last(
        self,
        mut good: u32,
        mut bad: u32,
        mut holds: impl FnMut(Seconds, Phase) -> Verdict,
    ) -> Last {
        let mut given_up = false;
        for (by, phase) in [(self.parts, Phase::Units), (1, Phase::Parts)] {
            while good.abs_diff(bad) > by {
                let middle = good.midpoint(bad);
                let whole = middle - middle % by;
                // Between the ends, also if one of them is not a multiple.
                let middle = if whole > good.min(bad) { whole } else { whole + by };
                match holds(self.time(middle), phase) {
                    verdict if verdict.holds() => good = middle,
                    Verdict::Unknown if phase == Phase::Parts => break,
                    verdict => {
                        given_up |= verdict == Verdict::Unknown;
                        bad = middle;
                    }
                }
            }
        }
        Last { steps: good, resolution: bad.abs_diff(good), given_up }
    }
}

/// The part of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Whole base units.
    Units,
    /// Parts of one unit.
    Parts,
}

impl Phase {
    /// Limit on the states of a verification.
    pub(crate) fn states(self) -> usize {
        match self {
            Phase::Units => usize::MAX,
            Phase::Parts => 20_000,
        }
    }
}

/// The end of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Last {
    /// The last number of steps that holds.
    pub(crate) steps: u32,
    /// Distance, in steps, to the first number that does not hold.
    pub(crate) resolution: u32,
    /// A verification of whole units was given up, so that greater numbers may hold.
    pub(crate) given_up: bool,
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
            let holds = |time, _| if time <= limit { Verdict::Proved } else { Verdict::Refuted };
            let last = grid.last(grid.steps(1), grid.steps(3), holds);
            assert_eq!((grid.time(last.steps), last.resolution, last.given_up), (limit, 1, false));
        }
    }

    #[test]
    fn what_is_given_up_is_not_taken_for_the_limit() {
        let grid = Grid::new(Ratio::new(1, 1000), Ratio::new(1, 10));
        let holds = |time: Seconds, _| {
            if time <= Ratio::new(1, 100) { Verdict::Proved } else { Verdict::Unknown }
        };
        assert_eq!(grid.last(5, 90, holds), Last { steps: 10, resolution: 1, given_up: true });
        let grid = Grid::new(Ratio::new(1, 100), Ratio::new(1, 10));
        let holds = |_, phase| match phase {
            Phase::Units => Verdict::Proved,
            Phase::Parts => Verdict::Unknown,
        };
        let last = grid.last(grid.steps(1), grid.steps(3), holds);
        assert_eq!(last, Last { steps: grid.steps(2), resolution: grid.steps(1), given_up: false });
    }
}
