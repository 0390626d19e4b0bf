//! Comparison with TChecker and the schedule-abstraction tool, on systems that they can express.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde_json::Value;

use super::measure::{Job, Measurement, alternate, announce};
use super::periodic::{self, PERIODS, Task};
use super::{SECONDS, show};
use crate::chart::{Chart, Line};
use xtask::run::step;
use xtask::{root, target, tools};

/// The programs; `None`: not available.
pub(crate) struct Competitors {
    dotgen: String,
    tchecker: Option<String>,
    jobs: Option<String>,
}

impl Competitors {
    /// Finds them: by environment variable, or on `PATH`.
    pub(crate) fn find(dotgen: &Path) -> Competitors {
        Competitors {
            dotgen: dotgen.to_string_lossy().into_owned(),
            tchecker: program("TCHECKER", "tck-reach", "ticktac-project/tchecker"),
            jobs: program("SAG", "nptest", "SAG-org/schedule_abstraction-main"),
        }
    }
}

fn program(variable: &str, name: &str, repository: &str) -> Option<String> {
    let path = match std::env::var_os(variable) {
        Some(path) => Some(PathBuf::from(path)).filter(|path| path.is_file()),
        None => tools::find(name),
    };
    if path.is_none() {
        eprintln!(
            "SKIPPED: `{name}` is not there. Build it from {repository} and give its path in {variable}"
        );
    }
    path.map(|path| path.to_string_lossy().into_owned())
}

const NAMES: [&str; 3] = ["dotgen", "TChecker", "schedule abstraction"];
const DOTGEN: [&str; 4] = ["verify", "--format", "json", "scenario.scn"];
/// Options for sets of tasks: with late jobs there can be very many states, and the first failure is
/// sufficient.
const STATE_LIMIT: [&str; 2] = ["--max-states", "1000000"];

/// One question for all programs, as files in a folder.
struct Question {
    directory: PathBuf,
    label: &'static str,
    jobs: bool,
}

impl Question {
    fn write(name: &str, files: &[(&str, &str)], label: &'static str) -> Result<Question> {
        let directory = target().join("competitors").join(name);
        std::fs::create_dir_all(&directory)?;
        for (file, text) in files {
            std::fs::write(directory.join(file), text)?;
        }
        let jobs = files.iter().any(|file| file.0 == "jobs.csv");
        Ok(Question { directory, label, jobs })
    }

    /// Medians of dotgen, TChecker and the schedule-abstraction tool.
    fn ask(&self, competitors: &Competitors, runs: usize) -> Result<[Option<Answer>; 3]> {
        let dotgen = Some(&competitors.dotgen);
        let jobs = competitors.jobs.as_ref().filter(|_| self.jobs);
        let limited = if self.jobs { &STATE_LIMIT[..] } else { &[] };
        let commands = [
            (dotgen, [&DOTGEN, limited].concat()),
            (competitors.tchecker.as_ref(), vec!["-a", "covreach", "-l", self.label, "model.tck"]),
            (jobs, vec!["-r", "jobs.csv"]),
        ];
        let present = commands.iter().filter_map(|(program, arguments)| {
            Some(Job {
                program: program.as_ref()?,
                arguments: arguments.iter().map(ToString::to_string).collect(),
                directory: &self.directory,
            })
        });
        let mut taken = alternate(&present.collect::<Vec<_>>(), runs)?.into_iter();
        let mut next = |present: bool| present.then(|| taken.next().flatten()).flatten();
        let (dotgen, tchecker, jobs) =
            (next(true), next(commands[1].0.is_some()), next(jobs.is_some()));
        Ok([
            dotgen.map(of_dotgen).transpose()?.flatten(),
            tchecker.map(of_tchecker).transpose()?,
            jobs.map(|job| self.of_jobs(job)).transpose()?,
        ])
    }

    /// Dotgen alone, once.
    fn dotgen(&self, competitors: &Competitors) -> Result<Answer> {
        let job = Job {
            program: &competitors.dotgen,
            arguments: DOTGEN.map(str::to_owned).to_vec(),
            directory: &self.directory,
        };
        let taken = alternate(&[job], 1)?.pop().flatten();
        let answer = taken.map(of_dotgen).transpose()?.flatten();
        answer.context("dotgen gave up")
    }

