//! Pictures of units, for the editor and the command line.

use std::collections::BTreeMap;

use dotgen_analysis::host::UnitResult;
use dotgen_analysis::model::mutex::{self, Excluded};
use dotgen_analysis::model::system::parts;
use dotgen_analysis::model::{CodelRef, Component, ComponentKind, Owner, Spec, Src};
use dotgen_analysis::quantity;
use dotgen_analysis::source_map::{Location, Locations};
use dotgen_diagram::graph::{Graph, Origin};
use dotgen_diagram::layout::{Layout, Point, layout, layout_within, moved};
use dotgen_diagram::render::{dot::dot, mermaid::mermaid, svg::svg};
use dotgen_diagram::system::{self, Chain, Connection};
use dotgen_diagram::theme::Theme;
use dotgen_diagram::{fsm, locks};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Kinds of picture.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, clap::ValueEnum,
)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// State machine of a task or activity
    #[default]
    Fsm,
    /// Components, ports, and the data between them
    System,
    /// Codels that exclude each other, and the data they lock
    Locks,
}

/// Text forms of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// Scalable Vector Graphics.
    #[default]
    Svg,
    /// Graphviz.
    Dot,
    /// Mermaid flow chart.
    Mermaid,
}

/// The subject and contents of a picture.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct PictureRequest {
    /// Kind of picture.
    pub kind: Kind,
    /// The component; by default the first one with such a picture.
    pub component: Option<String>,
    /// The task or activity.
    pub owner: Option<String>,
    /// State machines: execution times.
    pub wcet: bool,
    /// State machines: their share of the period.
    pub load: bool,
    /// State machines: sums of execution times up to the next pause.
    pub paths: bool,
    /// State machines: the number of codels that each codel excludes. Systems: the codels that exclude each
    /// other at a port.
    pub locks: bool,
    /// State machines: states of a path. The longest path through them is marked and described.
    pub way: Vec<String>,
    /// Systems: maximum number of services listed in a component.
    pub services: usize,
    /// Systems: interruptions between services.
    pub interrupts: bool,
    /// Systems: the cause-effect chains in scenarios.
    pub chains: bool,
    /// Systems: components that the user expanded or collapsed.
    pub opened: BTreeMap<String, bool>,
    /// Systems: offsets of moved nodes from their layout, to the right and down, in pixels. A port moves with
    /// its component.
    pub moved: BTreeMap<String, (i32, i32)>,
    /// Systems: width of the pane, in pixels. A picture that is wider, with letters of 9 pixels, is drawn
    /// from top to bottom in rows of that width.
    pub width: Option<u32>,
}

/// Facts about a system that are not in its specifications.
#[derive(Debug, Clone, Default)]
pub struct SystemContext {
    /// Connections from output ports to input ports.
    pub connections: Vec<Connection>,
    /// Cause-effect chains to draw.
    pub chains: Vec<Chain>,
}

impl Default for PictureRequest {
    fn default() -> PictureRequest {
        PictureRequest {
            kind: Kind::Fsm,
            component: None,
            owner: None,
            wcet: true,
            load: true,
            paths: false,
            locks: false,
            way: Vec::new(),
            services: 6,
            interrupts: false,
            chains: false,
            opened: BTreeMap::new(),
            moved: BTreeMap::new(),
            width: None,
        }
    }
}

/// A picture with its layout.
pub struct Picture {
    /// Nodes and edges.
    pub graph: Graph,
    /// Their places.
    pub layout: Layout,
    /// The component, for pictures of one.
    pub component: Option<String>,
    /// The task or activity, for pictures of one.
    pub owner: Option<String>,
}

impl Picture {
    /// The picture as text.
    pub fn text(&self, form: Form, theme: Theme) -> String {
        match form {
            Form::Svg => svg(&self.graph, &self.layout, theme),
            Form::Dot => dot(&self.graph),
            Form::Mermaid => mermaid(&self.graph),
        }
    }
}

