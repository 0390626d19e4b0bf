//! Macro expansion.
//!
//! Expansions are a stack of token lists, as in C compilers: the replacement of a macro is pushed and read
//! again. While its list is on the stack the macro is disabled, and its name in the list is marked
//! permanently. Arguments may extend from the lists into the text of the file, which the source at the bottom
//! of the stack provides.

mod arguments;

use rowan::TextRange;
use rustc_hash::FxHashMap;
use smol_str::SmolStr;

use arguments::Args;

use super::{
    MacroSite, MacroUse, Origin,
    definition::{BodyToken, Macro, MacroKind, Role, spaced},
    env::MacroEnv,
    token::{Token, paste, stringize},
};
use crate::{
    SyntaxKind,
    directive::text_range,
    finding::preprocessing::Preprocessing,
    kind::SyntaxKind::*,
    lexer::{RawTokens, is_trivia, is_word},
    line_index::LineIndex,
};

/// Maximum number of tokens that expansions may produce in one file, besides four for each of its own tokens.
/// Stops macros that grow exponentially.
const BUDGET: usize = 1 << 18;
/// Maximum length of a token in bytes; longer ones come only from pasting and stringizing in a loop.
const MAX_TOKEN_LEN: usize = 1 << 16;
/// Maximum nesting of macro calls in arguments of macro calls.
const MAX_DEPTH: u32 = 128;

/// An error in a call.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct CallProblem {
    pub(crate) kind: Preprocessing,
    /// The end of the call as far as it was read, if it is read from the text of the file.
    pub(crate) end: Option<u32>,
}

/// The raw tokens of a file from which arguments may be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Source {
    /// The next raw token.
    pub(crate) next: u32,
    /// One past the last that may be read.
    pub(crate) end: u32,
}

/// Expands macros in one file.
pub(crate) struct Expander<'a> {
    file: &'a SmolStr,
    text: &'a str,
    raw: &'a RawTokens,
    lines: Option<LineIndex>,
    budget: usize,
    /// True if the budget is used up, which has been reported.
    exhausted: bool,
    /// True if a call that runs to the end of the file has been reported.
    open_call: bool,
    /// True in the operand of `#if`: the operand of `defined` is left alone.
    pub(crate) in_condition: bool,
    pub(crate) uses: Vec<MacroUse>,
    pub(crate) problems: Vec<CallProblem>,
}

/// The state of one expansion.
struct Expansion<'r> {
    env: &'r MacroEnv,
    stack: Vec<PendingTokens>,
    source: Option<&'r mut Source>,
    depth: u32,
    /// The raw token at which the outermost call begins.
    at: u32,
}

/// Tokens to read, and the macro they come from.
struct PendingTokens {
    tokens: std::vec::IntoIter<Token>,
    name: Option<SmolStr>,
}

type Disabled = FxHashMap<SmolStr, u32>;

