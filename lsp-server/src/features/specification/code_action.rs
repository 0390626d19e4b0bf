//! `textDocument/codeAction`: the fixes of diagnostics, and refactorings.

use dotgen_analysis::diagnostic::{Diagnostic, Fix, FixKind, Severity};
use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide::AssistKind;
use dotgen_codegen::codels::edit::Edit;

use crate::features::codels::judged_actions::{self, JudgedActions};
use crate::features::codels::{actions, standins};
use crate::features::convert::diagnostic;
use crate::features::convert::edit::{Review, edit_of, is_wanted, with_edit};
use crate::features::project_settings;
use crate::features::specification::search_paths;
use crate::protocol::convert::position::touches;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};

/// Kind of the action that generates files from a component.
pub(crate) const GENERATE: CodeActionKind = CodeActionKind::new("source.generate");

/// Kind of the action that applies a fix of every finding, including guesses and placeholders. It is not
/// below `source.fixAll`, which editors run on save without a question.
pub(crate) const FIX_FINDINGS: CodeActionKind = CodeActionKind::new("source.fixFindings");

/// Maximum number of errors at a place for which repairs are searched by trial.
const MAX_TRIED: usize = 3;

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &CodeActionParams,
) -> Answer<Option<CodeActionResponse>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let range = lines.clamped(params.range).ok_or(Stop::Nothing)?;
    let offers =
        |offers: &mut JudgedActions<'_, '_, '_>| offered(snapshot, subject, params, &range, offers);
    Ok(judged_actions::offers(snapshot, &subject.path, offers)?)
}

fn offered(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &CodeActionParams,
    range: &std::ops::Range<usize>,
    offers: &mut JudgedActions<'_, '_, '_>,
) -> Cancellable<Option<CodeActionResponse>> {
    let wanted = |kind: &CodeActionKind| is_wanted(params, kind);
    let mut actions = Vec::new();
    let codels = |kind: &CodeActionKind| actions::offered(params, kind);
    let mut all = crate::features::codels::unrefuted_findings(snapshot, &subject.path)?;
    all.extend(crate::features::codels::unused_in(snapshot, &subject.path)?);
    // Only on request: this action changes the whole file.
    let plain = "Fix all that has one plain repair";
    for (kind, title, guesses) in [
        (CodeActionKind::SOURCE_FIX_ALL, plain, false),
        (FIX_FINDINGS, "Fix all that has a fix", true),
    ] {
        let which = |fix: &Fix| guesses || fix.kind == FixKind::Plain;
        if params.context.only.is_some()
            && wanted(&kind)
            && let Some(fix_all) = fix_all(snapshot, title, all.iter(), which, offers)?
        {
            actions
                .push(CodeActionOrCommand::CodeAction(CodeAction { kind: Some(kind), ..fix_all }));
        }
    }
    for action in crate::features::verification::actions(snapshot, subject, range, offers)? {
        let kind = match &action {
            CodeActionOrCommand::CodeAction(code_action) => code_action.kind.as_ref(),
            CodeActionOrCommand::Command(_) => None,
        };
        if kind.is_none_or(wanted) {
            actions.push(action);
        }
    }
    actions::actions(snapshot, subject, range, &codels, offers, &mut actions)?;
    if !wanted(&CodeActionKind::QUICKFIX) {
        generate(snapshot, subject, range, params, &mut actions)?;
        refactorings(snapshot, subject, range, params, offers, &mut actions)?;
        return Ok(Some(actions));
    }
    search_paths::fixes(snapshot, subject, range, &mut actions)?;
    quick_fixes(snapshot, subject, &all, range, offers, &mut actions)?;
    refactorings(snapshot, subject, range, params, offers, &mut actions)?;
    generate(snapshot, subject, range, params, &mut actions)?;
    Ok(Some(actions))
}

