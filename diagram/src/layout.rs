//! Computes the place of every node, edge and label of a graph.
//!
//! The classic layered method (Sugiyama, Tagawa and Toda 1981), one module a step: make the graph acyclic,
//! give nodes ranks, split long edges, order each rank to avoid crossings, assign coordinates. Edge labels
//! and self loops are part of the problem, not an afterthought: a label is a node of a rank between its ends,
//! a loop is part of the width of its node. Edges run straight through the ranks they cross and bend only
//! between ranks, so they never pass behind a node.
//!
//! The method works top to bottom; for pictures that read left to right, x and y are exchanged.

mod acyclic;
mod moved;
mod order;
mod position;
mod rank;
mod ranked;
mod route;
mod rows;
mod size;

use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use crate::graph::{Direction, Graph};
use crate::text;

pub use moved::moved;
pub use size::{CARD_HEADER, LINE_PADDING, octagon};

/// A point, in pixels, y downwards.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Point {
    /// To the right.
    pub x: f64,
    /// Down.
    pub y: f64,
}

impl Point {
    fn transposed(self) -> Point {
        Point { x: self.y, y: self.x }
    }
}

/// An axis-parallel rectangle, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Rect {
    /// Left.
    pub x: f64,
    /// Top.
    pub y: f64,
    pub width: f64,
    pub height: f64,
}

impl Rect {
    /// A rectangle around a centre.
    pub(crate) fn centered(center: Point, width: f64, height: f64) -> Rect {
        Rect { x: center.x - width / 2.0, y: center.y - height / 2.0, width, height }
    }

    /// The centre of the rectangle.
    pub(crate) fn center(self) -> Point {
        Point { x: self.x + self.width / 2.0, y: self.y + self.height / 2.0 }
    }

    /// The smallest rectangle around two.
    pub fn union(self, other: Rect) -> Rect {
        let (x, y) = (self.x.min(other.x), self.y.min(other.y));
        Rect {
            x,
            y,
            width: (self.x + self.width).max(other.x + other.width) - x,
            height: (self.y + self.height).max(other.y + other.height) - y,
        }
    }

    /// Returns true if two rectangles share more than a border.
    pub fn overlaps(self, other: Rect) -> bool {
        const SLACK: f64 = 0.01;
        self.x + self.width > other.x + SLACK
            && other.x + other.width > self.x + SLACK
            && self.y + self.height > other.y + SLACK
            && other.y + other.height > self.y + SLACK
    }

    /// Returns true if this rectangle lies inside another.
    pub fn inside(self, outer: Rect) -> bool {
        self.x >= outer.x
            && self.y >= outer.y
            && self.x + self.width <= outer.x + outer.width
            && self.y + self.height <= outer.y + outer.height
    }

    fn transposed(self) -> Rect {
        Rect { x: self.y, y: self.x, width: self.height, height: self.width }
    }
}

/// The places of all elements of a graph, in pixels. Indexes are those of the graph.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Layout {
    /// Width of the picture.
    pub width: f64,
    /// Height of the picture, notes included.
    pub height: f64,
    /// Outline of each node.
    pub nodes: Vec<Rect>,
    pub edges: Vec<EdgePath>,
    /// Frames round groups of nodes.
    pub frames: Vec<Frame>,
    /// Top left corner of each note.
    pub notes: Vec<Point>,
}

/// The frame round a group of nodes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Frame {
    /// The text at the top of the frame, inside.
    pub name: String,
    /// The outline.
    pub rect: Rect,
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct EdgePath {
    /// A chain of cubic Bézier curves: the first point, then three points for each curve. Empty for an
    /// edge to a node that does not exist.
    pub points: Vec<Point>,
    /// Box of its label, if it has one.
    pub label: Option<Rect>,
}

impl EdgePath {
    /// Exchanges x and y.
    fn transposed(self) -> EdgePath {
        EdgePath {
            points: self.points.into_iter().map(Point::transposed).collect(),
            label: self.label.map(Rect::transposed),
        }
    }
}

