//! `dotgen play`: writes the port data of a recording to input ports of a run.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::time::Duration;

use anyhow::bail;
use camino::Utf8PathBuf;
use clap::Args;
use dotgen_analysis::terminal;
use dotgen_recording::record::{self, PortRecording};
use dotgen_syntax::suggestion::advice;
use serde_json::Value;

use super::call::RunConnection;
use super::wcet::unreadable;
use super::write::{Input, Pacer};
use super::{CommandExit, report};

/// Write the port data of a recording to input ports of a run, at the recorded times
///
/// FILE.mcap is a recording of `dotgen run --record`. The data of an output port goes to the input ports of
/// the same name. No output port of the run may be connected to them. In the end, the command prints which
/// topics were played, and which not and why.
///
/// Exit status: 0 if at least one topic was played and all its data was written, 1 if data was refused, 2 if
/// nothing was played.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Recording
    #[arg(value_name = "FILE.mcap")]
    file: Utf8PathBuf,

    /// Write the data of topic FROM to the input port TO instead, for example `pom/frame=nhfc/state`
    #[arg(long = "topic", value_name = "FROM=TO", value_parser = renaming)]
    topics: Vec<(String, String)>,

    /// Play faster or slower: 2 is twice as fast
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = factor)]
    speed: f64,

    /// Socket of the run [default: the only run on this machine]
    #[arg(long, value_name = "PATH")]
    socket: Option<Utf8PathBuf>,
}

fn renaming(text: &str) -> Result<(String, String), String> {
    let (from, to) =
        text.split_once('=').ok_or("write FROM=TO, for example pom/frame=nhfc/state")?;
    let from = from.trim().trim_start_matches('/');
    Ok((from.to_owned(), to.trim().trim_start_matches('/').to_owned()))
}

fn factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if (1e-3..=1e3).contains(&number) => Ok(number),
        _ => Err("write a number from 0.001 to 1000".to_owned()),
    }
}

/// An input port of the run.
struct Port {
    path: String,
    multiple: bool,
    schema: Value,
}

/// An input port that receives the data of a topic.
struct Target {
    port: usize,
    instance: Option<String>,
    written: u64,
    /// The reason for which data was refused. No more data is sent then.
    refused: Option<String>,
}

/// A topic, with its targets, or the reason why there are none.
struct Topic {
    name: String,
    targets: Vec<Target>,
    why: Option<String>,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let path = &arguments.file;
    let bytes = std::fs::read(path).map_err(|error| unreadable(path, &error))?;
    let data = record::read_data(&bytes).map_err(|error| anyhow::anyhow!("`{path}`: {error}"))?;
    match &data.broken {
        // Times and values after a damage are not those of the run.
        Some(broken) if broken.damaged.is_some() => bail!("`{path}` is {broken}"),
        Some(broken) => report::note(&format!("`{path}` breaks off: {broken}")),
        None => {}
    }
    if data.messages.is_empty() {
        bail!("`{path}` has no data of ports: a recording with codels has it");
    }
    let mut talk = RunConnection::begin(arguments.socket.as_ref())?;
    let ports = inputs(&talk.components()?);
    let mut topics = targets(&data, &ports, &arguments.topics)?;
    let whole = play(&data, &ports, &mut topics, arguments.speed, &mut talk)?;
    print(&topics, &ports)?;
    if !whole {
        bail!("the run has ended before the recording");
    }
    let all = || topics.values().flat_map(|topic| &topic.targets);
    Ok(
        match (all().any(|target| target.written > 0), all().any(|target| target.refused.is_some()))
        {
            (false, _) => CommandExit::Unusable,
            (true, true) => CommandExit::Errors,
            (true, false) => CommandExit::Fine,
        },
    )
}