/// Adds the fixes of the findings at a place, and those of all findings like them.
fn quick_fixes(
    snapshot: &Snapshot,
    subject: &Subject,
    all: &[Diagnostic],
    range: &std::ops::Range<usize>,
    offers: &mut JudgedActions<'_, '_, '_>,
    actions: &mut Vec<CodeActionOrCommand>,
) -> Cancellable<()> {
    let mut codes: Vec<&str> = Vec::new();
    let mut offered: Vec<&Fix> = Vec::new();
    // Findings at this place come first, then findings elsewhere that a fix at this place repairs.
    let (here, elsewhere): (Vec<_>, Vec<_>) =
        all.iter().partition(|finding| touches(&finding.range, range));
    let mut tried = 0;
    for diagnostic in here {
        let before = actions.len();
        for (rank, fix) in diagnostic.fixes.iter().enumerate() {
            actions.extend(quick_fix(snapshot, diagnostic, fix, rank == 0, offers)?);
            offered.push(fix);
        }
        if actions.len() == before && diagnostic.severity == Severity::Error && tried < MAX_TRIED {
            tried += 1;
            for fix in snapshot.analysis.trials(diagnostic, all)? {
                actions.extend(quick_fix(snapshot, diagnostic, &fix, false, offers)?);
            }
        }
        if !diagnostic.fixes.is_empty() && !codes.contains(&diagnostic.code) {
            codes.push(diagnostic.code);
        }
    }
    for diagnostic in elsewhere {
        for fix in &diagnostic.fixes {
            let mut edits = fix.edits.iter();
            let mends = edits.any(|edit| edit.path == subject.path && touches(&edit.range, range));
            if mends && !offered.contains(&fix) {
                actions.extend(quick_fix(snapshot, diagnostic, fix, false, offers)?);
                offered.push(fix);
            }
        }
    }
    actions.extend(standins::actions(snapshot, subject, all, range, offers)?);
    for diagnostic in all.iter().filter(|finding| touches(&finding.range, range)) {
        if let Some(fix) = snapshot.analysis.allowing(diagnostic)? {
            let action = without_edit(snapshot, diagnostic, &fix, false)?;
            let edit = edit_of(snapshot, Review::None, &Edit::of(&fix.edits))?;
            let action = with_edit(snapshot, action, edit);
            actions.extend(action.map(CodeActionOrCommand::CodeAction));
        }
        project_settings::allow(snapshot, subject, diagnostic, actions)?;
    }
    for code in codes {
        let alike =
            || all.iter().filter(|finding| finding.code == code && !finding.fixes.is_empty());
        if alike().count() > 1 {
            let title = format!("Fix all `{code}` in this file");
            let action = fix_all(snapshot, &title, alike(), |_| true, offers)?;
            actions.extend(action.map(CodeActionOrCommand::CodeAction));
        }
    }
    Ok(())
}

/// The action of a fix, if the judge accepts the edit.
fn quick_fix(
    snapshot: &Snapshot,
    diagnostic: &Diagnostic,
    fix: &Fix,
    first: bool,
    offers: &mut JudgedActions<'_, '_, '_>,
) -> Cancellable<Option<CodeActionOrCommand>> {
    let action = without_edit(snapshot, diagnostic, fix, first)?;
    offers.action(action, &Edit::of(&fix.edits), Some(diagnostic.code))
}

/// The action of a fix, without its edit.
pub(crate) fn without_edit(
    snapshot: &Snapshot,
    diagnostic: &Diagnostic,
    fix: &Fix,
    first: bool,
) -> Cancellable<CodeAction> {
    Ok(CodeAction {
        title: fix.title.clone(),
        kind: Some(CodeActionKind::QUICKFIX),
        diagnostics: diagnostic::to_proto(snapshot, diagnostic)?.map(|proto| vec![proto]),
        // Editors may apply a preferred fix without showing it.
        is_preferred: Some(first && fix.kind == FixKind::Plain),
        ..CodeAction::default()
    })
}

