//! Recordings of whole runs, as files in the [MCAP](https://mcap.dev) format.
//!
//! Each output port is a channel of JSON messages with the JSON Schema of its type, so
//! [Foxglove](https://foxglove.dev) opens the file. One more channel, [`STEPS`], contains the steps of the
//! run, for a [replay](crate::replay). The metadata [`RUN`] describes the run: at the beginning of the file,
//! and once more at its end, with the time at which the run ended. A recording without its end is read as far
//! as it goes.

mod records;

use std::collections::BTreeMap;
use std::io::Write;
use std::ops::ControlFlow;

use mcap::records::{MessageHeader, Metadata, Record};
use mcap::write::NoSeek;
use mcap::{McapError, McapResult, WriteOptions};
use rustc_hash::FxHashMap;
use serde_json::json;

use crate::replay::Step;

/// The channel of the steps.
pub const STEPS: &str = "/dotgen/steps";

/// The name of the metadata.
pub const RUN: &str = "dotgen.run";

/// Approximate number of bytes of a chunk of messages.
const CHUNK: u64 = 256 << 10;

/// The description of a run.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RunInfo {
    pub scenario: String,
    /// Unit of time in seconds, as a fraction: `1/1000000`.
    pub unit: String,
    /// `real` or `virtual`.
    pub clock: String,
    /// Some clients stand for requests from outside.
    pub outside: bool,
    /// Some codels were simulated: the recording says nothing about the program.
    pub simulated: bool,
    /// End of the run, in units.
    pub end: u64,
}

impl RunInfo {
    /// Returns the metadata, with the end of the run if it is known.
    fn metadata(&self, ended: bool) -> Metadata {
        let text = |text: &str| text.to_owned();
        let mut metadata = BTreeMap::from([
            (text("scenario"), self.scenario.clone()),
            (text("unit"), self.unit.clone()),
            (text("clock"), self.clock.clone()),
            (text("outside"), self.outside.to_string()),
            (text("simulated"), self.simulated.to_string()),
        ]);
        if ended {
            metadata.insert(text("end"), self.end.to_string());
        }
        Metadata { name: RUN.to_owned(), metadata }
    }
}

/// Writes a recording.
pub struct Writer<W: Write> {
    out: mcap::Writer<NoSeek<W>>,
    steps: u16,
    ports: FxHashMap<String, (u16, u32)>,
    count: u32,
}

impl<W: Write> Writer<W> {
    /// Begins a recording. The end of the run is not known yet.
    ///
    /// # Errors
    ///
    /// Returns an error if the recording cannot be written.
    pub fn new(out: W, about: &RunInfo) -> McapResult<Self> {
        let options = WriteOptions::new()
            .compression(None)
            .chunk_size(Some(CHUNK))
            .disable_seeking(true)
            .library(concat!("dotgen ", env!("CARGO_PKG_VERSION")));
        let mut out = mcap::Writer::with_options(NoSeek::new(out), options)?;
        out.write_metadata(&about.metadata(false))?;
        let text = json!({"type": "string"});
        let schema = json!({
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": "dotgen.Step",
            "type": "object",
            "properties": {
                "time": {"type": "integer", "minimum": 0},
                "rule": text,
                "of": text,
                "what": text,
                "to": text,
            },
            "required": ["time", "rule", "of"],
        });
        let schema = out.add_schema("dotgen.Step", "jsonschema", schema.to_string().as_bytes())?;
        let steps = out.add_channel(schema, STEPS, "json", &BTreeMap::new())?;
        Ok(Writer { ports: FxHashMap::default(), count: 0, steps, out })
    }

    /// Writes a step, at a time in nanoseconds.
    ///
    /// # Errors
    ///
    /// Returns an error if the recording cannot be written.
    pub fn step(&mut self, at: u64, step: &Step) -> McapResult<()> {
        let bytes = serde_json::to_vec(step).map_err(|error| McapError::Io(error.into()))?;
        self.count += 1;
        self.write(self.steps, self.count, at, &bytes)
    }

    /// Writes new data of a port. `schema` returns the name and JSON Schema of its type, and is called once
    /// per port.
    ///
    /// # Errors
    ///
    /// Returns an error if the recording cannot be written.
    pub fn data(
        &mut self,
        at: u64,
        topic: &str,
        value: &[u8],
        schema: impl FnOnce() -> (String, Vec<u8>),
    ) -> McapResult<()> {
        let (channel, count) = if let Some((channel, count)) = self.ports.get_mut(topic) {
            *count = count.wrapping_add(1);
            (*channel, *count)
        } else {
            let (name, schema) = schema();
            let schema = self.out.add_schema(&name, "jsonschema", &schema)?;
            let none = BTreeMap::new();
            let channel = self.out.add_channel(schema, topic, "json", &none)?;
            self.ports.insert(topic.to_owned(), (channel, 1));
            (channel, 1)
        };
        self.write(channel, count, at, value)
    }

    fn write(&mut self, channel_id: u16, sequence: u32, at: u64, data: &[u8]) -> McapResult<()> {
        let header = MessageHeader { channel_id, sequence, log_time: at, publish_time: at };
        self.out.write_to_known_channel(&header, data)
    }

