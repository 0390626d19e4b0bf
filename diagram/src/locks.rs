//! The codels that exclude each other, and the resources that cause it.
//!
//! Two codels that share a resource would need an edge each; ten codels of two tasks that share one,
//! twenty-five. So the resource is a node of its own, and a codel has one edge to each resource that makes it
//! wait. Codels of one task are next to each other; two of them never exclude each other.

use dotgen_analysis::model::mutex::{self, Excluded, Shared};
use dotgen_analysis::model::{
    Codel, CodelKind, CodelRef, Component, Owner, Param, ParamDir, ServiceId, Spec, Src, TaskId,
};
use rustc_hash::FxHashMap;

use crate::graph::{Direction, Edge, Graph, Line, LineStyle, Node, Origin, Shape};

/// The holder of a lock: a codel, or a client that reads or sets an attribute.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Holder {
    Codel(CodelRef),
    Attribute(ServiceId),
}

/// One use of a resource.
#[derive(Default)]
struct Use {
    reads: bool,
    writes: bool,
    src: Option<Src>,
    excluded: Vec<String>,
}

/// Builds the graph of the mutual exclusions of a component, or of those that concern one task,
/// service or its codels. Without any, it has a note only.
pub fn graph(spec: &Spec, component: &Component, of: Option<Owner>) -> Graph {
    let mut found = Exclusions { component, resources: Vec::new(), uses: FxHashMap::default() };
    for codel in component.all_codels() {
        for exclusion in mutex::exclusions(spec, component, codel) {
            let other = match exclusion.with {
                Excluded::Codel(codel) => Holder::Codel(codel),
                Excluded::Service(service) => Holder::Attribute(service),
            };
            let concerned = |owner: Owner| {
                codel.owner == owner
                    || match other {
                        Holder::Codel(other) => other.owner == owner,
                        Holder::Attribute(other) => Owner::Service(other) == owner,
                    }
            };
            if of.is_some_and(|owner| !concerned(owner)) {
                continue;
            }
            for through in &exclusion.through {
                found.add(Holder::Codel(codel), other, &through.shared, through.own);
                found.add(other, Holder::Codel(codel), &through.shared, through.other);
            }
        }
    }
    found.graph(of)
}

struct Exclusions<'a> {
    component: &'a Component,
    resources: Vec<Shared>,
    /// By holder and index of the resource.
    uses: FxHashMap<(Holder, usize), Use>,
}

