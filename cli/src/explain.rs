//! `dotgen explain`

use std::io::{IsTerminal as _, Write as _};

use clap::Args;

use super::CommandExit;
use super::width::wrapped;
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

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let mut out = std::io::stdout().lock();
    let Some(code) = &arguments.code else {
        for code in manual::codes() {
            writeln!(out, "{code}")?;
        }
        return Ok(CommandExit::Fine);
    };
    let Some(text) = manual::text(code) else {
        let near = dotgen_syntax::suggestion::nearest(code, manual::codes());
        let near = near.map(|text| format!("; did you mean `{text}`?"));
        let near = near.unwrap_or_else(|| "; `dotgen explain` lists all codes".to_owned());
        anyhow::bail!("there is no diagnostic `{code}`{near}");
    };
    // Programs read the page as it is.
    if !out.is_terminal() {
        out.write_all(text.as_bytes())?;
        return Ok(CommandExit::Fine);
    }
    let mut is_code = false;
    for line in text.lines() {
        is_code ^= line.starts_with("```");
        if is_code {
            writeln!(out, "{line}")?;
        } else {
            writeln!(out, "{}", wrapped(line, 0, 0))?;
        }
    }
    Ok(CommandExit::Fine)
}
