//! The pieces the formatter moves: tokens, comments, and opaque stretches.

use std::ops::Range;

use crate::{
    SyntaxElement, SyntaxKind, SyntaxKind::*, SyntaxNode, SyntaxToken, TextRange, WalkEvent,
};

/// What a piece is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ChunkKind {
    /// A token of the language.
    Token(SyntaxKind),
    /// A comment after something on its line, the last of it.
    TrailingComment,
    /// A comment between two pieces of a line.
    InlineComment,
    /// A comment on lines of its own.
    Comment,
    /// A directive, inactive text, or a macro call.
    Opaque,
}

/// A piece of text that is printed as it is.
#[derive(Debug, Clone)]
pub(super) struct Chunk {
    pub(super) kind: ChunkKind,
    pub(super) range: TextRange,
    /// Node the token is a child of.
    pub(super) parent: SyntaxKind,
    /// Levels of bodies around it.
    pub(super) indent: usize,
    /// Levels of lists (parameters, initializers) around it.
    pub(super) list_depth: usize,
    /// It opens a list of this depth.
    pub(super) opens_list: Option<usize>,
    /// It is the first token of a property value, under which further lines are aligned.
    pub(super) opens_hang: Option<usize>,
    /// White space around it is not touched.
    pub(super) frozen: bool,
    /// Line breaks before it in the text.
    pub(super) newlines: usize,
    /// White space before it in the text, line breaks included.
    pub(super) spaced: bool,
    /// It is in a body that is written on one line.
    pub(super) flat: bool,
    /// It begins an item of a body.
    pub(super) first_of_item: bool,
    /// That item is an enumerator: several may share a line.
    pub(super) listed: bool,
    /// Ends in a line comment: what follows must be on another line.
    pub(super) ends_line: bool,
}

impl Chunk {
    pub(super) fn span(&self) -> Range<usize> {
        self.range.into()
    }

    pub(super) fn is(&self, kind: SyntaxKind) -> bool {
        self.kind == ChunkKind::Token(kind)
    }
}

/// Whether a node's children are on lines of their own, one level deeper.
fn is_block(kind: SyntaxKind) -> bool {
    matches!(kind, BODY | ENUMERATOR_LIST)
}

fn is_list(kind: SyntaxKind) -> bool {
    matches!(kind, PARAM_LIST | INITIALIZER_LIST)
}

/// Properties of the form keyword, value: further lines may stand under the value.
fn is_valued_property(kind: SyntaxKind) -> bool {
    matches!(
        kind,
        STRING_PROPERTY
            | REQUIRES_PROPERTY
            | DURATION_PROPERTY
            | INTERFACES_PROPERTY
            | THROWS_PROPERTY
            | PRIORITY_PROPERTY
            | SCHEDULING_PROPERTY
            | STACK_PROPERTY
            | TASK_PROPERTY
            | SERVICES_PROPERTY
    )
}

/// Cuts a tree into pieces.
pub(super) fn chunks(root: &SyntaxNode, broken: &[TextRange]) -> Vec<Chunk> {
    let mut cutter = Cutter {
        broken,
        out: Vec::new(),
        newlines: 0,
        spaced: false,
        path: Vec::new(),
    };
    for event in root.preorder_with_tokens() {
        match event {
            WalkEvent::Enter(SyntaxElement::Node(node)) => cutter.enter(&node),
            WalkEvent::Leave(SyntaxElement::Node(node)) => cutter.leave(&node),
            WalkEvent::Enter(SyntaxElement::Token(token)) => cutter.token(&token),
            WalkEvent::Leave(SyntaxElement::Token(_)) => {}
        }
    }
    let mut out = cutter.out;
    for i in 0..out.len() {
        let goes_on = out
            .get(i + 1)
            .is_some_and(|next| next.newlines == 0 && !starts_line(next));
        if out[i].kind == ChunkKind::TrailingComment && !out[i].ends_line && goes_on {
            out[i].kind = ChunkKind::InlineComment;
        }
    }
    out
}

