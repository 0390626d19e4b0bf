//! A run as a recording: its steps, and what its components write to their ports.

use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::Context;
use camino::Utf8Path;
use dotgen_codegen::codels::schema;
use dotgen_codegen::codels::value::Values;
use dotgen_recording::record::{About, Writer};
use dotgen_recording::replay::Step;
use dotgen_runtime::simulation::Record;
use dotgen_runtime::watch::Published;
use dotgen_timing::explore::{Action, Stepper};
use dotgen_timing::scn::names::{Member, Names};
use dotgen_timing::system::TimedSystem;
use dotgen_timing::verify::Prepared;
use num_rational::Ratio;
use serde_json::{Value, json};

use crate::files::disk::Stream;

/// See the [module](self).
pub(super) struct Recording<'r, 's> {
    path: &'r Utf8Path,
    system: &'r TimedSystem,
    /// By component of the system.
    members: Vec<Option<&'r Member<'s>>>,
    out: Writer<Stream>,
    about: About,
    /// Nanoseconds since 1970 at which the run begins; 0 on the virtual clock.
    start: u64,
    /// Messages, steps apart.
    pub(super) data: u64,
    pub(super) steps: u64,
    error: Option<anyhow::Error>,
}

impl<'r, 's> Recording<'r, 's> {
    /// For a run of a system, to a file.
    pub(super) fn new(
        path: &'r Utf8Path,
        prepared: &'r Prepared,
        names: &'r Names<'s>,
        scenario: String,
        real: bool,
    ) -> anyhow::Result<Self> {
        let wrong = || format!("cannot write `{path}`");
        let stream = Stream::create(path.as_std_path()).with_context(wrong)?;
        let system = &prepared.built.system;
        let mut members = vec![None; system.components.len()];
        for (&name, &component) in &prepared.built.components {
            members[component] = names.components.get(name);
        }
        let start = SystemTime::now().duration_since(UNIX_EPOCH);
        let start = start.map_or(0, |it| u64::try_from(it.as_nanos()).unwrap_or(0));
        Ok(Recording {
            out: Writer::new(stream).with_context(wrong)?,
            about: About {
                unit: system.unit.to_string(),
                clock: if real { "real" } else { "virtual" }.to_owned(),
                outside: real,
                end: 0,
                scenario,
            },
            start: if real { start } else { 0 },
            data: 0,
            steps: 0,
            error: None,
            members,
            path,
            system,
        })
    }

    /// Gives the file its name.
    pub(super) fn finish(self) -> anyhow::Result<()> {
        let wrong = || format!("cannot write `{}`", self.path);
        if let Some(error) = self.error {
            return Err(error).with_context(wrong);
        }
        let stream = self.out.finish(&self.about).with_context(wrong)?;
        stream.finish().with_context(wrong)
    }

    fn at(&self, stepper: &Stepper) -> u64 {
        let nanos = self.system.unit * Ratio::from_integer(1_000_000_000);
        let nanos = nanos * Ratio::from_integer(i128::from(stepper.now()));
        self.start + u64::try_from(nanos.to_integer()).unwrap_or(u64::MAX / 2)
    }

    fn step(&mut self, at: u64, step: &Step) {
        self.steps += 1;
        let result = self.out.step(at, step);
        self.error = self.error.take().or(result.err().map(Into::into));
    }
}

impl Record for Recording<'_, '_> {
    fn act(&mut self, stepper: &Stepper, action: Action) {
        let at = self.at(stepper);
        self.step(at, &Step::new(self.system, stepper, action));
    }

    fn interrupt(&mut self, stepper: &Stepper, place: usize) {
        let at = self.at(stepper);
        self.step(at, &Step::abort(self.system, stepper, place));
    }

    fn wrote(&mut self, stepper: &Stepper, written: &Published) {
        let Some(Some(member)) = self.members.get(written.component) else {
            return;
        };
        let component = &member.component;
        let Some(port) = component.ports.get(written.port as usize) else {
            return;
        };
        let Ok(value) = Values::new(member.spec).decode(port.data, &written.data) else {
            return;
        };
        let schema = || {
            let name = member.spec.full_name(port.data);
            let name = name.unwrap_or_else(|| format!("::{}::{}", component.name, port.name));
            let name = name.trim_start_matches("::").replace("::", ".");
            let schema = message(schema::of_type(member.spec, port.data));
            (name, schema.to_string().into_bytes())
        };
        let mut topic = format!("/{}/{}", component.name, port.name);
        if !written.id.is_empty() {
            topic = format!("{topic}/{}", written.id);
        }
        // Messages are objects: what is none is wrapped, as its schema is.
        let value = match value {
            it @ Value::Object(_) => it,
            it => json!({"value": it}),
        };
        let at = self.at(stepper);
        let result = (self.out).data(at, &topic, value.to_string().as_bytes(), schema);
        self.data += 1;
        self.error = self.error.take().or(result.err().map(Into::into));
    }

    fn end(&mut self, stepper: &Stepper) {
        self.about.end = stepper.now();
    }
}

/// The schema of messages with values of a schema.
fn message(mut schema: Value) -> Value {
    if schema["type"] != "object" {
        schema = json!({
            "type": "object",
            "properties": {"value": schema},
            "required": ["value"],
        });
    }
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
    schema
}
