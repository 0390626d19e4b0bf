//! Measurements that take long, and that only those who work on speed need.
//!
//! | module | what |
//! | --- | --- |
//! | `bench` | time and memory of whole processes, and instruction counts |
//! | `budgets` | instructions and memory of commands, against `budgets.txt` |
//! | `campaign` | findings and edits on real components and random mutations |
//! | `chart` | charts of the measurements |

mod bench;
mod budgets;
mod campaign;
mod chart;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Measurements of dotgen.
#[derive(Parser)]
#[command(bin_name = "cargo xtask", disable_help_subcommand = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Measure whole processes, and count instructions; draw charts of growth.
    Bench(bench::Options),
    /// Count the instructions of commands, and compare them with bench/budgets.txt.
    Budgets(budgets::Options),
    /// Measure if findings are right and edits leave nothing worse.
    Campaign(campaign::Options),
}

fn main() -> ExitCode {
    xtask::exit(match Cli::parse().command {
        Command::Bench(options) => bench::bench(&options),
        Command::Budgets(options) => budgets::budgets(&options),
        Command::Campaign(options) => campaign::campaign(&options),
    })
}
