//! Orders each rank so that few edges cross.

use super::ranked::RankedGraph;

/// Number of sweeps of the median heuristic without improvement before it stops.
const MAX_IDLE_SWEEPS: usize = 4;
/// Maximum number of sweeps.
const SWEEPS: usize = 24;

/// Orders the ranks: weighted medians, sweeping down and up, with exchanges of neighbours
/// (Gansner, Koutsofios, North and Vo, "A technique for drawing directed graphs", 1993).
pub(super) fn order(graph: &mut RankedGraph) {
    for rank in 0..graph.layers.len() {
        graph.gather(rank);
    }
    let mut position = positions(graph);
    transpose(graph, &mut position);
    let mut best = graph.layers.clone();
    let mut fewest = crossings(graph, &position);
    let mut idle = 0;
    for sweep in 0..SWEEPS {
        if fewest == 0 || idle >= MAX_IDLE_SWEEPS {
            break;
        }
        let ranks = graph.layers.len();
        let down = sweep % 2 == 0;
        for step in 1..ranks {
            let rank = if down { step } else { ranks - 1 - step };
            sort_by_median(graph, rank, down, sweep % 4 >= 2, &mut position);
        }
        transpose(graph, &mut position);
        let now = crossings(graph, &position);
        if now < fewest {
            (fewest, idle) = (now, 0);
            best.clone_from(&graph.layers);
        } else {
            idle += 1;
        }
    }
    graph.layers = best;
}

fn positions(graph: &RankedGraph) -> Vec<usize> {
    let mut position = vec![0; graph.rank.len()];
    for layer in &graph.layers {
        for (i, &vertex) in layer.iter().enumerate() {
            position[vertex] = i;
        }
    }
    position
}

fn sort_by_median(
    graph: &mut RankedGraph,
    rank: usize,
    down: bool,
    later_first: bool,
    position: &mut [usize],
) {
    let side = if down { &graph.up } else { &graph.down };
    let layer = &mut graph.layers[rank];
    let mut keyed: Vec<(Option<f64>, usize, usize)> = layer
        .iter()
        .enumerate()
        .map(|(i, &vertex)| {
            let mut near: Vec<usize> = side[vertex].iter().map(|&n| position[n]).collect();
            near.sort_unstable();
            (median(&near), i, vertex)
        })
        .collect();
    // Vertices without neighbours on that side keep their place; the others are sorted around them.
    let mut movable: Vec<(f64, usize, usize)> =
        keyed.iter().filter_map(|&(m, i, v)| m.map(|m| (m, i, v))).collect();
    movable.sort_by(|a, b| {
        let tie = if later_first { b.1.cmp(&a.1) } else { a.1.cmp(&b.1) };
        a.0.total_cmp(&b.0).then(tie)
    });
    let mut sorted = movable.into_iter().map(|(_, _, v)| v);
    for entry in &mut keyed {
        if entry.0.is_some()
            && let Some(vertex) = sorted.next()
        {
            entry.2 = vertex;
        }
    }
    for (i, &(_, _, vertex)) in keyed.iter().enumerate() {
        layer[i] = vertex;
    }
    graph.gather(rank);
    for (i, &vertex) in graph.layers[rank].iter().enumerate() {
        position[vertex] = i;
    }
}

/// The median of sorted positions, leaning to the denser side.
fn median(near: &[usize]) -> Option<f64> {
    let n = near.len();
    let at = |i: usize| near[i] as f64;
    Some(match n {
        0 => return None,
        1 => at(0),
        2 => f64::midpoint(at(0), at(1)),
        _ if n % 2 == 1 => at(n / 2),
        _ => {
            let left = at(n / 2 - 1) - at(0);
            let right = at(n - 1) - at(n / 2);
            if left + right == 0.0 {
                f64::midpoint(at(n / 2 - 1), at(n / 2))
            } else {
                (at(n / 2 - 1) * right + at(n / 2) * left) / (left + right)
            }
        }
    })
}

/// Exchanges neighbours as long as that removes crossings.
fn transpose(graph: &mut RankedGraph, position: &mut [usize]) {
    for _ in 0..8 {
        let mut improved = false;
        for rank in 0..graph.layers.len() {
            for i in 1..graph.layers[rank].len() {
                let (a, b) = (graph.layers[rank][i - 1], graph.layers[rank][i]);
                if graph.group_of(a) != graph.group_of(b) {
                    continue;
                }
                let keep = crossings_of(graph, a, b, position);
                let swap = crossings_of(graph, b, a, position);
                if swap < keep {
                    graph.layers[rank].swap(i - 1, i);
                    (position[a], position[b]) = (i, i - 1);
                    improved = true;
                }
            }
        }
        if !improved {
            break;
        }
    }
}

/// Crossings between the edges of two neighbours when `left` stands left of `right`.
fn crossings_of(graph: &RankedGraph, left: usize, right: usize, position: &[usize]) -> usize {
    let mut count = 0;
    for side in [&graph.up, &graph.down] {
        for &a in &side[left] {
            for &b in &side[right] {
                count += usize::from(position[a] > position[b]);
            }
        }
    }
    count
}

fn crossings(graph: &RankedGraph, position: &[usize]) -> usize {
    let mut count = 0;
    let mut ends: Vec<usize> = Vec::new();
    for layer in &graph.layers {
        ends.clear();
        for &vertex in layer {
            let mut below: Vec<usize> = graph.down[vertex].iter().map(|&n| position[n]).collect();
            below.sort_unstable();
            ends.extend(below);
        }
        // Inversions; ranks are short enough for the plain count.
        for (i, a) in ends.iter().enumerate() {
            count += ends[i + 1..].iter().filter(|b| *b < a).count();
        }
    }
    count
}
