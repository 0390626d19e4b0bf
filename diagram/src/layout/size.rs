//! The space that nodes, labels and self loops need.

use rustc_hash::FxHashMap;

use crate::graph::{Graph, Node, Shape};
use crate::text;

use super::{EdgePath, Point, Rect};

/// Extent of a self loop beyond its node, in pixels.
const LOOP_REACH: f64 = 22.0;
/// Space between a loop and its label, in pixels.
const LABEL_GAP: f64 = 2.0;

/// Space between the text of a node and its outline, horizontal and vertical, in pixels.
pub const LINE_PADDING: (f64, f64) = (12.0, 7.0);
/// Additional space between the first line of a card and the rest, in pixels.
pub const CARD_HEADER: f64 = 7.0;

/// Width and height of all nodes, in pixels. Nodes of one column have equal widths and are high enough for
/// their edges.
pub(super) fn node_sizes(graph: &Graph, ends: &[Option<(usize, usize)>]) -> Vec<(f64, f64)> {
    /// Height that an edge takes at a node of a column, in pixels.
    const EDGE: f64 = 10.0;
    let mut sizes: Vec<(f64, f64)> = graph.nodes.iter().map(node_size).collect();
    let column = |node: usize| graph.nodes[node].column;
    let mut widest: FxHashMap<usize, f64> = FxHashMap::default();
    for (node, size) in sizes.iter().enumerate() {
        if let Some(column) = column(node) {
            let widest = widest.entry(column).or_default();
            *widest = widest.max(size.0);
        }
    }
    // Edges on the side of lower and of higher columns.
    let mut sides = vec![[0_usize; 2]; sizes.len()];
    for &(from, to) in ends.iter().flatten() {
        sides[from][usize::from(column(from) < column(to))] += 1;
        sides[to][usize::from(column(to) < column(from))] += 1;
    }
    for (node, size) in sizes.iter_mut().enumerate() {
        if let Some(widest) = column(node).and_then(|column| widest.get(&column)) {
            let edges = sides[node].into_iter().max().unwrap_or(0);
            *size = (*widest, size.1.max(EDGE * edges as f64 + 16.0));
        }
    }
    sizes
}

/// Width and height of a node, in pixels.
fn node_size(node: &Node) -> (f64, f64) {
    match node.shape {
        Shape::Initial => return (14.0, 14.0),
        Shape::Interrupt => return (14.0, 14.0),
        _ => {}
    }
    let width =
        node.lines.iter().map(|l| text::width(&l.text, l.style.metrics())).fold(0.0, f64::max);
    let height: f64 = node.lines.iter().map(|l| l.style.metrics().height).sum();
    let (dx, dy) = LINE_PADDING;
    let extra = match node.shape {
        Shape::Octagon | Shape::Final | Shape::Pill => 10.0,
        _ => 0.0,
    };
    let header = if node.shape == Shape::Card && node.lines.len() > 1 { CARD_HEADER } else { 0.0 };
    // Whole, even pixels keep outlines crisp.
    let even = |v: f64| (v / 2.0).ceil() * 2.0;
    (even((width + 2.0 * dx + extra).max(54.0)), even(height + 2.0 * dy + header))
}

/// Width and height of an edge label, in pixels; 0 for an empty one.
pub(super) fn label_size(label: &str) -> (f64, f64) {
    if label.is_empty() {
        (0.0, 0.0)
    } else {
        (text::width(label, text::LABEL) + 6.0, text::LABEL.height)
    }
}

/// The self loops of a graph, on the sides where no other edges arrive: the first loop of a node on the
/// right, the second on the left, further ones wider on the right again.
pub(super) struct Loops {
    /// Edge to (node, number of loops of that node before it).
    rank: FxHashMap<usize, usize>,
    /// Node to room needed on the left and right.
    reach: FxHashMap<usize, (f64, f64)>,
}

impl Loops {
    pub(super) fn of(ends: &[Option<(usize, usize)>], labels: &[(f64, f64)]) -> Loops {
        let mut loops = Loops { rank: FxHashMap::default(), reach: FxHashMap::default() };
        let mut count: FxHashMap<usize, usize> = FxHashMap::default();
        for (i, end) in ends.iter().enumerate() {
            let Some((from, to)) = *end else { continue };
            if from != to {
                continue;
            }
            let nth = count.entry(from).or_insert(0);
            loops.rank.insert(i, *nth);
            let room = LOOP_REACH + labels[i].0 + LABEL_GAP;
            let reach = loops.reach.entry(from).or_insert((0.0, 0.0));
            match *nth {
                1 => reach.0 = room,
                // Wider loops enclose the labels of the loops before them.
                _ => reach.1 += room,
            }
            *nth += 1;
        }
        loops
    }

    /// Room for loops on the left and right of a node.
    pub(super) fn reach(&self, node: usize) -> (f64, f64) {
        self.reach.get(&node).copied().unwrap_or_default()
    }

    /// The curve and label of a self loop.
    pub(super) fn path(&self, edge: usize, node: Rect, (width, height): (f64, f64)) -> EdgePath {
        let nth = self.rank.get(&edge).copied().unwrap_or(0);
        let left = nth == 1;
        let side = if left { -1.0 } else { 1.0 };
        let border = if left { node.x } else { node.x + node.width };
        let spread = node.height * if nth < 2 { 0.22 } else { 0.4 };
        let reach = LOOP_REACH
            + if nth < 2 { 0.0 } else { (nth - 1) as f64 * (LOOP_REACH + width + LABEL_GAP) };
        let middle = node.center().y;
        // A cubic reaches three quarters of the way to its control points.
        let control = border + side * reach * 4.0 / 3.0;
        let points = vec![
            Point { x: border, y: middle - spread },
            Point { x: control, y: middle - spread - 4.0 },
            Point { x: control, y: middle + spread + 4.0 },
            Point { x: border, y: middle + spread },
        ];
        let label = (width > 0.0).then(|| {
            let near = border + side * (reach + LABEL_GAP);
            let x = if left { near - width } else { near };
            Rect { x, y: middle - height / 2.0, width, height }
        });
        EdgePath { points, label }
    }
}

/// The corners of an octagon in a rectangle.
pub fn octagon(rect: Rect) -> [Point; 8] {
    let cut = (rect.height.min(rect.width) * 0.29).min(12.0);
    let (l, r, t, b) = (rect.x, rect.x + rect.width, rect.y, rect.y + rect.height);
    [
        Point { x: l + cut, y: t },
        Point { x: r - cut, y: t },
        Point { x: r, y: t + cut },
        Point { x: r, y: b - cut },
        Point { x: r - cut, y: b },
        Point { x: l + cut, y: b },
        Point { x: l, y: b - cut },
        Point { x: l, y: t + cut },
    ]
}
