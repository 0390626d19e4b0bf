//! A `#…` line as a typed value.
//!
//! Purely textual: nothing is expanded or evaluated here, and every part carries its raw tokens, so that
//! editor features can point at it. Errors in a directive are found where the directive takes effect, in
//! `preproc::walk`.

use std::ops::Range;

use rowan::{TextRange, TextSize};
use smol_str::SmolStr;

use crate::{
    kind::SyntaxKind::{self, *},
    lexer::{RawTokens, is_trivia, is_word, lex},
    suggestion::nearest,
};

/// One directive of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Directive {
    /// First raw token: the `#`, or `_Pragma`.
    pub first: u32,
    /// One past the last raw token; the line end is excluded.
    pub end: u32,
    /// Byte range of these tokens. For a `_Pragma` that comes out of a macro, the range of the call.
    pub range: TextRange,
    /// The word after `#`, if there is one.
    pub keyword: Option<Name>,
    /// The content of the directive.
    pub kind: DirectiveKind,
    /// Set if the word of the directive, or of its pragma, is misspelt; `kind` is the intended one.
    pub misspelt: Option<Misspelt>,
    /// True in active text. A conditional directive is active if the text around its conditional is.
    pub active: bool,
    /// For active `#if`, `#ifdef`, `#ifndef`, `#elif` and `#else`: true if the text after the directive is
    /// active.
    pub taken: Option<bool>,
}

/// A word of a directive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Name {
    /// The word, without splices.
    pub text: SmolStr,
    /// The range of the word in the text.
    pub range: TextRange,
}

/// The content of a directive. Token ranges are indexes into the raw tokens of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DirectiveKind {
    /// `#include`
    Include(IncludeOperand),
    /// `#define`
    Define(Define),
    /// `#undef NAME`
    Undef(Operand),
    /// `#if CONDITION`
    If(Range<u32>),
    /// `#elif CONDITION`
    Elif(Range<u32>),
    /// `#ifdef NAME`
    Ifdef(Operand),
    /// `#ifndef NAME`
    Ifndef(Operand),
    /// `#else`, with the superfluous tokens after it.
    Else(Range<u32>),
    /// `#endif`, with the superfluous tokens after it.
    Endif(Range<u32>),
    /// `#error TEXT`
    Error(SmolStr),
    /// `#warning TEXT`
    Warning(SmolStr),
    /// `#line N "FILE"`
    Line(Range<u32>),
    /// `#pragma NAME ARGUMENTS`, or `_Pragma("NAME ARGUMENTS")`
    Pragma(Pragma),
    /// Any other word or number: the line is ignored.
    Unknown,
    /// A `#` alone.
    Empty,
}

/// The name after `#undef`, `#ifdef` or `#ifndef`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Operand {
    /// `None` if the name is missing.
    pub name: Option<Name>,
    /// The tokens after the name, or in its place.
    pub rest: Range<u32>,
}

/// The operand of `#include`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IncludeOperand {
    /// The form of the file name.
    pub form: IncludeForm,
    /// The operand as written, with its delimiters; empty at the end of the directive if missing.
    pub range: TextRange,
    /// The superfluous tokens after a quoted or angled name.
    pub rest: Range<u32>,
}

/// The forms of a file name after `#include`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum IncludeForm {
    /// `"path"`
    Quoted(SmolStr),
    /// `<path>`
    Angled(SmolStr),
    /// Anything else: tokens to expand.
    Macro(Range<u32>),
}

/// A `#define` as written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Define {
    /// `None` if the name is missing.
    pub name: Option<Name>,
    /// `None` for an object-like macro.
    pub params: Option<Params>,
    /// The replacement, without blanks around it.
    pub body: Range<u32>,
    /// No blank between the name of an object-like macro and its body.
    pub glued: bool,
    /// Index among all `#define`s of the file, active or not; see [`MacroSite`](crate::preproc::MacroSite).
    pub ordinal: u32,
}

/// The parameter list of a function-like macro.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Params {
    /// The names, in order.
    pub names: Vec<Name>,
    /// Ends in `...`.
    pub variadic: bool,
    /// Neither broken nor without its closing parenthesis.
    pub well_formed: bool,
}

