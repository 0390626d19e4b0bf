//! `dotgen check --fix` and `--diff` for scenarios.

use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use dotgen_codegen::codels::edit::{Edit, apply};

use super::fix::{Applied, AppliedFixes, ChangedTexts, MAX_ROUNDS, project};
use super::scenario_with;
use crate::session::{Session, SourceFile};

/// A scenario during its correction.
struct Corrected {
    text: String,
    found: Vec<Diagnostic>,
    /// Titles of the applied fixes.
    titles: Vec<String>,
}

/// Applies fixes to the scenarios of a session, in memory. A fix is applied if fewer errors of its kind are
/// left.
pub(super) fn apply_fixes(
    session: &mut Session,
    which: Applied,
    changed: &mut ChangedTexts,
    titles: &mut AppliedFixes,
) -> anyhow::Result<()> {
    let mut all = Vec::new();
    for file in session.files.iter().filter(|file| file.is_scenario()) {
        let text = session.ask(&file.path, |analysis| analysis.text(&file.path))?;
        let before = text.unwrap_or_default().to_string();
        let corrected = corrected(session, file, which, before.clone())?;
        if !corrected.titles.is_empty() {
            all.push((file.path.clone(), before, corrected));
        }
    }
    for (path, before, corrected) in all {
        let of_file = titles.entry(path.clone()).or_default();
        for title in corrected.titles {
            *of_file.entry(title).or_default() += 1;
        }
        let entry = changed.entry(path).or_insert((before, String::new()));
        entry.1 = corrected.text;
    }
    // The session has the changed texts from now on.
    project(session, changed);
    Ok(())
}

fn corrected(
    session: &Session,
    file: &SourceFile,
    which: Applied,
    text: String,
) -> anyhow::Result<Corrected> {
    let mut now =
        Corrected { found: scenario_with(session, file, &text)?, text, titles: Vec::new() };
    for _ in 0..MAX_ROUNDS {
        let Some(next) = next(session, file, which, &now)? else {
            break;
        };
        now = next;
    }
    Ok(now)
}

/// Returns the scenario with the first fix that leaves fewer errors of its kind.
fn next(
    session: &Session,
    file: &SourceFile,
    which: Applied,
    now: &Corrected,
) -> anyhow::Result<Option<Corrected>> {
    let findings = now.found.iter();
    let fixes = findings.filter_map(|finding| Some((finding.fixes.first()?, finding)));
    for (fix, finding) in fixes.filter(|(fix, finding)| which.includes(fix, finding.severity)) {
        let edit = Edit::of(&fix.edits);
        let Some(edits) = edit.changed.get(&file.path) else {
            continue;
        };
        let text = apply(&now.text, edits);
        let found = scenario_with(session, file, &text)?;
        if errors(&found, finding.code) < errors(&now.found, finding.code) {
            let titles = now.titles.iter().cloned().chain([fix.title.clone()]);
            return Ok(Some(Corrected { titles: titles.collect(), text, found }));
        }
    }
    Ok(None)
}

/// Returns the number of errors of a kind. Others may appear: names are looked up when the syntax is right.
fn errors(found: &[Diagnostic], code: &str) -> usize {
    let errors = found.iter().filter(|finding| finding.severity == Severity::Error);
    errors.filter(|finding| finding.code == code).count()
}
