//! The diagnostics of one file's text, the same in every unit: reading, preprocessing, parsing.

use std::sync::Arc;

use camino::Utf8Path;
use dotgen_syntax::{
    TextRange, TextSize, encoding,
    finding::preprocessing::Preprocessing,
    preproc::{Element, MacroSite},
};
use smol_str::SmolStr;

use super::{fixes_at, shown};
use crate::{
    base::{Db, FileStatus, SourceFile, lexed},
    diagnostic::{Diagnostic, Related, Wording},
    finding::{FindingKind, files::FileProblem},
    fixes::{TextFix, near_include},
    source_map::{bytes, offset},
    unit::{self, FileKey, lowered, parsed, preprocessed, text_facts},
};

#[salsa::tracked]
pub(super) fn text_report<'db>(db: &'db dyn Db, key: FileKey<'db>) -> Arc<Vec<Diagnostic>> {
    let file = key.file(db);
    let at = |kind: FindingKind, range: TextRange, related: Option<(TextRange, &str)>| {
        let mut out = shown(&kind, None, None, file.path(db), range);
        let related = related.map(|(range, what)| related_at(db, file, range, what));
        out.related.extend(related);
        out.fixes = fixes_at(db, key, &kind, range, &[]);
        out
    };
    let mut out = Vec::new();
    if let Some((kind, range)) = reading(db, file) {
        out.push(at(kind.into(), range, None));
    }
    for error in &preprocessed(db, key).errors {
        let kind = FindingKind::Preprocessing(error.kind.clone());
        let diagnostic = match misspelt_include(db, file, &error.kind, error.range) {
            Some((range, path)) => {
                let meant = format!("did you mean `{path}`?");
                let mut diagnostic = shown(&kind, None, Some(&meant), file.path(db), error.range);
                let fix = TextFix::guess(format!("Change to `{path}`"), range, path);
                diagnostic.fixes.push(fix.within(file.path(db)));
                diagnostic
            }
            None => at(kind, error.range, error.related),
        };
        out.push(diagnostic);
    }
    for error in &parsed(db, key).errors {
        let kind = FindingKind::Parsing(Box::new(error.clone()));
        let mut diagnostic = at(kind, error.range, error.related);
        diagnostic.related.extend(expanded_from(db, key, error.range));
        out.push(diagnostic);
    }
    for &range in &lowered(db, key).misplaced {
        out.push(at(FileProblem::MisplacedInclude.into(), range, None));
    }
    Arc::new(out)
}

/// The place of the path of an include that is not found, and the probable intention.
fn misspelt_include(
    db: &dyn Db,
    file: SourceFile,
    kind: &Preprocessing,
    range: TextRange,
) -> Option<(TextRange, String)> {
    let (path, searched) = match kind {
        Preprocessing::NotFound { path } => (path, &[][..]),
        Preprocessing::NotFoundIn { path, searched } => (path, &searched.0[..]),
        _ => return None,
    };
    let directive = file.text(db).get(bytes(range))?;
    let at = directive.find(path.as_str())?;
    let at = TextRange::at(range.start() + offset(at), TextSize::of(path.as_str()));
    let beside = file.path(db).parent().into_iter();
    let directories = beside.chain(searched.iter().map(Utf8Path::new));
    let meant = near_include(db, directories, path)?;
    Some((at, meant))
}

/// The error of the file as such.
fn reading(db: &dyn Db, file: SourceFile) -> Option<(FileProblem, TextRange)> {
    let start = TextRange::empty(TextSize::new(0));
    match file.status(db) {
        FileStatus::Text => None,
        FileStatus::Missing => Some((FileProblem::NoFile, start)),
        FileStatus::Directory => Some((FileProblem::Directory, start)),
        FileStatus::Unreadable(why) => {
            let why = why.as_str().into();
            Some((FileProblem::Unreadable { why }, start))
        }
        FileStatus::TooLarge(size) => {
            let (size, limit) = (size.div_ceil(1024), db.max_bytes() / 1024);
            Some((FileProblem::TooLarge { size, limit }, start))
        }
        FileStatus::NotUtf8 => {
            let at = encoding::first_escape(file.text(db));
            let at = at.or_else(|| file.text(db).find('\u{fffd}')).unwrap_or(0);
            let width = file.text(db)[at..].chars().next().map_or(0, char::len_utf8);
            Some((FileProblem::NotUtf8, TextRange::at(offset(at), offset(width))))
        }
    }
}

/// A related place.
pub(super) fn related_at(
    db: &dyn Db,
    file: SourceFile,
    range: TextRange,
    message: impl Into<Wording>,
) -> Related {
    Related { path: file.path(db).clone(), range: bytes(range), message: message.into() }
}

/// For the range of a macro call: the definition of the macro.
pub(super) fn expanded_from(db: &dyn Db, key: FileKey<'_>, range: TextRange) -> Option<Related> {
    let (name, site) = macro_call_at(db, key, range)?;
    let (file, range) = macro_definition(db, &site)?;
    let message = format!("expanded from macro `{name}`");
    Some(related_at(db, file, range, message))
}

/// The macro whose call covers a range exactly from its start.
pub(super) fn macro_call_at(
    db: &dyn Db,
    key: FileKey<'_>,
    range: TextRange,
) -> Option<(SmolStr, MacroSite)> {
    if !text_facts(db, key).has_expansions {
        return None;
    }
    let pre = preprocessed(db, key);
    let uses = &pre.macro_uses;
    let used = uses
        .binary_search_by_key(&range.start(), |usage| usage.range.start())
        .ok()
        .and_then(|place| uses.get(place))?;
    let site = used.site.clone()?;
    // Not a mention in a condition, or of a function-like macro without arguments.
    let raw = &lexed(db, key.file(db)).raw;
    let first = raw.token_at(usize::from(range.start())) as u32;
    let is_call =
        |element: &Element| matches!(element, Element::Call { first: call, .. } if *call == first);
    pre.elements.iter().any(is_call).then(|| (used.name.clone(), site))
}

/// The definition of a macro: its name in the directive.
fn macro_definition(db: &dyn Db, site: &MacroSite) -> Option<(SourceFile, TextRange)> {
    let file = db.file(camino::Utf8Path::new(site.file.as_ref()?.as_str()));
    let name = unit::define(db, file, site.ordinal)?.name?;
    Some((file, name.range))
}
