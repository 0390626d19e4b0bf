//! `dotgen explain`

use std::io::Write;

use clap::Args;

use super::Outcome;
use dotgen_views::manual;

/// Print the manual page of a diagnostic
///
/// Without a code, all codes are listed.
///
/// Exit status: 0, or 2 if the code does not exist.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Code of a diagnostic, as shown in brackets, for example fsm/busy-loop
    #[arg(value_name = "CODE")]
    code: Option<String>,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let mut out = std::io::stdout().lock();
    let Some(code) = &arguments.code else {
        for code in manual::codes() {
            writeln!(out, "{code}")?;
        }
        return Ok(Outcome::Fine);
    };
    let Some(text) = manual::text(code) else {
        let near = dotgen_syntax::suggestion::nearest(code, manual::codes());
        let near = near.map(|text| format!("; did you mean `{text}`?"));
        let near = near.unwrap_or_else(|| "; `dotgen explain` lists all codes".to_owned());
        anyhow::bail!("there is no diagnostic `{code}`{near}");
    };
    out.write_all(text.as_bytes())?;
    Ok(Outcome::Fine)
}
