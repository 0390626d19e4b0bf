//! `dotgen run`

pub(super) mod bounds;
mod execute;
#[cfg(unix)]
mod hosted;
mod merge;
#[cfg(unix)]
mod params;
mod plan;
mod record;
mod recorder;
mod scenario;
#[cfg(unix)]
mod serve;
#[cfg(unix)]
mod systemd;
pub(super) mod text;

use std::io::Write;

use camino::Utf8PathBuf;
use clap::{Args, ValueEnum};
use dotgen_analysis::model::Seconds;
use dotgen_ros2::remap::Remap;
use dotgen_runtime::engine::End;
use dotgen_runtime::estimate;
use dotgen_runtime::parts::Part;
use dotgen_runtime::report::RunReport;
use dotgen_timing::scn::ast::Unit;
use num_rational::Ratio;
use serde::{Deserialize, Serialize};

use super::outputs::{self, MCAP, Output, PERFETTO, VIEWER};
use super::report::TextOrJson;
use super::system_options::SystemOptions;
use super::verify::{body, interrupt, problems};
use super::{CommandExit, SpecificationOptions, report};
use scenario::{Ended, one};

/// Run components and watch the checks of a scenario
///
/// A scenario (FILE.scn) names its specifications, platform, clients and checks. Without a scenario, all
/// FILE.gen run together as one system; on the virtual clock, a client sends any request at any time.
///
/// Codels with sources are compiled and executed, each component in its own process. Times and yields of
/// other codels are random, and the same for the same seed. The run follows the model of `dotgen verify`;
/// deviations are reported as violations.
///
/// When a run ends, its activities and tasks execute their `stop` codels. After a second signal the run ends
/// without them, after a third one at once.
///
/// Exit status: 0 without violations, 1 with violations of a check, a proved bound or a codel, 2 if nothing
/// could be run (wrong usage, a file that cannot be read or has errors, codels that do not compile), 3 if the
/// run ended early, 4 if something had not ended within --stop-within.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, disable_help_subcommand = true)]
pub(super) struct Arguments {
    /// Scenarios (.scn), specifications (.gen), and directories to search for .gen files [default: the
    /// scenario in this directory, else .]
    #[arg(value_name = "FILE")]
    files: Vec<Utf8PathBuf>,

    #[command(subcommand)]
    command: Option<Subcommand>,

    /// Clock of the run
    #[arg(long, value_enum, default_value_t = Clock::Virtual)]
    clock: Clock,

    /// Codels to simulate instead of executing them; their yields are random
    #[arg(long, value_enum, default_value_t = Simulate::Missing)]
    simulate: Simulate,

    /// Duration of the run, with a unit (us, ms, s, min, h) [default: 10s; on the real clock, until Ctrl-C]
    #[arg(long, value_name = "TIME", value_parser = time, allow_hyphen_values = true)]
    until: Option<Seconds>,

    /// Inputs of the scenario's requests, for example pump.fill={"height": 2}
    #[arg(long = "input", value_name = "SERVICE=JSON", action = clap::ArgAction::Append)]
    inputs: Vec<String>,

    /// Set attributes when the run begins, with --clock real; FILE is JSON, for example
    /// {"pump": {"set_limit": {"limit": 2}}}
    #[arg(long, value_name = "FILE")]
    params: Option<Utf8PathBuf>,

    /// Print a systemd unit that starts this run with the machine, instead of running
    #[cfg(unix)]
    #[arg(long)]
    systemd: bool,

    /// Socket for `dotgen call`, with --clock real [default: NAME.sock in a folder of this user]
    #[arg(long, value_name = "PATH")]
    socket: Option<Utf8PathBuf>,

    /// Also listen on this local TCP port, with --clock real; 0 selects a free port. Clients send the token
    /// in PORT.token, which only this user can read
    #[arg(long, value_name = "PORT")]
    listen: Option<u16>,

    /// Serve all users of this machine on the TCP port, without a token
    #[arg(long, requires = "listen")]
    listen_anyone: bool,

    /// Exchange port data with other machines, with --clock real: listen for Zenoh at this endpoint, for
    /// example tcp/0.0.0.0:7447
    #[arg(long, value_name = "ENDPOINT", action = clap::ArgAction::Append)]
    zenoh_listen: Vec<String>,

