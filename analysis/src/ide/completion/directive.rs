//! Completion in directives: their words, files, macros, packages, interfaces.

use camino::Utf8PathBuf;
use dotgen_syntax::directive::DirectiveKind;
use rustc_hash::FxHashSet;

use super::{CompletionKind, Completions};
use crate::{
    base::normalize,
    elab::DefKind,
    ide::{FileView, SymbolKind},
    unit::{DirectiveEffect, serving_visit, walk_unit},
};

const WORDS: &[(&str, &str)] = &[
    ("include", "include \"$0\""),
    ("define", "define ${1:NAME} $0"),
    ("undef", "undef $0"),
    ("ifdef", "ifdef ${1:NAME}\n$0\n#endif"),
    ("ifndef", "ifndef ${1:NAME}\n$0\n#endif"),
    ("if", "if ${1:0}\n$0\n#endif"),
    ("elif", "elif $0"),
    ("else", "else"),
    ("endif", "endif"),
    ("warning", "warning $0"),
    ("pragma requires", "pragma requires \"$0\""),
    ("pragma provides", "pragma provides $0"),
    ("pragma masquerade", "pragma masquerade $0"),
    ("pragma wcet", "pragma wcet $0"),
];

/// Words that need an open condition.
const CONDITIONAL: &[&str] = &["elif", "else", "endif"];

pub(super) fn complete(view: &FileView<'_>, index: u32, at: usize, out: &mut Completions) {
    let Some(directive) = view.pre().directives.get(index as usize) else {
        return;
    };
    let text = view.text();
    let start = usize::from(directive.range.start());
    let line = text.get(start..at).unwrap_or_default();
    let Some(keyword) =
        directive.keyword.as_ref().filter(|keyword| usize::from(keyword.range.end()) < at)
    else {
        let hash = line.find('#').map_or(0, |hash| hash + 1);
        out.replace = start + hash..out.replace.end.max(at);
        // Blanks between `#` and the word stay.
        let blanks = line[hash..].len() - line[hash..].trim_start().len();
        out.replace.start += blanks;
        // The text after the word stays.
        let rest = super::line_behind(view, out.replace.end);
        let bare = !rest.is_empty();
        if bare
            && directive
                .keyword
                .as_ref()
                .is_some_and(|keyword| usize::from(keyword.range.start()) >= at)
        {
            return;
        }
        let open = is_open(view, start);
        for (word, insert) in WORDS {
            if CONDITIONAL.contains(word) && !open {
                continue;
            }
            if bare {
                out.add(*word, CompletionKind::Keyword, 0)
            } else {
                out.snippet(*word, *insert, 0)
            }
            .kind = CompletionKind::Keyword;
        }
        return;
    };
    let operand = text.get(usize::from(keyword.range.end())..at).unwrap_or_default();
    match &directive.kind {
        DirectiveKind::Include(_) => include(view, operand, at, out),
        DirectiveKind::If(_) | DirectiveKind::Elif(_) => {
            macros(view, start, 0, out);
            out.add("defined", CompletionKind::Keyword, 1);
        }
        DirectiveKind::Ifdef(_) | DirectiveKind::Ifndef(_) | DirectiveKind::Undef(_) => {
            macros(view, start, 0, out);
        }
        DirectiveKind::Pragma(_) => pragma(view, operand, out),
        _ => {}
    }
}

/// Returns true if a condition is open at an offset and can have another branch.
fn is_open(view: &FileView<'_>, at: usize) -> bool {
    let before = view.pre().directives.iter();
    let before = before.filter(|directive| usize::from(directive.range.start()) < at);
    let depth = before.fold(0_usize, |depth, directive| match directive.kind {
        DirectiveKind::If(_) | DirectiveKind::Ifdef(_) | DirectiveKind::Ifndef(_) => depth + 1,
        DirectiveKind::Endif(_) => depth.saturating_sub(1),
        _ => depth,
    });
    depth > 0
}

fn pragma(view: &FileView<'_>, operand: &str, out: &mut Completions) {
    let at = out.replace.end;
    if out.replace.is_empty() && !super::line_behind(view, at).is_empty() {
        return;
    }
    let words: Vec<&str> = operand.split_whitespace().collect();
    let complete = operand.ends_with(char::is_whitespace);
    let before = if complete { words.len() } else { words.len().saturating_sub(1) };
    match (words.first().copied().unwrap_or_default(), before) {
        (_, 0) => {
            for (word, insert) in WORDS {
                if let Some(word) = word.strip_prefix("pragma ") {
                    let insert = insert.strip_prefix("pragma ").unwrap_or(insert);
                    out.snippet(word, insert, 0).kind = CompletionKind::Keyword;
                }
            }
        }
        ("requires" | "require", _) => packages(view, out),
        ("provides" | "provide", _) => named(view, DefKind::Interface, out),
        ("wcet", 1) => named(view, DefKind::Codel, out),
        ("wcet", 3) => {
            for text in ["s", "ms", "us"] {
                out.add(text, CompletionKind::Unit, 0);
            }
        }
        ("masquerade", 2) => {
            for kind in
                [DefKind::Typedef, DefKind::Struct, DefKind::Union, DefKind::Enum, DefKind::Native]
            {
                named(view, kind, out);
            }
        }
        _ => {}
    }
}

