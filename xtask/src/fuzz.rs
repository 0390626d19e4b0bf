//! `cargo xtask fuzz`: libFuzzer searches for inputs that cause failures, guided by coverage.
//!
//! The program is built with libFuzzer's counters, for which the stable compiler is sufficient. Inputs with
//! new coverage stay in `target/fuzz`. With `--keep`, a minimal set with the same coverage goes to
//! `fuzz/corpus`, which the tests run.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Args;

use xtask::run::{self, step};
use xtask::target;

/// Options of `cargo xtask fuzz`.
#[derive(Args)]
pub(crate) struct Options {
    /// What is fuzzed: specification, format, codels, scenario, messages. All of them, one after the other,
    /// by default.
    targets: Vec<String>,
    /// Seconds for each target.
    #[arg(long, default_value_t = 60)]
    seconds: u32,
    /// Inputs for each target; 0 is as many as the time allows.
    #[arg(long, default_value_t = 0)]
    inputs: u64,
    /// Puts the least inputs that reach as much into fuzz/corpus.
    #[arg(long)]
    keep: bool,
}

const TARGETS: &[&str] = &["specification", "format", "codels", "scenario", "messages"];

/// Counters for each edge, a table of places, and comparisons of values.
const FLAGS: &str = "--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=1";

/// Fuzzes. Returns false if an input caused a failure.
pub(crate) fn fuzz(options: &Options) -> Result<bool> {
    let known = |text: &&String| !TARGETS.contains(&text.as_str());
    if let Some(unknown) = options.targets.iter().find(known) {
        bail!("no target `{unknown}`; there are: {}", TARGETS.join(", "));
    }
    let program = build()?;
    let mut fine = true;
    for target in TARGETS {
        if options.targets.is_empty() || options.targets.iter().any(|chosen| chosen == target) {
            fine &= one(&program, target, options)?;
        }
    }
    Ok(fine)
}

fn build() -> Result<PathBuf> {
    step("Building with counters of coverage (some minutes at first)");
    let manifest = xtask::root().join("fuzz/Cargo.toml");
    let manifest = manifest.to_string_lossy();
    let into = target().join("fuzz/build");
    // With an explicit target, build scripts and macros are built without the flags.
    let host = host()?;
    let arguments =
        ["build", "--release", "--locked", "--manifest-path", &manifest, "--target", &host];
    let mut cargo = run::cargo(&arguments);
    cargo.env("RUSTFLAGS", FLAGS).env("CARGO_TARGET_DIR", &into);
    run::run(cargo)?;
    Ok(into.join(&host).join("release/dotgen-fuzz"))
}

/// The triple of this machine.
fn host() -> Result<String> {
    let version = run::capture(run::command(xtask::root(), "rustc", &["-vV"]))?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: "));
    match host {
        Some(host) => Ok(host.to_owned()),
        None => bail!("`rustc -vV` names no host"),
    }
}

fn one(program: &Path, name: &str, options: &Options) -> Result<bool> {
    step(&format!("Fuzzing `{name}`"));
    let found = target().join("fuzz").join(name);
    let kept = xtask::root().join("fuzz/corpus").join(name);
    std::fs::create_dir_all(&found)?;
    std::fs::create_dir_all(&kept)?;
    let (found, kept) = (found.to_string_lossy().into_owned(), kept.to_string_lossy().into_owned());
    let time = format!("-max_total_time={}", options.seconds);
    let broken = format!("-artifact_prefix={found}-broken-");
    let runs = match options.inputs {
        0 => "-runs=-1".to_owned(),
        n => format!("-runs={n}"),
    };
    // An input that takes ten seconds is a failure, like a panic.
    let limits = ["-timeout=10", "-rss_limit_mb=4096", "-max_len=16384", "-print_final_stats=1"];
    let mut arguments = vec![found.as_str(), &kept, &time, &runs, &broken];
    arguments.extend(limits);
    let examples = xtask::root().join("examples");
    let seeds = target().join("fuzz").join(format!("{name}-seeds"));
    let seeds = if seeded(&examples, name, &seeds)? {
        seeds.to_string_lossy().into_owned()
    } else {
        kept.clone()
    };
    arguments.push(&seeds);
    let mut command = run::command(xtask::root(), &program.to_string_lossy(), &arguments);
    command.env("FUZZ_TARGET", name);
    let fine = command.status()?.success();
    if fine && options.keep {
        let mut merge = run::command(
            xtask::root(),
            &program.to_string_lossy(),
            &["-merge=1", "-max_len=16384", "-timeout=10", &kept, &found],
        );
        merge.env("FUZZ_TARGET", name);
        run::run(merge)?;
    }
    Ok(fine)
}

/// Copies the examples for a target into a flat folder. Returns true if there are any.
fn seeded(folder: &Path, name: &str, into: &Path) -> Result<bool> {
    let extensions: &[&str] = match name {
        "specification" | "format" => &["gen", "idl"],
        "codels" => &["c"],
        "scenario" => &["scn"],
        _ => return Ok(false),
    };
    std::fs::create_dir_all(into)?;
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let extension = path.extension().and_then(|extension| extension.to_str());
        if path.is_dir() {
            seeded(&path, name, into)?;
        } else if extension.is_some_and(|extension| extensions.contains(&extension))
            && let Some(file) = path.file_name()
        {
            std::fs::copy(&path, into.join(file))?;
        }
    }
    Ok(true)
}
