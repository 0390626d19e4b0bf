//! Horizontal coordinates (Brandes and Köpf, "Fast and simple horizontal coordinate assignment",
//! 2001, with vertices of different widths).
//!
//! Vertices are aligned in vertical runs with a median neighbour, once for each of the four
//! combinations of up or down and left or right; each alignment is packed; the balanced mean of the
//! four keeps edges straight and the picture symmetric.

use rustc_hash::FxHashSet;

use super::ranked::RankedGraph;
use super::{FRAME_PADDING, LABEL_HEIGHT};

const NONE: usize = usize::MAX;
/// Minimum distance of two edges that pass through a column next to each other, in pixels.
const EDGE_GAP: f64 = 4.0;

/// The x coordinate of the anchor of each vertex. `gap` is the minimum distance of two nodes. All are in
/// pixels.
pub(super) fn positions(graph: &RankedGraph, gap: f64) -> Vec<f64> {
    let conflicts = conflicts(graph);
    let mut candidates: Vec<Vec<f64>> = Vec::with_capacity(4);
    for upward in [false, true] {
        for rightward in [false, true] {
            let layers = oriented(&graph.layers, upward, rightward);
            let above = if upward { &graph.down } else { &graph.up };
            let root = alignment(&layers, above, &conflicts, graph.rank.len());
            let mut x = compaction(graph, &layers, &root, gap, rightward);
            if rightward {
                for v in &mut x {
                    *v = -*v;
                }
            }
            candidates.push(x);
        }
    }
    balance(graph, &mut candidates)
}

fn oriented(layers: &[Vec<usize>], upward: bool, rightward: bool) -> Vec<Vec<usize>> {
    let mut layers: Vec<Vec<usize>> = layers.to_vec();
    if upward {
        layers.reverse();
    }
    if rightward {
        for l in &mut layers {
            l.reverse();
        }
    }
    layers
}

/// Segments that cross the inner segment of a long edge: long edges win and stay straight.
fn conflicts(graph: &RankedGraph) -> FxHashSet<(usize, usize)> {
    let mut position = vec![0; graph.rank.len()];
    for layer in &graph.layers {
        for (i, &v) in layer.iter().enumerate() {
            position[v] = i;
        }
    }
    let mut out = FxHashSet::default();
    for layers in graph.layers.windows(2) {
        let (upper, lower) = (&layers[0], &layers[1]);
        let inner = |v: usize| {
            graph
                .is_dummy(v)
                .then(|| graph.up[v].iter().copied().find(|&u| graph.is_dummy(u)))
                .flatten()
        };
        let mut left = 0;
        let mut scanned = 0;
        for (i, &v) in lower.iter().enumerate() {
            let end = inner(v);
            if end.is_none() && i + 1 != lower.len() {
                continue;
            }
            let right = end.map_or(upper.len(), |u| position[u]);
            for &w in &lower[scanned..=i] {
                for &u in &graph.up[w] {
                    let k = position[u];
                    if (k < left || k > right) && !(graph.is_dummy(u) && graph.is_dummy(w)) {
                        out.insert((u, w));
                    }
                }
            }
            scanned = i + 1;
            left = right;
        }
    }
    out
}

/// The top vertex of the run each vertex is in.
fn alignment(
    layers: &[Vec<usize>],
    above: &[Vec<usize>],
    conflicts: &FxHashSet<(usize, usize)>,
    vertices: usize,
) -> Vec<usize> {
    let mut root: Vec<usize> = (0..vertices).collect();
    let mut align: Vec<usize> = (0..vertices).collect();
    let mut position = vec![0; vertices];
    for layer in layers {
        for (i, &v) in layer.iter().enumerate() {
            position[v] = i;
        }
    }
    for layer in layers {
        let mut last: Option<usize> = None;
        for &v in layer {
            let mut near: Vec<usize> = above[v].clone();
            if near.is_empty() {
                continue;
            }
            near.sort_by_key(|&u| position[u]);
            let middle = (near.len() - 1) / 2;
            for &u in &near[middle..=near.len() / 2] {
                let free = align[v] == v
                    && last.is_none_or(|l| l < position[u])
                    && !conflicts.contains(&(u, v))
                    && !conflicts.contains(&(v, u));
                if free {
                    align[u] = v;
                    root[v] = root[u];
                    align[v] = root[v];
                    last = Some(position[u]);
                }
            }
        }
    }
    root
}

