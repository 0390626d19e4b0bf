//! `dotgen call` and `dotgen watch`: requests to a run, and values of its ports.

use std::io::{BufRead as _, BufReader, Write as _};

use anyhow::{Context, bail};
use camino::Utf8PathBuf;
use clap::Args;
use serde_json::{Map, Value, json};

use super::{CommandExit, report};
use dotgen_hosting::sockets;

/// Request a service of a component that runs (`dotgen run --clock real`)
///
/// Prints the outputs as JSON when the service has ended. Ctrl-C ends only this command; the activity goes
/// on.
///
/// Exit status: 0 if the service ended, 1 if it was refused, was interrupted or threw an exception, 2 if
/// nothing could be requested.
#[derive(Debug, Args)]
pub(super) struct Call {
    /// Component of the service
    component: String,

    /// Service to request
    service: String,

    /// Inputs by name, as a JSON object; the others have their default, or are zero
    #[arg(value_name = "JSON", default_value = "{}")]
    input: String,

    /// Return as soon as the service is accepted
    #[arg(long)]
    ack: bool,

    /// Request it on another machine, by Zenoh: the endpoint of the run there, or of a Zenoh router, for
    /// example tcp/robot2:7447
    #[arg(long, value_name = "ENDPOINT", action = clap::ArgAction::Append, conflicts_with = "socket")]
    zenoh_connect: Vec<String>,

    /// Socket of the run [default: the only run on this machine]
    #[arg(long, value_name = "PATH")]
    socket: Option<Utf8PathBuf>,
}

/// Print the values of an output port, one JSON value per line
///
/// Begins with the newest value, if the port has been written. Ends when the run or the component ends, or
/// on Ctrl-C.
///
/// Exit status: 0 if the run ended or N values were printed, 1 if the component ended, 2 if the port could
/// not be watched.
#[derive(Debug, Args)]
pub(super) struct Watch {
    /// Port to watch, as COMPONENT/PORT
    port: String,

    /// End after N values
    #[arg(short = 'n', long, value_name = "N")]
    count: Option<u64>,

    /// Leave out the value that was written before
    #[arg(long)]
    only_new: bool,

    /// Socket of the run [default: the only run on this machine]
    #[arg(long, value_name = "PATH")]
    socket: Option<Utf8PathBuf>,
}

/// A connection to a run.
pub(super) struct RunConnection {
    stream: std::os::unix::net::UnixStream,
    lines: std::io::Lines<BufReader<std::os::unix::net::UnixStream>>,
}

impl RunConnection {
    pub(super) fn begin(socket: Option<&Utf8PathBuf>) -> anyhow::Result<RunConnection> {
        let path = socket.map(|socket| socket.as_std_path());
        let stream = sockets::connect(path).map_err(anyhow::Error::msg)?;
        let lines = BufReader::new(stream.try_clone()?).lines();
        Ok(RunConnection { stream, lines })
    }

    pub(super) fn say(&mut self, message: &Value) -> anyhow::Result<()> {
        self.stream.write_all(format!("{message}\n").as_bytes())?;
        Ok(())
    }

    /// Returns the next answer, or `None` after the end of the run.
    ///
    /// # Errors
    /// The run refuses the request.
    pub(super) fn hear(&mut self) -> anyhow::Result<Option<Value>> {
        let Some(Ok(line)) = self.lines.next() else {
            return Ok(None);
        };
        let message: Value =
            serde_json::from_str(&line).context("the answer of the run is not valid JSON")?;
        refused(&message)?;
        Ok(Some(message))
    }

    /// Returns the descriptions of the components of the run.
    pub(super) fn components(&mut self) -> anyhow::Result<Vec<Value>> {
        self.say(&json!({"id": 1, "describe": null}))?;
        match self.hear()? {
            Some(mut message) => match message["components"].take() {
                Value::Array(all) => Ok(all),
                _ => bail!("the run does not describe its components"),
            },
            None => bail!("the run has ended"),
        }
    }
}

