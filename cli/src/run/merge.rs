//! `dotgen run merge`

use anyhow::Context as _;
use camino::{Utf8Path, Utf8PathBuf};
use clap::Args;
use dotgen_runtime::report::{FORMAT, RunReport};

use super::{Answer, outcome, print};
use crate::report::TextOrJson;
use crate::{CommandExit, session};

/// Upper limit on the size of a report, in MB.
const MAX_REPORT: usize = 64;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Reports of `dotgen run --runs N --shard K/M --format json` about one scenario
    #[arg(value_name = "FILE", required = true)]
    files: Vec<Utf8PathBuf>,

    /// Output format
    #[arg(long, value_enum, default_value_t = TextOrJson::Text)]
    format: TextOrJson,
}

/// Merges the reports of parts of the runs.
pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let answers: anyhow::Result<Vec<Answer>> =
        arguments.files.iter().map(|path| read(path)).collect();
    let answers = answers?;
    let same = |other: &Answer| {
        let of = |answer: &Answer| {
            (answer.clock, answer.platform.clone(), answer.executed_codels, answer.simulated_codels)
        };
        of(other) == of(&answers[0])
    };
    if !answers.iter().all(same) {
        anyhow::bail!("the reports are about different clocks, platforms or executed codels");
    }
    let mut answers = answers.into_iter();
    let mut first = answers.next().context("no report to merge")?;
    let others = answers.map(|answer| answer.report);
    let parts = std::iter::once(first.report).chain(others).collect();
    first.report = RunReport::merge(parts).map_err(anyhow::Error::msg)?;
    print(std::slice::from_ref(&first), arguments.format)?;
    Ok(outcome(&[first]))
}

fn read(path: &Utf8Path) -> anyhow::Result<Answer> {
    let text = session::text(path, MAX_REPORT)?;
    let answer: Answer = serde_json::from_str(&text).map_err(|error| {
        anyhow::anyhow!(
            "{path} is not a report of one scenario from `dotgen run --format json`: {error}"
        )
    })?;
    if answer.report.format != FORMAT {
        anyhow::bail!("{path}: version {} of reports is not known", answer.report.format);
    }
    Ok(answer)
}
