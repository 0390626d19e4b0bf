//! Random systems with all features of the servers, as the tests of verification make them.

use dotgen_analysis::host::UnitResult;
use dotgen_loaders::unit;

#[allow(dead_code, reason = "shared with the tests of verification")]
#[path = "../../../timing/tests/agreement/servers/random.rs"]
pub(crate) mod random;

/// The parts from which random texts are made.
pub(crate) mod systems {
    pub(crate) struct Dice(fastrand::Rng);

    impl Dice {
        pub(crate) fn new(seed: u64) -> Self {
            Dice(fastrand::Rng::with_seed(seed))
        }

        pub(crate) fn below(&mut self, n: u32) -> u32 {
            self.0.u32(..n)
        }

        pub(crate) fn in_ten(&mut self, n: u32) -> bool {
            self.below(10) < n
        }

        pub(crate) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
            from[self.0.usize(..from.len())]
        }
    }
}

/// Compiles each specification alone; `None` if one has errors, as machines are random.
pub(crate) fn load(texts: &[String]) -> Option<Vec<UnitResult>> {
    texts.iter().map(|text| unit(text).ok()).collect()
}
