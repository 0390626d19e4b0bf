//! The cost of a whole process: processor time, which other processes disturb least, and peak memory.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use anyhow::{Context, Result};

use xtask::{run, target, tools};

/// Limit on the processor time of a run, in seconds.
pub(crate) const LIMIT: u32 = 60;

/// Checks that measuring is possible, and prints the method.
pub(crate) fn announce() -> Result<()> {
    tools::ensure(tools::TIME)?;
    run::step(&format!(
        "Whole processes: processor time, median of alternating runs; peak memory; states. Given up after \
            {LIMIT} s"
    ));
    Ok(())
}

/// A command to measure, and the folder it runs in.
pub(crate) struct Job<'a> {
    pub(crate) program: &'a str,
    pub(crate) arguments: Vec<String>,
    pub(crate) directory: &'a Path,
}

/// The medians of the runs.
pub(crate) struct Measurement {
    pub(crate) seconds: f64,
    /// Wall-clock time from start to end.
    pub(crate) elapsed: f64,
    /// Peak resident memory.
    pub(crate) megabytes: f64,
    /// Standard output of the last run.
    pub(crate) output: String,
}

/// Measures some jobs in alternation, so that disturbances affect all of them equally. `None`: the job
/// exceeded [`LIMIT`]. Jobs of more than two seconds run at most three times, those of more than twenty
/// seconds once.
pub(crate) fn alternate(jobs: &[Job], runs: usize) -> Result<Vec<Option<Measurement>>> {
    let mut all: Vec<Option<Vec<Measurement>>> = jobs.iter().map(|_| Some(Vec::new())).collect();
    for run in 0..runs {
        for (job, taken) in std::iter::zip(jobs, &mut all) {
            let Some(list) = taken else { continue };
            let first = list.first().map_or(0.0, |measurement| measurement.seconds);
            if run >= 3 && first > 2.0 || run >= 1 && first > 20.0 {
                continue;
            }
            match once(job)? {
                Some(measurement) => list.push(measurement),
                None => *taken = None,
            }
        }
    }
    Ok(all.into_iter().map(|job| job.map(medians)).collect())
}

fn medians(mut runs: Vec<Measurement>) -> Measurement {
    let mut megabytes: Vec<f64> = runs.iter().map(|run| run.megabytes).collect();
    megabytes.sort_unstable_by(f64::total_cmp);
    let megabytes = megabytes[runs.len() / 2];
    runs.sort_unstable_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let middle = runs.len() / 2;
    Measurement { megabytes, ..runs.swap_remove(middle) }
}

/// Separates the shell's report of times from the program's error output. The shell is killed last.
const SCRIPT: &str = "ulimit -S -t $0; TIMEFORMAT='%3U %3S'; time \"$@\" 2>/dev/null";
/// Status of a process that has used up its time: 128, and the number of SIGXCPU.
const CPU_TIME_STATUS: i32 = 128 + 24;

/// One run. `None`: it exceeded [`LIMIT`].
fn once(job: &Job) -> Result<Option<Measurement>> {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let report = target().join(format!("measured-{}-{number}", std::process::id()));
    let report = report.to_string_lossy();
    let limit = LIMIT.to_string();
    let mut arguments = vec!["-c", SCRIPT, &limit];
    arguments.extend(["/usr/bin/time", "-f", "%M", "-o", &*report, job.program]);
    arguments.extend(job.arguments.iter().map(String::as_str));
    let started = Instant::now();
    let output = run::command(job.directory, "bash", &arguments).output()?;
    let elapsed = started.elapsed().as_secs_f64();
    if output.status.code() == Some(CPU_TIME_STATUS) {
        return Ok(None);
    }
    let text = std::fs::read_to_string(&*report).context("`time` wrote nothing")?;
    std::fs::remove_file(&*report)?;
    let kilobytes: f64 = (text.lines().last().unwrap_or_default().trim().parse())
        .with_context(|| format!("{}: `time` wrote {text}", job.program))?;
    let times = String::from_utf8_lossy(&output.stderr);
    let times = times.split_whitespace().map(str::parse::<f64>);
    Ok(Some(Measurement {
        seconds: times.sum::<Result<f64, _>>().context("bash told no time")?,
        elapsed,
        megabytes: kilobytes / 1024.0,
        output: String::from_utf8_lossy(&output.stdout).into_owned(),
    }))
}