/// Whether each brace of a text has its partner, as the grammar reads it.
pub(super) fn is_paired(root: &SyntaxNode) -> bool {
    let mut open = 0;
    let mut events = root.preorder_with_tokens();
    while let Some(event) = events.next() {
        match event {
            WalkEvent::Enter(SyntaxElement::Node(node)) if is_opaque(node.kind()) => {
                events.skip_subtree();
            }
            WalkEvent::Enter(SyntaxElement::Token(token)) => match token.kind() {
                L_CURLY => open += 1,
                R_CURLY => open -= 1,
                _ => {}
            },
            _ => {}
        }
        if open < 0 {
            return false;
        }
    }
    open == 0
}

/// Text that the grammar does not read.
fn is_opaque(kind: SyntaxKind) -> bool {
    matches!(kind, DIRECTIVE | INACTIVE | MACRO_CALL)
}

/// A node on the way down to the current token.
struct Level {
    kind: SyntaxKind,
    flat: bool,
    frozen: bool,
    /// Pieces before it.
    chunks: usize,
    /// No piece of it but comments so far.
    fresh: bool,
}

struct Cutter<'a> {
    broken: &'a [TextRange],
    out: Vec<Chunk>,
    newlines: usize,
    spaced: bool,
    path: Vec<Level>,
}

impl Cutter<'_> {
    fn enter(&mut self, node: &SyntaxNode) {
        let kind = node.kind();
        let above = self.path.last();
        let range = node.text_range();
        let in_body = above.is_none_or(|l| l.kind == BODY || l.kind == SOURCE_FILE);
        // An item of a body is frozen as a whole when something in it does not parse, unless it has a
        // body of its own in which the trouble can be isolated.
        let troubled = kind == ERROR || self.broken.iter().any(|b| touches(*b, range));
        let holds_body = node.children().any(|c| c.kind() == BODY);
        let frozen = above.is_some_and(|l| l.frozen)
            || (troubled && kind != SOURCE_FILE && (kind == ERROR || (in_body && !holds_body)));
        // Inline structs keep the shape their outermost block has.
        // Components and modules are never on one line; the others as their author has them.
        let large = above.is_some_and(|l| matches!(l.kind, COMPONENT | MODULE));
        let flat =
            above.is_some_and(|l| l.flat) || (is_block(kind) && !large && !breaks_inside(node));
        self.path.push(Level {
            kind,
            flat,
            frozen,
            chunks: self.out.len(),
            fresh: true,
        });
        if is_opaque(kind) && !self.inside_opaque() {
            self.push(ChunkKind::Opaque, range, false);
        }
    }

    fn leave(&mut self, node: &SyntaxNode) {
        self.path.pop();
        if is_opaque(node.kind()) {
            (self.newlines, self.spaced) = (0, false);
        }
    }

    fn inside_opaque(&self) -> bool {
        let above = self.path.len().saturating_sub(1);
        self.path[..above].iter().any(|l| is_opaque(l.kind))
    }

    fn token(&mut self, token: &SyntaxToken) {
        let range = token.text_range();
        if range.is_empty() || self.path.iter().any(|l| is_opaque(l.kind)) {
            return;
        }
        match token.kind() {
            // A carriage return and a line feed are one line end also when a joined line stands between them.
            WHITESPACE | NEWLINE if token.text().contains('\\') => {
                self.push(ChunkKind::Opaque, range, false);
            }
            WHITESPACE | NEWLINE => {
                self.newlines += token
                    .text()
                    .matches('\n')
                    .count()
                    .max(usize::from(token.kind() == NEWLINE));
                self.spaced = true;
            }
            // A joined line is its author's business.
            SPLICE => self.push(ChunkKind::Opaque, range, false),
            LINE_COMMENT => self.comment(range, true),
            BLOCK_COMMENT => self.comment(range, false),
            OPEN_COMMENT | OPEN_STRING | STRAY => self.push(ChunkKind::Opaque, range, false),
            kind => self.push(ChunkKind::Token(kind), range, false),
        }
    }

    fn comment(&mut self, range: TextRange, ends_line: bool) {
        let own_line = self.newlines > 0 || self.out.is_empty();
        let kind = if own_line {
            ChunkKind::Comment
        } else {
            ChunkKind::TrailingComment
        };
        self.push(kind, range, ends_line);
    }

    fn push(&mut self, kind: ChunkKind, range: TextRange, ends_line: bool) {
        let up = |n: usize| {
            self.path
                .len()
                .checked_sub(n)
                .map_or(SOURCE_FILE, |i| self.path[i].kind)
        };
        let closes = matches!(kind, ChunkKind::Token(R_CURLY)) && is_block(up(1));
        let opens_block = matches!(kind, ChunkKind::Token(L_CURLY)) && is_block(up(1));
        let blocks = self.path.iter().filter(|l| is_block(l.kind)).count();
        let lists = self.path.iter().filter(|l| is_list(l.kind)).count();
        // Braces belong to the level outside.
        let indent = if closes || opens_block {
            blocks.saturating_sub(1)
        } else {
            blocks
        };
        let closes_list = matches!(kind, ChunkKind::Token(R_PAREN | R_CURLY)) && is_list(up(1));
        let opens_list = matches!(kind, ChunkKind::Token(L_PAREN | L_CURLY)) && is_list(up(1));
        let comment = matches!(kind, ChunkKind::Comment | ChunkKind::TrailingComment);
        // The second piece of a property is where its value begins. Comments move with those of other lines,
        // so nothing is aligned under them.
        let property = |l: &Level| is_valued_property(l.kind);
        let value = !comment
            && self
                .path
                .iter()
                .rposition(property)
                .is_some_and(|at| self.out.len() == self.path[at].chunks + 1);
        let item = self
            .path
            .iter()
            .rposition(|l| is_block(l.kind))
            .map_or(1, |b| b + 1);
        let first_of_item = !comment
            && self
                .path
                .get(item)
                .is_some_and(|l| l.fresh && !is_block(l.kind));
        let listed = item > 0
            && self
                .path
                .get(item - 1)
                .is_some_and(|l| l.kind == ENUMERATOR_LIST);
        let flat = self.path.last().is_some_and(|l| l.flat);
        let frozen = self.path.last().is_some_and(|l| l.frozen);
        self.out.push(Chunk {
            kind,
            range,
            parent: up(1),
            indent,
            list_depth: if closes_list || opens_list {
                lists - 1
            } else {
                lists
            } + usize::from(value || self.in_value()),
            opens_list: opens_list.then_some(lists + usize::from(self.in_value())),
            opens_hang: value.then_some(lists + 1),
            frozen,
            newlines: self.newlines,
            spaced: self.spaced,
            flat,
            first_of_item,
            listed,
            ends_line,
        });
        if !comment {
            self.path.iter_mut().for_each(|l| l.fresh = false);
        }
        (self.newlines, self.spaced) = (0, false);
    }

    /// Whether the current token is inside the value of a property.
    fn in_value(&self) -> bool {
        self.path
            .iter()
            .rposition(|l| is_valued_property(l.kind))
            .is_some_and(|at| self.out.len() > self.path[at].chunks)
    }
}

