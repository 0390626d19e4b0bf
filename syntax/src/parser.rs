//! From tokens to the structure of the tree.
//!
//! The grammar (`grammar`) reads the kinds of the real and virtual tokens of a file (`input`) and describes
//! the tree as a list of events (`event`). [`crate::sink`] builds the tree from them and puts back all text
//! that the grammar does not read. Parsing never fails: the result is a tree that holds the whole text, and
//! errors.
//!
//! Keywords are contextual: [`Parser::at`] accepts both readings of a word, and the reading that the grammar
//! bumps goes into the tree.

mod event;
mod grammar;
mod input;
mod marker;
mod repair;
mod token_set;

use std::cell::Cell;

use smol_str::SmolStr;

use self::repair::RawRepair;
pub use self::repair::Repair;
pub(crate) use self::{
    event::Event,
    input::{Input, is_read},
};
use self::{
    marker::{CompletedMarker, Marker},
    token_set::TokenSet,
};
pub use crate::preproc::Severity;
use crate::{
    TextRange, TextSize,
    codes::AT_END,
    directive::DirectiveKind,
    finding::{Wording, parsing::Parsing},
    fragment::Fragment,
    kind::SyntaxKind::{self, *},
    lexer::RawTokens,
    preproc::{Element, Preprocessed},
};

/// Maximum nesting of declarations, types, expressions and initializers. Trees are walked and dropped
/// recursively; real specifications nest less than a tenth of this.
const MAX_DEPTH: u32 = 128;

/// Maximum number of errors kept for one file. A file with more is not a specification.
const MAX_ERRORS: usize = 500;

/// The result of the grammar for a file.
pub(crate) struct ParserOutput {
    /// The events that build the tree.
    pub(crate) events: Vec<Event>,
    /// The errors in text order, up to the maximum number.
    pub(crate) errors: Vec<SyntaxError>,
    /// Offset from which code and strings seem to be exchanged.
    pub(crate) inside_out: Option<TextSize>,
    /// Offset from which errors are not kept.
    pub(crate) unlisted: Option<TextSize>,
}