pub(super) fn call(arguments: &Call) -> anyhow::Result<CommandExit> {
    let input: Value = serde_json::from_str(&arguments.input)
        .context("the inputs are not valid JSON: give an object, for example '{\"height\": 2}'")?;
    if !arguments.zenoh_connect.is_empty() {
        return call_elsewhere(arguments, &input);
    }
    let mut talk = RunConnection::begin(arguments.socket.as_ref())?;
    let path = format!("{}.{}", arguments.component, arguments.service);
    talk.say(&json!({"id": 1, "call": path, "input": input}))?;
    while let Some(message) = talk.hear()? {
        if let Some(outcome) = show(&message, arguments.ack)? {
            return Ok(outcome);
        }
    }
    bail!("the run has ended before the service has")
}

/// Requests the service on another machine.
#[cfg(feature = "zenoh")]
fn call_elsewhere(arguments: &Call, input: &Value) -> anyhow::Result<CommandExit> {
    use std::ops::ControlFlow;

    let Call { component, service, .. } = arguments;
    let mut result = None;
    let mut hear = |message: Value| {
        result = refused(&message).and_then(|()| show(&message, arguments.ack)).transpose();
        match result {
            Some(_) => ControlFlow::Break(()),
            None => ControlFlow::Continue(()),
        }
    };
    let connect = &arguments.zenoh_connect;
    let requested = dotgen_hosting::network::request(connect, component, service, input, &mut hear);
    requested.map_err(anyhow::Error::msg)?;
    result.context("the run has not said how the service ended")?
}

#[cfg(not(feature = "zenoh"))]
fn call_elsewhere(_: &Call, _: &Value) -> anyhow::Result<CommandExit> {
    bail!(crate::report::NO_ZENOH)
}

/// Prints a reply to a request of a service. Returns the outcome of the command if the reply decides it.
fn show(message: &Value, ack: bool) -> anyhow::Result<Option<CommandExit>> {
    Ok(match message["event"].as_str() {
        Some("accepted") if ack => Some(CommandExit::Fine),
        Some("done") => {
            writeln!(std::io::stdout(), "{}", message["output"])?;
            Some(CommandExit::Fine)
        }
        Some("failed") => {
            let exception = message["exception"].as_str().unwrap_or("an exception");
            match &message["detail"] {
                Value::Null => explain_failure(exception),
                detail => explain_failure(&format!("{exception} {detail}")),
            }
            Some(CommandExit::Errors)
        }
        _ => None,
    })
}

/// Returns an error if a reply says that the request is refused.
fn refused(message: &Value) -> anyhow::Result<()> {
    if message["event"] == "error" {
        let why = message["message"].as_str();
        bail!("{}", why.unwrap_or("the request is wrong"));
    }
    Ok(())
}

pub(super) fn watch(arguments: &Watch) -> anyhow::Result<CommandExit> {
    let mut talk = RunConnection::begin(arguments.socket.as_ref())?;
    talk.say(&json!({"id": 0, "read": arguments.port}))?;
    talk.say(&json!({"id": 1, "watch": arguments.port, "newest": !arguments.only_new}))?;
    let mut left = arguments.count;
    while left != Some(0) {
        let Some(message) = talk.hear()? else { break };
        refused(&message)?;
        match message["event"].as_str() {
            Some("data") if message["id"] == 0 => {
                if message["instances"].as_object().is_some_and(Map::is_empty) {
                    report::note(&format!("waiting: {} was never written", arguments.port));
                }
                continue;
            }
            Some("data") => {}
            Some("lost") => {
                explain_failure(message["message"].as_str().unwrap_or("the component is gone"));
                return Ok(CommandExit::Errors);
            }
            _ => continue,
        }
        let mut out = std::io::stdout();
        match message["instance"].as_str() {
            None | Some("") => writeln!(out, "{}", message["value"])?,
            Some(instance) => writeln!(out, "{}", json!({instance: message["value"]}))?,
        }
        left = left.map(|number| number - 1);
    }
    Ok(CommandExit::Fine)
}

/// Prints the reason of the failure of a service.
fn explain_failure(why: &str) {
    // If standard error is closed, nothing can be reported.
    let _ = writeln!(std::io::stderr(), "{why}");
}