    /// Exchange port data with other machines, with --clock real: connect to a peer or Zenoh router at this
    /// endpoint, for example tcp/robot2:7447
    #[arg(long, value_name = "ENDPOINT", action = clap::ArgAction::Append)]
    zenoh_connect: Vec<String>,

    /// Key that an input port reads from other machines, for example pump.goal=planner/goal [default: the
    /// output port of the same name]
    #[arg(long = "zenoh-read", value_name = "PORT=KEY", action = clap::ArgAction::Append)]
    zenoh_reads: Vec<String>,

    /// Make each component a ROS 2 node (rmw_zenoh), with --clock real, at the router at
    /// tcp/localhost:7447 or at --zenoh-connect; with --zenoh-listen, the run is a router itself
    #[arg(long, conflicts_with = "zenoh_reads")]
    ros2: bool,

    /// ROS domain [default: ROS_DOMAIN_ID, or 0]
    #[arg(long, value_name = "N", requires = "ros2", value_parser = clap::value_parser!(u32).range(0..=232))]
    ros_domain: Option<u32>,

    /// Rename a topic, service or action, for example /motor/measure:=/odom
    #[arg(long = "remap", value_name = "FROM:=TO", requires = "ros2", action = clap::ArgAction::Append)]
    remaps: Vec<Remap>,

    /// Number of runs, each with the next seed
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    runs: u64,

    /// As many runs as make the interval of each probability narrower than WIDTH, for example 0.02
    #[arg(long, value_name = "WIDTH", value_parser = width, conflicts_with = "runs")]
    width: Option<f64>,

    /// Only part K of M of the runs, for example 3/8; `dotgen run merge` merges the reports of all parts
    #[arg(long, value_name = "K/M", value_parser = shard, default_value = "1/1", hide_default_value = true)]
    shard: Part,

    /// Seed of random times and yields
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    seed: u64,

    /// Draw yields of simulated codels by weights: a file of `OWNER::COMP_STATE::COMP_STATE COUNT`, instead
    /// of that of the scenario
    #[arg(long, value_name = "FILE")]
    weights: Option<Utf8PathBuf>,

    /// Execution times on the virtual clock, and of simulated codels, within their intervals
    #[arg(long, value_enum, default_value_t = DurationsName::Random)]
    durations: DurationsName,

    #[command(flatten)]
    system: SystemOptions,

    /// Watch CHECK instead of the scenario's checks, for example "response arm.motion <= 5 ms"
    #[arg(long = "check", value_name = "CHECK", action = clap::ArgAction::Append)]
    checks: Vec<String>,

    /// Bounds to compare response times with
    #[arg(long, value_enum, default_value_t = bounds::Source::Proved)]
    bounds: bounds::Source,

    /// Reaction to a violation
    #[arg(long, value_enum, default_value_t = OnViolation::Report)]
    on_violation: OnViolation,

    /// Longest end of the run: the time in which `stop` codels must have ended, with a unit
    #[arg(long, value_name = "TIME", value_parser = stop_within, default_value = "2s")]
    stop_within: std::time::Duration,

    /// Time in which the processes of components expect a sign of the engine, with --clock real; without one
    /// they execute their `stop` codels by themselves and end [default: 1s]
    #[arg(long, value_name = "TIME", value_parser = watched_within)]
    engine_within: Option<std::time::Duration>,

    /// Time in which the process of a component that executes cycles without the engine must answer, with
    /// --clock real; one that does not is ended [default: 2s]
    #[arg(long, value_name = "TIME", value_parser = watched_within)]
    host_within: Option<std::time::Duration>,

    /// Write all executions of codels to FILE, in the format of GenoM3's profiler
    #[arg(long, value_name = "FILE")]
    profile: Option<Utf8PathBuf>,

    /// Write a trace: FILE.pftrace (tasks, cores, locks, requests) for https://ui.perfetto.dev, or FILE.json
    /// (the first run) for the trace viewer
    #[arg(long, value_name = "FILE")]
    trace: Option<Utf8PathBuf>,

    /// Write a recording (.mcap): values of ports for https://foxglove.dev, and steps for `dotgen replay`
    #[arg(long, value_name = "FILE")]
    record: Option<Utf8PathBuf>,

