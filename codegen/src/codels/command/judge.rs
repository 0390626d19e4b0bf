//! Judges an edit before it is offered: the edit is applied to copies of the documents, specification and
//! codels, and the findings before and after are compared.
//!
//! An edit is *whole* if it adds no finding and removes the finding that it repairs. An edit of the
//! specification whose only new findings have a repair in the sources is paired with that repair.

use std::collections::BTreeMap;
use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::codes::{CODEL, lints};
use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use rustc_hash::FxHashMap;

use super::{FileChange, project::Project};
use crate::codels::{
    diagnostics::{Side, diagnostics},
    drift::{Drift, Repair, SIGNATURE_MISMATCH, finding::Difference},
    edit::{Edit, line_edits},
    folder::Folder,
};

/// Maximum number of edits that are tried for a request or command. Each costs about one analysis of the
/// affected units.
pub const MAX_TRIALS: usize = 400;

/// Bytes of specifications that are analysed in the trials of a command: the edits of a large file are fewer.
const MAX_BYTES: usize = 2 << 20;

/// Maximum number of units in which an edit is tried. An edit of a file that more units include is not
/// judged.
pub const MAX_UNITS: usize = 8;

/// Maximum number of rounds of repairs that complete an edit.
const ROUNDS: usize = 2;

/// The answer of a judge.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// The edit adds no finding, and removes the finding that it repairs.
    Whole,
    /// The edit is whole together with changes of the sources; the value contains all changes.
    Paired(Edit),
    /// The edit adds a finding, or the finding that it repairs remains.
    Refused,
    /// The edit was not tried, because the maximum was reached.
    Unknown,
}

impl Verdict {
    /// True if the edit may be offered.
    pub fn allows(&self) -> bool {
        *self != Verdict::Refused
    }
}

/// What a judge found about the texts of one revision, for the next judge of the same texts.
#[derive(Default)]
pub struct Known {
    roots: Vec<Utf8PathBuf>,
    before: Option<Findings>,
    judged: Vec<Judged>,
}

/// An edit with its verdict.
struct Judged {
    edit: Edit,
    /// The numbers of findings that it should remove, by code.
    mends: Vec<(String, usize)>,
    /// True if changes of the sources could complete it.
    follow: bool,
    verdict: Verdict,
}

impl Judged {
    fn is(&self, edit: &Edit, mends: &[(&str, usize)], follow: bool) -> bool {
        let mut codes = std::iter::zip(&self.mends, mends);
        self.edit == *edit
            && self.follow == follow
            && self.mends.len() == mends.len()
            && codes.all(|(mine, other)| (&*mine.0, mine.1) == *other)
    }
}

/// Tries edits on a project. Afterwards its texts are unchanged.
pub struct Judge<'j, 'p> {
    project: &'j mut Project<'p>,
    known: Known,
    /// Remaining number of edits that may be tried. Later edits are not judged.
    pub room: usize,
    /// True if edits are tried in all affected units.
    is_complete: bool,
}

impl<'j, 'p> Judge<'j, 'p> {
    /// A judge of edits that affect the units of some roots. Nothing is analysed before the first edit.
    pub fn new(project: &'j mut Project<'p>, roots: &[Utf8PathBuf]) -> Judge<'j, 'p> {
        Judge::knowing(project, roots, Known::default())
    }

    /// As [`Judge::new`], with what another judge found about the same texts.
    pub fn knowing(
        project: &'j mut Project<'p>,
        roots: &[Utf8PathBuf],
        known: Known,
    ) -> Judge<'j, 'p> {
        let is_complete = roots.len() <= MAX_UNITS;
        let roots = &roots[..roots.len().min(MAX_UNITS)];
        let known = if known.roots == roots {
            known
        } else {
            Known { roots: roots.to_vec(), ..Known::default() }
        };
        Judge { project, known, room: MAX_TRIALS, is_complete }
    }

    /// What was found about the texts.
    pub fn into_known(self) -> Known {
        self.known
    }

    /// Leaves room for as many trials as texts of this size allow.
    pub fn limit(&mut self, size: usize) {
        self.room = self.room.min(MAX_BYTES / size.max(1));
    }

