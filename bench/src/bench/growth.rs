//! The cost of verification: for the published systems, and for growing systems.

use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result};
use serde_json::Value;

use super::measure::{Job, Measurement, alternate, announce};
use super::{SECONDS, show};
use crate::chart::{Chart, Line};
use xtask::run::step;
use xtask::shared::optional;
use xtask::{root, target};

/// The published systems on 1 to 5 cores; skipped if they are not available.
pub(crate) fn corpus(dotgen: &Path, runs: usize) -> Result<()> {
    announce()?;
    // All checks together, and one by one if there are several.
    let robnav: &[&str] = &["schedulable *", "no-overdue *", "response *"];
    for (name, scenario, checks) in
        [("RobNav", "robnav/robnav.scn", robnav), ("Quadcopter", "quadcopter/hover.scn", &[])]
    {
        step(&format!("{name}, 1 to 5 cores"));
        let Some(path) = optional(&format!("corpus/{scenario}")) else {
            continue;
        };
        println!("| {name}, cores | checks | fixed | interval |\n| --- | --- | --- | --- |");
        for cores in 1..=5 {
            row(dotgen, &path, cores, None, runs)?;
        }
        for check in checks {
            row(dotgen, &path, 4, Some(check), runs)?;
        }
    }
    Ok(())
}

fn row(dotgen: &Path, scenario: &Path, cores: u32, check: Option<&str>, runs: usize) -> Result<()> {
    let job = |durations: &str| {
        let mut arguments = vec!["verify", "--format", "json", "--durations", durations];
        let cores = cores.to_string();
        arguments.extend(["--cores", &*cores]);
        if let Some(check) = check {
            arguments.extend(["--check", check]);
        }
        let scenario = scenario.to_string_lossy();
        arguments.push(&*scenario);
        command(dotgen, &arguments)
    };
    let taken = alternate(&[job("fixed"), job("interval")], runs)?;
    let cells = taken.iter().map(|measurement| match measurement {
        Some(measurement) => cell(measurement),
        None => Ok("gave up".to_owned()),
    });
    let cells = cells.collect::<Result<Vec<_>>>()?.join(" | ");
    println!("| {cores} | {} | {cells} |", check.unwrap_or("all"));
    Ok(())
}

fn command<'a>(dotgen: &'a Path, arguments: &[&str]) -> Job<'a> {
    Job {
        program: dotgen.to_str().unwrap_or("dotgen"),
        arguments: arguments.iter().map(ToString::to_string).collect(),
        directory: root(),
    }
}

/// Time, memory, states, and the number of checks that hold.
fn cell(taken: &Measurement) -> Result<String> {
    let report: Value = serde_json::from_str(&taken.output).context("dotgen wrote no JSON")?;
    let checks = report["checks"].as_array().context("no checks")?;
    let count = |verdict| checks.iter().filter(|check| check["verdict"] == verdict).count();
    let mut out =
        show(taken.seconds, taken.megabytes, report["states"].as_u64().context("no states")?);
    let _ = write!(out, "; {} proved", count("proved"));
    for verdict in ["refuted", "unknown"] {
        if count(verdict) > 0 {
            let _ = write!(out, ", {} {verdict}", count(verdict));
        }
    }
    Ok(out)
}

/// The connections between the components of a growing system.
struct Kind {
    name: &'static str,
    /// True if each component reads the port of the previous one.
    chain: bool,
    platform: &'static str,
}

const KINDS: [Kind; 4] = [
    Kind { name: "ports and cores shared", chain: true, platform: "cores 2; policy fifo;" },
    Kind { name: "two cores shared", chain: false, platform: "cores 2; policy fifo;" },
    Kind { name: "chained by ports", chain: true, platform: "cores free;" },
    Kind { name: "nothing shared", chain: false, platform: "cores free;" },
];

/// Draws time and memory against the number of components.
pub(crate) fn growth(dotgen: &Path, runs: usize) -> Result<()> {
    announce()?;
    step("Growing systems of one task per component, durations from 0 to the WCET");
    let mut lines = KINDS.map(|kind| (kind.name, Vec::new()));
    let names = KINDS.map(|kind| kind.name).join(" | ");
    println!("| components | {names} |\n| --- | --- | --- | --- | --- |");
    for n in 1..=8 {
        let mut jobs = Vec::new();
        for (number, kind) in KINDS.iter().enumerate() {
            let folder = target().join(format!("growth/{number}"));
            std::fs::create_dir_all(&folder)?;
            let (genom, scenario) = stages(kind, n);
            std::fs::write(folder.join("growth.gen"), genom)?;
            let path = folder.join("growth.scn");
            std::fs::write(&path, scenario)?;
            let path = path.to_string_lossy();
            jobs.push(command(dotgen, &["verify", "--format", "json", &*path]));
        }
        let mut cells = Vec::new();
        for ((_, points), taken) in std::iter::zip(&mut lines, alternate(&jobs, runs)?) {
            cells.push(match &taken {
                Some(measurement) => cell(measurement)?,
                None => "gave up".to_owned(),
            });
            points.extend(taken.map(|measurement| (n, measurement.seconds, measurement.megabytes)));
        }
        println!("| {n} | {} |", cells.join(" | "));
    }
    let drawn = |what: fn(&(usize, f64, f64)) -> f64| {
        let line = |(name, points): &(&'static str, Vec<(usize, f64, f64)>)| Line {
            name,
            points: points.iter().map(|point| (point.0, what(point))).collect(),
        };
        lines.iter().map(line).collect::<Vec<_>>()
    };
    let pictures = root().join("docs/charts");
    let chart = Chart {
        title: "Time of a verification",
        across: "components",
        powers: SECONDS,
        ratios: false,
        lines: drawn(|(_, seconds, _)| *seconds),
    };
    std::fs::write(pictures.join("growth-time.svg"), chart.svg())?;
    let chart = Chart {
        title: "Memory of a verification",
        across: "components",
        powers: &[(10.0, "10 MB"), (100.0, "100 MB"), (1000.0, "1 GB"), (10000.0, "10 GB")],
        ratios: false,
        lines: drawn(|(.., megabytes)| *megabytes),
    };
    std::fs::write(pictures.join("growth-memory.svg"), chart.svg())?;
    step("Drew docs/charts/growth-time.svg and growth-memory.svg");
    Ok(())
}

/// Specification and scenario of `n` components that read, work and write.
fn stages(kind: &Kind, n: usize) -> (String, String) {
    let mut genom = String::new();
    for i in 1..=n {
        let input = match kind.chain {
            true => format!("v{}", i - 1),
            false => format!("unconnected{i}"),
        };
        let period = [20, 40, 60][i % 3];
        let _ = writeln!(
            genom,
            "component stage{i} {{
  version \"1.0\";
  lang \"c\";
  struct data_s {{ long value; }};
  port in data_s {input};
  port out data_s v{i};
  task t {{
    period {period} ms;
    codel<start> start{i}() yield pause::read wcet 0 ms;
    codel<read> read{i}(port in {input}) yield work wcet 1 ms;
    codel<work> work{i}() yield write wcet 2 ms;
    codel<write> write{i}(port out v{i}) yield pause::read wcet 1 ms;
  }};
}};"
        );
    }
    let scenario = format!(
        "scenario growth {{\n  use \"growth.gen\"; semantics published;\n  unit 1 ms;\n  {}\n  durations interval;\n  \
         check schedulable *;\n  check response *;\n}}\n",
        kind.platform
    );
    (genom, scenario)
}