impl<'a> Expander<'a> {
    pub(crate) fn new(file: &'a SmolStr, text: &'a str, raw: &'a RawTokens) -> Expander<'a> {
        Expander {
            file,
            text,
            raw,
            lines: None,
            budget: BUDGET.saturating_add(raw.len().saturating_mul(4)),
            exhausted: false,
            open_call: false,
            in_condition: false,
            uses: Vec::new(),
            problems: Vec::new(),
        }
    }

    /// A raw token of the file.
    pub(crate) fn token(&self, i: u32) -> Token {
        let at = i as usize;
        Token {
            kind: self.raw.kind(at),
            text: SmolStr::new(self.raw.clean_text(self.text, at)),
            spaced: spaced(self.raw, at),
            origin: Origin::Argument(i),
            painted: false,
        }
    }

    /// Expands the macro named by the raw token `i`. Arguments are read from `source`, which is advanced past
    /// them. `None` if the name is not a macro, or if the macro is not called.
    pub(crate) fn call(
        &mut self,
        env: &MacroEnv,
        i: u32,
        source: &mut Source,
    ) -> Option<Vec<Token>> {
        let token = self.token(i);
        let definition = env.get(&token.text)?;
        if self.exhausted {
            return None;
        }
        let start = *source;
        if matches!(definition.kind, MacroKind::Function { .. }) {
            let after_blanks = self.skip_blanks(*source)?;
            if self.raw.kind(after_blanks as usize) != L_PAREN {
                return None;
            }
        }
        let mut run = Expansion { env, stack: Vec::new(), source: Some(source), depth: 0, at: i };
        run.push(vec![token], None);
        let tokens = self.run(&mut run, &mut Disabled::default());
        // A call with errors is left as it is.
        let unread = *source == start
            && matches!(&tokens[..], [only] if only.origin == Origin::Argument(i) && only.painted);
        (!unread).then_some(tokens)
    }

    /// Expands the operand of a directive.
    pub(crate) fn operand(&mut self, env: &MacroEnv, tokens: Vec<Token>, at: u32) -> Vec<Token> {
        let mut run = Expansion { env, stack: Vec::new(), source: None, depth: 0, at };
        run.push(tokens, None);
        self.run(&mut run, &mut Disabled::default())
    }

    fn run(&mut self, run: &mut Expansion<'_>, disabled: &mut Disabled) -> Vec<Token> {
        let mut out = Vec::new();
        while let Some(mut token) = run.next(disabled) {
            if token.painted || self.exhausted || !is_word(token.kind, &token.text) {
                out.push(token);
                continue;
            }
            if self.in_condition && token.text == "defined" {
                out.push(token);
                self.defined_operand(run, disabled, &mut out);
                continue;
            }
            let Some(definition) = run.env.get(&token.text) else {
                if self.in_condition {
                    self.record(&token, None);
                }
                out.push(token);
                continue;
            };
            if disabled.get(&token.text).is_some_and(|&count| count > 0) {
                token.painted = true;
                out.push(token);
                continue;
            }
            let definition = definition.clone();
            let expansion = match &definition.kind {
                MacroKind::Object => {
                    let args: &mut Args = &mut Args::default();
                    self.record(&token, Some(&definition.site));
                    self.substitute(run, disabled, &definition, args, &token)
                }
                MacroKind::File | MacroKind::Line => {
                    self.record(&token, Some(&definition.site));
                    vec![self.position(&definition.kind, run.at, &token)]
                }
                MacroKind::Function { params, variadic } => {
                    if !self.opens_call(run) {
                        out.push(token);
                        continue;
                    }
                    match self.arguments(run, disabled, &definition, params.len(), *variadic) {
                        Ok(mut args) => {
                            self.record(&token, Some(&definition.site));
                            self.substitute(run, disabled, &definition, &mut args, &token)
                        }
                        Err(read) => {
                            token.painted = true;
                            out.push(token);
                            out.extend(read);
                            continue;
                        }
                    }
                }
            };
            if self.take_from_budget(expansion.len() + 1, &definition) {
                *disabled.entry(definition.name.clone()).or_default() += 1;
                run.push(expansion, Some(definition.name.clone()));
            } else {
                token.painted = true;
                out.push(token);
            }
        }
        out
    }

    /// Takes tokens from the budget; reports, once, when it is used up.
    fn take_from_budget(&mut self, tokens: usize, definition: &Macro) -> bool {
        if let Some(left) = self.budget.checked_sub(tokens) {
            self.budget = left;
            return true;
        }
        if !self.exhausted {
            self.exhausted = true;
            // Calls without an end are read repeatedly: they have been reported.
            if self.open_call {
                return false;
            }
            self.limit(Preprocessing::TooManyTokens { name: definition.name.clone() });
        }
        false
    }

    fn limit(&mut self, kind: Preprocessing) {
        self.problems.push(CallProblem { kind, end: None });
    }

    fn record(&mut self, token: &Token, site: Option<&MacroSite>) {
        if let Origin::Argument(i) = token.origin {
            let range = self.raw_range(i);
            self.uses.push(MacroUse { name: token.text.clone(), range, site: site.cloned() });
        }
    }

    pub(crate) fn raw_range(&self, i: u32) -> TextRange {
        let range = self.raw.range(i as usize);
        text_range(range.start, range.end)
    }

    /// Passes `NAME` or `(NAME)` after `defined` through unchanged.
    fn defined_operand(
        &mut self,
        run: &mut Expansion<'_>,
        disabled: &mut Disabled,
        out: &mut Vec<Token>,
    ) {
        for _ in 0..2 {
            let Some(token) = run.next(disabled) else {
                return;
            };
            let is_name = is_word(token.kind, &token.text);
            let is_paren = token.kind == L_PAREN;
            if is_name {
                let site = run.env.get(&token.text).map(|environment| environment.site.clone());
                self.record(&token, site.as_ref());
            }
            out.push(token);
            if is_name || !is_paren {
                return;
            }
        }
    }

    /// The value of `__FILE__` or `__LINE__`.
    fn position(&mut self, kind: &MacroKind, at: u32, name: &Token) -> Token {
        let (kind, text) = if kind == &MacroKind::File {
            let escaped = self.file.replace('\\', "\\\\").replace('"', "\\\"");
            (STRING, format!("\"{escaped}\""))
        } else {
            let lines = self.lines.get_or_insert_with(|| LineIndex::new(self.text));
            let offset = self.raw.start(at as usize) as u32;
            (INT, (lines.line(offset.into()) + 1).to_string())
        };
        let text = text.into();
        Token { kind, text, spaced: name.spaced, origin: Origin::Synthetic, painted: true }
    }

    /// Returns true if the next token to read is a parenthesis.
    fn opens_call(&self, run: &Expansion<'_>) -> bool {
        for list in run.stack.iter().rev() {
            if let Some(token) = list.tokens.as_slice().first() {
                return token.kind == L_PAREN;
            }
        }
        let next = run.source.as_deref().and_then(|source| self.skip_blanks(*source));
        next.is_some_and(|next| self.raw.kind(next as usize) == L_PAREN)
    }

    /// The next raw token that is not a blank. Comments count: a parenthesis behind one does not open a call.
    fn skip_blanks(&self, source: Source) -> Option<u32> {
        let is_blank = |kind: SyntaxKind| is_trivia(kind) && !kind.is_comment();
        (source.next..source.end).find(|&i| !is_blank(self.raw.kind(i as usize)))
    }

    /// The body of a macro with its parameters replaced.
    fn substitute(
        &mut self,
        run: &mut Expansion<'_>,
        disabled: &mut Disabled,
        definition: &Macro,
        args: &mut Args,
        name: &Token,
    ) -> Vec<Token> {
        let mut out: Vec<Token> = Vec::with_capacity(definition.body.len());
        // True if the operand on the left of the next `##` has tokens.
        let mut left = false;
        let body = &definition.body;
        for (i, token) in body.iter().enumerate() {
            let after_paste = i > 0 && body[i - 1].is_paste();
            let pasted = after_paste || body.get(i + 1).is_some_and(BodyToken::is_paste);
            let mut operand = match token.role {
                Role::Paste => continue,
                Role::Plain => vec![Token {
                    kind: token.kind,
                    text: token.text.clone(),
                    spaced: token.spaced,
                    origin: Origin::Body(definition.site.clone()),
                    painted: false,
                }],
                Role::Stringize(param) => {
                    vec![stringize(
                        args.spelled.get(param as usize).map_or(&[][..], |spelled| spelled),
                    )]
                }
                Role::Param(param) if pasted => {
                    args.spelled.get(param as usize).cloned().unwrap_or_default()
                }
                Role::Param(param) => self.argument(run, disabled, args, param as usize),
            };
            if let Some(first) = operand.first_mut() {
                first.spaced = token.spaced;
            }
            let too_long = operand.iter().any(|operand| operand.text.len() > MAX_TOKEN_LEN);
            if too_long || operand.len() + out.len() > self.budget {
                self.take_from_budget(usize::MAX, definition);
                return Vec::new();
            }
            if !after_paste {
                left = !operand.is_empty();
                out.append(&mut operand);
                continue;
            }
            let has_tokens = !operand.is_empty();
            let mut operand = operand.into_iter();
            if left
                && has_tokens
                && let (Some(lhs), Some(rhs)) = (out.pop(), operand.next())
            {
                paste(&lhs, &rhs, &mut out);
            }
            left |= has_tokens;
            out.extend(operand);
        }
        if let Some(first) = out.first_mut() {
            first.spaced = name.spaced;
        }
        out
    }

    /// An argument after its own expansion.
    fn argument(
        &mut self,
        run: &mut Expansion<'_>,
        disabled: &mut Disabled,
        args: &mut Args,
        param: usize,
    ) -> Vec<Token> {
        let (Some(spelled), Some(expanded)) =
            (args.spelled.get(param), args.expanded.get_mut(param))
        else {
            return Vec::new();
        };
        if let Some(expanded) = expanded {
            return expanded.clone();
        }
        if run.depth >= MAX_DEPTH {
            if !self.exhausted {
                self.exhausted = true;
                self.limit(Preprocessing::TooManyCalls { most: MAX_DEPTH as usize });
            }
            return spelled.clone();
        }
        let mut inner = Expansion {
            env: run.env,
            stack: Vec::new(),
            source: None,
            depth: run.depth + 1,
            at: run.at,
        };
        inner.push(spelled.clone(), None);
        let tokens = self.run(&mut inner, disabled);
        *expanded = Some(tokens.clone());
        tokens
    }
}

impl Expansion<'_> {
    fn push(&mut self, tokens: Vec<Token>, name: Option<SmolStr>) {
        self.stack.push(PendingTokens { tokens: tokens.into_iter(), name });
    }

    /// The next token of the lists. A list that is used up enables its macro again.
    fn next(&mut self, disabled: &mut Disabled) -> Option<Token> {
        loop {
            let list = self.stack.last_mut()?;
            if let Some(token) = list.tokens.next() {
                return Some(token);
            }
            let list = self.stack.pop()?;
            if let Some(count) = list.name.and_then(|name| disabled.get_mut(&name)) {
                *count -= 1;
            }
        }
    }
}
