//! Measurements that benchmarks inside a crate cannot make: whole processes, and instruction counts.
//!
//! Times are medians of alternating runs, so that disturbances affect all of them equally. Times of
//! verification are processor time. Instructions are counted by valgrind, whose results are reproducible.

mod adversarial;
pub(crate) mod client;
mod codels;
mod competitors;
mod endurance;
mod flight;
mod growth;
pub(crate) mod measure;
mod periodic;
mod reductions;
mod runtime;
mod semantics;
mod session;
mod size;
mod stacks;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use serde_json::Value;

use xtask::run::{self, step};
use xtask::{example, root, target, tools};

/// See the module.
#[derive(Args)]
pub(crate) struct Options {
    /// What to measure.
    #[arg(value_enum, default_value_t = What::Server)]
    what: What,
    /// Runs of each process. Default: 101 for `server`, 5 for the others.
    #[arg(long)]
    runs: Option<usize>,
    /// Random sets of periodic tasks to compare verdicts on, or random stacks.
    #[arg(long, default_value_t = 200)]
    sets: u64,
    /// Components of the workspaces of `size`.
    #[arg(long, value_delimiter = ',', default_value = "10,100,1000")]
    components: Vec<usize>,
    /// Size of the smallest texts of `adversarial`.
    #[arg(long, default_value_t = 500)]
    lines: usize,
    /// How long `endurance` edits.
    #[arg(long, default_value_t = 60.0)]
    minutes: f64,
    /// Duration of each measurement of `runtime`, time limit of each of `stacks`.
    #[arg(long, default_value_t = 5.0)]
    seconds: f64,
    /// Duration of the run of two tasks of `runtime`. Default: that of the others.
    #[arg(long)]
    task_seconds: Option<f64>,
    /// A program to measure instead of one built for release now.
    #[arg(long)]
    dotgen: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// Start of processes, an editing session, instructions of the front end.
    Server,
    /// Components with sources in C and C++: checks, and typing in an editor, beside the goals. DOTGEN_CLONES
    /// names a folder of public components.
    Codels,
    /// Verification next to TChecker and the schedule-abstraction tool, by their paths in TCHECKER and SAG.
    Competitors,
    /// Verification of the published systems.
    Verify,
    /// Verification of a flight stack, with and without schedule abstraction.
    Flight,
    /// Verification of growing systems; draws the charts in docs/charts.
    Growth,
    /// Workspaces of growing size, on the command line and in an editor; draws the charts in docs/charts.
    Size,
    /// Thousands of files of one line.
    Tiny,
    /// Instructions for worst-case texts of growing size.
    Adversarial,
    /// Memory of a server during an hour of edits.
    Endurance,
    /// Verification with and without each reduction.
    Reductions,
    /// Components on the real clock: codels, ticks, ports, requests. Needs compilers and Linux, for ports
    /// between runs a --dotgen with Zenoh, and compares with `cyclictest` if it is installed.
    Runtime,
    /// Answers under the semantics of the servers and under the published one, and the point that makes the
    /// difference.
    Semantics,
    /// Deadlines of random stacks that are answered, with --seconds for each stack.
    Stacks,
}

/// The scale of times in charts.
const SECONDS: &[(f64, &str)] = &[
    (0.001, "1 ms"),
    (0.01, "10 ms"),
    (0.1, "100 ms"),
    (1.0, "1 s"),
    (10.0, "10 s"),
    (100.0, "100 s"),
];

/// Measures and prints. Returns true if the programs that must agree did.
pub(crate) fn bench(options: &Options) -> Result<bool> {
    if options.runs == Some(0) {
        bail!("--runs 0 measures nothing; give at least 1");
    }
    let dotgen = match &options.dotgen {
        Some(dotgen) => std::path::absolute(dotgen)?,
        None => build(options.what)?,
    };
    let runs = |default| options.runs.unwrap_or(default);
    match options.what {
        What::Server => server(&dotgen, runs(101))?,
        What::Codels => codels::codels(&dotgen, runs(5))?,
        What::Competitors => return competitors::competitors(&dotgen, runs(5), options.sets),
        What::Verify => growth::corpus(&dotgen, runs(5))?,
        What::Flight => flight::flight(&dotgen, runs(3))?,
        What::Growth => growth::growth(&dotgen, runs(5))?,
        What::Reductions => reductions::reductions(&dotgen, runs(1))?,
        What::Runtime => {
            let task_seconds = options.task_seconds.unwrap_or(options.seconds);
            runtime::runtime(&dotgen, options.seconds, task_seconds)?;
        }
        What::Semantics => semantics::semantics(&dotgen)?,
        What::Stacks => stacks::stacks(&dotgen, options.sets, options.seconds)?,
        What::Size => size::size(&dotgen, &options.components, runs(3))?,
        What::Tiny => size::tiny(&dotgen, runs(3))?,
        What::Adversarial => return adversarial::adversarial(&dotgen, options.lines),
        What::Endurance => endurance::endurance(&dotgen, options.minutes)?,
    }
    Ok(true)
}

