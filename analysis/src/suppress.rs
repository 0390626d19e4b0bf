//! Findings allowed by a comment: `// dotgen: allow(code, …) because …`.
//!
//! A comment on a line of its own allows the findings in the declaration below it; at the end of a
//! line, those in the declaration that begins on that line. Errors cannot be allowed. A comment that
//! allows nothing, or gives no reason, is reported itself.

use std::sync::Arc;

use dotgen_syntax::{
    NodeOrToken, SyntaxKind, SyntaxNode, SyntaxToken, TextRange, TextSize,
    ast::{self, AstNode, support},
};

use crate::{
    base::Db,
    unit::{FileKey, parsed},
};

/// One comment that allows findings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Suppression {
    pub(crate) comment: TextRange,
    /// The range in which findings are allowed.
    pub(crate) scope: TextRange,
    /// Each code, with its place.
    pub(crate) codes: Vec<(String, TextRange)>,
    /// True if it gives a reason.
    pub(crate) has_reason: bool,
}

/// The comments of a file that allow findings, in text order.
#[salsa::tracked]
pub(crate) fn suppressions<'db>(db: &'db dyn Db, key: FileKey<'db>) -> Arc<Vec<Suppression>> {
    // Most files have none: check before walking the tree.
    if !key.file(db).text(db).contains(MARK) {
        return Arc::default();
    }
    let root = parsed(db, key).syntax();
    let tokens = root.descendants_with_tokens().filter_map(NodeOrToken::into_token);
    Arc::new(tokens.filter_map(|token| suppression(&token)).collect())
}

/// The beginning of a comment for dotgen.
pub(crate) const MARK: &str = "dotgen:";

fn suppression(comment: &SyntaxToken) -> Option<Suppression> {
    if !matches!(comment.kind(), SyntaxKind::LINE_COMMENT | SyntaxKind::BLOCK_COMMENT) {
        return None;
    }
    let text = comment.text();
    let start = text.find(MARK)? + MARK.len();
    let rest = text[start..].trim_start();
    let open = text.len() - rest.len();
    let list = rest.strip_prefix("allow(")?;
    let (list, reason) = list.split_once(')')?;
    let mut at = open + "allow(".len();
    let mut codes = Vec::new();
    for piece in list.split(',') {
        let code = piece.trim();
        let from = at + (piece.len() - piece.trim_start().len());
        if !code.is_empty() {
            let range = TextRange::at(size(from), size(code.len())) + comment.text_range().start();
            codes.push((code.to_owned(), range));
        }
        at += piece.len() + 1;
    }
    let reason = reason
        .trim_end_matches("*/")
        .trim_matches(|c: char| c.is_whitespace() || c == '-' || c == ':');
    Some(Suppression {
        comment: comment.text_range(),
        scope: scope(comment)?,
        codes,
        has_reason: !reason.is_empty(),
    })
}

fn size(offset: usize) -> TextSize {
    TextSize::try_from(offset).unwrap_or_else(|_| TextSize::from(u32::MAX))
}

/// The declaration that a comment applies to.
fn scope(comment: &SyntaxToken) -> Option<TextRange> {
    let on_own_line = is_on_own_line(comment);
    let item = if on_own_line {
        // The first declaration that begins after the comment.
        let next = std::iter::successors(comment.next_token(), SyntaxToken::next_token)
            .find(support::is_text)?;
        outermost_item_at(&next)?
    } else {
        // The declaration that begins on this line, or else the one around it.
        let first = std::iter::successors(comment.prev_token(), SyntaxToken::prev_token)
            .take_while(|token| !token.text().contains('\n'))
            .filter(support::is_text)
            .last()?;
        outermost_item_at(&first).or_else(|| {
            first.parent_ancestors().find(|ancestor| ast::Item::can_cast(ancestor.kind()))
        })?
    };
    Some(item.text_range())
}

/// Returns true if only blanks stand before a comment on its line.
fn is_on_own_line(comment: &SyntaxToken) -> bool {
    let mut before = comment.prev_token();
    while let Some(token) = before {
        if token.text().contains(['\n', '\r']) {
            return true;
        }
        if support::is_text(&token) {
            return false;
        }
        before = token.prev_token();
    }
    true
}

/// The largest declaration whose first real token this is.
fn outermost_item_at(token: &SyntaxToken) -> Option<SyntaxNode> {
    let begins = |node: &SyntaxNode| {
        support::first_text_token(node)
            .is_some_and(|other| other.text_range() == token.text_range())
    };
    token
        .parent_ancestors()
        .filter(|ancestor| ast::Item::can_cast(ancestor.kind()))
        .take_while(begins)
        .last()
}
