//! The formatter: one style, changes of blanks and line breaks only.
//!
//! The tokens of a tree are printed one after the other; between two of them the [`rules`] say
//! whether there is nothing, a blank, or a line break. Where a list may be broken (parameters, states,
//! values) the author's line breaks stay and only their indentation changes. Comments, directives,
//! inactive text and macro calls are printed as they are. A declaration that does not parse is left
//! alone, so the rest of a half-typed file can be formatted. Where a brace is missing, what belongs to
//! what is a guess: such a file is left alone as a whole.
//!
//! The style is the one most published components have: two blanks a level, arguments aligned
//! under the first, values of properties and trailing comments aligned in runs of lines.

mod chunks;
mod rules;

use crate::{SyntaxKind::*, SyntaxNode, TextRange, TextSize};

use chunks::{Chunk, ChunkKind};
use rules::Gap;

/// Blanks for each level.
const INDENT: usize = 2;
/// Some editors put it at the beginning of a text.
const BYTE_ORDER_MARK: char = '\u{feff}';
/// Blanks between the longest keyword of a run of properties and its value, at least.
const VALUE_GAP: usize = 1;
/// Columns of a tabulator.
const TAB: usize = 8;
/// Blanks before a trailing comment, at least.
const COMMENT_GAP: usize = 2;

/// Replacement of blanks and line breaks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextEdit {
    /// What is replaced; it holds white space only.
    pub range: TextRange,
    /// White space.
    pub new_text: String,
}

/// Whether every brace of a text has its other half.
pub fn is_paired(root: &SyntaxNode) -> bool {
    chunks::is_paired(root)
}

/// The edits that bring a tree in shape, in text order, disjoint.
///
/// `broken` are the ranges of syntax errors: the declarations that hold them are left as they are.
/// With `within`, only edits that touch that range are returned. Without, there are none for a text
/// whose braces are not paired.
pub fn format(root: &SyntaxNode, broken: &[TextRange], within: Option<TextRange>) -> Vec<TextEdit> {
    if within.is_none() && !broken.is_empty() && !chunks::is_paired(root) {
        return Vec::new();
    }
    let text = root.text().to_string();
    let chunks = chunks::chunks(root, broken);
    let mut printer = Printer::new(&text, &chunks);
    printer.run();
    printer.align_defaults();
    printer.align_comments();
    let mut edits = printer.edits();
    // A byte order mark goes with what is behind it.
    if text.starts_with(BYTE_ORDER_MARK) {
        let behind = TextSize::of(BYTE_ORDER_MARK);
        edits.retain(|edit| edit.range.start() > behind);
    }
    if let Some(within) = within {
        edits.retain(|edit| edit.range.intersect(within).is_some());
    }
    edits
}

/// A text with edits applied.
pub fn apply(text: &str, edits: &[TextEdit]) -> String {
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    for edit in edits {
        out.push_str(&text[at..usize::from(edit.range.start())]);
        out.push_str(&edit.new_text);
        at = usize::from(edit.range.end());
    }
    out.push_str(&text[at..]);
    out
}

/// The white space chosen before a chunk.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Printed {
    space: String,
    /// Column of the first character of the chunk.
    column: usize,
}

struct Printer<'a> {
    text: &'a str,
    chunks: &'a [Chunk],
    printed: Vec<Printed>,
    /// Column after the last character printed.
    column: usize,
    /// Columns under which the pieces of open lists are aligned: depth of the list, column.
    hang: Vec<(usize, usize)>,
}

