//! The tests that use shared test data, run without the data, because other clones do not have it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};

use crate::run;
use crate::test::Outcome;

/// The variable with the path of the log that `tests/loaders/src/shared.rs` writes.
pub(crate) const LOG: &str = "DOTGEN_SHARED_LOG";

/// Uses of shared test data by program, its folder, and test; false if some data was not found.
#[derive(Default)]
pub(crate) struct Uses(BTreeMap<(PathBuf, PathBuf), BTreeMap<String, bool>>);

fn log() -> PathBuf {
    crate::target().join("shared-test-data.log")
}

/// An empty log; returns its path.
pub(crate) fn new_log() -> Result<PathBuf> {
    let path = log();
    std::fs::create_dir_all(crate::target())?;
    std::fs::write(&path, "").with_context(|| format!("cannot write {}", path.display()))?;
    Ok(path)
}

impl Uses {
    /// The uses that the last run of the suite `rust` logged.
    pub(crate) fn read() -> Result<Uses> {
        let Ok(text) = std::fs::read_to_string(log()) else {
            bail!("the tests that read shared data are not known: run the suite `rust` first");
        };
        Ok(Uses::parse(&text))
    }

    fn parse(text: &str) -> Uses {
        let mut uses = Uses::default();
        for line in text.lines() {
            let fields: Vec<_> = line.split('\t').collect();
            let [program, folder, test, _, found] = fields[..] else {
                continue;
            };
            let tests = uses.0.entry((program.into(), folder.into())).or_default();
            *tests.entry(test.to_owned()).or_insert(true) &= found == "found";
        }
        uses
    }

    /// One line: the number of tests that read shared data, and of those that found it.
    pub(crate) fn summary(&self) -> String {
        let tests: Vec<bool> = self.0.values().flat_map(BTreeMap::values).copied().collect();
        let found = tests.iter().filter(|found| **found).count();
        format!("shared test data: {} tests read it, {found} found it", tests.len())
    }
}

/// Runs the tests that read shared data without the data.
pub(crate) fn without_data() -> Result<Outcome> {
    let mut outcome = Outcome::default();
    for ((program, folder), tests) in &Uses::read()?.0 {
        let mut arguments = Vec::new();
        // A test without its own thread has no name. In that case the whole program runs.
        if !tests.contains_key("main") {
            arguments.push("--exact");
            arguments.extend(tests.keys().map(String::as_str));
        }
        let mut command = run::command(folder, &program.to_string_lossy(), &arguments);
        command.env("DOTGEN_SHARED", "none").env_remove(LOG);
        command.env("INSTA_UPDATE", "no");
        let before = outcome.failed;
        let succeeded = run::watch(command, |line| outcome.read(line))?;
        if !succeeded && outcome.failed == before {
            outcome.failed += 1;
        }
    }
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use super::Uses;

    #[test]
    fn a_test_found_its_data_if_all_of_it_was_found() {
        let text = "/p\t/f\ta::b\tcorpus\tfound\n/p\t/f\ta::b\tgolden\tmissing\n/p\t/f\tc\tcorpus\tfound\nx\n";
        let uses = Uses::parse(text);
        assert_eq!(uses.summary(), "shared test data: 2 tests read it, 1 found it");
    }
}
