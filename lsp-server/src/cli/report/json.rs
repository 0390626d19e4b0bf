//! `--format json`: one document, positions as in the LSP.

use std::io::Write;

use camino::Utf8Path;
use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use serde::Serialize;

use super::Report;
use crate::cli::session::{self, Texts};
use crate::proto::Range;

#[derive(Serialize)]
struct Document<E> {
    diagnostics: Vec<E>,
}

#[derive(Serialize)]
struct Entry {
    file: String,
    severity: Severity,
    code: &'static str,
    message: String,
    range: Range,
    related: Vec<Related>,
}

#[derive(Serialize)]
struct Related {
    file: String,
    range: Range,
    message: String,
}

/// Diagnostics as programs read them.
pub(in crate::cli) fn entries(diagnostics: &[Diagnostic], texts: &Texts) -> Vec<impl Serialize> {
    let entries = diagnostics.iter().map(|it| Entry {
        file: session::display(&it.path),
        severity: it.severity,
        code: it.code,
        message: it.message.clone(),
        range: range(texts, &it.path, &it.range),
        related: it
            .related
            .iter()
            .map(|it| Related {
                file: session::display(&it.path),
                range: range(texts, &it.path, &it.range),
                message: it.message.clone(),
            })
            .collect(),
    });
    entries.collect()
}

pub(in crate::cli) fn print(report: &Report) -> anyhow::Result<()> {
    let document = Document {
        diagnostics: entries(&report.diagnostics, &report.texts),
    };
    let mut json = serde_json::to_string_pretty(&document)?;
    json.push('\n');
    Ok(std::io::stdout().write_all(dotgen_syntax::encoding::shown(&json).as_bytes())?)
}

/// Lines from 0, characters in UTF-16 units.
pub(super) fn range(texts: &Texts, path: &Utf8Path, range: &std::ops::Range<usize>) -> Range {
    texts
        .get(path)
        .map(|it| it.range(range))
        .unwrap_or_default()
}
