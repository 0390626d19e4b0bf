//! `cargo xtask budgets`: instructions and memory of what users do, at three sizes, against a file of the
//! repository.
//!
//! Valgrind counts the instructions of the program that people build, so the machine and its load do not
//! matter. A change that takes more than [`SLACK`] of what the file says fails, and so does one that takes as
//! much less: the file is written anew (`--write`), and the commit shows it. Twice the input may take
//! [`DOUBLE`] times the instructions.

mod operations;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Stdio;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::bench::client::Editor;
use crate::bench::measure::{self, Job};
use operations::{OPERATIONS, Operation};
use xtask::run::{self, step};
use xtask::{extension, target, tools};

/// Part of a budget by which a measurement may differ: the C library chooses its functions by the processor.
const SLACK: f64 = 0.1;
/// Part of a memory budget by which a measurement may differ.
const MEMORY_TOLERANCE: f64 = 0.25;
/// The smallest size, and how many times that the others are.
const SIZE: usize = 8;
const SIZE_FACTORS: [usize; 3] = [1, 2, 4];

/// Options of `cargo xtask budgets`.
#[derive(Args)]
pub(crate) struct Options {
    /// Write what was measured into bench/budgets.txt.
    #[arg(long)]
    write: bool,
    /// Measure only the operations whose names contain one of these.
    operations: Vec<String>,
}

/// What an operation takes at the three sizes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Figures {
    /// Millions of instructions.
    instructions: [f64; 3],
    /// Peak resident memory at the largest size, in MB.
    megabytes: f64,
}

/// Measures. Returns whether all operations are within their budgets.
pub(crate) fn budgets(options: &Options) -> Result<bool> {
    let measured = measured(&options.operations)?;
    if options.write {
        let mut all = read().unwrap_or_default();
        all.extend(measured);
        std::fs::write(path(), written(&all))?;
        println!("wrote {}", path().display());
        return Ok(true);
    }
    let wrong = differences(&read()?, &measured);
    wrong.iter().for_each(|wrong| println!("{wrong}"));
    if !wrong.is_empty() {
        println!("If this is meant: `cargo xtask budgets --write`, with the reason in the commit.");
    }
    Ok(wrong.is_empty())
}

fn measured(names: &[String]) -> Result<BTreeMap<String, Figures>> {
    tools::ensure(tools::VALGRIND)?;
    tools::ensure(tools::TIME)?;
    let folder = target().join("budgets");
    std::fs::create_dir_all(&folder)?;
    // Valgrind reads symbols for as long as it counts.
    let dotgen = folder.join("dotgen");
    let built = extension::build_server(extension::Profile::Release)?;
    let (built, stripped) = (built.to_string_lossy(), dotgen.to_string_lossy());
    run::run(run::command(&folder, "strip", &["-o", &stripped, &built]))?;
    let wanted = |operation: &&Operation| {
        names.is_empty() || names.iter().any(|name| operation.name.contains(name))
    };
    let wanted: Vec<&Operation> = OPERATIONS.iter().filter(wanted).collect();
    step(&format!("Instructions and memory of {} operations", wanted.len()));
    let (next, results) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        while let Some(operation) = wanted.get(next.fetch_add(1, Ordering::Relaxed)) {
            let started = Instant::now();
            let figures = one(&dotgen, &folder, operation);
            eprintln!("    {}: {:.1} s", operation.name, started.elapsed().as_secs_f32());
            let mut results = results.lock().unwrap_or_else(|error| error.into_inner());
            results.push((operation.name.to_owned(), figures));
        }
    };
    std::thread::scope(|scope| {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        (0..cores).for_each(|_| drop(scope.spawn(work)));
    });
    let results = results.into_inner().unwrap_or_else(|error| error.into_inner());
    let result = |(name, figures): (String, Result<Figures>)| {
        let figures = figures.with_context(|| name.clone())?;
        Ok((name, figures))
    };
    results.into_iter().map(result).collect()
}

fn one(dotgen: &Path, folder: &Path, operation: &Operation) -> Result<Figures> {
    let mut figures = Figures { instructions: [0.0; 3], megabytes: 0.0 };
    for (at, times) in SIZE_FACTORS.into_iter().enumerate() {
        let here = folder.join(operation.name.replace(' ', "-")).join(times.to_string());
        if here.exists() {
            std::fs::remove_dir_all(&here)?;
        }
        std::fs::create_dir_all(&here)?;
        let arguments = (operation.prepare)(dotgen, &here, SIZE * times)?;
        let counted = instructions(dotgen, &here, &arguments, operation.session)?;
        figures.instructions[at] = counted as f64 / 1e6;
        if times == SIZE_FACTORS[2] {
            figures.megabytes = match operation.session {
                Some(session) => {
                    let mut editor = Editor::start(dotgen, &here, capabilities())?;
                    session(&mut editor, &here)?;
                    let peak = editor.memory("VmHWM")?;
                    editor.end()?;
                    peak
                }
                None => megabytes(dotgen, &here, arguments)?,
            };
        }
    }
    Ok(figures)
}

/// The capabilities of the editor of a session.
fn capabilities() -> serde_json::Value {
    serde_json::json!({ "textDocument": { "diagnostic": {}, "codeAction": {
        "codeActionLiteralSupport": { "codeActionKind": { "valueSet": ["quickfix", "refactor"] } } } } })
}

