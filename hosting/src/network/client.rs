//! Requests to runs on other machines.

use std::ops::ControlFlow;
use std::time::Duration;

use serde_json::{Value, json};
use zenoh::Wait as _;
use zenoh::bytes::Encoding;
use zenoh::query::ConsolidationMode;

use super::config;

/// Maximum time for the end of a service.
const REQUEST_TIMEOUT: Duration = Duration::from_hours(24);

/// Requests a service of a run that listens at one of the endpoints, or of one that is connected to a router
/// there. Calls `hear` with each reply until the service has ended, or `hear` breaks.
///
/// # Errors
/// A message: nothing listens there, no run provides the service, or the connection was lost.
pub fn request(
    endpoints: &[String],
    component: &str,
    service: &str,
    input: &Value,
    hear: &mut dyn FnMut(Value) -> ControlFlow<()>,
) -> Result<(), String> {
    let failed = |error: zenoh::Error| format!("cannot connect by Zenoh: {error}");
    let config = config("client", &[], endpoints).map_err(failed)?;
    let session = zenoh::open(config).wait().map_err(failed)?;
    let key = format!("{component}/{service}");
    let wrong = |error: zenoh::Error| format!("cannot request `{key}`: {error}");
    // Acceptance and end are replies of their own.
    let query = session.get(&key).consolidation(ConsolidationMode::None);
    let query = query.payload(input.to_string()).encoding(Encoding::APPLICATION_JSON);
    let replies = query.timeout(REQUEST_TIMEOUT).wait().map_err(wrong)?;
    let mut accepted = false;
    while let Ok(reply) = replies.recv() {
        let payload = match reply.result() {
            Ok(sample) => sample.payload(),
            Err(error) => error.payload(),
        };
        let bytes = payload.to_bytes();
        // Errors of Zenoh are text.
        let reply = serde_json::from_slice(&bytes).unwrap_or_else(
            |_| json!({"event": "error", "message": String::from_utf8_lossy(&bytes)}),
        );
        accepted |= reply["event"] == "accepted";
        let ends = reply["event"] != "accepted";
        if hear(reply).is_break() || ends {
            return Ok(());
        }
    }
    if accepted {
        Err("the run has ended before the service has, or its machine is gone".to_owned())
    } else {
        Err(format!("no run there provides `{component}.{service}`, or it has ended"))
    }
}
