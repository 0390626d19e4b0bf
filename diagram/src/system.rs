//! Components, their ports, and the data that flows between them.
//!
//! A component is a card with its tasks and services, a port an octagon beside it; data flows from
//! the writer through the port to every reader.

use dotgen_analysis::model::{Component, ComponentKind, PortDir, Spec, Src, TypeId};

use crate::fsm::duration;
use crate::graph::{Direction, Edge, Graph, Line, LineStyle, Node, Origin, Shape};

/// A component to draw, with the specification it belongs to.
#[derive(Debug, Clone, Copy)]
pub struct Part<'a> {
    /// Where its types live.
    pub spec: &'a Spec,
    /// The component.
    pub component: &'a Component,
    /// Number of the specification: what [`crate::graph::Origin::part`] says.
    pub number: usize,
}

/// `a.in_port` is fed by `b.out_port`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Connection {
    /// Component and output port.
    pub from: (String, String),
    /// Component and input port.
    pub to: (String, String),
}

/// What to show.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Title of the picture.
    pub title: String,
    /// Connections that are known; the others are found by type and name.
    pub connections: Vec<Connection>,
    /// At most this many services are listed in a component (0: none).
    pub services: usize,
    /// Say which services interrupt which.
    pub interrupts: bool,
}

/// Builds the graph of a system.
pub fn graph(parts: &[Part], options: &Options) -> Graph {
    let parts: Vec<Part> = parts
        .iter()
        .copied()
        .filter(|p| p.component.kind == ComponentKind::Component)
        .collect();
    let mut graph = Graph {
        title: options.title.clone(),
        direction: Direction::Right,
        ..Graph::default()
    };
    for part in &parts {
        graph.nodes.push(card(part, options));
        for port in part
            .component
            .ports
            .iter()
            .filter(|p| p.dir == PortDir::Out)
        {
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
    for part in &parts {
        let name = &part.component.name;
        for port in part.component.ports.iter().filter(|p| p.dir == PortDir::In) {
            let sources = sources(&parts, part, &port.name, port.data, options);
            if sources.is_empty() {
                let id = format!("{name}.{}", port.name);
                let link = origin(part, port.src);
                graph.nodes.push(octagon(
                    &id,
                    &port.name,
                    type_name(part.spec, port.data),
                    true,
                    link,
                ));
                graph.edges.push(flow(
                    &id,
                    name,
                    format!("{name} reads {}, which nothing feeds", port.name),
                ));
            }
            for (component, source) in sources {
                let id = format!("{component}.{source}");
                let mut edge = flow(
                    &id,
                    name,
                    format!("{name} reads {component}.{source} as {}", port.name),
                );
                if source != port.name {
                    edge.label = port.name.to_string();
                }
                graph.edges.push(edge);
            }
        }
    }
    let lonely = |it: &Node| it.classes.iter().any(|it| it == "unconnected");
    if graph.nodes.iter().any(lonely) {
        let note = "Dashed: input ports that nothing here feeds.";
        graph.notes.push(note.to_owned());
    }
    graph
}

/// Output ports that feed an input port: the configured ones; else those of equal name and type;
/// else the only one of that type.
fn sources(
    parts: &[Part],
    reader: &Part,
    port: &str,
    ty: TypeId,
    options: &Options,
) -> Vec<(String, String)> {
    let name = reader.component.name.as_str();
    let configured: Vec<(String, String)> = options
        .connections
        .iter()
        .filter(|c| c.to.0 == name && c.to.1 == port)
        .map(|c| c.from.clone())
        .filter(|(component, port)| {
            parts.iter().any(|p| {
                p.component.name == component.as_str()
                    && p.component
                        .ports
                        .iter()
                        .any(|it| it.name == port.as_str() && it.dir == PortDir::Out)
            })
        })
        .collect();
    if !configured.is_empty() {
        return configured;
    }
    let ty = type_name(reader.spec, ty);
    let candidates: Vec<(String, String)> = parts
        .iter()
        .filter(|p| p.component.name != name)
        .flat_map(|p| p.component.ports.iter().map(move |port| (p, port)))
        .filter(|(p, it)| it.dir == PortDir::Out && type_name(p.spec, it.data) == ty)
        .map(|(p, it)| (p.component.name.to_string(), it.name.to_string()))
        .collect();
    let same_name: Vec<_> = candidates
        .iter()
        .filter(|(_, it)| it == port)
        .cloned()
        .collect();
    match (same_name.is_empty(), candidates.len()) {
        (false, _) => same_name,
        (true, 1) => candidates,
        _ => Vec::new(),
    }
}

fn origin(part: &Part, src: Src) -> Option<Origin> {
    Some(Origin {
        part: part.number,
        src,
    })
}

fn type_name(spec: &Spec, ty: TypeId) -> String {
    spec.full_name(spec.resolve_alias(ty)).unwrap_or_default()
}

fn card(part: &Part, options: &Options) -> Node {
    let component = part.component;
    let mut lines = vec![Line::new(LineStyle::Title, component.name.as_str())];
    for task in &component.tasks {
        let rate = task
            .period
            .as_ref()
            .map_or("aperiodic".to_owned(), |p| duration(p.value));
        lines.push(Line::new(
            LineStyle::Detail,
            format!("task {} · {rate}", task.name),
        ));
    }
    if options.services > 0 {
        let shown = component.services.len().min(options.services);
        for service in &component.services[..shown] {
            lines.push(Line::new(LineStyle::Code, format!("{}()", service.name)));
        }
        let more = component.services.len() - shown;
        if more > 0 {
            let plural = if more == 1 { "" } else { "s" };
            lines.push(Line::new(
                LineStyle::Detail,
                format!("… {more} more service{plural}"),
            ));
        }
    }
    if options.interrupts {
        for service in &component.services {
            let list = &service.interrupts;
            let names = if list.all {
                "all".to_owned()
            } else {
                let names: Vec<&str> = list
                    .services
                    .iter()
                    .map(|&i| component.services[i as usize].name.as_str())
                    .collect();
                names.join(", ")
            };
            if !names.is_empty() {
                lines.push(Line::new(
                    LineStyle::Detail,
                    format!("{} interrupts {names}", service.name),
                ));
            }
        }
    }
    let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    Node {
        id: component.name.to_string(),
        shape: Shape::Card,
        lines,
        classes: vec!["component".to_owned()],
        description: format!(
            "component {}, {}, {}, {}",
            component.name,
            count(component.tasks.len(), "task"),
            count(component.services.len(), "service"),
            count(component.ports.len(), "port")
        ),
        origin: origin(part, component.src),
        names: vec![component.name.to_string()],
        ..Node::default()
    }
}

fn octagon(id: &str, name: &str, ty: String, unconnected: bool, origin: Option<Origin>) -> Node {
    let mut classes = vec!["port".to_owned()];
    if unconnected {
        classes.push("unconnected".to_owned());
    }
    let end = if unconnected {
        ", connected to nothing"
    } else {
        ""
    };
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
