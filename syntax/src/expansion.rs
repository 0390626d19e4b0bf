//! Texts and origins of the zero-width tokens of a tree.
//!
//! A token that exists only after macro expansion is in the tree with an empty text, so that the text of the
//! tree is the text of the file. Its spelling and origin are kept here, found by the place of the token in
//! the tree: the indexes of its ancestors among their siblings, and its own.
//!
//! Two empty tokens of one kind at one offset compare equal as `SyntaxToken`s: never use equality or node
//! pointers to distinguish them.

use smol_str::SmolStr;

use crate::{
    SyntaxToken, TextRange, TextSize,
    preproc::{Origin, VirtualToken},
};

/// The virtual tokens of one tree.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ExpansionMap {
    /// In tree order; offsets ascend.
    tokens: Vec<Entry>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Entry {
    offset: TextSize,
    /// Indexes among siblings, from below the root down to the token.
    path: Box<[u32]>,
    token: VirtualToken,
    call: TextRange,
}

impl ExpansionMap {
    /// Returns true if the file uses no macro.
    pub fn is_empty(&self) -> bool {
        self.tokens.is_empty()
    }

    /// The text of a token: its own, or the text from the macro.
    pub fn text(&self, token: &SyntaxToken) -> SmolStr {
        match self.entry(token) {
            Some(entry) => entry.token.text.clone(),
            None => unsplice(token.text()),
        }
    }

    /// The virtual token behind an empty token of the tree.
    pub fn virtual_token(&self, token: &SyntaxToken) -> Option<&VirtualToken> {
        self.entry(token).map(|entry| &entry.token)
    }

    /// The origin of the spelling of a virtual token.
    pub fn origin(&self, token: &SyntaxToken) -> Option<&Origin> {
        self.entry(token).map(|entry| &entry.token.origin)
    }

    /// The range to report for a token: its own, or the macro call that produced it.
    pub fn range(&self, token: &SyntaxToken) -> TextRange {
        self.entry(token).map_or_else(|| token.text_range(), |entry| entry.call)
    }

    /// The virtual tokens that a macro call produced.
    pub fn expansion(&self, call: TextRange) -> impl Iterator<Item = &VirtualToken> {
        let start = self.tokens.partition_point(|token| token.call.start() < call.start());
        self.tokens[start..]
            .iter()
            .take_while(move |token| token.call == call)
            .map(|token| &token.token)
    }

    /// Adds the next virtual token of the tree, which is at this path, and the range of its call.
    pub(crate) fn push(&mut self, path: &[u32], token: VirtualToken, call: TextRange) {
        self.tokens.push(Entry { offset: call.end(), path: path.into(), token, call });
    }

    fn entry(&self, token: &SyntaxToken) -> Option<&Entry> {
        if self.tokens.is_empty() || !token.text_range().is_empty() {
            return None;
        }
        let offset = token.text_range().start();
        let mut path: Vec<u32> = std::iter::once(token.index())
            .chain(token.parent_ancestors().map(|ancestor| ancestor.index()))
            .map(|place| place as u32)
            .collect();
        // The root is not in any list of siblings.
        path.pop();
        path.reverse();
        let found = self
            .tokens
            .binary_search_by(|token| (token.offset, &*token.path).cmp(&(offset, &*path)));
        found.ok().map(|token| &self.tokens[token])
    }
}

/// A text without the line joins (a backslash and a line end) inside it.
fn unsplice(text: &str) -> SmolStr {
    if !text.contains(['\n', '\r']) || !text.contains('\\') {
        return SmolStr::new(text);
    }
    ["\\\r\n", "\\\n", "\\\r"]
        .iter()
        .fold(text.to_owned(), |text, splice| text.replace(splice, ""))
        .into()
}
