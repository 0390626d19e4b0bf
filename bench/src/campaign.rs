//! Measures if dotgen's findings and edits are right: on examples, published components and random mutations
//! of them. See `docs/quality.md`.
//!
//! The programs are black boxes: the server is driven over its protocol, the commands are executed, and
//! compilers judge codels.

mod actions;
mod codels;
mod compare;
mod edits;
mod mutate;
mod report;
pub(crate) mod sets;
mod workspace;

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, ValueEnum};

use report::Report;
use xtask::extension::{self, Profile};

/// Options of `cargo xtask campaign`.
#[derive(Args)]
pub(crate) struct Options {
    /// What to measure.
    #[arg(value_enum)]
    what: What,
    /// Seed of the random choices.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Mutations of each specification (and, with `codels`, of each folder of sources).
    #[arg(long, default_value_t = 5)]
    mutations: usize,
    /// Random places of each document at which code actions are requested.
    #[arg(long, default_value_t = 3)]
    places: usize,
    /// Measure only workspaces with one of these texts in their names.
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Measure the examples only.
    #[arg(long)]
    examples: bool,
    /// Program to measure [default: a development build].
    #[arg(long)]
    dotgen: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// Edits of code actions and of `dotgen check --fix`: findings before and after.
    Actions,
    /// Findings about codels and edits of `dotgen codels sync`, next to a compiler.
    Codels,
}

/// Measures and prints a table. Returns false if an edit makes something worse or a finding is contradicted.
pub(crate) fn campaign(options: &Options) -> Result<bool> {
    let dotgen = match &options.dotgen {
        Some(dotgen) => std::path::absolute(dotgen)?,
        None => extension::build_server(Profile::Dev)?,
    };
    let report = measure(options, &dotgen)?;
    report.print();
    Ok(report.is_clean())
}

fn measure(options: &Options, dotgen: &std::path::Path) -> Result<Report> {
    let mut report = Report::default();
    for set in sets::sets(options.examples, &options.only)? {
        let started = std::time::Instant::now();
        report.set.clone_from(&set.name);
        let result = match options.what {
            What::Actions => actions::actions(options, dotgen, &set, &mut report),
            What::Codels => codels::codels(options, dotgen, &set, &mut report),
        };
        if let Err(error) = result {
            report.count("all", "failed", 1);
            report.report_offender("failed", &format!("{error:#}"));
        }
        let seconds = started.elapsed().as_secs_f32();
        eprintln!("    {}: {seconds:.1} s", set.name);
    }
    Ok(report)
}