    /// The project on which edits are tried.
    pub fn project(&self) -> &Project<'p> {
        self.project
    }

    /// Judges an edit that should remove a finding of the code `mends`, or remove none. Changes of the
    /// sources may complete it.
    pub fn verdict(&mut self, edit: &Edit, mends: Option<&str>) -> Verdict {
        let mends: Vec<(&str, usize)> = mends.into_iter().map(|text| (text, 1)).collect();
        self.judged(edit, &mends, true)
    }

    /// As [`Judge::verdict`], for an edit that nothing completes.
    pub fn verdict_alone(&mut self, edit: &Edit, mends: &str) -> Verdict {
        self.judged(edit, &[(mends, 1)], false)
    }

    /// Judges edits that nothing completes, each with the code of the finding that it is for. They are tried
    /// together first: many edits that are whole together cost one analysis. Otherwise they are tried in
    /// halves, or, if edits are refused one after the other, by themselves.
    pub fn verdicts(&mut self, edits: &[(Edit, &str)]) -> Vec<Verdict> {
        let mut out = Vec::with_capacity(edits.len());
        let mut refused = 0;
        while out.len() < edits.len() {
            let rest = &edits[out.len()..];
            if refused < 2 && rest.len() > 1 {
                if self.are_whole_together(rest) {
                    out.resize(edits.len(), Verdict::Whole);
                    break;
                }
                if refused == 0 && rest.len() > 3 {
                    let half = self.verdicts(&rest[..rest.len() / 2]);
                    refused = half
                        .iter()
                        .rev()
                        .take_while(|verdict| **verdict == Verdict::Refused)
                        .count();
                    out.extend(half);
                    continue;
                }
            }
            let (edit, code) = &rest[0];
            let verdict = self.verdict_alone(edit, code);
            refused = match verdict {
                Verdict::Refused => refused + 1,
                _ => 0,
            };
            out.push(verdict);
        }
        out
    }

    /// All edits as one are whole, and remove a finding each.
    fn are_whole_together(&mut self, edits: &[(Edit, &str)]) -> bool {
        let mut all = Edit::default();
        let mut mends: BTreeMap<&str, usize> = BTreeMap::new();
        for (edit, code) in edits {
            if all.touches(edit) || !all.merge(edit.clone()) {
                return false;
            }
            *mends.entry(code).or_default() += 1;
        }
        let mends: Vec<(&str, usize)> = mends.into_iter().collect();
        self.judged(&all, &mends, false) == Verdict::Whole
    }

    /// Judges an edit that is to remove a number of findings of each of some codes. With `follow`, changes of
    /// the sources may complete it.
    fn judged(&mut self, edit: &Edit, mends: &[(&str, usize)], follow: bool) -> Verdict {
        let mut judged = self.known.judged.iter();
        if let Some(known) = judged.find(|known| known.is(edit, mends, follow)) {
            return known.verdict.clone();
        }
        let Some(room) = self.room.checked_sub(1) else {
            return Verdict::Unknown;
        };
        self.room = room;
        let mut before = match self.known.before.take() {
            Some(before) => before,
            None => Findings::of_specifications(self.project, &self.known.roots),
        };
        let verdict = match self.tried(edit, mends, follow, &mut before) {
            Verdict::Refused => Verdict::Refused,
            _ if !self.is_complete => Verdict::Unknown,
            verdict => verdict,
        };
        self.known.before = Some(before);
        let mends = mends.iter().map(|(code, number)| ((*code).to_owned(), *number)).collect();
        if self.known.judged.len() < MAX_TRIALS {
            let judged = Judged { edit: edit.clone(), mends, follow, verdict: verdict.clone() };
            self.known.judged.push(judged);
        }
        verdict
    }

    fn tried(
        &mut self,
        edit: &Edit,
        mends: &[(&str, usize)],
        follow: bool,
        before: &mut Findings,
    ) -> Verdict {
        let changes = self.project.changes(edit);
        let touched = ChangedLines::of(edit, &changes);
        let mut originals = self.overlay(changes);
        let mut after = Findings::of_specifications(self.project, &self.known.roots);
        // What a specification alone refuses needs no codels.
        let of_codels = |code: &str| code.starts_with(CODEL) || code == lints::UNUSED_SUPPRESSION;
        let remains = |&&(code, number): &&(&str, usize)| {
            !of_codels(code) && after.count(code).saturating_add(number) > before.count(code)
        };
        if !before.added(&after, &touched).is_empty() || mends.iter().any(|one| remains(&one)) {
            self.restore(originals);
            return Verdict::Refused;
        }
        if !before.has_codels {
            let changed = originals.keys().map(|path| (path.clone(), self.project.text(path)));
            let changed: Vec<_> = changed.collect();
            self.restore(std::mem::take(&mut originals));
            before.add_codels(self.project, &self.known.roots);
            let changed = changed.into_iter().filter_map(|(path, after)| {
                let before = self.project.text(&path).map(|text| text.to_string());
                Some(FileChange { path, before, after: after?.to_string() })
            });
            originals = self.overlay(changed.collect());
        }
        after.add_codels(self.project, &self.known.roots);
        let mut is_paired = false;
        for _ in 0..if follow { ROUNDS } else { 0 } {
            let added = before.added(&after, &touched);
            if added.is_empty() || !added.iter().all(|code| after.is_followed(code)) {
                break;
            }
            let repair = after.following(self.project, &added);
            if repair.is_empty() {
                break;
            }
            is_paired = true;
            let changes = self.project.changes(&repair);
            for (path, text) in self.overlay(changes) {
                originals.entry(path).or_insert(text);
            }
            after = Findings::of_specifications(self.project, &self.known.roots);
            after.add_codels(self.project, &self.known.roots);
        }
        let is_mended = mends
            .iter()
            .all(|&(code, number)| after.count(code).saturating_add(number) <= before.count(code));
        let is_whole = before.added(&after, &touched).is_empty() && is_mended;
        let paired = (is_whole && is_paired).then(|| self.difference(&originals));
        self.restore(originals);
        match (is_whole, paired) {
            (true, Some(edit)) => Verdict::Paired(edit),
            (true, None) => Verdict::Whole,
            (false, _) => Verdict::Refused,
        }
    }

    /// Selects edits that can be made together, from edits with the code of the finding that each repairs.
    /// Each selected edit is whole by itself and together with those before it. Edits that touch another one
    /// are skipped. Returns the selected edits as one, and their indexes.
    ///
    /// With `follow`, changes of the sources may be added.
    pub fn together(&mut self, edits: &[(Edit, &str)], follow: bool) -> (Edit, Vec<usize>) {
        if edits.len() > 1 && self.are_whole_together(edits) {
            let mut all = Edit::default();
            for pair in edits {
                _ = all.merge(pair.0.clone());
            }
            return (all, (0..edits.len()).collect());
        }
        let mut chosen = Edit::default();
        let mut numbers = Vec::new();
        for (number, (edit, code)) in edits.iter().enumerate() {
            let mut more = chosen.clone();
            if more.touches(edit) {
                continue;
            }
            let edit = match self.judged(edit, &[(code, 1)], follow) {
                Verdict::Whole => edit.clone(),
                Verdict::Paired(edit) if follow => edit,
                _ => continue,
            };
            if more.touches(&edit) || !more.merge(edit) {
                continue;
            }
            if numbers.is_empty() || self.verdict_alone(&more, code) == Verdict::Whole {
                chosen = more;
                numbers.push(number);
            }
        }
        (chosen, numbers)
    }

    /// Replaces the texts of files. Returns the previous texts.
    fn overlay(&mut self, changes: Vec<FileChange>) -> BTreeMap<Utf8PathBuf, Option<String>> {
        let mut originals = BTreeMap::new();
        for change in changes {
            self.project.overlay(change.path.clone(), change.after);
            originals.insert(change.path, change.before);
        }
        originals
    }

    fn restore(&mut self, originals: BTreeMap<Utf8PathBuf, Option<String>>) {
        for (path, text) in originals {
            self.project.restore(path, text);
        }
    }

    /// The edit from some previous texts to the present ones.
    fn difference(&self, originals: &BTreeMap<Utf8PathBuf, Option<String>>) -> Edit {
        let mut edit = Edit::default();
        for (path, before) in originals {
            let after = self.project.text(path).unwrap_or_default();
            match before {
                None => {
                    edit.created.insert(path.clone(), after.to_string());
                }
                Some(before) => {
                    for line_edit in line_edits(before, &after) {
                        edit.replace(path, line_edit.range, line_edit.text);
                    }
                }
            }
        }
        edit
    }
}

