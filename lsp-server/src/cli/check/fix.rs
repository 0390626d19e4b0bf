//! `dotgen check --fix` and `--diff`: what has one plain repair gets it.

use std::collections::BTreeMap;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::{FileEdit, Fix};
use dotgen_analysis::host::Change;

use super::{Report, Session, Trouble, check};
use crate::fixes::together;

/// Repairs may show what else is wrong; texts in which more than so many lie one below the other are left.
const MOST_ROUNDS: usize = 20;

/// Texts as they were and as they are now, by file.
pub(super) type Changed = BTreeMap<Utf8PathBuf, (String, String)>;

/// Repairs the texts that a session reads, in memory.
pub(super) fn mend(session: &mut Session, changed: &mut Changed) -> anyhow::Result<()> {
    for _ in 0..MOST_ROUNDS {
        let mut report = Report::default();
        // Trouble is told by the check that follows.
        check(session, &mut report, &mut Trouble::default());
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
        session.host().apply(Change {
            files,
            ..Change::default()
        });
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