    /// Compile codels with debug information; each component prints its process id and waits for a debugger
    #[arg(long)]
    debug: bool,

    /// Output format
    #[arg(long, value_enum, default_value_t = TextOrJson::Text)]
    format: TextOrJson,

    #[command(flatten)]
    reading: SpecificationOptions,
}

#[derive(Debug, clap::Subcommand)]
enum Subcommand {
    /// Merge the reports of parts of the runs
    Merge(merge::Arguments),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Clock {
    /// Simulated time: discrete events, no waiting
    Virtual,
    /// The clock of this machine
    Real,
}

impl Clock {
    fn word(self) -> &'static str {
        match self {
            Clock::Virtual => "virtual",
            Clock::Real => "real",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Simulate {
    /// Codels without a function in the sources
    Missing,
    /// All codels
    All,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum DurationsName {
    /// Always the longest time
    Worst,
    /// A random time of the interval
    Random,
    /// Always the shortest time
    Best,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum OnViolation {
    /// Report it at the end
    Report,
    /// Also stop the activity whose codel took too long
    StopActivity,
    /// Stop the run
    Stop,
}

/// The longest bound on the end of a run.
const MAX_STOP: std::time::Duration = std::time::Duration::from_mins(10);

/// The least time for a sign of life: the engine waits for events up to 50 ms.
const MIN_WATCHED: std::time::Duration = std::time::Duration::from_millis(200);

/// A file, and the number of items in it.
type WrittenFile = (Utf8PathBuf, u64, Contents);

/// The kind of items in a file.
#[derive(Debug, Clone, Copy)]
enum Contents {
    Lines,
    Codels,
    Steps,
    /// Messages of ports, and the number of steps.
    Messages(u64),
}

/// A finished run: a document of `--format json`.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Answer {
    /// The scenario, as users call it.
    file: String,
    clock: Clock,
    /// Cores, policy, durations and semantics, in words.
    platform: String,
    executed_codels: usize,
    simulated_codels: usize,
    #[serde(flatten)]
    report: RunReport,
    /// Files that were written.
    #[serde(skip)]
    written: Vec<WrittenFile>,
}

/// Parses a time with its unit.
fn time(text: &str) -> Result<Seconds, String> {
    let wrong = || "give a time with a unit, for example 10s, 500ms or 2min".to_owned();
    let at = text.find(|c: char| c.is_ascii_alphabetic());
    let (number, unit) = text.split_at(at.ok_or_else(wrong)?);
    let number: Seconds = exact(number.trim()).ok_or_else(wrong)?;
    let unit = match unit {
        "us" | "µs" => Unit::Microseconds.seconds(),
        "ms" => Unit::Milliseconds.seconds(),
        "s" => Ratio::from_integer(1),
        "min" => Ratio::from_integer(60),
        "h" => Ratio::from_integer(3600),
        _ => return Err(wrong()),
    };
    Ok(number * unit)
}

/// The least width: it takes seven million runs.
const MIN_WIDTH: f64 = 0.001;

/// Parses the width of an interval of probabilities.
fn width(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(width) if (MIN_WIDTH..=1.0).contains(&width) => Ok(width),
        _ => Err(format!("give a number from {MIN_WIDTH} to 1")),
    }
}

/// Parses a part of the runs: `3/8`.
fn shard(text: &str) -> Result<Part, String> {
    let numbers = text
        .split_once('/')
        .and_then(|(index, of)| Some((index.parse::<u64>().ok()?, of.parse::<u64>().ok()?)));
    match numbers {
        Some((index, of)) if (1..=of).contains(&index) => Ok(Part { index: index - 1, of }),
        _ => Err("give the number of the part and that of all parts, for example 3/8".to_owned()),
    }
}

/// Parses the longest end of a run.
fn stop_within(text: &str) -> Result<std::time::Duration, String> {
    let nanos = (time(text)? * Ratio::from_integer(1_000_000_000)).to_integer();
    match u64::try_from(nanos) {
        Ok(nanos) if nanos <= MAX_STOP.as_nanos() as u64 => {
            Ok(std::time::Duration::from_nanos(nanos))
        }
        _ => Err(format!("give at most {} s", MAX_STOP.as_secs())),
    }
}

/// Parses the time in which the engine and a host expect a sign of each other.
fn watched_within(text: &str) -> Result<std::time::Duration, String> {
    let within = stop_within(text)?;
    if within >= MIN_WATCHED {
        Ok(within)
    } else {
        Err(format!("give at least {} ms", MIN_WATCHED.as_millis()))
    }
}

/// Parses a decimal number that is not negative.
fn exact(text: &str) -> Option<Seconds> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let digits = format!("{whole}{fraction}");
    let short = fraction.len() <= 9 && digits.len() <= 18;
    if !short || digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let scale = 10i128.pow(u32::try_from(fraction.len()).ok()?);
    Some(Ratio::new(digits.parse().ok()?, scale))
}

impl Arguments {
    /// Returns the number of runs, of which `--shard` selects a part.
    fn all_runs(&self) -> u64 {
        self.width.map_or(self.runs, estimate::runs_for)
    }

