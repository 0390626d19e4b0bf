//! A fresh clone: nothing that a component requires is there.

use std::collections::BTreeMap;
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::Severity;
use dotgen_analysis::host::{
    Analysis, AnalysisHost, Change, Config, FileContent, Loader, PackageFlags, UnitResult,
};
use dotgen_analysis::model::Name;
use dotgen_codegen::codels::drift::{Drift, MISSING_DEFINITION};
use dotgen_codegen::codels::expected::Expected;
use dotgen_codegen::codels::files::{FilesConfig, Sources};
use dotgen_codegen::codels::folder::{Folder, folders};
use dotgen_codegen::codels::stub::{StubOptions, Stubs};

use crate::codels::golden::components;
use crate::codels::support::{Disk, Memory, host_of, shared};

/// The files of one folder, with stand-ins that were written; packages are not installed.
struct Clone {
    folder: Utf8PathBuf,
    written: BTreeMap<Utf8PathBuf, String>,
}

impl Loader for Clone {
    fn read(&self, path: &Utf8Path) -> FileContent {
        match self.written.get(path) {
            Some(text) => FileContent::Text(text.clone()),
            None if path.parent() == Some(&self.folder) => Loader::read(&Disk, path),
            None => FileContent::Missing,
        }
    }

    fn packages(&self, arguments: &[String]) -> Result<PackageFlags, String> {
        Err(format!("no package {}", arguments.join(" ")))
    }
}

/// The specifications of the corpus, each with a component.
fn corpus(shared: &Utf8Path) -> Vec<Utf8PathBuf> {
    let root = shared.join("corpus/components");
    let all = walkdir::WalkDir::new(&root).sort_by_file_name();
    let all = all
        .into_iter()
        .flatten()
        .filter_map(|entry| Utf8PathBuf::from_path_buf(entry.into_path()).ok());
    all.filter(|path| path.extension() == Some("gen") && !path.starts_with(root.join("standins")))
        .filter(|path| path.file_name() != Some("Apriltag.gen"))
        .collect()
}

fn complete(shared: &Utf8Path, path: &Utf8Path) -> UnitResult {
    let host = host_of(None, vec![shared.join("corpus/components/standins")]);
    let unit = unit(&host.analysis(), path);
    assert!(unit.accepted(), "{path}: {:?}", unit.diagnostics);
    unit
}

fn unit(analysis: &Analysis, path: &Utf8Path) -> UnitResult {
    analysis.root_unit(path).expect("nothing is cancelled")
}

fn clone_of(path: &Utf8Path, written: BTreeMap<Utf8PathBuf, String>) -> AnalysisHost {
    let folder = path.parent().expect("a file is in a folder").to_owned();
    let mut host = AnalysisHost::new(Arc::new(Clone { folder, written }));
    host.apply(Change { config: Some(Config::default()), ..Change::default() });
    host
}

/// The skeleton of all components of a unit, below the folder of a specification.
fn skeleton(unit: &UnitResult, path: &Utf8Path) -> BTreeMap<Utf8PathBuf, String> {
    let beside = path.parent().expect("a file is in a folder");
    let mut out = BTreeMap::new();
    for component in components(&unit.spec) {
        let expected = Expected::new(&unit.spec, component);
        let stubs = StubOptions::default();
        for file in Stubs::new(&expected, &stubs).all_files().expect("types have a mapping") {
            out.insert(beside.join(file.path), file.text);
        }
    }
    out
}

fn folder_of(unit: &UnitResult, files: &Memory) -> Vec<Folder> {
    let config = FilesConfig::default();
    folders(unit, &mut |path| Sources::load(path, &config, files))
}

