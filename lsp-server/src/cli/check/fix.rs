//! `dotgen check --fix` and `--diff`: what has one plain repair gets it.

use std::collections::BTreeMap;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::{FileEdit, Fix};
use dotgen_analysis::host::Change;

use super::{FileReports, Outcome, Session, Trouble, check};
use crate::cli::{fmt, report, session};
use crate::views::fixes::together;

/// Repairs may show what else is wrong; texts in which more than so many lie one below the other are left.
const MOST_ROUNDS: usize = 20;

/// Texts as they were and as they are now, by file.
pub(super) type Changed = BTreeMap<Utf8PathBuf, (String, String)>;

/// Repairs the texts that a session reads, in memory.
pub(super) fn mend(session: &mut Session, changed: &mut Changed) -> anyhow::Result<()> {
    for _ in 0..MOST_ROUNDS {
        let mut report = FileReports::default();
        // What cannot be read is told once, with the report.
        check(session, &mut report, &mut Trouble::silent());
        let first = report.diagnostics.iter().filter_map(|it| it.fixes.first());
        let plain = first.filter(|it| it.plain && is_ours(session, it));
        let mut edits = together(plain);
        if edits.is_empty() {
            return Ok(());
        }
        edits.sort_by(|a, b| (&a.path, b.range.start).cmp(&(&b.path, a.range.start)));
        let mut files = Vec::new();
        for edits in edits.chunk_by(|a, b| a.path == b.path) {
            let path = &edits[0].path;
            let old = session.ask(path, |it| it.text(path))?.unwrap_or_default();
            let new = edited(&old, edits);
            let entry = changed.entry(path.clone());
            entry.or_insert_with(|| (old.to_string(), String::new())).1 = new.clone();
            files.push((path.clone(), Some(new)));
        }
        session.host_mut().apply(Change {
            files,
            ..Change::default()
        });
    }
    Ok(())
}

/// Shows what would change.
pub(super) fn print(changed: &Changed) -> anyhow::Result<Outcome> {
    for (path, (old, new)) in changed {
        fmt::print_diff(&session::display(path), old, new)?;
    }
    Ok(match changed.is_empty() {
        true => Outcome::Fine,
        false => Outcome::Errors,
    })
}

/// Gives the files their new texts: all of them, or none.
pub(super) fn write(changed: &Changed) -> anyhow::Result<()> {
    let files = changed.iter();
    let files: Vec<_> = files
        .map(|(path, (_, new))| report::new_content(path, new))
        .collect();
    report::write_files(&files)?;
    if !changed.is_empty() {
        let files = if changed.len() == 1 { "file" } else { "files" };
        report::note(&format!("mended {} {files}", changed.len()));
    }
    Ok(())
}

/// Whether a fix changes only what was given, and what lies beside or below it.
fn is_ours(session: &Session, fix: &Fix) -> bool {
    let beside = |path: &Utf8Path| {
        let mut folders = session.files.iter().filter_map(|it| it.path.parent());
        folders.any(|it| path.starts_with(it))
    };
    fix.edits.iter().all(|it| beside(&it.path))
}

/// A text after edits, which are in order from its end.
fn edited(text: &str, edits: &[FileEdit]) -> String {
    let mut out = text.to_owned();
    for it in edits {
        out.replace_range(it.range.clone(), &it.new_text);
    }
    out
}