/// A `#pragma` as written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pragma {
    /// The first word; `None` if there is nothing after `#pragma`.
    pub name: Option<Name>,
    /// The other words, blanks removed.
    pub args: Vec<PragmaArg>,
    /// Written as `_Pragma("…")`.
    pub operator: bool,
    /// Set if the first word is misspelt; `name` is the intended word.
    pub misspelt: Option<Misspelt>,
}

/// One word of a pragma.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PragmaArg {
    /// The text; quotes removed, `\"` replaced by `"`.
    pub text: SmolStr,
    /// True if the word was written between quotes.
    pub quoted: bool,
    /// The range of the word, quotes included. In a `_Pragma`, the range of the string.
    pub range: TextRange,
}

/// The words of directives.
const WORDS: [&str; 13] = [
    "include", "define", "undef", "if", "elif", "ifdef", "ifndef", "else", "endif", "error",
    "warning", "line", "pragma",
];

/// The words of pragmas that dotgen knows.
const PRAGMAS: [&str; 7] =
    ["require", "requires", "provide", "provides", "masquerade", "wcet", "once"];

/// A misspelt word of a directive. The directive is read as the known word nearest to it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Misspelt {
    /// The word as it is written.
    pub word: Name,
    /// The intended word.
    pub meant: &'static str,
}

impl Directive {
    /// Reads the directive whose `#` is the raw token `first`. `defines` is the number of `#define`s before
    /// it in the file.
    pub fn parse(text: &str, raw: &RawTokens, first: usize, defines: &mut u32) -> Directive {
        let mut end = first;
        while !matches!(raw.kind(end), NEWLINE | EOF) {
            end += 1;
        }
        let mut line = Line { text, raw, at: first + 1, end };
        let mut misspelt = None;
        let (keyword, kind) = match line.word() {
            Some(word) => {
                let meant = nearest(&word.text, WORDS).filter(|_| !WORDS.contains(&&*word.text));
                misspelt = meant.map(|meant| Misspelt { word: word.clone(), meant });
                let kind = line.kind(meant.unwrap_or(&word.text), defines);
                (Some(word), kind)
            }
            None if line.rest().is_empty() => (None, DirectiveKind::Empty),
            None => (None, DirectiveKind::Unknown),
        };
        if let DirectiveKind::Pragma(Pragma { misspelt: node, .. }) = &kind {
            misspelt = misspelt.or_else(|| node.clone());
        }
        let last = (first..end).rev().find(|&i| !is_trivia(raw.kind(i))).unwrap_or(first);
        let mut range = text_range(raw.start(first), raw.start(last + 1));
        if let DirectiveKind::Include(operand) = &kind {
            range = range.cover(operand.range);
        }
        Directive {
            first: first as u32,
            end: end as u32,
            range,
            keyword,
            kind,
            misspelt,
            active: true,
            taken: None,
        }
    }

    /// Opens a conditional group.
    pub(crate) fn is_opening(&self) -> bool {
        matches!(
            self.kind,
            DirectiveKind::If(_) | DirectiveKind::Ifdef(_) | DirectiveKind::Ifndef(_)
        )
    }
}

impl Pragma {
    /// Splits the content of a `_Pragma` string into words; `range` is the range of the string.
    pub(crate) fn from_operator(literal: &str, range: TextRange) -> Pragma {
        let mut content = String::new();
        let mut chars = unquote(literal).chars().peekable();
        while let Some(char) = chars.next() {
            let escaped = chars.next_if(|&next| char == '\\' && matches!(next, '"' | '\\'));
            content.push(escaped.unwrap_or(char));
        }
        let raw = lex(&content);
        let mut words = Line { text: &content, raw: &raw, at: 0, end: raw.len() }.pragma_words();
        for word in &mut words {
            word.range = range;
        }
        Pragma::from_words(words, true)
    }

    fn from_words(words: Vec<PragmaArg>, operator: bool) -> Pragma {
        let mut words = words.into_iter();
        let mut name = words.next().map(|word| Name { text: word.text, range: word.range });
        let mut misspelt = None;
        if let Some(name) = &mut name
            && !PRAGMAS.contains(&&*name.text)
            && let Some(meant) = nearest(&name.text, PRAGMAS)
        {
            misspelt = Some(Misspelt { word: name.clone(), meant });
            name.text = meant.into();
        }
        Pragma { name, args: words.collect(), operator, misspelt }
    }
}

