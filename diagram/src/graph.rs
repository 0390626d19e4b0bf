//! The content of a picture, before layout.

use dotgen_analysis::model::Src;
use serde::{Deserialize, Serialize};

/// A directed graph to draw.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Graph {
    /// Title, for `<title>` and headings.
    pub title: String,
    /// Reading direction.
    pub direction: Direction,
    /// Nodes, in order of declaration (the layout keeps the order if possible).
    pub nodes: Vec<Node>,
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

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Node {
    /// Unique in the graph.
    pub id: String,
    /// Outline.
    pub shape: Shape,
    /// Lines of text, top to bottom.
    pub lines: Vec<Line>,
    /// Words for the kind of node; the theme styles each.
    pub classes: Vec<String>,
    /// One sentence for tooltips and screen readers.
    pub description: String,
    /// The declaration it stands for in the text.
    pub origin: Option<Origin>,
    /// Further names the node answers to (the states of a codel).
    pub names: Vec<String>,
    /// The rank, counted from 0 in the reading direction. It is used only if every node has one and no edge
    /// joins two nodes of one rank; otherwise the layout derives ranks from the edges.
    pub column: Option<usize>,
    /// The group. Nodes of one group and column are next to each other, in a frame with this name.
    pub group: Option<String>,
    /// For a node that can be opened and closed: true if it is open.
    pub open: Option<bool>,
    /// Names of its content, listed or not, for search.
    pub holds: Vec<String>,
}

/// A place in the text of one of the specifications a picture is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub struct Origin {
    /// Index of the specification, from 0 in the order in which they were given.
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
    /// Double-bordered pill: the end of a machine.
    Final,
    /// Small filled disc: the start of a machine.
    Initial,
    /// Small ring: the entry of an interrupted machine.
    Interrupt,
    /// A port.
    Octagon,
    /// A pill: a shared resource.
    Pill,
}

/// One line of text in a node.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Line {
    pub text: String,
    /// The style of the text.
    pub style: LineStyle,
    /// The declaration it stands for in the text, if it differs from the node's.
    pub origin: Option<Origin>,
}

impl Line {
    pub fn new(style: LineStyle, text: impl Into<String>) -> Line {
        Line { text: text.into(), style, origin: None }
    }

    /// The line with an origin of its own.
    pub fn at(self, origin: Option<Origin>) -> Line {
        Line { origin, ..self }
    }
}

/// The styles of a line of text.
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
    /// The declaration it stands for in the text.
    pub origin: Option<Origin>,
    /// Arrow heads at both ends.
    pub both_ways: bool,
}

/// The class of elements that a reader follows: a path through a machine, a chain of data.
pub const MARKED: &str = "marked";

/// Adds the class, once.
fn mark(classes: &mut Vec<String>) {
    if classes.iter().all(|class| class != MARKED) {
        classes.push(MARKED.to_owned());
    }
}

impl Node {
    /// Marks the node as followed.
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
    /// Returns true if a node or edge is marked.
    pub(crate) fn has_marks(&self) -> bool {
        let marks = |text: &String| text == MARKED || text == "contended";
        self.nodes.iter().any(|node| node.classes.iter().any(marks))
    }
}
