//! Components, their ports, and the data that flows between them.
//!
//! A component is a card with its tasks and services, a port an octagon next to it; data flows from the
//! writer through the port to every reader.

pub use dotgen_analysis::model::system::{Connection, Part};
use std::collections::BTreeMap;

use dotgen_analysis::model::system::{PortRef, System, type_name};
use dotgen_analysis::model::{ParamSource, PortDir, Seconds, Src, Task};

use crate::graph::{Direction, Edge, Graph, Line, LineStyle, Node, Origin, Shape};
use dotgen_analysis::quantity;

/// The content of the picture.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Title of the picture.
    pub title: String,
    /// Known connections; the others are found by type and name.
    pub connections: Vec<Connection>,
    /// Maximum number of services listed in a component (0: none).
    pub services: usize,
    /// True to show the services that interrupt each other.
    pub interrupts: bool,
    /// True to show, at each port, the codels that exclude each other there and the longest time that one of
    /// them holds it.
    pub locks: bool,
    /// Components that were opened (all of their ports, tasks and services are listed) or closed (they are
    /// counted). Other components have a summary, or in large systems only the counts.
    pub opened: BTreeMap<String, bool>,
    /// Chains of data to show, each with the ports on its path as `component.port`, and its result.
    pub chains: Vec<Chain>,
}

/// A chain of data through a system.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Chain {
    /// Ports that it passes, from the first to the last, as component and port. Between them it takes the
    /// shortest path.
    pub ports: Vec<(String, String)>,
    /// The result for the chain, in one line.
    pub says: String,
}

/// Maximum number of components for which a system shows summaries; in larger systems components are closed.
const SUMMARIES: usize = 12;

/// The amount of detail of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Detail {
    /// Counts only.
    Closed,
    /// Tasks, and the first services.
    Summary,
    /// Everything.
    Open,
}

impl Options {
    fn detail(&self, component: &str, components: usize) -> Detail {
        match self.opened.get(component) {
            Some(true) => Detail::Open,
            Some(false) => Detail::Closed,
            None if components > SUMMARIES => Detail::Closed,
            None => Detail::Summary,
        }
    }
}

/// Builds the graph of a system.
pub fn graph(parts: &[Part], options: &Options) -> Graph {
    let system = System::new(parts.iter().copied(), &options.connections);
    let parts = &system.parts;
    let mut graph =
        Graph { title: options.title.clone(), direction: Direction::Right, ..Graph::default() };
    for part in parts {
        let detail = options.detail(&part.component.name, parts.len());
        graph.nodes.push(card(part, options, detail));
        for port in part.component.ports.iter().filter(|p| p.dir == PortDir::Out) {
            let id = format!("{}.{}", part.component.name, port.name);
            graph.nodes.push(octagon(
                &id,
                &port.name,
                type_name(part.spec, port.data),
                false,
                origin(part, port.src),
            ));
            graph.edges.push(flow(
                &part.component.name,
                &id,
                format!("{} writes {}", part.component.name, port.name),
            ));
        }
    }
    for number in 0..parts.len() {
        inputs(&system, number, &mut graph);
    }
    if options.locks {
        locks(&system, &mut graph);
    }
    for chain in &options.chains {
        follow(&system, chain, &mut graph);
    }
    let lonely = |node: &Node| node.classes.iter().any(|class| class == "unconnected");
    if graph.nodes.iter().any(lonely) {
        let note = "Dashed: input ports that nothing here feeds.";
        graph.notes.push(note.to_owned());
    }
    graph
}

/// Adds the input ports of a component that nothing feeds, and the flows into the others.
fn inputs(system: &System<'_>, number: usize, graph: &mut Graph) {
    let part = &system.parts[number];
    let name = &part.component.name;
    let ports = part.component.ports.iter_enumerated();
    for (index, port) in ports.filter(|port| port.1.dir == PortDir::In) {
        let sources = system.sources((number, index));
        if sources.is_empty() {
            let id = format!("{name}.{}", port.name);
            let link = origin(part, port.src);
            graph.nodes.push(octagon(&id, &port.name, type_name(part.spec, port.data), true, link));
            graph.edges.push(flow(
                &id,
                name,
                format!("{name} reads {}, which nothing feeds", port.name),
            ));
        }
        for (component, source) in sources {
            let component = system.parts[component].component;
            let source = &component.ports[source].name;
            let component = &component.name;
            let id = format!("{component}.{source}");
            let mut edge =
                flow(&id, name, format!("{name} reads {component}.{source} as {}", port.name));
            if *source != port.name {
                edge.label = port.name.to_string();
            }
            graph.edges.push(edge);
        }
    }
}

