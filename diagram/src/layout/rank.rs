//! The rank of each node.

/// The minimum length of an edge in ranks. Every edge spans an even number of ranks, so that its label has a
/// rank of its own.
pub(super) const EDGE_LENGTH: usize = 2;

/// An edge of the acyclic graph: both ends, minimum length in ranks, weight.
pub(super) type Arc = (usize, usize, usize, i64);

/// Ranks from 0 such that every arc spans at least its length, short in total.
///
/// Longest paths give feasible ranks; nodes are then moved towards the side that pulls harder, and
/// connected groups together with them, until nothing improves.
pub(super) fn ranks(nodes: usize, arcs: &[Arc]) -> Vec<usize> {
    let mut out = vec![Vec::new(); nodes];
    let mut into = vec![Vec::new(); nodes];
    for &(from, to, length, weight) in arcs {
        out[from].push((to, length as i64, weight));
        into[to].push((from, length as i64, weight));
    }
    let mut rank = vec![0_i64; nodes];
    let mut waiting: Vec<usize> = into.iter().map(Vec::len).collect();
    let mut ready: Vec<usize> = (0..nodes).filter(|&n| waiting[n] == 0).collect();
    let mut sorted = Vec::with_capacity(nodes);
    while let Some(node) = ready.pop() {
        sorted.push(node);
        for &(to, length, _) in &out[node] {
            rank[to] = rank[to].max(rank[node] + length);
            waiting[to] -= 1;
            if waiting[to] == 0 {
                ready.push(to);
            }
        }
    }
    for _ in 0..16 {
        let mut moved = false;
        for &node in sorted.iter().rev().chain(&sorted) {
            let pull: i64 = out[node].iter().map(|e| e.2).sum::<i64>()
                - into[node].iter().map(|e| e.2).sum::<i64>();
            let low = into[node].iter().map(|&(from, length, _)| rank[from] + length).max();
            let high = out[node].iter().map(|&(to, length, _)| rank[to] - length).min();
            let target = match (pull.signum(), low, high) {
                (1, _, Some(high)) => high,
                (-1, Some(low), _) => low,
                _ => continue,
            };
            if rank[node] != target {
                rank[node] = target;
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
    let least = rank.iter().copied().min().unwrap_or(0);
    rank.iter().map(|r| (r - least) as usize).collect()
}
