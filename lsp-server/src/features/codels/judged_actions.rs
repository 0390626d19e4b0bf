//! Edits that were tried on a copy of the documents before they are offered, see [`judge`].
//!
//! [`judge`]: dotgen_codegen::codels::command::judge

use std::sync::Arc;

use camino::Utf8Path;
use dotgen_analysis::host::{AnalysisHost, Cancellable, Change};
use dotgen_codegen::codels::command::Project;
use dotgen_codegen::codels::command::judge::{Judge, Known, Verdict};
use dotgen_codegen::codels::edit::Edit;
use dotgen_codegen::codels::stub::StubOptions;

use crate::features::codels::{self, Texts};
use crate::features::convert::edit::{Review, edit_of, with_edit};
use crate::protocol::types::{CodeAction, CodeActionOrCommand};
use crate::workspace::codels::{Workshop, lock};
use crate::workspace::snapshot::Snapshot;

/// Makes actions of the edits that a judge allows.
pub(crate) struct JudgedActions<'o, 'j, 'p> {
    snapshot: &'o Snapshot,
    texts: &'o Texts<'o>,
    judge: Judge<'j, 'p>,
}

/// Calls `offer` with a judge of edits around a document.
pub(crate) fn offers<T>(
    snapshot: &Snapshot,
    path: &Utf8Path,
    offer: impl FnOnce(&mut JudgedActions<'_, '_, '_>) -> Cancellable<T>,
) -> Cancellable<T> {
    let mut roots = if snapshot.is_code(path) {
        codels::roots_around(snapshot, path)?
    } else {
        snapshot.analysis.roots_containing(path)?
    };
    if roots.is_empty() {
        roots.push(path.to_owned());
    }
    let mut workshop = workshop(snapshot)?;
    let texts = Texts::new(snapshot);
    let mut project = project(&mut workshop.host, snapshot, &texts, &roots[0]);
    let judge = Judge::knowing(&mut project, &roots, workshop.known);
    let mut offers = JudgedActions { snapshot, texts: &texts, judge };
    let out = offer(&mut offers)?;
    texts.check()?;
    workshop.known = offers.judge.into_known();
    *lock(&snapshot.codels.workshop) = Some(workshop);
    Ok(out)
}

impl JudgedActions<'_, '_, '_> {
    /// The action with an edit, or `None` if the judge refuses the edit. `mends`: the code of the finding
    /// that the edit fixes.
    pub(crate) fn action(
        &mut self,
        action: CodeAction,
        edit: &Edit,
        mends: Option<&str>,
    ) -> Cancellable<Option<CodeActionOrCommand>> {
        let verdict = self.judge.verdict(edit, mends);
        // Texts that were read after a cancellation are invalid.
        self.texts.check()?;
        let is_whole = verdict == Verdict::Whole;
        let (title, edit) = match &verdict {
            Verdict::Refused => return Ok(None),
            Verdict::Paired(all) => (format!("{}, and change the codels", action.title), all),
            Verdict::Whole | Verdict::Unknown => (action.title.clone(), edit),
        };
        let action = CodeAction {
            title,
            is_preferred: action.is_preferred.map(|flag| flag && is_whole),
            ..action
        };
        let edit = edit_of(self.snapshot, Review::None, edit)?;
        Ok(with_edit(self.snapshot, action, edit).map(CodeActionOrCommand::CodeAction))
    }

    /// See [`Judge::together`]. No source is changed: editors apply these edits without a question.
    pub(crate) fn together(&mut self, edits: &[(Edit, &str)]) -> Cancellable<Edit> {
        let edit = self.judge.together(edits, false).0;
        self.texts.check()?;
        Ok(edit)
    }
}

/// The workshop with the texts of a snapshot. Who has it puts it back after work that left its texts as they
/// were; otherwise the next request makes a new one.
fn workshop(snapshot: &Snapshot) -> Cancellable<Workshop> {
    let last = lock(&snapshot.codels.workshop).take();
    let same_settings = |last: &Workshop| {
        Arc::ptr_eq(&last.config, &snapshot.config) && Arc::ptr_eq(&last.roots, &snapshot.roots)
    };
    let Some(mut last) = last.filter(same_settings) else {
        return Ok(Workshop {
            host: private_host(snapshot)?,
            known: Known::default(),
            revision: snapshot.revision,
            config: snapshot.config.clone(),
            roots: snapshot.roots.clone(),
        });
    };
    if last.revision == snapshot.revision {
        return Ok(last);
    }
    let mut files = Vec::new();
    let known = last.host.known_at("".into());
    for path in known.into_iter().chain(snapshot.open.keys().cloned()) {
        let text = snapshot.analysis.text(&path)?;
        files.push((path, text.map(|text| text.to_string())));
    }
    last.host.apply(Change { files, ..Change::default() });
    Ok(Workshop { known: Known::default(), revision: snapshot.revision, ..last })
}

/// A separate database with the texts of a snapshot, for work that tries changes.
pub(crate) fn private_host(snapshot: &Snapshot) -> Cancellable<AnalysisHost> {
    let mut host = AnalysisHost::new(snapshot.vfs.clone());
    let mut files = Vec::new();
    for path in snapshot.open.keys() {
        let text = snapshot.analysis.text(path)?;
        files.push((path.clone(), text.map(|text| text.to_string())));
    }
    host.apply(Change {
        files,
        roots: Some(snapshot.roots.to_vec()),
        config: Some(snapshot.config.for_analysis()),
        ..Change::default()
    });
    Ok(host)
}

/// A project over a separate database, with the configuration around a file.
pub(crate) fn project<'a>(
    host: &'a mut AnalysisHost,
    snapshot: &Snapshot,
    texts: &'a Texts<'a>,
    file: &Utf8Path,
) -> Project<'a> {
    let files = snapshot.config.codels_of(file).cloned().unwrap_or_default();
    let stubs = StubOptions { use_parameters: true, ..StubOptions::default() };
    Project::new(host, texts, files, stubs).sharing(snapshot.codels.indexes.clone())
}
