//! The pieces the formatter moves: tokens, comments, and opaque stretches.

use std::ops::Range;

use crate::{
    SyntaxElement, SyntaxKind, SyntaxKind::*, SyntaxNode, SyntaxToken, TextRange, TextSize,
    WalkEvent,
};

/// The kind of a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ChunkKind {
    /// A token of the language.
    Token(SyntaxKind),
    /// A comment that ends a line and follows something on it.
    TrailingComment,
    /// A comment between two pieces of one line.
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
    /// Depth of the list that the piece opens.
    pub(super) opens_list: Option<usize>,
    /// Set for the first token of a property value, under which further lines are aligned.
    pub(super) opens_hang: Option<usize>,
    /// White space around it is not touched.
    pub(super) frozen: bool,
    /// Line breaks before it in the text.
    pub(super) newlines: usize,
    /// White space before it in the text, line breaks included.
    pub(super) spaced: bool,
    /// True if the piece is in a body that is written on one line.
    pub(super) flat: bool,
    /// True if the piece begins an item of a body.
    pub(super) first_of_item: bool,
    /// True if that item is an enumerator: several may share a line.
    pub(super) listed: bool,
    /// True if the piece ends in a line comment: the next one must be on another line.
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

/// Returns true if a node's children are on lines of their own, one level deeper.
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
    let mut cutter = Chunker {
        broken: ErrorRanges::new(broken),
        broken_line: None,
        out: Vec::new(),
        pieces: 0,
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
        let goes_on = out.get(i + 1).is_some_and(|next| next.newlines == 0 && !starts_line(next));
        if out[i].kind == ChunkKind::TrailingComment && !out[i].ends_line && goes_on {
            out[i].kind = ChunkKind::InlineComment;
        }
    }
    out
}

/// Returns true if each brace of a text has its partner, as the grammar reads it.
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
    /// Pieces before the node, without comments.
    pieces: usize,
    /// The node or one around it is text that the grammar does not read.
    opaque: bool,
    /// Blocks from the root to the node, with the node.
    blocks: usize,
    /// Lists from the root to the node, with the node.
    lists: usize,
    /// Place of the innermost block in the path.
    block: Option<usize>,
    /// Pieces before the innermost property that has a value.
    property: Option<usize>,
}

/// Ranges of syntax errors, for overlap queries.
struct ErrorRanges {
    /// In order of their starts.
    ranges: Vec<TextRange>,
    /// For each range, the greatest end of the range and all before it.
    ends: Vec<TextSize>,
}

impl ErrorRanges {
    fn new(ranges: &[TextRange]) -> ErrorRanges {
        let mut ranges = ranges.to_vec();
        ranges.sort_by_key(|range| range.start());
        let greatest = |end: &mut TextSize, range: &TextRange| {
            *end = range.end().max(*end);
            Some(*end)
        };
        let ends = ranges.iter().scan(TextSize::new(0), greatest).collect();
        ErrorRanges { ranges, ends }
    }

    /// Returns true if an error is in a node. An error next to the node is not in it: otherwise white space
    /// between them, which formatting changes, would make a difference.
    fn touches(&self, range: TextRange) -> bool {
        let before = self.ranges.partition_point(|other| other.start() < range.end());
        before > 0 && range.start() < self.ends[before - 1]
    }
}

struct Chunker {
    broken: ErrorRanges,
    /// A line break, and the brace of the block after which it is the first one.
    broken_line: Option<(TextSize, TextSize)>,
    out: Vec<Chunk>,
    /// Pieces so far, without comments.
    pieces: usize,
    newlines: usize,
    spaced: bool,
    path: Vec<Level>,
}

impl Chunker {
    fn enter(&mut self, node: &SyntaxNode) {
        let kind = node.kind();
        let above = self.path.last();
        let range = node.text_range();
        let in_body = above.is_none_or(|l| l.kind == BODY || l.kind == SOURCE_FILE);
        // An item of a body is frozen as a whole if something in it does not parse, unless it has a body of
        // its own that contains the error.
        let troubled = kind == ERROR || self.broken.touches(range);
        let holds_body = node.children().any(|c| c.kind() == BODY);
        let frozen = above.is_some_and(|l| l.frozen)
            || (troubled && kind != SOURCE_FILE && (kind == ERROR || (in_body && !holds_body)));
        // Inline structs keep the shape of their outermost block. Components and modules are never on one
        // line; other blocks stay as written.
        let large = above.is_some_and(|l| matches!(l.kind, COMPONENT | MODULE));
        let (in_opaque, blocks, lists, block, property) = above
            .map_or_else(Default::default, |l| (l.opaque, l.blocks, l.lists, l.block, l.property));
        let in_flat = above.is_some_and(|l| l.flat);
        let flat = in_flat || (is_block(kind) && !large && !self.breaks_inside(node));
        let place = self.path.len();
        let chunks = self.out.len();
        self.path.push(Level {
            kind,
            flat,
            frozen,
            pieces: self.pieces,
            opaque: in_opaque || is_opaque(kind),
            blocks: blocks + usize::from(is_block(kind)),
            lists: lists + usize::from(is_list(kind)),
            block: is_block(kind).then_some(place).or(block),
            property: is_valued_property(kind).then_some(chunks).or(property),
        });
        if is_opaque(kind) && !in_opaque {
            self.push(ChunkKind::Opaque, range, false);
        }
    }

    fn leave(&mut self, node: &SyntaxNode) {
        self.path.pop();
        if is_opaque(node.kind()) {
            (self.newlines, self.spaced) = (0, false);
        }
    }

