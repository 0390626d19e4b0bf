//! Values of ports, as clients see them.

use dotgen_codegen::codels::value::Values;
use serde_json::{Map, Value};

use super::{Shared, State};
use dotgen_analysis::model::PortId;
use dotgen_timing::system::ComponentId;

/// Returns the newest value of each instance of a port.
pub(super) fn newest(
    shared: &Shared,
    state: &State,
    component: ComponentId,
    port: PortId,
) -> Map<String, Value> {
    let known = &shared.known[&component];
    let ty = known.component().ports[port].data;
    let of = state.data.iter();
    let of = of.filter(|((c, p, _), _)| (*c, *p) == (component, port));
    let values = of.map(|((_, _, instance), bytes)| {
        let value = Values::new(&known.spec).decode(ty, bytes);
        (instance.clone(), value.unwrap_or(Value::Null))
    });
    values.collect()
}
