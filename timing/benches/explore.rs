//! Time per verification on the shared corpus. Without the corpus, no time is measured.
//!
//! `cargo bench -p dotgen-timing`

use std::sync::Arc;

use camino::Utf8Path;
use divan::Bencher;
use dotgen_analysis::host::{AnalysisHost, BatchInput, Input, UnitResult};
use dotgen_loaders::Disk;
use dotgen_timing::scn::ast::{Durations, Item, Scenario};
use dotgen_timing::scn::parse;
use dotgen_timing::scn::semantics::Preset;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

fn main() {
    divan::main();
}

fn load(path: &str) -> Option<(Scenario, UnitResult)> {
    let path = dotgen_loaders::shared(&format!("corpus/{path}"))?;
    let text = std::fs::read_to_string(&path).ok()?;
    let scenario = parse(&text).scenario;
    let folder = Utf8Path::from_path(path.parent()?)?.to_owned();
    let inputs = scenario.items.iter().filter_map(|item| match item {
        Item::Use(file) => Some(Input::File(folder.join(&file.value))),
        _ => None,
    });
    let input =
        BatchInput { inputs: inputs.collect(), include_dirs: vec![folder], defines: Vec::new() };
    let host = AnalysisHost::new(Arc::new(Disk));
    let unit = host.analysis().batch(&input).ok()?;
    Some((scenario, unit))
}

fn bench(bencher: Bencher, path: &str, cores: u32, durations: Durations) {
    let Some((scenario, unit)) = load(path) else {
        return;
    };
    let options = Options {
        cores: Some(Some(cores)),
        durations: Some(durations),
        semantics: Some(Preset::Published),
        ..Options::default()
    };
    bencher.bench(|| {
        let input = SystemInput { specs: vec![&unit.spec] };
        verify(&input, &scenario, &options, &Cancel::default())
    });
}

#[divan::bench(args = [3, 4, 5], sample_count = 10)]
fn robnav_interval(bencher: Bencher, cores: u32) {
    bench(bencher, "robnav/robnav.scn", cores, Durations::Interval);
}

#[divan::bench(args = [1, 2, 3, 4, 5], sample_count = 10)]
fn robnav_fixed(bencher: Bencher, cores: u32) {
    bench(bencher, "robnav/robnav.scn", cores, Durations::Fixed);
}

#[divan::bench(args = [3, 4, 5], sample_count = 3, sample_size = 1)]
fn hover_fixed(bencher: Bencher, cores: u32) {
    bench(bencher, "quadcopter/hover.scn", cores, Durations::Fixed);
}

#[divan::bench(args = [4], sample_count = 1, sample_size = 1)]
fn hover_interval(bencher: Bencher, cores: u32) {
    bench(bencher, "quadcopter/hover.scn", cores, Durations::Interval);
}
