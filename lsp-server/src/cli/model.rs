//! `dotgen model`

use std::io::Write;

use camino::Utf8PathBuf;
use clap::Args;

use super::{Outcome, Reading, report, session};

/// Print the component model of a specification as JSON
///
/// The model of what could be understood is printed even if there are errors; they go to standard
/// error, and the exit status is 1.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The specification, or - for standard input
    #[arg(value_name = "FILE")]
    file: Utf8PathBuf,

    #[command(flatten)]
    reading: Reading,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let session = session::single(&arguments.file, &arguments.reading)?;
    let mut outcome = Outcome::Fine;
    for file in &session.files {
        let unit = session.ask(&file.path, |it| it.root_unit(&file.path))?;
        let model = crate::views::model::document(&unit);
        let mut json = serde_json::to_string_pretty(&model)?;
        json.push('\n');
        std::io::stdout().write_all(dotgen_syntax::encoding::shown(&json).as_bytes())?;
        if !unit.accepted() {
            let mut texts = session::Texts::default();
            session.add_texts(&unit.diagnostics, &mut texts)?;
            report::text::print_errors(&unit.diagnostics, &texts)?;
            outcome = Outcome::Errors;
        }
    }
    Ok(outcome)
}
