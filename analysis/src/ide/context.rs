//! The position of the cursor in the structure, read from the tokens before it: the open brackets and the
//! text since the last `;`, `{` or `,` in each.
//!
//! Incomplete text seldom has a useful tree around the cursor, but the tokens before it nearly always
//! suffice. The text after the cursor ([`TextAfter`]) only removes completion items.

use std::ops::Range;

use dotgen_syntax::{Fragment, SyntaxElement, SyntaxKind, WalkEvent, lexer::is_word};
use smol_str::SmolStr;

use super::FileView;
use crate::source_map::bytes;
pub(crate) use text_after::TextAfter;

mod text_after;

/// A token before the cursor, macros expanded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Word {
    pub(crate) kind: SyntaxKind,
    pub(crate) text: SmolStr,
    /// Range in the file; for a token from a macro, the range of the call.
    pub(crate) range: Range<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BodyKind {
    Specification,
    Module,
    Component,
    Interface,
    Members,
    Ids,
    Cases,
    Enum,
    Task,
    Port,
    Attribute,
    Function,
    Activity,
    /// The braces of an unknown construct.
    Unknown,
}

/// The construct that a bracket opens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FrameKind {
    /// `{ }` around statements, or a whole file.
    Body(BodyKind),
    /// `( )`
    Paren,
    /// `[ ]`
    Bracket,
    /// `{ }` around initializers.
    Initializers,
}

/// An open bracket.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    pub(crate) kind: FrameKind,
    /// Index of the first token of the statement with the bracket.
    pub(crate) head: usize,
    /// Index of the bracket; equal to `head` for a whole file.
    pub(crate) open: usize,
    /// Index of the first token of the statement, or of the list element, around the cursor.
    pub(crate) start: usize,
    /// Number of commas since the bracket.
    pub(crate) commas: usize,
    /// First words of the statements that ended in it.
    pub(crate) given: Vec<SmolStr>,
}

/// The context of a cursor; see the module.
#[derive(Debug, Clone)]
pub(crate) struct Context {
    /// All active tokens before the word under the cursor.
    pub(crate) tokens: Vec<Word>,
    /// Outermost first; never empty.
    pub(crate) frames: Vec<Frame>,
    /// The word around or before the cursor; empty at the cursor if there is none.
    pub(crate) word: Range<usize>,
    /// The text after the word.
    pub(crate) after: TextAfter,
}

/// The kind of text around the cursor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Surroundings {
    /// Declarations.
    Code,
    /// A directive line: index of the directive.
    Directive(u32),
    /// A string that is not part of a directive: its range, quotes included.
    String(Range<usize>),
    /// A comment, or text excluded by a conditional.
    Dead,
}

/// The kind of text at an offset.
pub(crate) fn surroundings(view: &FileView<'_>, at: usize) -> Surroundings {
    let (raw, pre) = (view.raw(), view.pre());
    // The tokens that touch the cursor from the left decide, since they are being typed.
    let touching = (0..raw.len()).filter(|&i| raw.range(i).start < at && at <= raw.range(i).end);
    let directive = pre.directives.iter().position(|directive| {
        usize::from(directive.range.start()) < at
            && at <= line_end(view.text(), directive.range.end().into())
    });
    for i in touching {
        let range = raw.range(i);
        match raw.kind(i) {
            SyntaxKind::LINE_COMMENT | SyntaxKind::OPEN_COMMENT => return Surroundings::Dead,
            SyntaxKind::BLOCK_COMMENT if at < range.end => return Surroundings::Dead,
            SyntaxKind::STRING if at < range.end && directive.is_none() => {
                return Surroundings::String(range);
            }
            SyntaxKind::OPEN_STRING if directive.is_none() => return Surroundings::String(range),
            _ => {}
        }
    }
    if let Some(directive) = directive
        && pre.directives[directive].active
    {
        return Surroundings::Directive(directive as u32);
    }
    let dead = |range: &dotgen_syntax::TextRange| {
        usize::from(range.start()) <= at && at < usize::from(range.end())
    };
    if pre.inactive.iter().any(dead) {
        return Surroundings::Dead;
    }
    Surroundings::Code
}

