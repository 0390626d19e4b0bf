//! The white space before each piece.

use std::ops::Range;

use super::chunks::{Chunk, ChunkKind, gap_span, starts_line};
use super::layout::{ChunkLayout, Page};
use super::rules::{self, Gap};
use super::unit::{self, Ruler, Unit, advance};
use super::{Options, TextEdit, columns};
use crate::SyntaxKind::*;
use crate::line_index::line_start;
use crate::{TextRange, TextSize};

/// Maximum number of empty lines in a row.
const EMPTY_LINES: usize = 2;

/// The start of a line that continues a list or statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Continuation {
    /// This many units right of the line that it continues.
    Units(usize),
    /// Under the first piece of the list.
    Under,
}

/// A list or value that further lines may continue.
#[derive(Debug, Clone, Copy)]
struct Open {
    depth: usize,
    /// Column of the line it begins on, in the text and as printed.
    anchor: (usize, usize),
    /// Column of its first piece, in the text and as printed.
    first: (usize, usize),
    /// The continuation of its last further line.
    last: Option<Continuation>,
    /// The continuation of its first further line.
    usual: Continuation,
}

/// Prints pieces one after the other.
pub(super) struct Printer<'a> {
    page: Page<'a>,
    options: &'a Options,
    /// Unit of the text as it is.
    old_unit: Unit,
    /// Column after each piece in the text.
    old_ends: Vec<usize>,
    line_end: &'static str,
    /// Column of each piece that stands in a column with others.
    targets: Vec<Option<usize>>,
    /// Column after the last character printed.
    column: usize,
    /// Lists that are open, the innermost last.
    open: Vec<Open>,
    /// First piece of the line that is printed, and of the declaration.
    line: usize,
    item: usize,
}

