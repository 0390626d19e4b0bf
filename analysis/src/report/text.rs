//! What the text of one file gives, whatever unit it is in: reading, preprocessing, parsing.

use std::sync::Arc;

use dotgen_syntax::{
    TextRange, TextSize, encoding,
    preproc::{Element, MacroSite},
};
use smol_str::SmolStr;

use crate::{
    base::{Db, FileStatus, SourceFile, lexed},
    diagnostic::{Diagnostic, Related, Severity},
    fixes,
    source_map::{bytes, offset},
    unit::{self, FileKey, lowered, parsed, preprocessed},
};

/// A file given to compile cannot be read.
const PP_INPUT: &str = "pp-input";
/// An include in the middle of a declaration.
const PP_INCLUDE_PLACE: &str = "pp-include-place";
/// A text that is not UTF-8.
const NOT_UTF8: &str = "not-utf8";
/// The diagnostics of a text.
#[salsa::tracked]
pub(super) fn text_report<'db>(db: &'db dyn Db, key: FileKey<'db>) -> Arc<Vec<Diagnostic>> {
    let file = key.file(db);
    let new = |code, severity, range, message| Diagnostic {
        code,
        severity,
        message,
        path: file.path(db).clone(),
        range: bytes(range),
        related: Vec::new(),
        tags: Vec::new(),
        fixes: Vec::new(),
    };
    let mut out = Vec::new();
    if let Some((code, severity, range, message)) = reading(db, file) {
        out.push(new(code, severity, range, message));
    }
    for error in &preprocessed(db, key).errors {
        let severity = syntax_severity(error.severity);
        let mut it = new(error.code, severity, error.range, error.message.clone());
        let related = error.related.as_ref();
        it.related
            .extend(related.map(|(range, message)| related_at(db, file, *range, *message)));
        out.push(it);
    }
    for error in &parsed(db, key).errors {
        let severity = syntax_severity(error.severity);
        let mut it = new(error.code, severity, error.range, error.message.clone());
        let related = error.related.as_ref();
        it.related
            .extend(related.map(|(range, message)| related_at(db, file, *range, *message)));
        it.related.extend(expanded_from(db, key, error.range));
        if error.missing.is_some() && macro_call_at(db, key, error.range).is_none() {
            let root = parsed(db, key).syntax();
            let fix = fixes::missing_brace(&root, error);
            it.fixes.extend(fix.map(|it| it.within(file.path(db))));
        }
        out.push(it);
    }
    for &range in &lowered(db, key).misplaced {
        let message = "a file cannot be included in the middle of a declaration; \
                       include it between two declarations, or write its text here";
        out.push(new(
            PP_INCLUDE_PLACE,
            Severity::Error,
            range,
            message.into(),
        ));
    }
    Arc::new(out)
}

/// What is wrong with the file as such.
fn reading(db: &dyn Db, file: SourceFile) -> Option<(&'static str, Severity, TextRange, String)> {
    let start = TextRange::empty(TextSize::new(0));
    let unreadable = |message: String| Some((PP_INPUT, Severity::Error, start, message));
    match file.status(db) {
        FileStatus::Text => None,
        FileStatus::Missing => unreadable("no such file".into()),
        FileStatus::Directory => unreadable("this is a directory, not a specification".into()),
        FileStatus::Unreadable(why) => unreadable(format!("this file cannot be read: {why}")),
        FileStatus::NotUtf8 => {
            let at = encoding::first_escape(file.text(db));
            let at = at.or_else(|| file.text(db).find('\u{fffd}')).unwrap_or(0);
            let width = file.text(db)[at..].chars().next().map_or(0, char::len_utf8);
            let at = TextRange::at(offset(at), offset(width));
            let message = "this file is not UTF-8 from here on; save it as UTF-8".into();
            Some((NOT_UTF8, Severity::Warning, at, message))
        }
    }
}

/// A place that explains something.
pub(super) fn related_at(
    db: &dyn Db,
    file: SourceFile,
    range: TextRange,
    message: impl Into<String>,
) -> Related {
    Related {
        path: file.path(db).clone(),
        range: bytes(range),
        message: message.into(),
    }
}

/// For a range that is a macro call: where the macro is defined.
pub(super) fn expanded_from(db: &dyn Db, key: FileKey<'_>, range: TextRange) -> Option<Related> {
    let (name, site) = macro_call_at(db, key, range)?;
    let (file, range) = macro_definition(db, &site)?;
    let message = format!("expanded from macro `{name}`");
    Some(related_at(db, file, range, message))
}

fn syntax_severity(it: dotgen_syntax::Severity) -> Severity {
    match it {
        dotgen_syntax::Severity::Error => Severity::Error,
        dotgen_syntax::Severity::Warning => Severity::Warning,
        dotgen_syntax::Severity::Hint => Severity::Hint,
    }
}

/// The macro whose call covers a range exactly from its start.
pub(super) fn macro_call_at(
    db: &dyn Db,
    key: FileKey<'_>,
    range: TextRange,
) -> Option<(SmolStr, MacroSite)> {
    if parsed(db, key).expansion.is_empty() {
        return None;
    }
    let pre = preprocessed(db, key);
    let uses = &pre.macro_uses;
    let used = uses
        .binary_search_by_key(&range.start(), |it| it.range.start())
        .ok()
        .and_then(|it| uses.get(it))?;
    let site = used.site.clone()?;
    // Not a mention in a condition, or of a function-like macro without arguments.
    let raw = &lexed(db, key.file(db)).raw;
    let first = raw.token_at(usize::from(range.start())) as u32;
    let is_call = |it: &Element| matches!(it, Element::Call { first: call, .. } if *call == first);
    pre.elements
        .iter()
        .any(is_call)
        .then(|| (used.name.clone(), site))
}

/// Where a macro is defined: its name in the directive.
fn macro_definition(db: &dyn Db, site: &MacroSite) -> Option<(SourceFile, TextRange)> {
    let file = db.file(camino::Utf8Path::new(site.file.as_ref()?.as_str()));
    let name = unit::define(db, file, site.ordinal)?.name?;
    Some((file, name.range))
}
