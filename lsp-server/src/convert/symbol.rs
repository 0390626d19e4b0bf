//! Kinds of symbols.

use dotgen_analysis::ide::{AccessKind, SymbolKind as Kind};

use crate::proto::{DocumentHighlightKind, SymbolKind};

/// The protocol's nearest kind.
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

/// Reads and writes as editors colour them.
pub fn highlight(access: AccessKind) -> DocumentHighlightKind {
    match access {
        AccessKind::Declaration | AccessKind::Mention => DocumentHighlightKind::TEXT,
        AccessKind::Read => DocumentHighlightKind::READ,
        AccessKind::Write | AccessKind::ReadWrite => DocumentHighlightKind::WRITE,
    }
}
