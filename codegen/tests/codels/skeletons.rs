//! What a release's own `skeleton` writes is in step with the specification as that release reads it.

use std::collections::BTreeMap;
use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_analysis::host::{BatchInput, Input};
use dotgen_analysis::model::{ComponentId, ComponentKind, Spec};
use dotgen_analysis::release::{CHANGES, Release};
use dotgen_codegen::codels::drift::{self, DriftOptions};
use dotgen_codegen::codels::expected::Expected;
use dotgen_codegen::codels::files::{FilesConfig, Sources};
use dotgen_codegen::codels::stub::{StubOptions, Stubs};

use crate::codels::support::{Memory, host_of, shared, temporary};

/// What releases write differently: ports, tasks and codels through interfaces, details of exceptions,
/// bounded sequences.
const SPECIFICATION: &str = "
interface pose {
  struct at { double x, y; };
  exception e_lost { long code; };
  port out at frame;
  task shared { codel<start> poseStart(port out frame) yield ether; };
  function where(out double x) { codel poseWhere(out x); throw e_lost; };
};
component lamp {
  provides pose;
  version \"1.0\"; lang \"LANG\"; email \"a@example.org\"; require \"genom3 >= 2.99.26\";
  native handle;
  exception e_broken { string<16> why; }, e_dark;
  enum colour { RED, GREEN };
  struct light { colour which; double power[3]; sequence<octet, 8> raw; optional<long> limit; };
  ids { light set; handle it; sequence<double> past; };
  port in light other;
  port multiple out light all;
  task blink {
    period 5 ms;
    codel<start> lampStart(ids out set, port in other, port out all) yield loop, ether;
    codel<loop, again> lampLoop(ids inout set, ids in past, inout ::it)
      yield pause::loop, again, ether;
    throw e_broken, e_dark;
  };
  attribute power(inout set.power) { validate lampPower(in power); throw e_dark; };
  function reset(in long level = 1: \"How bright\", out string<8> said) {
    codel lampReset(in level, out said); throw e_broken;
  };
  activity shine(in light to) {
    task blink;
    validate lampCheck(in to);
    codel<start> lampShine(in to, port out all) yield more;
    codel<more, start_over> lampMore(inout ::set) yield pause::more, start_over, ether;
    throw e_broken, e_dark;
    interrupts shine;
  };
};
";

/// Every release that differs from the one before.
fn releases() -> Vec<Release> {
    let mut all: Vec<Release> = CHANGES.iter().map(|change| change.since).collect();
    all.extend([Release::OLDEST, Release::V3]);
    all.sort();
    all.dedup();
    all
}

/// What is found in unchanged stubs of a component, and how many functions they have.
fn findings(
    spec: &Spec,
    component: ComponentId,
    compile_as_cxx: bool,
) -> Option<(Vec<String>, usize)> {
    let expected = Expected::new(spec, component);
    let options = StubOptions { compile_as_cxx, ..StubOptions::default() };
    let stubs = Stubs::new(&expected, &options).all_files().ok()?;
    let mut files = BTreeMap::from([(Utf8PathBuf::from("/c.gen"), String::new())]);
    files.extend(stubs.into_iter().map(|stub| (Utf8PathBuf::from("/").join(stub.path), stub.text)));
    let files = Memory(files);
    let sources = Sources::load("/c.gen".into(), &FilesConfig::default(), &files);
    let count = expected.functions.len();
    let found = drift::check(&[expected], &sources, &DriftOptions::default());
    let found = found.iter().map(|check| format!("{}: {}", check.code(), check.message()));
    Some((found.collect(), count))
}

/// Reads a specification as a release does; `None` where that refuses it.
fn read(release: Release, file: Utf8PathBuf, include_dirs: Vec<Utf8PathBuf>) -> Option<Arc<Spec>> {
    let input = BatchInput {
        inputs: vec![Input::File(file)],
        include_dirs: include_dirs.clone(),
        ..BatchInput::default()
    };
    let unit = host_of(Some(release), include_dirs).analysis().batch(&input);
    let unit = unit.expect("nothing is cancelled");
    unit.accepted().then_some(unit.spec)
}

fn components(spec: &Spec) -> impl Iterator<Item = ComponentId> {
    let all = spec.components.iter_enumerated();
    all.filter(|(_, component)| component.kind == ComponentKind::Component)
        .map(|(number, _)| number)
}

#[test]
fn skeletons_of_each_release_have_no_finding() {
    let (_guard, folder) = temporary();
    for release in releases() {
        for (lang, compile_as_cxx) in [("c", false), ("c", true), ("c++", true)] {
            let file = folder.join(format!("{lang}.gen"));
            std::fs::write(&file, SPECIFICATION.replace("LANG", lang)).expect("a file");
            let spec = read(release, file, Vec::new()).expect("every release accepts it");
            for component in components(&spec) {
                let (found, count) =
                    findings(&spec, component, compile_as_cxx).expect("types have a mapping");
                assert_eq!(found, [""; 0], "{release} {lang}");
                assert!(count >= 8, "{release} {lang}: {count} functions");
            }
        }
    }
}

#[test]
fn skeletons_of_published_specifications_have_no_finding() {
    let Some(shared) = shared() else { return };
    let includes = ["corpus/quadcopter", "corpus/components/standins", "golden/standins"];
    let includes: Vec<Utf8PathBuf> = includes.iter().map(|include| shared.join(include)).collect();
    let mut count = 0;
    for folder in ["corpus", "golden/inputs"] {
        for entry in walkdir::WalkDir::new(shared.join(folder)) {
            let path = Utf8PathBuf::from_path_buf(entry.expect("a folder").into_path());
            let path = path.expect("UTF-8");
            if path.extension() != Some("gen") {
                continue;
            }
            for release in [Release::V2_99_39, Release::V2_99_41, Release::V2_99_42, Release::V3] {
                let Some(spec) = read(release, path.clone(), includes.clone()) else {
                    continue;
                };
                for component in components(&spec) {
                    for compile_as_cxx in [false, true] {
                        let Some((found, functions)) = findings(&spec, component, compile_as_cxx)
                        else {
                            continue;
                        };
                        assert_eq!(found, [""; 0], "{path} {release}");
                        count += functions;
                    }
                }
            }
        }
    }
    assert!(count > 500, "{count} functions");
}
