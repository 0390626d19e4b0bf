//! `textDocument/codeLens` and `codeLens/resolve`

use camino::Utf8PathBuf;
use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide::LensKind;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::features::commands::{SHOW_DIAGRAM, SHOW_REFERENCES};
use crate::features::{runs, verification};
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Subject};

/// The data of a lens that is resolved later.
#[derive(Debug, Serialize, Deserialize)]
struct Data {
    path: Utf8PathBuf,
    lens: LensKind,
    /// Version of the document of the lens.
    version: Option<i32>,
}

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &CodeLensParams,
) -> Answer<Option<Vec<CodeLens>>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let config = &snapshot.config.code_lens;
    let verdicts =
        if config.verdicts { verification::lenses(snapshot, subject)? } else { Vec::new() };
    let lenses = snapshot.analysis.code_lenses(&subject.path, config)?;
    let convert = lenses.into_iter().map(|lens| CodeLens {
        range: lines.range(&lens.range),
        command: None,
        data: Some(json!({
            "path": subject.path,
            "lens": lens.kind,
            "version": subject.version,
        })),
    });
    let ready = runs::lenses(snapshot, subject)?.into_iter().chain(verdicts);
    Ok(Some(ready.map(|lens| lens.1).chain(convert).collect()))
}

/// Adds the title and command to a lens.
pub(crate) fn resolve(snapshot: &Snapshot, lens: &CodeLens) -> Cancellable<Option<CodeLens>> {
    let data = lens.data.clone().map(serde_json::from_value::<Data>);
    let Some(Ok(data)) = data else {
        return Ok(None);
    };
    // Offsets of another version are invalid; the client asks again after a change.
    let version = snapshot.open.get(&data.path).map(|file| file.version);
    let text = if version == data.version {
        snapshot.analysis.resolve_lens(&data.path, &data.lens)?
    } else {
        None
    };
    let uri = snapshot.uri(&data.path);
    let (Some(text), Some(uri)) = (text, uri) else {
        return Ok(Some(CodeLens {
            command: Some(Command::new(String::new(), String::new(), None)),
            ..lens.clone()
        }));
    };
    let (command, argument) = match &data.lens {
        LensKind::StateMachine { component, owner } => {
            (SHOW_DIAGRAM, json!({ "uri": uri, "component": component, "owner": owner }))
        }
        LensKind::Accesses { .. } if !text.references.is_empty() => {
            let mut locations = Vec::with_capacity(text.references.len());
            for reference in &text.references {
                locations.extend(snapshot.location(&reference.path, &reference.range)?);
            }
            let position = lens.range.start;
            let argument = json!({
                "uri": uri,
                "position": position,
                "locations": locations,
                "tooltip": text.details,
            });
            (SHOW_REFERENCES, argument)
        }
        LensKind::Accesses { .. } => ("", json!(null)),
    };
    let arguments = (!command.is_empty()).then(|| vec![argument]);
    Ok(Some(CodeLens {
        command: Some(Command::new(text.title, command.to_owned(), arguments)),
        ..lens.clone()
    }))
}