/// Space between a frame and the nodes in it, in pixels.
const FRAME_PADDING: f64 = 8.0;
/// Height of the name of a frame, in pixels.
pub const LABEL_HEIGHT: f64 = 20.0;

/// Space around the drawing, in pixels.
const MARGIN: f64 = 12.0;

/// Least size of letters on a screen, in pixels.
const LEAST_LETTER: f64 = 9.0;

/// Maximum number of nodes of a graph that is drawn in rows: in larger ones the edges need most of the width.
const MOST_IN_ROWS: usize = 300;

/// Places a graph in a pane of a width in pixels. A graph that reads from left to right and is so wide that
/// its letters would be smaller than 9 pixels is turned, to read from top to bottom in rows of that width, if
/// it is not too large for that. The pane scrolls downwards.
pub fn layout_within(graph: &Graph, pane: f64) -> Layout {
    let sideways = layout(graph);
    // The width of the picture at which its smallest letters have the least size.
    let most = pane * text::LABEL.size / LEAST_LETTER;
    let large = graph.nodes.len() > MOST_IN_ROWS;
    if graph.direction != Direction::Right || sideways.width <= most || large {
        return sideways;
    }
    // Passing edges need space as well, which is known only after the layout.
    for share in [1.0, 0.8, 0.6, 0.45, 0.3] {
        let place = place(graph, Direction::Down, Some(share * most));
        if place.width <= most {
            return place;
        }
    }
    sideways
}

/// Places a graph. Deterministic and total: edges to unknown nodes are left out.
pub fn layout(graph: &Graph) -> Layout {
    place(graph, graph.direction, None)
}

/// Places a graph in a direction, with ranks of at most a width in pixels.
fn place(graph: &Graph, direction: Direction, within: Option<f64>) -> Layout {
    let sideways = direction == Direction::Right;
    let turn = |(w, h): (f64, f64)| if sideways { (h, w) } else { (w, h) };
    let labels: Vec<(f64, f64)> =
        graph.edges.iter().map(|e| turn(size::label_size(&e.label))).collect();
    let index: FxHashMap<&str, usize> =
        graph.nodes.iter().enumerate().map(|(i, node)| (node.id.as_str(), i)).collect();
    let ends: Vec<Option<(usize, usize)>> = graph
        .edges
        .iter()
        .map(|e| Some((*index.get(e.from.as_str())?, *index.get(e.to.as_str())?)))
        .collect();
    let boxes: Vec<(f64, f64)> = size::node_sizes(graph, &ends).into_iter().map(turn).collect();
    let loops = size::Loops::of(&ends, &labels);

    let mut ranked = ranked::RankedGraph::new(graph, &ends, &boxes, &labels, &loops, within);
    order::order(&mut ranked);
    let mut places = position::positions(&ranked, if sideways { 18.0 } else { 26.0 });
    position::pack_groups(&ranked, 14.0, &mut places);
    // Columns are joined by many edges, which need space to fan out.
    let gap = match (ranked.columns, sideways) {
        (true, _) => 80.0,
        (_, true) => 25.0,
        (_, false) => 24.0,
    };
    let tops = route::rank_bands(&ranked, gap);

    let nodes: Vec<Rect> = boxes
        .iter()
        .enumerate()
        .map(|(i, &(w, h))| {
            Rect::centered(Point { x: places[i], y: tops.middle(ranked.rank[i]) }, w, h)
        })
        .collect();
    let mut edges = route::edges(&ranked, &places, &tops, &nodes, &labels);
    for (i, end) in ends.iter().enumerate() {
        if let Some((from, to)) = end
            && from == to
        {
            edges[i] = loops.path(i, nodes[*from], labels[i]);
        }
    }
    let mut placed = Layout { nodes, edges, ..Layout::default() };
    if sideways {
        placed.nodes = placed.nodes.into_iter().map(Rect::transposed).collect();
        placed.edges = placed.edges.into_iter().map(EdgePath::transposed).collect();
    }
    finish(graph, placed)
}

