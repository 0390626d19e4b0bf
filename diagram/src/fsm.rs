//! The state machine of a task or an activity.
//!
//! A node is a codel with the states that trigger it, so that a codel bound to several states is
//! drawn once. `pause::` transitions are drawn differently because they wait for the next period.

use dotgen_analysis::model::fsm;
use dotgen_analysis::model::mutex;
use dotgen_analysis::model::path::Way;
use dotgen_analysis::model::turn::Turn;
use dotgen_analysis::model::{Codel, CodelId, CodelRef, Component, Owner, Seconds, Spec, Src};
use dotgen_analysis::quantity;
use dotgen_analysis::quantity::load;
use rustc_hash::{FxHashMap, FxHashSet};
use serde::{Deserialize, Serialize};

use crate::graph::{Direction, Edge, Graph, Line, LineStyle, Node, Origin, Shape};

/// Optional content besides states, codels and transitions.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    /// Execution times.
    pub wcet: bool,
    /// The share of the period that execution times take, as a shade.
    pub load: bool,
    /// Per state, the longest sum of execution times from there to the next pause or the end.
    pub paths: bool,
    /// Per codel, the number of codels it excludes.
    pub locks: bool,
    /// States that the reader selects, in order; the longest path through them is marked.
    pub way: Vec<String>,
}

impl Default for Options {
    fn default() -> Options {
        Options { wcet: true, load: true, paths: false, locks: false, way: Vec::new() }
    }
}

/// Builds the graph of one machine. `None` when the owner has no codel with states.
pub fn graph(spec: &Spec, component: &Component, owner: Owner, options: Options) -> Option<Graph> {
    let model = fsm::Machine::new(component.codels_of(owner));
    if model.is_empty() {
        return None;
    }
    let task = match owner {
        Owner::Task(i) => Some(i),
        Owner::Service(i) => component.services[i].task,
    }
    .and_then(|i| component.tasks.get(i));
    let mut machine = Machine {
        graph: Graph {
            title: format!("{}.{}", component.name, component.owner_name(owner)),
            direction: Direction::Down,
            ..Graph::default()
        },
        node_of: FxHashMap::default(),
        reached: reached(&model),
        model: &model,
        locks: Locks { spec, component, owner },
        options,
        period: task.and_then(|task| task.period.as_ref()).map(|p| p.value),
    };
    for &(index, codel) in &model.codels {
        machine.codel(index, codel);
    }
    for &(_, codel) in &model.codels {
        machine.yields(codel);
    }
    machine.entries();
    machine.notes(owner, task);
    machine.way();
    Some(machine.graph)
}

/// States that are reached from an entry: `start`, and `stop`, which needs no transition.
fn reached<'m>(model: &fsm::Machine<'m>) -> FxHashSet<&'m str> {
    let mut reached = model.reachable("start");
    reached.extend(model.reachable("stop"));
    reached
}

/// Lookup of the exclusions of a machine's codels.
struct Locks<'a> {
    spec: &'a Spec,
    component: &'a Component,
    owner: Owner,
}

impl Locks<'_> {
    /// Names of the codels that a codel excludes, each once.
    fn of(&self, index: CodelId) -> Vec<String> {
        let codel = CodelRef { owner: self.owner, index };
        mutex::excluded_names(self.spec, self.component, codel)
    }
}

struct Machine<'a> {
    graph: Graph,
    /// State name to node id.
    node_of: FxHashMap<String, String>,
    model: &'a fsm::Machine<'a>,
    reached: FxHashSet<&'a str>,
    locks: Locks<'a>,
    options: Options,
    period: Option<Seconds>,
}