/// Runs the grammar on a file, given its raw tokens and the output of the preprocessor.
pub(crate) fn read(
    text: &str,
    raw: &RawTokens,
    pre: &Preprocessed,
    fragment: Fragment,
) -> ParserOutput {
    let is_include = |index: u32| {
        pre.directives
            .get(index as usize)
            .is_some_and(|directive| matches!(directive.kind, DirectiveKind::Include(_)))
    };
    let input = Input::new(text, raw, &pre.elements, is_include);
    let mut p = Parser::new(&input);
    grammar::fragment(&mut p, fragment);
    let inside_out = p.inside_out;
    let (events, mut errors) = p.finish();
    let unlisted = errors.get(MAX_ERRORS).map(|error| input.range(error.token).start());
    errors.retain(|error| inside_out.is_none_or(|from| error.token <= from));
    ParserOutput {
        events,
        errors: locate(&input, errors),
        inside_out: inside_out.map(|token| input.range(token).start()),
        unlisted,
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct SyntaxError {
    /// The error as data.
    pub kind: Parsing,
    /// Error, or warning.
    pub severity: Severity,
    /// True if the text ends there.
    pub at_end: bool,
    /// The macro that the text comes out of.
    pub in_macro: Option<SmolStr>,
    /// The range of the error, in bytes of this file.
    pub range: TextRange,
    /// Another range that explains the error, and its description.
    pub related: Option<(TextRange, &'static str)>,
    /// The brace that is missing before the error, with its semicolon: `{`, `}` or `};`.
    pub missing: Option<&'static str>,
    /// The change that makes the text fit, if the grammar knows one.
    pub repair: Option<Repair>,
}

impl SyntaxError {
    /// The Id of the table in section 19 of the language reference, such as `missing-semicolon`.
    pub fn code(&self) -> &'static str {
        match self.kind.code() {
            "syntax" if self.at_end => AT_END,
            code => code,
        }
    }

    /// The message: the token found, the one expected and the correction.
    pub fn wording(&self) -> Wording {
        let mut wording = self.kind.wording();
        if let Some(name) = &self.in_macro {
            wording.append(&format!(" (in what the macro `{name}` expands to)"));
        }
        wording
    }
}

/// Reads the words of a `#pragma wcet` after `wcet`: the name of a codel and a duration. Missing words are
/// left to the users of the tree; superfluous ones are reported.
pub(crate) fn parse_wcet_pragma(
    text: &str,
    raw: &RawTokens,
    elements: &[Element],
) -> (Vec<Event>, Vec<SyntaxError>) {
    let input = Input::new(text, raw, elements, |_| false);
    let mut p = Parser::new(&input);
    grammar::wcet_pragma(&mut p);
    let (events, mut errors) = p.finish();
    errors.retain(|error| matches!(error.kind, Parsing::MoreInPragma { .. }));
    (events, locate(&input, errors))
}

/// Gives errors their ranges. An error in the expansion of a macro is reported once, at the call.
fn locate(input: &Input<'_>, errors: Vec<RawError>) -> Vec<SyntaxError> {
    let mut located: Vec<SyntaxError> = Vec::with_capacity(errors.len());
    let mut last_call = None;
    for error in errors {
        let mut range = input.range(error.token);
        if error.behind
            && let Some(end) = input.end_before(error.token)
        {
            range = TextRange::empty(end);
        }
        if input.macro_name(error.token).is_some() {
            if last_call == Some(range) {
                continue;
            }
            last_call = Some(range);
        }
        located.push(SyntaxError {
            kind: error.kind,
            severity: Severity::Error,
            at_end: error.at_end,
            in_macro: input.macro_name(error.token).map(SmolStr::new),
            range,
            related: error.related.map(|(token, what)| (input.range(token), what)),
            missing: error.missing,
            repair: error.repair.and_then(|repair| repair.locate(input)),
        });
    }
    located.sort_by_key(|capacity| capacity.range.start());
    located
}

/// An error at a token of the input.
struct RawError {
    kind: Parsing,
    token: usize,
    at_end: bool,
    /// Index of another token that explains the error, and its description.
    related: Option<(usize, &'static str)>,
    missing: Option<&'static str>,
    /// True to report the error right behind the token before.
    behind: bool,
    repair: Option<RawRepair>,
}

/// The state of the grammar: a position in the input and the events so far.
pub(crate) struct Parser<'i> {
    input: &'i Input<'i>,
    pos: usize,
    events: Vec<Event>,
    errors: Vec<RawError>,
    /// Token of the last error. Further errors at this token are not reported.
    last_error: Option<usize>,
    /// Open constructs that may nest.
    depth: u32,
    /// Number of bodies that ended without their `}`. As many superfluous `}` follow from them.
    unclosed: u32,
    /// True after a report of a body whose first line is missing and whose `}` is still to come.
    headless: bool,
    /// Token of a string over several lines before something that cannot follow it: its quotes belong to two
    /// strings.
    inside_out: Option<usize>,
    /// Bodies around the current token.
    open: u32,
    /// First token of the item around the current one.
    item: usize,
    /// Inside `< >` of a type, where `>>` may be two closing brackets.
    in_angles: bool,
    /// A misspelt word that is read as a keyword: its token and the keyword.
    respelt: Option<(usize, SyntaxKind)>,
    /// The `{` of a struct or enum whose missing name is reported.
    nameless: Option<usize>,
    /// Look-aheads since the last token was consumed.
    fuel: Cell<u32>,
}

impl<'i> Parser<'i> {
    fn new(input: &'i Input<'i>) -> Parser<'i> {
        Parser {
            input,
            pos: 0,
            events: Vec::with_capacity(input.len() * 3),
            errors: Vec::new(),
            last_error: None,
            depth: 0,
            unclosed: 0,
            headless: false,
            inside_out: None,
            open: 0,
            item: 0,
            in_angles: false,
            respelt: None,
            nameless: None,
            fuel: Cell::new(0),
        }
    }

    fn finish(self) -> (Vec<Event>, Vec<RawError>) {
        (self.events, self.errors)
    }

    /// Kind of the current token; words are identifiers.
    pub(crate) fn current(&self) -> SyntaxKind {
        self.nth(0)
    }

    /// Kind of the token `n` further on; words are identifiers.
    pub(crate) fn nth(&self, n: usize) -> SyntaxKind {
        self.check_progress();
        self.kind_at(self.pos + n)
    }

    /// The current token as a keyword, if it is a word that may be one; else its kind.
    pub(crate) fn current_contextual(&self) -> SyntaxKind {
        self.check_progress();
        self.contextual_at(self.pos)
    }

    /// Returns true if the current token is, or may be read as, this kind.
    pub(crate) fn at(&self, kind: SyntaxKind) -> bool {
        self.nth_at(0, kind)
    }

    /// Returns true if the token `n` further on is, or may be read as, this kind.
    pub(crate) fn nth_at(&self, n: usize, kind: SyntaxKind) -> bool {
        self.check_progress();
        self.kind_at(self.pos + n) == kind || self.contextual_at(self.pos + n) == kind
    }

    /// Returns true if the current token is, or may be read as, one of these kinds.
    pub(crate) fn at_ts(&self, kinds: TokenSet) -> bool {
        self.nth_at_ts(0, kinds)
    }

    /// Returns true if the token `n` further on is, or may be read as, one of these kinds.
    pub(crate) fn nth_at_ts(&self, n: usize, kinds: TokenSet) -> bool {
        self.check_progress();
        kinds.contains(self.kind_at(self.pos + n))
            || kinds.contains(self.contextual_at(self.pos + n))
    }

    fn kind_at(&self, i: usize) -> SyntaxKind {
        match self.respelt {
            Some((at, kind)) if at == i && kind.is_reserved_word() => kind,
            _ => self.input.kind(i),
        }
    }

    fn contextual_at(&self, i: usize) -> SyntaxKind {
        match self.respelt {
            Some((at, kind)) if at == i => kind,
            _ => self.input.contextual(i),
        }
    }

    /// Returns true if an `#include` is right before the current token, so that missing text may come from
    /// another file.
    pub(crate) fn is_after_include(&self) -> bool {
        self.input.is_after_include(self.pos)
    }

    /// Begins a node.
    pub(crate) fn start(&mut self) -> Marker {
        let position = self.events.len() as u32;
        self.events.push(Event::tombstone());
        Marker::new(position)
    }

    /// Consumes the current token under this kind, if it is or may be read as this kind.
    pub(crate) fn eat(&mut self, kind: SyntaxKind) -> bool {
        let found = self.at(kind);
        if found {
            self.advance(kind);
        }
        found
    }

    /// Consumes the current token, which must be or be readable as this kind.
    pub(crate) fn bump(&mut self, kind: SyntaxKind) {
        let found = self.eat(kind);
        debug_assert!(found, "not at {kind:?}");
    }

    /// Consumes the current token; words become identifiers.
    pub(crate) fn bump_any(&mut self) {
        let kind = self.current();
        if kind != EOF {
            self.advance(kind);
        }
    }

    /// Consumes the current token; words that may be keywords become keywords.
    pub(crate) fn bump_contextual(&mut self) {
        let kind = self.current_contextual();
        if kind != EOF {
            self.advance(kind);
        }
    }

    fn advance(&mut self, kind: SyntaxKind) {
        self.pos += 1;
        self.respelt = None;
        self.fuel.set(0);
        self.events.push(Event::Token { kind });
    }

    /// Consumes a token of this kind or reports that it is missing.
    pub(crate) fn expect(&mut self, kind: SyntaxKind) -> bool {
        let found = self.eat(kind);
        if !found {
            self.expected(&quoted(kind));
        }
        found
    }

    /// Like [`Parser::expect`]. If the current token is one of `followers`, only the expected token is
    /// missing.
    pub(crate) fn expect_before(&mut self, kind: SyntaxKind, followers: TokenSet) -> bool {
        let found = self.eat(kind);
        if !found && self.expected(&quoted(kind)) && self.at_ts(followers) {
            self.insert_behind(kind.spelling().unwrap_or_default(), true);
            if self.starts_line() {
                self.show_behind();
            }
        }
        found
    }

    /// Reports that something else was expected at the current token. Returns false, like all methods that
    /// report, if an error was already reported at the token.
    pub(crate) fn expected(&mut self, what: &str) -> bool {
        let (what, found) = (what.into(), self.describe_current().into());
        self.error_here(Parsing::Expected { what, found })
    }

    /// Reports that something else was expected at the current token, with a sentence of advice.
    pub(crate) fn expected_because(&mut self, what: &str, help: &'static str) -> bool {
        let (what, found) = (what.into(), self.describe_current().into());
        self.error_here(Parsing::ExpectedBecause { what, found, help })
    }

    /// Reports the current token.
    pub(crate) fn error_here(&mut self, kind: Parsing) -> bool {
        self.error_at(self.pos, kind)
    }

    /// Reports the token before the current one, unless the current one was the last one reported.
    pub(crate) fn error_before(&mut self, kind: Parsing) -> bool {
        let is_new = self.error_here(kind);
        if let Some(last) = self.errors.last_mut().filter(|_| is_new) {
            last.token = self.pos.saturating_sub(1);
        }
        is_new
    }

    /// Reports a token, unless it was the last one reported.
    pub(crate) fn error_at(&mut self, token: usize, kind: Parsing) -> bool {
        if self.last_error.is_some_and(|last| last >= token) {
            return false;
        }
        self.last_error = Some(token);
        self.push_error(token, kind);
        true
    }

    /// Reports a token after which the grammar continues as if it was correct.
    pub(crate) fn push_error(&mut self, token: usize, kind: Parsing) {
        let kind = match self.errors.len() {
            ..MAX_ERRORS => kind,
            MAX_ERRORS => Parsing::TooMany,
            _ => return,
        };
        self.errors.push(RawError {
            kind,
            token,
            at_end: self.at(EOF),
            related: None,
            missing: None,
            behind: false,
            repair: None,
        });
    }

    /// Number of errors so far.
    pub(crate) fn error_count(&self) -> usize {
        self.errors.len()
    }

    /// Adds to the last error another token that explains it.
    pub(crate) fn explain(&mut self, token: usize, what: &'static str) {
        if let Some(last) = self.errors.last_mut() {
            last.related = Some((token, what));
        }
    }

    /// Adds to the last error the brace that is missing there.
    pub(crate) fn add_missing_brace(&mut self, brace: &'static str) {
        if let Some(last) = self.errors.last_mut() {
            last.missing = Some(brace);
        }
    }

    /// Index of the current token, for [`Parser::error_at`].
    pub(crate) fn position(&self) -> usize {
        self.pos
    }

    /// Marks the current token as reported, since an earlier error covers it.
    pub(crate) fn mark_reported(&mut self) {
        self.last_error = self.last_error.max(Some(self.pos));
    }

    /// Returns true if the current token has been reported already.
    pub(crate) fn is_reported(&self) -> bool {
        self.last_error.is_some_and(|last| last >= self.pos)
    }

    /// Returns true if more `}` follow than bodies are open: a `{` is missing somewhere.
    pub(crate) fn has_spare_brace(&self) -> bool {
        let closing = self.input.closing(self.pos);
        closing.is_some_and(|number| number > self.open + self.unclosed)
    }

    /// Returns true if fewer `}` follow than bodies are open: a `}` is missing somewhere.
    pub(crate) fn lacks_brace(&self) -> bool {
        let closing = self.input.closing(self.pos);
        closing.is_some_and(|number| number < self.open)
    }

    /// Enters a construct that may nest. If it is nested too deeply, the error is reported and the text is
    /// skipped without structure; the caller then returns at once.
    pub(crate) fn enter(&mut self) -> bool {
        if self.depth < MAX_DEPTH {
            self.depth += 1;
            return true;
        }
        self.error_here(Parsing::TooNested { most: MAX_DEPTH });
        self.skip_construct();
        false
    }

    /// Leaves a construct that was entered.
    pub(crate) fn leave(&mut self) {
        self.depth -= 1;
    }

    /// Skips tokens into one flat `ERROR` node, up to the end of the construct around.
    pub(crate) fn skip_construct(&mut self) {
        let (m, start) = (self.start(), self.pos);
        let (mut open, mut braces) = (0u32, 0u32);
        loop {
            match self.current() {
                EOF => break,
                L_PAREN | L_BRACK => open += 1,
                L_CURLY => {
                    open += 1;
                    braces += 1;
                }
                R_PAREN | R_BRACK | R_CURLY if open == 0 => break,
                R_PAREN | R_BRACK => open -= 1,
                R_CURLY => {
                    open -= 1;
                    braces = braces.saturating_sub(1);
                }
                SEMICOLON if braces == 0 => break,
                _ => {}
            }
            self.bump_any();
        }
        let passed = self.pos > start;
        m.complete_unless_empty(self, passed, ERROR);
    }

    /// Description of the current token, for messages.
    pub(crate) fn describe_current(&self) -> String {
        let kind = self.current();
        match kind {
            EOF => "the end of the file".to_owned(),
            OPEN_STRING => "a string without end".to_owned(),
            _ => {
                let text = self.input.text(self.pos);
                let line = text.lines().next().unwrap_or_default();
                let shown: String = line.chars().take(40).collect();
                let dots = if shown.len() < text.len() { "…" } else { "" };
                let what = if kind.is_reserved_word() { "the reserved word " } else { "" };
                format!("{what}`{shown}{dots}`")
            }
        }
    }

    /// Marks strings and code as exchanged from here, after an error at the current token or before.
    pub(crate) fn mark_exchanged(&mut self) {
        self.inside_out.get_or_insert(self.pos);
    }

    /// Returns true if the token before the current one is a literal that spans a line end.
    pub(crate) fn is_after_long_literal(&self) -> bool {
        self.pos.checked_sub(1).is_some_and(|before| {
            self.input.kind(before) == STRING && self.input.text(before).contains(['\n', '\r'])
        })
    }

    /// Text of the current token.
    pub(crate) fn current_text(&self) -> String {
        self.input.text(self.pos).into_owned()
    }

    pub(crate) fn nth_text_at(&self, token: usize) -> String {
        self.input.text(token).into_owned()
    }

    /// Text of the token `n` further on.
    pub(crate) fn nth_text(&self, n: usize) -> String {
        self.input.text(self.pos + n).into_owned()
    }

    /// Detects grammar loops that do not advance.
    fn check_progress(&self) {
        let burnt = self.fuel.get() + 1;
        self.fuel.set(burnt);
        debug_assert!(burnt < 10_000, "the parser is stuck at token {}", self.pos);
    }
}

/// The spelling of a token between back quotes.
fn quoted(kind: SyntaxKind) -> String {
    format!("`{}`", kind.spelling().unwrap_or("?"))
}
