//! `dotgen check --fix` and `--diff`: plain fixes are applied.

use std::collections::BTreeMap;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::{Diagnostic, Fix, FixKind, Severity};
use dotgen_codegen::codels::command::Project;
use dotgen_codegen::codels::command::judge::{Judge, MAX_TRIALS, Verdict};
use dotgen_codegen::codels::edit::Edit;
use dotgen_codegen::codels::folder::NEVER_THROWN;

use super::{CommandExit, ErrorReporter, FileReports, Session, check};
use crate::{codels, fmt, report, session};

/// Maximum number of rounds. A fix may reveal other errors.
pub(super) const MAX_ROUNDS: usize = 20;

/// Maximum number of errors of one file for which fixes are found by trial.
const MAX_TRIED: usize = 3;

/// The fixes that are applied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Applied {
    /// Those without an alternative.
    Plain,
    /// Also the first proposal for an error.
    AlsoGuesses,
}

impl Applied {
    pub(super) fn includes(self, fix: &Fix, severity: Severity) -> bool {
        let is_guess = fix.kind == FixKind::Guess && severity == Severity::Error;
        fix.kind == FixKind::Plain || is_guess && self == Applied::AlsoGuesses
    }
}

/// The fixes of a finding that are shown, and so tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shown {
    /// The first whole one.
    First,
    /// Every whole one.
    All,
}

/// Original and new texts, by file.
pub(super) type ChangedTexts = BTreeMap<Utf8PathBuf, (String, String)>;

/// Titles of the applied fixes, with their number, by file.
pub(super) type AppliedFixes = BTreeMap<Utf8PathBuf, BTreeMap<String, usize>>;

/// Applies fixes to the texts of a session, in memory. A fix is applied if it was tried and is whole: see
/// [`judge`](dotgen_codegen::codels::command::judge).
pub(super) fn apply_fixes(
    session: &mut Session,
    which: Applied,
    changed: &mut ChangedTexts,
    titles: &mut AppliedFixes,
) -> anyhow::Result<()> {
    let mut room = MAX_TRIALS;
    for _ in 0..MAX_ROUNDS {
        let mut report = FileReports::default();
        // Files that cannot be read are reported once, with the final report.
        check(session, &mut report, &mut ErrorReporter::silent());
        if which == Applied::AlsoGuesses {
            // The first proposal may be one that the judge refuses, and others are found by trial.
            judge(session, changed, &mut report.diagnostics, Shown::First);
        }
        let found = report.diagnostics.iter();
        let first = found.filter_map(|diagnostic| Some((diagnostic.fixes.first()?, diagnostic)));
        let first = first.filter(|(fix, finding)| {
            which.includes(fix, finding.severity) && is_within_arguments(session, fix)
        });
        let edits: Vec<(Edit, &Diagnostic)> =
            first.map(|(fix, finding)| (Edit::of(&fix.edits), finding)).collect();
        let mut project = project(session, changed);
        let mut made = Vec::new();
        for (roots, edits) in by_roots(&project, edits) {
            let mut judge = Judge::new(&mut project, &roots);
            judge.room = room;
            let of_codes: Vec<(Edit, &str)> =
                edits.iter().map(|edit| (edit.0.clone(), edit.1.code)).collect();
            let (edit, chosen) = judge.together(&of_codes, false);
            room = judge.room;
            for edit in chosen.into_iter().filter_map(|place| edits.get(place)) {
                let title = edit.1.fixes.first().map_or("", |fix| &fix.title);
                let of_file = titles.entry(edit.1.path.clone()).or_default();
                *of_file.entry(title.to_owned()).or_default() += 1;
            }
            // Edits of other units are judged together with these.
            for change in project.changes(&edit) {
                project.overlay(change.path.clone(), change.after.clone());
                made.push(change);
            }
        }
        if made.is_empty() {
            return Ok(());
        }
        for change in made {
            let before = change.before.unwrap_or_default();
            changed.entry(change.path).or_insert((before, String::new())).1 = change.after;
        }
    }
    Ok(())
}

/// Keeps the fixes of findings that are whole. Fixes that cannot be tried within the limit are left out.
pub(super) fn judge(
    session: &mut Session,
    changed: &ChangedTexts,
    found: &mut [Diagnostic],
    shown: Shown,
) {
    let is_open = |diagnostic: &Diagnostic| {
        diagnostic.severity == Severity::Error || !diagnostic.fixes.is_empty()
    };
    if !found.iter().any(is_open) {
        return;
    }
    let mut project = project(session, changed);
    let mut room = MAX_TRIALS;
    let mut at = 0;
    while at < found.len() {
        let path = found[at].path.clone();
        let end = at + found[at..].iter().take_while(|diagnostic| diagnostic.path == path).count();
        let roots = project.roots_of(&path);
        let size = project.text(&path).map_or(0, |text| text.len());
        let mut judge = Judge::new(&mut project, &roots);
        judge.room = room;
        judge.limit(size);
        let allowed = judge.room;
        let mut verdicts = verdicts(&mut judge, &found[at..end], shown).into_iter();
        let had_room = judge.room > 0;
        let mut tried = 0;
        for number in at..end {
            let diagnostic = &mut found[number];
            diagnostic.fixes.retain_mut(|fix| {
                let verdict = verdicts.next().unwrap_or(Verdict::Unknown);
                if verdict != Verdict::Whole && fix.kind == FixKind::Plain {
                    fix.kind = FixKind::Guess;
                }
                // A fix of a file that many units include is offered without a trial.
                verdict == Verdict::Whole || verdict == Verdict::Unknown && had_room
            });
            if diagnostic.severity == Severity::Error
                && diagnostic.fixes.is_empty()
                && tried < MAX_TRIED
            {
                tried += 1;
                let code = diagnostic.code;
                let mut fixes = judge.project().trials(&found[number], &found[at..end]);
                fixes.retain_mut(|fix| {
                    judge.verdict_alone(&Edit::of(&fix.edits), code) == Verdict::Whole
                });
                found[number].fixes = fixes;
            }
        }
        room -= allowed - judge.room;
        at = end;
    }
}