impl Machine<'_> {
    fn codel(&mut self, index: CodelId, codel: &Codel) {
        let states: Vec<String> = codel.triggers.iter().map(|s| s.name.to_string()).collect();
        let mut id = states.join("+");
        if id.is_empty() || self.graph.nodes.iter().any(|n| n.id == id) {
            id = format!("{id}#{index}");
        }
        for state in &states {
            self.node_of.entry(state.clone()).or_insert_with(|| id.clone());
        }
        let mut lines = vec![
            Line::new(LineStyle::Title, states.join(", ")),
            Line::new(
                LineStyle::Code,
                format!("{}{}", if codel.is_async { "async " } else { "" }, codel.name),
            ),
        ];
        let mut classes = vec!["state".to_owned()];
        let mut description = format!("state {}, codel {}", states.join(", "), codel.name);
        if codel.is_async {
            classes.push("async".to_owned());
            description.push_str(", asynchronous");
        }
        if let Some(wcet) = &codel.wcet {
            let (parts, heat) = self.times(wcet.value);
            classes.extend(heat);
            if self.options.wcet {
                description.push_str(&format!(", at most {}", quantity::time(wcet.value)));
            }
            if !parts.is_empty() {
                lines.push(Line::new(LineStyle::Detail, parts.join(" · ")));
            }
        }
        // The transitions of a codel do not depend on the state that triggered it.
        if self.options.paths
            && let Some(text) = states.first().and_then(|state| self.turn(state))
        {
            let of = if states.len() > 1 { "each " } else { "" };
            description.push_str(&format!(", {text}"));
            lines.push(Line::new(LineStyle::Detail, format!("{of}{text}")));
        }
        if self.options.locks {
            let excluded = self.locks.of(index);
            if !excluded.is_empty() {
                let plural = if excluded.len() == 1 { "" } else { "s" };
                lines.push(Line::new(
                    LineStyle::Detail,
                    format!("excludes {} codel{plural}", excluded.len()),
                ));
                description.push_str(&format!(", excludes {}", excluded.join(", ")));
            }
        }
        if !states.iter().any(|s| self.reached.contains(s.as_str())) {
            classes.push("unreachable".to_owned());
            let named = states.join(", ");
            let reason = if self.model.position("start").is_none() {
                "there is no state start".to_owned()
            } else {
                format!("no transition leads from start or stop to {named}")
            };
            description.push_str(&format!(", unreachable: {reason}"));
            lines.push(Line::new(LineStyle::Detail, "unreachable"));
        }
        self.graph.nodes.push(Node {
            id,
            shape: Shape::Box,
            lines,
            classes,
            description,
            origin: origin(codel.src),
            names: states,
            ..Node::default()
        });
    }

    /// The texts about an execution time, and the class of its share of the period.
    fn times(&self, wcet: Seconds) -> (Vec<String>, Option<String>) {
        let mut parts = Vec::new();
        if self.options.wcet {
            parts.push(format!("≤ {}", quantity::time(wcet)));
        }
        let period = self.period.filter(|p| self.options.load && p.numer() > &0);
        let share = period.map(|period| wcet / period);
        parts.extend(share.map(load));
        (parts, share.and_then(heat))
    }

    fn yields(&mut self, codel: &Codel) {
        let Some(from) =
            codel.triggers.first().and_then(|s| self.node_of.get(s.name.as_str())).cloned()
        else {
            return;
        };
        for state in &codel.yields {
            let to = self.target(&state.name, state.src);
            let several = self.graph.nodes.iter().any(|n| n.id == to && n.names.len() > 1);
            let label = match (state.paused, several) {
                (true, true) => format!("pause::{}", state.name),
                (true, false) => "pause".to_owned(),
                (false, true) => state.name.to_string(),
                (false, false) => String::new(),
            };
            let wait = if state.paused { " at the next period" } else { "" };
            let description = format!("{} yields {}{wait}", codel.name, state.name);
            let mut classes = vec!["transition".to_owned()];
            if state.paused {
                classes.push("paused".to_owned());
            }
            self.graph.edges.push(Edge {
                from: from.clone(),
                to,
                label,
                classes,
                description,
                origin: origin(state.src),
                both_ways: false,
            });
        }
    }

    /// The node of a state, created if no codel has the state: the end, or an undefined state.
    fn target(&mut self, state: &str, src: Src) -> String {
        if let Some(id) = self.node_of.get(state) {
            return id.clone();
        }
        let end = state == "ether";
        self.node_of.insert(state.to_owned(), state.to_owned());
        self.graph.nodes.push(Node {
            id: state.to_owned(),
            shape: if end { Shape::Final } else { Shape::Box },
            lines: if end {
                vec![Line::new(LineStyle::Title, state)]
            } else {
                vec![Line::new(LineStyle::Title, state), Line::new(LineStyle::Detail, "no codel")]
            },
            classes: vec![if end { "end" } else { "undefined" }.to_owned()],
            description: if end {
                "ether: the machine ends".to_owned()
            } else {
                format!("state {state} has no codel")
            },
            origin: origin(src),
            names: vec![state.to_owned()],
            ..Node::default()
        });
        state.to_owned()
    }

    /// The description of the longest turn from a state.
    fn turn(&self, state: &str) -> Option<String> {
        Some(match self.model.longest_turn(state)? {
            Turn::Bounded { sum, incomplete, .. } => {
                let open = if incomplete { " + unknown" } else { "" };
                format!("Σ ≤ {}{open} to pause or end", quantity::time(sum))
            }
            Turn::Unbounded { .. } => "Σ unbounded: a cycle without pause".to_owned(),
        })
    }

    /// Marks the longest path through the selected states and adds its length.
    fn way(&mut self) {
        let way = self.options.way.clone();
        let named: Vec<&str> = way.iter().map(String::as_str).collect();
        for state in &named {
            if let Some(id) = self.node_of.get(*state).cloned() {
                self.graph.nodes.iter_mut().for_each(|node| {
                    if node.id == id {
                        node.mark();
                    }
                });
            }
        }
        let Some(found) = self.model.way(&named) else {
            return;
        };
        if let Way::Longest { states, .. } = &found {
            for pair in states.windows(2) {
                let ends = (self.node_of.get(&pair[0]), self.node_of.get(&pair[1]));
                let (Some(from), Some(to)) = ends else {
                    continue;
                };
                let several =
                    self.graph.nodes.iter().any(|node| node.id == *to && node.names.len() > 1);
                let mut edges = self.graph.edges.iter_mut();
                let step = edges.find(|edge| {
                    edge.from == *from
                        && edge.to == *to
                        && (!several || edge.label.ends_with(&pair[1]))
                });
                if let Some(step) = step {
                    step.mark();
                }
                let (from, to) = (from.clone(), to.clone());
                for node in &mut self.graph.nodes {
                    if node.id == from || node.id == to {
                        node.mark();
                    }
                }
            }
        }
        self.graph.notes.push(in_words(&named, &found));
    }

    /// The text below the picture.
    fn notes(&mut self, owner: Owner, task: Option<&dotgen_analysis::model::Task>) {
        let Locks { spec, component, .. } = self.locks;
        if let (Owner::Service(_), Some(task)) = (owner, task) {
            let rate = match &task.period {
                Some(period) => format!("every {}", quantity::time(period.value)),
                None => "aperiodic".to_owned(),
            };
            self.graph.notes.push(format!("task {}, {rate}", task.name));
        } else if let Some(period) = self.period {
            self.graph.notes.push(format!("every {}", quantity::time(period)));
        }
        let mut thrown: Vec<&str> = Vec::new();
        let service = match owner {
            Owner::Service(i) => component.services[i].throws.as_slice(),
            Owner::Task(_) => &[],
        };
        let of_task = task.map_or(&[][..], |task| &task.throws);
        for &id in component.throws.iter().chain(of_task).chain(service) {
            let name = spec.ty(id).name.as_deref().unwrap_or_default();
            if !name.is_empty() && !thrown.contains(&name) {
                thrown.push(name);
            }
        }
        if !thrown.is_empty() {
            self.graph.notes.push(format!("may throw {}", thrown.join(", ")));
        }
    }

    /// Adds the entries of the machine: its start and its reaction to an interrupt.
    fn entries(&mut self) {
        let entries = [
            ("start", "(entry)", Shape::Initial, "", "the machine begins here"),
            (
                "stop",
                "(interrupt)",
                Shape::Interrupt,
                "interrupted",
                "an interrupted machine goes on here",
            ),
        ];
        for (state, id, shape, label, description) in entries {
            let Some(to) = self.node_of.get(state).cloned() else {
                continue;
            };
            self.graph.nodes.push(Node {
                id: id.to_owned(),
                shape,
                classes: vec!["marker".to_owned()],
                description: description.to_owned(),
                ..Node::default()
            });
            self.graph.edges.push(Edge {
                from: id.to_owned(),
                to,
                label: label.to_owned(),
                classes: vec![
                    "entry".to_owned(),
                    if shape == Shape::Interrupt { "interrupt" } else { "begin" }.to_owned(),
                ],
                description: description.to_owned(),
                ..Edge::default()
            });
        }
        // Markers come first, so that the tab key reaches the entry first.
        let markers = self.graph.nodes.iter().filter(|n| n.classes == ["marker"]).count();
        self.graph.nodes.rotate_right(markers);
    }
}

