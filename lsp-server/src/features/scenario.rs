//! Editor features of scenarios (`.scn`): what the handlers of specifications leave to it. The language
//! itself is in `dotgen_timing::scn`; here it meets documents and positions.

use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::{Diagnostic, FileEdit};
use dotgen_analysis::host::{Cancellable, FileContent};
use dotgen_analysis::ide::FilePosition;
use dotgen_analysis::markdown;
use dotgen_analysis::source_map::Locations;
use dotgen_timing::scn::complete::{self, CompletionKind as Kind, Completions};
use dotgen_timing::scn::lexer::{self, lex};
use dotgen_timing::scn::names::{Names, Reference, Target};
use dotgen_timing::scn::outline::{self, EntryKind};
use dotgen_timing::scn::{self, describe};

use crate::features::verification::problems;
use crate::files::vfs;
use crate::protocol::convert::Lines;
use crate::protocol::convert::symbol::{Symbol, response};
use crate::protocol::types::{self, *};
use crate::verification::Problem;
use crate::verification::problem::{self, EXTENSION};
use crate::workspace::snapshot::{Snapshot, Subject};

/// Whether a document is a scenario.
pub(crate) fn is(path: &Utf8Path) -> bool {
    path.extension() == Some(EXTENSION)
}

/// A scenario as it stands, with the cursor in it.
struct Cursor {
    problem: Problem,
    offset: usize,
    lines: std::sync::Arc<Lines>,
}

impl Cursor {
    fn new(
        snapshot: &Snapshot,
        subject: &Subject,
        position: Position,
    ) -> Cancellable<Option<Cursor>> {
        let (Some(at), Some(lines)) = (
            snapshot.cursor(subject, position)?,
            snapshot.lines(&subject.path)?,
        ) else {
            return Ok(None);
        };
        Ok(Some(Cursor {
            problem: read(snapshot, &subject.path)?,
            offset: at.offset,
            lines,
        }))
    }

    fn touches(&self, it: &Range<usize>) -> bool {
        it.start <= self.offset && self.offset <= it.end
    }

    /// The name of a specification, client or status under the cursor.
    fn reference(&self) -> Option<Reference> {
        let specs = self.problem.specs();
        let names = Names::new(&specs);
        let mut all = names.references(&self.problem.scenario).into_iter();
        all.find(|it| self.touches(&it.range))
    }
}

