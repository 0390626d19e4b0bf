//! From the ids of the model back to files and ranges.

use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_syntax::{
    TextRange, TextSize,
    line_index::{LineIndex, PositionEncoding},
    preproc::Element,
};
use typed_index_collections::TiVec;

use crate::{
    base::{Db, lexed, line_index},
    item_tree::{Ptr, lower::PtrRanges},
    model::{Src, VisitId},
    unit::{FileKey, UnitKey, parsed, preprocessed, ranges, text_facts, visits},
};

/// A place in a file. Lines and columns count from 0; columns are in bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Location {
    /// Absolute path of the file (or the name of an in-memory text).
    pub path: Utf8PathBuf,
    /// Byte offsets of start and end.
    pub range: std::ops::Range<usize>,
    /// Line and column of the start.
    pub start: LineCol,
    /// Line and column of the end.
    pub end: LineCol,
}

/// A position by line and column, both from 0; the column counts bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LineCol {
    /// Line, from 0.
    pub line: u32,
    /// Column in bytes, from 0.
    pub col: u32,
}

/// Converts a [`Src`] of a unit to a place in the text.
pub trait Locations {
    /// The place of an id; `None` for ids of other units.
    fn locate(&self, src: Src) -> Option<Location>;
}

/// The places of one unit. Keeps its data alive; independent of the database.
#[derive(Clone)]
pub struct UnitLocations {
    /// By visit, as the elaborator numbers them.
    visits: TiVec<VisitId, Option<VisitPlaces>>,
}

#[derive(Clone)]
struct VisitPlaces {
    path: Utf8PathBuf,
    ranges: Arc<PtrRanges>,
    lines: Arc<LineIndex>,
    calls: Arc<[MacroCall]>,
    /// Set if its text has changed since.
    moved: Option<TextMove>,
}

/// The movement of text after one part was replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextMove {
    /// Start of the part in both texts, in bytes.
    pub start: usize,
    /// End of the old part, in bytes.
    pub old_end: usize,
    /// End of the new part, in bytes.
    pub new_end: usize,
}

impl TextMove {
    /// The smallest replaced part between two texts; `None` if they are equal.
    pub fn between(old: &str, new: &str) -> Option<TextMove> {
        if old == new {
            return None;
        }
        let (a, b) = (old.as_bytes(), new.as_bytes());
        let start = a.iter().zip(b).take_while(|(a, b)| a == b).count();
        let (a, b) = (&a[start..], &b[start..]);
        let same = a.iter().rev().zip(b.iter().rev());
        let same = same.take_while(|(a, b)| a == b).count();
        Some(TextMove { start, old_end: old.len() - same, new_end: new.len() - same })
    }

    /// The new place of a range; `None` if some of it was replaced.
    pub fn range(&self, old: &std::ops::Range<usize>) -> Option<std::ops::Range<usize>> {
        if old.end <= self.start {
            return Some(old.clone());
        }
        let behind = |index: usize| index - self.old_end + self.new_end;
        (old.start >= self.old_end).then(|| behind(old.start)..behind(old.end))
    }

    /// Returns true if a range was changed without being replaced as a whole.
    pub fn is_within(&self, old: &std::ops::Range<usize>) -> bool {
        let touched = self.start < old.end && old.start < self.old_end;
        touched && !(self.start <= old.start && old.end <= self.old_end)
    }
}

/// A call of a macro, and the size of its expansion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MacroCall {
    /// Byte offsets of the call.
    pub range: std::ops::Range<usize>,
    /// Length of its expansion in bytes, tokens and the blanks between them.
    pub expanded: usize,
    /// True if the expansion begins with punctuation.
    pub punctuation: bool,
}

impl UnitLocations {
    pub(crate) fn new<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> UnitLocations {
        let places = visits(db, unit).all().iter().map(|visit| {
            let file = visit.key.file(db);
            Some(VisitPlaces {
                path: file.path(db).clone(),
                ranges: ranges(db, visit.key).clone(),
                lines: line_index(db, file).clone(),
                calls: macro_calls(db, visit.key),
                moved: None,
            })
        });
        UnitLocations { visits: std::iter::once(None).chain(places).collect() }
    }

    /// The places in the present texts of the files, as far as they still exist. `text` returns the old and
    /// the new text of a file.
    pub fn moved(&self, text: impl Fn(&Utf8Path) -> Option<(Arc<str>, Arc<str>)>) -> UnitLocations {
        let mut out = self.clone();
        for places in out.visits.iter_mut().flatten() {
            let Some((old, new)) = text(&places.path) else {
                continue;
            };
            places.moved = TextMove::between(&old, &new);
            if places.moved.is_some() {
                places.lines = Arc::new(LineIndex::new(&new));
                places.calls = Arc::default();
            }
        }
        out
    }

    /// The macro calls in the file of an id, in text order.
    pub fn macro_calls(&self, src: Src) -> &[MacroCall] {
        let visit = self.visits.get(src.visit);
        visit.and_then(Option::as_ref).map_or(&[], |places| &places.calls)
    }
}

fn macro_calls<'db>(db: &'db dyn Db, key: FileKey<'db>) -> Arc<[MacroCall]> {
    // Most files have none, and need not be parsed again to detect it.
    if !text_facts(db, key).has_expansions {
        return Arc::default();
    }
    let raw = &lexed(db, key.file(db)).raw;
    let expansions = &parsed(db, key).expansion;
    let calls = preprocessed(db, key).elements.iter().filter_map(|element| {
        let Element::Call { first, end } = *element else {
            return None;
        };
        let range = raw.start(first as usize)..raw.start(end as usize);
        let mut tokens = expansions.expansion(text_range(&range)).peekable();
        let punctuation = tokens.peek().is_some_and(|token| {
            token.text.len() == 1 && token.text.bytes().all(|byte| byte.is_ascii_punctuation())
        });
        let expanded = tokens
            .enumerate()
            .map(|(number, token)| token.text.len() + usize::from(number > 0 && !token.glued))
            .sum();
        Some(MacroCall { range, expanded, punctuation })
    });
    calls.collect()
}

impl Locations for UnitLocations {
    fn locate(&self, src: Src) -> Option<Location> {
        let visit = self.visits.get(src.visit)?.as_ref()?;
        let mut range = visit.ranges.get(ptr(src))?;
        if let Some(moved) = &visit.moved {
            range = text_range(&moved.range(&bytes(range))?);
        }
        let position = |offset| {
            let position = visit.lines.line_col(offset, PositionEncoding::Utf8);
            LineCol { line: position.line, col: position.col }
        };
        Some(Location {
            path: visit.path.clone(),
            range: bytes(range),
            start: position(range.start()),
            end: position(range.end()),
        })
    }
}

/// The pointer of an id inside its visit.
pub(crate) fn ptr(src: Src) -> Ptr {
    Ptr { item: src.item, node: src.node }
}

/// Byte offsets.
pub(crate) fn bytes(range: TextRange) -> std::ops::Range<usize> {
    usize::from(range.start())..usize::from(range.end())
}

/// The range of byte offsets, which must fit 32 bits.
pub(crate) fn text_range(range: &std::ops::Range<usize>) -> TextRange {
    TextRange::new(offset(range.start), offset(range.end.max(range.start)))
}

/// A byte offset; files beyond 4 GiB are not read.
pub(crate) fn offset(offset: usize) -> TextSize {
    TextSize::new(u32::try_from(offset).unwrap_or(u32::MAX))
}
