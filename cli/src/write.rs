//! `dotgen write`: writes values to an input port of a run.

use std::io::BufRead as _;
use std::time::{Duration, Instant};

use anyhow::Context;
use camino::Utf8PathBuf;
use clap::Args;
use serde_json::{Value, json};

use super::call::RunConnection;
use super::{CommandExit, failure, report};

/// Write a value to an input port of a component that runs (`dotgen run --clock real`)
///
/// No output port of the run may be connected to the input port. Each value is acknowledged by the run before
/// the next one is sent. Codels that read the port get the newest value.
///
/// Exit status: 0 if all values were written, 1 if lines of standard input were refused, 2 if the value could
/// not be written.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Input port to write, as COMPONENT/PORT
    port: String,

    /// Value, as JSON; `-` reads values from standard input, one per line, and writes each as it comes
    #[arg(value_name = "JSON", allow_negative_numbers = true)]
    value: String,

    /// Write HZ values per second: the same value until Ctrl-C, or the lines
    #[arg(long, value_name = "HZ", value_parser = rate)]
    rate: Option<f64>,

    /// Instance to write, if the port is `multiple`
    #[arg(long, value_name = "NAME")]
    instance: Option<String>,

    /// Socket of the run [default: the only run on this machine]
    #[arg(long, value_name = "PATH")]
    socket: Option<Utf8PathBuf>,
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if (1e-6..=1e6).contains(&number) => Ok(number),
        _ => Err("write a number of values per second, for example 50".to_owned()),
    }
}

/// Waits for the moments at which values are due.
#[derive(Debug)]
pub(super) struct Pacer {
    begin: Instant,
    latest: Duration,
}

/// Minimum delay that is reported.
const REPORTED_DELAY: Duration = Duration::from_millis(100);

impl Pacer {
    pub(super) fn begin() -> Pacer {
        Pacer { begin: Instant::now(), latest: Duration::ZERO }
    }

    /// Waits until a time after the beginning.
    pub(super) fn wait(&mut self, until: Duration) {
        let now = self.begin.elapsed();
        match until.checked_sub(now) {
            Some(left) => std::thread::sleep(left),
            None => self.latest = self.latest.max(now.saturating_sub(until)),
        }
    }

    /// Reports values that were written late.
    pub(super) fn end(&self) {
        if self.latest > REPORTED_DELAY {
            let millis = self.latest.as_millis();
            report::note(&format!("values were written up to {millis} ms late"));
        }
    }
}

/// An input port of a run.
pub(super) struct Input<'t> {
    pub(super) talk: &'t mut RunConnection,
    pub(super) port: String,
    pub(super) instance: Option<String>,
}

impl Input<'_> {
    /// Writes a value. Returns false if the run has ended. A value that does not fit is an error.
    pub(super) fn write(&mut self, value: &Value) -> anyhow::Result<bool> {
        let mut request = json!({"id": 1, "write": self.port, "value": value});
        if let Some(instance) = &self.instance {
            request["instance"] = instance.as_str().into();
        }
        if self.talk.say(&request).is_err() {
            return Ok(false);
        }
        while let Some(answer) = self.talk.hear()? {
            if answer["event"] == "written" {
                return Ok(true);
            }
            if answer["event"] == "lost" {
                return Ok(false);
            }
        }
        Ok(false)
    }
}

/// Returns the error for values that were not written, because the run has ended.
fn ended(which: &str) -> anyhow::Error {
    anyhow::anyhow!("the run has ended: {which} was not written")
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let value = match arguments.value.as_str() {
        "-" => None,
        text => Some(parse(text)?),
    };
    let mut talk = RunConnection::begin(arguments.socket.as_ref())?;
    let (port, instance) = (arguments.port.clone(), arguments.instance.clone());
    let mut input = Input { talk: &mut talk, port, instance };
    match value {
        Some(value) => write_value(arguments, &mut input, &value),
        None => write_lines(arguments, &mut input),
    }
}

fn parse(text: &str) -> anyhow::Result<Value> {
    serde_json::from_str(text)
        .context("the value is not valid JSON: write for example 2, '{\"x\": 1.5}' or '\"a text\"'")
}

fn write_value(
    arguments: &Arguments,
    input: &mut Input<'_>,
    value: &Value,
) -> anyhow::Result<CommandExit> {
    if !input.write(value)? {
        return Err(ended("the value"));
    }
    let Some(rate) = arguments.rate else {
        return Ok(CommandExit::Fine);
    };
    let period = Duration::from_secs_f64(1.0 / rate);
    loop {
        // The value stays the same: missed writes are not repeated.
        std::thread::sleep(period);
        if !input.write(value)? {
            return Ok(CommandExit::Fine);
        }
    }
}

fn write_lines(arguments: &Arguments, input: &mut Input<'_>) -> anyhow::Result<CommandExit> {
    let period = arguments.rate.map(|rate| 1.0 / rate);
    let mut outcome = CommandExit::Fine;
    let mut pace = Pacer::begin();
    let mut count = 0.0;
    for (number, line) in (1u64..).zip(std::io::stdin().lock().lines()) {
        let line = line.context("cannot read standard input")?;
        if line.trim().is_empty() {
            continue;
        }
        if let Some(period) = period {
            pace.wait(Duration::from_secs_f64(count * period));
            count += 1.0;
        }
        match parse(&line).and_then(|value| input.write(&value)) {
            Ok(true) => {}
            Ok(false) => return Err(ended(&format!("line {number}"))),
            Err(error) => {
                failure(&error.context(format!("line {number} was not written")));
                outcome = CommandExit::Errors;
            }
        }
    }
    Ok(outcome)
}