    /// Ends the present chunk: all messages so far are in the output.
    ///
    /// # Errors
    ///
    /// Returns an error if the recording cannot be written.
    pub fn flush(&mut self) -> McapResult<()> {
        self.out.flush()
    }

    /// Ends the recording.
    ///
    /// # Errors
    ///
    /// Returns an error if the recording cannot be written.
    pub fn finish(mut self, about: &RunInfo) -> McapResult<W> {
        self.out.write_metadata(&about.metadata(true))?;
        self.out.finish()?;
        Ok(self.out.into_inner().into_inner())
    }
}

/// The end of a recording before its run has ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Break {
    /// The reason.
    pub why: String,
    /// The place of damage, in bytes from the beginning of the file; `None` if the file is only cut.
    pub damaged: Option<usize>,
}

impl std::fmt::Display for Break {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.damaged {
            Some(at) => write!(f, "damaged at byte {at}: {}", self.why),
            None => f.write_str(&self.why),
        }
    }
}

/// The contents of a recording, except the data of ports.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Recording {
    /// Description of the run.
    pub about: RunInfo,
    pub steps: Vec<Step>,
    /// Number of messages of ports.
    pub data: u64,
    /// The reason why the recording breaks off; `None` if it is whole.
    pub broken: Option<Break>,
}

/// Reads a recording. If it breaks off, because its run was killed or had no room for more, or if it is
/// damaged, everything before is read, and the run ends with its last step. A chunk with a wrong checksum is
/// not read.
///
/// # Errors
///
/// Returns a message if the bytes are not a recording, or do not describe a run.
pub fn read(bytes: &[u8]) -> Result<Recording, String> {
    let mut out = Recording::default();
    let mut steps = None;
    let mut about: BTreeMap<String, String> = BTreeMap::new();
    let broken = records::each(bytes, &mut |record| {
        match record {
            Record::Channel(channel) if channel.topic == STEPS => steps = Some(channel.id),
            Record::Metadata(metadata) if metadata.name == RUN => about.extend(metadata.metadata),
            Record::Message { header, data } if steps == Some(header.channel_id) => {
                let number = out.steps.len() + 1;
                // Steps are numbered, so that a chunk that is skipped is noticed.
                if usize::try_from(header.sequence) != Ok(number) {
                    return ControlFlow::Break(format!("step {number} is missing"));
                }
                match serde_json::from_slice(&data) {
                    Ok(step) => out.steps.push(step),
                    Err(error) => {
                        return ControlFlow::Break(format!("step {number} is none: {error}"));
                    }
                }
            }
            Record::Message { .. } => out.data += 1,
            _ => {}
        }
        ControlFlow::Continue(())
    })?;
    out.broken = broken;
    if about.is_empty() {
        return Err(match out.broken {
            Some(Break { why, damaged: Some(at) }) => format!("it is damaged at byte {at}: {why}"),
            Some(broken) => format!("it breaks off before the first step of a run: {broken}"),
            None => "it has no steps of a run: `dotgen run --record` writes them".to_owned(),
        });
    }
    let text = |key: &str| about.get(key).cloned().unwrap_or_default();
    let last = out.steps.last().map_or(0, |step| step.time);
    out.about = RunInfo {
        scenario: text("scenario"),
        unit: text("unit"),
        clock: text("clock"),
        outside: text("outside") == "true",
        simulated: text("simulated") != "false",
        end: text("end").parse().unwrap_or(last),
    };
    Ok(out)
}

/// The data of ports of a recording.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PortRecording {
    /// Topics by channel: `/pump/level`, with a third word for the instance of a `multiple` port.
    pub topics: BTreeMap<u16, String>,
    /// Messages in the order of the file.
    pub messages: Vec<Message>,
    /// The reason why the recording breaks off; `None` if it is whole.
    pub broken: Option<Break>,
}

/// New data of a port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Channel, of [`PortRecording::topics`].
    pub channel: u16,
    /// Time in nanoseconds.
    pub at: u64,
    /// Number of the last step before.
    pub after: u32,
    /// Value as JSON. A value that is not an object is the member `value` of one.
    pub text: Vec<u8>,
}

/// Reads the data of ports. If the recording breaks off, everything before is read.
///
/// # Errors
///
/// Returns a message if the bytes are not a recording.
pub fn read_data(bytes: &[u8]) -> Result<PortRecording, String> {
    let mut out = PortRecording::default();
    let (mut steps, mut after) = (None, 0);
    out.broken = records::each(bytes, &mut |record| {
        match record {
            Record::Channel(channel) if channel.topic == STEPS => steps = Some(channel.id),
            Record::Channel(channel) => {
                out.topics.insert(channel.id, channel.topic);
            }
            Record::Message { header, .. } if steps == Some(header.channel_id) => {
                after = header.sequence;
            }
            Record::Message { header, data } if out.topics.contains_key(&header.channel_id) => {
                out.messages.push(Message {
                    channel: header.channel_id,
                    at: header.log_time,
                    after,
                    text: data.into_owned(),
                });
            }
            _ => {}
        }
        ControlFlow::Continue(())
    })?;
    Ok(out)
}

#[cfg(test)]
mod tests;
