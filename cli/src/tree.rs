//! `dotgen tree`

use std::io::Write;

use camino::Utf8PathBuf;
use clap::Args;

use super::{CommandExit, SpecificationOptions, session};

/// Print the syntax tree of a file
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The file, or - for standard input
    #[arg(value_name = "FILE")]
    file: Utf8PathBuf,

    #[command(flatten)]
    reading: SpecificationOptions,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let session = session::single(&arguments.file, &arguments.reading)?;
    for file in &session.files {
        let tree = session
            .ask(&file.path, |analysis| analysis.syntax_tree(&file.path))?
            .unwrap_or_default();
        std::io::stdout().write_all(dotgen_syntax::encoding::shown(&tree).as_bytes())?;
    }
    Ok(CommandExit::Fine)
}
