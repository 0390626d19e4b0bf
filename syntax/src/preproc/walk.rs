//! The linear walk of one file: raw tokens in, elements out.
//!
//! Text and directives are read in one pass. A file without macros costs a look at the first byte of
//! each word and nothing else.

mod execute;

use rowan::TextRange;
use smol_str::SmolStr;

use super::{
    Element, Host, MacroEnv, MacroUse, PpError, Preprocessed, Severity, VirtualToken,
    expand::{Expander, Source},
    token::Token,
};
use crate::{
    directive::{Directive, DirectiveKind, Name, Pragma, text_range},
    finding::preprocessing::Preprocessing,
    kind::SyntaxKind::*,
    lexer::{RawTokens, is_trivia},
};

/// Preprocesses one file.
///
/// `file` is the path as the host names it (for `__FILE__` and [`MacroSite`](super::MacroSite)), `raw` the
/// tokens of `text`, `env` the environment at its start.
pub fn preprocess(
    file: &SmolStr,
    text: &str,
    raw: &RawTokens,
    env: MacroEnv,
    host: &mut dyn Host,
) -> Preprocessed {
    let mut walker = Walker {
        file,
        text,
        raw,
        env,
        host,
        expander: Expander::new(file, text, raw),
        out: Preprocessed { elements: Vec::with_capacity(raw.len()), ..Preprocessed::default() },
        conditionals: Vec::new(),
        live: true,
        at: 0,
        defines: 0,
        body_words: Vec::new(),
        open_comment: false,
    };
    walker.walk();
    walker.finish()
}

/// Maximum number of reports for one file; more are of no use.
const MAX_ERRORS: usize = 1000;

struct Walker<'a> {
    file: &'a SmolStr,
    text: &'a str,
    raw: &'a RawTokens,
    env: MacroEnv,
    host: &'a mut dyn Host,
    expander: Expander<'a>,
    out: Preprocessed,
    /// The open conditionals; those inside inactive text are not among them.
    conditionals: Vec<Conditional>,
    /// True outside of inactive groups.
    live: bool,
    /// The next raw token.
    at: usize,
    /// Number of `#define`s so far.
    defines: u32,
    /// Words in bodies of macros that do not name a macro yet.
    body_words: Vec<Name>,
    /// True if a comment without an end has been reported, which explains everything missing.
    open_comment: bool,
}

struct Conditional {
    /// Index of the directive that opens it.
    opening: usize,
    /// True if an active group has ended at an `#elif`: no other group can be active.
    closed: bool,
    seen_else: bool,
}

