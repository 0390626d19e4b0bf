//! Tests in editors: Neovim, Emacs, the pages of the extension in Chromium, and VS Code.

use anyhow::{Context, Result};

use super::{TestCounts, copy, count};
use crate::workbench::Workbench;
use xtask::extension::{self, Profile};
use xtask::run::{self, step};
use xtask::shared;
use xtask::tools;

pub(super) fn neovim() -> Result<TestCounts> {
    tools::ensure(tools::NEOVIM)?;
    let script = xtask::root().join("tests/editors/neovim/nvim.lua");
    let arguments = [
        "--headless",
        "--clean",
        "-n",
        "-i",
        "NONE",
        "-u",
        &*script.to_string_lossy(),
        "maneuver.gen",
    ];
    let mut outcome = editor("neovim", "nvim", &arguments)?;
    let highlights = tree_sitter()?;
    outcome.passed += usize::from(highlights);
    outcome.failed += usize::from(!highlights);
    Ok(outcome)
}

/// Parses the examples and, if there are some, the published specifications with the tree-sitter grammar, and
/// compares its highlights with those of VS Code. True if all is well.
fn tree_sitter() -> Result<bool> {
    step("Testing the tree-sitter grammar");
    extension::install_packages(&extension::directory())?;
    let server = extension::build_server(Profile::Dev)?;
    let grammar = xtask::root().join("editors/tree-sitter-genom3");
    let mut command = run::command(&grammar, "timeout", &["--kill-after=5", "300", "./test.sh"]);
    command.env("DOTGEN", server);
    if let Some(published) = shared::optional("corpus") {
        command.env("DOTGEN_SPECIFICATIONS", published);
    }
    run::watch(command, |_| {})
}

pub(super) fn emacs() -> Result<TestCounts> {
    tools::ensure(tools::EMACS)?;
    let script = xtask::root().join("tests/editors/emacs/eglot.el");
    editor("emacs", "emacs", &["--batch", "-l", &*script.to_string_lossy()])
}

/// Runs an editor's script in a copy of the example; it prints `ok …` for each successful check.
fn editor(name: &str, program: &str, arguments: &[&str]) -> Result<TestCounts> {
    let server = extension::build_server(Profile::Dev)?;
    // Outside of this repository, which editors would take for the project.
    let workspace = std::env::temp_dir().join(format!("dotgen-{name}-{}", std::process::id()));
    copy(&xtask::example(), &workspace)?;
    // Both editors print to either stream. There is a timeout, because an editor that waits for a key never
    // ends.
    let mut command = run::command(&workspace, "timeout", &["--kill-after=5", "120", program]);
    command.args(arguments).env("DOTGEN", server).env("FILE", workspace.join("maneuver.gen"));
    let output = command.output().with_context(|| format!("cannot run {program}"))?;
    let text = [output.stdout, output.stderr].concat();
    let text = String::from_utf8_lossy(&text);
    println!("{}", text.trim_end());
    std::fs::remove_dir_all(&workspace)?;
    let passed = text.lines().filter(|line| line.starts_with("ok ")).count();
    Ok(TestCounts { passed, ..TestCounts::default() }.ended(output.status.success() && passed > 0))
}

/// The pages of the extension in Chromium, without VS Code.
pub(super) fn pages() -> Result<TestCounts> {
    tools::ensure(tools::CHROMIUM)?;
    let scripts = xtask::root().join("tests/editors/vscode");
    extension::install_packages(&scripts)?;
    extension::install_packages(&extension::directory())?;
    step("Trying the pages of the extension in Chromium");
    let pages = [
        "webview/trace.test.mjs",
        "webview/diagram.test.mjs",
        "webview/verification.test.mjs",
        "webview/run.test.mjs",
    ];
    let arguments = [&["--test", "--test-reporter=tap"], &pages[..]].concat();
    let mut outcome = TestCounts::default();
    let succeeded = run::watch(run::command(&scripts, "node", &arguments), |line| {
        tap(line, &mut outcome);
    })?;
    Ok(outcome.ended(succeeded))
}

/// Reads a line of the summary of Node's tests.
pub(super) fn tap(line: &str, outcome: &mut TestCounts) {
    let number = |word: &str| line.strip_prefix(word)?.trim().parse::<usize>().ok();
    outcome.passed += number("# pass ").unwrap_or(0);
    outcome.failed += number("# fail ").unwrap_or(0);
}

pub(super) fn vscode() -> Result<TestCounts> {
    let server = extension::build_server(Profile::Dev)?;
    let vsix = extension::package(&server)?;
    let workbench = Workbench::set_up()?;
    let scenario = workbench.scenario(&vsix, &[])?;
    step("Driving VS Code; screenshots go to target/shots");
    let mut outcome = TestCounts::default();
    let succeeded = run::watch(scenario, |line| {
        if let Some(reason) = line.strip_prefix("skipped: ") {
            outcome.skipped.push(format!("vscode: {reason}"));
        }
        if line.starts_with("failed: ") {
            outcome.notes.push(line.to_owned());
        }
        if line.contains(" passed, ") {
            outcome.passed = count(line, " passed");
            outcome.failed = count(line, " failed");
        }
    })?;
    Ok(outcome.ended(succeeded))
}
