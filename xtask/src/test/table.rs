//! The table at the end of `cargo xtask test`: each suite beside the last record of its time.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, Result};

use super::{Row, TestCounts, skipped};

/// A suite that takes this many times the recorded time is marked.
const GROWTH: f64 = 1.2;
/// Shorter times vary too much to be compared, in seconds.
const SHORT: f64 = 5.0;

fn path() -> PathBuf {
    xtask::root().join("xtask/suites.txt")
}

const HEAD: &str = "\
# Seconds of each suite of `cargo xtask test`, from a fresh clone on two cores. Written by `cargo xtask test
# --record`.
";

/// Prints the table and the totals, records the times if asked to, and returns the totals.
pub(super) fn print(rows: &[Row], whole: Duration, record: bool) -> Result<TestCounts> {
    let known = parse(&std::fs::read_to_string(path()).unwrap_or_default());
    println!();
    println!(
        "{:<10} {:>7} {:>7} {:>7} {:>8} {:>9}",
        "suite", "passed", "failed", "skipped", "time", "recorded"
    );
    let mut total = TestCounts::default();
    for row in rows {
        let (counts, note) = match &row.outcome {
            Ok(outcome) => {
                total.skipped.extend(outcome.skipped.iter().cloned());
                ([outcome.passed, outcome.failed, outcome.skipped.len()], String::new())
            }
            Err(error) => {
                let text = format!("{error:#}");
                ([0, 1, 0], format!("  {}", text.lines().next().unwrap_or_default()))
            }
        };
        let [passed, failed, skipped] = counts;
        total.passed += passed;
        total.failed += failed;
        let time = times(row.time.as_secs_f64(), known.get(row.name).copied());
        println!("{:<10} {passed:>7} {failed:>7} {skipped:>7} {time}{note}", row.name);
    }
    let time = times(whole.as_secs_f64(), known.get("all").copied());
    println!("{:<10} {:>7} {:>7} {:>7} {time}", "all", "", "", "");
    println!();
    for note in rows.iter().flat_map(|row| &row.outcome).flat_map(|outcome| &outcome.notes) {
        println!("{note}");
    }
    for reason in &total.skipped {
        println!("skipped: {reason}");
    }
    // In continuous integration everything is installed.
    let wrong = total.skipped.iter().filter(|reason| !skipped::is_allowed(reason)).count();
    if wrong > 0 && std::env::var_os("CI").is_some() {
        println!("{wrong} of these may not be skipped here: install what they need");
        total.failed += wrong;
        total.skipped.truncate(total.skipped.len() - wrong);
    }
    if record {
        write(rows, whole)?;
    }
    println!("{} passed, {} failed, {} skipped", total.passed, total.failed, total.skipped.len());
    Ok(total)
}

/// The columns of a time and of its record, with a mark if it grew.
fn times(seconds: f64, recorded: Option<f64>) -> String {
    let mark = recorded.is_some_and(|recorded| seconds > (recorded * GROWTH).max(SHORT));
    let recorded = recorded.map(|seconds| format!("{seconds:.0} s")).unwrap_or_default();
    format!("{seconds:>6.1} s {recorded:>9}{}", if mark { "  slower" } else { "" })
}

fn write(rows: &[Row], whole: Duration) -> Result<()> {
    let mut text = HEAD.to_owned();
    let all = rows.iter().map(|row| (row.name, row.time)).chain([("all", whole)]);
    for (name, time) in all {
        let _ = writeln!(text, "{name:<10} {:.0}", time.as_secs_f64());
    }
    std::fs::write(path(), text).context("cannot write xtask/suites.txt")
}

fn parse(text: &str) -> BTreeMap<String, f64> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let row = |line: &str| {
        let (name, seconds) = line.split_once(' ')?;
        Some((name.to_owned(), seconds.trim().parse().ok()?))
    };
    lines.filter_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::{parse, times};

    #[test]
    fn what_grew_by_more_than_a_fifth_is_marked() {
        let known = parse("# head\nrust       100\nformat     1\n");
        assert!(times(121.0, known.get("rust").copied()).ends_with("slower"));
        assert!(!times(119.0, known.get("rust").copied()).ends_with("slower"));
        assert!(!times(3.0, known.get("format").copied()).ends_with("slower"));
        assert!(!times(3.0, None).ends_with("slower"));
    }
}
