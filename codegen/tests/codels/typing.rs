//! Items that are being typed: while text of the specification does not parse, the sources have no new
//! findings.
//!
//! The environment variable `DOTGEN_TIMES` multiplies the number of beginnings.

use std::collections::BTreeSet;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_codegen::codels::command::{Project, check};
use dotgen_codegen::codels::files::FilesConfig;
use dotgen_codegen::codels::stub::StubOptions;
use dotgen_syntax::NodeOrToken;
use dotgen_syntax::ast::{AstNode, Item};

use crate::codels::support::{Disk, host, workspace};

/// Number of beginnings tried for each component.
const BEGINNINGS: u64 = 60;

/// The findings about the sources of a specification with this text, without what is found in detail.
fn findings(project: &mut Project<'_>, root: &Utf8Path, text: &str) -> BTreeSet<String> {
    project.overlay(root.to_owned(), text.to_owned());
    let report = check(project, &[root.to_owned()]);
    let of_codels =
        report.findings.into_iter().filter(|finding| finding.code.starts_with("codel/"));
    let subject = |message: &str| message.split(": ").next().unwrap_or_default().to_owned();
    of_codels
        .map(|finding| format!("{}: {}", finding.code, subject(&finding.message.to_string())))
        .collect()
}

/// The items of a text, each with its start and the ends of its tokens.
fn items(text: &str) -> Vec<(usize, Vec<usize>)> {
    let root = dotgen_syntax::parse_text(text).syntax();
    let items = root.descendants().filter(|node| Item::can_cast(node.kind()));
    let items = items.map(|item| {
        let tokens = item.descendants_with_tokens().filter_map(NodeOrToken::into_token);
        let tokens = tokens.filter(|token| !token.kind().is_trivia());
        let ends = tokens.map(|token| token.text_range().end().into()).collect();
        (item.text_range().start().into(), ends)
    });
    items.filter(|(start, _)| !text[*start..].starts_with('#')).collect()
}

fn components() -> Vec<Utf8PathBuf> {
    let names = ["maneuver", "mikrokopter", "nhfc", "optitrack", "pom", "simulator"];
    let names = names.map(|name| format!("examples/quadcopter/{name}.gen"));
    let names = names.into_iter().chain(["examples/drift/tank.gen".to_owned()]);
    names.map(|name| workspace().join(name)).collect()
}

#[test]
fn an_unfinished_item_adds_no_findings_in_the_sources() {
    let folders = ["examples/quadcopter/idl", "examples/maneuver/idl"];
    let folders = folders.map(|folder| workspace().join(folder));
    let mut host = host(folders.to_vec());
    let mut project =
        Project::new(&mut host, &Disk, FilesConfig::default(), StubOptions::default());
    let mut random = fastrand::Rng::with_seed(0x51_7c_c1_b7_27_22_0a_95);
    let mut bad = Vec::new();
    for root in components() {
        let text = std::fs::read_to_string(&root).expect("the example is there");
        let items = items(&text);
        let real = findings(&mut project, &root, &text);
        for _ in 0..dotgen_loaders::times(BEGINNINGS) {
            let (start, ends) = &items[random.usize(..items.len())];
            let last = ends[ends.len() - 1];
            let end = ends[random.usize(..ends.len())];
            let mut typed = text.clone();
            typed.replace_range(end..last, "\n");
            if dotgen_syntax::parse_text(&typed).errors.is_empty() {
                continue;
            }
            let all = findings(&mut project, &root, &typed);
            if let Some(first) = all.difference(&real).next() {
                let name = root.file_name().unwrap_or_default();
                bad.push(format!("{name}: {first}, after `{}`", &text[*start..end]));
            }
        }
    }
    assert!(bad.is_empty(), "{}:\n{}", bad.len(), bad.join("\n"));
}

/// The case of a port above an exception: 22 findings once.
#[test]
fn an_unfinished_port_adds_no_findings_in_the_sources() {
    let root = workspace().join("examples/quadcopter/maneuver.gen");
    let folders = ["examples/quadcopter/idl", "examples/maneuver/idl"];
    let mut host = host(folders.map(|folder| workspace().join(folder)).to_vec());
    let mut project =
        Project::new(&mut host, &Disk, FilesConfig::default(), StubOptions::default());
    let text = std::fs::read_to_string(&root).expect("the example is there");
    let real = findings(&mut project, &root, &text);
    for typed in ["port out or_rigid_body::st", "port out or_rigid_body::", "port"] {
        let at = text.find("exception e_nostate;").expect("the exception of the example");
        let mut typing = text.clone();
        typing.insert_str(at, &format!("{typed}\n  "));
        assert_eq!(findings(&mut project, &root, &typing), real, "{typed}");
    }
}