fn named(view: &FileView<'_>, kind: DefKind, out: &mut Completions) {
    for definition in &view.elaborated().definitions {
        if definition.kind == kind {
            let item = out.add(
                definition.name.as_str(),
                CompletionKind::Symbol(SymbolKind::from(kind)),
                0,
            );
            item.definition = Some(definition.id);
        }
    }
}

/// Macros that stand for the beginning of a statement.
pub(super) fn beginning(
    view: &FileView<'_>,
    at: usize,
    rank: u8,
    begins: &dyn Fn(&str) -> bool,
    out: &mut Completions,
) {
    let mut all = defined(view, at);
    all.retain(|(name, definition)| {
        let body = definition.strip_prefix("#define").unwrap_or(definition).trim();
        let body = body.strip_prefix(name.as_str()).unwrap_or(body).trim_start();
        let word = body
            .split(|character: char| {
                !character.is_ascii_alphanumeric() && !"_-".contains(character)
            })
            .next();
        word.is_some_and(begins)
    });
    add(all, rank, out);
}

/// Names of packages.
pub(super) fn packages(view: &FileView<'_>, out: &mut Completions) {
    for package_name in view.db.loader().package_names() {
        out.add(package_name, CompletionKind::Package, 0);
    }
}

/// Macros defined at an offset.
pub(super) fn macros(view: &FileView<'_>, at: usize, rank: u8, out: &mut Completions) {
    let mut all = defined(view, at);
    let guards = guards(view);
    all.retain(|(name, _)| !guards.contains(name));
    add(all, rank, out);
}

/// Names of include guards: files of the unit begin with `#ifndef` and `#define` of them.
fn guards(view: &FileView<'_>) -> FxHashSet<String> {
    let files = crate::unit::files(view.db, view.unit);
    let guard = |file: crate::base::SourceFile| {
        let text = crate::unit::walk::skeleton(view.db, file);
        let mut lines = text.lines().filter(|line| !line.trim().is_empty());
        let words = |line: &str| -> Vec<String> {
            let line = line.trim().trim_start_matches('#').trim_start();
            line.split_whitespace().map(ToOwned::to_owned).collect()
        };
        let (first, second) = (words(lines.next()?), words(lines.next()?));
        let [condition, name, ..] = first.as_slice() else {
            return None;
        };
        let defines =
            second.first().is_some_and(|text| text == "define") && second.get(1) == Some(name);
        (condition == "ifndef" && defines).then(|| name.clone())
    };
    files.into_iter().filter_map(guard).collect()
}

/// Macros that stand for a number.
pub(super) fn values(view: &FileView<'_>, at: usize, rank: u8, out: &mut Completions) {
    let mut all = defined(view, at);
    all.retain(|(name, definition)| {
        let body = definition.strip_prefix("#define").unwrap_or(definition).trim();
        let body = body.strip_prefix(name.as_str()).unwrap_or(body);
        body.trim_start()
            .starts_with(|character: char| character.is_ascii_digit() || character == '(')
    });
    add(all, rank, out);
}

fn add(all: Vec<(String, String)>, rank: u8, out: &mut Completions) {
    for (name, definition) in all {
        out.add(name, CompletionKind::Symbol(SymbolKind::Macro), rank).detail = Some(definition);
    }
}

