//! Code actions that make specifications and codels agree.

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::Cancellable;
use dotgen_analysis::model::{CodelRef, Owner};
use dotgen_analysis::source_map::Locations;
use dotgen_codegen::codels::command::{FileChange, SyncOptions, sync};
use dotgen_codegen::codels::diagnostics::{Side, diagnostics};
use dotgen_codegen::codels::drift::{Drift, ORPHAN, Repair};
use dotgen_codegen::codels::edit::{Edit, apply, line_edits};
use dotgen_codegen::codels::expected::owner_words;
use dotgen_codegen::codels::files::Files as _;
use dotgen_codegen::codels::folder::Folder;
use dotgen_codegen::codels::links;
use dotgen_codegen::codels::repair::Repairs;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::features::codels::judged_actions::{self, JudgedActions};
use crate::features::codels::{self, Texts};
use crate::features::commands::SHOW_CODEL;
use crate::features::convert::diagnostic;
use crate::features::convert::edit::{EditResult, Review, edit_of, is_wanted, with_edit};
use crate::features::project_settings;
use crate::protocol::convert::Lines;
use crate::protocol::convert::position::touches;
use crate::protocol::types::*;
use crate::protocol::user_result::UserResult;
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};

/// Kind of the action that applies every fix. It is not below `source.fixAll`, which editors run on save
/// without a question.
pub(crate) const SYNC: CodeActionKind = CodeActionKind::new("source.syncCodels");

/// Title of that action.
const FIX_ALL: &str = "Fix all differences between specification and codels";

/// The data of an action that is resolved later.
#[derive(Debug, Serialize, Deserialize)]
struct Data {
    /// The document in which the action was offered.
    sync: Utf8PathBuf,
}

/// `textDocument/codeAction` in a source.
pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &CodeActionParams,
) -> Answer<Option<CodeActionResponse>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let range = lines.clamped(params.range).ok_or(Stop::Nothing)?;
    let mut out = Vec::new();
    judged_actions::offers(snapshot, &subject.path, |offers| {
        let wanted = |action_kind: &CodeActionKind| offered(params, action_kind);
        actions(snapshot, subject, &range, &wanted, offers, &mut out)
    })?;
    Ok(Some(out))
}

/// True if actions of a kind are offered. Actions that change every file are offered only on request.
pub(crate) fn offered(params: &CodeActionParams, kind: &CodeActionKind) -> bool {
    is_wanted(params, kind) && (*kind != SYNC || params.context.only.is_some())
}

/// The actions for a range of a specification or a source.
pub(crate) fn actions(
    snapshot: &Snapshot,
    subject: &Subject,
    range: &std::ops::Range<usize>,
    wanted: &dyn Fn(&CodeActionKind) -> bool,
    offers: &mut JudgedActions<'_, '_, '_>,
    out: &mut Vec<CodeActionOrCommand>,
) -> Cancellable<()> {
    let quick = wanted(&CodeActionKind::QUICKFIX);
    let rewrite = wanted(&CodeActionKind::REFACTOR_REWRITE);
    let sync_wanted = wanted(&SYNC);
    if !(quick || rewrite || sync_wanted) {
        return Ok(());
    }
    let texts = Texts::new(snapshot);
    for compared in codels::around(snapshot, &subject.path)? {
        let mut here = false;
        let mut mendable = 0;
        for found in compared.findings(&snapshot.analysis) {
            let (folder, findings) = found?;
            let work = Work { snapshot, subject, folder, texts: &texts };
            mendable += findings.iter().filter(|finding| !finding.repairs.is_empty()).count();
            for drift in findings.iter().filter(|_| quick) {
                here |= work.fixes(drift, range, offers, out)?;
            }
            if rewrite && !snapshot.is_code(&subject.path) {
                work.stubs_at(range, offers, out)?;
            }
        }
        let fix = here && mendable > 1 && quick;
        if mendable > 0 && (fix || sync_wanted) {
            out.extend(sync_action(snapshot, subject, fix)?);
        }
    }
    texts.check()
}

/// The data for the edits of one folder.
struct Work<'a> {
    snapshot: &'a Snapshot,
    subject: &'a Subject,
    folder: &'a Folder,
    texts: &'a Texts<'a>,
}

