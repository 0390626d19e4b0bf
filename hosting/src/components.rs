//! The components of a run, as clients see them.

use std::sync::Arc;

use dotgen_analysis::model::{self, Component, ComponentId, PortDir, Service, Spec, TypeKind};
use dotgen_codegen::codels::schema;
use dotgen_codegen::codels::value::{Values, is_input, is_output};
use dotgen_runtime::hosts::RequestReply;
use dotgen_timing::system::ServiceId;
use serde_json::{Map, Value, json};

/// The service that every component has in addition to its own.
pub(super) const CONNECT: &str = "connect_port";

/// A component that accepts requests.
#[derive(Clone)]
pub struct KnownComponent {
    /// The specification of the component.
    pub spec: Arc<Spec>,
    /// Index of the component in the specification.
    pub component: ComponentId,
    /// For each service of the component, its index in the system.
    pub services: Vec<Option<ServiceId>>,
    /// True if a host executes its codels.
    pub executed: bool,
}

impl KnownComponent {
    pub fn component(&self) -> &Component {
        &self.spec.components[self.component]
    }
}

/// The description of a component.
pub(super) fn describe(known: &KnownComponent) -> Value {
    let values = Values::new(&known.spec);
    let component = known.component();
    let services = component.services.iter().map(|service| {
        let inputs = service.params.iter().filter(|param| is_input(param));
        let inputs = inputs.map(|input| {
            let mut out = json!({
                "name": input.name.as_str(),
                "schema": schema::of_param(&known.spec, input),
            });
            if let Some(default) = values.default_of(input) {
                out["default"] = default;
            }
            out
        });
        let outputs = service.params.iter().filter(|param| is_output(param));
        json!({
            "name": service.name.as_str(),
            "kind": service.kind.word(),
            "doc": service.doc,
            "inputs": inputs.collect::<Vec<_>>(),
            "outputs": outputs.map(|output| output.name.as_str()).collect::<Vec<_>>(),
        })
    });
    let mut services: Vec<Value> = services.collect();
    if !component.services.iter().any(|service| service.name == CONNECT) {
        services.push(json!({
            "name": CONNECT,
            "kind": "function",
            "doc": "Connect two ports",
            "inputs": [
                {"name": "local", "schema": {"type": "string", "description": "Input port"}},
                {"name": "remote", "schema": {"type": "string", "description": "COMPONENT/PORT that it \
                    reads"}},
            ],
            "outputs": [],
        }));
    }
    let ports = component.ports.iter().map(|port| {
        json!({
            "name": port.name.as_str(),
            "direction": if port.dir == PortDir::In { "in" } else { "out" },
            "multiple": port.multiple,
            "schema": schema::of_type(&known.spec, port.data),
            "doc": port.doc,
        })
    });
    json!({
        "name": component.name.as_str(),
        "doc": component.doc,
        "executed": known.executed,
        "services": services,
        "ports": ports.collect::<Vec<_>>(),
    })
}

fn detail_of(spec: &Spec, exception: &str, bytes: &[u8]) -> Value {
    if exception == "::genom::syserr"
        && let Ok(code) = <[u8; 4]>::try_from(bytes)
    {
        return json!({"code": i32::from_ne_bytes(code)});
    }
    if exception == "::genom::unkex" {
        let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
        let what = String::from_utf8_lossy(bytes.get(..end).unwrap_or_default());
        return json!({"what": what});
    }
    let ids = spec.types.keys();
    let mut exceptions = ids.filter(|&ty| matches!(spec.ty(ty).kind, TypeKind::Exception { .. }));
    let found = exceptions.find(|&ty| spec.full_name(ty).as_deref() == Some(exception));
    let value = found.and_then(|exception| Values::new(spec).decode(exception, bytes).ok());
    match value {
        Some(Value::Object(object)) if object.is_empty() => Value::Null,
        exception => exception.unwrap_or(Value::Null),
    }
}

/// Returns the index in the system of a service, and its inputs as bytes, from those of a client.
///
/// # Errors
/// A message: the service cannot be requested in this run, or the inputs do not fit.
pub(super) fn inputs_of(
    known: &KnownComponent,
    index: model::ServiceId,
    input: Option<&Value>,
) -> Result<(ServiceId, Vec<u8>), String> {
    let service = &known.component().services[index];
    let path = format!("{}.{}", known.component().name, service.name);
    let Some(wanted) = known.services[usize::from(index)] else {
        return Err(format!("`{path}` cannot be requested in this run"));
    };
    let none = Map::new();
    let given = match input {
        None | Some(Value::Null) => &none,
        Some(Value::Object(object)) => object,
        Some(_) => return Err(not_an_object(&known.spec, service)),
    };
    let inputs = Values::new(&known.spec).inputs(service, given);
    let inputs = inputs.map_err(|error| format!("`{path}`: {error}"))?;
    Ok((wanted, inputs))
}

/// Returns the message for inputs that are not an object, with an example of a valid object.
fn not_an_object(spec: &Spec, service: &Service) -> String {
    let values = Values::new(spec);
    let inputs = service.params.iter().filter(|param| is_input(param));
    let example: Map<String, Value> = inputs
        .map(|input| {
            let default = values.default_of(input);
            (input.name.to_string(), default.unwrap_or_else(|| json!(0)))
        })
        .collect();
    let example = Value::Object(example);
    format!("the input is not an object; write the parameters by name, as in `{example}`")
}

/// Returns the reply to a client for an answer of the engine to a request of a service.
pub(super) fn reply_of(
    known: &KnownComponent,
    index: model::ServiceId,
    answer: &RequestReply,
) -> Value {
    match answer {
        RequestReply::Accepted => json!({"event": "accepted"}),
        RequestReply::Done(bytes) => {
            let service = &known.component().services[index];
            let output = Values::new(&known.spec).outputs(service, bytes);
            json!({"event": "done", "output": output.unwrap_or(Value::Null)})
        }
        RequestReply::Failed { exception, detail } => {
            let detail = detail_of(&known.spec, exception, detail);
            json!({"event": "failed", "exception": exception, "detail": detail})
        }
    }
}
