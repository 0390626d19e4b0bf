//! Changes that make a text fit the grammar, for errors whose correction the grammar knows.

use smol_str::SmolStr;

use super::{Input, Parser, TokenSet};
use crate::{
    TextRange,
    finding::parsing::Parsing,
    kind::SyntaxKind::{self, *},
    suggestion::nearest_keyword,
};

/// A change of the text that makes it fit the grammar.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Repair {
    /// The replaced range; empty to insert.
    pub range: TextRange,
    /// The new text; empty to remove.
    pub text: SmolStr,
    /// True if the repair is unambiguous.
    pub plain: bool,
}

/// A [`Repair`] in terms of tokens.
pub(super) struct RawRepair {
    place: RepairPlace,
    text: SmolStr,
    plain: bool,
}

pub(super) enum RepairPlace {
    /// An insertion behind the token before this one.
    Behind(usize),
    /// An insertion before this token.
    Before(usize),
    /// A replacement of these tokens and the text between them.
    Tokens(std::ops::Range<usize>),
}

impl RawRepair {
    /// The repair in terms of the text. `None` if a macro made the text.
    pub(super) fn locate(self, input: &Input<'_>) -> Option<Repair> {
        let real = |index: usize| input.macro_name(index).is_none();
        let range = match self.place {
            RepairPlace::Behind(token) => TextRange::empty(input.end_before(token)?),
            RepairPlace::Before(token) if real(token) => {
                TextRange::empty(input.range(token).start())
            }
            RepairPlace::Tokens(tokens) if tokens.clone().all(real) => {
                let first = input.range(tokens.start);
                first.cover(input.range(tokens.end.checked_sub(1)?))
            }
            _ => return None,
        };
        let RawRepair { text, plain, .. } = self;
        Some(Repair { range, text, plain })
    }
}

/// Repairs of the last error, and words that are misspelt.
impl Parser<'_> {
    /// Reads the current word as the nearest of these keywords, and reports it. Does nothing unless the
    /// following tokens `fits` that reading.
    pub(crate) fn respell(
        &mut self,
        keywords: TokenSet,
        fits: impl FnOnce(&Parser<'_>) -> bool,
    ) -> bool {
        let is_word = self.current_contextual() == IDENT;
        if !is_word || self.is_reported() || self.respelt.is_some() {
            return false;
        }
        let word = self.current_text();
        let all = SyntaxKind::spellings();
        let candidates = all.iter().filter(|spelling| keywords.contains(spelling.0));
        let Some(spelling) = nearest_keyword(&word, candidates.map(|candidate| candidate.1)) else {
            return false;
        };
        let Some(kind) =
            all.iter().find(|candidate| candidate.1 == spelling).map(|spelling| spelling.0)
        else {
            return false;
        };
        self.respelt = Some((self.pos, kind));
        if !fits(self) {
            self.respelt = None;
            return false;
        }
        let (word, keyword) = (word.into(), spelling.into());
        self.push_error(self.pos, Parsing::Misspelt { word, keyword });
        self.replace(self.pos..self.pos + 1, spelling, true);
        true
    }

    /// Reports the next `count` tokens as a spelling of another language and reads the last of them as a
    /// keyword.
    pub(crate) fn read_foreign(&mut self, count: usize, kind: SyntaxKind) {
        let (first, last) = (self.pos, self.pos + count - 1);
        let ty = kind.spelling().unwrap_or_default();
        let word = self.source(first..last + 1).into();
        self.push_error(first, Parsing::ForeignType { word, ty });
        self.replace(first..last + 1, ty, true);
        if first < last {
            self.skip_tokens(count - 1);
        }
        self.respelt = Some((last, kind));
    }

    /// Consumes tokens into an `ERROR` node.
    pub(crate) fn skip_tokens(&mut self, count: usize) {
        let bad = self.start();
        (0..count).for_each(|_| self.bump_any());
        bad.complete(self, ERROR);
    }

    /// The text from the first of some tokens to the last.
    pub(crate) fn source(&self, tokens: std::ops::Range<usize>) -> &str {
        self.input.source(tokens)
    }

    /// Number of tokens from the current one up to the `;` on the same line, if there is one within some
    /// dozens.
    pub(crate) fn rest_of_line(&self) -> Option<usize> {
        const MOST: usize = 64;
        let end = (self.pos..self.pos + MOST).find(|token| {
            let next_line = *token > self.pos && self.input.line_ends_before(*token);
            next_line || matches!(self.input.kind(*token), SEMICOLON | EOF)
        })?;
        let same_line = end == self.pos || !self.input.line_ends_before(end);
        (same_line && self.input.kind(end) == SEMICOLON).then_some(end - self.pos)
    }

    /// Moves the last error to the place right behind the token before it.
    pub(crate) fn show_behind(&mut self) {
        if let Some(last) = self.errors.last_mut() {
            last.behind = true;
        }
    }

    /// Repairs the last error by inserting a text behind the token before the current one.
    pub(crate) fn insert_behind(&mut self, text: &str, plain: bool) {
        self.repair(RepairPlace::Behind(self.pos), text, plain);
    }

    /// Repairs the last error by inserting a text before the current token.
    pub(crate) fn insert_before(&mut self, text: &str, plain: bool) {
        self.repair(RepairPlace::Before(self.pos), text, plain);
    }

    /// Repairs the last error by replacing tokens with a text.
    pub(crate) fn replace(&mut self, tokens: std::ops::Range<usize>, text: &str, plain: bool) {
        self.repair(RepairPlace::Tokens(tokens), text, plain);
    }

    fn repair(&mut self, place: RepairPlace, text: &str, plain: bool) {
        let text = text.into();
        if let Some(last) = self.errors.last_mut()
            && last.kind != Parsing::TooMany
        {
            last.repair = Some(RawRepair { place, text, plain });
        }
    }

    /// Returns true if a line ends between the token before and the current one.
    pub(crate) fn starts_line(&self) -> bool {
        self.nth_starts_line(0)
    }

    /// Returns true if a line ends between the token `n` further on and the one before.
    pub(crate) fn nth_starts_line(&self, n: usize) -> bool {
        self.pos + n > 0 && self.input.line_ends_before(self.pos + n)
    }

    /// Returns true if nothing is between the current token and the next one.
    pub(crate) fn is_glued(&self) -> bool {
        self.input.range(self.pos).end() == self.input.range(self.pos + 1).start()
    }
}
