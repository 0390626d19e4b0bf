//! Nodes that the reader moved, and the edges that follow them.

use crate::graph::Graph;
use crate::text;

use super::{EdgePath, Layout, Point, Rect, finish};

/// Moves each node by an offset in pixels from its computed place (nodes beyond the end of `by` stay). Edges
/// between nodes with equal offsets move along; an edge with one moved end is redrawn, straight out of the
/// sides that face each other.
pub fn moved(graph: &Graph, mut layout: Layout, by: &[Point]) -> Layout {
    let of = |node: usize| by.get(node).copied().unwrap_or_default();
    let still = Point::default();
    if by.iter().all(|point| *point == still) {
        return layout;
    }
    for (node, rect) in layout.nodes.iter_mut().enumerate() {
        (rect.x, rect.y) = (rect.x + of(node).x, rect.y + of(node).y);
    }
    let index = |id: &str| graph.nodes.iter().position(|node| node.id == id);
    for (edge, path) in graph.edges.iter().zip(&mut layout.edges) {
        let (Some(from), Some(to)) = (index(&edge.from), index(&edge.to)) else {
            continue;
        };
        if of(from) == of(to) {
            shift(path, of(from));
        } else {
            *path = between(layout.nodes[from], layout.nodes[to], &edge.label);
        }
    }
    finish(graph, layout)
}

fn shift(path: &mut EdgePath, by: Point) {
    for point in &mut path.points {
        *point = Point { x: point.x + by.x, y: point.y + by.y };
    }
    if let Some(label) = &mut path.label {
        (label.x, label.y) = (label.x + by.x, label.y + by.y);
    }
}

/// One curve from a side of a node to the side of another that faces it, with its label in the middle.
fn between(from: Rect, to: Rect, label: &str) -> EdgePath {
    let (a, b) = (from.center(), to.center());
    // The horizontal and vertical distances between the nodes.
    let aside = (b.x - a.x).abs() - f64::midpoint(from.width, to.width);
    let above = (b.y - a.y).abs() - f64::midpoint(from.height, to.height);
    let end = |of: Rect, towards: Point| {
        let middle = of.center();
        if aside >= above {
            let side = (towards.x - middle.x).signum() * of.width / 2.0;
            Point { x: middle.x + side, y: middle.y }
        } else {
            let side = (towards.y - middle.y).signum() * of.height / 2.0;
            Point { x: middle.x, y: middle.y + side }
        }
    };
    let (first, last) = (end(from, b), end(to, a));
    let middle = Point { x: f64::midpoint(first.x, last.x), y: f64::midpoint(first.y, last.y) };
    let (leave, arrive) = if aside >= above {
        (Point { x: middle.x, y: first.y }, Point { x: middle.x, y: last.y })
    } else {
        (Point { x: first.x, y: middle.y }, Point { x: last.x, y: middle.y })
    };
    let label = (!label.is_empty()).then(|| {
        let (width, height) = (text::width(label, text::LABEL) + 6.0, text::LABEL.height);
        Rect::centered(middle, width, height)
    });
    EdgePath { points: vec![first, leave, arrive, last], label }
}