/// The input ports of the components of a run.
fn inputs(components: &[Value]) -> Vec<Port> {
    let ports = components.iter().flat_map(|component| {
        let name = component["name"].as_str().unwrap_or_default();
        let ports = component["ports"].as_array().into_iter().flatten();
        ports.filter(|port| port["direction"] == "in").map(move |port| Port {
            path: format!("{name}/{}", port["name"].as_str().unwrap_or_default()),
            multiple: port["multiple"] == true,
            schema: port["schema"].clone(),
        })
    });
    ports.collect()
}

/// Finds the input ports for all topics: the named ones, or else those with the name of the topic's port.
fn targets(
    data: &PortRecording,
    ports: &[Port],
    renamed: &[(String, String)],
) -> anyhow::Result<BTreeMap<u16, Topic>> {
    let names: Vec<&str> =
        data.topics.values().map(|topic| topic.trim_start_matches('/')).collect();
    let paths: Vec<&str> = ports.iter().map(|port| port.path.as_str()).collect();
    check_renamed(renamed, &names, &paths)?;
    let mut topics: BTreeMap<u16, Topic> = BTreeMap::new();
    // Input ports and instances that are taken, with the topic.
    let mut taken: BTreeMap<(usize, Option<String>), String> = BTreeMap::new();
    // Named ports come first.
    let mut order: Vec<(&u16, &str)> = data.topics.keys().zip(names).collect();
    order.sort_by_key(|(_, name)| !renamed.iter().any(|entry| entry.0 == *name));
    for (channel, name) in order {
        let (own, instance) = port_of(name);
        let (component, port) = own.split_once('/').unwrap_or((own, ""));
        let chosen: Vec<&str> =
            (renamed.iter()).filter(|(old, _)| old == name).map(|(_, new)| new.as_str()).collect();
        let mut topic = Topic { name: name.to_owned(), targets: Vec::new(), why: None };
        for (number, declaration) in ports.iter().enumerate() {
            let named = chosen.iter().find(|to| port_of(to).0 == declaration.path);
            let fits = declaration.path.split_once('/').is_some_and(|(_, own)| own == port);
            if named.is_none() && (!chosen.is_empty() || !fits) {
                continue;
            }
            let given = named.and_then(|to| port_of(to).1).or(instance);
            let instance = declaration.multiple.then(|| given.unwrap_or(component).to_owned());
            if let Some(other) = taken.get(&(number, instance.clone())) {
                let why = "choose one with --topic";
                topic.why = Some(format!("`{}` gets `{other}`; {why}", declaration.path));
            } else {
                taken.insert((number, instance.clone()), name.to_owned());
                topic.targets.push(Target { port: number, instance, written: 0, refused: None });
            }
        }
        if topic.targets.is_empty() && topic.why.is_none() {
            topic.why =
                Some(format!("the run has no input port `{port}`; --topic names another one"));
        }
        topics.insert(*channel, topic);
    }
    Ok(topics)
}

/// Checks that the renamed topics and their ports exist.
///
/// # Errors
/// One of them does not.
fn check_renamed(
    renamed: &[(String, String)],
    names: &[&str],
    paths: &[&str],
) -> anyhow::Result<()> {
    for (from, to) in renamed {
        if !names.contains(&from.as_str()) {
            bail!("`--topic {from}={to}`: the recording has no `{from}`; {}", advice(from, names));
        }
        if !paths.contains(&port_of(to).0) {
            bail!("`--topic {from}={to}`: the run has no input port `{to}`; {}", advice(to, paths));
        }
    }
    Ok(())
}

/// `pump/level/left` is the instance `left` of `pump/level`.
fn port_of(path: &str) -> (&str, Option<&str>) {
    let mut slashes = path.match_indices('/');
    match slashes.nth(1) {
        Some((at, _)) => (&path[..at], Some(&path[at + 1..])),
        None => (path, None),
    }
}

