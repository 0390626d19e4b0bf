//! Vertical coordinates, and the curves of edges.

use super::ranked::RankedGraph;
use super::{EdgePath, Point, Rect};

/// The top and bottom of each rank, in pixels.
pub(super) struct Bands {
    bands: Vec<(f64, f64)>,
}

impl Bands {
    pub(super) fn middle(&self, rank: usize) -> f64 {
        let (top, bottom) = self.bands[rank];
        f64::midpoint(top, bottom)
    }
}

/// Stacks the ranks, as high as their highest vertex, with a gap between them.
pub(super) fn rank_bands(graph: &RankedGraph, gap: f64) -> Bands {
    let mut bands = Vec::with_capacity(graph.layers.len());
    let mut y = 0.0;
    for layer in &graph.layers {
        let height = layer.iter().map(|&v| graph.extent[v].2).fold(0.0, f64::max);
        bands.push((y, y + height));
        y += height + gap;
    }
    Bands { bands }
}

/// A smooth curve through points of increasing y that never swings past them: monotone cubic
/// interpolation (Fritsch and Carlson 1980), vertical at both ends.
fn smooth(through: &[Point]) -> Vec<Point> {
    let slopes: Vec<f64> =
        through.windows(2).map(|w| (w[1].x - w[0].x) / (w[1].y - w[0].y)).collect();
    let tangent = |i: usize| match (i.checked_sub(1).map(|before| slopes[before]), slopes.get(i)) {
        (Some(a), Some(&b)) if a * b > 0.0 => 2.0 * a * b / (a + b),
        _ => 0.0,
    };
    let mut points = vec![through[0]];
    for (i, pair) in through.windows(2).enumerate() {
        let third = (pair[1].y - pair[0].y) / 3.0;
        // Vertical ends take half of the way, for a rounder bend.
        let reach = |tangent: f64| if tangent == 0.0 { 1.5 * third } else { third };
        let (t0, t1) = (tangent(i), tangent(i + 1));
        points.push(Point { x: pair[0].x + t0 * reach(t0), y: pair[0].y + reach(t0) });
        points.push(Point { x: pair[1].x - t1 * reach(t1), y: pair[1].y - reach(t1) });
        points.push(pair[1]);
    }
    points
}

/// Maximum height of a rank that holds only labels, in pixels.
const LABEL_RANK: f64 = 16.0;

/// Minimum distance of two edges at a node, in pixels.
const PORT_GAP: f64 = 16.0;

/// The curves of all edges except self loops.
pub(super) fn edges(
    graph: &RankedGraph,
    x: &[f64],
    bands: &Bands,
    nodes: &[Rect],
    labels: &[(f64, f64)],
) -> Vec<EdgePath> {
    let ports = ports(graph, x, nodes);
    graph
        .chains
        .iter()
        .enumerate()
        .map(|(i, chain)| {
            let (Some(&upper), Some(&lower)) = (chain.first(), chain.last()) else {
                return EdgePath::default();
            };
            let (from_x, to_x) = ports[i];
            // Straight through every rank, nodes' own ranks included; bends between ranks.
            let mut through = vec![
                Point { x: from_x, y: nodes[upper].y + nodes[upper].height },
                Point { x: from_x, y: bands.bands[graph.rank[upper]].1 },
            ];
            for &vertex in &chain[1..chain.len() - 1] {
                let (top, bottom) = bands.bands[graph.rank[vertex]];
                // An edge may cross a rank of labels at a slant, since the rank is low.
                if bottom - top <= LABEL_RANK && graph.label_at[i] != Some(vertex) {
                    through.push(Point { x: x[vertex], y: f64::midpoint(top, bottom) });
                } else {
                    through.extend([top, bottom].map(|y| Point { x: x[vertex], y }));
                }
            }
            through.push(Point { x: to_x, y: bands.bands[graph.rank[lower]].0 });
            through.push(Point { x: to_x, y: nodes[lower].y });
            through.dedup_by(|a, b| (a.y - b.y).abs() < 0.5);
            let mut points = smooth(&through);
            if graph.reversed[i] {
                points.reverse();
            }
            let label = graph.label_at[i].map(|vertex| {
                let center = Point { x: x[vertex], y: bands.middle(graph.rank[vertex]) };
                Rect::centered(center, labels[i].0, labels[i].1)
            });
            EdgePath { points, label }
        })
        .collect()
}

/// The points at which each edge meets its upper and its lower node: spread along the side in the order of
/// the next vertices, so that edges do not cross at the node.
fn ports(graph: &RankedGraph, x: &[f64], nodes: &[Rect]) -> Vec<(f64, f64)> {
    let mut out: Vec<(f64, f64)> = vec![(0.0, 0.0); graph.chains.len()];
    let mut bottom: Vec<Vec<(f64, usize)>> = vec![Vec::new(); graph.real];
    let mut top: Vec<Vec<(f64, usize)>> = vec![Vec::new(); graph.real];
    for (i, chain) in graph.chains.iter().enumerate() {
        if let [upper, next, ..] = chain[..] {
            bottom[upper].push((x[next], i));
            let (previous, lower) = (chain[chain.len() - 2], chain[chain.len() - 1]);
            top[lower].push((x[previous], i));
        }
    }
    for (sides, is_bottom) in [(&mut bottom, true), (&mut top, false)] {
        for (node, side) in sides.iter_mut().enumerate() {
            side.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let rect = nodes[node];
            let center = rect.center().x;
            let reach = (rect.width / 2.0 - 12.0).max(0.0);
            let gap = if side.len() > 1 {
                PORT_GAP.min(2.0 * reach / (side.len() - 1) as f64)
            } else {
                0.0
            };
            // As near as possible to straight down, in order and apart.
            let mut places: Vec<f64> =
                side.iter().map(|&(at, _)| at.clamp(center - reach, center + reach)).collect();
            for k in 1..places.len() {
                places[k] = places[k].max(places[k - 1] + gap);
            }
            let mut limit = center + reach;
            for place in places.iter_mut().rev() {
                *place = place.min(limit);
                limit = *place - gap;
            }
            // Prefer an even spread around the centre.
            let spread = |k: usize| {
                center + (k as f64 - (side.len() as f64 - 1.0) / 2.0) * gap.max(PORT_GAP.min(gap))
            };
            for (k, &(_, edge)) in side.iter().enumerate() {
                let at = if (places[k] - center).abs() < 0.5 {
                    center
                } else {
                    places[k] * 0.5 + spread(k) * 0.5
                };
                if is_bottom {
                    out[edge].0 = at;
                } else {
                    out[edge].1 = at;
                }
            }
        }
    }
    out
}
