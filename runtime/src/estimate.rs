//! Probabilities from counts of independent runs.

use serde::{Deserialize, Serialize};

/// The confidence of the intervals in reports.
pub const CONFIDENCE: f64 = 0.95;

/// Halvings of an interval: more than a number has digits.
const HALVINGS: u32 = 60;

/// An interval that contains a probability, whatever it is, in a share of all samples that is at least the
/// confidence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    pub low: f64,
    pub high: f64,
    pub confidence: f64,
}

impl Estimate {
    /// Returns the exact interval for `count` of `runs` independent runs (C. Clopper, E. Pearson, *The use of
    /// confidence or fiducial limits illustrated in the case of the binomial*, Biometrika 26, 1934).
    pub fn of(count: u64, runs: u64, confidence: f64) -> Estimate {
        let tail = (1.0 - confidence) / 2.0;
        let high = |count| root(|p| at_most(count, runs, p) > tail);
        Estimate {
            // The bounds of an event are those of its opposite, from the other end.
            low: if count == 0 { 0.0 } else { 1.0 - high(runs - count) },
            high: if count >= runs { 1.0 } else { high(count) },
            confidence,
        }
    }
}

/// Returns the number of runs of which the share differs from the probability by at most half of a width,
/// with the confidence of reports, whatever the probability is (W. Hoeffding, *Probability inequalities for
/// sums of bounded random variables*, Journal of the American Statistical Association 58, 1963). `width` is
/// above 0 and at most 1.
pub fn runs_for(width: f64) -> u64 {
    (2.0 * (2.0 / (1.0 - CONFIDENCE)).ln() / (width * width)).ceil() as u64
}

/// Returns the greatest number from 0 to 1 below which a condition holds.
fn root(below: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// Returns the probability of at most `count` successes in `runs` runs, each with probability `p`, which is
/// neither 0 nor 1.
fn at_most(count: u64, runs: u64, p: f64) -> f64 {
    let odds = p.ln() - (1.0 - p).ln();
    // Logarithms: single probabilities may be smaller than any number.
    let mut term = runs as f64 * (1.0 - p).ln();
    let mut sum = term;
    for successes in 0..count {
        term += odds + ((runs - successes) as f64 / (successes + 1) as f64).ln();
        let (more, less) = if sum > term { (sum, term) } else { (term, sum) };
        sum = more + (less - more).exp().ln_1p();
    }
    sum.exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_near(one: f64, other: f64) -> bool {
        (one - other).abs() < 1e-4
    }

    /// Values of the published tables.
    #[test]
    fn intervals_are_those_of_the_tables() {
        for (count, runs, low, high) in [
            (0, 10, 0.0, 0.3085),
            (1, 10, 0.0025, 0.4450),
            (5, 10, 0.1871, 0.8129),
            (10, 10, 0.6915, 1.0),
        ] {
            let found = Estimate::of(count, runs, 0.95);
            assert!(is_near(found.low, low) && is_near(found.high, high), "{count}: {found:?}");
        }
    }

    /// The exact share of samples whose interval contains the probability.
    #[test]
    fn an_interval_contains_the_probability_as_often_as_it_says() {
        for p in [0.01, 0.1, 0.37, 0.5, 0.9] {
            let runs = 40;
            let mut covered = 0.0;
            for count in 0..=runs {
                let less = if count == 0 { 0.0 } else { at_most(count - 1, runs, p) };
                let Estimate { low, high, .. } = Estimate::of(count, runs, 0.95);
                if low <= p && p <= high {
                    covered += at_most(count, runs, p) - less;
                }
            }
            assert!(covered >= 0.95 - 1e-9, "{p}: {covered}");
        }
    }

    #[test]
    fn the_runs_for_a_width_suffice() {
        assert_eq!(runs_for(0.1), 738);
        let runs = runs_for(0.1);
        for count in [0, runs / 4, runs / 2, runs] {
            let Estimate { low, high, .. } = Estimate::of(count, runs, CONFIDENCE);
            assert!(high - low <= 0.1, "{count}: {low} {high}");
        }
    }

    #[test]
    fn many_runs_need_no_small_numbers() {
        let found = Estimate::of(20_000, 100_000, 0.99);
        assert!(found.low > 0.196 && found.high < 0.204 && found.low < 0.2 && found.high > 0.2);
    }
}
