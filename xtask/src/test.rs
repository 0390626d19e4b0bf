//! `cargo xtask test`: all tests, as a list of suites.
//!
//! A suite that lacks a tool fails, with one line that names the package to install, because a skipped test
//! proves nothing.

mod editors;
mod without_data;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use clap::Args;

use crate::extension::{self, Profile};
use crate::notices;
use crate::run::{self, step};
use crate::tools;

/// Options of `cargo xtask test`.
#[derive(Args)]
pub(crate) struct Options {
    /// Leave out the suites that need a real editor.
    #[arg(long)]
    fast: bool,
    /// Run only the suites whose names contain one of these.
    suites: Vec<String>,
}

struct Suite {
    name: &'static str,
    /// True if the suite drives a real editor.
    editor: bool,
    run: fn() -> Result<Outcome>,
}

/// Numbers of tests; a suite that is one check counts as one test.
#[derive(Default)]
pub(crate) struct Outcome {
    pub(crate) passed: usize,
    pub(crate) failed: usize,
    /// Lines for the end of the summary.
    pub(crate) notes: Vec<String>,
}

impl Outcome {
    /// Reads a line of output of a Rust test program.
    pub(crate) fn read(&mut self, line: &str) {
        if let Some(result) = line.strip_prefix("test result: ") {
            self.passed += count(result, " passed");
            self.failed += count(result, " failed");
        }
    }
}

/// The suite whose build, with Clippy as the compiler, is that of the others.
const CLIPPY: &str = "clippy";

const SUITES: &[Suite] = &[
    Suite { name: "format", editor: false, run: format },
    Suite { name: CLIPPY, editor: false, run: clippy },
    Suite { name: "notices", editor: false, run: notices },
    Suite { name: "rust", editor: false, run: rust },
    Suite { name: "without-data", editor: false, run: without_data::without_data },
    Suite { name: "campaign", editor: false, run: campaign },
    Suite { name: "fuzz", editor: false, run: fuzz },
    Suite { name: "extension", editor: false, run: extension_units },
    Suite { name: "grammar", editor: false, run: grammar },
    Suite { name: "client", editor: false, run: client },
    Suite { name: "neovim", editor: true, run: editors::neovim },
    Suite { name: "emacs", editor: true, run: editors::emacs },
    Suite { name: "vscode", editor: true, run: editors::vscode },
];

