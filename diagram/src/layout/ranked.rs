//! The graph with ranks: real nodes, and one dummy for each rank a long edge crosses.

use crate::graph::{Graph, Shape};

use super::rank::{Arc, EDGE_LENGTH, ranks};
use super::{acyclic, rows, size::Loops};

/// A graph whose edges join neighbouring ranks only. Real nodes come first and keep their index.
pub(super) struct RankedGraph {
    /// Number of real nodes.
    pub(super) real: usize,
    /// True if the ranks are the columns of the nodes.
    pub(super) columns: bool,
    /// Rank of each vertex.
    pub(super) rank: Vec<usize>,
    /// Space left and right of the anchor of each vertex, and its height, in pixels.
    pub(super) extent: Vec<(f64, f64, f64)>,
    /// Vertices of each rank, in order.
    pub(super) layers: Vec<Vec<usize>>,
    /// For each real node, the number of its group.
    pub(super) group: Vec<Option<usize>>,
    /// Neighbours on the next and previous rank.
    pub(super) down: Vec<Vec<usize>>,
    /// See [`RankedGraph::down`].
    pub(super) up: Vec<Vec<usize>>,
    /// For each edge of the graph, its vertices from the upper to the lower end (empty for self loops and
    /// edges to unknown nodes).
    pub(super) chains: Vec<Vec<usize>>,
    /// For each edge, true if it was reversed.
    pub(super) reversed: Vec<bool>,
    /// For each edge, the vertex that holds its label.
    pub(super) label_at: Vec<Option<usize>>,
}

impl RankedGraph {
    pub(super) fn new(
        graph: &Graph,
        ends: &[Option<(usize, usize)>],
        boxes: &[(f64, f64)],
        labels: &[(f64, f64)],
        loops: &Loops,
        within: Option<f64>,
    ) -> RankedGraph {
        let real = boxes.len();
        let columns = columns(graph, ends);
        let begins = graph.nodes.iter().any(|node| node.shape == Shape::Initial);
        let reversed = match &columns {
            Some(column) => ends
                .iter()
                .map(|end| end.is_some_and(|(from, to)| column[from] > column[to]))
                .collect(),
            None => acyclic::back_edges(real, ends, begins),
        };
        let upper_lower = |i: usize| {
            let (from, to) = ends[i].filter(|(from, to)| from != to)?;
            Some(if reversed[i] { (to, from) } else { (from, to) })
        };
        let arcs: Vec<Arc> = (0..ends.len())
            .filter_map(|i| {
                let (upper, lower) = upper_lower(i)?;
                // Markers are right above the state they lead to.
                let weight =
                    if graph.edges[i].classes.iter().any(|c| c == "entry") { 8 } else { 1 };
                Some((upper, lower, EDGE_LENGTH, weight))
            })
            .collect();
        let mut graph = RankedGraph {
            real,
            columns: columns.is_some(),
            rank: match columns {
                // Without labels, no ranks are needed for them.
                Some(column) if labels.iter().all(|label| label.0 == 0.0) => column,
                Some(column) => column.into_iter().map(|column| column * EDGE_LENGTH).collect(),
                None => {
                    let ranks = ranks(real, &arcs);
                    let shapes = graph.nodes.iter().map(|node| node.shape);
                    let nodes: Vec<_> = boxes.iter().map(|boxed| boxed.0).zip(shapes).collect();
                    match within {
                        Some(width) => rows::bounded(&nodes, &ranks, &arcs, width),
                        None => ranks,
                    }
                }
            },
            group: groups(graph),
            extent: Vec::new(),
            layers: Vec::new(),
            down: Vec::new(),
            up: Vec::new(),
            chains: vec![Vec::new(); ends.len()],
            label_at: vec![None; ends.len()],
            reversed: Vec::new(),
        };
        for (i, &(width, height)) in boxes.iter().enumerate() {
            let (left, right) = loops.reach(i);
            graph.extent.push((width / 2.0 + left, width / 2.0 + right, height));
        }
        for (i, &label) in labels.iter().enumerate() {
            let Some((upper, lower)) = upper_lower(i) else {
                continue;
            };
            graph.add_chain(i, upper, lower, label);
        }
        graph.reversed = reversed;
        graph.connect();
        graph
    }