fn read(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Problem> {
    let text = match snapshot.analysis.text(path)? {
        Some(text) => text.to_string(),
        None => String::new(),
    };
    problems::scenario(snapshot, path, text)
}

/// Syntax, files, names; and what the verifier said, if that was about this text.
pub(crate) fn diagnostics(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Vec<Diagnostic>> {
    let problem = read(snapshot, path)?;
    let (mut out, mut elsewhere): (Vec<Diagnostic>, Vec<Diagnostic>) =
        (problem.errors.iter().cloned()).partition(|it| it.path == path);
    // Errors of a specification are shown there; here it is enough that there are some.
    elsewhere.dedup_by(|a, b| a.path == b.path);
    for mut it in elsewhere {
        let file = it.path.file_name().unwrap_or("a specification");
        it.message = format!("`{file}` has errors: {}", it.message);
        let used = problem::used(&problem.scenario, path);
        let used = used.into_iter().find(|used| used.path == it.path);
        it.range = used.map_or(problem.scenario.name_range.clone(), |it| it.range);
        it.path = path.to_owned();
        it.fixes.clear();
        it.related.clear();
        out.push(it);
    }
    if out.is_empty() {
        // Names are looked up whether verification is on or not.
        let known = super::verification::in_scenario(snapshot, path);
        let specs = problem.specs();
        let names = Names::new(&specs);
        for it in names.unknown_names(&problem.scenario) {
            if !known.iter().any(|known| known.range == it.range) {
                out.push(problem::diagnostic(&it, path));
            }
        }
        out.extend(known);
    }
    Ok(out)
}

/// The formatted text, as one edit.
pub(crate) fn format(snapshot: &Snapshot, subject: &Subject) -> Cancellable<Option<Vec<TextEdit>>> {
    let (Some(text), Some(lines)) = (
        snapshot.analysis.text(&subject.path)?,
        snapshot.lines(&subject.path)?,
    ) else {
        return Ok(None);
    };
    let formatted = scn::format(&text).filter(|it| **it != *text);
    Ok(formatted.map(|it| vec![TextEdit::new(lines.range(&(0..text.len())), it)]))
}

/// Where a target is declared.
fn declaration(
    snapshot: &Snapshot,
    problem: &Problem,
    target: &Target,
) -> Cancellable<Option<FilePlace>> {
    let specs = problem.specs();
    let names = Names::new(&specs);
    let own = |range: Range<usize>| {
        Some(FilePlace {
            path: problem.path.clone(),
            range,
        })
    };
    let declared = match target {
        Target::Client(name) => {
            let entries = outline::outline(&problem.text, &problem.scenario);
            let mut children = entries.into_iter().flat_map(|it| it.children);
            return Ok(children
                .find(|it| it.kind == EntryKind::Client && it.name == *name)
                .and_then(|it| own(it.selection)));
        }
        Target::Step(client, label) => {
            let entries = outline::outline(&problem.text, &problem.scenario);
            let children = entries.into_iter().flat_map(|it| it.children);
            let mut steps = children
                .filter(|it| it.kind == EntryKind::Client && it.name == *client)
                .flat_map(|it| it.children);
            return Ok(steps
                .find(|it| it.name == *label)
                .and_then(|it| own(it.selection)));
        }
        _ => names.declaration(target),
    };
    let Some((spec, src)) = declared else {
        return Ok(None);
    };
    let place = problem.units[spec].locations.locate(src);
    let Some(place) = place else {
        return Ok(None);
    };
    // Analysis says where the name stands.
    let at = FilePosition {
        path: place.path.clone(),
        offset: place.range.start,
    };
    let found = snapshot.analysis.goto_definition(&at)?;
    let name = found.and_then(|it| it.info.into_iter().next());
    Ok(Some(match name {
        Some(it) if !matches!(target, Target::State(..) | Target::Codel(..)) => FilePlace {
            path: it.path,
            range: it.focus_range,
        },
        _ => FilePlace {
            path: place.path,
            range: place.range,
        },
    }))
}

/// A range of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
struct FilePlace {
    path: Utf8PathBuf,
    range: Range<usize>,
}

/// From a name of a path to its declaration, and from a `use` to its file.
pub(crate) fn definition(
    snapshot: &Snapshot,
    subject: &Subject,
    position: Position,
) -> Cancellable<Option<Vec<Location>>> {
    let Some(cursor) = Cursor::new(snapshot, subject, position)? else {
        return Ok(None);
    };
    let files = problem::used(&cursor.problem.scenario, &subject.path);
    if let Some(file) = files.into_iter().find(|it| cursor.touches(&it.range)) {
        return Ok(snapshot.location(&file.path, &(0..0))?.map(|it| vec![it]));
    }
    let Some(reference) = cursor.reference() else {
        return Ok(None);
    };
    match declaration(snapshot, &cursor.problem, &reference.target)? {
        Some(it) => Ok(snapshot.location(&it.path, &it.range)?.map(|it| vec![it])),
        None => Ok(None),
    }
}

pub(crate) fn hover(
    snapshot: &Snapshot,
    subject: &Subject,
    position: Position,
) -> Cancellable<Option<Hover>> {
    let Some(cursor) = Cursor::new(snapshot, subject, position)? else {
        return Ok(None);
    };
    let Problem { text, scenario, .. } = &cursor.problem;
    let specs = cursor.problem.specs();
    let names = Names::new(&specs);
    let found = describe::describe(text, scenario, &names, cursor.offset);
    Ok(found.map(|it| Hover {
        contents: HoverContents::Markup(match snapshot.client.markdown_hover {
            true => MarkupContent {
                kind: MarkupKind::Markdown,
                value: format!("{}\n{}", markdown::block("", &it.form), it.meaning),
            },
            false => MarkupContent {
                kind: MarkupKind::PlainText,
                value: format!("{}\n{}", it.form, it.meaning),
            },
        }),
        range: Some(cursor.lines.range(&it.range)),
    }))
}

pub(crate) fn completion(
    snapshot: &Snapshot,
    subject: &Subject,
    position: Position,
) -> Cancellable<Option<CompletionResponse>> {
    let Some(cursor) = Cursor::new(snapshot, subject, position)? else {
        return Ok(None);
    };
    let Problem { text, scenario, .. } = &cursor.problem;
    let specs = cursor.problem.specs();
    let names = Names::new(&specs);
    let item =
        |order: usize, label: String, kind, detail: String, range: &Range<usize>| CompletionItem {
            text_edit: Some(CompletionTextEdit::Edit(TextEdit::new(
                cursor.lines.range(range),
                label.clone(),
            ))),
            label,
            kind: Some(kind),
            detail: Some(detail).filter(|it| !it.is_empty()),
            sort_text: Some(format!("{order:05}")),
            ..CompletionItem::default()
        };
    let items = match complete::complete(text, scenario, &names, cursor.offset) {
        Completions::File(range) => {
            let files = files(snapshot, &subject.path);
            let items = files.into_iter().enumerate();
            let kind = CompletionItemKind::FILE;
            items
                .map(|(i, file)| item(i, file, kind, String::new(), &range))
                .collect()
        }
        Completions::Of { replace, items } => {
            let items = items.into_iter().enumerate();
            items
                .map(|(i, it)| item(i, it.label, item_kind(it.kind), it.detail, &replace))
                .collect()
        }
    };
    Ok(Some(CompletionResponse::List(CompletionList {
        is_incomplete: false,
        items,
    })))
}

/// Specifications of the workspace, as `use` names them.
fn files(snapshot: &Snapshot, path: &Utf8Path) -> Vec<String> {
    let Some(directory) = path.parent() else {
        return Vec::new();
    };
    // Those beside it are there before the workspace is listed, and without one.
    let beside = directory.read_dir_utf8().into_iter().flatten();
    let beside = beside.filter_map(|it| Some(it.ok()?.into_path()));
    let specifications = snapshot.roots.iter().cloned().chain(beside);
    let specifications = specifications.filter(|it| it.extension() == Some("gen"));
    let mut names: Vec<String> = specifications
        .map(|file| {
            let mut up = String::new();
            for base in directory.ancestors() {
                if let Ok(rest) = file.strip_prefix(base) {
                    return format!("{up}{rest}");
                }
                up += "../";
            }
            file.to_string()
        })
        .collect();
    names.sort_by_key(|it| (it.matches("../").count(), it.clone()));
    names.dedup();
    names
}

fn item_kind(kind: Kind) -> CompletionItemKind {
    match kind {
        Kind::Word => CompletionItemKind::KEYWORD,
        Kind::Unit => CompletionItemKind::UNIT,
        Kind::Component => CompletionItemKind::CLASS,
        Kind::Task => CompletionItemKind::VALUE,
        Kind::Service => CompletionItemKind::METHOD,
        Kind::Port => CompletionItemKind::PROPERTY,
        Kind::Codel => CompletionItemKind::EVENT,
        Kind::Client => CompletionItemKind::VARIABLE,
        Kind::Status => CompletionItemKind::ENUM_MEMBER,
    }
}

pub(crate) fn symbols(
    snapshot: &Snapshot,
    subject: &Subject,
) -> Cancellable<Option<DocumentSymbolResponse>> {
    let (Some(text), Some(lines)) = (
        snapshot.analysis.text(&subject.path)?,
        snapshot.lines(&subject.path)?,
    ) else {
        return Ok(None);
    };
    let entries = outline::outline(&text, &scn::parse(&text).scenario);
    let symbols = entries.into_iter().map(symbol);
    let nested = snapshot.client.hierarchical_symbols;
    Ok(Some(response(symbols, nested, &subject.uri, &lines)))
}

fn symbol_kind(kind: EntryKind) -> SymbolKind {
    match kind {
        EntryKind::Scenario => SymbolKind::MODULE,
        EntryKind::File => SymbolKind::FILE,
        EntryKind::Client => SymbolKind::OBJECT,
        EntryKind::Step => SymbolKind::EVENT,
        EntryKind::Check => SymbolKind::BOOLEAN,
    }
}

fn symbol(it: outline::Entry) -> Symbol {
    Symbol {
        name: it.name,
        detail: None,
        kind: symbol_kind(it.kind),
        range: it.range,
        selection: it.selection,
        children: it.children.into_iter().map(symbol).collect(),
    }
}

/// Braces that hold more than a line, and comments.
pub(crate) fn folds(
    snapshot: &Snapshot,
    subject: &Subject,
) -> Cancellable<Option<Vec<FoldingRange>>> {
    let (Some(text), Some(lines)) = (
        snapshot.analysis.text(&subject.path)?,
        snapshot.lines(&subject.path)?,
    ) else {
        return Ok(None);
    };
    let mut open = Vec::new();
    let mut out = Vec::new();
    let mut fold = |from: usize, to: usize, kind: Option<FoldingRangeKind>| {
        let range = lines.range(&(from..to));
        let whole = snapshot.client.line_folding_only;
        let last = range.end.line - u32::from(whole && kind.is_none() && range.end.line > 0);
        if last > range.start.line {
            out.push(FoldingRange {
                start_line: range.start.line,
                start_character: (!whole).then_some(range.start.character),
                end_line: last,
                end_character: (!whole).then_some(range.end.character),
                kind,
                collapsed_text: None,
            });
        }
    };
    for token in lex(&text) {
        match token.kind {
            lexer::Kind::OpenBrace => open.push(token.range.end),
            lexer::Kind::CloseBrace => {
                if let Some(from) = open.pop() {
                    fold(from, token.range.start, None);
                }
            }
            lexer::Kind::BlockComment => {
                fold(
                    token.range.start,
                    token.range.end,
                    Some(FoldingRangeKind::Comment),
                );
            }
            _ => {}
        }
    }
    Ok(Some(out))
}

/// The other mentions in this scenario of the name under the cursor.
pub(crate) fn highlights(
    snapshot: &Snapshot,
    subject: &Subject,
    position: Position,
) -> Cancellable<Option<Vec<DocumentHighlight>>> {
    let Some(cursor) = Cursor::new(snapshot, subject, position)? else {
        return Ok(None);
    };
    let Some(reference) = cursor.reference() else {
        return Ok(None);
    };
    let specs = cursor.problem.specs();
    let all = Names::new(&specs).references(&cursor.problem.scenario);
    let same = all.into_iter().filter(|it| it.target == reference.target);
    let ranges = same.map(|it| DocumentHighlight {
        range: cursor.lines.range(&it.range),
        kind: Some(DocumentHighlightKind::READ),
    });
    Ok(Some(ranges.collect()))
}

/// The declaration in a specification of the name under the cursor of a scenario: where the handlers of
/// specifications can go on.
pub(crate) fn declared_at(
    snapshot: &Snapshot,
    subject: &Subject,
    position: Position,
) -> Cancellable<Option<(FilePosition, types::Range, String)>> {
    let Some(cursor) = Cursor::new(snapshot, subject, position)? else {
        return Ok(None);
    };
    let Some(reference) = cursor.reference() else {
        return Ok(None);
    };
    let Some(place) = declaration(snapshot, &cursor.problem, &reference.target)? else {
        return Ok(None);
    };
    let text = cursor.problem.text.get(reference.range.clone());
    let at = FilePosition {
        path: place.path,
        offset: place.range.start,
    };
    let range = cursor.lines.range(&reference.range);
    Ok(Some((at, range, text.unwrap_or_default().to_owned())))
}

/// The scenarios of the workspace and open documents that use a file, as they stand.
fn scenarios_using(snapshot: &Snapshot, file: &Utf8Path) -> Cancellable<Vec<Problem>> {
    let open = snapshot.open.keys().filter(|it| is(it));
    let mut paths: Vec<&Utf8PathBuf> = snapshot.scenarios.iter().chain(open).collect();
    paths.sort();
    paths.dedup();
    let mut out = Vec::new();
    for path in paths {
        let text = match snapshot.analysis.text(path)? {
            Some(text) => text.to_string(),
            None => match vfs::read(path) {
                FileContent::Text(text) => text,
                _ => continue,
            },
        };
        let problem = problems::scenario(snapshot, path, text)?;
        if problem.reads(file) {
            out.push(problem);
        }
    }
    Ok(out)
}

/// Where scenarios mention what is declared at a place of a specification.
pub(crate) fn mentions(
    snapshot: &Snapshot,
    at: &FilePosition,
) -> Cancellable<Vec<(Utf8PathBuf, Range<usize>)>> {
    let mut out = Vec::new();
    if is(&at.path) {
        return Ok(out);
    }
    let scenarios = scenarios_using(snapshot, &at.path)?;
    if scenarios.is_empty() {
        return Ok(out);
    }
    let Some(found) = snapshot.analysis.goto_definition(at)? else {
        return Ok(out);
    };
    for problem in scenarios {
        let specs = problem.specs();
        let references = Names::new(&specs).references(&problem.scenario);
        for reference in references {
            let Some(place) = declaration(snapshot, &problem, &reference.target)? else {
                continue;
            };
            let same = |it: &dotgen_analysis::ide::NavTarget| {
                it.path == place.path && it.focus_range == place.range
            };
            if found.info.iter().any(same) {
                out.push((problem.path.clone(), reference.range));
            }
        }
    }
    Ok(out)
}

/// Edits that let scenarios follow a rename.
pub(crate) fn renames(
    snapshot: &Snapshot,
    at: &FilePosition,
    new_name: &str,
) -> Cancellable<Vec<FileEdit>> {
    let mentions = mentions(snapshot, at)?.into_iter();
    let edits = mentions.map(|(path, range)| FileEdit {
        path,
        range,
        new_text: new_name.to_owned(),
    });
    Ok(edits.collect())
}