/// Runs the suites; false if a test failed.
pub(crate) fn test(options: &Options) -> Result<bool> {
    let wanted = |suite: &&Suite| match options.suites.as_slice() {
        [] => !(options.fast && suite.editor),
        names => names.iter().any(|name| suite.name.contains(name.as_str())),
    };
    let suites: Vec<&Suite> = SUITES.iter().filter(wanted).collect();
    if suites.is_empty() {
        let names: Vec<_> = SUITES.iter().map(|suite| suite.name).collect();
        bail!("no such suite; there are: {}", names.join(", "));
    }
    if suites.iter().any(|suite| suite.editor) && options.suites.is_empty() {
        // All at once, first: apt starts slowly, and missing packages are known before the long builds. Each
        // suite checks its tools again, and fails with a line of its own.
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
    if suites.iter().any(|suite| suite.name == CLIPPY) {
        run::lint_while_building();
    }
    let mut rows = Vec::new();
    for (i, suite) in suites.iter().enumerate() {
        step(&format!("[{}/{}] {}", i + 1, suites.len(), suite.name));
        let started = Instant::now();
        let outcome = (suite.run)();
        if let Err(error) = &outcome {
            eprintln!("{}: {error:#}", suite.name);
        }
        rows.push((suite.name, outcome, started.elapsed()));
    }
    Ok(summary(&rows))
}

fn summary(rows: &[(&str, Result<Outcome>, Duration)]) -> bool {
    println!();
    println!("{:<12} {:>7} {:>7} {:>8}", "suite", "passed", "failed", "time");
    let mut total = Outcome::default();
    for (name, outcome, time) in rows {
        let (passed, failed, note) = match outcome {
            Ok(outcome) => (outcome.passed, outcome.failed, String::new()),
            Err(error) => {
                let text = format!("{error:#}");
                let first = text.lines().next().unwrap_or_default();
                (0, 1, format!("  {first}"))
            }
        };
        println!("{name:<12} {passed:>7} {failed:>7} {:>6.1} s{note}", time.as_secs_f32());
        total.passed += passed;
        total.failed += failed;
    }
    println!();
    for (_, outcome, _) in rows {
        for note in outcome.iter().flat_map(|outcome| &outcome.notes) {
            println!("{note}");
        }
    }
    println!("{} passed, {} failed", total.passed, total.failed);
    total.failed == 0
}

/// The outcome of a suite that is one check.
fn one(passed: bool) -> Outcome {
    Outcome { passed: passed.into(), failed: (!passed).into(), ..Outcome::default() }
}

fn format() -> Result<Outcome> {
    run::watch(run::cargo(&["fmt", "--all", "--check"]), |_| ()).map(one)
}

/// Builds all that the suite `rust` runs, and the benchmarks, and lints them meanwhile.
fn clippy() -> Result<Outcome> {
    let arguments = [
        "test",
        "--no-run",
        "--locked",
        "--workspace",
        "--all-targets",
        "--features",
        extension::FEATURES,
        "--message-format=json",
    ];
    // A crate is compiled with and without its tests, and has most findings twice.
    let mut found = BTreeSet::new();
    let built = run::lines(run::cargo(&arguments), |line| {
        if let Some(finding) = finding(line)
            && found.insert(finding.clone())
        {
            eprintln!("{finding}");
        }
    })?;
    if built {
        extension::is_built_with_tests();
    }
    Ok(one(built && found.is_empty()))
}

/// The text of a finding, from a line of the messages of cargo.
fn finding(line: &str) -> Option<String> {
    let message: serde_json::Value = serde_json::from_str(line).ok()?;
    let is_finding = message["reason"] == "compiler-message";
    let text = message["message"]["rendered"].as_str()?;
    is_finding.then(|| text.to_owned())
}

fn notices() -> Result<Outcome> {
    notices::notices(&notices::Options { check: true }).map(one)
}

fn rust() -> Result<Outcome> {
    // Without Tcl the tests of templates are skipped, with a message.
    tools::ensure(tools::TCL)?;
    let log = without_data::new_log()?;
    let mut outcome = Outcome::default();
    let mut times = Vec::new();
    let mut succeeded = true;
    // Documentation tests run separately: rustdoc of a stable release reports no times.
    for documentation in [false, true] {
        let arguments = ["test", "--locked", "--workspace", "--no-fail-fast"];
        let mut cargo = run::cargo(&arguments);
        cargo.args(["--features", extension::FEATURES]);
        // A missing snapshot is a failure here, never a new file.
        cargo.env("INSTA_UPDATE", "no").env(without_data::LOG, &log);
        match documentation {
            true => cargo.arg("--doc"),
            false => cargo.args(["--lib", "--bins", "--tests"]),
        };
        if !documentation && cfg!(unix) {
            // Set only for test programs: set for cargo itself, the variable would cause a complete rebuild.
            cargo.args([
                "--config",
                "target.'cfg(unix)'.runner = ['env', 'RUSTC_BOOTSTRAP=1']",
                "--",
                "-Zunstable-options",
                "--report-time",
            ]);
        }
        succeeded &= run::watch(cargo, |line| {
            outcome.read(line);
            times.extend(time(line));
        })?;
    }
    if !succeeded && outcome.failed == 0 {
        bail!("the tests do not compile");
    }
    extension::is_built_with_tests();
    outcome.notes = slowest(times);
    outcome.notes.push(without_data::Uses::read()?.summary());
    Ok(outcome)
}

/// Name and seconds of a test, from a line `test NAME ... ok <0.123s>`.
fn time(line: &str) -> Option<(f64, String)> {
    let (name, rest) = line.strip_prefix("test ")?.split_once(" ... ")?;
    let (_, time) = rest.rsplit_once('<')?;
    let seconds = time.strip_suffix("s>")?.parse().ok()?;
    Some((seconds, name.to_owned()))
}

/// The ten slowest tests, as lines.
fn slowest(mut times: Vec<(f64, String)>) -> Vec<String> {
    times.sort_by(|a, b| b.0.total_cmp(&a.0));
    times.truncate(10);
    let lines = times.iter();
    let lines = lines.map(|(seconds, name)| format!("{seconds:>7.1} s  {name}"));
    let head = (!times.is_empty()).then(|| "slowest tests:".to_owned());
    head.into_iter().chain(lines).collect()
}

/// A sample of `cargo xtask campaign`.
fn campaign() -> Result<Outcome> {
    let (passed, failed) = crate::campaign::sample()?;
    Ok(Outcome { passed, failed, ..Outcome::default() })
}

/// Checks that the lock file of the fuzzed programs, which are a separate workspace, is current.
fn fuzz() -> Result<Outcome> {
    let arguments =
        ["metadata", "--locked", "--format-version=1", "--manifest-path=fuzz/Cargo.toml"];
    match run::capture(run::cargo(&arguments)) {
        Ok(_) => Ok(one(true)),
        Err(error) => {
            bail!("fuzz/Cargo.lock is out of date: `cargo update --workspace` in `fuzz`\n{error:#}")
        }
    }
}

fn extension_units() -> Result<Outcome> {
    let directory = extension::directory();
    extension::install_packages(&directory)?;
    let mut outcome =
        one(run::watch(extension::npm(&directory, &["run", "--silent", "typecheck"]), |_| ())?);
    run::capture(extension::npm(&directory, &["run", "--silent", "bundle"]))?;
    let succeeded =
        run::watch(extension::npm(&directory, &["run", "--silent", "test:unit"]), |line| {
            if let Some((_, number)) = line.split_once(" pass ") {
                outcome.passed += number.trim().parse().unwrap_or(0);
            }
            if let Some((_, number)) = line.split_once(" fail ") {
                outcome.failed += number.trim().parse().unwrap_or(0);
            }
        })?;
    if !succeeded && outcome.failed == 0 {
        outcome.failed = 1;
    }
    Ok(outcome)
}

fn grammar() -> Result<Outcome> {
    let directory = extension::directory();
    extension::install_packages(&directory)?;
    let snapshots = directory.join("test/grammar/snap");
    // The snapshot tool writes a missing snapshot and passes.
    for source in files(&snapshots, "gen")? {
        let snapshot = PathBuf::from(format!("{}.snap", source.display()));
        if !snapshot.exists() {
            bail!("{} is missing: run `npm run test:grammar` and commit it", snapshot.display());
        }
    }
    let sources = directory.join("test/grammar");
    let tests = files(&sources, "gen")?.len()
        + files(&sources, "scn")?.len()
        + files(&snapshots, "gen")?.len();
    let succeeded =
        run::watch(extension::npm(&directory, &["run", "--silent", "test:grammar"]), |_| ())?;
    Ok(match succeeded {
        true => Outcome { passed: tests, ..Outcome::default() },
        false => one(false),
    })
}

fn client() -> Result<Outcome> {
    tools::ensure(tools::PYTHON)?;
    let server = extension::build_server(Profile::Dev)?;
    let scripts = crate::root().join("tests/editors/client");
    let python = python(&scripts)?;
    let arguments = ["-m", "pytest", "-q", "-p", "no:cacheprovider"];
    let mut command = run::command(&scripts, &python.to_string_lossy(), &arguments);
    command
        .env("DOTGEN", server)
        .env("WORKSPACE", crate::example())
        .env("PYTHONDONTWRITEBYTECODE", "1");
    let mut outcome = Outcome::default();
    let succeeded = run::watch(command, |line| {
        if line.contains(" in ") && line.ends_with('s') {
            outcome.passed = count(line, " passed");
            outcome.failed = count(line, " failed") + count(line, " error");
        }
    })?;
    if !succeeded && outcome.failed == 0 {
        outcome.failed = 1;
    }
    Ok(outcome)
}

/// Creates a virtual environment with the test's packages, and returns its Python.
fn python(scripts: &Path) -> Result<PathBuf> {
    let requirements = scripts.join("requirements.txt");
    let wanted = std::fs::read_to_string(&requirements)?;
    let directory = crate::target().join("tools/python");
    let (python, stamp) = (directory.join("bin/python"), directory.join("requirements.txt"));
    if std::fs::read_to_string(&stamp).ok().as_ref() != Some(&wanted) {
        step("Installing pytest-lsp");
        let venv = ["-m", "venv", "--clear", &*directory.to_string_lossy()];
        run::capture(run::command(crate::root(), "python3", &venv))?;
        let pip = [
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "-r",
            &*requirements.to_string_lossy(),
        ];
        run::capture(run::command(crate::root(), &python.to_string_lossy(), &pip))?;
        std::fs::write(&stamp, wanted)?;
    }
    Ok(python)
}

/// The number before ` passed` or a similar word.
fn count(line: &str, what: &str) -> usize {
    let before = line.split(what).next().filter(|_| line.contains(what));
    let number = before.and_then(|before| before.rsplit(|c: char| !c.is_ascii_digit()).next());
    number.and_then(|number| number.parse().ok()).unwrap_or(0)
}

fn files(directory: &Path, extension: &str) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(directory)? {
        let path = entry?.path();
        if path.is_file() && path.extension().is_some_and(|name| name == extension) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        match entry.file_type()?.is_dir() {
            true => copy(&entry.path(), &target)?,
            false => drop(std::fs::copy(entry.path(), target)?),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::count;

    #[test]
    fn the_summary_of_node_is_read() {
        let mut outcome = super::Outcome::default();
        let lines = ["ok 1 - # pass 3 of it", "# pass 10", "# fail 2", "# suites 0"];
        lines.iter().for_each(|line| super::editors::tap(line, &mut outcome));
        assert_eq!((outcome.passed, outcome.failed), (10, 2));
    }

    #[test]
    fn times_are_read_from_test_programs() {
        let line = "test cli::help ... ok <0.123s>";
        assert_eq!(super::time(line), Some((0.123, "cli::help".to_owned())));
        assert_eq!(super::time("test cli::help ... ignored"), None);
        assert_eq!(super::time("test result: ok. 1 passed"), None);
    }

    #[test]
    fn findings_are_read_from_the_messages_of_cargo() {
        let finding = r#"{"reason":"compiler-message","message":{"rendered":"warning: `dbg!`"}}"#;
        assert_eq!(super::finding(finding).as_deref(), Some("warning: `dbg!`"));
        let other = r#"{"reason":"compiler-artifact","fresh":true}"#;
        assert_eq!(super::finding(other), None);
        assert_eq!(super::finding("no JSON"), None);
    }

    #[test]
    fn counts_are_read_from_the_summaries_of_the_test_tools() {
        assert_eq!(count("ok. 12 passed; 3 failed; 1 ignored", " passed"), 12);
        assert_eq!(count("ok. 12 passed; 3 failed; 1 ignored", " failed"), 3);
        assert_eq!(count("2 failed, 19 passed in 3.21s", " passed"), 19);
        assert_eq!(count("21 passed in 3.21s", " failed"), 0);
        assert_eq!(count("no number passed", " passed"), 0);
    }
}