/// Draws every picture that matches a wish: all machines if no owner is named, one picture of all units for a
/// system, one of each component for locks.
pub fn draw(units: &[UnitResult], around: &SystemContext, wish: &PictureRequest) -> Vec<Picture> {
    if wish.kind == Kind::System {
        return system_picture(units, around, wish).into_iter().collect();
    }
    let mut out = Vec::new();
    for (unit, component) in components(units, wish.component.as_deref()) {
        match (wish.kind, &wish.owner) {
            (Kind::Locks, owner) => {
                let named = owner.as_ref().and_then(|owner| find_owner(component, owner));
                if owner.is_some() && named.is_none() {
                    continue;
                }
                let graph = locks::graph(&unit.spec, component, named);
                out.push(picture(graph, Some(component), owner.clone()));
            }
            (_, owner) => {
                for found in component.machines() {
                    let name = component.owner_name(found);
                    if owner.as_ref().is_some_and(|owner| owner != name) {
                        continue;
                    }
                    let options = fsm::Options {
                        wcet: wish.wcet,
                        load: wish.load,
                        paths: wish.paths,
                        locks: wish.locks,
                        way: wish.way.clone(),
                    };
                    let graph = fsm::graph(&unit.spec, component, found, options);
                    let name = Some(name.to_string());
                    out.extend(graph.map(|graph| picture(graph, Some(component), name)));
                }
            }
        }
    }
    out
}

fn picture(graph: Graph, component: Option<&Component>, owner: Option<String>) -> Picture {
    Picture {
        layout: layout(&graph),
        graph,
        component: component.map(|component| component.name.to_string()),
        owner,
    }
}

fn system_picture(
    units: &[UnitResult],
    around: &SystemContext,
    wish: &PictureRequest,
) -> Option<Picture> {
    let parts = parts(units.iter().map(|unit| &*unit.spec));
    if parts.is_empty() {
        return None;
    }
    let options = system::Options {
        title: match parts.as_slice() {
            [one] => one.component.name.to_string(),
            several => format!("System of {} components", several.len()),
        },
        connections: around.connections.clone(),
        services: wish.services,
        interrupts: wish.interrupts,
        locks: wish.locks,
        opened: wish.opened.clone(),
        chains: if wish.chains { around.chains.clone() } else { Vec::new() },
    };
    let graph = system::graph(&parts, &options);
    let mut drawn = Picture {
        layout: match wish.width {
            Some(pane) => layout_within(&graph, f64::from(pane)),
            None => layout(&graph),
        },
        graph,
        component: None,
        owner: None,
    };
    let by = |id: &str| wish.moved.get(id).copied().unwrap_or_default();
    let nodes = drawn.graph.nodes.iter();
    let moves: Vec<Point> = nodes
        .map(|node| {
            let own = by(&node.id);
            let with = node.id.split_once('.').map_or((0, 0), |(of, _)| by(of));
            Point {
                x: f64::from(own.0) + f64::from(with.0),
                y: f64::from(own.1) + f64::from(with.1),
            }
        })
        .collect();
    drawn.layout = moved(&drawn.graph, drawn.layout, &moves);
    Some(drawn)
}

/// Components of the units, or those of one name.
fn components<'u>(
    units: &'u [UnitResult],
    name: Option<&'u str>,
) -> impl Iterator<Item = (&'u UnitResult, &'u Component)> {
    units.iter().flat_map(move |unit| {
        let components = unit.spec.components.iter();
        components
            .filter(move |component| {
                component.kind == ComponentKind::Component
                    && name.is_none_or(|name| component.name == name)
            })
            .map(move |component| (unit, component))
    })
}

/// The task or service of a name.
fn find_owner(component: &Component, name: &str) -> Option<Owner> {
    let tasks = component.tasks.position(|task| task.name == name);
    let services = || component.services.position(|service| service.name == name);
    match tasks {
        Some(task) => Some(Owner::Task(task)),
        None => services().map(Owner::Service),
    }
}

