//! `--format sarif`: SARIF 2.1.0 (OASIS), as code scanning services read it.

use std::collections::BTreeSet;
use std::io::Write;

use camino::Utf8Path;
use dotgen_analysis::diagnostic::{Diagnostic, Fix, FixKind, Severity};
use serde_json::{Value, json};

use super::FileReports;
use crate::session;
use dotgen_lsp_server::protocol::convert::uri;
use dotgen_views::manual;

pub(crate) fn print(report: &FileReports) -> anyhow::Result<()> {
    let mut text = serde_json::to_string_pretty(&document(report))?;
    text.push('\n');
    Ok(std::io::stdout().write_all(dotgen_syntax::encoding::shown(&text).as_bytes())?)
}

fn document(report: &FileReports) -> Value {
    let codes: BTreeSet<&str> =
        report.diagnostics.iter().map(|diagnostic| diagnostic.code).collect();
    let rules = codes.iter().map(|code| rule(code));
    let results = report.diagnostics.iter().map(|diagnostic| result(report, diagnostic));
    json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": {
                "name": "dotgen",
                "version": env!("CARGO_PKG_VERSION"),
                "rules": rules.collect::<Vec<_>>(),
            }},
            "columnKind": "utf16CodeUnits",
            "results": results.collect::<Vec<_>>(),
        }],
    })
}

/// Describes a code by its page of the manual.
fn rule(code: &str) -> Value {
    let Some(page) = manual::text(code) else {
        return json!({ "id": code });
    };
    json!({
        "id": code,
        "shortDescription": { "text": summary(page) },
        "help": { "text": page, "markdown": page },
    })
}

/// Returns the first paragraph below the title of a page, in one line.
fn summary(page: &str) -> String {
    let mut paragraphs = page.split("\n\n").map(str::trim);
    let first = paragraphs.find(|paragraph| !paragraph.is_empty() && !paragraph.starts_with('#'));
    first.unwrap_or_default().replace('\n', " ")
}

fn result(report: &FileReports, diagnostic: &Diagnostic) -> Value {
    let level = match diagnostic.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Information | Severity::Hint => "note",
    };
    let related = diagnostic.related.iter().map(|related| {
        let mut location = location(report, &related.path, &related.range);
        location["message"] = json!({ "text": related.message });
        location
    });
    let mut result = json!({
        "ruleId": diagnostic.code,
        "level": level,
        "message": { "text": diagnostic.message },
        "locations": [location(report, &diagnostic.path, &diagnostic.range)],
    });
    if !diagnostic.related.is_empty() {
        result["relatedLocations"] = related.collect();
    }
    if !diagnostic.fixes.is_empty() {
        result["fixes"] = diagnostic.fixes.iter().map(|context| fix(report, context)).collect();
    }
    result
}

/// Converts a fix. A property of dotgen tells if the fix is plain.
fn fix(report: &FileReports, fix: &Fix) -> Value {
    let changes = fix.edits.iter().map(|edit| {
        json!({
            "artifactLocation": { "uri": artifact(&edit.path) },
            "replacements": [{
                "deletedRegion": region(report, &edit.path, &edit.range),
                "insertedContent": { "text": edit.new_text },
            }],
        })
    });
    json!({
        "description": { "text": fix.title },
        "artifactChanges": changes.collect::<Vec<_>>(),
        "properties": { "safe": fix.kind == FixKind::Plain },
    })
}

fn location(report: &FileReports, path: &Utf8Path, range: &std::ops::Range<usize>) -> Value {
    json!({
        "physicalLocation": {
            "artifactLocation": { "uri": artifact(path) },
            "region": region(report, path, range),
        },
    })
}

fn region(report: &FileReports, path: &Utf8Path, range: &std::ops::Range<usize>) -> Value {
    let range = super::json::range(&report.texts, path, range);
    json!({
        "startLine": range.start.line + 1,
        "startColumn": range.start.character + 1,
        "endLine": range.end.line + 1,
        "endColumn": range.end.character + 1,
    })
}

/// Returns a relative reference for files below the current directory, so that the result holds on other
/// machines. For other files, returns a URI.
fn artifact(path: &Utf8Path) -> String {
    let whole =
        uri::from_path(path).map_or_else(|| path.to_string(), |path| path.as_str().to_owned());
    let shown = session::display(path);
    if Utf8Path::new(&shown).is_absolute() {
        return whole;
    }
    let root = path.as_str().strip_suffix(&shown).unwrap_or_default();
    let root = uri::from_path(Utf8Path::new(root)).map_or(0, |path| path.as_str().len());
    whole[root..].trim_start_matches('/').to_owned()
}