/// A finding, without the words for what is wrong: these may say less when less is known.
type Key = (&'static str, Option<(Utf8PathBuf, usize)>, Name);

fn findings(unit: &UnitResult, files: &Memory) -> Vec<(Key, Drift)> {
    let mut out = Vec::new();
    for folder in folder_of(unit, files) {
        for check in folder.check(&folder.expected()) {
            let place =
                check.source.as_ref().map(|source| (source.path.clone(), source.range.start));
            let component = &unit.spec.components[check.component];
            out.push(((check.code(), place, component.name.clone()), check));
        }
    }
    out
}

/// Sources with faults of every kind, spread over the functions.
fn with_faults(clean: &BTreeMap<Utf8PathBuf, String>) -> Memory {
    let mut number = 0;
    let mut out = BTreeMap::new();
    for (path, text) in clean {
        let mut faulty = String::new();
        for part in text.split_inclusive("\ngenom_event\n") {
            number += 1;
            let part = match number % 6 {
                // The name of the function, a parameter more, an event, an exception, a type.
                0 => part.replacen('(', "_renamed(", 1),
                1 => part.replacen(
                    "const genom_context self)",
                    "int more, const genom_context self)",
                    1,
                ),
                2 => part.replacen("return ", "return maneuver_nowhere; return ", 1),
                3 => part.replacen("double ", "float ", 1).replacen("int32_t ", "int64_t ", 1),
                4 => part.replacen("/* skeleton", "if (self) return 0; /* skeleton", 1),
                _ => part.to_owned(),
            };
            faulty += &part;
        }
        out.insert(path.clone(), faulty);
    }
    Memory(out)
}

#[test]
fn a_fresh_clone_is_compared_and_told_nothing_that_is_not_so() {
    let Some(shared) = shared() else { return };
    let (mut codels, mut judged, mut told) = (0, 0, 0);
    for path in corpus(&shared) {
        let all = complete(&shared, &path);
        let clone = clone_of(&path, BTreeMap::new());
        let alone = unit(&clone.analysis(), &path);
        let clean = skeleton(&all, &path);
        for files in [Memory(clean.clone()), with_faults(&clean)] {
            let expected = findings(&all, &files);
            let found = findings(&alone, &files);
            for (key, drift) in &found {
                let known = expected.iter().any(|finding| finding.0 == *key);
                assert!(known, "{path}: not so: {} {key:?}", drift.message());
            }
            // What the specification alone tells is found: what is missing, renamed, or has a parameter more.
            for (key, drift) in &expected {
                let plain =
                    drift.code() == MISSING_DEFINITION || drift.code() == "codel/undeclared-yield";
                let known = found.iter().any(|finding| finding.0 == *key);
                assert!(known || !plain, "{path}: not found: {}", drift.message());
            }
            told += found.len();
            for folder in folder_of(&alone, &files) {
                let coverage = folder.coverage(&folder.expected());
                codels += coverage.codels;
                judged += coverage.judged;
            }
        }
    }
    assert!(codels > 100 && told > 50, "{codels} codels, {told} findings");
    assert!(judged * 100 >= codels * 95, "{judged} of {codels} codels judged");
}

#[test]
fn a_fresh_clone_has_one_diagnostic_for_each_package() {
    let Some(shared) = shared() else { return };
    for path in corpus(&shared) {
        let clone = clone_of(&path, BTreeMap::new());
        let alone = unit(&clone.analysis(), &path);
        let errors = alone.diagnostics.iter();
        let errors = errors.filter(|error| error.severity == Severity::Error);
        let codes: Vec<_> = errors.map(|error| error.code).collect();
        let packages = alone.spec.pragma_requires.len();
        assert_eq!(codes, vec!["pp-requires-unresolved"; packages], "{path}");
    }
}

#[test]
fn stand_ins_declare_what_a_specification_uses() {
    let Some(shared) = shared() else { return };
    for path in corpus(&shared) {
        let clone = clone_of(&path, BTreeMap::new());
        let stand_ins = clone.analysis().stand_ins(&path).expect("nothing is cancelled");
        assert!(!stand_ins.is_empty(), "{path}");
        let written =
            stand_ins.into_iter().map(|stand_in| (stand_in.path, stand_in.text)).collect();
        let clone = clone_of(&path, written);
        let needs = clone.analysis().dependencies(&path).expect("nothing is cancelled");
        assert!(
            needs.includes.iter().all(|include| include.found.is_some()),
            "{path}: {:?}",
            needs.includes
        );
        assert!(
            needs.interfaces.iter().all(|interface| interface.found.is_some()),
            "{path}: {:?}",
            needs.interfaces
        );
        assert!(needs.unknown.is_empty(), "{path}: {:?}", needs.unknown);
        let unit = unit(&clone.analysis(), &path);
        let gaps = &unit.spec.gaps;
        assert!(gaps.is_empty(), "{path}: {gaps:?}");
        let errors =
            unit.diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error);
        let codes: Vec<_> = errors.map(|error| error.code).collect();
        assert!(codes.iter().all(|code| *code == "pp-requires-unresolved"), "{path}: {codes:?}");
    }
}
