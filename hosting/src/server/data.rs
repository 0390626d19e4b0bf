//! Values of ports and of inputs, as clients see them.

use dotgen_analysis::model::{Service, Spec};
use dotgen_codegen::codels::value::{Values, is_input};
use serde_json::{Map, Value, json};

use super::{Shared, State};
use dotgen_timing::system::ComponentId;

/// Returns the newest value of each instance of a port.
pub(super) fn newest(
    shared: &Shared,
    state: &State,
    component: ComponentId,
    port: u32,
) -> Map<String, Value> {
    let known = &shared.known[&component];
    let ty = known.component().ports[port as usize].data;
    let of = state.data.iter();
    let of = of.filter(|((c, p, _), _)| (*c, *p) == (component, port));
    let values = of.map(|((_, _, instance), bytes)| {
        let value = Values::new(&known.spec).decode(ty, bytes);
        (instance.clone(), value.unwrap_or(Value::Null))
    });
    values.collect()
}

/// Returns the message for inputs that are not an object, with an example of a valid object.
pub(super) fn not_an_object(spec: &Spec, service: &Service) -> String {
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
