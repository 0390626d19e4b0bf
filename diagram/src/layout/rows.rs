//! Ranks for a picture of a given width: full ranks are continued in further ranks below.
//!
//! Layering with bounded width (E. Coffman, R. Graham, *Optimal scheduling for two-processor systems*, 1972):
//! a row takes nodes whose predecessors are in rows above, in the order of their unbounded ranks, until it is
//! full. A row holds nodes of one shape, and shapes take turns, so that ports are right below their
//! components.

use crate::graph::Shape;

use super::rank::{Arc, EDGE_LENGTH};

/// Space beside each node, in pixels: the distance of nodes, and of a passing edge.
const BESIDE: f64 = 30.0;

/// Bounds the width of the ranks of nodes, in pixels. `nodes` are the widths and shapes, `ranks` the ranks
/// without a bound, `arcs` the edges of the acyclic graph.
pub(super) fn bounded(
    nodes: &[(f64, Shape)],
    ranks: &[usize],
    arcs: &[Arc],
    width: f64,
) -> Vec<usize> {
    let mut waiting: Vec<usize> = (0..nodes.len()).collect();
    waiting.sort_by_key(|&node| ranks[node]);
    let mut above: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
    for arc in arcs {
        above[arc.1].push(arc.0);
    }
    let mut row: Vec<Option<usize>> = vec![None; nodes.len()];
    let mut last = None;
    for number in 0.. {
        let is_ready = |node: usize| above[node].iter().all(|&node| row[node].is_some());
        let ready: Vec<usize> = waiting.iter().copied().filter(|&node| is_ready(node)).collect();
        let shape = |&&node: &&usize| Some(nodes[node].1) != last;
        let Some(&first) = ready.iter().find(shape).or(ready.first()) else {
            break;
        };
        last = Some(nodes[first].1);
        let mut used = 0.0;
        for node in ready.into_iter().filter(|&node| Some(nodes[node].1) == last) {
            used += nodes[node].0 + BESIDE;
            if used > width && node != first {
                break;
            }
            row[node] = Some(number);
        }
        waiting.retain(|&node| row[node].is_none());
    }
    (row.into_iter()).map(|row| row.unwrap_or(0) * EDGE_LENGTH).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_rank_goes_on_below_its_ports() {
        // Three components of which two fit in a row, each with a port.
        let nodes = [
            (100.0, Shape::Card),
            (50.0, Shape::Octagon),
            (100.0, Shape::Card),
            (50.0, Shape::Octagon),
            (100.0, Shape::Card),
            (50.0, Shape::Octagon),
        ];
        let arcs = [(0, 1, 2, 1), (2, 3, 2, 1), (4, 5, 2, 1)];
        let ranks = bounded(&nodes, &[0, 2, 0, 2, 0, 2], &arcs, 270.0);
        assert_eq!(ranks, [0, 2, 0, 2, 4, 6]);
    }
}
