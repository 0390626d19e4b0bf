//! A flight stack: 7 tasks of 4 components, periods of 1 to 5 ms, execution times from 0; see
//! `flight/flight.gen`.

use std::path::Path;

use anyhow::{Context, Result};
use serde_json::Value;

use super::measure::{Job, alternate, announce};
use super::show;
use xtask::run::step;
use xtask::target;

const PLATFORMS: [&str; 3] = ["cores 4; policy edf;", "cores 3; policy edf;", "cores free;"];

/// Verifies it with and without the middle tier.
pub(crate) fn flight(dotgen: &Path, runs: usize) -> Result<()> {
    announce()?;
    step("Flight stack, 7 tasks of 4 components, durations from 0 to the WCET");
    println!("| platform | as it is | without schedule abstraction |\n| --- | --- | --- |");
    for (number, platform) in PLATFORMS.into_iter().enumerate() {
        let folder = target().join(format!("flight/{number}"));
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join("flight.gen"), include_str!("flight/flight.gen"))?;
        let scenario = include_str!("flight/flight.scn");
        let scenario = scenario.replace("cores 4; policy edf;", platform);
        std::fs::write(folder.join("flight.scn"), scenario)?;
        let job = |without: &[&str]| {
            let fixed = ["verify", "--format", "json", "--max-states", "6000000"];
            let arguments = fixed.iter().chain(without).chain(&["flight.scn"]);
            Job {
                program: dotgen.to_str().unwrap_or("dotgen"),
                arguments: arguments.map(ToString::to_string).collect(),
                directory: &folder,
            }
        };
        let jobs = [job(&[]), job(&["--without", "schedule-abstraction"])];
        let mut cells = Vec::new();
        for taken in alternate(&jobs, runs)? {
            let Some(taken) = taken else {
                cells.push("gave up".to_owned());
                continue;
            };
            let report: Value =
                serde_json::from_str(&taken.output).context("dotgen wrote no JSON")?;
            let checks = report["checks"].as_array().context("no checks")?;
            let proved = checks.iter().filter(|check| check["verdict"] == "proved").count();
            let states = report["states"].as_u64().context("no states")?;
            let shown = show(taken.seconds, taken.megabytes, states);
            cells.push(format!("{shown}; {proved} of {} proved", checks.len()));
        }
        println!("| {platform} | {} |", cells.join(" | "));
    }
    Ok(())
}