/// Judges all fixes of findings of one file, in their order. The first fixes of all findings are tried
/// together, then the second ones, because alternatives exclude each other. Fixes of errors come first. A fix
/// that is not shown counts as refused.
fn verdicts(judge: &mut Judge<'_, '_>, found: &[Diagnostic], shown: Shown) -> Vec<Verdict> {
    let mut order: Vec<usize> = (0..found.len()).collect();
    order.sort_by_key(|&diagnostic| found[diagnostic].severity);
    let most = found.iter().map(|diagnostic| diagnostic.fixes.len()).max();
    let mut verdicts = vec![Vec::new(); found.len()];
    for rank in 0..most.unwrap_or(0) {
        let fixes = order.iter().filter_map(|&number| {
            let diagnostic = &found[number];
            let fix = diagnostic.fixes.get(rank)?;
            let is_settled = |verdicts: &[Verdict]| verdicts.contains(&Verdict::Whole);
            if shown == Shown::First && is_settled(&verdicts[number]) {
                return None;
            }
            Some((number, (Edit::of(&fix.edits), diagnostic.code)))
        });
        let (numbers, edits): (Vec<usize>, Vec<(Edit, &str)>) = fixes.unzip();
        for (number, verdict) in std::iter::zip(numbers, judge.verdicts(&edits)) {
            verdicts[number].push(verdict);
        }
    }
    for (verdicts, diagnostic) in std::iter::zip(&mut verdicts, found) {
        verdicts.resize(diagnostic.fixes.len(), Verdict::Refused);
    }
    verdicts.into_iter().flatten().collect()
}

/// Removes findings that the sources of codels contradict.
pub(super) fn retain_unrefuted(session: &mut Session, found: &mut Vec<Diagnostic>) {
    if found.iter().any(|diagnostic| diagnostic.code == NEVER_THROWN) {
        let project = codels::project(session);
        found.retain(|diagnostic| !project.refutes(diagnostic));
    }
}

/// Returns the specifications of a session and their codels, with the changed texts.
pub(super) fn project<'s>(session: &'s mut Session, changed: &ChangedTexts) -> Project<'s> {
    let mut project = codels::project(session);
    for (path, (_, new)) in changed {
        project.overlay(path.clone(), new.clone());
    }
    project
}

/// Edits by the roots of the units that they concern, each with the finding that it fixes.
type EditsByRoots<'e> = BTreeMap<Vec<Utf8PathBuf>, Vec<(Edit, &'e Diagnostic)>>;

fn by_roots<'e>(project: &Project<'_>, edits: Vec<(Edit, &'e Diagnostic)>) -> EditsByRoots<'e> {
    let mut out = EditsByRoots::new();
    for edit in edits {
        let paths = edit.0.changed.keys();
        let mut roots: Vec<_> = paths.flat_map(|path| project.roots_of(path)).collect();
        roots.sort();
        roots.dedup();
        out.entry(roots).or_default().push(edit);
    }
    out
}

/// Prints the changes.
pub(super) fn print(changed: &ChangedTexts) -> anyhow::Result<CommandExit> {
    for (path, (old, new)) in changed {
        fmt::print_diff(&session::display(path), old, new)?;
    }
    Ok(if changed.is_empty() { CommandExit::Fine } else { CommandExit::Errors })
}

/// Writes the new texts: all of them, or none.
pub(super) fn write(
    changed: &ChangedTexts,
    made: &AppliedFixes,
    within: &[Utf8PathBuf],
) -> anyhow::Result<()> {
    let files = changed.iter();
    let files = files.map(|(path, (old, new))| report::edited(path, Some(old), new)).collect();
    report::write_files(files, within)?;
    for (path, titles) in made {
        let title = |(title, count): (&String, &usize)| match count {
            1 => report::text::title(title),
            _ => format!("{} ({count} times)", report::text::title(title)),
        };
        let titles: Vec<String> = titles.iter().map(title).collect();
        let path = session::display(path);
        report::note(&format!("fixed `{path}`: {}", titles.join(", ")));
    }
    Ok(())
}

/// Returns true if a fix changes only files that were given, and files in their directories or below.
fn is_within_arguments(session: &Session, fix: &Fix) -> bool {
    let beside = |path: &Utf8Path| {
        let mut folders = session.files.iter().filter_map(|file| file.path.parent());
        folders.any(|folder| path.starts_with(folder))
    };
    fix.edits.iter().all(|edit| beside(&edit.path))
}
