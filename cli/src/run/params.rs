//! `dotgen run --params`: attributes that are set at the start of a run.

use std::path::PathBuf;

use anyhow::{Context, bail, ensure};
use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::model::ServiceKind;
use dotgen_codegen::codels::value::Values;
use dotgen_timing::scn::names::Names;
use serde_json::{Map, Value, json};

use crate::call::RunConnection;
use crate::report;

/// The attributes to set, in the order of the file.
pub(super) struct Params(Vec<Param>);

struct Param {
    /// `component.attribute`
    path: String,
    /// Values by name of the input.
    input: Map<String, Value>,
}

impl Params {
    /// Reads a file: a JSON object with the values of the inputs, by component, attribute and input.
    ///
    /// # Errors
    /// The file cannot be read, or it names something that is not an attribute of the run, or a value has
    /// another type.
    pub(super) fn read(path: &Utf8Path, names: &Names<'_>) -> anyhow::Result<Params> {
        let text = std::fs::read_to_string(path);
        let text = text.with_context(|| format!("cannot read `{path}`"))?;
        let all: Map<String, Value> = serde_json::from_str(&text).with_context(|| {
            format!("`{path}` is not a JSON object, such as {{\"pump\": {{\"set_limit\": {{\"limit\": 2}}}}}}")
        })?;
        let mut out = Vec::new();
        for (component, attributes) in all {
            let mut members = names.components.iter();
            let Some(member) = members.find(|member| member.component.name == component) else {
                bail!("`{path}`: `{component}` is not a component of this run");
            };
            let Value::Object(attributes) = attributes else {
                bail!("`{path}`: `{component}` is not an object with attributes");
            };
            for (attribute, input) in attributes {
                let own = format!("{component}.{attribute}");
                let mut services = member.component.services.iter();
                let Some(service) = services.find(|service| service.name == attribute) else {
                    bail!("`{path}`: `{component}` has no attribute `{attribute}`");
                };
                ensure!(
                    service.kind == ServiceKind::Attribute,
                    "`{path}`: `{own}` is not an attribute; a client of a scenario can request it"
                );
                let Value::Object(input) = input else {
                    bail!("`{path}`: `{own}` is not an object with the values of its inputs");
                };
                let encoded = Values::new(member.spec).inputs(service, &input);
                encoded.map_err(|error| anyhow::anyhow!("`{path}`: `{own}`: {error}"))?;
                out.push(Param { path: own, input });
            }
        }
        Ok(Params(out))
    }

    /// Sets the attributes by requests to the run behind a socket, one after the other. What is refused is a
    /// note.
    pub(super) fn set_at(self, socket: PathBuf) {
        std::thread::spawn(move || {
            if let Err(error) = self.set(&socket) {
                report::note(&format!("`--params`: {error}"));
            }
        });
    }

    fn set(&self, socket: &std::path::Path) -> anyhow::Result<()> {
        let socket = Utf8PathBuf::try_from(socket.to_owned())?;
        let mut run = RunConnection::begin(Some(&socket))?;
        for (id, Param { path, input }) in self.0.iter().enumerate() {
            run.say(&json!({"id": id, "call": path, "input": input}))?;
            let why = loop {
                let message = match run.hear() {
                    Ok(message) => message.context("the run has ended before all are set")?,
                    Err(refused) => break Some(refused.to_string()),
                };
                match message["event"].as_str() {
                    Some("done") => break None,
                    Some("failed") => {
                        let exception = message["exception"].as_str().unwrap_or("an exception");
                        break Some(match &message["detail"] {
                            Value::Null => exception.to_owned(),
                            detail => format!("{exception} {detail}"),
                        });
                    }
                    _ => {}
                }
            };
            if let Some(why) = why {
                report::note(&format!("`--params`: `{path}` is not set: {why}"));
            }
        }
        Ok(())
    }
}
