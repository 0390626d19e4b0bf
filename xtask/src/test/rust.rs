//! The tests of the crates: one build, which Clippy lints meanwhile, and one run of all test programs.

use std::collections::BTreeSet;

use anyhow::{Result, bail};

use super::{TestCounts, count, skipped};
use xtask::extension::{self, TEST_FEATURES};
use xtask::{run, tools};

/// Builds all that [`run`] runs.
pub(super) fn build() -> Result<TestCounts> {
    let mut cargo = run::cargo(&["test", "--no-run", "--locked", "--workspace"]);
    cargo.args(TEST_FEATURES).arg("--message-format=json");
    // A crate is compiled with and without its tests, and has most findings twice.
    let mut found = BTreeSet::new();
    let built = run::lines(cargo, |line| {
        if let Some(finding) = finding(line)
            && found.insert(finding.clone())
        {
            eprintln!("{finding}");
        }
    })?;
    if built {
        extension::is_built_with_tests();
    }
    Ok(TestCounts::one(built && found.is_empty()))
}

/// The text of a finding, from a line of the messages of cargo.
fn finding(line: &str) -> Option<String> {
    let message: serde_json::Value = serde_json::from_str(line).ok()?;
    let is_finding = message["reason"] == "compiler-message";
    let text = message["message"]["rendered"].as_str()?;
    is_finding.then(|| text.to_owned())
}

/// Runs the test programs.
pub(super) fn run() -> Result<TestCounts> {
    // Without Tcl the tests of templates are skipped.
    tools::ensure(tools::TCL)?;
    let log = skipped::new_log()?;
    let mut cargo = run::cargo(&["test", "--locked", "--workspace", "--no-fail-fast"]);
    cargo.args(TEST_FEATURES).args(["--lib", "--bins", "--tests"]);
    // A missing snapshot is a failure here, never a new file.
    cargo.env("INSTA_UPDATE", "no").env(xtask::shared::SKIPPED, &log);
    if cfg!(unix) {
        // Set only for test programs: set for cargo itself, the variable would cause a complete rebuild.
        let runner = "target.'cfg(unix)'.runner = ['env', 'RUSTC_BOOTSTRAP=1']";
        cargo.args(["--config", runner, "--", "-Zunstable-options", "--report-time"]);
    }
    let mut outcome = TestCounts::default();
    let (mut times, mut failed) = (Vec::new(), Vec::new());
    let succeeded = run::watch(cargo, |line| {
        if let Some(result) = line.strip_prefix("test result: ") {
            outcome.passed += count(result, " passed");
            outcome.failed += count(result, " failed");
        }
        times.extend(time(line));
        failed.extend(failure(line));
    })?;
    if !succeeded && outcome.failed == 0 {
        bail!("the tests do not compile");
    }
    extension::is_built_with_tests();
    outcome.notes = [slowest(times), failed].concat();
    outcome.skipped = skipped::read(&log)?;
    outcome.passed = outcome.passed.saturating_sub(outcome.skipped.len());
    Ok(outcome)
}

/// Name and seconds of a test, from a line `test NAME ... ok <0.123s>`.
fn time(line: &str) -> Option<(f64, String)> {
    let (name, rest) = line.strip_prefix("test ")?.split_once(" ... ")?;
    let (_, time) = rest.rsplit_once('<')?;
    let seconds = time.strip_suffix("s>")?.parse().ok()?;
    Some((seconds, name.to_owned()))
}

/// A line for the end of the summary, from a line `test NAME ... FAILED <0.123s>`.
fn failure(line: &str) -> Option<String> {
    let (name, rest) = line.strip_prefix("test ")?.split_once(" ... ")?;
    rest.starts_with("FAILED").then(|| format!("failed: {name}"))
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

#[cfg(test)]
mod tests {
    #[test]
    fn times_are_read_from_test_programs() {
        let line = "test cli::help ... ok <0.123s>";
        assert_eq!(super::time(line), Some((0.123, "cli::help".to_owned())));
        assert_eq!(super::time("test cli::help ... ok"), None);
        assert_eq!(super::failure(line), None);
        let line = "test cli::help ... FAILED <0.123s>";
        assert_eq!(super::failure(line), Some("failed: cli::help".to_owned()));
    }
}
