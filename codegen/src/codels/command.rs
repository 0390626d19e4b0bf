//! The commands of the command line for codels: `check`, `stub`, `sync`, `headers`.

pub mod judge;
mod project;
mod report;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::model::{ComponentId, Owner};
use dotgen_syntax::encoding::LineEnd;
use serde::Serialize;

use super::{
    drift::{self, Repair},
    edit::{Edit, apply, unified_diff},
    expected::{Expected, state_text},
    repair::ManualChange,
    stub::NewFile,
};

use self::judge::{Judge, Verdict};
pub use super::folder::Folder;
pub use project::Project;
pub use report::{CheckReport, Finding, FolderSummary};

/// The codels that get a stub.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StubTarget {
    /// Every codel without a function.
    All,
    /// The codels of a task or service.
    Owner(String),
    Codel(String),
}

/// A file that a command would change.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FileChange {
    pub path: Utf8PathBuf,
    /// Present text; `None` if the file does not exist.
    pub before: Option<String>,
    /// New text.
    pub after: String,
}

impl FileChange {
    /// The change in the format of `diff -u`.
    pub fn diff(&self) -> String {
        unified_diff(&self.path, self.before.as_deref(), &self.after)
    }
}

/// The result of `sync`.
#[derive(Debug, Clone, Default, Serialize)]
pub struct SyncReport {
    /// Changes, by path. They are not written yet.
    pub changes: Vec<FileChange>,
    /// Descriptions of the applied repairs, in order.
    pub applied: Vec<String>,
    /// Changes after a new signature that have to be made by hand.
    pub notes: Vec<ManualChange>,
    /// The remaining findings after the changes.
    pub left: CheckReport,
}

/// The repairs that `sync` applies.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SyncOptions {
    /// Yields to remove that the code never returns: name of the codel, and the state as written (`main`,
    /// `pause::main`). Other yields are not removed, because they may be intended.
    pub remove_yields: Vec<(String, String)>,
}

impl SyncOptions {
    /// True if a repair removes a yield that is listed.
    fn removes(&self, expected: &Expected<'_>, repair: &Repair) -> bool {
        let Repair::RemoveYield { at, index } = repair else {
            return false;
        };
        let codel = expected.component().codel(*at);
        let state = codel.yields.get(*index).map(state_text);
        let mut all = self.remove_yields.iter();
        all.any(|entry| entry.0 == codel.name && Some(&entry.1) == state.as_ref())
    }
}

/// Maximum number of rounds of `sync`. An edit of the specification makes comments outdated; they are
/// repaired in a later round.
const ROUNDS: usize = 6;

/// Compares specifications with their codels.
pub fn check(project: &mut Project<'_>, roots: &[Utf8PathBuf]) -> CheckReport {
    let mut report = CheckReport::default();
    for folder in project.folders(roots, &mut report.errors) {
        report.add(project, &folder);
    }
    report
}

/// Stubs for codels without a function. Nothing is written.
pub fn stub(
    project: &mut Project<'_>,
    root: &Utf8Path,
    target: &StubTarget,
) -> Result<Vec<FileChange>, String> {
    let mut errors = Vec::new();
    let folders = project.folders(&[root.to_owned()], &mut errors);
    if let Some(error) = errors.into_iter().next() {
        return Err(error);
    }
    let mut edit = Edit::default();
    let mut known = false;
    for folder in &folders {
        // Without a file that is missing on this machine, its types count as structures.
        if let Some(error) = folder.unit.errors_in_text().next() {
            return Err(format!("no stubs of a specification with errors: {}", error.message));
        }
        for expected in folder.expected() {
            let component = expected.component();
            let stubs = project.stub_options(&folder.specification);
            let repairs = project.repairs(folder, &expected, &stubs);
            let mut codels = repairs.missing();
            match target {
                StubTarget::All => known = true,
                StubTarget::Owner(name) => {
                    let owner = |owner: Owner| {
                        super::expected::owner_words(component, owner).1 == name.as_str()
                    };
                    known |= component.all_codels().any(|codel| owner(codel.owner));
                    codels.retain(|codel| owner(codel.owner));
                }
                StubTarget::Codel(name) => {
                    let named = |codel| component.codel(codel).name == name.as_str();
                    known |= component.all_codels().any(named);
                    codels.retain(|codel| named(*codel));
                }
            }
            let one = repairs.stub(&codels).map_err(|error| error.message)?;
            edit.merge(one);
        }
    }
    match target {
        StubTarget::Owner(name) if !known => Err(format!("no task or service `{name}` in {root}")),
        StubTarget::Codel(name) if !known => Err(format!("no codel `{name}` in {root}")),
        _ => Ok(project.changes(&edit)),
    }
}