impl<'a> Printer<'a> {
    pub(super) fn new(text: &'a str, chunks: &'a [Chunk], options: &'a Options) -> Printer<'a> {
        let own = unit::of(text, chunks);
        let unit = options.unit.or(own).unwrap_or(options.otherwise);
        let old_unit = own.unwrap_or(unit);
        // A text of tabulators is read with the width that they are going to have.
        let tab = match (unit, old_unit) {
            (Unit::Tabs(_), _) => unit.tab(),
            (_, old) => old.tab(),
        };
        let (mut starts, mut ends) = (Ruler::new(text, tab), Ruler::new(text, old_unit.tab()));
        let old_columns = chunks.iter().map(|chunk| starts.column(chunk.span().start));
        let old_ends = chunks.iter().map(|chunk| ends.column(chunk.span().end));
        Printer {
            page: Page {
                text,
                chunks,
                width: options.width,
                unit,
                old_columns: old_columns.collect(),
                printed: Vec::with_capacity(chunks.len()),
            },
            options,
            old_unit,
            old_ends: old_ends.collect(),
            line_end: if text.contains("\r\n") { "\r\n" } else { "\n" },
            targets: vec![None; chunks.len()],
            column: 0,
            open: Vec::new(),
            line: 0,
            item: 0,
        }
    }

    /// The edits that turn the text into the printed text.
    pub(super) fn print(mut self) -> Vec<TextEdit> {
        let mut runs = columns::runs(
            self.page.text,
            self.page.chunks,
            &self.page.old_columns,
            self.options.align,
        );
        // A column depends on the text left of it, and lines that continue a list may begin in a column. So
        // the text is printed again with the new columns until nothing moves.
        const PASSES: usize = 8;
        for _ in 0..PASSES {
            self.pass(&runs);
            let targets = columns::targets(&self.page, &mut runs);
            if targets == self.targets {
                break;
            }
            self.targets = targets;
        }
        self.edits()
    }

    fn pass(&mut self, runs: &columns::AlignedColumns) {
        self.page.printed.clear();
        self.open.clear();
        (self.column, self.line, self.item) = (0, 0, 0);
        for i in 0..self.page.chunks.len() {
            let space = match (self.space(i, runs), self.targets[i]) {
                (space, Some(column)) if !space.contains('\n') => self.padding(i, column),
                (space, _) => space,
            };
            self.push(i, space);
        }
    }

    /// White space up to a column. The mixture in the text stays if it reaches the same column.
    fn padding(&self, i: usize, column: usize) -> String {
        let original = self.page.original(i);
        if advance(self.column, original, self.page.unit.tab()) == column {
            original.to_owned()
        } else {
            " ".repeat(column.saturating_sub(self.column).max(1))
        }
    }

    fn space(&mut self, i: usize, runs: &columns::AlignedColumns) -> String {
        let chunk = &self.page.chunks[i];
        let before = i.checked_sub(1).map(|before| &self.page.chunks[before]);
        // Depths only grow from one open list to the next.
        while self.open.pop_if(|open| open.depth > chunk.list_depth).is_some() {}
        match rules::gap(self.page.text, before, chunk) {
            Gap::Keep => self.page.original(i).to_owned(),
            Gap::None => String::new(),
            Gap::Author => " ".repeat(usize::from(chunk.spaced)),
            Gap::Comment | Gap::Space if runs.is_loose(i) => self.page.original(i).to_owned(),
            Gap::Comment | Gap::Space => " ".to_owned(),
            Gap::Break if self.breaks(i) => self.line_break_inside(i),
            Gap::Break if runs.is_loose(i) => self.page.original(i).to_owned(),
            Gap::Break => " ".to_owned(),
            Gap::Line { blank } => {
                // The file does not begin with empty lines.
                let empty = chunk.newlines.saturating_sub(1).min(EMPTY_LINES);
                let count = match before {
                    None => 0,
                    Some(_) if blank => 1 + empty,
                    Some(_) => 1,
                };
                self.newlines(i, count, chunk.indent * self.page.unit.columns())
            }
            Gap::Continue => self.line_break_inside(i),
        }
    }

    fn push(&mut self, i: usize, space: String) {
        let chunk = &self.page.chunks[i];
        let tab = self.page.unit.tab();
        self.column = advance(self.column, &space, tab);
        if i == 0 || space.contains('\n') {
            self.line = i;
            if chunk.list_depth == 0 && starts_line(chunk) {
                self.item = i;
            }
        }
        self.page.printed.push(ChunkLayout { space, column: self.column });
        if let Some(depth) = chunk.opens_hang {
            let first = (self.page.old_columns[i], self.column);
            self.open_list(depth, first, Continuation::Units(1));
        }
        self.column = advance(self.column, &self.page.text[chunk.span()], tab);
        if let Some(depth) = chunk.opens_list {
            let old = self.page.old_columns[i] + chunk.span().len();
            // A list that begins on the line of its name is indented by two units, to distinguish it from the
            // body.
            let goes_on = self.page.chunks.get(i + 1).is_some_and(|chunk| chunk.newlines == 0);
            let usual = if goes_on && chunk.is(L_PAREN) { 2 } else { 1 };
            self.open_list(depth, (old, self.column), Continuation::Units(usual));
        }
    }

    fn open_list(&mut self, depth: usize, first: (usize, usize), usual: Continuation) {
        let line = self.line;
        self.open.push(Open {
            depth,
            anchor: (self.page.old_columns[line], self.page.printed[line].column),
            first,
            last: None,
            usual,
        });
    }

    /// A line break inside a list or statement: as in the text, if that is one of the known continuations;
    /// otherwise like the line before, or the usual continuation.
    fn line_break_inside(&mut self, i: usize) -> String {
        let (anchor, first, usual) = if let Some(open) = self.open.last() {
            (open.anchor, Some(open.first), open.last.unwrap_or(open.usual))
        } else {
            let item = self.item;
            let anchor = (self.page.old_columns[item], self.page.printed[item].column);
            (anchor, None, Continuation::Units(1))
        };
        let old = self.page.old_columns[i];
        let units = |count: usize| anchor.0 + count * self.old_unit.columns() == old;
        let breaks = self.page.chunks[i].newlines > 0;
        let closes = self.page.chunks[i].is(R_PAREN);
        let way = match first {
            Some(_) if breaks && closes && units(0) => Continuation::Units(0),
            Some((column, _)) if breaks && column == old => Continuation::Under,
            _ if breaks && units(1) => Continuation::Units(1),
            _ if breaks && units(2) => Continuation::Units(2),
            _ => usual,
        };
        let column = |way: Continuation| match way {
            Continuation::Units(count) => anchor.1 + count * self.page.unit.columns(),
            Continuation::Under => first.map_or(anchor.1, |(_, printed)| printed),
        };
        // No text is moved beyond the width that was within it.
        let rest = self.rest_of_line(i);
        let over = |column: usize| column + rest > self.page.width;
        let mut target = column(way);
        if over(target) && !(breaks && over(old)) {
            target = target.min(column(Continuation::Units(1)));
            if breaks && over(target) {
                target = target.min(old);
            }
        }
        if let Some(open) = self.open.last_mut()
            && !closes
        {
            open.last = Some(way);
        }
        self.newlines(i, 1, target)
    }

    /// Returns true if a line that was short enough must be broken here because it no longer is.
    fn breaks(&self, i: usize) -> bool {
        let ends = |&index: &usize| {
            let (before, chunk) = (&self.page.chunks[index - 1], &self.page.chunks[index]);
            chunk.newlines > 0 || rules::may_break(self.page.text, before, chunk)
        };
        let end = (i + 1..self.page.chunks.len()).find(ends);
        let end = end.unwrap_or(self.page.chunks.len());
        let last = &self.page.chunks[end - 1];
        let old_end = self.old_ends[end - 1];
        let length =
            self.page.text[self.page.chunks[i].span().start..last.span().end].chars().count();
        self.column + 1 + length > self.page.width && old_end <= self.page.width
    }

    /// Columns from a piece to the end of its line, without a trailing comment.
    fn rest_of_line(&self, i: usize) -> usize {
        let end = self.page.chunks[i + 1..]
            .iter()
            .position(|chunk| chunk.newlines > 0 || chunk.kind == ChunkKind::TrailingComment)
            .map_or(self.page.chunks.len(), |further| i + 1 + further);
        let text =
            &self.page.text[self.page.chunks[i].span().start..self.page.chunks[end - 1].span().end];
        text.lines().next().map_or(0, |line| line.chars().count())
    }

    /// Line breaks before a piece. Indentation that already reaches the column is left as it is.
    fn newlines(&self, i: usize, count: usize, column: usize) -> String {
        let mut out = self.line_end.repeat(count);
        let old = self.page.original(i);
        let old = &old[line_start(old, old.len())..];
        let begins = i == 0 || self.page.chunks[i].newlines > 0;
        let fits = begins && old.bytes().all(|byte| matches!(byte, b' ' | b'\t'));
        if fits && advance(0, old, self.page.unit.tab()) == column {
            out.push_str(old);
        } else {
            out.push_str(&self.page.unit.indentation(column));
        }
        out
    }

    fn edits(&self) -> Vec<TextEdit> {
        let mut out = Vec::new();
        for (i, printed) in self.page.printed.iter().enumerate() {
            let span = gap_span(self.page.chunks, i);
            if self.page.text[span.clone()] != printed.space {
                out.push(edit(span, printed.space.clone()));
            }
            self.move_comment(i, &mut out);
        }
        // One line end at the end of the file.
        if let Some(last) = self.page.chunks.last() {
            let span = last.span().end..self.page.text.len();
            // A backslash would join a new line end to the comment before it.
            let joins = self.page.text[..span.start].ends_with('\\');
            let wanted = if last.frozen || joins || last.kind == ChunkKind::Opaque {
                self.page.text[span.clone()].to_owned()
            } else {
                self.line_end.to_owned()
            };
            if self.page.text[span.clone()] != wanted {
                out.push(edit(span, wanted));
            }
        }
        out
    }

    /// Moves the further lines of a block comment with its first one.
    fn move_comment(&self, i: usize, out: &mut Vec<TextEdit>) {
        let chunk = &self.page.chunks[i];
        let (old, new) = (self.page.old_columns[i], self.page.printed[i].column);
        let comment = matches!(chunk.kind, ChunkKind::Comment | ChunkKind::TrailingComment);
        // A token on the last line of the comment would move as well.
        let ends = self.page.chunks.get(i + 1).is_none_or(|chunk| chunk.newlines > 0);
        if !comment || !ends || chunk.ends_line || chunk.frozen || old == new {
            return;
        }
        let span = chunk.span();
        for (at, _) in self.page.text[span.clone()].match_indices('\n') {
            let start = span.start + at + 1;
            let rest = &self.page.text[start..span.end];
            let blanks = rest.len() - rest.trim_start_matches([' ', '\t']).len();
            // An empty line has nothing to move.
            if rest[blanks..].starts_with(['\r', '\n']) {
                continue;
            }
            let column = advance(0, &rest[..blanks], self.page.unit.tab());
            let moved = self.page.unit.indentation((column + new).saturating_sub(old));
            if moved != rest[..blanks] {
                out.push(edit(start..start + blanks, moved));
            }
        }
    }
}

fn edit(span: Range<usize>, new_text: String) -> TextEdit {
    let offset = |at: usize| TextSize::try_from(at).unwrap_or_else(|_| TextSize::from(u32::MAX));
    TextEdit { range: TextRange::new(offset(span.start), offset(span.end)), new_text }
}