/// Refactorings of the selection, and on request the refactorings of the whole file.
fn refactorings(
    snapshot: &Snapshot,
    subject: &Subject,
    range: &std::ops::Range<usize>,
    params: &CodeActionParams,
    offers: &mut JudgedActions<'_, '_, '_>,
    actions: &mut Vec<CodeActionOrCommand>,
) -> Cancellable<()> {
    let only = params.context.only.as_deref();
    let wanted = |kind: &CodeActionKind| is_wanted(params, kind);
    let organize = CodeActionKind::SOURCE_ORGANIZE_IMPORTS;
    let mut assists = Vec::new();
    // Clients ask for fixes at every move of the cursor. Such requests do not compute refactorings.
    let asked =
        |action_kind: &CodeActionKind| action_kind.as_str().split('.').next() == Some("refactor");
    if only.is_none_or(|only| only.iter().any(asked) || only.contains(&CodeActionKind::EMPTY)) {
        assists = snapshot.analysis.assists(&subject.path, range.clone())?;
    }
    if only.is_some() && wanted(&organize) {
        assists.extend(snapshot.analysis.organize_includes(&subject.path)?);
    }
    for assist in assists {
        let kind = match assist.kind {
            AssistKind::Extract => CodeActionKind::REFACTOR_EXTRACT,
            AssistKind::Inline => CodeActionKind::REFACTOR_INLINE,
            AssistKind::Move => CodeActionKind::new("refactor.move"),
            AssistKind::Rewrite => CodeActionKind::REFACTOR_REWRITE,
            AssistKind::OrganizeIncludes => organize.clone(),
        };
        if wanted(&kind) {
            let action =
                CodeAction { title: assist.title, kind: Some(kind), ..CodeAction::default() };
            actions.extend(offers.action(action, &Edit::of(&assist.edits), None)?);
        }
    }
    Ok(())
}

/// "Generate…" and "Regenerate": at the name of a component, and anywhere on request. Editors show `source`
/// actions only on request. At a component the actions have no kind, so that editors show them.
fn generate(
    snapshot: &Snapshot,
    subject: &Subject,
    range: &std::ops::Range<usize>,
    params: &CodeActionParams,
    actions: &mut Vec<CodeActionOrCommand>,
) -> Cancellable<()> {
    let only = params.context.only.as_deref().unwrap_or_default();
    let asked = |action_kind: &CodeActionKind| GENERATE.as_str().starts_with(action_kind.as_str());
    let kind = if only.is_empty() || only.contains(&CodeActionKind::EMPTY) {
        let symbols = snapshot.analysis.document_symbols(&subject.path)?;
        let here = symbols.iter().any(|symbol| {
            symbol.kind == dotgen_analysis::ide::SymbolKind::Component
                && touches(&symbol.selection_range, range)
        });
        if !here {
            return Ok(());
        }
        CodeActionKind::EMPTY
    } else if only.iter().any(asked) {
        GENERATE
    } else {
        return Ok(());
    };
    let path = subject.path.as_str();
    let remembered = snapshot.config.generate.iter().any(|generate| generate.file == path);
    for (title, command) in crate::features::generation::actions(&subject.uri, remembered) {
        actions.push(CodeActionOrCommand::CodeAction(CodeAction {
            title,
            kind: Some(kind.clone()),
            command: Some(command),
            ..CodeAction::default()
        }));
    }
    Ok(())
}

/// One action that applies the first fix of each diagnostic, if the fixes do not conflict and none changes
/// the behaviour of the program.
fn fix_all<'d>(
    snapshot: &Snapshot,
    title: &str,
    of: impl Iterator<Item = &'d Diagnostic>,
    which: impl Fn(&Fix) -> bool,
    offers: &mut JudgedActions<'_, '_, '_>,
) -> Cancellable<Option<CodeAction>> {
    let first = of.filter_map(|diagnostic| Some((diagnostic.fixes.first()?, diagnostic.code)));
    let chosen = first.filter(|(fix, _)| fix.kind != FixKind::Choice && which(fix));
    let edits = chosen.map(|(fix, code)| (Edit::of(&fix.edits), code));
    let edit = offers.together(&edits.collect::<Vec<_>>())?;
    if edit.is_empty() {
        return Ok(None);
    }
    let action = CodeAction {
        title: title.to_owned(),
        kind: Some(CodeActionKind::QUICKFIX),
        ..CodeAction::default()
    };
    let edit = edit_of(snapshot, Review::SeveralFiles(title), &edit)?;
    Ok(with_edit(snapshot, action, edit))
}