/// Writes all data. Returns false if the run ended before.
fn play(
    data: &PortRecording,
    ports: &[Port],
    topics: &mut BTreeMap<u16, Topic>,
    speed: f64,
    talk: &mut RunConnection,
) -> anyhow::Result<bool> {
    let has_target =
        |number: &u16| topics.get(number).is_some_and(|topic| !topic.targets.is_empty());
    let played = data.messages.iter().filter(|message| has_target(&message.channel));
    let mut played: Vec<_> = played.collect();
    played.sort_by_key(|message| message.at);
    let first = played.first().map_or(0, |message| message.at);
    let mut pace = Pacer::begin();
    for message in played {
        let Some(topic) = topics.get_mut(&message.channel) else {
            continue;
        };
        if topic.targets.iter().all(|target| target.refused.is_some()) {
            continue;
        }
        pace.wait(Duration::from_nanos(message.at - first).div_f64(speed));
        let value: Result<Value, _> = serde_json::from_slice(&message.text);
        for target in topic.targets.iter_mut().filter(|target| target.refused.is_none()) {
            let Some(port) = ports.get(target.port) else {
                continue;
            };
            let value = match &value {
                Ok(slice) => unwrap_member(slice, &port.schema),
                Err(error) => {
                    target.refused = Some(format!("the recording has no JSON there: {error}"));
                    continue;
                }
            };
            if is_not_finite(value, &port.schema) {
                target.refused = Some("a number is not finite, and cannot be written".to_owned());
                continue;
            }
            let mut input = Input {
                talk: &mut *talk,
                port: port.path.clone(),
                instance: target.instance.clone(),
            };
            match input.write(value) {
                Ok(true) => target.written += 1,
                Ok(false) => return Ok(false),
                Err(error) => target.refused = Some(format!("{error:#}")),
            }
        }
    }
    pace.end();
    Ok(true)
}

/// Returns the value of a message. A value that is not an object is a member of the message.
fn unwrap_member<'v>(value: &'v Value, schema: &Value) -> &'v Value {
    match value {
        Value::Object(all) if all.len() == 1 && schema["type"] != "object" => {
            all.get("value").unwrap_or(value)
        }
        _ => value,
    }
}

/// Returns true for a float that is not a number: `null` in JSON, which a run would read as zero.
fn is_not_finite(value: &Value, schema: &Value) -> bool {
    // The first is the type of an optional value.
    let optional = schema["anyOf"].as_array().and_then(|value| value.first());
    let inner = optional.unwrap_or(schema);
    match value {
        Value::Null => {
            let kinds = schema["type"].as_array();
            kinds.is_some_and(|all| all.iter().any(|value| value == "number"))
        }
        Value::Array(all) => all.iter().any(|value| is_not_finite(value, &inner["items"])),
        Value::Object(all) => {
            let mut all = all.iter();
            all.any(|(name, value)| is_not_finite(value, &inner["properties"][name]))
        }
        _ => false,
    }
}

fn print(topics: &BTreeMap<u16, Topic>, ports: &[Port]) -> anyhow::Result<()> {
    let mut out = anstream::AutoStream::auto(std::io::stdout().lock());
    for topic in topics.values() {
        let name = terminal::text(&topic.name);
        for target in &topic.targets {
            let path = ports.get(target.port).map_or("", |port| port.path.as_str());
            let instance = target.instance.as_ref().map(|instance| format!("/{instance}"));
            let to = format!("{path}{}", instance.unwrap_or_default());
            let to = terminal::text(&to);
            match (&target.refused, target.written) {
                (None, written) => writeln!(out, "{name}: {written} values to {to}")?,
                (Some(why), 0) => {
                    writeln!(out, "{name}: not played to {to}: {}", terminal::text(why))?;
                }
                (Some(why), written) => {
                    writeln!(
                        out,
                        "{name}: only {written} values to {to}: {}",
                        terminal::text(why)
                    )?;
                }
            }
        }
        if let Some(why) = &topic.why {
            writeln!(out, "{name}: not played: {}", terminal::text(why))?;
        }
    }
    Ok(())
}