    /// Reports options that do not fit together, for a number of scenarios.
    fn check(&self, scenarios: usize) -> anyhow::Result<()> {
        let several = scenarios > 1 || self.all_runs() > 1;
        let virtually = self.clock == Clock::Virtual;
        let conflicts = [
            (
                self.profile.is_some() && scenarios > 1,
                "`--profile` writes one file: run one scenario at a time",
            ),
            (
                self.trace.is_some() && scenarios > 1,
                "`--trace` writes one file: run one scenario at a time",
            ),
            (
                self.record.is_some() && several,
                "`--record` writes one run: one scenario, without `--runs`",
            ),
            (
                self.all_runs() < self.shard.of,
                "`--shard` divides runs into parts: give `--runs` at least as many as parts",
            ),
            (
                self.seed.checked_add(self.all_runs()).is_none(),
                "`--seed` is too large: each run has the next seed",
            ),
            (self.debug && several, "`--debug` is for one run: one scenario, without `--runs`"),
            (
                self.debug && self.simulate == Simulate::All,
                "`--debug` is for codels that are executed: leave `--simulate all` out",
            ),
            (
                self.debug && !cfg!(target_os = "linux"),
                "components wait for a debugger on Linux only",
            ),
            (
                (self.width.is_some() || self.shard.of > 1) && !virtually,
                "`--width` and `--shard` are for `--clock virtual`: runs on the clock of this machine are no sample",
            ),
            (
                self.socket.is_some() && virtually,
                "`--socket` needs `--clock real`: no request can come in time on the virtual clock",
            ),
            (
                self.params.is_some() && virtually,
                "`--params` needs `--clock real`; on the virtual clock, a client of the scenario sets attributes",
            ),
            (
                (self.engine_within.is_some() || self.host_within.is_some()) && virtually,
                "`--engine-within` and `--host-within` need `--clock real`: on the virtual clock, the engine and \
                 the components wait for each other",
            ),
            (
                self.is_unit() && virtually,
                "`--systemd` needs `--clock real`: a run on the virtual clock ends at once",
            ),
            (
                self.listen.is_some() && virtually,
                "`--listen` needs `--clock real`: no request can come in time on the virtual clock",
            ),
            (
                self.has_network() && virtually,
                "`--zenoh-listen` and `--zenoh-connect` are for `--clock real`: other machines have another \
                 virtual clock",
            ),
            (
                self.ros2 && virtually,
                "`--ros2` needs `--clock real`: ROS 2 nodes do not know the virtual clock",
            ),
            (
                !self.zenoh_reads.is_empty() && !self.has_network(),
                "`--zenoh-read` needs other machines: add `--zenoh-listen` or `--zenoh-connect`",
            ),
        ];
        match conflicts.into_iter().find(|conflict| conflict.0) {
            Some((_, why)) => Err(anyhow::anyhow!(why)),
            None => Ok(()),
        }
    }
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    if let Some(Subcommand::Merge(arguments)) = &arguments.command {
        return merge::run(arguments);
    }
    let checks: Vec<&str> = arguments.checks.iter().map(|check| body(check)).collect();
    // Every way to end a run also ends its compilers and hosts.
    let interrupt = interrupt::on_signals();
    let (all, mut trouble) =
        problems(&crate::session::or_scenario_here(&arguments.files)?, &arguments.reading);
    arguments.check(all.len())?;
    #[cfg(unix)]
    if arguments.systemd {
        let titles: Vec<&str> =
            all.iter().map(|(_, problem)| problem.path.file_stem().unwrap_or_default()).collect();
        let unit =
            systemd::unit(&titles.join(", "), std::env::args_os().skip(1), arguments.stop_within)?;
        std::io::stdout().write_all(unit.as_bytes())?;
        return Ok(trouble.outcome(CommandExit::Fine));
    }
    let output = |path, endings| Output { path, endings };
    let log = arguments.profile.iter().map(|profile| output(profile, &[]));
    let trace = arguments.trace.iter();
    let trace = trace.map(|trace| output(trace, &[PERFETTO, VIEWER]));
    let record = arguments.record.iter().map(|record| output(record, &[MCAP]));
    let written: Vec<Output<'_>> = log.chain(trace).chain(record).collect();
    outputs::check(&written, all.iter().flat_map(|(_, problem)| problem.files()))?;
    let mut answers = Vec::new();
    for (session, problem) in all {
        match one(arguments, (&session, problem), (&checks, &interrupt), &mut trouble)? {
            Ended::Answered(answer) => answers.push(*answer),
            Ended::Unusable => trouble.told(),
            Ended::Stopped(outcome) => return Ok(outcome),
        }
    }
    print(&answers, arguments.format)?;
    Ok(trouble.outcome(outcome(&answers)))
}

fn print(answers: &[Answer], format: TextOrJson) -> anyhow::Result<()> {
    match format {
        _ if answers.is_empty() => Ok(()),
        TextOrJson::Text => text::print(answers),
        TextOrJson::Json => print_json(answers),
    }
}

fn outcome(answers: &[Answer]) -> CommandExit {
    let ended = |answer: &Answer| !matches!(answer.report.end, End::Done | End::NothingLeft);
    if answers.iter().any(|answer| !answer.report.unfinished.is_empty()) {
        CommandExit::NotStopped
    } else if answers.iter().any(|answer| answer.report.violated()) {
        CommandExit::Errors
    } else if answers.iter().any(ended) {
        CommandExit::GaveUp
    } else {
        CommandExit::Fine
    }
}

impl Arguments {
    /// Returns a function that reports components that wait for a debugger: as text on standard error, or as
    /// a line of JSON for each before the report.
    #[cfg(unix)]
    fn waiting(&self) -> dotgen_hosting::children::Waiting {
        let format = self.format;
        Box::new(move |component, process| match format {
            TextOrJson::Text => {
                report::note(&format!("`{component}` waits for a debugger: gdb -p {process}"));
            }
            TextOrJson::Json => {
                let line = serde_json::json!({
                    "format": dotgen_runtime::report::FORMAT,
                    "component": component,
                    "process": process,
                });
                let mut out = std::io::stdout();
                // If the output is closed, the run continues.
                let _ = writeln!(out, "{line}").and_then(|()| out.flush());
            }
        })
    }

