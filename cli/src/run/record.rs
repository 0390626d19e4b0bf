//! A recording of a run: its steps, and the data that its components write to their ports.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use dotgen_codegen::codels::schema;
use dotgen_codegen::codels::value::Values;
use dotgen_recording::record::{RunInfo, Writer};
use dotgen_recording::replay::Step;
use dotgen_runtime::simulation::Record;
use dotgen_runtime::watch::PortUpdate;
use dotgen_timing::explore::{Action, Stepper};
use dotgen_timing::scn::names::{Member, Names};
use dotgen_timing::system::{CodelId, ComponentId, TimedSystem};
use dotgen_timing::verify::Prepared;
use num_rational::Ratio;
use serde_json::{Value, json};

use dotgen_platform::files::disk::AppendedFile;
use typed_index_collections::{TiVec, ti_vec};

/// Maximum time until messages are in the file, even if their chunk is not full.
const FLUSH_INTERVAL: Duration = Duration::from_millis(500);

/// See the [module](self).
pub(super) struct Recording<'r, 's> {
    system: &'r TimedSystem,
    /// By component of the system.
    members: TiVec<ComponentId, Option<&'r Member<'s>>>,
    out: Writer<AppendedFile>,
    about: RunInfo,
    /// Nanoseconds since 1970 at the start of the run; 0 on the virtual clock.
    start: u64,
    /// Number of messages, without steps.
    pub(super) data: u64,
    pub(super) steps: u64,
    /// Start of the present chunk, if it has messages.
    begun: Option<Instant>,
    error: Option<anyhow::Error>,
}

impl<'r, 's> Recording<'r, 's> {
    /// Creates a recording of a run of a system, in a file. `executed`: the codels that are not simulated.
    pub(super) fn new(
        file: AppendedFile,
        prepared: &'r Prepared,
        names: &'r Names<'s>,
        scenario: String,
        real: bool,
        executed: &dyn Fn(CodelId) -> bool,
    ) -> anyhow::Result<Self> {
        let system = &prepared.built.system;
        let mut members = ti_vec![None; system.components.len()];
        for (&name, &component) in &prepared.built.components {
            members[component] = names.components.get(name);
        }
        let start = SystemTime::now().duration_since(UNIX_EPOCH);
        let start = start.map_or(0, |start| u64::try_from(start.as_nanos()).unwrap_or(0));
        let about = RunInfo {
            unit: system.unit.to_string(),
            clock: if real { "real" } else { "virtual" }.to_owned(),
            outside: real,
            simulated: (system.codels.iter_enumerated())
                .any(|(id, codel)| codel.site.is_some() && !executed(id)),
            end: 0,
            scenario,
        };
        Ok(Recording {
            out: Writer::new(file, &about)?,
            about,
            start: if real { start } else { 0 },
            data: 0,
            steps: 0,
            begun: None,
            error: None,
            members,
            system,
        })
    }

    /// Ends the file. Returns false if something could not be written, which was reported.
    pub(super) fn finish(self) -> anyhow::Result<bool> {
        match self.error {
            Some(error) => Err(error),
            None => Ok(self.out.finish(&self.about)?.finish()),
        }
    }

    /// Keeps the first error of a write.
    fn keep(&mut self, result: Result<(), impl Into<anyhow::Error>>) {
        self.error = self.error.take().or(result.err().map(Into::into));
    }

    fn at(&self, stepper: &Stepper) -> u64 {
        let nanos = self.system.unit * Ratio::from_integer(1_000_000_000);
        let nanos = nanos * Ratio::from_integer(i128::from(stepper.now()));
        self.start + u64::try_from(nanos.to_integer()).unwrap_or(u64::MAX / 2)
    }

    fn step(&mut self, at: u64, step: &Step) {
        self.steps += 1;
        self.begun.get_or_insert_with(Instant::now);
        let result = self.out.step(at, step);
        self.keep(result);
    }
}

impl Record for Recording<'_, '_> {
    fn on_action(&mut self, stepper: &Stepper, action: Action, executed: Option<u64>) {
        let at = self.at(stepper);
        self.step(at, &Step { executed, ..Step::new(self.system, stepper, action) });
    }

    fn interrupt(&mut self, stepper: &Stepper, place: usize) {
        let at = self.at(stepper);
        self.step(at, &Step::abort(self.system, stepper, place));
    }

    fn on_ending(&mut self, stepper: &Stepper) {
        let at = self.at(stepper);
        self.step(at, &Step::stop(stepper));
    }

    fn on_port_update(&mut self, stepper: &Stepper, written: &PortUpdate) {
        let Some(Some(member)) = self.members.get(written.component) else {
            return;
        };
        let component = &member.component;
        let Some(port) = component.ports.get(written.port) else {
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
        // Messages are objects. Another value becomes a member of an object, as in its schema.
        let value = match value {
            value @ Value::Object(_) => value,
            value => json!({"value": value}),
        };
        let at = self.at(stepper);
        let result = (self.out).data(at, &topic, value.to_string().as_bytes(), schema);
        self.data += 1;
        self.begun.get_or_insert_with(Instant::now);
        self.keep(result);
    }

    fn moment(&mut self) {
        if self.begun.is_some_and(|instant| instant.elapsed() >= FLUSH_INTERVAL) {
            self.begun = None;
            let result = self.out.flush();
            self.keep(result);
        }
    }

    fn end(&mut self, stepper: &Stepper) {
        self.about.end = stepper.now();
    }
}

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
