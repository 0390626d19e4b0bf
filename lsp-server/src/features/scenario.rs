//! Scenarios (`.scn`). The language itself is in `dotgen_timing::scn`. This module applies it to documents
//! and positions.

mod text;
mod tokens;

use std::ops::Range;

use camino::Utf8Path;
use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide::FilePosition;
use dotgen_analysis::language;
use dotgen_analysis::markdown;
use dotgen_codegen::codels::edit::Edit;
use dotgen_timing::scn::complete::{self, CompletionKind as Kind, Completions};
use dotgen_timing::scn::names::{Names, Reference};
use dotgen_timing::scn::outline::{self, EntryKind};
use dotgen_timing::scn::{self, describe};

use super::codels::judged_actions;
use super::convert::edit::is_wanted;
use super::language::LanguageFeatures;
use super::mentions::declaration;
use super::specification::{code_action, completion, references, rename};
use super::verification::problems;
use crate::protocol::convert::Lines;
use crate::protocol::convert::position::touches;
use crate::protocol::convert::symbol::{Symbol, response};
use crate::protocol::types::{self, *};
use crate::protocol::user_result::UserResult;
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};
use dotgen_views::verification::Problem;
use dotgen_views::verification::problem;

/// The features of scenarios.
pub(crate) const FEATURES: LanguageFeatures = LanguageFeatures {
    diagnostics,
    is_own: true,
    symbols,
    definition,
    references,
    highlights,
    hover,
    completion,
    prepare_rename,
    rename,
    lenses: super::runs::scenario_lenses,
    links,
    actions,
    folds: text::folds,
    selections: text::selections,
    format: text::format,
    format_range: text::format_range,
    tokens: tokens::full,
    tokens_in: tokens::range,
    ..LanguageFeatures::NONE
};

/// The present text of a scenario, with the position of the cursor.
struct Cursor {
    problem: Problem,
    offset: usize,
    lines: std::sync::Arc<Lines>,
}

impl Cursor {
    fn new(snapshot: &Snapshot, subject: &Subject, position: Position) -> Answer<Cursor> {
        let at = snapshot.at(subject, position)?;
        let lines = snapshot.text_lines(&subject.path)?;
        Ok(Cursor { problem: read(snapshot, &subject.path)?, offset: at.offset, lines })
    }

    fn touches(&self, range: &Range<usize>) -> bool {
        range.start <= self.offset && self.offset <= range.end
    }

    /// The name of a specification, client or status under the cursor.
    fn reference(&self) -> Option<Reference> {
        let specs = self.problem.specs();
        let names = Names::new(&specs);
        let mut all = names.references(&self.problem.scenario).into_iter();
        all.find(|reference| self.touches(&reference.range))
    }
}

