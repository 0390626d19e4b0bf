//! The edges to reverse so that the graph has no cycle.

/// For each edge, true if it must be reversed: the back edges of a depth-first search.
///
/// If the graph has an entry (`begins`), the search starts at the nodes without entering edges, so that the
/// edges that people call "back" are reversed. Otherwise (cyclic data flow) it starts at the node that gives
/// the fewest reversed edges, the first of them in order of declaration.
pub(super) fn back_edges(
    nodes: usize,
    edges: &[Option<(usize, usize)>],
    begins: bool,
) -> Vec<bool> {
    /// Maximum number of start nodes to try. One search is linear, but a search from every node is not.
    const STARTS: usize = 64;
    let first = walk(nodes, edges, None);
    let count = |flags: &[bool]| flags.iter().filter(|flag| **flag).count();
    let mut best = (count(&first), first);
    for start in (0..nodes).take(if begins { 0 } else { STARTS }) {
        if best.0 <= 1 {
            break;
        }
        let other = walk(nodes, edges, Some(start));
        if count(&other) < best.0 {
            best = (count(&other), other);
        }
    }
    best.1
}

/// Back edges of the depth-first search that begins at `start`, at the nodes without entering edges, and at
/// the others in order.
fn walk(nodes: usize, edges: &[Option<(usize, usize)>], start: Option<usize>) -> Vec<bool> {
    let mut out = vec![Vec::new(); nodes];
    let mut has_incoming = vec![false; nodes];
    for (i, end) in edges.iter().enumerate() {
        if let Some((from, to)) = *end
            && from != to
        {
            out[from].push((i, to));
            has_incoming[to] = true;
        }
    }
    #[derive(Clone, Copy, PartialEq)]
    enum Mark {
        New,
        Open,
        Done,
    }
    let mut mark = vec![Mark::New; nodes];
    let mut back = vec![false; edges.len()];
    let roots = start.into_iter().chain((0..nodes).filter(|&n| !has_incoming[n])).chain(0..nodes);
    for root in roots {
        if mark[root] != Mark::New {
            continue;
        }
        mark[root] = Mark::Open;
        let mut stack = vec![(root, 0)];
        while let Some((node, next)) = stack.last_mut() {
            let node = *node;
            let Some(&(edge, to)) = out[node].get(*next) else {
                mark[node] = Mark::Done;
                stack.pop();
                continue;
            };
            *next += 1;
            match mark[to] {
                Mark::New => {
                    mark[to] = Mark::Open;
                    stack.push((to, 0));
                }
                Mark::Open => back[edge] = true,
                Mark::Done => {}
            }
        }
    }
    back
}