/// Nodes and edges as plain data. `place` returns the place of a declaration.
pub fn data(
    units: &[UnitResult],
    picture: &Picture,
    place: &dyn Fn(&Location) -> Option<Value>,
) -> (Value, Value) {
    let located = |origin: Option<Origin>| {
        let origin = origin?;
        let location = units.get(origin.part)?.locations.locate(origin.src)?;
        place(&location)
    };
    let graph = &picture.graph;
    let nodes: Vec<Value> = graph
        .nodes
        .iter()
        .map(|node| {
            let lines: Vec<&str> = node.lines.iter().map(|line| line.text.as_str()).collect();
            let parts: Vec<Option<Value>> =
                node.lines.iter().map(|line| located(line.origin)).collect();
            let detail = node.origin.and_then(|origin| {
                let unit = units.get(origin.part)?;
                codel_details(&unit.spec, picture.component.as_deref(), origin.src)
            });
            json!({
                "id": node.id,
                "names": node.names,
                "lines": lines,
                "classes": node.classes,
                "description": node.description,
                "place": located(node.origin),
                "parts": parts,
                "open": node.open,
                "holds": node.holds,
                "codel": detail,
            })
        })
        .collect();
    let edges: Vec<Value> = graph
        .edges
        .iter()
        .map(|edge| {
            json!({
                "from": edge.from,
                "to": edge.to,
                "label": edge.label,
                "classes": edge.classes,
                "description": edge.description,
                "place": located(edge.origin),
            })
        })
        .collect();
    (nodes.into(), edges.into())
}

/// The facts about the codel at a place.
fn codel_details(spec: &Spec, component: Option<&str>, src: Src) -> Option<Value> {
    let component =
        spec.components.iter().find(|candidate| Some(candidate.name.as_str()) == component)?;
    let found = component.all_codels().find(|codel| component.codel(*codel).src == src)?;
    let codel = component.codel(found);
    let params: Vec<String> = codel
        .params
        .iter()
        .map(|param| {
            let direction = param.dir.word();
            let source = param.source.word();
            format!("{direction} {source} {}", param.name)
        })
        .collect();
    let states: Vec<&str> = codel.triggers.iter().map(|trigger| trigger.name.as_str()).collect();
    Some(json!({
        "name": codel.name,
        "states": states,
        "async": codel.is_async,
        "params": params,
        "wcet": codel.wcet.as_ref().map(|wcet| quantity::time(wcet.value)),
        "excludes": excluded(spec, component, found),
    }))
}

/// The names of the excluded codels and tasks, with the reason.
fn excluded(spec: &Spec, component: &Component, codel: CodelRef) -> Vec<String> {
    let exclusions = mutex::exclusions(spec, component, codel).into_iter();
    exclusions
        .map(|exclusion| {
            let name = match exclusion.with {
                Excluded::Codel(codel) => &component.codel(codel).name,
                Excluded::Service(service) => &component.services[service].name,
            };
            let mut through: Vec<String> = Vec::new();
            for one in &exclusion.through {
                let text = one.shared.describe(component).plain();
                if !through.contains(&text) {
                    through.push(text);
                }
            }
            format!("{name} (through {})", through.join(", "))
        })
        .collect()
}

/// The state machine of a task or activity, for a template; see [`dotgen_codegen::command::Pictures`].
pub fn machine(spec: &Spec, component: &str, owner: &str, form: &str) -> Result<String, String> {
    let form = Form::deserialize(serde_json::Value::from(form))
        .map_err(|_| format!("no form {form} of pictures: it is svg, mermaid or dot"))?;
    let found = spec.components.iter().find(|candidate| candidate.name.as_str() == component);
    let graph = found.and_then(|component| {
        let owner = component
            .machines()
            .find(|machine| component.owner_name(*machine).as_str() == owner)?;
        fsm::graph(spec, component, owner, fsm::Options::default())
    });
    Ok(graph.map_or_else(String::new, |graph| match form {
        Form::Svg => svg(&graph, &layout(&graph), Theme::Light),
        Form::Mermaid => mermaid(&graph),
        Form::Dot => dot(&graph),
    }))
}