/// Packs the runs to the left.
fn compaction(
    graph: &RankedGraph,
    layers: &[Vec<usize>],
    root: &[usize],
    gap: f64,
    mirrored: bool,
) -> Vec<f64> {
    let vertices = graph.rank.len();
    let mut before = vec![NONE; vertices];
    for layer in layers {
        for pair in layer.windows(2) {
            before[pair[1]] = pair[0];
        }
    }
    let distance = |left: usize, right: usize| {
        let (left, right) = if mirrored { (right, left) } else { (left, right) };
        let space = match (graph.is_dummy(left), graph.is_dummy(right)) {
            (true, true) if graph.columns => EDGE_GAP,
            (true, true) => 14.0,
            (false, false) if graph.group_of(left) != graph.group_of(right) => {
                gap + FRAME_PADDING + LABEL_HEIGHT
            }
            (false, false) => gap,
            _ => 18.0,
        };
        graph.extent[left].1 + graph.extent[right].0 + space
    };
    // The block graph: block a lies left of block b. Longest paths place blocks as far left as possible; a
    // second pass pulls them right, to their neighbours.
    let mut before_block: Vec<Vec<(usize, f64)>> = vec![Vec::new(); vertices];
    let mut after_block: Vec<Vec<(usize, f64)>> = vec![Vec::new(); vertices];
    let mut degree = vec![0_usize; vertices];
    for v in 0..vertices {
        let u = before[v];
        if u != NONE {
            let d = distance(u, v);
            before_block[root[v]].push((root[u], d));
            after_block[root[u]].push((root[v], d));
            degree[root[v]] += 1;
        }
    }
    let mut ready: Vec<usize> = (0..vertices).filter(|&v| root[v] == v && degree[v] == 0).collect();
    let mut sorted = Vec::new();
    while let Some(block) = ready.pop() {
        sorted.push(block);
        for &(next, _) in &after_block[block] {
            degree[next] -= 1;
            if degree[next] == 0 {
                ready.push(next);
            }
        }
    }
    let mut x = vec![0.0_f64; vertices];
    for &block in &sorted {
        x[block] = before_block[block].iter().map(|&(b, d)| x[b] + d).fold(0.0, f64::max);
    }
    for &block in sorted.iter().rev() {
        let limit = after_block[block].iter().map(|&(b, d)| x[b] - d).fold(f64::MAX, f64::min);
        if limit < f64::MAX {
            x[block] = x[block].max(limit);
        }
    }
    (0..vertices).map(|v| x[root[v]]).collect()
}

/// Aligns the four candidates with the narrowest and takes the mean of the two middle values.
fn balance(graph: &RankedGraph, candidates: &mut [Vec<f64>]) -> Vec<f64> {
    let bounds = |x: &[f64]| {
        x.iter().enumerate().fold((f64::MAX, f64::MIN), |(low, high), (v, &at)| {
            (low.min(at - graph.extent[v].0), high.max(at + graph.extent[v].1))
        })
    };
    let all: Vec<(f64, f64)> = candidates.iter().map(|x| bounds(x)).collect();
    let Some(narrowest) =
        (0..all.len()).min_by(|&a, &b| (all[a].1 - all[a].0).total_cmp(&(all[b].1 - all[b].0)))
    else {
        return Vec::new();
    };
    let (low, high) = all[narrowest];
    for (i, x) in candidates.iter_mut().enumerate() {
        let rightward = i % 2 == 1;
        let shift = if rightward { high - all[i].1 } else { low - all[i].0 };
        for v in x.iter_mut() {
            *v += shift;
        }
    }
    (0..graph.rank.len())
        .map(|v| {
            let mut values: Vec<f64> = candidates.iter().map(|x| x[v]).collect();
            values.sort_by(f64::total_cmp);
            f64::midpoint(values[1], values[2])
        })
        .collect()
}

/// Moves the nodes of each group together, `gap` apart, as near as possible to where they are.
pub(super) fn pack_groups(graph: &RankedGraph, gap: f64, x: &mut [f64]) {
    // Many columns keep the picture low: all of them are packed, and none is lower than another.
    let wrapped = graph.columns && graph.layers.len() > 3;
    for layer in &graph.layers {
        // Vertices without a group are pieces of passing edges; they stay together where they are neighbours.
        if !wrapped && layer.iter().all(|&layer| graph.group_of(layer).is_none()) {
            continue;
        }
        // The distance of each node from the first when all are packed; the rest of its coordinate is one
        // shift per group.
        let mut offset = vec![0.0; layer.len()];
        for i in 1..layer.len() {
            let (left, right) = (layer[i - 1], layer[i]);
            let frame = if graph.group_of(left) == graph.group_of(right) {
                0.0
            } else {
                FRAME_PADDING + LABEL_HEIGHT
            };
            let passing = graph.is_dummy(left) && graph.is_dummy(right);
            let gap = if passing { EDGE_GAP } else { gap };
            let between = graph.extent[left].1 + graph.extent[right].0 + gap + frame;
            offset[i] = offset[i - 1] + between;
        }
        if wrapped {
            let height = offset.last().copied().unwrap_or(0.0);
            for (&vertex, offset) in layer.iter().zip(offset) {
                x[vertex] = offset - height / 2.0;
            }
            continue;
        }
        // Least squares with increasing shifts: neighbours that would change places are pooled.
        let mut pools: Vec<(f64, usize)> = Vec::new();
        let mut start = 0;
        while start < layer.len() {
            let group = graph.group_of(layer[start]);
            let rest = &layer[start..];
            let count = rest.iter().take_while(|&&layer| graph.group_of(layer) == group).count();
            let sum: f64 = (start..start + count).map(|i| x[layer[i]] - offset[i]).sum();
            let mut pool = (sum, count);
            while let Some(&(sum, count)) = pools.last()
                && sum / count as f64 > pool.0 / pool.1 as f64
            {
                pools.pop();
                pool = (pool.0 + sum, pool.1 + count);
            }
            pools.push(pool);
            start += count;
        }
        let shifts =
            pools.iter().flat_map(|&(sum, count)| std::iter::repeat_n(sum / count as f64, count));
        for ((&vertex, offset), shift) in layer.iter().zip(offset).zip(shifts) {
            x[vertex] = offset + shift;
        }
    }
}
