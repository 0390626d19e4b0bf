//! `dotgen man`

use camino::Utf8PathBuf;
use clap::Args;
use clap_mangen::Man;
use dotgen_codegen::disk::NewContent;

use super::{CommandExit, report};

/// Write pages for `man`: one for the program and one for each command
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Directory to write to
    #[arg(value_name = "DIR")]
    directory: Utf8PathBuf,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let mut command = crate::help::command();
    // This passes global options and names down to all subcommands.
    command.build();
    let mut pages = Vec::new();
    add(&command, "dotgen", arguments, &mut pages)?;
    report::write_files(pages, &[])?;
    Ok(CommandExit::Fine)
}

fn add(
    command: &clap::Command,
    name: &str,
    arguments: &Arguments,
    pages: &mut Vec<NewContent>,
) -> anyhow::Result<()> {
    let mut bytes = Vec::new();
    let own = command.clone().display_name(name.to_owned());
    Man::new(own).render(&mut bytes)?;
    pages.push(NewContent::new(arguments.directory.join(format!("{name}.1")), bytes));
    for subcommand in command.get_subcommands().filter(|subcommand| !subcommand.is_hide_set()) {
        if subcommand.get_name() != "help" {
            add(subcommand, &format!("{name}-{}", subcommand.get_name()), arguments, pages)?;
        }
    }
    Ok(())
}
