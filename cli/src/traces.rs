//! `dotgen trace`: runs that other tools have found.

mod import;

use clap::{Args, Subcommand};

use super::CommandExit;

/// Import counterexamples of other tools for exported models
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Import(import::Arguments),
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    match &arguments.command {
        Command::Import(arguments) => import::run(arguments),
    }
}