/// Blanks at the end of a directive line belong to it.
fn line_end(text: &str, end: usize) -> usize {
    let blanks =
        text.get(end..).map_or(0, |rest| rest.len() - rest.trim_start_matches([' ', '\t']).len());
    end + blanks
}

impl Context {
    /// Reads the tokens before a cursor.
    pub(crate) fn new(view: &FileView<'_>, at: usize) -> Context {
        let word = word_at(view, at);
        let tokens = tokens_before(view, word.start);
        let body = match view.key.fragment(view.db) {
            Fragment::Specification => BodyKind::Specification,
            Fragment::Module => BodyKind::Module,
            Fragment::Component => BodyKind::Component,
            Fragment::Members => BodyKind::Members,
            Fragment::Cases => BodyKind::Cases,
            Fragment::Properties => BodyKind::Activity,
        };
        let mut reader = Reader {
            text: view.text(),
            tokens: &tokens,
            frames: vec![Frame::new(FrameKind::Body(body), 0, 0, 0)],
        };
        for i in 0..tokens.len() {
            reader.token(i);
        }
        let frames = reader.frames;
        let after = TextAfter::new(view, word.end.max(at));
        Context { tokens, frames, word, after }
    }

    /// The innermost open bracket.
    pub(crate) fn top(&self) -> &Frame {
        match self.frames.last() {
            Some(frame) => frame,
            None => unreachable!("the file is a frame"),
        }
    }

    /// The statement or list element before the cursor, without the word under it.
    pub(crate) fn current(&self) -> &[Word] {
        &self.tokens[self.top().start.min(self.tokens.len())..]
    }

    /// The elements after the cursor in its list. The first is the element around the cursor, unless the
    /// cursor is before another element.
    pub(crate) fn elements_behind(&self) -> impl Iterator<Item = &[Word]> {
        let next = self.after.next();
        let in_front =
            self.word.is_empty() && next.is_some_and(|word| word.kind == SyntaxKind::IDENT);
        let all = self.after.list().split(|word| word.is(","));
        all.skip(usize::from(!in_front))
    }

    /// The tokens before a bracket, from the start of its statement or element.
    pub(crate) fn head(&self, frame: &Frame) -> &[Word] {
        &self.tokens[frame.head..frame.open]
    }

    /// The innermost body.
    pub(crate) fn body(&self) -> (BodyKind, &Frame) {
        let bodies = self.frames.iter().rev();
        let mut bodies = bodies.filter_map(|body| match body.kind {
            FrameKind::Body(kind) => Some((kind, body)),
            _ => None,
        });
        match bodies.next() {
            Some(body) => body,
            None => unreachable!("the file is a body"),
        }
    }

    /// The name a body was opened with.
    pub(crate) fn name_of(&self, frame: &Frame) -> Option<SmolStr> {
        let head = self.head(frame);
        let FrameKind::Body(kind) = frame.kind else {
            return None;
        };
        match kind {
            BodyKind::Ids => Some("ids".into()),
            BodyKind::Members | BodyKind::Enum => Some(head.last()?.text.clone()),
            BodyKind::Cases => {
                let union = head.iter().rposition(|word| word.is("union"))?;
                Some(head.get(union + 1)?.text.clone())
            }
            BodyKind::Attribute | BodyKind::Function | BodyKind::Activity => {
                Some(head.get(1)?.text.clone())
            }
            BodyKind::Specification | BodyKind::Unknown => None,
            _ => head.get(1).map(|head| head.text.clone()),
        }
    }
}

impl Word {
    /// Returns true if the word is spelled like this.
    pub(crate) fn is(&self, text: &str) -> bool {
        self.text == text
    }

    /// Returns true if the word is one of these.
    pub(crate) fn is_any(&self, texts: &[&str]) -> bool {
        texts.contains(&self.text.as_str())
    }
}

impl Frame {
    fn new(kind: FrameKind, head: usize, open: usize, start: usize) -> Frame {
        Frame { kind, head, open, start, commas: 0, given: Vec::new() }
    }
}

