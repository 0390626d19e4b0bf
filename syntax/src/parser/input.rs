//! The input of the parser: the kinds of the real and virtual tokens of a file.

use std::borrow::Cow;

use rowan::{TextRange, TextSize};

use crate::{
    kind::SyntaxKind::{self, *},
    lexer::RawTokens,
    line_index::line_start,
    preproc::Element,
};

/// The tokens of one file as the grammar sees them.
pub(crate) struct Input<'a> {
    text: &'a str,
    raw: &'a RawTokens,
    elements: &'a [Element],
    /// Kind of each token; identifiers that may be keywords are `IDENT` here.
    kinds: Vec<SyntaxKind>,
    /// The contextual keyword that each token may be; its kind for all others.
    contextual: Vec<SyntaxKind>,
    /// Index of the element of each token.
    sources: Vec<u32>,
    /// Tokens with an `#include` between them and the token before, ascending.
    after_include: Vec<u32>,
    /// For each token, the number of `}` from there on that close nothing opened there; empty if all braces
    /// are paired.
    closing: Vec<u32>,
}

impl<'a> Input<'a> {
    /// The grammar's tokens among `elements`. `is_include` returns true for the directives that are
    /// `#include`s.
    pub(crate) fn new(
        text: &'a str,
        raw: &'a RawTokens,
        elements: &'a [Element],
        is_include: impl Fn(u32) -> bool,
    ) -> Input<'a> {
        let mut input = Input {
            text,
            raw,
            elements,
            kinds: Vec::with_capacity(elements.len() / 2),
            contextual: Vec::with_capacity(elements.len() / 2),
            sources: Vec::with_capacity(elements.len() / 2),
            after_include: Vec::new(),
            closing: Vec::new(),
        };
        for (index, element) in elements.iter().enumerate() {
            match element {
                Element::Real(i) => {
                    let kind = raw.kind(*i as usize);
                    input.push(kind, raw.text(text, *i as usize), index);
                }
                Element::Virtual(token) => input.push(token.kind, &token.text, index),
                Element::Directive { index, .. } if is_include(*index) => {
                    let next = input.kinds.len() as u32;
                    if input.after_include.last() != Some(&next) {
                        input.after_include.push(next);
                    }
                }
                _ => {}
            }
        }
        if !input.is_paired() {
            input.count_closing();
        }
        input
    }

    /// Returns true if each `{` has its `}`.
    fn is_paired(&self) -> bool {
        let mut open = 0u32;
        for kind in &self.kinds {
            match kind {
                L_CURLY => open += 1,
                R_CURLY if open == 0 => return false,
                R_CURLY => open -= 1,
                _ => {}
            }
        }
        open == 0
    }

    fn count_closing(&mut self) {
        let mut count = 0u32;
        self.closing = vec![0; self.kinds.len()];
        for (kind, closing) in self.kinds.iter().zip(&mut self.closing).rev() {
            match kind {
                R_CURLY => count += 1,
                L_CURLY => count = count.saturating_sub(1),
                _ => {}
            }
            *closing = count;
        }
    }

    /// The number of `}` from token `i` that close nothing opened there. `None` if the braces of the file are
    /// paired.
    pub(crate) fn closing(&self, i: usize) -> Option<u32> {
        (!self.closing.is_empty()).then(|| self.closing.get(i).copied().unwrap_or(0))
    }

    /// Column of token `i`, if it is the first of its line.
    pub(crate) fn indent(&self, i: usize) -> Option<usize> {
        const TAB: usize = 8;
        let Some(Element::Real(raw)) = self.element(i) else {
            return None;
        };
        let before = self.text.get(..self.raw.start(*raw as usize))?;
        let line = &before[line_start(before, before.len())..];
        line.chars().try_fold(0, |column, character| match character {
            ' ' => Some(column + 1),
            '\t' => Some(column / TAB * TAB + TAB),
            _ => None,
        })
    }

    fn push(&mut self, kind: SyntaxKind, text: &str, element: usize) {
        if !is_read(kind) {
            return;
        }
        let contextual = match kind {
            IDENT => SyntaxKind::contextual(text).unwrap_or(IDENT),
            _ => kind,
        };
        self.kinds.push(kind);
        self.contextual.push(contextual);
        self.sources.push(element as u32);
    }

    pub(crate) fn len(&self) -> usize {
        self.kinds.len()
    }

    /// Kind of token `i`, contextual keywords being identifiers.
    pub(crate) fn kind(&self, i: usize) -> SyntaxKind {
        self.kinds.get(i).copied().unwrap_or(EOF)
    }

    /// Kind of token `i`, words that may be keywords being keywords.
    pub(crate) fn contextual(&self, i: usize) -> SyntaxKind {
        self.contextual.get(i).copied().unwrap_or(EOF)
    }

    /// Returns true if an `#include` stands right before token `i`.
    pub(crate) fn is_after_include(&self, i: usize) -> bool {
        self.after_include.binary_search(&(i as u32)).is_ok()
    }

    /// Spelling of token `i`, after macro expansion.
    pub(crate) fn text(&self, i: usize) -> Cow<'_, str> {
        match self.element(i) {
            Some(Element::Real(raw)) => self.raw.clean_text(self.text, *raw as usize),
            Some(Element::Virtual(token)) => Cow::Borrowed(&token.text),
            _ => Cow::Borrowed(""),
        }
    }

    /// The range of token `i` in the file. For a virtual token, the range of its macro call; beyond the last
    /// token, the range of the last token, so that an error at the end of the input is visible.
    pub(crate) fn range(&self, i: usize) -> TextRange {
        let last = i.min(self.len().saturating_sub(1));
        match self.element(last) {
            Some(Element::Real(raw)) => self.raw_range(*raw, raw + 1),
            Some(Element::Virtual(_)) => self.call_range(self.sources[last] as usize),
            _ => TextRange::empty(TextSize::new(self.text.len() as u32)),
        }
    }

    /// The end of the token before token `i`. `None` if a macro made that token, or if there is none.
    pub(crate) fn end_before(&self, i: usize) -> Option<TextSize> {
        let before = i.min(self.len()).checked_sub(1)?;
        match self.element(before) {
            Some(Element::Real(raw)) => Some(self.raw_range(*raw, raw + 1).end()),
            _ => None,
        }
    }

    /// The text of the file from the first of some tokens to the last.
    pub(crate) fn source(&self, tokens: std::ops::Range<usize>) -> &'a str {
        let range = self.range(tokens.start).cover(self.range(tokens.end - 1));
        self.text.get(std::ops::Range::from(range)).unwrap_or_default()
    }

    /// Returns true if a line ends between token `i` and the one before.
    pub(crate) fn line_ends_before(&self, i: usize) -> bool {
        let (Some(end), start) = (self.end_before(i), self.range(i).start()) else {
            return false;
        };
        let between = self.text.get(usize::from(end)..usize::from(start));
        i >= self.len() || between.is_some_and(|text| text.contains(['\n', '\r']))
    }

    /// The macro that token `i` comes out of. A token with a line join inside is its own macro.
    pub(crate) fn macro_name(&self, i: usize) -> Option<&'a str> {
        let Some(Element::Virtual(_)) = self.element(i) else {
            return None;
        };
        let (first, _) = self.call(self.sources[i] as usize)?;
        Some(self.raw.text(self.text, first as usize))
    }

    fn element(&self, i: usize) -> Option<&'a Element> {
        self.elements.get(*self.sources.get(i)? as usize)
    }

    fn call_range(&self, element: usize) -> TextRange {
        self.call(element)
            .map_or_else(TextRange::default, |(first, end)| self.raw_range(first, end))
    }

    /// The raw tokens of the macro call that a virtual token comes from.
    fn call(&self, element: usize) -> Option<(u32, u32)> {
        self.elements[..element].iter().rev().find_map(|element| match element {
            Element::Call { first, end } => Some((*first, *end)),
            _ => None,
        })
    }

    fn raw_range(&self, first: u32, end: u32) -> TextRange {
        let start = self.raw.start(first as usize) as u32;
        let end = self.raw.start(end as usize) as u32;
        TextRange::new(start.into(), end.into())
    }
}

/// Returns true if the grammar reads tokens of this kind; the preprocessor reports and skips the others.
pub(crate) fn is_read(kind: SyntaxKind) -> bool {
    !kind.is_trivia() && !matches!(kind, STRAY | HASH | HASH2)
}
