//! `dotgen model`

use std::io::Write;

use camino::Utf8PathBuf;
use clap::Args;

use super::{CommandExit, SpecificationOptions, report, session};

/// Print the component model of a specification as JSON
///
/// If the specification has errors, the model of the rest is printed and the errors go to standard error.
///
/// Exit status: 0 without errors, 1 with errors, 2 if the file cannot be read.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The specification, a directory with one specification, or - for standard input
    #[arg(value_name = "FILE")]
    file: Utf8PathBuf,

    #[command(flatten)]
    reading: SpecificationOptions,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let session = session::single(&arguments.file, &arguments.reading)?;
    let mut outcome = CommandExit::Fine;
    for file in &session.files {
        let unit = session.ask(&file.path, |analysis| analysis.root_unit(&file.path))?;
        let model = dotgen_views::model::document(&unit);
        let mut json = serde_json::to_string_pretty(&model)?;
        json.push('\n');
        std::io::stdout().write_all(dotgen_syntax::encoding::shown(&json).as_bytes())?;
        if !unit.accepted() {
            let mut texts = session::Texts::default();
            session.add_texts(&unit.diagnostics, &mut texts)?;
            report::text::print_errors(&unit.diagnostics, &texts)?;
            outcome = CommandExit::Errors;
        }
    }
    Ok(outcome)
}