/// The word around or before an offset.
pub(crate) fn word_at(view: &FileView<'_>, at: usize) -> Range<usize> {
    let (raw, text) = (view.raw(), view.text());
    let at = at.min(text.len());
    if at == 0 || raw.is_empty() {
        return at..at;
    }
    let i = raw.token_at(at - 1).min(raw.len() - 1);
    if is_word(raw.kind(i), raw.text(text, i)) { raw.range(i) } else { at..at }
}

fn tokens_before(view: &FileView<'_>, end: usize) -> Vec<Word> {
    let mut out = Vec::new();
    let map = view.map();
    let mut preorder = view.root().preorder_with_tokens();
    while let Some(event) = preorder.next() {
        let WalkEvent::Enter(element) = event else {
            continue;
        };
        if usize::from(element.text_range().start()) > end {
            break;
        }
        let token = match element {
            SyntaxElement::Node(node) => {
                if matches!(
                    node.kind(),
                    SyntaxKind::DIRECTIVE | SyntaxKind::INACTIVE | SyntaxKind::MACRO_CALL
                ) {
                    preorder.skip_subtree();
                }
                continue;
            }
            SyntaxElement::Token(token) => token,
        };
        let range = bytes(map.range(&token));
        if token.kind().is_trivia() || range.end > end {
            continue;
        }
        let text = map.text(&token);
        if text.is_empty() {
            continue;
        }
        out.push(Word {
            kind: match token.kind() {
                kind if kind.is_keyword() => SyntaxKind::IDENT,
                kind => kind,
            },
            text,
            range,
        });
    }
    out
}

/// Words that nearly always begin a statement: a statement without its `;` ends where one of them begins a
/// line.
const STATEMENTS: &[&str] = &[
    "activity",
    "async",
    "attribute",
    "codel",
    "component",
    "const",
    "exception",
    "function",
    "interface",
    "module",
    "typedef",
    "validate",
];

struct Reader<'a> {
    text: &'a str,
    tokens: &'a [Word],
    frames: Vec<Frame>,
}

