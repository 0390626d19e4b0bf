//! What a picture shows, before anything has a place.

use dotgen_analysis::model::Src;
use serde::{Deserialize, Serialize};

/// A directed graph to draw.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Graph {
    /// Title, for `<title>` and headings.
    pub title: String,
    /// Reading direction.
    pub direction: Direction,
    /// Nodes, in the order in which they were declared (the layout keeps it where it can).
    pub nodes: Vec<Node>,
    /// Edges.
    pub edges: Vec<Edge>,
    /// Lines of text below the picture.
    pub notes: Vec<String>,
}

/// Main direction of the edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// Top to bottom.
    #[default]
    Down,
    /// Left to right.
    Right,
}

/// A node.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Node {
    /// Unique in the graph.
    pub id: String,
    /// Outline.
    pub shape: Shape,
    /// Lines of text, top to bottom.
    pub lines: Vec<Line>,
    /// Words that say what kind of node it is; the theme gives each a look.
    pub classes: Vec<String>,
    /// One sentence for tooltips and screen readers.
    pub description: String,
    /// What it stands for in the text.
    pub origin: Option<Origin>,
    /// Further names the node answers to (the states of a codel).
    pub names: Vec<String>,
    /// Which rank it stands in, counted from 0 in the reading direction. Counts only when every node has
    /// one and no edge joins two nodes of one rank; otherwise the layout ranks by the edges.
    pub column: Option<usize>,
    /// Nodes of one group and column stand together, in a frame with this name.
    pub group: Option<String>,
    /// Of nodes that can be opened and closed: which they are.
    pub open: Option<bool>,
    /// Names of what is in it, listed or not: by these it is found.
    pub holds: Vec<String>,
}

/// A place in the text of one of the specifications a picture is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub struct Origin {
    /// Which specification, counted from 0 in the order in which they were given.
    pub part: usize,
    /// The place.
    pub src: Src,
}

/// Outline of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// Rectangle with rounded corners.
    #[default]
    Box,
    /// Rectangle with a header line under the first line of text.
    Card,
    /// Double-bordered pill: where a machine ends.
    Final,
    /// Small filled disc: where a machine begins.
    Initial,
    /// Small ring: where an interrupted machine goes on.
    Interrupt,
    /// A port.
    Octagon,
    /// A pill: something that is shared.
    Pill,
}

/// One line of text in a node.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Line {
    /// The text.
    pub text: String,
    /// How it is set.
    pub style: LineStyle,
    /// What it stands for in the text, where that is not what its node stands for.
    pub origin: Option<Origin>,
}

impl Line {
    /// A line of text in a style.
    pub fn new(style: LineStyle, text: impl Into<String>) -> Line {
        Line {
            text: text.into(),
            style,
            origin: None,
        }
    }

    /// The same, standing for a place of its own.
    pub fn at(self, origin: Option<Origin>) -> Line {
        Line { origin, ..self }
    }
}

/// How a line of text is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LineStyle {
    /// The name of the node.
    Title,
    /// Code: names of functions.
    Code,
    /// Smaller, fainter.
    Detail,
}

/// A directed edge.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Edge {
    /// Id of the node it leaves.
    pub from: String,
    /// Id of the node it enters.
    pub to: String,
    /// Text on it, often none.
    pub label: String,
    /// See [`Node::classes`].
    pub classes: Vec<String>,
    /// One sentence for tooltips and screen readers.
    pub description: String,
    /// What it stands for in the text.
    pub origin: Option<Origin>,
    /// Arrow heads at both ends.
    pub both_ways: bool,
}

/// The class of what a reader follows: a way through a machine, a chain of data.
pub const MARKED: &str = "marked";

/// Adds the class, once.
fn mark(classes: &mut Vec<String>) {
    if classes.iter().all(|it| it != MARKED) {
        classes.push(MARKED.to_owned());
    }
}

impl Node {
    /// Shows that it is followed.
    pub(crate) fn mark(&mut self) {
        mark(&mut self.classes);
    }
}

impl Edge {
    /// See [`Node::mark`].
    pub(crate) fn mark(&mut self) {
        mark(&mut self.classes);
    }
}

impl Graph {
    /// Whether something needs the looks of what is marked.
    pub(crate) fn has_marks(&self) -> bool {
        let marks = |it: &String| it == MARKED || it == "contended";
        self.nodes.iter().any(|it| it.classes.iter().any(marks))
    }
}
