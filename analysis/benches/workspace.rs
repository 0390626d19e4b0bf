//! A workspace of 100 components: the time of the cold check, and of one keystroke until all diagnostics of
//! the file are computed again.

use std::sync::Arc;

use camino::Utf8PathBuf;
use divan::Bencher;
use dotgen_analysis::diagnostic::Severity;
use dotgen_analysis::host::{Analysis, AnalysisHost, Change};
use dotgen_loaders::{Disk, EmptyLoader};

mod components;

use components::{TYPES, component};

const COMPONENTS: usize = 100;
fn main() {
    // Before other benchmarks have used memory.
    if let Some(before) = resident_megabytes() {
        let host = workspace();
        check_all(&host.analysis());
        let after = resident_megabytes().unwrap_or(before);
        println!("memory of {COMPONENTS} components: {} MB", after - before);
    }
    divan::main();
}

fn path(i: usize) -> Utf8PathBuf {
    format!("/w/c{i}.gen").into()
}

fn workspace() -> AnalysisHost {
    let mut host = AnalysisHost::new(Arc::new(EmptyLoader));
    let mut files = vec![(Utf8PathBuf::from("/w/types.idl"), Some(TYPES.to_owned()))];
    files.extend((0..COMPONENTS).map(|i| (path(i), Some(component(i)))));
    host.apply(Change {
        files,
        roots: Some((0..COMPONENTS).map(path).collect()),
        ..Change::default()
    });
    host
}

fn check_all(analysis: &Analysis) {
    for i in 0..COMPONENTS {
        let found = analysis.diagnostics(&path(i)).unwrap_or_default();
        let rejected = found.iter().any(|diagnostic| diagnostic.severity == Severity::Error);
        assert!(!rejected, "{found:#?}");
    }
}

/// The first check of one component, with an empty database.
#[divan::bench(sample_count = 50)]
fn cold_component(bencher: Bencher<'_, '_>) {
    bencher
        .with_inputs(|| {
            let mut host = AnalysisHost::new(Arc::new(EmptyLoader));
            let types = ("/w/types.idl".into(), Some(TYPES.to_owned()));
            host.apply(Change {
                files: vec![types, (path(0), Some(component(0)))],
                roots: Some(vec![path(0)]),
                ..Change::default()
            });
            host
        })
        .bench_values(|host| host.analysis().diagnostics(&path(0)));
}

/// The first check of the whole workspace.
#[divan::bench(sample_count = 5)]
fn cold_workspace(bencher: Bencher<'_, '_>) {
    bencher.with_inputs(workspace).bench_values(|host| check_all(&host.analysis()));
}

/// A change of one name, inside one codel.
#[divan::bench(sample_count = 200)]
fn keystroke_in_a_codel(bencher: Bencher<'_, '_>) {
    keystrokes(bencher, 50, |text| text.replacen("c50_step7(", "c50_stepX(", 1));
}

/// A change in a comment.
#[divan::bench(sample_count = 200)]
fn keystroke_in_a_comment(bencher: Bencher<'_, '_>) {
    keystrokes(bencher, 50, |text| text.replacen('\n', " // note\n", 1));
}

/// Samples alternate between the edit and its reversal.
fn keystrokes(bencher: Bencher<'_, '_>, i: usize, edit: impl Fn(&str) -> String) {
    let mut host = workspace();
    check_all(&host.analysis());
    let before = component(i);
    let after = edit(&before);
    assert_ne!(before, after);
    let mut edited = false;
    bencher.bench_local(|| {
        edited = !edited;
        let text = if edited { &after } else { &before };
        host.apply(Change { files: vec![(path(i), Some(text.clone()))], ..Change::default() });
        let analysis = host.analysis();
        analysis.diagnostics(&path(i))
    });
}

fn resident_megabytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes / 1024)
}

/// Cold check of the largest published component in the shared test data, if present.
#[divan::bench]
fn cold_check_of_the_largest_real_specification(bencher: Bencher<'_, '_>) {
    let corpus = dotgen_loaders::shared("corpus/components");
    let Some(corpus) = corpus.and_then(|corpus| Utf8PathBuf::from_path_buf(corpus).ok()) else {
        return;
    };
    let folders = corpus.read_dir_utf8().into_iter().flatten().flatten();
    let files =
        folders.flat_map(|folder| folder.path().read_dir_utf8().into_iter().flatten().flatten());
    let sizes = files
        .filter(|file| file.path().extension() == Some("gen"))
        .filter_map(|file| Some((file.metadata().ok()?.len(), file.path().to_owned())));
    let Some((_, largest)) = sizes.max() else {
        return;
    };
    bencher.bench(|| {
        let mut host = AnalysisHost::new(Arc::new(Disk));
        host.apply(Change {
            roots: Some(vec![largest.clone()]),
            config: Some(dotgen_analysis::host::Config {
                include_dirs: vec![corpus.join("standins")],
                ..Default::default()
            }),
            ..Change::default()
        });
        host.analysis().diagnostics(&largest).map(|diagnostic| diagnostic.len()).unwrap_or_default()
    });
}
