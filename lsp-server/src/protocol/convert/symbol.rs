//! Symbols of documents.

use std::ops::Range;

use dotgen_analysis::ide::{self, AccessKind, SymbolKind as Kind};

use super::Lines;
use crate::protocol::types::{
    DocumentHighlightKind, DocumentSymbol, DocumentSymbolResponse, Location, SymbolInformation,
    SymbolKind, Uri,
};

/// A symbol with the symbols inside it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Symbol {
    pub name: String,
    /// The text shown after the name.
    pub detail: Option<String>,
    pub kind: SymbolKind,
    /// The range of the whole declaration.
    pub range: Range<usize>,
    /// The range of its name.
    pub selection: Range<usize>,
    /// The symbols inside it.
    pub children: Vec<Symbol>,
}

impl From<ide::DocumentSymbol> for Symbol {
    fn from(symbol: ide::DocumentSymbol) -> Symbol {
        Symbol {
            name: symbol.name,
            detail: symbol.detail,
            kind: kind(symbol.kind),
            range: symbol.range,
            selection: symbol.selection_range,
            children: symbol.children.into_iter().map(Symbol::from).collect(),
        }
    }
}

/// The symbols of a document: nested, or a flat list with the name of each container.
pub fn response(
    symbols: impl Iterator<Item = Symbol>,
    hierarchical: bool,
    uri: &Uri,
    lines: &Lines,
) -> DocumentSymbolResponse {
    if hierarchical {
        return DocumentSymbolResponse::Nested(
            symbols.map(|symbol| nested(symbol, lines)).collect(),
        );
    }
    let mut flat = Vec::new();
    for symbol in symbols {
        flatten(symbol, None, uri, lines, &mut flat);
    }
    DocumentSymbolResponse::Flat(flat)
}

fn nested(symbol: Symbol, lines: &Lines) -> DocumentSymbol {
    let children = symbol.children.into_iter().map(|child| nested(child, lines));
    #[allow(deprecated, reason = "the field has to be given")]
    DocumentSymbol {
        children: Some(children.collect()),
        name: symbol.name,
        detail: symbol.detail,
        kind: symbol.kind,
        tags: None,
        deprecated: None,
        range: lines.range(&symbol.range),
        selection_range: lines.range(&symbol.selection),
    }
}

fn flatten(
    symbol: Symbol,
    container: Option<&str>,
    uri: &Uri,
    lines: &Lines,
    out: &mut Vec<SymbolInformation>,
) {
    #[allow(deprecated, reason = "the field has to be given")]
    out.push(SymbolInformation {
        name: symbol.name.clone(),
        kind: symbol.kind,
        tags: None,
        deprecated: None,
        location: Location::new(uri.clone(), lines.range(&symbol.range)),
        container_name: container.map(str::to_owned),
    });
    for child in symbol.children {
        flatten(child, Some(&symbol.name), uri, lines, out);
    }
}

/// The most similar kind of the protocol.
pub fn kind(kind: Kind) -> SymbolKind {
    match kind {
        Kind::File => SymbolKind::FILE,
        Kind::Macro | Kind::Const => SymbolKind::CONSTANT,
        Kind::Module => SymbolKind::NAMESPACE,
        Kind::Component => SymbolKind::CLASS,
        Kind::Interface | Kind::Remote => SymbolKind::INTERFACE,
        Kind::Ids | Kind::Struct | Kind::Union | Kind::Exception => SymbolKind::STRUCT,
        Kind::Enum => SymbolKind::ENUM,
        Kind::Enumerator => SymbolKind::ENUM_MEMBER,
        Kind::Typedef | Kind::Native => SymbolKind::TYPE_PARAMETER,
        Kind::Member => SymbolKind::FIELD,
        Kind::Task => SymbolKind::OBJECT,
        Kind::Port => SymbolKind::PROPERTY,
        Kind::Attribute | Kind::Function | Kind::Activity => SymbolKind::METHOD,
        Kind::Parameter | Kind::Local => SymbolKind::VARIABLE,
        Kind::Codel => SymbolKind::FUNCTION,
        Kind::State => SymbolKind::EVENT,
    }
}

/// The kind of a highlight, for a read or a write.
pub fn highlight(access: AccessKind) -> DocumentHighlightKind {
    match access {
        AccessKind::Declaration | AccessKind::Mention => DocumentHighlightKind::TEXT,
        AccessKind::Read => DocumentHighlightKind::READ,
        AccessKind::Write | AccessKind::ReadWrite => DocumentHighlightKind::WRITE,
    }
}
