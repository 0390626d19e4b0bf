//! `textDocument/prepareCallHierarchy`, `callHierarchy/incomingCalls` and `outgoingCalls`

use camino::Utf8PathBuf;
use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide::{Call, CallItem, CallKey};
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::protocol::convert::{symbol, uri};
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};

/// The data of an item, which the client returns.
#[derive(Debug, Serialize, Deserialize)]
struct Data {
    /// The document of the first request: its unit answers.
    path: Utf8PathBuf,
    key: CallKey,
}

pub(crate) fn prepare(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &CallHierarchyPrepareParams,
) -> Answer<Option<Vec<CallHierarchyItem>>> {
    let position = params.text_document_position_params.position;
    let at = snapshot.at(subject, position)?;
    let items = snapshot.analysis.call_hierarchy(&at)?.ok_or(Stop::Nothing)?;
    let mut out = Vec::with_capacity(items.len());
    for call_item in items {
        out.extend(to_proto(snapshot, &subject.path, call_item)?);
    }
    Ok(Some(out))
}

pub(crate) fn incoming(
    snapshot: &Snapshot,
    params: &CallHierarchyIncomingCallsParams,
) -> Cancellable<Option<Vec<CallHierarchyIncomingCall>>> {
    let Some(data) = data(&params.item) else {
        return Ok(None);
    };
    let mut out = Vec::new();
    for call in snapshot.analysis.incoming_calls(&data.path, &data.key)? {
        // The mentions are in the file of the caller.
        let from_ranges = ranges(snapshot, &call.item.path, &call)?;
        if let Some(from) = to_proto(snapshot, &data.path, call.item)? {
            out.push(CallHierarchyIncomingCall { from, from_ranges });
        }
    }
    Ok(Some(out))
}

pub(crate) fn outgoing(
    snapshot: &Snapshot,
    params: &CallHierarchyOutgoingCallsParams,
) -> Cancellable<Option<Vec<CallHierarchyOutgoingCall>>> {
    let Some(data) = data(&params.item) else {
        return Ok(None);
    };
    let here = uri::to_path(&params.item.uri);
    let mut out = Vec::new();
    for call in snapshot.analysis.outgoing_calls(&data.path, &data.key)? {
        let from_ranges = ranges(snapshot, &here, &call)?;
        if let Some(to) = to_proto(snapshot, &data.path, call.item)? {
            out.push(CallHierarchyOutgoingCall { to, from_ranges });
        }
    }
    Ok(Some(out))
}

fn data(item: &CallHierarchyItem) -> Option<Data> {
    serde_json::from_value(item.data.clone()?).ok()
}

fn ranges(snapshot: &Snapshot, path: &camino::Utf8Path, call: &Call) -> Cancellable<Vec<Range>> {
    let lines = snapshot.lines(path)?;
    let convert = lines.iter().flat_map(|lines| {
        let ranges = call.ranges.iter();
        ranges.map(|range| lines.range(range))
    });
    Ok(convert.collect())
}

fn to_proto(
    snapshot: &Snapshot,
    asked: &camino::Utf8Path,
    call_item: CallItem,
) -> Cancellable<Option<CallHierarchyItem>> {
    let Some(location) = snapshot.location(&call_item.path, &call_item.range)? else {
        return Ok(None);
    };
    Ok(Some(CallHierarchyItem {
        name: call_item.name,
        kind: symbol::kind(call_item.kind),
        tags: None,
        detail: Some(call_item.detail),
        uri: location.uri,
        range: location.range,
        selection_range: location.range,
        data: Some(json!({ "path": asked, "key": call_item.key })),
    }))
}