/// The lines that an edit changes, in the text after it.
#[derive(Default)]
struct ChangedLines {
    lines: BTreeMap<Utf8PathBuf, Vec<Range<usize>>>,
}

impl ChangedLines {
    fn of(edit: &Edit, changes: &[FileChange]) -> ChangedLines {
        let mut lines: BTreeMap<Utf8PathBuf, Vec<Range<usize>>> = BTreeMap::new();
        for change in changes {
            let here = lines.entry(change.path.clone()).or_default();
            let Some(edits) = edit.changed.get(&change.path) else {
                here.push(0..change.after.len());
                continue;
            };
            let mut moved = 0isize;
            for edit in edits {
                let start = edit.range.start.saturating_add_signed(moved);
                let (before, after) = change.after.split_at_checked(start).unwrap_or_default();
                let line = before.rfind('\n').map_or(0, |end| end + 1);
                let rest = after.get(edit.text.len()..).unwrap_or_default();
                let end = rest.find('\n').unwrap_or(rest.len());
                here.push(line..start + edit.text.len() + end);
                moved += edit.text.len() as isize - edit.range.len() as isize;
            }
        }
        ChangedLines { lines }
    }

    /// True if a place is on a changed line.
    fn is_at(&self, path: &Utf8Path, at: &Range<usize>) -> bool {
        let mut ranges = self.lines.get(path).into_iter().flatten();
        ranges.any(|range| range.start <= at.end && at.start <= range.end)
    }
}