/// Names and definitions of the macros defined at an offset.
fn defined(view: &FileView<'_>, at: usize) -> Vec<(String, String)> {
    let Some((visit, _)) = serving_visit(view.db, view.unit, view.file) else {
        return Vec::new();
    };
    let Some(walked) = walk_unit(view.db, view.unit).visits.get(visit) else {
        return Vec::new();
    };
    let pre = view.pre();
    let includes_before =
        pre.includes.iter().filter(|include| usize::from(include.range.start()) < at);
    let passed = includes_before.count();
    let environments = walked.outcomes.iter().filter_map(|outcome| match outcome {
        DirectiveEffect::Include(include) => Some(include.as_ref().ok()),
        DirectiveEffect::Requires(_) => None,
    });
    let environments: Vec<_> = environments.collect();
    let last = environments.iter().take(passed).rev().find_map(|environment| *environment);
    let env = last.unwrap_or(&walked.entry);
    let mut all: Vec<(String, String)> = env
        .iter()
        .filter(|environment| !environment.name.starts_with("__"))
        .map(|environment| (environment.name.to_string(), environment.definition_text()))
        .collect();
    all.sort();
    for directive in pre
        .directives
        .iter()
        .filter(|directive| directive.active && usize::from(directive.range.end()) <= at)
    {
        if let DirectiveKind::Define(define) = &directive.kind
            && let Some(name) = &define.name
        {
            all.retain(|entry| entry.0 != name.text);
            let text = view.text().get(std::ops::Range::from(directive.range)).unwrap_or_default();
            all.push((name.text.to_string(), text.trim().to_owned()));
        }
    }
    all
}

/// Files that an `#include` may name.
fn include(view: &FileView<'_>, operand: &str, at: usize, out: &mut Completions) {
    let trimmed = operand.trim_start();
    let Some(delimiter) = trimmed.chars().next() else {
        if !super::line_behind(view, at).is_empty() {
            return;
        }
        for (label, insert) in [("\"…\"", "\"$0\""), ("<…>", "<$0>")] {
            out.snippet(label, insert, 0);
        }
        return;
    };
    if !matches!(delimiter, '"' | '<') {
        macros(view, at, 0, out);
        return;
    }
    let written = &trimmed[1..];
    if written.contains(['"', '>']) {
        return;
    }
    let (folder, name) = written.rsplit_once('/').map_or(("", written), |(a, b)| (a, b));
    // Up to the delimiter, so that an existing path is replaced.
    let rest = view.text().get(at..).unwrap_or_default();
    let end = rest.find(['"', '>', '\n', '\r', '/']).unwrap_or(rest.len());
    out.replace = at - name.len()..at + end;
    let (dirs, including) = searched(view, delimiter == '"');
    let mut seen = FxHashSet::default();
    for dir in dirs {
        let dir = normalize(&dir.join(folder));
        if !seen.insert(dir.clone()) || seen.len() > 32 {
            continue;
        }
        let mut entries = view.db.loader().list_dir(&dir);
        entries.sort();
        for entry in entries {
            if entry.name.starts_with('.') && !name.starts_with('.') {
                continue;
            }
            let path = dir.join(&entry.name);
            // A file that includes this one would include itself.
            let own = path == *view.file.path(view.db) || including.contains(&path);
            let specification =
                ["gen", "idl"].iter().any(|text| entry.name.ends_with(&format!(".{text}")));
            if entry.is_dir {
                out.add(format!("{}/", entry.name), CompletionKind::Directory, 2);
            } else if !own && specification {
                let rank =
                    u8::from(!(entry.name.ends_with(".idl") || entry.name.ends_with(".gen")));
                out.add(entry.name, CompletionKind::Symbol(SymbolKind::File), rank).detail =
                    Some(dir.to_string());
            }
        }
    }
}

/// The directories that an `#include` searches, and the files that include this one. With `quoted`, the
/// directory of the file comes first.
fn searched(view: &FileView<'_>, quoted: bool) -> (Vec<Utf8PathBuf>, Vec<Utf8PathBuf>) {
    let mut dirs: Vec<Utf8PathBuf> = Vec::new();
    if quoted {
        dirs.extend(view.file.path(view.db).parent().map(ToOwned::to_owned));
    }
    let root = view.unit.inputs(view.db).first().unwrap_or(&view.file);
    let (searched, _) = view.db.workspace().reading(view.db, root.path(view.db));
    dirs.extend(searched.iter().cloned());
    // Directories of packages: the directories of other includes, without the path as written.
    let walked = walk_unit(view.db, view.unit);
    let mut including: Vec<Utf8PathBuf> = Vec::new();
    for visit in &walked.visits {
        let Some((by, _)) = visit.includer else {
            continue;
        };
        let Some(by) = walked.visits.get(by) else {
            continue;
        };
        let (found, own) = (visit.file.path(view.db), by.file.path(view.db).parent());
        if visit.file == view.file {
            including.push(by.file.path(view.db).clone());
        }
        for written in crate::unit::walk::skeleton(view.db, by.file).lines() {
            let written = written.split(['"', '<', '>']).nth(1).unwrap_or_default();
            let root = found.as_str().strip_suffix(written);
            let root = root.and_then(|root| root.strip_suffix('/')).filter(|_| !written.is_empty());
            dirs.extend(root.map(Utf8PathBuf::from).filter(|path| Some(path.as_path()) != own));
        }
    }
    (dirs, including)
}
