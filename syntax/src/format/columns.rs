//! Columns: pieces that are aligned because their author aligned them.
//!
//! A piece is in a column with one of the line before or after if both begin at the same column of the text
//! with white space before them, and at least one of them is padded (more than one blank, or a tabulator).
//! Such a *run* of lines is printed in one column again, no further to the left than it was, so that
//! formatting a second time finds and leaves it.

use rustc_hash::FxHashMap;

use super::Align;
use super::chunks::{Chunk, ChunkKind, gap_span};
use super::layout::{ChunkLayout, Page};
use super::rules;

/// The columns of a text.
pub(super) struct AlignedColumns {
    /// Pieces of one column, on consecutive lines; by column.
    runs: Vec<Vec<usize>>,
    /// Padded pieces outside of every column whose white space stays as it is.
    loose: Vec<bool>,
}

impl AlignedColumns {
    /// Returns true if the white space before a piece stays although the piece is in no column.
    pub(super) fn is_loose(&self, i: usize) -> bool {
        self.loose[i]
    }
}

/// Finds the columns.
pub(super) fn runs(
    text: &str,
    chunks: &[Chunk],
    columns: &[usize],
    align: Align,
) -> AlignedColumns {
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
    let place = |i: usize| {
        let chunk = &chunks[i];
        (columns[i], chunk.indent, chunk.list_depth, is_comment(i))
    };
    // Pieces of the line above, by column.
    let mut above = FxHashMap::default();
    for line in lines(chunks) {
        let adjacent = chunks[line[0]].newlines == 1;
        let mut members: Vec<usize> = Vec::new();
        for &i in &line[1..] {
            let movable = rules::may_pad(text, &chunks[i - 1], &chunks[i]);
            if !movable || gap(i).is_empty() || !aligns(i) {
                continue;
            }
            members.push(i);
            // A lone tabulator, or a comment to the right, is deliberate.
            loose[i] = padded(i) && (is_comment(i) || gap(i).contains('\t'));
            if !adjacent {
                continue;
            }
            if let Some(&partner) = above.get(&place(i))
                && (padded(partner) || padded(i))
            {
                next[partner] = Some(i);
                first[i] = false;
            }
        }
        above.clear();
        for i in members {
            above.entry(place(i)).or_insert(i);
        }
    }
    let mut runs: Vec<Vec<usize>> = Vec::new();
    for i in 0..chunks.len() {
        if !first[i] || next[i].is_none() {
            continue;
        }
        let run: Vec<usize> = std::iter::successors(Some(i), |&chunk| next[chunk]).collect();
        runs.push(run);
    }
    runs.sort_by_key(|run| columns[run[0]]);
    AlignedColumns { runs, loose }
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

/// The column of the pieces of each run, as far as the text is printed now; by piece.
///
/// Lines that formatting has separated are no longer a run and never become one again: a line that is broken
/// because of its padding would be whole without it, and the printer would not terminate.
pub(super) fn targets(page: &Page<'_>, runs: &mut AlignedColumns) -> Vec<Option<usize>> {
    let mut out = vec![None; page.chunks.len()];
    let mut line = 0;
    let number = |layout: &ChunkLayout| {
        line += layout.space.matches('\n').count();
        line
    };
    let numbers: Vec<usize> = page.printed.iter().map(number).collect();
    let (shifts, ends) = (shifts(page), page.line_ends());
    let parts = runs.runs.iter().flat_map(|run| consecutive_parts(&numbers, page, run));
    runs.runs = parts.collect();
    for run in &runs.runs {
        let least = run.iter().map(|&i| page.end_before(i) + 1).max();
        let least = least.unwrap_or(0);
        let old = page.old_columns[run[0]].saturating_add_signed(shifts[run[0]]);
        let over = |column: usize| {
            run.iter().any(|&i| {
                let length = ends[i].saturating_sub(page.printed[i].column);
                let was_over = page.old_columns[i] + length > page.width;
                column + length > page.width && !was_over
            })
        };
        let wanted = least.max(old);
        let column = if over(wanted) { least } else { wanted };
        for &i in run {
            out[i] = Some(column);
        }
    }
    out
}

/// The parts of a run that are still on consecutive lines, given the number of the line of each piece.
fn consecutive_parts(numbers: &[usize], page: &Page<'_>, run: &[usize]) -> Vec<Vec<usize>> {
    let in_line = |&i: &usize| !page.printed[i].space.contains('\n');
    let mut out: Vec<Vec<usize>> = Vec::new();
    for i in run.iter().copied().filter(in_line) {
        match out.last_mut() {
            Some(part) if part.last().is_some_and(|&last| numbers[i] - numbers[last] == 1) => {
                part.push(i);
            }
            _ => out.push(vec![i]),
        }
    }
    out.retain(|out| out.len() > 1);
    out
}

/// The number of columns by which the line of each piece moved.
fn shifts(page: &Page<'_>) -> Vec<isize> {
    let mut moved = 0;
    let shift = |i: usize| {
        if i == 0 || page.chunks[i].newlines > 0 {
            let (old, new) = (page.old_columns[i], page.printed[i].column);
            moved = isize::try_from(new).unwrap_or(0) - isize::try_from(old).unwrap_or(0);
        }
        moved
    };
    (0..page.chunks.len()).map(shift).collect()
}
