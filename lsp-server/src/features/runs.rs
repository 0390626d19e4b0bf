//! Lenses that run a component or a scenario. The client runs it.

use std::ops::Range;

use camino::Utf8Path;
use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide::SymbolKind;
use dotgen_timing::scn;
use serde_json::json;

use crate::features::commands::{RUN, SIMULATE};
use crate::protocol::types::{CodeLens, CodeLensParams, Command};
use crate::workspace::snapshot::{Answer, Snapshot, Subject};

/// `Simulate` and `Run` over every component, at the place of its name. Empty for clients that do not run
/// components.
pub(crate) fn lenses(
    snapshot: &Snapshot,
    subject: &Subject,
) -> Cancellable<Vec<(usize, CodeLens)>> {
    if !offered(snapshot) {
        return Ok(Vec::new());
    }
    let mut names: Vec<Range<usize>> = Vec::new();
    let mut open = snapshot.analysis.document_symbols(&subject.path)?;
    // Components may be in modules.
    while let Some(symbol) = open.pop() {
        match symbol.kind {
            SymbolKind::Component => names.push(symbol.selection_range),
            SymbolKind::Module => open.extend(symbol.children),
            _ => {}
        }
    }
    names.sort_by_key(|name| name.start);
    over(snapshot, subject, names)
}

/// The lenses of a scenario: first the ones that run it, then the verdicts.
pub(crate) fn scenario_lenses(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &CodeLensParams,
) -> Answer<Option<Vec<CodeLens>>> {
    let verdicts = super::verification::scenario_lenses(snapshot, subject, params)?;
    if !offered(snapshot) {
        return Ok(verdicts);
    }
    let names = name_of(snapshot, &subject.path)?.into_iter().collect();
    let runs = over(snapshot, subject, names)?;
    let runs = runs.into_iter().map(|run| run.1);
    Ok(Some(verdicts.into_iter().flatten().chain(runs).collect()))
}

fn offered(snapshot: &Snapshot) -> bool {
    snapshot.client.runs && snapshot.config.run_lenses
}

/// The place of a scenario's name, if it has one.
fn name_of(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Option<Range<usize>>> {
    let Some(text) = snapshot.analysis.text(path)? else {
        return Ok(None);
    };
    let name = scn::parse(&text).scenario.name_range;
    Ok((!name.is_empty()).then_some(name))
}

fn over(
    snapshot: &Snapshot,
    subject: &Subject,
    names: Vec<Range<usize>>,
) -> Cancellable<Vec<(usize, CodeLens)>> {
    let Some(lines) = snapshot.lines(&subject.path)? else {
        return Ok(Vec::new());
    };
    let lens = |range: &Range<usize>, title: &str, command: &str| CodeLens {
        range: lines.range(range),
        command: Some(Command::new(
            title.to_owned(),
            command.to_owned(),
            Some(vec![json!({ "uri": subject.uri })]),
        )),
        data: None,
    };
    Ok(names
        .iter()
        .flat_map(|name| {
            let both = [("Simulate", SIMULATE), ("Run", RUN)];
            both.map(|(title, command)| (name.start, lens(name, title, command)))
        })
        .collect())
}
