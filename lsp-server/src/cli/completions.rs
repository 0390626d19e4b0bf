//! `dotgen completions`

use std::io::Write;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{Cli, Outcome};

/// Print a script that completes commands and options in a shell
///
/// For bash, put it where completions are loaded from: `dotgen completions bash >
/// ~/.local/share/bash-completion/completions/dotgen`. For zsh, into a file `_dotgen` in a directory of
/// `$fpath`; for fish, into `~/.config/fish/completions/dotgen.fish`.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The shell
    shell: Shell,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "dotgen", &mut script);
    std::io::stdout().write_all(&script)?;
    Ok(Outcome::Fine)
}
