//! `examples/drift`: one drift of each kind, each found, nothing else, and all mended.

use std::collections::BTreeSet;

use camino::Utf8PathBuf;
use dotgen_codegen::codels::command::{Project, SyncOptions, check, headers, sync};
use dotgen_codegen::codels::edit::unified_diff;
use dotgen_codegen::codels::files::FilesConfig;
use dotgen_codegen::codels::stub::StubOptions;

use crate::codels::support::{Disk, compile, compiler, host, temporary, workspace, write};

fn root() -> Utf8PathBuf {
    workspace().join("examples/drift/tank.gen")
}

fn stubs() -> StubOptions {
    StubOptions { use_parameters: true, ..StubOptions::default() }
}

#[test]
fn every_seeded_drift_is_found_and_nothing_else() {
    let mut host = host(Vec::new());
    let mut project = Project::new(&mut host, &Disk, FilesConfig::default(), stubs());
    let report = check(&mut project, &[root()]);
    let told = report.findings.iter().map(|finding| {
        let at = finding.at.as_ref().expect("a place");
        let file = at.path.file_name().unwrap_or_default();
        format!("{file}:{}:{}: {} [{}]\n", at.line, at.column, finding.message, finding.code)
    });
    insta::assert_snapshot!(told.collect::<String>());
    // Every kind is seeded.
    let kinds: BTreeSet<&str> = report.findings.iter().map(|finding| finding.code).collect();
    assert_eq!(kinds.len(), 7, "{kinds:?}");
}

#[test]
fn fix_all_leaves_nothing_to_report_and_the_code_compiles() {
    let mut host = host(Vec::new());
    let mut project = Project::new(&mut host, &Disk, FilesConfig::default(), stubs());
    let remove_yields = vec![("tank_control_main".into(), "stop".into())];
    let options = SyncOptions { remove_yields };
    let report = sync(&mut project, &[root()], &options);
    let left = report.left;
    assert!(left.findings.is_empty() && left.errors.is_empty(), "{left:#?}");
    let mut diff = String::new();
    for change in &report.changes {
        let path = change.path.strip_prefix(workspace()).expect("inside the workspace");
        diff += &unified_diff(path, change.before.as_deref(), &change.after);
    }
    insta::assert_snapshot!(diff);

    let Some(cc) = compiler("cc") else { return };
    let (_guard, folder) = temporary();
    write(&folder, &headers(&mut project, &root(), &folder, &[]).expect("types have a mapping"));
    for name in ["tank_codels.c", "tank_control_codels.c"] {
        let path = root().with_file_name("codels").join(name);
        let text = project.text(&path).expect("a source");
        let copy = folder.join(name);
        std::fs::write(&copy, &*text).expect("a temporary file");
        // A parameter that is new is not used yet.
        compile(cc, &folder, &copy, &["-Wno-unused-parameter"]).expect("the mended code compiles");
    }
}

#[test]
fn a_text_that_breaks_off_makes_no_orphans() {
    let text = std::fs::read_to_string(root()).expect("the example is there");
    let mut host = host(Vec::new());
    let mut project = Project::new(&mut host, &Disk, FilesConfig::default(), stubs());
    let mut orphans = |text: &str| -> BTreeSet<String> {
        project.overlay(root(), text.to_owned());
        let report = check(&mut project, &[root()]);
        let orphans = report.findings.into_iter().filter(|finding| finding.code == "codel/orphan");
        orphans.map(|orphan| orphan.message.to_string()).collect()
    };
    let real = orphans(&text);
    assert!(!real.is_empty());
    // Behind every third word or sign.
    let ends = text
        .char_indices()
        .filter(|(_, character)| character.is_whitespace() || ";{}(),".contains(*character));
    for end in ends.map(|end| end.0).step_by(3) {
        let found = orphans(&text[..end]);
        let made_up: Vec<_> = found.difference(&real).collect();
        assert!(made_up.is_empty(), "{made_up:?} behind {:?}", &text[end.saturating_sub(60)..end]);
    }
}

#[test]
fn sources_of_another_component_in_the_folder_are_not_judged() {
    let mut host = host(Vec::new());
    let mut project = Project::new(&mut host, &Disk, FilesConfig::default(), stubs());
    for component in ["maneuver", "nhfc", "pom", "simulator"] {
        let root = workspace().join(format!("examples/quadcopter/{component}.gen"));
        let report = check(&mut project, &[root]);
        let orphans = report.findings.iter().filter(|finding| finding.code == "codel/orphan");
        assert_eq!(orphans.count(), 0, "{component}: {report:#?}");
    }
}

/// A component that got another name by hand: its sources still include the types of the old one.
#[test]
fn sources_of_a_component_with_a_new_name_stay_its_own() {
    let (_guard, folder) = temporary();
    let source = "#include \"old_c_types.h\"\ngenom_event old_go(const genom_context self) { return genom_ok; }\n";
    let specification =
        "component new { version \"1\"; lang \"c\"; function go() { codel new_go(); }; };\n";
    std::fs::create_dir(folder.join("codels")).expect("a folder");
    std::fs::write(folder.join("codels/new_codels.c"), source).expect("a file");
    std::fs::write(folder.join("new.gen"), specification).expect("a file");
    let mut host = host(Vec::new());
    let mut project = Project::new(&mut host, &Disk, FilesConfig::default(), stubs());
    let report = check(&mut project, &[folder.join("new.gen")]);
    let mut findings = report.findings.iter();
    assert!(findings.any(|finding| finding.code == "codel/orphan"), "{report:#?}");
}