/// Repairs all drift that has one obvious repair. Nothing is written.
pub fn sync(project: &mut Project<'_>, roots: &[Utf8PathBuf], options: &SyncOptions) -> SyncReport {
    let mut out = SyncReport::default();
    let mut touched: BTreeSet<Utf8PathBuf> = BTreeSet::new();
    let mut tried: Vec<Edit> = Vec::new();
    let mut room = judge::MAX_TRIALS;
    for _ in 0..ROUNDS {
        let candidates = round(project, roots, options, &mut tried);
        let (edit, made) = whole(project, roots, &candidates, &mut room);
        if edit.is_empty() {
            break;
        }
        for (number, candidate) in candidates.into_iter().enumerate() {
            if made.contains(&number) {
                out.applied.extend(candidate.titles);
                out.notes.extend(candidate.notes);
            }
        }
        for note in &mut out.notes {
            note.follow(edit.changed.get(&note.path).map_or(&[], Vec::as_slice));
        }
        for change in project.changes(&edit) {
            touched.insert(change.path.clone());
            project.overlay(change.path, change.after);
        }
    }
    for note in &mut out.notes {
        note.set_line(&project.text(&note.path).unwrap_or_default());
    }
    out.left = check(project, roots);
    for path in touched {
        if let Some(after) = project.text(&path) {
            let before = project.text_before(&path);
            if before.as_deref() != Some(&*after) {
                out.changes.push(FileChange {
                    path,
                    before: before.map(|text| text.to_string()),
                    after: after.to_string(),
                });
            }
        }
    }
    out
}

/// An edit that `sync` may make.
struct Candidate {
    edit: Edit,
    /// The finding that it repairs.
    code: &'static str,
    titles: Vec<String>,
    notes: Vec<ManualChange>,
}

/// The edits of candidates that are accepted. If all of them together add no finding, all are accepted.
/// Otherwise those are accepted that add no finding alone and together, with the edits that complete them.
fn whole(
    project: &mut Project<'_>,
    roots: &[Utf8PathBuf],
    candidates: &[Candidate],
    room: &mut usize,
) -> (Edit, Vec<usize>) {
    let mut all = Edit::default();
    let mut numbers = Vec::new();
    for (number, candidate) in candidates.iter().enumerate() {
        if all.merge(candidate.edit.clone()) {
            numbers.push(number);
        }
    }
    let mut judge = Judge::new(project, roots);
    judge.room = *room;
    let verdict = judge.verdict(&all, None);
    let chosen = match verdict {
        Verdict::Whole => (all, numbers),
        Verdict::Paired(all) => (all, numbers),
        Verdict::Refused | Verdict::Unknown => {
            let edits = candidates.iter().map(|candidate| (candidate.edit.clone(), candidate.code));
            judge.together(&edits.collect::<Vec<_>>(), true)
        }
    };
    *room = judge.room;
    chosen
}

