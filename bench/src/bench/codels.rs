//! Components with sources in C and C++: checks on the command line, and typing in an editor, next to the
//! goals.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::client::Editor;
use super::measure::{self, Job};
use crate::campaign::sets::{Set, is_specification, sets};

/// Processor time of a check that every component may take, in milliseconds: twice that of `genom3 -n`.
const CHECK: f64 = 60.0;
/// Milliseconds for 1,000 lines of C or C++.
const PER_LINES: f64 = 10.0;
/// The 95th percentile from a keystroke to the answer of a pull, in milliseconds.
const KEYSTROKE: f64 = 8.0;
/// Memory of a server with one component and its sources, in MB.
const MEMORY: f64 = 60.0;

/// A line of a specification, typed a letter at a time.
const TYPED: &str = "    codel<typed> c_typed(in typed, out other) yield typed, ether;\n";

/// A component with its sources.
struct Component {
    specification: PathBuf,
    sources: Vec<PathBuf>,
    lines: usize,
}

/// Measures and prints.
pub(super) fn codels(dotgen: &Path, runs: usize) -> Result<()> {
    measure::announce()?;
    println!(
        "\n| component | lines | check, goal | keystroke p50, p95, most, goal | first lenses | actions | MB, goal |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for set in sets(false, &[])? {
        let copy = set.copy()?;
        for component in components(&set, &copy.root) {
            let check = check(dotgen, &component, runs)?;
            let goal = CHECK + PER_LINES * component.lines as f64 / 1000.0;
            let typing = typing(dotgen, &copy.root, &component)?;
            println!(
                "| {} | {} | {check:.0} ms, {goal:.0} | {:.1}, {:.1}, {:.1} ms, {KEYSTROKE} | {:.0} ms | {:.1} ms | \
                 {:.0}, {MEMORY} |",
                set.name,
                component.lines,
                typing.at(50),
                typing.at(95),
                typing.at(100),
                typing.lenses,
                typing.actions,
                typing.megabytes,
            );
        }
    }
    Ok(())
}

/// The components of a workspace that have sources.
fn components(set: &Set, root: &Path) -> Vec<Component> {
    let documents = set.documents(root);
    let of = |specification: &PathBuf| {
        let below = specification.with_file_name("codels");
        let is_source = |path: &&PathBuf| path.starts_with(&below) && !is_specification(path);
        let sources: Vec<PathBuf> = documents.iter().filter(is_source).cloned().collect();
        let texts = sources.iter().filter_map(|path| std::fs::read_to_string(path).ok());
        let lines = texts.map(|text| text.lines().count()).sum();
        Component { specification: specification.clone(), sources, lines }
    };
    let all = documents.iter().filter(|document| is_specification(document)).map(of);
    all.filter(|component| !component.sources.is_empty()).collect()
}

/// Processor time of `dotgen check`, in milliseconds.
fn check(dotgen: &Path, component: &Component, runs: usize) -> Result<f64> {
    let file = component.specification.to_string_lossy();
    let job = Job {
        program: &dotgen.to_string_lossy(),
        arguments: vec!["check".to_owned(), file.into_owned()],
        directory: component.specification.parent().context("a folder")?,
    };
    let measured = measure::alternate(&[job], runs)?.pop().flatten();
    Ok(measured.context("the check took too long")?.seconds * 1e3)
}

/// An editing session, in milliseconds and MB.
struct Typing {
    /// From each keystroke to the diagnostics, sorted.
    keystrokes: Vec<f64>,
    /// From the open document to its first lenses.
    lenses: f64,
    /// Code actions at a codel, when they are asked for the second time.
    actions: f64,
    megabytes: f64,
}

impl Typing {
    fn at(&self, percent: usize) -> f64 {
        self.keystrokes[(self.keystrokes.len() - 1) * percent / 100]
    }
}

fn typing(dotgen: &Path, root: &Path, component: &Component) -> Result<Typing> {
    let capabilities = json!({ "textDocument": { "diagnostic": {}, "codeLens": {}, "codeAction": {
        "codeActionLiteralSupport": { "codeActionKind": { "valueSet": ["quickfix", "refactor"] } } } } });
    let mut editor = Editor::start(dotgen, root, capabilities)?;
    let name = |path: &Path| -> Result<String> {
        Ok(path.strip_prefix(root)?.to_string_lossy().into_owned())
    };
    let text = std::fs::read_to_string(&component.specification)?;
    let mut opened = editor.open(&name(&component.specification)?, &text)?;
    let document = json!({ "uri": opened.uri });
    let about = json!({ "textDocument": document });
    let lenses = super::milliseconds(editor.request("textDocument/codeLens", about.clone())?);
    for source in &component.sources {
        let text = std::fs::read_to_string(source).unwrap_or_default();
        let opened = editor.open(&name(source)?, &text)?;
        let about = json!({ "textDocument": { "uri": opened.uri } });
        editor.request("textDocument/diagnostic", about)?;
    }
    editor.request("textDocument/diagnostic", about.clone())?;
    let is_codel = |line: &str| line.trim_start().starts_with("codel");
    let line = text.lines().position(is_codel).context("a component has a codel")?;
    let mut keystrokes = Vec::new();
    for (column, letter) in TYPED.chars().enumerate() {
        editor.edit(&mut opened, line, [column; 2], &letter.to_string())?;
        let time = editor.request("textDocument/diagnostic", about.clone())?;
        keystrokes.push(super::milliseconds(time));
    }
    keystrokes.sort_unstable_by(f64::total_cmp);
    let mut actions = 0.0;
    for _ in 0..2 {
        let at = json!({ "line": line + 1, "character": 6 });
        let params = json!({ "textDocument": document, "range": { "start": at, "end": at },
            "context": { "diagnostics": Value::Array(Vec::new()) } });
        actions = super::milliseconds(editor.request("textDocument/codeAction", params)?);
    }
    let megabytes = editor.memory("VmHWM")?;
    editor.end()?;
    Ok(Typing { keystrokes, lenses, actions, megabytes })
}
