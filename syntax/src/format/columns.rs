//! Columns: pieces that stand under each other because their author put them there.
//!
//! A piece is in a column with one of the line before or after when both begin at the same column of
//! the text with white space before them, and at least one of them is padded (more than one blank,
//! or a tabulator). Such a *run* of lines is printed in one column again, no further to the left than
//! it was, so that formatting a second time finds and leaves it.

use super::Align;
use super::chunks::{Chunk, ChunkKind, gap_span};
use super::page::Page;
use super::rules;

/// The columns of a text.
pub(super) struct Runs {
    /// Pieces of one column, on consecutive lines; by column.
    runs: Vec<Vec<usize>>,
    /// Padded pieces whose white space stays as it is where they are in no column.
    loose: Vec<bool>,
}

impl Runs {
    /// Whether the white space before a piece stays, though it is in no column.
    pub(super) fn is_loose(&self, i: usize) -> bool {
        self.loose[i]
    }
}

/// Finds the columns.
pub(super) fn runs(text: &str, chunks: &[Chunk], columns: &[usize], align: Align) -> Runs {
    let gap = |i: usize| &text[gap_span(chunks, i)];
    let is_comment = |i: usize| chunks[i].kind == ChunkKind::TrailingComment;
    let aligns = |i: usize| align == Align::Keep || is_comment(i);
    let padded = |i: usize| {
        let gap = gap(i);
        chunks[i].newlines == 0 && !gap.contains('\n') && (gap.len() > 1 || gap.contains('\t'))
    };
    let mut loose = vec![false; chunks.len()];
    let mut next = vec![None; chunks.len()];
    let mut first = vec![true; chunks.len()];
    let mut above: Vec<usize> = Vec::new();
    for line in lines(chunks) {
        let adjacent = chunks[line[0]].newlines == 1;
        let mut members: Vec<usize> = Vec::new();
        for &i in &line[1..] {
            let movable = rules::may_pad(text, &chunks[i - 1], &chunks[i]);
            if !movable || gap(i).is_empty() || !aligns(i) {
                continue;
            }
            members.push(i);
            // A lone tabulator, or a comment to the right, is its author's business.
            loose[i] = padded(i) && (is_comment(i) || gap(i).contains('\t'));
            if !adjacent {
                continue;
            }
            let level = |it: usize| (chunks[it].indent, chunks[it].list_depth);
            let partner = above.iter().copied().find(|&it| {
                columns[it] == columns[i]
                    && level(it) == level(i)
                    && is_comment(it) == is_comment(i)
            });
            if let Some(partner) = partner
                && (padded(partner) || padded(i))
            {
                next[partner] = Some(i);
                first[i] = false;
            }
        }
        above = members;
    }
    let mut runs: Vec<Vec<usize>> = Vec::new();
    for i in 0..chunks.len() {
        if !first[i] || next[i].is_none() {
            continue;
        }
        let run: Vec<usize> = std::iter::successors(Some(i), |&it| next[it]).collect();
        runs.push(run);
    }
    runs.sort_by_key(|run| columns[run[0]]);
    Runs { runs, loose }
}

/// The pieces of each line of the text.
fn lines(chunks: &[Chunk]) -> Vec<Vec<usize>> {
    let mut out: Vec<Vec<usize>> = Vec::new();
    for (i, chunk) in chunks.iter().enumerate() {
        match out.last_mut() {
            Some(line) if chunk.newlines == 0 => line.push(i),
            _ => out.push(vec![i]),
        }
    }
    out
}

/// The column that the pieces of each run belong in, as far as the rest is printed now; by piece.
///
/// Lines that formatting has parted are no run any more, and do not become one again: a line that is
/// broken because of its padding would be whole without it, and so on without end.
pub(super) fn targets(page: &Page<'_>, runs: &mut Runs) -> Vec<Option<usize>> {
    let mut out = vec![None; page.chunks.len()];
    let parts = runs.runs.iter().flat_map(|run| together(page, run));
    runs.runs = parts.collect();
    for run in &runs.runs {
        let least = run.iter().map(|&i| page.end_before(i) + 1).max();
        let least = least.unwrap_or(0);
        let old = page.old_columns[run[0]].saturating_add_signed(shift(page, run[0]));
        let over = |column: usize| {
            run.iter().any(|&i| {
                let length = end_of_line(page, i).saturating_sub(page.printed[i].column);
                let was_over = page.old_columns[i] + length > page.width;
                column + length > page.width && !was_over
            })
        };
        let wanted = least.max(old);
        let column = if over(wanted) { least } else { wanted };
        run.iter().for_each(|&i| out[i] = Some(column));
    }
    out
}

/// The parts of a run that are still on consecutive lines.
fn together(page: &Page<'_>, run: &[usize]) -> Vec<Vec<usize>> {
    let breaks = |from: usize, to: usize| {
        let spaces = (from + 1..=to).map(|i| &page.printed[i].space);
        spaces.map(|it| it.matches('\n').count()).sum::<usize>()
    };
    let in_line = |&i: &usize| !page.printed[i].space.contains('\n');
    let mut out: Vec<Vec<usize>> = Vec::new();
    for i in run.iter().copied().filter(in_line) {
        match out.last_mut() {
            Some(part) if part.last().is_some_and(|&it| breaks(it, i) == 1) => part.push(i),
            _ => out.push(vec![i]),
        }
    }
    out.retain(|it| it.len() > 1);
    out
}

/// How far the line of a piece was moved.
fn shift(page: &Page<'_>, i: usize) -> isize {
    let mut first = i;
    while first > 0 && page.chunks[first].newlines == 0 {
        first -= 1;
    }
    let (old, new) = (page.old_columns[first], page.printed[first].column);
    isize::try_from(new).unwrap_or(0) - isize::try_from(old).unwrap_or(0)
}

/// Column after the last piece of the line of a piece.
fn end_of_line(page: &Page<'_>, i: usize) -> usize {
    let line = page.line_from(i);
    page.end_before(line.end)
}