fn read(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Problem> {
    let text = match snapshot.analysis.text(path)? {
        Some(text) => text.to_string(),
        None => String::new(),
    };
    problems::scenario(snapshot, path, text)
}

/// Findings about syntax, files and names, and the results of the verifier if they are of this text.
fn diagnostics(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Vec<Diagnostic>> {
    let problem = read(snapshot, path)?;
    let (mut out, mut elsewhere): (Vec<Diagnostic>, Vec<Diagnostic>) =
        (problem.errors.iter().cloned()).partition(|error| error.path == path);
    elsewhere.extend(problem.warnings.iter().cloned());
    // Errors of a specification are reported in that specification. Here one diagnostic says that there are
    // some.
    elsewhere.dedup_by(|a, b| a.path == b.path);
    for mut diagnostic in elsewhere {
        let file = diagnostic.path.file_name().unwrap_or("a specification");
        diagnostic.message = match diagnostic.severity {
            Severity::Error => format!("`{file}` has errors: {}", diagnostic.message).into(),
            _ => format!("`{file}`: {}", diagnostic.message).into(),
        };
        let used = problem::named(&problem.scenario, path);
        let used = used.into_iter().find(|used| used.path == diagnostic.path);
        diagnostic.range = used.map_or(problem.scenario.name_range.clone(), |file| file.range);
        diagnostic.path = path.to_owned();
        diagnostic.fixes.clear();
        diagnostic.related.clear();
        out.push(diagnostic);
    }
    if out.iter().all(|diagnostic| diagnostic.severity != Severity::Error) {
        // Names are checked even if verification is off.
        let known = super::verification::in_scenario(snapshot, path);
        let specs = problem.specs();
        let names = Names::new(&specs);
        for unknown_name in names.unknown_names(&problem.scenario) {
            if !known.iter().any(|known| known.range == unknown_name.range) {
                out.push(problem::diagnostic(&unknown_name, path));
            }
        }
        out.extend(known);
    }
    Ok(out)
}

/// Links to the specifications that a scenario uses.
fn links(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentLinkParams,
) -> Answer<Option<Vec<DocumentLink>>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let problem = read(snapshot, &subject.path)?;
    let files = problem::named(&problem.scenario, &subject.path);
    let links = files.into_iter().map(|file| DocumentLink {
        // Inside the quotes.
        range: lines.range(&(file.range.start + 1..file.range.end - 1)),
        target: snapshot.uri(&file.path),
        tooltip: Some(file.path.to_string()),
        data: None,
    });
    Ok(Some(links.collect()))
}

/// The fixes of the findings at a place, and the actions of the verifier.
fn actions(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &CodeActionParams,
) -> Answer<Option<CodeActionResponse>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let range = lines.clamped(params.range).ok_or(Stop::Nothing)?;
    let actions = judged_actions::offers(snapshot, &subject.path, |offers| {
        let mut actions = super::verification::actions(snapshot, subject, &range, offers)?;
        for finding in diagnostics(snapshot, &subject.path)? {
            if touches(&finding.range, &range) {
                for fix in &finding.fixes {
                    let action = code_action::without_edit(snapshot, &finding, fix, true)?;
                    // The judge knows only findings about specifications and codels.
                    actions.extend(offers.action(action, &Edit::of(&fix.edits), None)?);
                }
            }
        }
        actions.retain(|action| match action {
            CodeActionOrCommand::CodeAction(action) => {
                let kind = action.kind.as_ref();
                kind.is_none_or(|kind| is_wanted(params, kind))
            }
            CodeActionOrCommand::Command(_) => true,
        });
        Ok(actions)
    })?;
    Ok(Some(actions))
}

/// The declaration of a name in a path, or the file of a `use`.
fn definition(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &GotoDefinitionParams,
) -> Answer<Option<GotoDefinitionResponse>> {
    let position = params.text_document_position_params.position;
    let cursor = Cursor::new(snapshot, subject, position)?;
    let files = problem::named(&cursor.problem.scenario, &subject.path);
    if let Some(file) = files.into_iter().find(|file| cursor.touches(&file.range)) {
        return Ok(snapshot.location(&file.path, &(0..0))?.map(|location| vec![location].into()));
    }
    let reference = cursor.reference().ok_or(Stop::Nothing)?;
    let declared = declaration(snapshot, &cursor.problem, &reference.target)?;
    let place = declared.ok_or(Stop::Nothing)?;
    let location = snapshot.location(&place.path, &place.range)?;
    Ok(location.map(|location| vec![location].into()))
}

fn hover(snapshot: &Snapshot, subject: &Subject, params: &HoverParams) -> Answer<Option<Hover>> {
    let position = params.text_document_position_params.position;
    let cursor = Cursor::new(snapshot, subject, position)?;
    let Problem { text, scenario, .. } = &cursor.problem;
    let specs = cursor.problem.specs();
    let names = Names::new(&specs);
    let found = describe::describe(text, scenario, &names, cursor.offset);
    Ok(found.map(|description| Hover {
        contents: HoverContents::Markup(if snapshot.client.markdown_hover {
            MarkupContent {
                kind: MarkupKind::Markdown,
                value: format!(
                    "{}\n{}",
                    markdown::block("", &description.form),
                    description.meaning
                ),
            }
        } else {
            MarkupContent {
                kind: MarkupKind::PlainText,
                value: format!("{}\n{}", description.form, description.meaning),
            }
        }),
        range: Some(cursor.lines.range(&description.range)),
    }))
}

fn completion(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &CompletionParams,
) -> Answer<Option<CompletionResponse>> {
    if !completion::is_wanted(snapshot, subject, params)? {
        return Err(Stop::Nothing);
    }
    let position = params.text_document_position.position;
    let cursor = Cursor::new(snapshot, subject, position)?;
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
            detail: Some(detail).filter(|detail| !detail.is_empty()),
            sort_text: Some(format!("{order:05}")),
            ..CompletionItem::default()
        };
    let items = match complete::complete(text, scenario, &names, cursor.offset) {
        Completions::File(range) => {
            let files = files(snapshot, &subject.path);
            let items = files.into_iter().enumerate();
            let kind = CompletionItemKind::FILE;
            items.map(|(i, file)| item(i, file, kind, String::new(), &range)).collect()
        }
        Completions::Of { replace, items } => {
            let items = items.into_iter().enumerate();
            items
                .map(|(i, completion)| {
                    item(
                        i,
                        completion.label,
                        item_kind(completion.kind),
                        completion.detail,
                        &replace,
                    )
                })
                .collect()
        }
    };
    Ok(Some(CompletionResponse::List(CompletionList { is_incomplete: false, items })))
}