impl Exclusions<'_> {
    fn add(&mut self, holder: Holder, other: Holder, shared: &Shared, param: u32) {
        let resource =
            if let Some(known) = self.resources.iter().position(|resource| resource == shared) {
                known
            } else {
                self.resources.push(shared.clone());
                self.resources.len() - 1
            };
        let component = self.component;
        let entry = self.uses.entry((holder, resource)).or_default();
        if let Some(param) = params(component, holder).get(param as usize) {
            // An attribute's direction is relative to its client: inputs are written.
            let (reads, writes) = match (param.dir, holder) {
                (ParamDir::In, Holder::Codel(_)) | (ParamDir::Out, Holder::Attribute(_)) => {
                    (true, false)
                }
                (ParamDir::Out, Holder::Codel(_)) | (ParamDir::In, Holder::Attribute(_)) => {
                    (false, true)
                }
                _ => (true, true),
            };
            entry.reads |= reads;
            entry.writes |= writes;
            entry.src.get_or_insert(param.src);
        }
        let name = holder_name(component, other);
        if !entry.excluded.contains(&name) {
            entry.excluded.push(name);
        }
    }

    fn graph(mut self, of: Option<Owner>) -> Graph {
        let component = self.component;
        let of = of.map_or(String::new(), |owner| format!(".{}", component.owner_name(owner)));
        let mut graph = Graph {
            title: format!("{}{of}: mutual exclusion", component.name),
            direction: Direction::Right,
            ..Graph::default()
        };
        if self.resources.is_empty() {
            graph.notes.push(format!("No codel of {}{of} excludes another.", component.name));
            return graph;
        }
        let mut holders: Vec<Holder> = self.uses.keys().map(|key| key.0).collect();
        // By task, so that holders that never exclude each other are next to each other; the control task
        // first.
        holders.sort_by_key(|holder| (task(component, *holder), *holder));
        holders.dedup();
        let columns = self.columns(&holders);
        for (&holder, &column) in holders.iter().zip(&columns) {
            let mut node = self.holder(holder);
            node.column = Some(column);
            node.group = Some(task_name(component, holder));
            graph.nodes.push(node);
        }
        let middles = self.middles(&holders, &columns);
        for (shared, column) in self.resources.iter().zip(middles) {
            graph.nodes.push(resource(component, shared, column));
        }
        let mut uses: Vec<_> = self.uses.drain().collect();
        uses.sort_by_key(|usage| usage.0);
        for ((holder, shared), used) in uses {
            let text = match (used.reads, used.writes) {
                (true, true) => "reads and writes",
                (_, true) => "writes",
                _ => "reads",
            };
            let codel = holder_id(component, holder);
            let resource = resource_id(component, &self.resources[shared]);
            let description = format!(
                "{} {text} {resource}: excludes {}",
                holder_name(component, holder),
                used.excluded.join(", ")
            );
            // Arrows show the direction of the data.
            let (from, to) = if used.writes { (codel, resource) } else { (resource, codel) };
            graph.edges.push(Edge {
                from,
                to,
                label: String::new(),
                classes: vec![
                    "lock".to_owned(),
                    if used.writes { "writes" } else { "reads" }.to_owned(),
                ],
                description,
                origin: used.src.map(|src| Origin { part: 0, src }),
                both_ways: used.reads && used.writes,
            });
        }
        graph
            .notes
            .push("Arrows show data: into a codel it reads, out of a codel it writes.".to_owned());
        graph.notes.push(
            "Codels of different tasks exclude each other where they meet, unless both only read the IDS."
                .to_owned(),
        );
        graph
    }

    /// The column of each of the holders, which are in order of their tasks. Even columns are for holders,
    /// odd ones for the shared resources between them. The number of columns grows with the number of
    /// holders, so that the picture stays about as wide as it is high.
    fn columns(&self, holders: &[Holder]) -> Vec<usize> {
        /// Maximum number of holders in two columns.
        const TWO_COLUMNS: usize = 30;
        let component = self.component;
        let sides = match holders.len() {
            0..=TWO_COLUMNS => 2,
            // A column of holders, with its shared resources, is about four times as wide as one holder is
            // high.
            many => (many as f64 / 4.0).sqrt().ceil() as usize,
        };
        let room = match sides {
            2 => holders.len(),
            _ => holders.len().div_ceil(sides),
        };
        // Tasks stay together, unless they have too many holders for one column.
        let mut groups: Vec<(usize, &[Holder])> = Vec::new();
        let mut first = 0;
        for group in holders.chunk_by(|a, b| task(component, *a) == task(component, *b)) {
            for part in group.chunks(room) {
                groups.push((first, part));
                first += part.len();
            }
        }
        // The largest first, each to the emptier side.
        groups.sort_by_key(|group| std::cmp::Reverse(group.1.len()));
        let mut count = vec![0; sides];
        let mut columns = vec![0; holders.len()];
        for (first, group) in groups {
            let least = (0..sides).min_by_key(|side| count[*side]).unwrap_or(0);
            count[least] += group.len();
            columns[first..first + group.len()].fill(2 * least);
        }
        columns
    }

    /// The column of each resource: between its holders, where the paths to them are shortest.
    fn middles(&self, holders: &[Holder], columns: &[usize]) -> Vec<usize> {
        let last = columns.iter().copied().max().unwrap_or(0).max(2);
        let mut taken: FxHashMap<usize, usize> = FxHashMap::default();
        let mut out = Vec::new();
        for shared in 0..self.resources.len() {
            let users = holders.iter().zip(columns);
            let users: Vec<usize> = users
                .filter(|(holder, _)| self.uses.contains_key(&(**holder, shared)))
                .map(|user| *user.1)
                .collect();
            let far = |column: usize| users.iter().map(|user| user.abs_diff(column)).sum::<usize>();
            let between = (1..last).step_by(2);
            let best = between
                .min_by_key(|column| (far(*column), taken.get(column).copied().unwrap_or(0)));
            let best = best.unwrap_or(1);
            *taken.entry(best).or_default() += 1;
            out.push(best);
        }
        out
    }

    fn holder(&self, holder: Holder) -> Node {
        let component = self.component;
        let name = holder_name(component, holder);
        let task = task_name(component, holder);
        let mut excluded: Vec<&str> = Vec::new();
        for resource in 0..self.resources.len() {
            if let Some(used) = self.uses.get(&(holder, resource)) {
                for text in &used.excluded {
                    if !excluded.contains(&text.as_str()) {
                        excluded.push(text);
                    }
                }
            }
        }
        let (what, of, src) = match holder {
            Holder::Codel(reference) => {
                let codel = component.codel(reference);
                (
                    "codel",
                    format!("{} {}", component.owner_name(reference.owner), states(codel)),
                    codel.src,
                )
            }
            Holder::Attribute(attribute) => {
                ("attribute", "attribute".to_owned(), component.services[attribute].src)
            }
        };
        Node {
            id: holder_id(component, holder),
            shape: Shape::Box,
            lines: vec![
                Line::new(LineStyle::Title, of.trim()),
                Line::new(LineStyle::Code, name.as_str()),
            ],
            classes: vec!["holder".to_owned()],
            description: format!(
                "{what} {name} of {}, {task}, excludes {}",
                of.trim(),
                excluded.join(", ")
            ),
            origin: Some(Origin { part: 0, src }),
            names: vec![name],
            ..Node::default()
        }
    }
}

