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
    unit: UnitResult,
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
        System { scenario: parsed.scenario, unit }
    }

    pub(crate) fn prepared(&self, options: &Options) -> Prepared {
        prepare(&self.input(), &self.scenario, options)
    }

    /// Returns the place of a declaration, as `FILE:LINE`.
    pub(crate) fn place(&self, _component: usize, src: Src) -> Option<String> {
        let at = self.unit.locations.locate(src)?;
        let text = std::fs::read_to_string(&at.path).ok()?;
        let line = 1 + text[..at.range.start].matches('\n').count();
        Some(format!("{}:{line}", at.path.file_name()?))
    }

    /// Returns the answers of the verifier.
    pub(crate) fn report(&self, options: &Options) -> Report {
        verify(&self.input(), &self.scenario, options, &Cancel::default())
    }

    fn input(&self) -> SystemInput<'_> {
        SystemInput { specs: vec![&self.unit.spec] }
    }
}