fn origin(part: &Part, src: Src) -> Option<Origin> {
    Some(Origin { part: part.number, src })
}

fn card(part: &Part, options: &Options, detail: Detail) -> Node {
    let component = part.component;
    let mut lines = vec![Line::new(LineStyle::Title, component.name.as_str())];
    match detail {
        Detail::Closed => lines.push(Line::new(LineStyle::Detail, counts(part, " · "))),
        Detail::Summary => summary(part, options, &mut lines),
        Detail::Open => everything(part, &mut lines),
    }
    if options.interrupts && detail != Detail::Closed {
        interrupts(part, &mut lines);
    }
    let open = detail == Detail::Open;
    let ports = component.ports.iter().map(|port| &port.name);
    let tasks = component.tasks.iter().map(|task| &task.name);
    let services = component.services.iter().map(|service| &service.name);
    let names = ports.chain(tasks).chain(services);
    let names = names.map(ToString::to_string).collect();
    Node {
        id: component.name.to_string(),
        shape: Shape::Card,
        lines,
        classes: vec!["component".to_owned()],
        description: format!("component {}, {}", component.name, counts(part, ", ")),
        origin: origin(part, component.src),
        names: vec![component.name.to_string()],
        open: Some(open),
        holds: names,
        ..Node::default()
    }
}

/// The numbers of tasks, services and ports.
fn counts(part: &Part, between: &str) -> String {
    let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    let component = part.component;
    [
        count(component.tasks.len(), "task"),
        count(component.services.len(), "service"),
        count(component.ports.len(), "port"),
    ]
    .join(between)
}

/// `task main · 5 ms`
fn task(task: &Task) -> Line {
    let rate = task.period.as_ref().map_or("aperiodic".to_owned(), |p| quantity::time(p.value));
    Line::new(LineStyle::Detail, format!("task {} · {rate}", task.name))
}

/// Tasks, and the first services up to the option's limit.
fn summary(part: &Part, options: &Options, lines: &mut Vec<Line>) {
    let component = part.component;
    lines.extend(component.tasks.iter().map(task));
    if options.services > 0 {
        for service in component.services.iter().take(options.services) {
            lines.push(Line::new(LineStyle::Code, format!("{}()", service.name)));
        }
        let more = component.services.len().saturating_sub(options.services);
        if more > 0 {
            let plural = if more == 1 { "" } else { "s" };
            lines.push(Line::new(LineStyle::Detail, format!("… {more} more service{plural}")));
        }
    }
}

/// Ports, tasks and services, each linked to its own place.
fn everything(part: &Part, lines: &mut Vec<Line>) {
    let component = part.component;
    for port in &component.ports {
        let dir = port.dir.word();
        let data = type_name(part.spec, port.data);
        let text = format!("{dir} {}: {}", port.name, data.trim_start_matches("::"));
        lines.push(Line::new(LineStyle::Detail, text).at(origin(part, port.src)));
    }
    let tasks = component.tasks.iter();
    lines.extend(tasks.map(|declared| task(declared).at(origin(part, declared.src))));
    for service in &component.services {
        let text = format!("{}()", service.name);
        lines.push(Line::new(LineStyle::Code, text).at(origin(part, service.src)));
    }
}

fn interrupts(part: &Part, lines: &mut Vec<Line>) {
    let component = part.component;
    for service in &component.services {
        let list = &service.interrupts;
        let names = if list.all {
            "all".to_owned()
        } else {
            let names: Vec<&str> =
                list.services.iter().map(|&i| component.services[i].name.as_str()).collect();
            names.join(", ")
        };
        if !names.is_empty() {
            lines
                .push(Line::new(LineStyle::Detail, format!("{} interrupts {names}", service.name)));
        }
    }
}

/// The users of the data of an output port, in any component.
#[derive(Default)]
struct PortUsers {
    /// `component.codel`
    codels: Vec<String>,
    components: Vec<usize>,
    longest: Option<Seconds>,
}