/// One pass over all findings: an edit for each finding that has a repair.
fn round(
    project: &mut Project<'_>,
    roots: &[Utf8PathBuf],
    options: &SyncOptions,
    tried: &mut Vec<Edit>,
) -> Vec<Candidate> {
    let mut out = Vec::new();
    for folder in project.folders(roots, &mut Vec::new()) {
        let all = folder.expected();
        let findings = project.findings(&folder, &all);
        // Stubs of one folder are made together: several may go into one new file.
        let mut stubs: BTreeMap<ComponentId, Vec<_>> = BTreeMap::new();
        for drift in &findings {
            let Some(expected) = all.iter().find(|expected| expected.component == drift.component)
            else {
                continue;
            };
            let named = |repair: &&Repair| options.removes(expected, repair);
            let stub_options = project.stub_options(&folder.specification);
            let repairs = project.repairs(&folder, expected, &stub_options);
            let ordered = repairs.ordered(drift);
            let first = ordered.first().copied();
            let first = first.filter(|repair| !matches!(repair, Repair::RemoveYield { .. }));
            // A repair that is a choice is not applied; its finding remains in the report.
            let first = first.filter(|repair| !repair.is_choice());
            let Some(repair) = drift.repairs.iter().find(named).or(first) else {
                continue;
            };
            if let Repair::Stub { at } = repair {
                stubs.entry(drift.component).or_default().push(*at);
                continue;
            }
            let title = repairs.title(repair);
            if let Some(one) = repairs.edit(repair)
                && !one.is_empty()
                // A repair that did not help once is not tried again.
                && !tried.contains(&one)
            {
                tried.push(one.clone());
                let notes = match repair {
                    Repair::UpdateSignature { name, path, start } => {
                        repairs.manual_changes(name, path, *start)
                    }
                    _ => Vec::new(),
                };
                out.push(Candidate { edit: one, code: drift.code(), titles: vec![title], notes });
            }
        }
        for expected in &all {
            let Some(codels) = stubs.get(&expected.component) else {
                continue;
            };
            let options = project.stub_options(&folder.specification);
            let repairs = project.repairs(&folder, expected, &options);
            if let Ok(edit) = repairs.stub(codels) {
                let titles = codels.iter().map(|&at| repairs.title(&Repair::Stub { at }));
                out.push(Candidate {
                    edit,
                    code: drift::MISSING_DEFINITION,
                    titles: titles.collect(),
                    notes: Vec::new(),
                });
            }
        }
    }
    out
}

/// Headers for compilers and editors of every component of a specification, for a folder `cache`.
pub fn headers(
    project: &mut Project<'_>,
    root: &Utf8Path,
    cache: &Utf8Path,
    flags: &[String],
) -> Result<Vec<NewFile>, String> {
    let mut errors = Vec::new();
    let folders = project.folders(&[root.to_owned()], &mut errors);
    if let Some(error) = errors.into_iter().next() {
        return Err(error);
    }
    let mut out: Vec<NewFile> = Vec::new();
    for folder in &folders {
        for expected in folder.expected() {
            let codels = &folder.sources.folder;
            let files = super::headers::headers(&expected, cache, codels, flags);
            for file in files.map_err(|error| error.message)? {
                if !out.contains(&file) {
                    out.push(file);
                }
            }
        }
    }
    Ok(out)
}

impl Project<'_> {
    /// The files that an edit changes, with their texts before and after.
    pub fn changes(&self, edit: &Edit) -> Vec<FileChange> {
        let created = edit.created.iter().map(|(path, text)| FileChange {
            path: path.clone(),
            before: self.text(path).map(|text: Arc<str>| text.to_string()),
            // Copied text may contain other line ends.
            after: LineEnd::Lf.fit(text).into_owned(),
        });
        let changed = edit.changed.iter().filter_map(|(path, edits)| {
            let before = self.text(path)?;
            Some(FileChange {
                path: path.clone(),
                after: apply(&before, edits),
                before: Some(before.to_string()),
            })
        });
        let mut out: Vec<FileChange> = created.chain(changed).collect();
        out.sort_by(|a, b| a.path.cmp(&b.path));
        out
    }
}
