//! The unit of indentation, and columns of text.

use super::TAB;
use super::chunks::{self, Chunk};
use crate::SyntaxNode;
use crate::line_index::line_start;

/// White space of one level of indentation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Unit {
    /// This many blanks.
    Spaces(usize),
    /// A tabulator of this many columns.
    Tabs(usize),
}

impl Unit {
    /// Columns of one level.
    pub fn columns(self) -> usize {
        match self {
            Unit::Spaces(columns) | Unit::Tabs(columns) => columns.max(1),
        }
    }

    /// Columns of a tabulator in a text that is indented by this unit.
    pub(super) fn tab(self) -> usize {
        match self {
            Unit::Spaces(_) => TAB,
            Unit::Tabs(columns) => columns.max(1),
        }
    }

    /// The column after white space at the beginning of a line.
    pub fn column_of(self, blanks: &str) -> usize {
        advance(0, blanks, self.tab())
    }

    /// White space from the beginning of a line up to a column.
    pub fn indentation(self, column: usize) -> String {
        match self {
            Unit::Spaces(_) => " ".repeat(column),
            Unit::Tabs(_) => {
                let tab = self.columns();
                format!("{}{}", "\t".repeat(column / tab), " ".repeat(column % tab))
            }
        }
    }
}

/// The unit of indentation of most declarations of a file; `None` if nothing is indented.
pub fn unit_of(root: &SyntaxNode) -> Option<Unit> {
    let text = root.text().to_string();
    of(&text, &chunks::chunks(root, &[]))
}

pub(super) fn of(text: &str, chunks: &[Chunk]) -> Option<Unit> {
    // Other widths are typing mistakes.
    const USUAL: [usize; 3] = [2, 4, 8];
    let mut spaces = [0; USUAL.len()];
    let mut tabs = 0;
    for chunk in chunks {
        let level = chunk.indent;
        if !chunk.first_of_item || chunk.newlines == 0 || chunk.flat || level == 0 {
            continue;
        }
        let start = chunk.span().start;
        let line = &text[line_start(text, start)..start];
        if line.len() == level && line.bytes().all(|byte| byte == b'\t') {
            tabs += 1;
            continue;
        }
        let columns = column(text, start, TAB);
        if let Some(at) = USUAL.iter().position(|usual| usual * level == columns) {
            spaces[at] += 1;
        }
    }
    let best = (0..USUAL.len()).rev().max_by_key(|&space| spaces[space])?;
    match spaces[best] {
        0 if tabs == 0 => None,
        votes if votes >= tabs => Some(Unit::Spaces(USUAL[best])),
        _ => Some(Unit::Tabs(TAB)),
    }
}

/// Column of an offset.
pub(super) fn column(text: &str, at: usize, tab: usize) -> usize {
    advance(0, &text[line_start(text, at)..at], tab)
}

/// Columns of offsets in text order. Each part of the text is read once.
pub(super) struct Ruler<'a> {
    text: &'a str,
    tab: usize,
    at: usize,
    column: usize,
}

impl<'a> Ruler<'a> {
    pub(super) fn new(text: &'a str, tab: usize) -> Ruler<'a> {
        Ruler { text, tab, at: 0, column: 0 }
    }

    /// Column of an offset. The offset must not be before the last one.
    pub(super) fn column(&mut self, at: usize) -> usize {
        self.column = advance(self.column, &self.text[self.at..at], self.tab);
        self.at = at;
        self.column
    }
}

/// The column after a text that begins at a column.
pub(super) fn advance(column: usize, text: &str, tab: usize) -> usize {
    let (start, line) = match text.rfind('\n') {
        Some(at) => (0, &text[at + 1..]),
        None => (column, text),
    };
    line.chars().fold(start, |column, character| match character {
        '\t' => column / tab * tab + tab,
        '\r' => column,
        _ => column + 1,
    })
}
