//! Units in which a rename can only change a name.

use std::ops::Range;

use rustc_hash::FxHashMap;

use crate::{
    base::{Db, SourceFile, lexed},
    diagnostic::FileEdit,
    unit::{files, unit_of_root},
};

/// A rename, for checks of one unit after the other.
pub(super) struct RenameCheck<'a> {
    /// The edited ranges, by file.
    edited: FxHashMap<SourceFile, Vec<Range<usize>>>,
    old: &'a str,
    new_name: &'a str,
}

impl<'a> RenameCheck<'a> {
    pub(super) fn new(
        db: &dyn Db,
        edits: &[FileEdit],
        old: &'a str,
        new_name: &'a str,
    ) -> RenameCheck<'a> {
        let mut edited: FxHashMap<SourceFile, Vec<Range<usize>>> = FxHashMap::default();
        for edit in edits {
            let ranges = edited.entry(db.file(&edit.path)).or_default();
            ranges.push(edit.range.clone());
        }
        for ranges in edited.values_mut() {
            ranges.sort_by_key(|range| range.start);
        }
        RenameCheck { edited, old, new_name }
    }

    /// Returns true if only one name differs in the unit of a root after the rename.
    ///
    /// The language only compares names. So a unit means the same after one identifier is replaced by another
    /// everywhere (alpha-conversion), if the new one does not occur in the unit: neither as it is, nor in
    /// another case, nor as a part of a composed name (`COMPONENT_state`, `a ## b`).
    pub(super) fn in_unit_of(&self, db: &dyn Db, root: SourceFile) -> bool {
        files(db, unit_of_root(db, root)).into_iter().all(|file| self.in_file(db, file))
    }

    fn in_file(&self, db: &dyn Db, file: SourceFile) -> bool {
        let (raw, text) = (&lexed(db, file).raw, file.text(db));
        if text.contains("##") {
            return false;
        }
        let ranges = self.edited.get(&file).map_or(&[][..], Vec::as_slice);
        let edited = |range: Range<usize>| {
            let at = ranges.binary_search_by_key(&range.start, |range| range.start);
            at.is_ok_and(|at| ranges[at] == range)
        };
        (0..raw.len()).all(|i| {
            let word = raw.clean_text(text, i);
            if word.as_ref() == self.old { edited(raw.range(i)) } else { !self.may_clash(&word) }
        })
    }

    /// Returns true if a word may be confused with the new name, or form it or a longer name with it.
    fn may_clash(&self, word: &str) -> bool {
        let (short, long) = if word.len() <= self.new_name.len() {
            (word, self.new_name)
        } else {
            (self.new_name, word)
        };
        let end = long.len() - short.len();
        let same = |part: Option<&str>| part.is_some_and(|part| part.eq_ignore_ascii_case(short));
        let joint = |part: Option<&str>| part == Some("_");
        !short.is_empty()
            && (end == 0 && same(Some(long))
                || same(long.get(..short.len())) && joint(long.get(short.len()..=short.len()))
                || end > 0 && same(long.get(end..)) && joint(long.get(end - 1..end)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_meet_that_are_equal_or_parts_of_each_other() {
        let fresh = RenameCheck { edited: FxHashMap::default(), old: "pose", new_name: "place" };
        for (word, meets) in [
            ("place", true),
            ("Place", true),
            ("place_state", true),
            ("my_place", true),
            ("_place", true),
            ("places", false),
            ("myplace", false),
            ("lace", false),
            ("", false),
            ("_", false),
            ("pläce", false),
        ] {
            assert_eq!(fresh.may_clash(word), meets, "{word}");
        }
        let fresh = RenameCheck { new_name: "arm_state", ..fresh };
        for (word, meets) in [("arm", true), ("state", true), ("rm", false), ("te", false)] {
            assert_eq!(fresh.may_clash(word), meets, "{word}");
        }
    }
}