/// Specifications of the workspace, in the form that `use` names them.
fn files(snapshot: &Snapshot, path: &Utf8Path) -> Vec<String> {
    let Some(directory) = path.parent() else {
        return Vec::new();
    };
    // The folder of the scenario is read directly: its files are known before the workspace is listed, and
    // without a workspace.
    let beside = directory.read_dir_utf8().into_iter().flatten();
    let beside = beside.filter_map(|beside| Some(beside.ok()?.into_path()));
    let specifications = snapshot.roots.iter().cloned().chain(beside);
    let specifications = specifications.filter(|path| language::is_specification(path));
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
    names.sort_by_key(|name| (name.matches("../").count(), name.clone()));
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

fn symbols(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentSymbolParams,
) -> Answer<Option<DocumentSymbolResponse>> {
    let text = snapshot.analysis.text(&subject.path)?.ok_or(Stop::Nothing)?;
    let lines = snapshot.text_lines(&subject.path)?;
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

fn symbol(entry: outline::Entry) -> Symbol {
    Symbol {
        name: entry.name,
        detail: None,
        kind: symbol_kind(entry.kind),
        range: entry.range,
        selection: entry.selection,
        children: entry.children.into_iter().map(symbol).collect(),
    }
}

/// The other mentions in this scenario of the name under the cursor.
fn highlights(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &DocumentHighlightParams,
) -> Answer<Option<Vec<DocumentHighlight>>> {
    let position = params.text_document_position_params.position;
    let cursor = Cursor::new(snapshot, subject, position)?;
    let reference = cursor.reference().ok_or(Stop::Nothing)?;
    let specs = cursor.problem.specs();
    let all = Names::new(&specs).references(&cursor.problem.scenario);
    let same = all.into_iter().filter(|other| other.target == reference.target);
    let ranges = same.map(|reference| DocumentHighlight {
        range: cursor.lines.range(&reference.range),
        kind: Some(DocumentHighlightKind::READ),
    });
    Ok(Some(ranges.collect()))
}

/// The declaration, in a specification, of the name under the cursor of a scenario. The handlers of
/// specifications continue from there.
fn declared_at(
    snapshot: &Snapshot,
    subject: &Subject,
    position: Position,
) -> Answer<(FilePosition, types::Range, String)> {
    let cursor = Cursor::new(snapshot, subject, position)?;
    let reference = cursor.reference().ok_or(Stop::Nothing)?;
    let place = declaration(snapshot, &cursor.problem, &reference.target)?.ok_or(Stop::Nothing)?;
    let text = cursor.problem.text.get(reference.range.clone());
    let at = FilePosition { path: place.path, offset: place.range.start };
    let range = cursor.lines.range(&reference.range);
    Ok((at, range, text.unwrap_or_default().to_owned()))
}

/// The mentions of the declaration that a name in a scenario refers to.
fn references(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &ReferenceParams,
) -> Answer<Option<Vec<Location>>> {
    let position = params.text_document_position.position;
    let (at, ..) = declared_at(snapshot, subject, position)?;
    Ok(references::of(snapshot, &at, params.context.include_declaration)?)
}

/// The range of a name that can be renamed. Names that a scenario declares itself cannot be renamed: they are
/// not in a specification.
fn prepare_rename(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &TextDocumentPositionParams,
) -> Answer<UserResult<PrepareRenameResponse>> {
    let (at, range, placeholder) = declared_at(snapshot, subject, params.position)?;
    if language::is_scenario(&at.path) {
        return Err(Stop::Nothing);
    }
    Ok(UserResult(match snapshot.analysis.prepare_rename(&at)? {
        Ok(_) => Ok(Some(PrepareRenameResponse::RangeWithPlaceholder { range, placeholder })),
        Err(error) => Err(error.0),
    }))
}

/// Renames the declaration that a name in a scenario refers to.
fn rename(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &RenameParams,
) -> Answer<UserResult<WorkspaceEdit>> {
    let (at, ..) = declared_at(snapshot, subject, params.text_document_position.position)?;
    if language::is_scenario(&at.path) {
        return Err(Stop::Nothing);
    }
    Ok(rename::rename_at(snapshot, &at, &params.new_name)?)
}