/// All findings about some specifications and their codels.
#[derive(Default)]
struct Findings {
    all: Vec<Diagnostic>,
    drifts: Vec<(usize, Drift)>,
    folders: Vec<Folder>,
    counts: FxHashMap<&'static str, usize>,
    errors: usize,
    /// True if codels were compared.
    has_codels: bool,
}

impl Findings {
    /// The findings of specifications alone: no source is parsed.
    fn of_specifications(project: &Project<'_>, roots: &[Utf8PathBuf]) -> Findings {
        let all = project.diagnostics(roots);
        let errors = all.iter().filter(|diagnostic| diagnostic.severity == Severity::Error).count();
        let mut out = Findings { errors, ..Findings::default() };
        out.add(all);
        out
    }

    fn add(&mut self, found: Vec<Diagnostic>) {
        for diagnostic in &found {
            *self.counts.entry(diagnostic.code).or_default() += 1;
        }
        self.all.extend(found);
    }

    /// Adds the findings about codels.
    fn add_codels(&mut self, project: &mut Project<'_>, roots: &[Utf8PathBuf]) {
        self.has_codels = true;
        let mut compared = Vec::new();
        for folder in project.folders(roots, &mut Vec::new()) {
            if !folder.sources.exists {
                continue;
            }
            let all = folder.check(&folder.expected());
            let mut found = project.adjusted(&folder, all.clone());
            // The number of missing functions is not a finding of its own.
            found.retain(|drift| !matches!(drift.kind, Difference::Unwritten { .. }));
            self.add(diagnostics(&found, &*folder.unit.locations, Side::First));
            let index = compared.len();
            self.drifts.extend(found.into_iter().map(|drift| (index, drift)));
            compared.push((folder, all));
        }
        self.add(project.unused_allowances(&compared));
        self.folders = compared.into_iter().map(|(folder, _)| folder).collect();
    }

    fn count(&self, code: &str) -> usize {
        self.counts.get(code).copied().unwrap_or(0)
    }

    /// Codes with more findings after an edit. Findings that existed before but were hidden do not count.
    /// After the removal of an error these are hints, findings of rules that wait until a specification is
    /// accepted, and findings away from the changed lines. After a change of a function's prototype these are
    /// uses in its body that have become invalid.
    fn added(&self, after: &Findings, touched: &ChangedLines) -> Vec<&'static str> {
        let reveals = after.errors < self.errors;
        let follows = after.count(SIGNATURE_MISMATCH) < self.count(SIGNATURE_MISMATCH);
        let in_body = ["codel/undeclared-name", "codel/constant-write", "codel/unwritten-port"];
        let is_left = |code: &str| follows && in_body.contains(&code);
        let mut out = Vec::new();
        for (&code, &count) in &after.counts {
            if count <= self.count(code) || is_left(code) {
                continue;
            }
            let waits = lints::find(code).is_some_and(|code| code.absence);
            let new = after.all.iter().filter(|diagnostic| diagnostic.code == code);
            let mut told = new.filter(|diagnostic| diagnostic.severity <= Severity::Warning);
            if !reveals
                || !waits
                    && told.any(|diagnostic| touched.is_at(&diagnostic.path, &diagnostic.range))
            {
                out.push(code);
            }
        }
        out
    }

    /// True if every finding of a code has a repair that adapts the sources.
    fn is_followed(&self, code: &&'static str) -> bool {
        let of_code = |drift: &&(usize, Drift)| drift.1.code() == *code;
        let mut found = self.drifts.iter().filter(of_code).peekable();
        found.peek().is_some() && found.all(|drift| drift.1.following().is_some())
    }

    /// The repairs that adapt the sources to findings of some codes, as one edit.
    fn following(&self, project: &Project<'_>, codes: &[&'static str]) -> Edit {
        let mut edit = Edit::default();
        for (index, folder) in self.folders.iter().enumerate() {
            let options = project.stub_options(&folder.specification);
            for expected in &folder.expected() {
                let repairs = project.repairs(folder, expected, &options);
                let mut stubs = Vec::new();
                let here = self.drifts.iter().filter(|(at, drift)| {
                    *at == index
                        && drift.component == expected.component
                        && codes.contains(&drift.code())
                });
                for (_, drift) in here {
                    match drift.following() {
                        Some(Repair::Stub { at }) => stubs.push(*at),
                        Some(repair) => {
                            if let Some(one) = repairs.edit(repair) {
                                edit.merge(one);
                            }
                        }
                        None => {}
                    }
                }
                if let Ok(one) = repairs.stub(&stubs)
                    && !stubs.is_empty()
                {
                    edit.merge(one);
                }
            }
        }
        edit
    }
}