    fn of_jobs(&self, taken: Measurement) -> Result<Answer> {
        let column = |i| taken.output.split(',').nth(i).map(str::trim);
        let (Some(holds), Some(states)) = (column(1), column(4)) else {
            bail!("the schedule-abstraction tool said: {}", taken.output);
        };
        let mut responses = Vec::new();
        let bounds = std::fs::read_to_string(self.directory.join("jobs.rta.csv"))?;
        for line in bounds.lines().skip(1) {
            let mut fields = line.split(',').map(|part| part.trim().parse::<u64>());
            let (Some(Ok(task)), Some(Ok(worst))) = (fields.next(), fields.nth(4)) else {
                bail!("the schedule-abstraction tool wrote: {line}");
            };
            let task = task as usize - 1;
            responses.resize(responses.len().max(task + 1), 0);
            responses[task] = worst.div_euclid(periodic::SCALE).max(responses[task]);
        }
        Ok(Answer { holds: holds == "1", states: states.parse()?, responses, taken })
    }
}

/// The answer of a program, and its cost.
struct Answer {
    holds: bool,
    states: u64,
    /// Longest response of every task, if the program returns it.
    responses: Vec<u64>,
    taken: Measurement,
}

/// The answer of dotgen; `None` if it gave up.
fn of_dotgen(taken: Measurement) -> Result<Option<Answer>> {
    let report: Value = serde_json::from_str(&taken.output).context("dotgen wrote no JSON")?;
    let checks = report["checks"].as_array().context("no checks")?;
    let some = |verdict| checks.iter().any(|check| check["verdict"] == verdict);
    let holds = !some("refuted");
    // The others stop at the first failure, so dotgen's other answers do not matter.
    if holds && some("unknown") {
        return Ok(None);
    }
    let responses = checks.iter().filter_map(|check| check["value"].as_u64()).collect();
    let states = report["states"].as_u64().context("no states")?;
    Ok(Some(Answer { holds, states, responses, taken }))
}

fn of_tchecker(taken: Measurement) -> Result<Answer> {
    let value = |key: &str| {
        let mut lines = taken.output.lines();
        lines.find_map(|line| line.strip_prefix(key).map(|rest| rest.trim().to_owned()))
    };
    let (Some(reachable), Some(states)) = (value("REACHABLE"), value("VISITED_STATES")) else {
        bail!("TChecker said: {}", taken.output);
    };
    Ok(Answer {
        holds: reachable == "false",
        states: states.parse()?,
        responses: Vec::new(),
        taken,
    })
}

/// Runs all comparisons. Returns true if all programs agreed.
pub(crate) fn competitors(dotgen: &Path, runs: usize, sets: u64) -> Result<bool> {
    announce()?;
    let competitors = Competitors::find(dotgen);
    if competitors.tchecker.is_none() && competitors.jobs.is_none() {
        step("Nothing to compare with: nothing measured");
        return Ok(true);
    }
    step(&format!("{sets} random sets of periodic tasks"));
    let mut agreed = agreement(&competitors, sets)?;
    step("Periodic tasks on one core, non-preemptive, earliest deadline first");
    let mut lines = NAMES.map(|name| Line { name, points: Vec::new() });
    agreed &= table(
        &competitors,
        runs,
        "tasks",
        2..=10,
        |n| periodic_question(&format!("periodic{n}"), &spread(n), false),
        &mut lines,
    )?;
    if lines.iter().all(|line| !line.points.is_empty()) {
        let chart = Chart {
            title: "Are all deadlines kept? Time until the answer",
            across: "periodic tasks on one core",
            powers: SECONDS,
            ratios: false,
            lines: lines.into(),
        };
        std::fs::write(root().join("docs/charts/competitors.svg"), chart.svg())?;
        step("Drew docs/charts/competitors.svg");
    }
    Ok(agreed)
}

