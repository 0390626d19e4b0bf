//! Runs of TChecker, as `tck-reach -C symbolic` and `-C concrete` write them: a graph in the language of
//! Graphviz whose nodes are states and whose edges are transitions, in one path.

use std::collections::HashMap;

use super::{Error, Moved, State, Transition, Written, time};

/// Attributes of a node or an edge.
type Attributes<'t> = HashMap<&'t str, &'t str>;

/// Edges from a node: line, target and attributes.
type Edges<'t> = Vec<(usize, &'t str, Attributes<'t>)>;

/// Reads a run.
pub(super) fn read(text: &str) -> Result<Written<'_>, Error> {
    let mut nodes: HashMap<&str, (usize, Attributes)> = HashMap::new();
    let mut edges: HashMap<&str, Edges> = HashMap::new();
    let (mut begun, mut ended) = (false, false);
    for (index, line) in text.lines().enumerate() {
        let (number, line) = (index + 1, line.trim());
        if line.starts_with("digraph") && begun {
            return Err(Error::at(number, "a second graph begins: give one run"));
        } else if line.starts_with("digraph") || !begun {
            // Statistics come before the graph.
            begun |= line.starts_with("digraph");
        } else if line == "}" {
            ended = true;
        } else if !line.is_empty() && !ended {
            let (name, rest) = line.split_once('[').unwrap_or((line, "]"));
            let attributes = attributes(rest, number)?;
            match name.split_once("->") {
                Some((source, target)) => {
                    let edge = (number, target.trim(), attributes);
                    edges.entry(source.trim()).or_default().push(edge);
                }
                None if nodes.insert(name.trim(), (number, attributes)).is_some() => {
                    return Err(Error::at(number, format!("a second node `{}`", name.trim())));
                }
                None => {}
            }
        }
    }
    if !ended {
        return Err(Error::new("the graph breaks off: its `}` is missing"));
    }
    path(nodes, edges)
}

/// Reads `key="value", …]`.
fn attributes(text: &str, line: usize) -> Result<Attributes<'_>, Error> {
    let wrong = || Error::at(line, "attributes `[key=\"value\", …]` are expected");
    let (mut out, mut rest) = (Attributes::new(), text.trim_start());
    while !rest.starts_with(']') {
        let (key, after) = rest.split_once('=').ok_or_else(wrong)?;
        let value = after.trim_start().strip_prefix('"').ok_or_else(wrong)?;
        let (value, after) = value.split_once('"').ok_or_else(wrong)?;
        out.insert(key.trim(), value);
        rest = after.trim_start().trim_start_matches(',').trim_start();
    }
    match rest.trim_matches([']', ';', ' ']) {
        "" => Ok(out),
        _ => Err(wrong()),
    }
}

/// Returns the only path of a graph.
fn path<'t>(
    mut nodes: HashMap<&'t str, (usize, Attributes<'t>)>,
    mut edges: HashMap<&'t str, Edges<'t>>,
) -> Result<Written<'t>, Error> {
    let mut out = Written::default();
    if nodes.is_empty() {
        return Err(Error::new("the graph is empty: TChecker has found no run"));
    }
    let starts = nodes.iter().filter(|node| node.1.1.contains_key("initial")).map(|node| *node.0);
    let starts: Vec<&str> = starts.collect();
    let [mut at] = starts[..] else {
        return Err(Error::new("the graph needs one node with `initial`"));
    };
    loop {
        let Some((line, attributes)) = nodes.remove(at) else {
            let message = format!("node `{at}` is missing, or the run comes back to it");
            return Err(Error::new(message));
        };
        out.states.push(state(line, &attributes)?);
        let Some(mut following) = edges.remove(at) else { break };
        let Some((line, target, attributes)) = following.pop() else { break };
        if let Some((other, ..)) = following.first() {
            let message =
                "a second edge leaves a node: give the output of `-C symbolic` or `-C concrete`";
            return Err(Error::at(line.max(*other), message));
        }
        let edge = |part: &'t str| match part.trim().split_once('@') {
            Some((process, event)) => Ok(Moved { process, between: None, event: Some(event) }),
            None => Err(Error::at(line, format!("`{part}` is not `PROCESS@EVENT`"))),
        };
        let parts = list(line, &attributes, "vedge")?.split(',');
        let delay = attributes.get("delay");
        out.has_times |= delay.is_some();
        let delay = delay.map_or(Ok(Some(0)), |delay| time(delay, line))?;
        out.transitions.push(Transition {
            line,
            delay,
            edges: parts.map(edge).collect::<Result<_, _>>()?,
        });
        at = target;
    }
    let others = nodes.values().map(|node| node.0);
    let others = others.chain(edges.values().flatten().map(|edge| edge.0));
    match others.min() {
        Some(line) => {
            Err(Error::at(line, "not on the path from the initial node: the graph is not a run"))
        }
        None => Ok(out),
    }
}

fn state<'t>(line: usize, attributes: &Attributes<'t>) -> Result<State<'t>, Error> {
    let locations = list(line, attributes, "vloc")?.split(',').collect();
    let values = attributes.get("intval").copied().unwrap_or_default();
    let values = values.split(',').filter(|text| !text.is_empty()).map(|text| {
        text.split_once('=').ok_or_else(|| Error::at(line, format!("`{text}` is not `NAME=VALUE`")))
    });
    Ok(State { line, locations, values: values.collect::<Result<_, _>>()? })
}

/// Returns the text of a list `<a,b>`.
fn list<'t>(line: usize, attributes: &Attributes<'t>, key: &str) -> Result<&'t str, Error> {
    let text = attributes.get(key).and_then(|text| text.strip_prefix('<')?.strip_suffix('>'));
    text.ok_or_else(|| Error::at(line, format!("`{key}=\"<…>\"` is missing")))
}