impl Reader<'_> {
    fn token(&mut self, i: usize) {
        use SyntaxKind::*;
        self.recover(i);
        match self.tokens[i].kind {
            L_CURLY => {
                let kind = self.brace(i);
                self.open(kind, i);
            }
            L_PAREN => self.open(FrameKind::Paren, i),
            L_BRACK => self.open(FrameKind::Bracket, i),
            R_PAREN => self.close(|kind| kind == FrameKind::Paren),
            R_BRACK => self.close(|kind| kind == FrameKind::Bracket),
            R_CURLY => self.close_brace(i),
            SEMICOLON => {
                while !matches!(self.top().kind, FrameKind::Body(_)) && self.frames.len() > 1 {
                    self.frames.pop();
                }
                self.end_statement(i + 1);
            }
            COMMA => {
                let body = matches!(self.top().kind, FrameKind::Body(_));
                // The element continues between a type and its bound.
                if body || !self.is_in_type(i) {
                    let top = self.top();
                    top.commas += 1;
                    if !body {
                        top.start = i + 1;
                    }
                }
            }
            _ => {}
        }
    }

    /// Returns true if a token is between the angle brackets of a type.
    fn is_in_type(&mut self, i: usize) -> bool {
        let start = self.top().start.min(i);
        let mut depth = 0_i32;
        for token in start..i {
            let opens =
                token > 0 && self.tokens[token - 1].is_any(&["sequence", "optional", "string"]);
            match self.tokens[token].text.as_str() {
                "<" if opens => depth += 1,
                ">" if depth > 0 => depth -= 1,
                ">>" => depth = (depth - 2).max(0),
                // A direction begins a parameter: the bracket is missing.
                "in" | "out" | "inout" => depth = 0,
                _ => {}
            }
        }
        depth > 0
    }

    /// Closes brackets that the author did not close.
    fn recover(&mut self, i: usize) {
        let word = &self.tokens[i];
        if !STATEMENTS.contains(&word.text.as_str()) || self.frames.len() < 2 && i == 0 {
            return;
        }
        let before = i.checked_sub(1).map(|before| &self.tokens[before]);
        let line = self.text.get(..word.range.start).unwrap_or_default();
        let begins_line = line.rsplit('\n').next().is_some_and(|part| part.trim().is_empty());
        let continues = before.is_some_and(|token| {
            use SyntaxKind::*;
            token.text == "async" || matches!(token.kind, COLON2 | DOT | EQ | SEMICOLON)
        });
        if !begins_line || continues {
            return;
        }
        let body = self.frames.iter().rposition(
            |frame| matches!(frame.kind, FrameKind::Body(body) if body != BodyKind::Enum),
        );
        self.frames.truncate(body.unwrap_or(0) + 1);
        if word.is_any(&["component", "interface"]) {
            self.frames.truncate(1);
        } else if word.is_any(&["attribute", "function", "activity"]) {
            while self.frames.len() > 1
                && !matches!(
                    self.top().kind,
                    FrameKind::Body(BodyKind::Component | BodyKind::Interface)
                )
            {
                self.frames.pop();
            }
        }
        if self.top().start < i {
            self.end_statement(i);
        }
    }

    fn top(&mut self) -> &mut Frame {
        match self.frames.last_mut() {
            Some(frame) => frame,
            None => unreachable!("the file is never closed"),
        }
    }

    fn open(&mut self, kind: FrameKind, at: usize) {
        let head = self.top().start;
        self.frames.push(Frame::new(kind, head, at, at + 1));
    }

    fn close(&mut self, wanted: impl Fn(FrameKind) -> bool) {
        let brace =
            |frame: &Frame| matches!(frame.kind, FrameKind::Body(_) | FrameKind::Initializers);
        let within = self.frames.iter().rposition(brace).unwrap_or(0) + 1;
        let found = self.frames[within..].iter().rposition(|frame| wanted(frame.kind));
        if let Some(found) = found {
            self.frames.truncate(within + found);
        }
    }

    fn close_brace(&mut self, i: usize) {
        let brace =
            |frame: &Frame| matches!(frame.kind, FrameKind::Body(_) | FrameKind::Initializers);
        let Some(at) = self.frames.iter().rposition(brace).filter(|depth| *depth > 0) else {
            // A superfluous bracket: a new statement follows.
            self.end_statement(i + 1);
            return;
        };
        let kind = self.frames[at].kind;
        self.frames.truncate(at);
        use BodyKind::*;
        if let FrameKind::Body(
            Module | Component | Interface | Ids | Task | Port | Attribute | Function | Activity
            | Unknown,
        ) = kind
        {
            self.end_statement(i + 1);
        }
    }

    fn end_statement(&mut self, next: usize) {
        let start = self.top().start;
        let first = self.tokens.get(start).filter(|_| start < next);
        let first = first.map(|token| token.text.clone());
        let top = self.top();
        top.given.extend(first.filter(|text| text != ";"));
        top.start = next;
        top.commas = 0;
    }

    /// The construct that the brace at `i` opens.
    fn brace(&mut self, i: usize) -> FrameKind {
        let top = self.top();
        let (kind, start) = (top.kind, top.start);
        let statement = &self.tokens[start.min(i)..i];
        let before = statement.len().checked_sub(2).map(|before| &statement[before]);
        if let Some(before) = before {
            if before.is("struct") {
                return FrameKind::Body(BodyKind::Members);
            }
            if before.is("enum") {
                return FrameKind::Body(BodyKind::Enum);
            }
        }
        let is = |text: &str| statement.iter().any(|word| word.is(text));
        if is("union")
            && is("switch")
            && statement.last().is_some_and(|statement| statement.is(")"))
        {
            return FrameKind::Body(BodyKind::Cases);
        }
        if !matches!(kind, FrameKind::Body(_)) {
            return FrameKind::Initializers;
        }
        FrameKind::Body(match statement.first().map_or("", |statement| statement.text.as_str()) {
            "module" => BodyKind::Module,
            "component" => BodyKind::Component,
            "interface" => BodyKind::Interface,
            "exception" => BodyKind::Members,
            "ids" => BodyKind::Ids,
            "task" => BodyKind::Task,
            "port" => BodyKind::Port,
            "attribute" => BodyKind::Attribute,
            "function" => BodyKind::Function,
            "activity" => BodyKind::Activity,
            _ => BodyKind::Unknown,
        })
    }
}