/// A frame round the nodes of each group and column, wide enough for its name.
fn frames(graph: &Graph, nodes: &[Rect]) -> Vec<Frame> {
    let mut frames: Vec<Frame> = Vec::new();
    let mut columns: Vec<Option<usize>> = Vec::new();
    for (node, rect) in graph.nodes.iter().zip(nodes) {
        let Some(name) = &node.group else { continue };
        let mut known = frames.iter_mut().zip(&columns);
        if let Some((frame, _)) =
            known.find(|(frame, column)| frame.name == *name && **column == node.column)
        {
            frame.rect = frame.rect.union(*rect);
        } else {
            columns.push(node.column);
            frames.push(Frame { name: name.clone(), rect: *rect });
        }
    }
    for Frame { name, rect } in &mut frames {
        let least = text::width(name, text::LABEL) - rect.width;
        let aside = FRAME_PADDING.max(least / 2.0 + 2.0);
        *rect = Rect {
            x: rect.x - aside,
            y: rect.y - LABEL_HEIGHT,
            width: rect.width + 2.0 * aside,
            height: rect.height + LABEL_HEIGHT + FRAME_PADDING,
        };
    }
    frames
}

/// The corners of the smallest rectangle around everything that is drawn.
fn bounds(layout: &Layout) -> (Point, Point) {
    if layout.nodes.is_empty() {
        return (Point::default(), Point::default());
    }
    let mut low = Point { x: f64::MAX, y: f64::MAX };
    let mut high = Point { x: f64::MIN, y: f64::MIN };
    let mut see = |p: Point| {
        low = Point { x: low.x.min(p.x), y: low.y.min(p.y) };
        high = Point { x: high.x.max(p.x), y: high.y.max(p.y) };
    };
    let rects = layout
        .nodes
        .iter()
        .chain(layout.frames.iter().map(|frame| &frame.rect))
        .chain(layout.edges.iter().filter_map(|e| e.label.as_ref()));
    for rect in rects {
        see(Point { x: rect.x, y: rect.y });
        see(Point { x: rect.x + rect.width, y: rect.y + rect.height });
    }
    // A Bézier curve stays inside the hull of its control points.
    layout.edges.iter().flat_map(|e| &e.points).copied().for_each(&mut see);
    (low, high)
}

/// Draws the frames, moves everything to positive coordinates, measures the picture, and adds the notes.
fn finish(graph: &Graph, mut layout: Layout) -> Layout {
    layout.frames = frames(graph, &layout.nodes);
    layout.notes.clear();
    let (low, high) = bounds(&layout);
    let (dx, dy) = (MARGIN - low.x, MARGIN - low.y);
    let round = |v: f64| (v * 10.0).round() / 10.0;
    for rect in layout
        .nodes
        .iter_mut()
        .chain(layout.frames.iter_mut().map(|frame| &mut frame.rect))
        .chain(layout.edges.iter_mut().filter_map(|e| e.label.as_mut()))
    {
        (rect.x, rect.y) = (round(rect.x + dx), round(rect.y + dy));
        (rect.width, rect.height) = (round(rect.width), round(rect.height));
    }
    for point in layout.edges.iter_mut().flat_map(|e| &mut e.points) {
        *point = Point { x: round(point.x + dx), y: round(point.y + dy) };
    }
    layout.width = high.x - low.x + 2.0 * MARGIN;
    layout.height = high.y - low.y + 2.0 * MARGIN;
    for note in &graph.notes {
        layout.notes.push(Point { x: MARGIN, y: round(layout.height) });
        layout.width = layout.width.max(text::width(note, text::NOTE) + 2.0 * MARGIN);
        layout.height += text::NOTE.height;
    }
    if !graph.notes.is_empty() {
        layout.height += MARGIN / 2.0;
    }
    (layout.width, layout.height) = (layout.width.ceil(), layout.height.ceil());
    layout
}