fn periodic_question(name: &str, tasks: &[Task], responses: bool) -> Result<Question> {
    let (genom, scenario) = periodic::dotgen(tasks, responses);
    let files = [
        ("periodic.gen", &*genom),
        ("scenario.scn", &*scenario),
        ("model.tck", &*periodic::tchecker(tasks)),
        ("jobs.csv", &*periodic::jobs(tasks)),
    ];
    Question::write(name, &files, "miss")
}

/// Growing numbers of tasks that meet their deadlines, with about three quarters of the core used.
pub(super) fn spread(n: usize) -> Vec<Task> {
    let tasks = PERIODS[..n].iter().map(|&period| Task {
        period,
        bcet: 0,
        wcet: (period * 3 / (4 * n as u64)).clamp(1, 6),
    });
    tasks.collect()
}

/// Random sets: equal verdicts, and equal responses if all deadlines are met.
fn agreement(competitors: &Competitors, sets: u64) -> Result<bool> {
    let mut agreed = true;
    let mut kept = 0;
    for seed in 0..sets {
        let tasks = random(seed);
        let [dotgen, tchecker, jobs] =
            periodic_question("random", &tasks, false)?.ask(competitors, 1)?;
        let Some(mut dotgen) = dotgen else { bail!("set {seed}: dotgen gave up") };
        // With late jobs there may be no bound.
        if dotgen.holds {
            kept += 1;
            let question = periodic_question("random", &tasks, true)?;
            dotgen = question.dotgen(competitors)?;
        }
        for (name, other) in [("TChecker", tchecker), ("schedule abstraction", jobs)] {
            let Some(other) = other else { continue };
            let responses = dotgen.holds && !other.responses.is_empty();
            if other.holds != dotgen.holds || responses && other.responses != dotgen.responses {
                agreed = false;
                println!(
                    "set {seed}: dotgen {} {:?}, {name} {} {:?}",
                    dotgen.holds, dotgen.responses, other.holds, other.responses
                );
            }
        }
    }
    println!("{sets} sets, {kept} of them keep all deadlines; all agree: {agreed}");
    Ok(agreed)
}

/// Two to five tasks, determined by the seed.
fn random(seed: u64) -> Vec<Task> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut below = move |n: u64| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 20) % n
    };
    let mut periods = PERIODS.to_vec();
    let tasks = (0..2 + below(4)).map(|_| {
        let period = periods.swap_remove(below(periods.len() as u64) as usize);
        let wcet = 1 + below(period / 3);
        // No lower bound, or a random one.
        let bcet = below(2) * below(wcet + 1);
        Task { period, bcet, wcet }
    });
    tasks.collect()
}

/// A line per size, until dotgen and TChecker have both given up.
fn table(
    competitors: &Competitors,
    runs: usize,
    unit: &str,
    sizes: impl Iterator<Item = usize>,
    question: impl Fn(usize) -> Result<Question>,
    lines: &mut [Line],
) -> Result<bool> {
    println!("| {unit} | holds | {} |", NAMES.join(" | "));
    println!("| --- | --- | --- | --- | --- |");
    let mut agreed = true;
    for size in sizes {
        let question = question(size)?;
        let answers = question.ask(competitors, runs)?;
        for (line, answer) in std::iter::zip(&mut *lines, &answers) {
            let point = answer.as_ref().map(|answer| (size, answer.taken.seconds));
            line.points.extend(point);
        }
        let mut verdicts = answers.iter().flatten().map(|answer| answer.holds).collect::<Vec<_>>();
        verdicts.dedup();
        agreed &= verdicts.len() <= 1;
        let holds = match *verdicts {
            [] => "–",
            [true] => "yes",
            [false] => "no",
            _ => "DIFFERENT",
        };
        let present =
            [true, competitors.tchecker.is_some(), question.jobs && competitors.jobs.is_some()];
        let cells = std::iter::zip(&answers, present).map(|(answer, present)| match answer {
            Some(answer) => show(answer.taken.seconds, answer.taken.megabytes, answer.states),
            None if present => "gave up".to_owned(),
            None => "–".to_owned(),
        });
        let cells = cells.collect::<Vec<_>>().join(" | ");
        println!("| {size} | {holds} | {cells} |");
        if answers[..2].iter().all(Option::is_none) {
            break;
        }
    }
    Ok(agreed)
}