/// Whether an error is in a node. One right beside it is not, or it would matter whether there is
/// white space between, which is what formatting changes.
fn touches(broken: TextRange, range: TextRange) -> bool {
    broken.start() < range.end() && range.start() < broken.end()
}

/// Whether there is a line break between the braces of a block.
fn breaks_inside(block: &SyntaxNode) -> bool {
    let mut depth = 0;
    for element in block.descendants_with_tokens() {
        let SyntaxElement::Token(token) = element else {
            continue;
        };
        match token.kind() {
            L_CURLY => depth += 1,
            R_CURLY => depth -= 1,
            _ if depth > 0 && token.text().contains(['\n', '\r']) => return true,
            _ => {}
        }
    }
    false
}

/// What begins a line: items of blocks that are not written on one line, and closing braces.
pub(super) fn starts_line(chunk: &Chunk) -> bool {
    if chunk.flat {
        return false;
    }
    chunk.first_of_item || (chunk.is(R_CURLY) && matches!(chunk.parent, BODY | ENUMERATOR_LIST))
}

/// Where the white space before a chunk is.
pub(super) fn gap_span(chunks: &[Chunk], i: usize) -> Range<usize> {
    let start = i
        .checked_sub(1)
        .map_or(0, |before| chunks[before].span().end);
    start..chunks[i].span().start
}
