//! `textDocument/signatureHelp`

use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &SignatureHelpParams,
) -> Answer<Option<SignatureHelp>> {
    let position = params.text_document_position_params.position;
    let at = snapshot.at(subject, position)?;
    let help = snapshot.analysis.signature_help(&at)?.ok_or(Stop::Nothing)?;
    // Offsets of labels are in UTF-16 units, independent of the encoding of positions.
    let units = |byte: usize| help.label[..byte].encode_utf16().count() as u32;
    let parameters = help.parameters.iter().map(|parameter| ParameterInformation {
        label: if snapshot.client.label_offsets {
            ParameterLabel::LabelOffsets([units(parameter.start), units(parameter.end)])
        } else {
            ParameterLabel::Simple(help.label[parameter.clone()].to_owned())
        },
        documentation: None,
    });
    let active = help.active.map(|parameter| parameter as u32);
    Ok(Some(SignatureHelp {
        signatures: vec![SignatureInformation {
            parameters: Some(parameters.collect()),
            active_parameter: active,
            documentation: help.documentation.clone().map(Documentation::String),
            label: help.label.clone(),
        }],
        active_signature: Some(0),
        active_parameter: active,
    }))
}
