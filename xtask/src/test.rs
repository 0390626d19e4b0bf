//! `cargo xtask test`: all tests, as a list of suites.
//!
//! A suite that lacks a tool fails, with one line that names the package to install. A test that cannot run
//! counts as skipped, with its reason.

mod editors;
mod pages;
mod rust;
mod skipped;
mod table;

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use clap::Args;

use crate::notices;
use crate::workbench::{self, Workbench};
use xtask::extension;
use xtask::run::{self, step};
use xtask::tools;

/// Options of `cargo xtask test`.
#[derive(Args)]
pub(crate) struct Options {
    /// Leave out the suites that need a real editor.
    #[arg(long)]
    fast: bool,
    /// Write the time of each suite into xtask/suites.txt.
    #[arg(long)]
    record: bool,
    /// Run only the suites whose names contain one of these.
    suites: Vec<String>,
}

struct Suite {
    name: &'static str,
    lane: Lane,
    run: fn() -> Result<TestCounts>,
}

/// The suites that a suite runs beside.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Lane {
    /// None.
    Alone,
    /// The editor, which mostly waits.
    Editor,
    /// Short ones, one after the other, beside the editor.
    Short,
}

/// Numbers of tests; a suite that is one check counts as one test.
#[derive(Default)]
pub(crate) struct TestCounts {
    pub(crate) passed: usize,
    pub(crate) failed: usize,
    /// The reason of each test that could not run.
    pub(crate) skipped: Vec<String>,
    /// Lines for the end of the summary.
    pub(crate) notes: Vec<String>,
}

impl TestCounts {
    /// The outcome of a suite that is one check.
    fn one(passed: bool) -> TestCounts {
        TestCounts { passed: passed.into(), failed: (!passed).into(), ..TestCounts::default() }
    }

    /// Counts a failure of the program itself, if it failed and no test did.
    fn ended(mut self, succeeded: bool) -> TestCounts {
        self.failed += usize::from(!succeeded && self.failed == 0);
        self
    }
}

/// A suite that ran.
struct Row {
    name: &'static str,
    outcome: Result<TestCounts>,
    time: Duration,
}

const SUITES: &[Suite] = &[
    Suite { name: "format", lane: Lane::Alone, run: format },
    Suite { name: "build", lane: Lane::Alone, run: rust::build },
    Suite { name: "notices", lane: Lane::Alone, run: notices },
    Suite { name: "locks", lane: Lane::Alone, run: locks },
    Suite { name: "rust", lane: Lane::Alone, run: rust::run },
    Suite { name: "extension", lane: Lane::Alone, run: pages::extension },
    Suite { name: "vscode", lane: Lane::Editor, run: editors::vscode },
    Suite { name: "grammar", lane: Lane::Short, run: pages::grammar },
    Suite { name: "client", lane: Lane::Short, run: pages::client },
    Suite { name: "pages", lane: Lane::Short, run: editors::pages },
    Suite { name: "neovim", lane: Lane::Short, run: editors::neovim },
    Suite { name: "emacs", lane: Lane::Short, run: editors::emacs },
];

/// Suites that need a real editor or browser.
const EDITORS: [&str; 4] = ["vscode", "pages", "neovim", "emacs"];