impl Work<'_> {
    /// Adds the fixes of a finding with a place in a range of the document. Returns true if the finding has
    /// such a place.
    fn fixes(
        &self,
        drift: &Drift,
        range: &std::ops::Range<usize>,
        offers: &mut JudgedActions<'_, '_, '_>,
        out: &mut Vec<CodeActionOrCommand>,
    ) -> Cancellable<bool> {
        let one = std::slice::from_ref(drift);
        let all = diagnostics(one, &*self.folder.unit.locations, Side::Both);
        let mut all = all.into_iter().filter(|entry| entry.path == self.subject.path);
        let Some(here) = all.find(|entry| touches(&entry.range, range)) else {
            return Ok(false);
        };
        let shown = diagnostic::to_proto(self.snapshot, &here)?;
        let expected = self.folder.expected();
        let Some(expected) = expected.iter().find(|expected| expected.component == drift.component)
        else {
            return Ok(true);
        };
        let stubs = codels::stub_options(self.folder, self.texts);
        let repairs = codels::repairs(self.folder, expected, self.texts, &stubs);
        let mut push = |title, edit: &Edit, written: Option<&str>, preferred| -> Cancellable<()> {
            // A stub next to a function that looks like the codel does not fix the finding about that
            // function.
            let mends = drift.code() != ORPHAN || written.is_none();
            let about = shown.clone().filter(|_| mends);
            let action = CodeAction {
                title,
                kind: Some(CodeActionKind::QUICKFIX),
                diagnostics: about.map(|finding| vec![finding]),
                is_preferred: Some(preferred && mends),
                ..CodeAction::default()
            };
            let code = mends.then_some(drift.code());
            out.extend(self.action(action, edit, written, code, offers)?);
            Ok(())
        };
        let name = |at: CodelRef| expected.component().codel(at).name.as_str();
        let ordered = repairs.ordered(drift);
        let adapts = |repair: &&&Repair| matches!(repair, Repair::AdaptParameters { .. });
        let others = ordered.iter().filter(|repair| !adapts(repair)).count();
        let only = |repair: &Repair| {
            others == 1 && !matches!(repair, Repair::RemoveYield { .. }) && !repair.is_choice()
        };
        for &repair in &ordered {
            if let Some(edit) = repairs.edit(repair) {
                let written = match repair {
                    Repair::Stub { at } => Some(name(*at)),
                    _ => None,
                };
                push(repairs.title(repair), &edit, written, only(repair))?;
            }
            if let Repair::Stub { at } = repair {
                for (title, codels) in stub_groups(&repairs, at.owner) {
                    if let Ok(edit) = repairs.stub(&codels) {
                        push(title, &edit, Some(name(*at)), false)?;
                    }
                }
            }
        }
        project_settings::allow(self.snapshot, self.subject, &here, out)?;
        Ok(true)
    }

    /// Stubs for the codel, the task or service, or the component whose name is selected.
    fn stubs_at(
        &self,
        range: &std::ops::Range<usize>,
        offers: &mut JudgedActions<'_, '_, '_>,
        out: &mut Vec<CodeActionOrCommand>,
    ) -> Cancellable<()> {
        for expected in &self.folder.expected() {
            let stubs = codels::stub_options(self.folder, self.texts);
            let repairs = codels::repairs(self.folder, expected, self.texts, &stubs);
            let component = expected.component();
            let selected = |src| {
                let place = self.folder.unit.locations.locate(src);
                place.is_some_and(|place| {
                    place.path == self.subject.path && touches(&place.range, range)
                })
            };
            let mut wanted: Vec<(String, Vec<CodelRef>)> = Vec::new();
            let missing = repairs.missing();
            // If only some functions are missing, a diagnostic offers their stubs.
            let silent = !self.folder.sources.exists || missing.len() == expected.functions.len();
            if !silent || missing.is_empty() {
                continue;
            }
            let codel = missing.iter().find(|codel| selected(component.codel(**codel).src));
            if let Some(at) = codel {
                wanted.push((repairs.title(&Repair::Stub { at: *at }), vec![*at]));
            }
            for owner in component.owners() {
                let src = match owner {
                    Owner::Task(task) => component.tasks[task].src,
                    Owner::Service(service) => component.services[service].src,
                };
                let of_owner = repairs.missing_codels_of(owner);
                if selected(src) && !of_owner.is_empty() {
                    wanted.push((owner_title(&repairs, owner, of_owner.len()), of_owner));
                }
            }
            if selected(component.src) {
                wanted.push((component_title(&repairs, missing.len()), missing));
            }
            for (title, codels) in wanted {
                let Ok(edit) = repairs.stub(&codels) else {
                    continue;
                };
                let action = CodeAction {
                    title,
                    kind: Some(CodeActionKind::REFACTOR_REWRITE),
                    ..CodeAction::default()
                };
                let first = codels.first().map(|codel| component.codel(*codel).name.as_str());
                out.extend(self.action(action, &edit, first, None, offers)?);
            }
        }
        Ok(())
    }

    /// The action with its edit. If the edit writes the function of a codel, the client then shows the body
    /// of that function. `None` if there is no edit, or if the edit would replace an existing file.
    fn action(
        &self,
        action: CodeAction,
        edit: &Edit,
        written: Option<&str>,
        mends: Option<&str>,
        offers: &mut JudgedActions<'_, '_, '_>,
    ) -> Cancellable<Option<CodeActionOrCommand>> {
        let mut created = edit.created.keys();
        if edit.is_empty() || created.any(|key| self.texts.read(key).is_some()) {
            return Ok(None);
        }
        let body = written.and_then(|text| self.body(edit, text));
        let action = CodeAction {
            command: body.map(|body| {
                Command::new("Show".to_owned(), SHOW_CODEL.to_owned(), Some(vec![body]))
            }),
            ..action
        };
        offers.action(action, edit, mends)
    }

    /// The place of the body of a function in the edited texts, for clients that can show it.
    fn body(&self, edit: &Edit, codel: &str) -> Option<serde_json::Value> {
        if !self.snapshot.client.show_document {
            return None;
        }
        let created = edit.created.iter().map(|(path, text)| (path, text.clone()));
        let changed = edit
            .changed
            .iter()
            .filter_map(|(path, edits)| Some((path, apply(&self.texts.read(path)?, edits))));
        let mut texts = created.chain(changed);
        texts.find_map(|(path, text)| {
            let body = links::body_start(path, &text, codel)?;
            let range = Lines::new(text.into(), self.snapshot.client.encoding).range(&body);
            let uri = self.snapshot.uri(path)?;
            Some(json!(Location { uri, range }))
        })
    }
}