impl Walker<'_> {
    fn walk(&mut self) {
        let bytes = self.text.as_bytes();
        let mut line_start = true;
        while self.at < self.raw.len() {
            if !self.live {
                self.skip_group();
                line_start = false;
                continue;
            }
            let i = self.at as u32;
            match self.raw.kind(self.at) {
                kind if is_trivia(kind) => {
                    line_start |= kind == NEWLINE;
                    if kind == OPEN_COMMENT {
                        self.report_open_comment();
                    }
                    self.out.elements.push(Element::Trivia(i));
                    self.at += 1;
                    continue;
                }
                HASH if line_start => self.directive(),
                STRAY | HASH | HASH2 => {
                    self.report_stray(i);
                    self.out.elements.push(Element::Trivia(i));
                    self.at += 1;
                }
                _ => {
                    let first = bytes.get(self.raw.start(self.at)).copied().unwrap_or_default();
                    let name = (self.env.may_start(first) || first == b'_') && self.word();
                    if !name {
                        self.real(i);
                    }
                }
            }
            line_start = false;
        }
    }

    fn finish(mut self) -> Preprocessed {
        if let (Some(conditional), false) = (self.conditionals.last(), self.open_comment) {
            let opening = self.out.directives.get(conditional.opening);
            let related = opening.map(|directive| (directive.range, "the conditional begins here"));
            let end = self.text.len();
            self.report(PpError {
                kind: Preprocessing::OpenConditional,
                range: text_range(end, end),
                severity: Severity::Error,
                related,
            });
        }
        let mut uses = std::mem::take(&mut self.expander.uses);
        for word in self.body_words.drain(..) {
            if let Some(definition) = self.env.get(&word.text) {
                let site = Some(definition.site.clone());
                uses.push(MacroUse { name: word.text, range: word.range, site });
            }
        }
        uses.sort_by_key(|usage| usage.range.start());
        uses.dedup_by_key(|usage| usage.range);
        self.out.macro_uses = uses;
        self.out.errors.sort_by_key(|error| error.range.start());
        self.out.exit_env = self.env;
        self.out
    }

    // ---- Text ----

    /// Passes on one token. A token with a splice inside is passed on like a macro call.
    fn real(&mut self, i: u32) {
        self.at = i as usize + 1;
        if self.raw.has_splice(i as usize) {
            let token = self.expander.token(i);
            self.call(i, i + 1, vec![token]);
        } else {
            self.out.elements.push(Element::Real(i));
        }
    }

    /// Handles the current word if it is a called macro or a `_Pragma`. Returns false otherwise.
    fn word(&mut self) -> bool {
        let i = self.at;
        let word = self.raw.clean_text(self.text, i);
        let number = i > 0 && matches!(self.raw.kind(i - 1), INT | FLOAT | FIXED);
        if word == "_Pragma" {
            self.pragma_operator();
            return true;
        }
        // For the preprocessor, letters after a number are part of it.
        if number || self.env.get(&word).is_none() {
            return false;
        }
        let mut source = Source { next: i as u32 + 1, end: self.raw.len() as u32 };
        let expansion = self.expander.call(&self.env, i as u32, &mut source);
        let end = if expansion.is_some() { source.next } else { i as u32 + 1 };
        self.report_calls(self.span(i as u32, end));
        let Some(tokens) = expansion else {
            return false;
        };
        self.at = end as usize;
        self.call(i as u32, end, tokens);
        true
    }

    /// Emits a macro call and its expansion.
    fn call(&mut self, first: u32, end: u32, tokens: Vec<Token>) {
        self.out.elements.push(Element::Call { first, end });
        let range = self.span(first, end);
        let mut reported = false;
        let mut rest = tokens.into_iter();
        while let Some(token) = rest.next() {
            match token.kind {
                STRAY | HASH | HASH2 if !reported => {
                    reported = true;
                    self.error(range, report_stray_directive(&token.text));
                }
                STRAY | HASH | HASH2 => {}
                IDENT if token.text == "_Pragma" => {
                    let literal = match rest.as_slice() {
                        [open, literal, close, ..]
                            if (open.kind, literal.kind, close.kind)
                                == (L_PAREN, STRING, R_PAREN) =>
                        {
                            Some(literal.text.clone())
                        }
                        _ => None,
                    };
                    if literal.is_some() {
                        rest.nth(2);
                    }
                    self.emit_pragma_operator(
                        end,
                        end,
                        range,
                        literal.map(|literal| (literal, range)),
                    );
                }
                kind => {
                    self.out.elements.push(Element::Virtual(Box::new(VirtualToken {
                        kind,
                        text: token.text,
                        origin: token.origin,
                        glued: !token.spaced,
                    })));
                }
            }
        }
    }

    /// `_Pragma ( "…" )` in the text.
    fn pragma_operator(&mut self) {
        let first = self.at;
        let significant: Vec<usize> =
            (first + 1..self.raw.len()).filter(|&i| !is_trivia(self.raw.kind(i))).take(3).collect();
        let (end, literal) = match significant[..] {
            [open, literal, close]
                if (self.raw.kind(open), self.raw.kind(literal), self.raw.kind(close))
                    == (L_PAREN, STRING, R_PAREN) =>
            {
                (close + 1, Some(literal))
            }
            // Skip the text that looks like the argument, within the line.
            [open, ..] if self.raw.kind(open) == L_PAREN => {
                let line = open..self.raw.len().min(open + 64);
                let close = line
                    .take_while(|&i| self.raw.kind(i) != NEWLINE)
                    .find(|&i| self.raw.kind(i) == R_PAREN);
                (close.map_or(open + 1, |close| close + 1), None)
            }
            _ => (first + 1, None),
        };
        self.at = end;
        let (first, end) = (first as u32, end as u32);
        let literal = literal
            .map(|i| (self.raw.clean_text(self.text, i).into(), self.expander.raw_range(i as u32)));
        self.emit_pragma_operator(first, end, self.span(first, end), literal);
    }

    fn emit_pragma_operator(
        &mut self,
        first: u32,
        end: u32,
        range: TextRange,
        literal: Option<(SmolStr, TextRange)>,
    ) {
        let pragma = match &literal {
            Some((literal, range)) => Pragma::from_operator(literal, *range),
            None => Pragma { name: None, args: Vec::new(), operator: true, misspelt: None },
        };
        if literal.is_none() {
            self.error(range, Preprocessing::PragmaOperator);
        } else {
            self.pragma(&pragma, range);
        }
        let index = self.out.directives.len() as u32;
        self.out.directives.push(Directive {
            first,
            end,
            range,
            keyword: None,
            misspelt: pragma.misspelt.clone(),
            kind: DirectiveKind::Pragma(pragma),
            active: true,
            taken: None,
        });
        self.out.elements.push(Element::Directive { first, end, index });
    }

    // ---- Directives ----

    /// Handles the directive at the current `#`, in active text or at the end of an inactive group.
    fn directive(&mut self) {
        let directive = Directive::parse(self.text, self.raw, self.at, &mut self.defines);
        let (first, end) = (directive.first, directive.end);
        self.at = end as usize;
        if end > first && self.raw.kind(self.at - 1) == OPEN_COMMENT {
            self.report_open_comment();
        }
        let index = self.out.directives.len();
        self.out.directives.push(directive.clone());
        let taken = self.execute(&directive, index);
        if let Some(directive) = self.out.directives.get_mut(index) {
            directive.taken = taken;
        }
        self.out.elements.push(Element::Directive { first, end, index: index as u32 });
    }

    // ---- Text left out ----

    /// Skips an inactive group, up to and including the directive that ends it.
    fn skip_group(&mut self) {
        // The line end of the directive before.
        if self.raw.kind(self.at) == NEWLINE {
            self.out.elements.push(Element::Trivia(self.at as u32));
            self.at += 1;
        }
        let first = self.at;
        let mut line = first;
        let mut line_start = true;
        let mut depth = 0usize;
        while self.at < self.raw.len() {
            match self.raw.kind(self.at) {
                NEWLINE => {
                    line_start = true;
                    line = self.at + 1;
                }
                kind if is_trivia(kind) => {
                    if kind == OPEN_COMMENT {
                        self.report_open_comment();
                    }
                }
                HASH if line_start => {
                    let mut defines = self.defines;
                    let mut directive =
                        Directive::parse(self.text, self.raw, self.at, &mut defines);
                    // Inactive text may be meant for another preprocessor.
                    if directive.misspelt.is_some() {
                        directive.kind = DirectiveKind::Unknown;
                        directive.misspelt = None;
                    }
                    let ends_group = matches!(
                        directive.kind,
                        DirectiveKind::Elif(_) | DirectiveKind::Else(_) | DirectiveKind::Endif(_)
                    );
                    if depth == 0 && ends_group {
                        self.push_inactive(first, line);
                        for i in line..self.at {
                            self.out.elements.push(Element::Trivia(i as u32));
                        }
                        self.directive();
                        return;
                    }
                    if directive.is_opening() {
                        depth += 1;
                    } else if matches!(directive.kind, DirectiveKind::Endif(_)) {
                        depth -= 1;
                    }
                    self.defines = defines;
                    directive.active = false;
                    self.at = directive.end as usize;
                    if self.raw.kind(self.at - 1) == OPEN_COMMENT {
                        self.report_open_comment();
                    }
                    self.out.directives.push(directive);
                    line_start = false;
                    continue;
                }
                _ => line_start = false,
            }
            self.at += 1;
        }
        self.push_inactive(first, self.at);
    }

    fn push_inactive(&mut self, first: usize, end: usize) {
        if first < end {
            let (first, end) = (first as u32, end as u32);
            self.out.elements.push(Element::Inactive { first, end });
            self.out.inactive.push(self.span(first, end));
        }
    }

    // ---- Reports ----

    /// The bytes from the raw token `first` to before `end`.
    fn span(&self, first: u32, end: u32) -> TextRange {
        let start = self.raw.start(first as usize);
        text_range(start, self.raw.start(end as usize).max(start))
    }

    fn report(&mut self, error: PpError) {
        match self.out.errors.len() {
            ..MAX_ERRORS => self.out.errors.push(error),
            MAX_ERRORS => self.out.errors.push(PpError {
                kind: Preprocessing::TooMany,
                related: None,
                ..error
            }),
            _ => {}
        }
    }

    fn error(&mut self, range: TextRange, kind: Preprocessing) {
        self.report(PpError { kind, range, severity: Severity::Error, related: None });
    }

    fn warning(&mut self, range: TextRange, kind: Preprocessing) {
        self.report(PpError { kind, range, severity: Severity::Warning, related: None });
    }

    /// Reports the errors in macro calls; `range` is the range of the calls.
    fn report_calls(&mut self, range: TextRange) {
        if self.expander.problems.is_empty() {
            return;
        }
        for problem in std::mem::take(&mut self.expander.problems) {
            // A call over several lines is reported at its end.
            let spans_lines = self
                .text
                .get(std::ops::Range::from(range))
                .is_some_and(|text| text.contains(['\n', '\r']));
            let at = match problem.end {
                Some(end) if spans_lines => self.span(end.saturating_sub(1), end),
                _ => range,
            };
            self.error(at, problem.kind);
        }
    }

    fn report_stray(&mut self, i: u32) {
        let text = self.raw.text(self.text, i as usize);
        self.error(self.expander.raw_range(i), report_stray_directive(text));
    }

    /// Reports a comment without an end as the last token.
    fn report_open_comment(&mut self) {
        if !self.open_comment {
            self.open_comment = true;
            let start = self.raw.start(self.raw.len() - 1);
            self.error(text_range(start, start + 2), Preprocessing::OpenComment);
        }
    }
}

/// The error for characters that do not start a token.
fn report_stray_directive(text: &str) -> Preprocessing {
    const SHOWN: usize = 20;
    if text.starts_with('\u{feff}') {
        return Preprocessing::ByteOrderMark;
    }
    let mut shown: String = text.chars().take(SHOWN).flat_map(char::escape_debug).collect();
    if text.chars().nth(SHOWN).is_some() {
        shown.push('…');
    }
    let shown = shown.into();
    if text.bytes().any(|byte| (1..=4).contains(&byte)) {
        Preprocessing::Control { shown }
    } else if text.starts_with('#') {
        Preprocessing::StrayHash { shown }
    } else if text.is_ascii() {
        Preprocessing::Stray { shown }
    } else {
        Preprocessing::NotAscii { shown }
    }
}

#[cfg(test)]
mod tests;
