//! `dotgen completions`

use std::io::Write;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{Cli, CommandExit};

/// Print a shell completion script
///
/// For bash: `dotgen completions bash > ~/.local/share/bash-completion/completions/dotgen`. For zsh, write it
/// to a file `_dotgen` in a directory of `$fpath`. For fish, write it to
/// `~/.config/fish/completions/dotgen.fish`.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The shell
    shell: Shell,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "dotgen", &mut script);
    std::io::stdout().write_all(&script)?;
    Ok(CommandExit::Fine)
}