/// Instructions of one process.
fn instructions(
    dotgen: &Path,
    folder: &Path,
    arguments: &[String],
    session: Option<fn(&mut Editor, &Path) -> Result<()>>,
) -> Result<u64> {
    let out = folder.join("callgrind.out");
    let output = format!("--callgrind-out-file={}", out.display());
    let dotgen = dotgen.to_string_lossy();
    let mut command = run::command(folder, "valgrind", &["--tool=callgrind", &output, &dotgen]);
    command.args(arguments);
    if let Some(session) = session {
        let mut editor = Editor::run(&mut command, folder, capabilities())?;
        session(&mut editor, folder)?;
        editor.end()?;
        return total(&out);
    }
    let output = command.stdout(Stdio::null()).output()?;
    // 1 is the status of what has errors.
    if output.status.code().is_none_or(|code| code > 1) {
        let said = String::from_utf8_lossy(&output.stderr);
        bail!("{arguments:?} failed:\n{said}");
    }
    total(&out)
}

/// The total of what valgrind wrote.
fn total(out: &Path) -> Result<u64> {
    let text = std::fs::read_to_string(out).context("valgrind wrote no counts")?;
    let mut lines = text.lines();
    let total =
        lines.find_map(|line| line.strip_prefix("summary: ").or(line.strip_prefix("totals: ")));
    Ok(total.context("no total in what valgrind wrote")?.trim().parse()?)
}

/// Peak memory of one process, without valgrind.
fn megabytes(dotgen: &Path, folder: &Path, arguments: Vec<String>) -> Result<f64> {
    let job = Job { program: &dotgen.to_string_lossy(), arguments, directory: folder };
    let taken = measure::alternate(&[job], 1)?.pop().flatten();
    Ok(taken.context("it took too long")?.megabytes)
}

/// What is not as the file says.
fn differences(
    budgets: &BTreeMap<String, Figures>,
    measured: &BTreeMap<String, Figures>,
) -> Vec<String> {
    let mut out = Vec::new();
    for (name, figures) in measured {
        let [small, middle, large] = figures.instructions;
        let fixed = (2.0 * small - middle).max(0.0);
        let growth = (large - fixed) / (middle - fixed).max(0.1);
        let allowed = OPERATIONS.iter().find(|operation| operation.name == *name);
        let allowed = allowed.map_or(0.0, |operation| operation.growth);
        if growth > allowed {
            out.push(format!(
                "{name}: twice the input takes {growth:.2} times the instructions, {allowed} are allowed: \
                 {middle:.1} and {large:.1} million"
            ));
        }
        let Some(budget) = budgets.get(name) else {
            out.push(format!("{name}: no budget"));
            continue;
        };
        for (now, then) in std::iter::zip(figures.instructions, budget.instructions) {
            if (now - then).abs() > SLACK * then {
                let percent = 100.0 * (now / then - 1.0);
                out.push(format!(
                    "{name}: {now:.1} million instructions, the budget is {then:.1} ({percent:+.0} %)"
                ));
            }
        }
        if figures.megabytes > budget.megabytes * (1.0 + MEMORY_TOLERANCE) {
            let (now, then) = (figures.megabytes, budget.megabytes);
            out.push(format!("{name}: {now:.0} MB at the peak, the budget is {then:.0} MB"));
        }
    }
    out
}

fn path() -> std::path::PathBuf {
    xtask::root().join("bench/budgets.txt")
}

const HEAD: &str = "\
# Millions of instructions at three sizes, each twice the one before, and peak memory in MB at the largest, of
# the program that `cargo install` builds. Written by `cargo xtask budgets --write`.
";

fn written(all: &BTreeMap<String, Figures>) -> String {
    let mut out = HEAD.to_owned();
    for (name, figures) in all {
        let [a, b, c] = figures.instructions;
        _ = writeln!(out, "{name:<24} {a:>9.1} {b:>9.1} {c:>9.1} {:>6.0}", figures.megabytes);
    }
    out
}

fn read() -> Result<BTreeMap<String, Figures>> {
    let text = std::fs::read_to_string(path()).context("bench/budgets.txt")?;
    let mut out = BTreeMap::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (name, figures) = line.split_at_checked(24).context("a line is too short")?;
        let figures: Vec<f64> = figures
            .split_whitespace()
            .map(str::parse)
            .collect::<Result<_, _>>()
            .with_context(|| line.to_owned())?;
        let [a, b, c, megabytes] = figures[..] else {
            bail!("four figures are needed: {line}");
        };
        let figures = Figures { instructions: [a, b, c], megabytes };
        out.insert(name.trim().to_owned(), figures);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(instructions: [f64; 3], megabytes: f64) -> BTreeMap<String, Figures> {
        let figures = Figures { instructions, megabytes };
        BTreeMap::from([("check".to_owned(), figures)])
    }

    #[test]
    fn the_file_is_read_as_it_is_written() {
        let all = of([1.5, 2.0, 3.0], 20.0);
        let text = written(&all);
        let line = text.lines().last().expect("a line");
        assert_eq!(line, "check                          1.5       2.0       3.0     20");
    }

    #[test]
    fn what_grows_or_shrinks_is_told() {
        let budget = of([10.0, 15.0, 25.0], 20.0);
        assert!(differences(&budget, &of([10.5, 15.5, 25.5], 24.0)).is_empty());
        // More, less, more memory, faster than the input, and unknown.
        for wrong in [
            of([10.0, 17.0, 25.0], 20.0),
            of([10.0, 15.0, 20.0], 20.0),
            of([10.0, 15.0, 25.0], 26.0),
        ] {
            assert_eq!(differences(&budget, &wrong).len(), 1, "{wrong:?}");
        }
        let square = of([1.0, 4.0, 16.0], 20.0);
        assert_eq!(differences(&square, &square).len(), 1);
        assert_eq!(differences(&BTreeMap::new(), &budget), ["check: no budget"]);
    }
}