    fn token(&mut self, token: &SyntaxToken) {
        let range = token.text_range();
        if range.is_empty() || self.path.last().is_some_and(|l| l.opaque) {
            return;
        }
        match token.kind() {
            // A carriage return and a line feed are one line end even if a joined line is between them.
            WHITESPACE | NEWLINE if token.text().contains('\\') => {
                self.push(ChunkKind::Opaque, range, false);
            }
            WHITESPACE | NEWLINE => {
                self.newlines +=
                    token.text().matches('\n').count().max(usize::from(token.kind() == NEWLINE));
                self.spaced = true;
            }
            // A joined line is deliberate and stays as written.
            SPLICE => self.push(ChunkKind::Opaque, range, false),
            LINE_COMMENT => self.comment(range, true),
            BLOCK_COMMENT => self.comment(range, false),
            OPEN_COMMENT | OPEN_STRING | STRAY => self.push(ChunkKind::Opaque, range, false),
            kind => self.push(ChunkKind::Token(kind), range, false),
        }
    }

    fn comment(&mut self, range: TextRange, ends_line: bool) {
        let own_line = self.newlines > 0 || self.out.is_empty();
        let kind = if own_line { ChunkKind::Comment } else { ChunkKind::TrailingComment };
        self.push(kind, range, ends_line);
    }

    fn push(&mut self, kind: ChunkKind, range: TextRange, ends_line: bool) {
        let up =
            |n: usize| self.path.len().checked_sub(n).map_or(SOURCE_FILE, |i| self.path[i].kind);
        let closes = matches!(kind, ChunkKind::Token(R_CURLY)) && is_block(up(1));
        let opens_block = matches!(kind, ChunkKind::Token(L_CURLY)) && is_block(up(1));
        let last = self.path.last();
        let (blocks, lists) = last.map_or((0, 0), |l| (l.blocks, l.lists));
        // Braces belong to the level outside.
        let indent = if closes || opens_block { blocks.saturating_sub(1) } else { blocks };
        let closes_list = matches!(kind, ChunkKind::Token(R_PAREN | R_CURLY)) && is_list(up(1));
        let opens_list = matches!(kind, ChunkKind::Token(L_PAREN | L_CURLY)) && is_list(up(1));
        let comment = matches!(kind, ChunkKind::Comment | ChunkKind::TrailingComment);
        // The value of a property begins at its second piece. Comments move with those of other lines, so
        // nothing is aligned under them.
        let property = last.and_then(|l| l.property);
        let value = !comment && property.is_some_and(|before| self.out.len() == before + 1);
        let in_value = property.is_some_and(|before| self.out.len() > before);
        let item = last.and_then(|l| l.block).map_or(1, |b| b + 1);
        let fresh = |l: &Level| l.pieces == self.pieces && !is_block(l.kind);
        let first_of_item = !comment && self.path.get(item).is_some_and(fresh);
        let listed = item > 0 && self.path.get(item - 1).is_some_and(|l| l.kind == ENUMERATOR_LIST);
        let flat = last.is_some_and(|l| l.flat);
        let frozen = last.is_some_and(|l| l.frozen);
        self.out.push(Chunk {
            kind,
            range,
            parent: up(1),
            indent,
            list_depth: if closes_list || opens_list { lists - 1 } else { lists }
                + usize::from(value || in_value),
            opens_list: opens_list.then_some(lists + usize::from(in_value)),
            opens_hang: value.then_some(lists + 1),
            frozen,
            newlines: self.newlines,
            spaced: self.spaced,
            flat,
            first_of_item,
            listed,
            ends_line,
        });
        self.pieces += usize::from(!comment);
        (self.newlines, self.spaced) = (0, false);
    }

    /// Returns true if there is a line break between the braces of a block.
    fn breaks_inside(&mut self, block: &SyntaxNode) -> bool {
        let range = block.text_range();
        // The text up to the line break found for an outer block is not scanned again.
        if let Some((brace, at)) = self.broken_line
            && (brace..at).contains(&range.start())
        {
            return at < range.end();
        }
        let found = first_break(block);
        self.broken_line = found.or(self.broken_line);
        found.is_some()
    }
}

/// The first brace of a block, and the first line break between it and its partner.
fn first_break(block: &SyntaxNode) -> Option<(TextSize, TextSize)> {
    let mut depth = 0;
    let mut brace = None;
    for element in block.descendants_with_tokens() {
        let SyntaxElement::Token(token) = element else {
            continue;
        };
        let start = token.text_range().start();
        match token.kind() {
            L_CURLY => {
                depth += 1;
                brace.get_or_insert(start);
            }
            R_CURLY => depth -= 1,
            _ if depth > 0 && token.text().contains(['\n', '\r']) => return Some((brace?, start)),
            _ => {}
        }
    }
    None
}

/// Returns true for a piece that begins a line: items of blocks that are not written on one line, and closing
/// braces.
pub(super) fn starts_line(chunk: &Chunk) -> bool {
    if chunk.flat {
        return false;
    }
    chunk.first_of_item || (chunk.is(R_CURLY) && matches!(chunk.parent, BODY | ENUMERATOR_LIST))
}

/// The range of the white space before a piece.
pub(super) fn gap_span(chunks: &[Chunk], i: usize) -> Range<usize> {
    let start = i.checked_sub(1).map_or(0, |before| chunks[before].span().end);
    start..chunks[i].span().start
}