fn task_name(component: &Component, holder: Holder) -> String {
    match task(component, holder) {
        Some(task) => format!("task {}", component.tasks[task].name),
        None => "control task".to_owned(),
    }
}

fn states(codel: &Codel) -> String {
    let states: Vec<&str> = codel.triggers.iter().map(|trigger| trigger.name.as_str()).collect();
    match codel.kind {
        CodelKind::Fsm => states.join(", "),
        CodelKind::Validate => "validate".to_owned(),
        CodelKind::Simple => String::new(),
    }
}

fn params(component: &Component, holder: Holder) -> &[Param] {
    match holder {
        Holder::Codel(codel) => &component.codel(codel).params,
        Holder::Attribute(attribute) => &component.services[attribute].params,
    }
}

/// The execution task; `None` for the control task.
fn task(component: &Component, holder: Holder) -> Option<TaskId> {
    match holder {
        Holder::Codel(codel) => component.task_of(codel),
        Holder::Attribute(_) => None,
    }
}

fn holder_name(component: &Component, holder: Holder) -> String {
    match holder {
        Holder::Codel(codel) => component.codel(codel).name.to_string(),
        Holder::Attribute(attribute) => component.services[attribute].name.to_string(),
    }
}

fn holder_id(component: &Component, holder: Holder) -> String {
    match holder {
        Holder::Codel(codel) => format!("{}#{}", component.owner_name(codel.owner), codel.index),
        Holder::Attribute(attribute) => component.services[attribute].name.to_string(),
    }
}

fn resource_id(component: &Component, shared: &Shared) -> String {
    match shared {
        Shared::Ids(path) if path.is_empty() => "ids".to_owned(),
        Shared::Ids(path) => format!("ids.{}", mutex::path_text(path)),
        Shared::Port(port) => component
            .ports
            .get(*port)
            .map_or_else(|| "port".to_owned(), |port| format!("port {}", port.name)),
    }
}

fn resource(component: &Component, shared: &Shared, column: usize) -> Node {
    let id = resource_id(component, shared);
    let src = match shared {
        Shared::Port(port) => component.ports.get(*port).map(|port| port.src),
        Shared::Ids(_) => None,
    };
    Node {
        shape: match shared {
            Shared::Ids(_) => Shape::Pill,
            Shared::Port(_) => Shape::Octagon,
        },
        lines: vec![Line::new(LineStyle::Title, id.as_str())],
        classes: vec![
            "resource".to_owned(),
            match shared {
                Shared::Ids(_) => "data",
                Shared::Port(_) => "port",
            }
            .to_owned(),
        ],
        description: format!("shared: {}", shared.describe(component).plain()),
        origin: src.map(|src| Origin { part: 0, src }),
        names: vec![id.clone()],
        column: Some(column),
        group: None,
        open: None,
        holds: Vec::new(),
        id,
    }
}
