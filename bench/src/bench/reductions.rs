//! The effect of each reduction of the exploration: every system with all reductions, and without each of
//! those it uses.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::Value;

use super::measure::{Job, Measurement, alternate, announce};
use super::{competitors, periodic, show};
use xtask::run::step;
use xtask::shared::optional;
use xtask::{root, target};

/// Maximum number of states.
const MAX_STATES: &str = "3000000";

/// A system and its options.
struct Subject {
    name: &'static str,
    scenario: PathBuf,
    options: Vec<&'static str>,
}

/// Prints a table.
pub(crate) fn reductions(dotgen: &Path, runs: usize) -> Result<()> {
    announce()?;
    for subject in subjects()? {
        step(subject.name);
        if !subject.scenario.is_file() {
            continue;
        }
        println!("| {} | time, memory, states |\n| --- | --- |", subject.name);
        let all = measure(dotgen, &subject, None, runs)?;
        println!("| with all that apply | {all} |");
        for name in used(dotgen, &subject)? {
            let cell = measure(dotgen, &subject, Some(&name), runs)?;
            println!("| without {name} | {cell} |");
        }
    }
    Ok(())
}

fn subjects() -> Result<Vec<Subject>> {
    let published = |name, path: &str, options: &[&'static str]| Subject {
        name,
        scenario: optional(&format!("corpus/{path}")).unwrap_or_default(),
        options: options.to_vec(),
    };
    let written = |name, folder: &str, files: [(&str, String); 2]| -> Result<Subject> {
        let directory = target().join("reductions").join(folder);
        std::fs::create_dir_all(&directory)?;
        for (file, text) in &files {
            std::fs::write(directory.join(file), text)?;
        }
        Ok(Subject { name, scenario: directory.join("scenario.scn"), options: Vec::new() })
    };
    let periodic = |n| {
        let (genom, scenario) = periodic::dotgen(&competitors::spread(n), true);
        [("periodic.gen", genom), ("scenario.scn", scenario)]
    };
    Ok(vec![
        published(
            "RobNav, 4 cores, intervals",
            "robnav/robnav.scn",
            &["--cores", "4", "--durations", "interval"],
        ),
        published(
            "RobNav, 2 cores, fixed",
            "robnav/robnav.scn",
            &["--cores", "2", "--durations", "fixed"],
        ),
        published(
            "Quadcopter hovering, 4 cores, fixed",
            "quadcopter/hover.scn",
            &["--cores", "4", "--durations", "fixed"],
        ),
        published(
            "Quadcopter hovering, 5 cores, intervals",
            "quadcopter/hover.scn",
            &["--cores", "5", "--durations", "interval"],
        ),
        written("6 periodic tasks", "periodic", periodic(6))?,
    ])
}

fn arguments(subject: &Subject, more: &[&str]) -> Vec<String> {
    let scenario = subject.scenario.to_string_lossy();
    let all = [&["verify", "--max-states", MAX_STATES], &subject.options[..], more, &[&scenario]];
    all.concat().into_iter().map(str::to_owned).collect()
}

/// The reductions that some exploration of a system uses.
fn used(dotgen: &Path, subject: &Subject) -> Result<Vec<String>> {
    let output = Command::new(dotgen).args(arguments(subject, &["--explain"])).output()?;
    let text = String::from_utf8(output.stdout)?;
    let lines = text.lines().skip_while(|line| *line != "reductions").skip(1);
    let rows = lines.filter_map(|line| line.trim_start().split_once(' '));
    let used = rows.filter(|(_, what)| what.trim_start().starts_with("used"));
    Ok(used.map(|(name, _)| name.to_owned()).collect())
}

fn measure(dotgen: &Path, subject: &Subject, without: Option<&str>, runs: usize) -> Result<String> {
    let mut more = vec!["--format", "json"];
    more.extend(without.iter().flat_map(|&text| ["--without", text]));
    let job = Job {
        program: dotgen.to_str().unwrap_or("dotgen"),
        arguments: arguments(subject, &more),
        directory: root(),
    };
    match alternate(&[job], runs)?.pop().flatten() {
        Some(taken) => cell(&taken),
        None => Ok("given up".to_owned()),
    }
}

/// Time, memory, states, and the number of checks that gave up.
fn cell(taken: &Measurement) -> Result<String> {
    let report: Value = serde_json::from_str(&taken.output).context("dotgen wrote no JSON")?;
    let checks = report["checks"].as_array().context("no checks")?;
    let unknown = checks.iter().filter(|check| check["verdict"] == "unknown");
    let states = report["states"].as_u64().context("no states")?;
    let shown = show(taken.seconds, taken.megabytes, states);
    Ok(match unknown.count() {
        0 => shown,
        n => format!("{shown}; {n} of {} given up", checks.len()),
    })
}
