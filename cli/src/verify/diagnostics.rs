//! The diagnostics of the verifier about a scenario and its specifications.

use camino::Utf8PathBuf;
use dotgen_analysis::diagnostic::Diagnostic;

use crate::report;
use crate::session::{Session, Texts};
use dotgen_lsp_server::config::Level;
use dotgen_lsp_server::protocol::convert::{Encoding, Lines};
use dotgen_views::verification::Problem;

/// Maximum number of related places that are shown.
const PLACES: usize = 4;

/// Diagnostics, with the texts to which they refer.
pub(crate) struct ScenarioDiagnostics {
    found: Vec<Diagnostic>,
    texts: Texts,
}

impl ScenarioDiagnostics {
    /// Returns the reasons why a problem cannot be verified.
    pub(crate) fn about(
        session: &Session,
        problem: &Problem,
        found: Vec<Diagnostic>,
    ) -> anyhow::Result<ScenarioDiagnostics> {
        let mut texts = Texts::default();
        if problem.is_written() {
            let lines = Lines::new(problem.text.as_str().into(), Encoding::Utf16);
            texts.insert(problem.path.clone(), lines);
        }
        session.add_texts(&found, &mut texts)?;
        Ok(ScenarioDiagnostics { found, texts })
    }

    /// Returns the diagnostics of the verifier, also about the checks of the command line, whose places
    /// follow the text of the scenario.
    pub(crate) fn by_verifier(
        session: &Session,
        problem: &Problem,
        all: &[dotgen_timing::diagnostic::Diagnostic],
        checks: &[&str],
    ) -> anyhow::Result<ScenarioDiagnostics> {
        let option = Utf8PathBuf::from("--check");
        let found = all.iter().filter_map(|diagnostic| {
            let mut out = Level::apply(&session.severity, problem.diagnostic(diagnostic))?;
            let after = diagnostic.range.start.checked_sub(problem.text.len());
            if let Some(start) = after.filter(|_| !checks.is_empty()) {
                out.path = option.clone();
                out.range = start..start + diagnostic.range.len();
            }
            Some(out)
        });
        let (of_checks, of_files) =
            found.partition::<Vec<_>, _>(|diagnostic| diagnostic.path == option);
        let warnings = problem.warnings.iter().cloned();
        let of_files = warnings
            .filter_map(|warning| Level::apply(&session.severity, warning))
            .chain(of_files)
            .collect();
        let mut out = ScenarioDiagnostics::about(session, problem, of_files)?;
        out.found.extend(of_checks);
        let lines = Lines::new(checks.join("\n").into(), Encoding::Utf16);
        out.texts.insert(option, lines);
        Ok(out)
    }

    /// Prints the diagnostics on standard error.
    pub(crate) fn print(mut self) -> anyhow::Result<()> {
        for diagnostic in &mut self.found {
            if diagnostic.related.len() > PLACES {
                diagnostic.related.clear();
            }
        }
        report::text::print_to_stderr(&self.found, &self.texts)
    }

    /// Returns the diagnostics in the form of `dotgen check --format json`.
    pub(crate) fn to_json(&self) -> anyhow::Result<serde_json::Value> {
        let entries = report::json::entries(&self.found, &self.texts);
        Ok(serde_json::to_value(entries)?)
    }
}
