//! Checks for unreadable drawings.

use dotgen_diagram::graph::Graph;
use dotgen_diagram::layout::{Layout, Point, Rect};

/// Lists the defects of a drawing: labels over labels or nodes, elements outside the picture, edges that do
/// not end on their nodes.
pub(crate) fn problems(graph: &Graph, placed: &Layout) -> Vec<String> {
    let mut out = Vec::new();
    let view = Rect { x: 0.0, y: 0.0, width: placed.width, height: placed.height };
    let labels: Vec<(usize, Rect)> =
        placed.edges.iter().enumerate().filter_map(|(i, e)| Some((i, e.label?))).collect();
    overlaps(graph, placed, &labels, &mut out);
    wrong_frames(graph, placed, &mut out);
    let frames = placed.frames.iter().map(|frame| &frame.rect);
    let inside = placed.nodes.iter().chain(labels.iter().map(|(_, r)| r));
    for rect in inside.chain(frames) {
        if !rect.inside(view) {
            out.push(format!("{rect:?} is outside the picture"));
        }
    }
    wrong_edges(graph, placed, &mut out);
    out
}

/// Labels and nodes over others.
fn overlaps(graph: &Graph, placed: &Layout, labels: &[(usize, Rect)], out: &mut Vec<String>) {
    for (n, (i, a)) in labels.iter().enumerate() {
        for (j, b) in &labels[n + 1..] {
            if a.overlaps(*b) {
                out.push(format!("labels of edges {i} and {j} overlap"));
            }
        }
        for (k, node) in placed.nodes.iter().enumerate() {
            if a.overlaps(*node) {
                out.push(format!("label of edge {i} overlaps node {}", graph.nodes[k].id));
            }
        }
    }
    for (k, node) in placed.nodes.iter().enumerate() {
        for (m, other) in placed.nodes.iter().enumerate().skip(k + 1) {
            if node.overlaps(*other) {
                out.push(format!("nodes {} and {} overlap", graph.nodes[k].id, graph.nodes[m].id));
            }
        }
    }
}

/// Frames that do not hold exactly their group, or are over others.
fn wrong_frames(graph: &Graph, placed: &Layout, out: &mut Vec<String>) {
    for (n, frame) in placed.frames.iter().enumerate() {
        for (node, rect) in graph.nodes.iter().zip(&placed.nodes) {
            let member = node.group.as_ref() == Some(&frame.name);
            // A group in several columns has a frame in each.
            let mut own = placed.frames.iter().filter(|other| other.name == frame.name);
            let framed = own.any(|frame| rect.inside(frame.rect));
            if member && !framed || !member && rect.overlaps(frame.rect) {
                out.push(format!("{} and the frame {} disagree", node.id, frame.name));
            }
        }
        for other in &placed.frames[n + 1..] {
            if frame.rect.overlaps(other.rect) {
                out.push(format!("frames {} and {} overlap", frame.name, other.name));
            }
        }
    }
}

/// Edges that do not end on their nodes, or run through others.
fn wrong_edges(graph: &Graph, placed: &Layout, out: &mut Vec<String>) {
    let near = |p: Point, r: Rect| {
        p.x >= r.x - 0.6
            && p.x <= r.x + r.width + 0.6
            && p.y >= r.y - 0.6
            && p.y <= r.y + r.height + 0.6
    };
    for (edge, path) in graph.edges.iter().zip(&placed.edges) {
        let of = |id: &str| {
            graph.nodes.iter().position(|n| n.id == id).map(|i| placed.nodes[i]).unwrap()
        };
        if !near(path.points[0], of(&edge.from))
            || !near(*path.points.last().unwrap(), of(&edge.to))
        {
            out.push(format!("edge {} -> {} does not end on its nodes", edge.from, edge.to));
        }
        for (node, rect) in graph.nodes.iter().zip(&placed.nodes) {
            let other = node.id != edge.from && node.id != edge.to;
            if other && curve(&path.points).any(|p| well_inside(p, *rect)) {
                out.push(format!("edge {} -> {} runs through {}", edge.from, edge.to, node.id));
            }
        }
    }
}

/// Points along a chain of Bézier curves.
fn curve(points: &[Point]) -> impl Iterator<Item = Point> + '_ {
    const STEPS: u32 = 16;
    let pieces = (0..points.len().saturating_sub(1) / 3).map(|i| &points[3 * i..3 * i + 4]);
    pieces.flat_map(|p| {
        (0..=STEPS).map(|step| {
            let t = f64::from(step) / f64::from(STEPS);
            let u = 1.0 - t;
            let at = |f: fn(&Point) -> f64| {
                u * u * u * f(&p[0])
                    + 3.0 * u * u * t * f(&p[1])
                    + 3.0 * u * t * t * f(&p[2])
                    + t * t * t * f(&p[3])
            };
            Point { x: at(|p| p.x), y: at(|p| p.y) }
        })
    })
}

fn well_inside(p: Point, r: Rect) -> bool {
    const SLACK: f64 = 0.5;
    p.x > r.x + SLACK
        && p.x < r.x + r.width - SLACK
        && p.y > r.y + SLACK
        && p.y < r.y + r.height - SLACK
}
