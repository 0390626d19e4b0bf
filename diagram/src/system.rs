//! Components, their ports, and the data that flows between them.
//!
//! A component is a card with its tasks and services, a port an octagon beside it; data flows from
//! the writer through the port to every reader.

pub use dotgen_analysis::model::system::{Connection, Part};
use dotgen_analysis::model::system::{System, type_name};
use dotgen_analysis::model::{PortDir, Src};

use crate::fsm::duration;
use crate::graph::{Direction, Edge, Graph, Line, LineStyle, Node, Origin, Shape};

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
    let system = System::new(parts.iter().copied(), &options.connections);
    let parts = &system.parts;
    let mut graph = Graph {
        title: options.title.clone(),
        direction: Direction::Right,
        ..Graph::default()
    };
    for part in parts {
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
    for (number, part) in parts.iter().enumerate() {
        let name = &part.component.name;
        let inputs = (0..).zip(&part.component.ports);
        for (index, port) in inputs.filter(|it| it.1.dir == PortDir::In) {
            let sources = system.sources((number, index));
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
                let component = parts[component].component;
                let source = &component.ports[source as usize].name;
                let component = &component.name;
                let id = format!("{component}.{source}");
                let mut edge = flow(
                    &id,
                    name,
                    format!("{name} reads {component}.{source} as {}", port.name),
                );
                if *source != port.name {
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

fn origin(part: &Part, src: Src) -> Option<Origin> {
    Some(Origin {
        part: part.number,
        src,
    })
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