/// The content of a string token, without its quotes.
pub(crate) fn unquote(literal: &str) -> &str {
    let content = literal.strip_prefix('"').unwrap_or(literal);
    content.strip_suffix('"').unwrap_or(content)
}

pub(crate) fn text_range(start: usize, end: usize) -> TextRange {
    TextRange::new(TextSize::new(start as u32), TextSize::new(end as u32))
}

/// A cursor over the raw tokens of one directive.
struct Line<'a> {
    text: &'a str,
    raw: &'a RawTokens,
    at: usize,
    end: usize,
}

impl Line<'_> {
    fn skip_trivia(&mut self) {
        while self.at < self.end && is_trivia(self.raw.kind(self.at)) {
            self.at += 1;
        }
    }

    /// Kind of the next token, blanks included.
    fn next_kind(&self) -> SyntaxKind {
        if self.at < self.end { self.raw.kind(self.at) } else { EOF }
    }

    /// Skips blanks and returns the kind of the next token.
    fn peek(&mut self) -> SyntaxKind {
        self.skip_trivia();
        self.next_kind()
    }

    fn eat(&mut self, kind: SyntaxKind) -> bool {
        let found = self.peek() == kind;
        self.at += usize::from(found);
        found
    }

    fn word(&mut self) -> Option<Name> {
        let kind = self.peek();
        if kind == EOF || !is_word(kind, self.raw.text(self.text, self.at)) {
            return None;
        }
        let text = SmolStr::new(self.raw.clean_text(self.text, self.at));
        let range = self.raw.range(self.at);
        self.at += 1;
        Some(Name { text, range: text_range(range.start, range.end) })
    }

    /// The tokens left, without blanks around them.
    fn rest(&mut self) -> Range<u32> {
        self.skip_trivia();
        let mut end = self.end;
        while end > self.at && is_trivia(self.raw.kind(end - 1)) {
            end -= 1;
        }
        self.at as u32..end as u32
    }

    fn rest_text(&mut self) -> SmolStr {
        let rest = self.rest();
        let mut text = String::new();
        for i in rest {
            if self.raw.kind(i as usize) != SPLICE {
                text.push_str(&self.raw.clean_text(self.text, i as usize));
            }
        }
        text.into()
    }

    fn kind(&mut self, word: &str, defines: &mut u32) -> DirectiveKind {
        match word {
            "include" => DirectiveKind::Include(self.include()),
            "define" => {
                let ordinal = *defines;
                *defines += 1;
                DirectiveKind::Define(self.define(ordinal))
            }
            "undef" => DirectiveKind::Undef(self.operand()),
            "if" => DirectiveKind::If(self.rest()),
            "elif" => DirectiveKind::Elif(self.rest()),
            "ifdef" => DirectiveKind::Ifdef(self.operand()),
            "ifndef" => DirectiveKind::Ifndef(self.operand()),
            "else" => DirectiveKind::Else(self.rest()),
            "endif" => DirectiveKind::Endif(self.rest()),
            "error" => DirectiveKind::Error(self.rest_text()),
            "warning" => DirectiveKind::Warning(self.rest_text()),
            "line" => DirectiveKind::Line(self.rest()),
            "pragma" => DirectiveKind::Pragma(Pragma::from_words(self.pragma_words(), false)),
            _ => DirectiveKind::Unknown,
        }
    }

    fn operand(&mut self) -> Operand {
        let name = self.word();
        Operand { name, rest: self.rest() }
    }

    fn include(&mut self) -> IncludeOperand {
        let kind = self.peek();
        let start = self.raw.start(self.at);
        let spelled = self.text.get(start..self.raw.start(self.end)).unwrap_or("");
        match kind {
            STRING => {
                let path = SmolStr::new(unquote(&self.raw.clean_text(self.text, self.at)));
                let range = self.raw.range(self.at);
                self.at += 1;
                IncludeOperand {
                    form: IncludeForm::Quoted(path),
                    range: text_range(range.start, range.end),
                    rest: self.rest(),
                }
            }
            // The file name is taken from the text, since it need not consist of tokens: it may even contain
            // `//`.
            _ if spelled.starts_with('<') && spelled.contains('>') => {
                let len = spelled.find('>').unwrap_or(0);
                let path = spelled.get(1..len).unwrap_or("");
                let path = path.replace("\\\r\n", "").replace("\\\n", "").replace("\\\r", "");
                while self.at < self.end && self.raw.start(self.at) <= start + len {
                    self.at += 1;
                }
                IncludeOperand {
                    form: IncludeForm::Angled(path.into()),
                    range: text_range(start, start + len + 1),
                    rest: self.rest(),
                }
            }
            _ => {
                let rest = self.rest();
                let range = text_range(
                    self.raw.start(rest.start as usize),
                    self.raw.start(rest.end as usize),
                );
                IncludeOperand {
                    form: IncludeForm::Macro(rest.clone()),
                    range,
                    rest: rest.end..rest.end,
                }
            }
        }
    }

    fn define(&mut self, ordinal: u32) -> Define {
        let name = self.word();
        while self.next_kind() == SPLICE {
            self.at += 1;
        }
        let next = self.next_kind();
        let params = (name.is_some() && next == L_PAREN).then(|| self.params());
        let glued = name.is_some() && params.is_none() && next != EOF && !is_trivia(next);
        Define { name, params, body: self.rest(), glued, ordinal }
    }

    fn params(&mut self) -> Params {
        let mut params = Params { names: Vec::new(), variadic: false, well_formed: true };
        self.eat(L_PAREN);
        if self.eat(R_PAREN) {
            return params;
        }
        loop {
            if let Some(name) = self.word() {
                params.names.push(name);
            } else if self.eat(DOT) && self.eat(DOT) && self.eat(DOT) {
                params.variadic = true;
            } else {
                break;
            }
            if self.eat(R_PAREN) {
                return params;
            }
            if params.variadic || !self.eat(COMMA) {
                break;
            }
        }
        params.well_formed = false;
        while self.at < self.end && !self.eat(R_PAREN) {
            self.at += 1;
        }
        params
    }

    /// The words of a pragma. In pragmas that the reference compiler knows, comments count as words.
    fn pragma_words(&mut self) -> Vec<PragmaArg> {
        let words = self.split_words(false);
        let name = words.first().map_or("", |word| word.text.as_str());
        match name {
            "requires" | "require" | "provides" | "provide" | "masquerade" => {
                self.split_words(true)
            }
            _ => words,
        }
    }

    fn split_words(&self, comments: bool) -> Vec<PragmaArg> {
        let mut words = Vec::new();
        let mut word = String::new();
        let mut range: Option<TextRange> = None;
        let mut end_word = |word: &mut String, range: &mut Option<TextRange>, quoted| {
            if let Some(range) = range.take() {
                words.push(PragmaArg { text: SmolStr::new(&word), quoted, range });
            }
            word.clear();
        };
        for i in self.at..self.end {
            let kind = self.raw.kind(i);
            let is_comment = kind.is_comment() && comments;
            if is_trivia(kind) && !is_comment {
                if kind != SPLICE {
                    end_word(&mut word, &mut range, false);
                }
                continue;
            }
            let text = self.raw.clean_text(self.text, i);
            let bytes = self.raw.range(i);
            let token = text_range(bytes.start, bytes.end);
            if is_comment {
                for (number, part) in text.split_ascii_whitespace().enumerate() {
                    if number > 0 {
                        end_word(&mut word, &mut range, false);
                    }
                    word.push_str(part);
                    range = Some(range.map_or(token, |range| range.cover(token)));
                }
            } else if matches!(kind, STRING | OPEN_STRING) && text.starts_with('"') {
                // `L"…"` is the same.
                if word == "L" {
                    word.clear();
                    range = None;
                }
                end_word(&mut word, &mut range, false);
                word.push_str(unquote(&text));
                range = Some(token);
                end_word(&mut word, &mut range, true);
            } else {
                word.push_str(&text);
                range = Some(range.map_or(token, |range| range.cover(token)));
            }
        }
        end_word(&mut word, &mut range, false);
        words
    }
}

#[cfg(test)]
mod tests;
