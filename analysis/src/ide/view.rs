//! One file in the unit that serves it.

use dotgen_syntax::preproc::Preprocessed;
use dotgen_syntax::{ExpansionMap, Parse, SyntaxNode, TextRange, lexer::RawTokens};

use crate::{
    base::{Db, SourceFile, lexed},
    elab::Elaborated,
    item_tree::lower::{node_range, token_range},
    model::Src,
    queries::elaborated,
    source_map::ptr,
    unit::{FileKey, UnitKey, parsed, preprocessed, ranges, serving_unit, serving_visit, visits},
};

/// A file in its unit.
pub(crate) struct FileView<'db> {
    pub(crate) db: &'db dyn Db,
    pub(crate) file: SourceFile,
    pub(crate) unit: UnitKey<'db>,
    pub(crate) key: FileKey<'db>,
}

impl<'db> FileView<'db> {
    /// The view of a file; `None` if it has no text.
    pub(crate) fn new(db: &'db dyn Db, file: SourceFile) -> Option<FileView<'db>> {
        if !file.status(db).is_text() {
            return None;
        }
        let unit = serving_unit(db, file);
        let (_, key) = serving_visit(db, unit, file)?;
        Some(FileView { db, file, unit, key })
    }

    pub(crate) fn text(&self) -> &'db str {
        self.file.text(self.db)
    }

    pub(crate) fn parse(&self) -> &'db Parse {
        parsed(self.db, self.key)
    }

    pub(crate) fn map(&self) -> &'db ExpansionMap {
        &self.parse().expansion
    }

    pub(crate) fn root(&self) -> SyntaxNode {
        self.parse().syntax()
    }

    pub(crate) fn pre(&self) -> &'db Preprocessed {
        preprocessed(self.db, self.key)
    }

    pub(crate) fn raw(&self) -> &'db RawTokens {
        &lexed(self.db, self.file).raw
    }

    pub(crate) fn elaborated(&self) -> &'db Elaborated {
        elaborated(self.db, self.unit)
    }

    /// The range of a node, without trivia.
    pub(crate) fn node_range(&self, node: &SyntaxNode) -> TextRange {
        node_range(node, self.map(), self.raw())
    }

    /// The range of a token, or of the text it was expanded from.
    pub(crate) fn token_range(&self, token: &dotgen_syntax::SyntaxToken) -> TextRange {
        token_range(token, self.map(), self.raw())
    }

    /// The place of an id of the unit.
    pub(crate) fn place(&self, src: Src) -> Option<(SourceFile, TextRange)> {
        place(self.db, self.unit, src)
    }
}

/// The place of an id of a unit.
pub(crate) fn place<'db>(
    db: &'db dyn Db,
    unit: UnitKey<'db>,
    src: Src,
) -> Option<(SourceFile, TextRange)> {
    let key = visits(db, unit).of(src.visit)?.key;
    Some((key.file(db), ranges(db, key).get(ptr(src))?))
}
