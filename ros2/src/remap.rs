//! Other names for topics, services and actions: `--remap /motor/measure:=/odom`.

use std::collections::{BTreeMap, BTreeSet};

use dotgen_syntax::suggestion::advice;

use crate::names;
use crate::node::{Endpoint, Node};
use crate::wire::Kind;

/// Maximum length of a name in ROS 2.
const LENGTH: usize = 247;

/// The part of the name of an action's topics and services that follows the action.
const ACTION: &str = "/_action/";

/// Another name for a topic, service or action.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remap {
    from: String,
    to: String,
}

impl std::str::FromStr for Remap {
    type Err = String;

    /// Reads `/motor/measure:=/odom`. The first name may lack its `/`.
    fn from_str(text: &str) -> Result<Remap, String> {
        let (from, to) = text.split_once(":=").ok_or_else(|| {
            "write FROM:=TO, for example `/motor/measure:=/odom`: FROM is a topic, service or action of the \
             run, TO its name in ROS 2"
                .to_owned()
        })?;
        let Some(path) = to.strip_prefix('/') else {
            return Err(format!("the name `{to}` is not absolute: begin it with `/`"));
        };
        if to.len() > LENGTH {
            return Err(format!("the name after `:=` is longer than {LENGTH} bytes: shorten it"));
        }
        let from = from.strip_prefix('/').unwrap_or(from);
        let name = |path: &str| {
            names::topic(path.split('/')).map_err(|_| {
                format!(
                    "`/{path}` is not a name in ROS 2: use letters, digits and `_` between single `/`, and no \
                     digit after `/`"
                )
            })
        };
        Ok(Remap { from: name(from)?, to: name(path)? })
    }
}

/// Renames topics, services and actions of all nodes of a run.
///
/// # Errors
/// In words: a name does not exist or has two new names, or two parts of the run that cannot share a name
/// get one.
pub fn remap(remaps: &[Remap], nodes: &mut [&mut Node]) -> Result<(), String> {
    let mut new: BTreeMap<&str, &str> = BTreeMap::new();
    for Remap { from, to } in remaps {
        if let Some(other) = new.insert(from, to).filter(|other| other != to) {
            return Err(format!("`{from}` has two new names, `{other}` and `{to}`: remove one"));
        }
    }
    let endpoints = nodes.iter().flat_map(|node| &node.endpoints);
    let known: BTreeSet<&str> = endpoints.map(|endpoint| base(&endpoint.topic)).collect();
    if let Some(unknown) = new.keys().find(|from| !known.contains(**from)) {
        let names: Vec<&str> = known.into_iter().collect();
        let near = advice(unknown, &names);
        let all = if near.starts_with("did") {
            format!(" There are `{}`", names.join("`, `"))
        } else {
            String::new()
        };
        return Err(format!("`{unknown}` is not a name of this run in ROS 2; {near}{all}"));
    }
    for endpoint in nodes.iter_mut().flat_map(|node| &mut node.endpoints) {
        let old = base(&endpoint.topic);
        if let Some(&to) = new.get(old) {
            endpoint.topic = format!("{to}{}", &endpoint.topic[old.len()..]);
        }
    }
    let mut users: BTreeMap<(bool, bool, &str), &Endpoint> = BTreeMap::new();
    for endpoint in nodes.iter().flat_map(|node| &node.endpoints) {
        let (topic, type_name) = (endpoint.topic.as_str(), &endpoint.type_name);
        let is_server = endpoint.kind == Kind::Server;
        let Some(other) = users.insert((is_server, endpoint.multiple, topic), endpoint) else {
            continue;
        };
        let topic = base(topic);
        if is_server || topic.len() < endpoint.topic.len() {
            return Err(format!(
                "two services or actions become `{topic}`: give them different names"
            ));
        }
        if other.type_name != *type_name {
            return Err(format!(
                "two ports become `{topic}`, but one has the type `{}` and the other `{type_name}`: give them \
                 different names, or the same message",
                other.type_name
            ));
        }
    }
    Ok(())
}

/// The name of a port, service or action, by that of one of its topics and services.
fn base(topic: &str) -> &str {
    topic.split_once(ACTION).map_or(topic, |(action, _)| action)
}