fn origin(src: Src) -> Option<Origin> {
    Some(Origin { part: 0, src })
}

/// The shade for a share of the period: none below 5 %, five steps up to the whole period.
fn heat(share: Seconds) -> Option<String> {
    let share = *share.numer() as f64 / *share.denom() as f64;
    let level = match share {
        s if s < 0.05 => return None,
        s if s < 0.15 => 1,
        s if s < 0.3 => 2,
        s if s < 0.6 => 3,
        s if s < 1.0 => 4,
        _ => 5,
    };
    Some(format!("heat-{level}"))
}

/// A path in one line: `start → level: at most 3 ms of execution`.
fn in_words(named: &[&str], way: &Way) -> String {
    let named = named.join(" → ");
    match way {
        Way::Longest { time, pauses, incomplete, .. } => {
            let open = if *incomplete { ", + unknown" } else { "" };
            let pauses = match pauses {
                0 => String::new(),
                1 => ", 1 pause".to_owned(),
                n => format!(", {n} pauses"),
            };
            format!("{named}: at most {} of execution{open}{pauses}", quantity::time(*time))
        }
        Way::Endless { cycle } => {
            let cycle = cycle.join(" → ");
            format!("{named}: no longest time, it can go round {cycle}")
        }
        Way::Broken { from, to } => format!("{named}: no way leads from {from} to {to}"),
    }
}