    /// Adds the vertices of an edge between its ends. One of them holds the label.
    fn add_chain(&mut self, i: usize, upper: usize, lower: usize, label: (f64, f64)) {
        let (first, last) = (self.rank[upper], self.rank[lower]);
        // The label is in the middle, on one of the ranks between nodes.
        let middle = first + ((last - first) / 2) / EDGE_LENGTH * EDGE_LENGTH;
        let label_rank =
            if (middle - first).is_multiple_of(EDGE_LENGTH) { middle + 1 } else { middle };
        let label_rank = label_rank.min(last - 1);
        let mut chain = vec![upper];
        for rank in first + 1..last {
            let vertex = self.rank.len();
            self.rank.push(rank);
            if rank == label_rank && label.0 > 0.0 {
                self.extent.push((label.0 / 2.0 + 2.0, label.0 / 2.0 + 2.0, label.1));
                self.label_at[i] = Some(vertex);
            } else {
                self.extent.push((1.0, 1.0, 0.0));
            }
            chain.push(vertex);
        }
        chain.push(lower);
        self.chains[i] = chain;
    }

    fn connect(&mut self) {
        let vertices = self.rank.len();
        self.down = vec![Vec::new(); vertices];
        self.up = vec![Vec::new(); vertices];
        for chain in &self.chains {
            for pair in chain.windows(2) {
                self.down[pair[0]].push(pair[1]);
                self.up[pair[1]].push(pair[0]);
            }
        }
        let ranks = self.rank.iter().max().map_or(0, |r| r + 1);
        self.layers = vec![Vec::new(); ranks];
        // First order: depth first from the top, which keeps branches together.
        let mut seen = vec![false; vertices];
        let mut roots: Vec<usize> = (0..vertices).collect();
        roots.sort_by_key(|&v| (self.rank[v], v));
        for root in roots {
            let mut stack = vec![root];
            while let Some(vertex) = stack.pop() {
                if std::mem::replace(&mut seen[vertex], true) {
                    continue;
                }
                self.layers[self.rank[vertex]].push(vertex);
                stack.extend(self.down[vertex].iter().rev());
            }
        }
    }

    /// Makes the groups of a rank contiguous, in the order of their places in it.
    pub(super) fn gather(&mut self, rank: usize) {
        let group = &self.group;
        let layer = &mut self.layers[rank];
        if !layer.iter().any(|&layer| group_of(group, layer).is_some()) {
            return;
        }
        let mut sums: Vec<(usize, usize)> = vec![(0, 0); self.real];
        for (i, &vertex) in layer.iter().enumerate() {
            if let Some(group) = group_of(group, vertex) {
                sums[group] = (sums[group].0 + i, sums[group].1 + 1);
            }
        }
        let mut keyed: Vec<(f64, usize, usize, usize)> = layer
            .iter()
            .enumerate()
            .map(|(i, &vertex)| match group_of(group, vertex) {
                Some(group) => (sums[group].0 as f64 / sums[group].1 as f64, group + 1, i, vertex),
                None => (i as f64, 0, i, vertex),
            })
            .collect();
        keyed.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        for (place, row) in layer.iter_mut().zip(keyed) {
            *place = row.3;
        }
    }

    pub(super) fn group_of(&self, vertex: usize) -> Option<usize> {
        group_of(&self.group, vertex)
    }

    /// Returns true if a vertex stands for a piece of an edge.
    pub(super) fn is_dummy(&self, vertex: usize) -> bool {
        vertex >= self.real
    }
}

fn group_of(group: &[Option<usize>], vertex: usize) -> Option<usize> {
    group.get(vertex).copied().flatten()
}

/// The columns of all nodes, if they can be the ranks.
fn columns(graph: &Graph, ends: &[Option<(usize, usize)>]) -> Option<Vec<usize>> {
    let columns: Option<Vec<usize>> = graph.nodes.iter().map(|node| node.column).collect();
    let columns = columns.filter(|column| !column.is_empty())?;
    let between = ends.iter().flatten().all(|&(from, to)| columns[from] != columns[to]);
    between.then_some(columns)
}

/// For each node, the number of its group: that of the first node in it.
fn groups(graph: &Graph) -> Vec<Option<usize>> {
    let first = |name: &str| {
        let mut nodes = graph.nodes.iter();
        nodes.position(|node| node.group.as_deref() == Some(name))
    };
    let groups = graph.nodes.iter().map(|node| first(node.group.as_deref()?));
    groups.collect()
}