impl<'a> Printer<'a> {
    fn new(text: &'a str, chunks: &'a [Chunk]) -> Printer<'a> {
        Printer {
            text,
            chunks,
            printed: Vec::with_capacity(chunks.len()),
            column: 0,
            hang: Vec::new(),
        }
    }

    fn run(&mut self) {
        let values = rules::value_columns(self.chunks);
        for (i, chunk) in self.chunks.iter().enumerate() {
            let before = i.checked_sub(1).map(|b| &self.chunks[b]);
            self.hang.retain(|&(depth, _)| chunk.list_depth >= depth);
            let space = match rules::gap(self.text, before, chunk) {
                Gap::Keep => self.original(i).to_owned(),
                Gap::None => String::new(),
                Gap::Space => " ".to_owned(),
                Gap::Value => " ".repeat(values[i].unwrap_or(VALUE_GAP)),
                Gap::Line { blank } => {
                    let lines = if blank { 2 } else { 1 };
                    // The file does not begin with blank lines.
                    let lines = if before.is_none() { 0 } else { lines };
                    self.newlines(lines, chunk.indent * INDENT)
                }
                Gap::Continue => {
                    let hang = self.hang.last().map(|&(_, column)| column);
                    let column = hang.unwrap_or((chunk.indent + 1) * INDENT);
                    self.newlines(1, column)
                }
                Gap::Comment => self.original_blanks(i),
            };
            self.print(chunk, space);
        }
    }

    fn print(&mut self, chunk: &Chunk, space: String) {
        advance(&mut self.column, &space);
        self.printed.push(Printed {
            space,
            column: self.column,
        });
        if let Some(depth) = chunk.opens_hang {
            self.hang.push((depth, self.column));
        }
        advance(&mut self.column, &self.text[chunk.span()]);
        if let Some(depth) = chunk.opens_list {
            // Aligned under the first piece, unless the author breaks right after the parenthesis.
            self.hang.push((depth, self.column));
        }
    }

    fn newlines(&self, count: usize, column: usize) -> String {
        let line_end = if self.text.contains("\r\n") {
            "\r\n"
        } else {
            "\n"
        };
        let mut out = line_end.repeat(count);
        out.push_str(&" ".repeat(column));
        out
    }

    /// The white space before a chunk as it is in the text.
    fn original(&self, i: usize) -> &'a str {
        &self.text[gap_span(self.chunks, i)]
    }

    /// Blanks before a trailing comment: at least one.
    fn original_blanks(&self, i: usize) -> String {
        let blanks = self.original(i).replace('\t', " ");
        if blanks.is_empty() {
            " ".to_owned()
        } else {
            blanks
        }
    }

    /// Keeps the `=` of parameters on lines of their own in one column, where their author has them so.
    fn align_defaults(&mut self) {
        let mut run: Vec<usize> = Vec::new();
        for i in 0..=self.chunks.len() {
            let chunk = self.chunks.get(i);
            let opens = |it: &Chunk| it.opens_list.is_some() && it.parent == PARAM_LIST;
            if chunk.is_none_or(opens) {
                self.align_column(&run);
                run.clear();
            } else if chunk
                .is_some_and(|it| it.is(EQ) && matches!(it.parent, TYPED_PARAM | PATH_PARAM))
            {
                run.push(i);
            }
        }
    }

    fn align_column(&mut self, run: &[usize]) {
        let columns = run.iter().map(|&i| self.column_in_text(i));
        let aligned = run.len() > 1 && columns.clone().all(|it| Some(it) == columns.clone().next());
        let plain = |&i: &usize| !self.chunks[i].frozen && self.printed[i].space == " ";
        if !aligned || !run.iter().all(plain) {
            return;
        }
        let column = run.iter().map(|&i| self.printed[i].column).max();
        for &i in run {
            let blanks = column.unwrap_or(0) - self.printed[i].column;
            self.printed[i].space.push_str(&" ".repeat(blanks));
            let line = self.printed.iter_mut().skip(i);
            let mut line = line
                .enumerate()
                .take_while(|(at, it)| *at == 0 || !it.space.contains('\n'));
            line.by_ref().for_each(|(_, it)| it.column += blanks);
        }
    }

    /// Column of a chunk before formatting.
    fn column_in_text(&self, i: usize) -> usize {
        let before = &self.text[..self.chunks[i].span().start];
        let line = &before[before.rfind('\n').map_or(0, |it| it + 1)..];
        line.chars().fold(0, |column, it| match it {
            '\t' => column / TAB * TAB + TAB,
            _ => column + 1,
        })
    }

    /// Puts the trailing comments of consecutive lines in one column.
    fn align_comments(&mut self) {
        let mut run: Vec<usize> = Vec::new();
        let mut line_ends = 0;
        for i in 0..=self.chunks.len() {
            let chunk = self.chunks.get(i);
            let breaks = chunk.map_or(2, |_| self.printed[i].space.matches('\n').count());
            line_ends += breaks;
            let trailing = chunk.is_some_and(|c| c.kind == ChunkKind::TrailingComment && !c.frozen);
            // A line without trailing comment, or an empty line, ends the run.
            let level = |c: &Chunk| (c.indent, c.list_depth);
            let moved = trailing
                && run
                    .last()
                    .is_some_and(|&l| chunk.map(level) != Some(level(&self.chunks[l])));
            if !run.is_empty() && (line_ends > 1 || chunk.is_none() || moved) {
                self.align_run(&run);
                run.clear();
            }
            if trailing {
                run.push(i);
                line_ends = 0;
            }
        }
    }

    fn align_run(&mut self, run: &[usize]) {
        let end_of = |it: &Printed| it.column - it.space.chars().count();
        let ends: Vec<usize> = run.iter().map(|&i| end_of(&self.printed[i])).collect();
        let column = ends.iter().max().map_or(0, |end| end + COMMENT_GAP);
        // A comment far to the right would push all others there: such runs are left ragged.
        let least = ends.iter().min().map_or(0, |end| end + COMMENT_GAP);
        for (&i, end) in run.iter().zip(ends) {
            let target = if column - least > 40 {
                end + COMMENT_GAP
            } else {
                column
            };
            self.printed[i].space = " ".repeat(target - end);
            self.printed[i].column = target;
        }
    }

    fn edits(&self) -> Vec<TextEdit> {
        let mut out = Vec::new();
        for (i, printed) in self.printed.iter().enumerate() {
            let span = gap_span(self.chunks, i);
            if self.text[span.clone()] != printed.space {
                out.push(edit(span, printed.space.clone()));
            }
        }
        // One line end at the end of the file.
        if let Some(last) = self.chunks.last() {
            let span = last.span().end..self.text.len();
            // A backslash would join a new line end to the comment before it.
            let joins = self.text[..span.start].ends_with('\\');
            let wanted = if last.frozen || joins || last.kind == ChunkKind::Opaque {
                self.text[span.clone()].to_owned()
            } else {
                self.newlines(1, 0)
            };
            if self.text[span.clone()] != wanted {
                out.push(edit(span, wanted));
            }
        }
        out
    }
}

fn edit(span: std::ops::Range<usize>, new_text: String) -> TextEdit {
    let offset = |at: usize| TextSize::try_from(at).unwrap_or_else(|_| TextSize::from(u32::MAX));
    TextEdit {
        range: TextRange::new(offset(span.start), offset(span.end)),
        new_text,
    }
}

/// Where the white space before a chunk is.
fn gap_span(chunks: &[Chunk], i: usize) -> std::ops::Range<usize> {
    let start = i
        .checked_sub(1)
        .map_or(0, |before| chunks[before].span().end);
    start..chunks[i].span().start
}

fn advance(column: &mut usize, text: &str) {
    match text.rfind('\n') {
        Some(at) => *column = text[at + 1..].chars().count(),
        None => *column += text.chars().count(),
    }
}
