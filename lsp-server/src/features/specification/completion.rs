//! `textDocument/completion` and `completionItem/resolve`

mod typed;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::elab::DefId;
use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide::{self, CompletionKind, plain_snippet};
use serde::{Deserialize, Serialize};

use crate::features::codels::{self, Texts};
use crate::protocol::convert::Lines;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};

/// The data of a proposal that is resolved later.
#[derive(Debug, Serialize, Deserialize)]
struct Data {
    path: Utf8PathBuf,
    definition: DefId,
    name: String,
}

/// True if a typed character asks for proposals.
pub(crate) fn is_wanted(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &CompletionParams,
) -> Cancellable<bool> {
    let position = params.text_document_position.position;
    let lines = snapshot.lines(&subject.path)?;
    Ok(lines.is_none_or(|line| typed::wanted(params.context.as_ref(), &line, position)))
}

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &CompletionParams,
) -> Answer<Option<CompletionResponse>> {
    let position = params.text_document_position.position;
    if !is_wanted(snapshot, subject, params)? {
        return Err(Stop::Nothing);
    }
    let at = snapshot.at(subject, position)?;
    let lines = snapshot.text_lines(&subject.path)?;
    let mut items = snapshot.analysis.completions(&at)?;
    functions(snapshot, &at, &mut items)?;
    let convert = (0..).zip(items).map(|(order, completion)| {
        let data = data(&subject.path, &completion);
        CompletionItem { data, ..to_proto(snapshot, &lines, completion, order) }
    });
    Ok(Some(CompletionResponse::List(CompletionList {
        is_incomplete: false,
        items: convert.collect(),
    })))
}

/// Proposals for the name of a codel: the functions in the sources that no specification names, with their
/// parameters.
fn functions(
    snapshot: &Snapshot,
    at: &ide::FilePosition,
    items: &mut Vec<ide::CompletionItem>,
) -> Cancellable<()> {
    let Some((item, place)) = items
        .iter()
        .find_map(|completion_item| Some((completion_item.clone(), completion_item.codel?)))
    else {
        return Ok(());
    };
    let texts = Texts::new(snapshot);
    for compared in codels::around(snapshot, &at.path)? {
        for folder in compared.folders() {
            let all = folder.expected();
            for (file, function) in folder.unnamed(&all) {
                let name = function.name.to_string();
                if items.iter().any(|completion_item| completion_item.label == name) {
                    continue;
                }
                let stubs = codels::stub_options(folder, &texts);
                let parameters = all.iter().find_map(|expected| {
                    let repairs = codels::repairs(folder, expected, &texts, &stubs);
                    let owner = repairs.owner_at(&at.path, at.offset)?;
                    Some(repairs.parameters_of(function, owner).join(", "))
                });
                let insert = if place.parameters {
                    format!("{name}(${{1:{}}}){}", parameters.unwrap_or_default(), place.tail)
                } else {
                    name.clone()
                };
                items.push(ide::CompletionItem {
                    label: name,
                    insert,
                    detail: file.path.file_name().map(|name| format!("function in {name}")),
                    // Ranked before the generated name.
                    rank: 0,
                    ..item.clone()
                });
            }
        }
    }
    items.sort_by_key(|completion_item| {
        (completion_item.rank, completion_item.codel.is_some() && completion_item.detail.is_none())
    });
    texts.check()
}

/// The data with which a proposal is resolved.
fn data(path: &Utf8Path, completion: &ide::CompletionItem) -> Option<serde_json::Value> {
    let data = Data {
        path: path.to_owned(),
        definition: completion.definition?,
        name: completion.name.as_ref()?.to_string(),
    };
    serde_json::to_value(data).ok()
}

fn to_proto(
    snapshot: &Snapshot,
    lines: &Lines,
    completion_item: ide::CompletionItem,
    order: usize,
) -> CompletionItem {
    let snippets = snapshot.client.snippets;
    let new_text = if completion_item.snippet && !snippets {
        plain_snippet(&completion_item.insert)
    } else {
        completion_item.insert
    };
    CompletionItem {
        label: completion_item.label,
        kind: Some(kind(completion_item.kind)),
        detail: completion_item.detail,
        filter_text: completion_item.filter,
        sort_text: Some(format!("{:02}{order:05}", completion_item.rank)),
        insert_text_format: Some(if completion_item.snippet && snippets {
            InsertTextFormat::SNIPPET
        } else {
            InsertTextFormat::PLAIN_TEXT
        }),
        text_edit: Some(CompletionTextEdit::Edit(TextEdit::new(
            lines.range(&completion_item.replace),
            new_text,
        ))),
        ..CompletionItem::default()
    }
}

fn kind(kind: CompletionKind) -> CompletionItemKind {
    use dotgen_analysis::ide::SymbolKind as Kind;
    match kind {
        CompletionKind::Keyword => CompletionItemKind::KEYWORD,
        CompletionKind::Snippet => CompletionItemKind::SNIPPET,
        CompletionKind::BaseType => CompletionItemKind::TYPE_PARAMETER,
        CompletionKind::Unit => CompletionItemKind::UNIT,
        CompletionKind::Directory => CompletionItemKind::FOLDER,
        CompletionKind::Package => CompletionItemKind::MODULE,
        CompletionKind::Symbol(kind) => match kind {
            Kind::File => CompletionItemKind::FILE,
            Kind::Macro | Kind::Const => CompletionItemKind::CONSTANT,
            Kind::Module => CompletionItemKind::MODULE,
            Kind::Component => CompletionItemKind::CLASS,
            Kind::Interface | Kind::Remote => CompletionItemKind::INTERFACE,
            Kind::Ids | Kind::Struct | Kind::Union | Kind::Exception => CompletionItemKind::STRUCT,
            Kind::Enum => CompletionItemKind::ENUM,
            Kind::Enumerator => CompletionItemKind::ENUM_MEMBER,
            Kind::Typedef | Kind::Native => CompletionItemKind::TYPE_PARAMETER,
            Kind::Member => CompletionItemKind::FIELD,
            Kind::Task => CompletionItemKind::VALUE,
            Kind::Port => CompletionItemKind::PROPERTY,
            Kind::Attribute | Kind::Function | Kind::Activity => CompletionItemKind::METHOD,
            Kind::Parameter | Kind::Local => CompletionItemKind::VARIABLE,
            Kind::Codel => CompletionItemKind::FUNCTION,
            Kind::State => CompletionItemKind::EVENT,
        },
    }
}

/// Adds documentation to a proposal.
pub(crate) fn resolve(
    snapshot: &Snapshot,
    item: &CompletionItem,
) -> Cancellable<Option<CompletionItem>> {
    let data = item.data.clone().map(serde_json::from_value::<Data>);
    let Some(Ok(data)) = data else {
        return Ok(None);
    };
    let doc = snapshot.analysis.resolve_completion(&data.path, data.definition, &data.name)?;
    let documentation = doc.map(|doc| {
        Documentation::MarkupContent(MarkupContent {
            kind: if snapshot.client.markdown_hover {
                MarkupKind::Markdown
            } else {
                MarkupKind::PlainText
            },
            value: doc.markdown,
        })
    });
    Ok(Some(CompletionItem { documentation, ..item.clone() }))
}
