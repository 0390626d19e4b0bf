//! The tests that could not run: `skip` of `tests/loaders/src/shared.rs` records them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// Creates an empty record and returns its path.
pub(super) fn new_log() -> Result<PathBuf> {
    let log = xtask::target().join("skipped-tests");
    std::fs::write(&log, "").with_context(|| format!("cannot write {}", log.display()))?;
    Ok(log)
}

/// A line for each test of the record: `NAME: reason`.
pub(super) fn read(log: &Path) -> Result<Vec<String>> {
    Ok(parse(&std::fs::read_to_string(log)?))
}

fn parse(log: &str) -> Vec<String> {
    let mut tests: BTreeMap<(&str, &str), &str> = BTreeMap::new();
    for line in log.lines() {
        let mut columns = line.splitn(3, '\t');
        if let (Some(program), Some(test), Some(reason)) =
            (columns.next(), columns.next(), columns.next())
        {
            tests.entry((program, test)).or_insert(reason);
        }
    }
    let lines = tests.into_iter().map(|((_, test), reason)| format!("{test}: {reason}"));
    lines.collect()
}

/// True if a test may be skipped in continuous integration: only data of others may be missing there.
pub(super) fn is_allowed(skipped: &str) -> bool {
    skipped.split_once(": ").is_some_and(|(_, reason)| reason.starts_with(xtask::shared::NO_DATA))
}

#[cfg(test)]
mod tests {
    use super::{is_allowed, parse};

    #[test]
    fn a_test_is_skipped_once_with_its_first_reason() {
        let log = "p\ta::b\tno data: x\np\ta::b\tno data: y\nq\ta::b\tno gdb\n";
        let skipped = parse(log);
        assert_eq!(skipped, ["a::b: no data: x", "a::b: no gdb"]);
        assert_eq!(skipped.iter().map(|line| is_allowed(line)).collect::<Vec<_>>(), [true, false]);
    }
}