    /// Returns true if a unit for systemd is wanted.
    fn is_unit(&self) -> bool {
        #[cfg(unix)]
        return self.systemd;
        #[cfg(not(unix))]
        false
    }

    /// Returns true if port data is exchanged with other machines.
    fn has_network(&self) -> bool {
        !self.zenoh_listen.is_empty() || !self.zenoh_connect.is_empty()
    }

    /// The ROS domain, from the option or from the environment as in ROS 2.
    #[cfg(all(unix, feature = "zenoh"))]
    fn ros_domain(&self) -> anyhow::Result<u32> {
        let given = std::env::var("ROS_DOMAIN_ID").unwrap_or_default();
        match (self.ros_domain, given.as_str()) {
            (Some(domain), _) => Ok(domain),
            (None, "") => Ok(0),
            (None, variable) => match variable.parse() {
                Ok(number @ 0..=232) => Ok(number),
                _ => anyhow::bail!("ROS_DOMAIN_ID is `{variable}`: write a number from 0 to 232"),
            },
        }
    }
}

/// One document: an object for one scenario, a list for several.
fn print_json(answers: &[Answer]) -> anyhow::Result<()> {
    let documents = answers.iter().map(serde_json::to_value).collect::<Result<_, _>>()?;
    outputs::print_json(&outputs::one_or_all(documents))
}