/// Stubs for the task or service of a codel, and for the component, if they have more missing codels.
fn stub_groups(repairs: &Repairs<'_>, owner: Owner) -> Vec<(String, Vec<CodelRef>)> {
    let of_owner = repairs.missing_codels_of(owner);
    let all = repairs.missing();
    let mut out = Vec::new();
    if of_owner.len() > 1 {
        out.push((owner_title(repairs, owner, of_owner.len()), of_owner.clone()));
    }
    if all.len() > of_owner.len().max(1) {
        out.push((component_title(repairs, all.len()), all));
    }
    out
}

fn owner_title(repairs: &Repairs<'_>, owner: Owner, count: usize) -> String {
    let (kind, name) = owner_words(repairs.expected.component(), owner);
    format!("Write {} of {kind} `{name}`", stubs(count))
}

fn component_title(repairs: &Repairs<'_>, count: usize) -> String {
    let name = &repairs.expected.component().name;
    format!("Write {} of component `{name}`", stubs(count))
}

fn stubs(count: usize) -> String {
    match count {
        1 => "the missing stub".to_owned(),
        count => format!("the {count} missing stubs"),
    }
}

/// The action that applies every fix. Its edit is computed on resolve, if the client supports that.
fn sync_action(
    snapshot: &Snapshot,
    subject: &Subject,
    fix: bool,
) -> Cancellable<Option<CodeActionOrCommand>> {
    let action = CodeAction {
        title: FIX_ALL.to_owned(),
        kind: Some(if fix { CodeActionKind::QUICKFIX } else { SYNC }),
        ..CodeAction::default()
    };
    let action = if snapshot.client.resolves_edits {
        Some(CodeAction { data: Some(json!({ "sync": subject.path })), ..action })
    } else {
        sync_edit(snapshot, &subject.path)?.and_then(|edit| with_edit(snapshot, action, edit))
    };
    Ok(action.map(CodeActionOrCommand::CodeAction))
}

/// `codeAction/resolve`
pub(crate) fn resolve(
    snapshot: &Snapshot,
    action: &CodeAction,
) -> Cancellable<UserResult<CodeAction>> {
    let data = action.data.clone().map(serde_json::from_value::<Data>);
    let Some(Ok(data)) = data else {
        return Ok(UserResult::default());
    };
    let edit = sync_edit(snapshot, &data.sync)?.transpose();
    Ok(UserResult(edit.map(|edit| Some(CodeAction { edit, ..action.clone() }))))
}

/// Every fix around a document, hints included.
fn sync_edit(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Option<EditResult>> {
    let mut roots: Vec<Utf8PathBuf> = Vec::new();
    for compared in codels::around(snapshot, path)? {
        for folder in compared.folders() {
            let beside = folder.specification.parent();
            roots.push(snapshot.analysis.root_of(&folder.specification)?);
            roots.extend(snapshot.roots.iter().filter(|root| root.parent() == beside).cloned());
        }
    }
    roots.sort();
    roots.dedup();
    let mut host = judged_actions::private_host(snapshot)?;
    let texts = Texts::new(snapshot);
    let mut project = judged_actions::project(&mut host, snapshot, &texts, path);
    // A yield that the code does not use may be intended: it is removed only on request.
    let options = SyncOptions::default();
    let done = sync(&mut project, &roots, &options);
    drop(project);
    texts.check()?;
    let mut edit = Edit::default();
    for FileChange { path, before, after } in done.changes {
        match before {
            Some(before) => {
                for line_edit in line_edits(&before, &after) {
                    edit.replace(&path, line_edit.range, line_edit.text);
                }
            }
            None => {
                edit.created.insert(path, after);
            }
        }
    }
    if edit.is_empty() {
        return Ok(None);
    }
    edit_of(snapshot, Review::SeveralFiles(FIX_ALL), &edit).map(Some)
}