/// Builds the program that is measured.
fn build(what: What) -> Result<PathBuf> {
    step("Building dotgen as a release publishes it");
    let mut command = run::cargo(&["build", "--profile=dist", "--quiet", "--package", "dotgen"]);
    if what == What::Runtime {
        command.args(["--features", "zenoh"]);
    }
    run::run(command)?;
    Ok(target().join("dist/dotgen"))
}

fn server(dotgen: &Path, runs: usize) -> Result<()> {
    step("Whole processes, alternating");
    processes(dotgen, runs)?;
    step("An editing session over the protocol, in a workspace of 100 components");
    session::session(dotgen)?;
    step("Instructions, counted by valgrind");
    instructions()
}

/// Time, memory and states, as a cell of a table.
fn show(seconds: f64, megabytes: f64, states: u64) -> String {
    format!("{}, {megabytes:.0} MB, {states}", show_time(seconds))
}

/// A duration in a suitable unit.
fn show_time(seconds: f64) -> String {
    match seconds {
        number if number < 0.1 => format!("{:.1} ms", number * 1e3),
        number if number < 1.0 => format!("{:.0} ms", number * 1e3),
        number => format!("{number:.1} s"),
    }
}

fn processes(dotgen: &Path, runs: usize) -> Result<()> {
    let dotgen = dotgen.to_string_lossy();
    let file = example().join("maneuver.gen");
    let file = file.to_string_lossy();
    let commands: [(&str, &str, &[&str]); 3] = [
        ("a process that does nothing (`true`)", "true", &[]),
        ("`dotgen --version`", &dotgen, &["--version"]),
        ("`dotgen check` of the maneuver example", &dotgen, &["check", &file]),
    ];
    let mut times = vec![Vec::with_capacity(runs); commands.len()];
    for _ in 0..runs {
        for ((_, program, arguments), times) in std::iter::zip(&commands, &mut times) {
            let started = Instant::now();
            let output = run::command(root(), program, arguments).output();
            output.with_context(|| format!("cannot run {program}"))?;
            times.push(started.elapsed());
        }
    }
    let mut medians = times.iter_mut().map(|time| median(time));
    let base = medians.next().unwrap_or_default();
    println!("{:<42} {:>7.2} ms", commands[0].0, milliseconds(base));
    for ((name, ..), median) in std::iter::zip(&commands[1..], medians) {
        let ratio = median.as_secs_f64() / base.as_secs_f64();
        println!("{name:<42} {:>7.2} ms  {ratio:>5.1} x", milliseconds(median));
    }
    Ok(())
}

fn median(times: &mut [Duration]) -> Duration {
    times.sort_unstable();
    times[times.len() / 2]
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Runs a benchmark program of the syntax crate once and eleven times; the tenth of the difference is one
/// round.
fn instructions() -> Result<()> {
    tools::ensure(tools::VALGRIND)?;
    let program = instruction_program()?;
    println!("{:<42} {:>14} {:>14}", "700 lines, once", "instructions", "per token");
    for what in ["lex", "parse"] {
        let (once, tokens) = count(&program, what, 1)?;
        let (often, _) = count(&program, what, 11)?;
        let round = (often - once) / 10;
        println!("{what:<42} {round:>14} {:>14.1}", round as f64 / tokens as f64);
    }
    Ok(())
}

/// Builds the program and returns its path.
fn instruction_program() -> Result<String> {
    let messages = run::capture(run::cargo(&[
        "bench",
        "--quiet",
        "--package",
        "dotgen-syntax",
        "--bench",
        "instructions",
        "--no-run",
        "--message-format=json",
    ]))?;
    let mut programs = messages.lines().filter_map(|line| {
        let message: Value = serde_json::from_str(line).ok()?;
        (message["target"]["name"] == "instructions").then_some(())?;
        Some(message["executable"].as_str()?.to_owned())
    });
    programs.next_back().context("cargo built no program")
}

/// Instructions of `rounds` rounds, and the tokens of one.
fn count(program: &str, what: &str, rounds: u64) -> Result<(u64, u64)> {
    let out = target().join("callgrind.out");
    let rounds = rounds.to_string();
    let arguments = [
        "--tool=callgrind",
        &format!("--callgrind-out-file={}", out.display()),
        program,
        what,
        &rounds,
    ];
    let tokens = run::capture(run::command(root(), "valgrind", &arguments))?;
    let text = std::fs::read_to_string(&out).context("valgrind wrote no counts")?;
    let total = text
        .lines()
        .find_map(|line| line.strip_prefix("summary: ").or(line.strip_prefix("totals: ")));
    let total = total.context("no total in what valgrind wrote")?;
    Ok((total.trim().parse()?, tokens.trim().parse()?))
}