/// Runs the suites; false if a test failed.
pub(crate) fn test(options: &Options) -> Result<bool> {
    let wanted = |suite: &&Suite| match options.suites.as_slice() {
        [] => !(options.fast && EDITORS.contains(&suite.name)),
        names => names.iter().any(|name| suite.name.contains(name.as_str())),
    };
    let suites: Vec<&Suite> = SUITES.iter().filter(wanted).collect();
    if suites.is_empty() {
        let names: Vec<_> = SUITES.iter().map(|suite| suite.name).collect();
        bail!("no such suite; there are: {}", names.join(", "));
    }
    let has = |name: &str| suites.iter().any(|suite| suite.name == name);
    if has("build") {
        run::lint_while_building();
    }
    if has("vscode") && has("build") {
        install_tools();
    }
    let started = Instant::now();
    let mut rows = Vec::new();
    std::thread::scope(|scope| {
        // Downloads go on while the compiler works.
        let downloads = (has("vscode") && has("build")).then(|| scope.spawn(download));
        for suite in suites.iter().filter(|suite| suite.lane == Lane::Alone) {
            rows.push(one(suite));
        }
        if let Some(Err(error)) = downloads.map(|thread| thread.join().expect("no panic")) {
            eprintln!("    {error:#}");
        }
        let lane = |lane| suites.iter().filter(move |suite| suite.lane == lane);
        let editor = scope.spawn(move || {
            run::prefix("vscode | ");
            lane(Lane::Editor).map(|suite| one(suite)).collect::<Vec<_>>()
        });
        rows.extend(lane(Lane::Short).map(|suite| one(suite)));
        rows.extend(editor.join().expect("no panic"));
    });
    Ok(table::print(&rows, started.elapsed(), options.record)?.failed == 0)
}

fn one(suite: &Suite) -> Row {
    step(suite.name);
    let started = Instant::now();
    let outcome = (suite.run)();
    if let Err(error) = &outcome {
        eprintln!("{}: {error:#}", suite.name);
    }
    let time = started.elapsed();
    step(&format!("{}: {:.0} s", suite.name, time.as_secs_f32()));
    Row { name: suite.name, outcome, time }
}

/// Installs all packages of the system at once: apt starts slowly, and a missing package is reported before
/// the long build. Each suite checks its tools again, and fails with a line of its own.
fn install_tools() {
    for tools in [
        tools::CHROMIUM,
        tools::NEOVIM,
        tools::EMACS,
        tools::PYTHON,
        tools::TCL,
        tools::NATIVE_MODULES,
        tools::DEBUGGER,
    ] {
        if let Err(error) = tools::ensure(tools) {
            eprintln!("    {error:#}");
        }
    }
}

/// Sets up what the suites after the build need from registries.
fn download() -> Result<()> {
    extension::install_packages(&extension::directory())?;
    extension::install_packages(&workbench::scripts())?;
    pages::python()?;
    Workbench::set_up().map(drop)
}

fn format() -> Result<TestCounts> {
    run::watch(run::cargo(&["fmt", "--all", "--check"]), |_| ()).map(TestCounts::one)
}

fn notices() -> Result<TestCounts> {
    notices::notices(&notices::Options { check: true }).map(TestCounts::one)
}

/// Checks that the lock files of the workspaces of their own, the fuzzed programs and the measurements, are
/// current.
fn locks() -> Result<TestCounts> {
    let mut outcome = TestCounts::default();
    for folder in ["fuzz", "bench"] {
        let manifest = format!("--manifest-path={folder}/Cargo.toml");
        let arguments = ["metadata", "--locked", "--format-version=1", &manifest];
        match run::capture(run::cargo(&arguments)) {
            Ok(_) => outcome.passed += 1,
            Err(error) => bail!(
                "{folder}/Cargo.lock is out of date: `cargo update --workspace` in `{folder}`\n{error:#}"
            ),
        }
    }
    Ok(outcome)
}

/// The number before ` passed` or a similar word.
fn count(line: &str, what: &str) -> usize {
    let before = line.split(what).next().filter(|_| line.contains(what));
    let number = before.and_then(|before| before.rsplit(|c: char| !c.is_ascii_digit()).next());
    number.and_then(|number| number.parse().ok()).unwrap_or(0)
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &target)?;
        } else {
            std::fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{TestCounts, count};

    #[test]
    fn the_summary_of_node_is_read() {
        let mut outcome = TestCounts::default();
        let lines = ["ok 1 - # pass 3 of it", "# pass 10", "# fail 2", "# suites 0"];
        for line in &lines {
            super::editors::tap(line, &mut outcome);
        }
        assert_eq!((outcome.passed, outcome.failed), (10, 2));
    }

    #[test]
    fn numbers_before_words_are_read() {
        assert_eq!(count("== 3 passed, 1 skipped in 2 s", " passed"), 3);
        assert_eq!(count("== 3 passed, 1 skipped in 2 s", " failed"), 0);
    }
}