/// Adds to each output port that codels of several components use the number of codels that exclude each
/// other there.
fn locks(system: &System, graph: &mut Graph) {
    let mut users: BTreeMap<PortRef, PortUsers> = BTreeMap::new();
    for (number, part) in system.parts.iter().enumerate() {
        for codel in part.component.all_codels() {
            let codel = part.component.codel(codel);
            let mut ports: Vec<PortRef> = Vec::new();
            for param in &codel.params {
                if let ParamSource::Port(port) = param.source {
                    ports.extend(system.data_of((number, port)));
                }
            }
            ports.sort_unstable();
            ports.dedup();
            for port in ports {
                let users = users.entry(port).or_default();
                let name = format!("{}.{}", part.component.name, codel.name);
                users.codels.push(name);
                if users.components.last() != Some(&number) {
                    users.components.push(number);
                }
                let wcet = codel.wcet.as_ref().map(|wcet| wcet.value);
                users.longest = users.longest.max(wcet);
            }
        }
    }
    for (port, users) in users.into_iter().filter(|user| user.1.components.len() > 1) {
        let id = system.port_name(port);
        let Some(node) = graph.nodes.iter_mut().find(|node| node.id == id) else {
            continue;
        };
        let mut text = format!("{} codels take turns", users.codels.len());
        if let Some(longest) = users.longest {
            text += &format!(", ≤ {} each", quantity::time(longest));
        }
        node.lines.push(Line::new(LineStyle::Detail, text));
        node.classes.push("contended".to_owned());
        node.description += &format!(", taken in turns by {}", users.codels.join(", "));
    }
}

/// Marks the path of a chain, and adds its result below.
fn follow(system: &System, chain: &Chain, graph: &mut Graph) {
    let data = |(component, port): &(String, String)| {
        let part = system.part(component)?;
        let mut ports = system.parts[part].component.ports.iter_enumerated();
        let (index, _) = ports.find(|(_, candidate)| candidate.name.as_str() == port)?;
        let source = system.data_of((part, index)).first().copied()?;
        Some(system.port_name(source))
    };
    let ports: Vec<String> = chain.ports.iter().filter_map(data).collect();
    let mut way: Vec<String> = ports.first().cloned().into_iter().collect();
    for pair in ports.windows(2) {
        way.extend(shortest(graph, &pair[0], &pair[1]));
    }
    for node in graph.nodes.iter_mut().filter(|node| way.contains(&node.id)) {
        node.mark();
    }
    for edge in &mut graph.edges {
        let mut steps = way.windows(2);
        if steps.any(|step| step[0] == edge.from && step[1] == edge.to) {
            edge.mark();
        }
    }
    graph.notes.push(chain.says.clone());
}

/// The nodes on a shortest path from one to another, without the first; empty if there is none.
fn shortest(graph: &Graph, from: &str, to: &str) -> Vec<String> {
    let mut before: BTreeMap<&str, &str> = BTreeMap::new();
    let mut queue = std::collections::VecDeque::from([from]);
    while let Some(node) = queue.pop_front().filter(|queue| *queue != to) {
        for edge in graph.edges.iter().filter(|edge| edge.from == node) {
            if edge.to != from && !before.contains_key(edge.to.as_str()) {
                before.insert(&edge.to, node);
                queue.push_back(&edge.to);
            }
        }
    }
    let mut way = Vec::new();
    let mut at = to;
    while let Some(text) = before.get(at) {
        way.push(at.to_owned());
        at = text;
    }
    way.reverse();
    way
}

fn octagon(id: &str, name: &str, ty: String, unconnected: bool, origin: Option<Origin>) -> Node {
    let mut classes = vec!["port".to_owned()];
    if unconnected {
        classes.push("unconnected".to_owned());
    }
    let end = if unconnected { ", connected to nothing" } else { "" };
    Node {
        id: id.to_owned(),
        shape: Shape::Octagon,
        lines: vec![Line::new(LineStyle::Title, name)],
        classes,
        description: format!("port {id} of type {ty}{end}"),
        origin,
        names: vec![id.to_owned()],
        ..Node::default()
    }
}

fn flow(from: &str, to: &str, description: String) -> Edge {
    Edge {
        from: from.to_owned(),
        to: to.to_owned(),
        classes: vec!["flow".to_owned()],
        description,
        ..Edge::default()
    }
}
