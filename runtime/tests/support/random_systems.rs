//! Random systems of all that the servers do, as tests of verification make them.

use std::sync::Arc;

use camino::Utf8Path;
use dotgen_analysis::diagnostic::Severity;
use dotgen_analysis::host::{
    AnalysisHost, BatchInput, FileContent, Input, Loader, PackageFlags, UnitResult,
};

#[allow(dead_code, reason = "shared with the tests of verification")]
#[path = "../../../timing/tests/agreement/servers/random.rs"]
pub(crate) mod random;

/// What the random texts are made with.
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

struct Nothing;

impl Loader for Nothing {
    fn read(&self, _: &Utf8Path) -> FileContent {
        FileContent::Missing
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags::default())
    }
}

/// Specifications, each compiled alone; `None` if one has errors: machines are drawn at random.
pub(crate) fn load(texts: &[String]) -> Option<Vec<UnitResult>> {
    let host = AnalysisHost::new(Arc::new(Nothing));
    let load = |text: &String| {
        let input = BatchInput {
            inputs: vec![Input::Text {
                name: "test.gen".into(),
                text: text.as_str().into(),
            }],
            ..BatchInput::default()
        };
        let unit = host.analysis().batch(&input).expect("nobody cancels");
        let mut errors = unit.diagnostics.iter();
        let error = errors.any(|it| it.severity == Severity::Error);
        (!error).then_some(unit)
    };
    texts.iter().map(load).collect()
}
