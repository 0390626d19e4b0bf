//! Scenarios of files, prepared for an export.

use std::path::Path;
use std::sync::Arc;

use dotgen_analysis::host::{AnalysisHost, BatchInput, Input, UnitResult};
use dotgen_analysis::model::Src;
use dotgen_analysis::source_map::Locations;
use dotgen_loaders::Disk;
use dotgen_timing::report::Report;
use dotgen_timing::scn::ast::{Item, Scenario};
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, Prepared, SystemInput, prepare, verify};

/// A scenario with its specifications.
pub(crate) struct System {
    scenario: Scenario,
    units: Vec<UnitResult>,
}

impl System {
    /// Reads a scenario and its specifications.
    pub(crate) fn read(path: &Path) -> System {
        let text = std::fs::read_to_string(path).expect("the scenario exists");
        let parsed = parse(&text);
        assert_eq!(parsed.errors, [], "{}", path.display());
        let folder = path.parent().expect("the scenario is in a folder");
        let folder = camino::Utf8PathBuf::from_path_buf(folder.to_owned()).expect("UTF-8");
        let used = parsed.scenario.items.iter().filter_map(|item| match item {
            Item::Use(file) => Some(Input::File(folder.join(&file.value))),
            _ => None,
        });
        let input = BatchInput {
            inputs: used.collect(),
            include_dirs: vec![folder.join("idl"), folder],
            defines: Vec::new(),
        };
        let host = AnalysisHost::new(Arc::new(Disk));
        let unit = host.analysis().batch(&input).expect("nobody cancels");
        System { scenario: parsed.scenario, units: vec![unit] }
    }

    /// Returns a system of texts; `None` if a specification has an error.
    pub(crate) fn of_texts(specifications: &[String], scenario: &str) -> Option<System> {
        let parsed = parse(scenario);
        assert_eq!(parsed.errors, [], "{scenario}");
        let units = specifications.iter().map(|text| dotgen_loaders::unit(text).ok());
        Some(System { scenario: parsed.scenario, units: units.collect::<Option<_>>()? })
    }

    pub(crate) fn prepared(&self, options: &Options) -> Prepared {
        prepare(&self.input(), &self.scenario, options)
    }

    /// Returns the place of a declaration, as `FILE:LINE`.
    pub(crate) fn place(&self, _component: usize, src: Src) -> Option<String> {
        let at = self.units.first()?.locations.locate(src)?;
        let text = std::fs::read_to_string(&at.path).ok()?;
        let line = 1 + text[..at.range.start].matches('\n').count();
        Some(format!("{}:{line}", at.path.file_name()?))
    }

    /// Returns the answers of the verifier.
    pub(crate) fn report(&self, options: &Options) -> Report {
        verify(&self.input(), &self.scenario, options, &Cancel::default())
    }

    fn input(&self) -> SystemInput<'_> {
        SystemInput { specs: self.units.iter().map(|unit| &*unit.spec).collect() }
    }
}

/// Pseudo-random choices from a seed: the generator `SplitMix64` (Steele, Lea and Flood 2014).
pub(crate) struct Dice(u64);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Dice(seed)
    }

    /// Returns a number from 0 to below `n`.
    pub(crate) fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % u64::from(n)) as u32
    }

    pub(crate) fn in_ten(&mut self, n: u32) -> bool {
        self.below(10) < n
    }

    pub(crate) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len() as u32) as usize]
    }
}
