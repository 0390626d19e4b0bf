//! `--format json`: one document, positions as in the LSP. `docs/check.schema.json` is its schema.

use std::io::Write;

use camino::Utf8Path;
use dotgen_analysis::diagnostic::{Diagnostic, Fix, FixKind, Severity};
use schemars::JsonSchema;
use serde::Serialize;

use super::{FileReports, OpenNames};
use crate::session::{self, Texts};
use dotgen_lsp_server::protocol::types::{Position, Range};

/// Version of the format. Additions may be ignored by readers; a removed or changed member increases the
/// version.
pub(crate) const VERSION: u32 = 1;

/// What `dotgen check --format json` prints.
#[derive(Serialize, JsonSchema)]
#[schemars(title = "Output of dotgen check --format json")]
struct Document<E> {
    /// Version of this form: 1.
    version: u32,
    /// Everything that was found.
    diagnostics: Vec<E>,
    /// Of `dotgen codels check`: how much of the codels of each component was compared, and what the others
    /// wait for.
    #[serde(skip_serializing_if = "<[_]>::is_empty", default)]
    #[schemars(with = "Vec<Compared>")]
    codels: Vec<serde_json::Value>,
    /// Names that only a missing package or file can explain, by specification.
    #[serde(skip_serializing_if = "<[_]>::is_empty", default)]
    waiting: Vec<OpenNames>,
}

/// One finding.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Entry {
    /// The file, relative to the current directory if it is below it.
    file: String,
    /// How bad it is; only errors reject a specification.
    #[schemars(with = "Level")]
    severity: Severity,
    /// The stable code; `dotgen explain CODE` says what it means.
    code: &'static str,
    /// What is wrong, and what to do, for people.
    message: String,
    /// Where.
    #[schemars(with = "Span")]
    range: Range,
    /// Other places that explain it.
    related: Vec<Related>,
    /// Ways to mend it, the best first.
    fixes: Vec<Mending>,
}

/// How bad a finding is.
#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
#[allow(dead_code, reason = "stands for the severity of the analysis in the schema")]
enum Level {
    Error,
    Warning,
    Information,
    Hint,
}

/// A part of a file.
#[derive(JsonSchema)]
#[allow(dead_code, reason = "stands for the range of the protocol in the schema")]
struct Span {
    /// Its beginning.
    #[schemars(with = "Place")]
    start: Position,
    /// Its end, behind the last character.
    #[schemars(with = "Place")]
    end: Position,
}

/// A place in a file.
#[derive(JsonSchema)]
#[allow(dead_code, reason = "stands for the position of the protocol in the schema")]
struct Place {
    /// The line, from 0.
    line: u32,
    /// The character in it, from 0, in UTF-16 units.
    character: u32,
}

/// A place that explains a finding.
#[derive(Serialize, JsonSchema)]
struct Related {
    /// The file.
    file: String,
    /// Where.
    #[schemars(with = "Span")]
    range: Range,
    /// What is there.
    message: String,
}

/// A way to mend a finding.
#[derive(Serialize, JsonSchema)]
struct Mending {
    /// What it does, in the imperative.
    title: String,
    /// Whether it can be applied unasked: nobody would mend it in another way.
    safe: bool,
    /// What it changes. All edits are made at once: their ranges are those of the texts as they were checked.
    edits: Vec<Edit>,
}

/// A change of a file.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
struct Edit {
    /// The file.
    file: String,
    /// What is replaced; empty to insert.
    #[schemars(with = "Span")]
    range: Range,
    /// The new text; empty to remove.
    new_text: String,
}

/// How much of the codels of a component was compared.
#[derive(JsonSchema)]
#[allow(dead_code, reason = "stands for the report of code generation in the schema")]
struct Compared {
    /// The specification, relative to the current directory if it is below it.
    file: String,
    /// The component.
    component: String,
    /// Functions that the specification names.
    codels: usize,
    /// Of these, the ones of which something was compared.
    judged: usize,
    /// Of these, the ones of which it is known what each parameter is.
    compared: usize,
    /// Those whose declaration has errors: they were left out.
    faulty: usize,
    /// What the others wait for.
    waiting: Vec<OpenNames>,
    /// Modules and types that are not known, and agree with any type of a parameter.
    assumed: Vec<String>,
}

/// Codels that wait for something.
#[derive(JsonSchema)]
#[allow(dead_code, reason = "stands for the report of code generation in the schema")]
struct Waiting {
    /// An interface that is not known.
    #[schemars(rename = "for")]
    missing: String,
    /// Number of codels with a parameter from there.
    codels: usize,
}

/// Converts diagnostics to entries.
pub(crate) fn entries(diagnostics: &[Diagnostic], texts: &Texts) -> Vec<Entry> {
    let entries = diagnostics.iter().map(|diagnostic| Entry {
        file: session::display(&diagnostic.path),
        severity: diagnostic.severity,
        code: diagnostic.code,
        message: diagnostic.message.to_string(),
        range: range(texts, &diagnostic.path, &diagnostic.range),
        related: diagnostic
            .related
            .iter()
            .map(|related| Related {
                file: session::display(&related.path),
                range: range(texts, &related.path, &related.range),
                message: related.message.to_string(),
            })
            .collect(),
        fixes: diagnostic.fixes.iter().map(|fix| mending(fix, texts)).collect(),
    });
    entries.collect()
}

fn mending(fix: &Fix, texts: &Texts) -> Mending {
    let edits = fix.edits.iter().map(|edit| Edit {
        file: session::display(&edit.path),
        range: range(texts, &edit.path, &edit.range),
        new_text: edit.new_text.clone(),
    });
    Mending { title: fix.title.clone(), safe: fix.kind == FixKind::Plain, edits: edits.collect() }
}

pub(crate) fn print(report: &FileReports) -> anyhow::Result<()> {
    let document = Document {
        version: VERSION,
        diagnostics: entries(&report.diagnostics, &report.texts),
        codels: (report.compared.iter().map(serde_json::to_value)).collect::<Result<_, _>>()?,
        waiting: report.waiting.clone(),
    };
    let mut json = serde_json::to_string_pretty(&document)?;
    json.push('\n');
    Ok(std::io::stdout().write_all(dotgen_syntax::encoding::shown(&json).as_bytes())?)
}

/// Returns a range with lines from 0 and characters in UTF-16 units.
pub(super) fn range(texts: &Texts, path: &Utf8Path, range: &std::ops::Range<usize>) -> Range {
    texts.get(path).map(|text| text.range(range)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Rewrites the committed schema, and fails if the schema was out of date.
    #[test]
    fn committed_schema_of_check_is_up_to_date() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/check.schema.json");
        let schema = schemars::schema_for!(Document<Entry>);
        let mut fresh = serde_json::to_string_pretty(&schema).expect("a schema is JSON");
        fresh.push('\n');
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        if committed != fresh {
            std::fs::write(&path, fresh).expect("docs/ is writable");
            panic!("docs/check.schema.json was not up to date; commit the new one");
        }
    }
}
