//! The kept states: calm states, with the nodes from which they were reached.

use std::collections::BTreeMap;
use std::ops::Index;

use super::observations::Sight;
use crate::explore::segments::Segments;
use crate::explore::state::{Frame, State};
use crate::explore::store::{Covering, Encoded, Store, decode_to};
use crate::system::Ticks;

/// The number of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct NodeId(u32);

impl NodeId {
    /// The position before the first node: the start of every run.
    pub(super) const ROOT: NodeId = NodeId(u32::MAX);
}

/// A calm state: a key of the set of passed states, and its own box.
pub(super) struct Node {
    key: u32,
    start: usize,
    len: u32,
    pub(super) time: u64,
    /// First edge: the nodes from which this node was reached.
    edges: u32,
}

/// Bytes of a node in the queue.
const QUEUED: usize = 2 * size_of::<u32>();

/// The end of a list of edges, or of links.
const END: u32 = u32::MAX;

/// All nodes, their edges, and the queue of nodes whose next moment is still to come.
pub(super) struct Graph {
    passed: Store,
    nodes: Segments<Node>,
    dims: Segments<Ticks>,
    edges: Segments<(NodeId, u32)>,
    queue: BTreeMap<u64, Vec<NodeId>>,
}

impl Graph {
    /// Creates an empty graph, for states with this many clocks.
    pub(super) fn new(clocks: usize, covering: Covering) -> Graph {
        Graph {
            passed: Store::new(clocks, covering),
            nodes: Segments::default(),
            dims: Segments::default(),
            edges: Segments::default(),
            queue: BTreeMap::new(),
        }
    }

    /// Returns the number of nodes.
    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Keeps a state as a node, unless the state is covered by an earlier one.
    pub(super) fn keep(
        &mut self,
        encoding: &Encoded,
        time: u64,
        parents: impl Iterator<Item = NodeId>,
    ) -> Option<NodeId> {
        let key = self.passed.insert(encoding, 0, |_, _| 0)?;
        let mut edges = END;
        for parent in parents {
            edges = self.edges.push((parent, edges)) as u32;
        }
        let node = self.nodes.push(Node {
            key,
            start: self.dims.extend(&encoding.dims),
            len: encoding.dims.len() as u32,
            time,
            edges,
        });
        Some(NodeId(node as u32))
    }

    /// Returns the nodes from which a node was reached.
    pub(super) fn parents(&self, node: NodeId) -> impl Iterator<Item = NodeId> {
        let mut edge = self[node].edges;
        std::iter::from_fn(move || {
            if edge == END {
                return None;
            }
            let (parent, next) = self.edges[edge as usize];
            edge = next;
            Some(parent)
        })
    }

    /// Adds a node to the queue, with its next moment.
    pub(super) fn wait(&mut self, node: NodeId, until: u64) {
        self.queue.entry(until).or_default().push(node);
    }

    /// Removes the earliest moment from the queue, with its nodes.
    pub(super) fn next_moment(&mut self) -> Option<(u64, Vec<NodeId>)> {
        self.queue.pop_first()
    }

    /// Removes and returns the whole queue.
    pub(super) fn take_queue(&mut self) -> BTreeMap<u64, Vec<NodeId>> {
        std::mem::take(&mut self.queue)
    }

    pub(super) fn state(&self, frame: &Frame, node: NodeId) -> State {
        let mut s = State::default();
        self.state_to(frame, node, &mut s);
        s
    }

    /// Writes the state of a node to existing memory.
    pub(super) fn state_to(&self, frame: &Frame, node: NodeId, s: &mut State) {
        let node = &self[node];
        let dims = self.dims.slice(node.start, node.len as usize);
        decode_to(frame, self.passed.key(node.key), dims, s);
    }

    /// Returns the time from the moment of the parent node to a sight, in base units.
    pub(super) fn since(&self, at: Sight<NodeId>) -> Ticks {
        (at.time - self[at.parent].time) as Ticks
    }

    /// Returns the bytes in use.
    pub(super) fn memory(&self) -> usize {
        self.passed.memory()
            + self.nodes.memory()
            + self.dims.memory()
            + self.edges.memory()
            + self.nodes.len() * QUEUED
    }
}

impl Index<NodeId> for Graph {
    type Output = Node;

    fn index(&self, NodeId(id): NodeId) -> &Node {
        &self.nodes[id as usize]
    }
}

/// Lists of the nodes from which states of one moment were reached. Merged states join their lists.
#[derive(Default)]
pub(super) struct Links(Segments<(NodeId, u32)>);

impl Links {
    /// Adds a list of one node, and returns its index.
    pub(super) fn one(&mut self, parent: NodeId) -> u32 {
        self.0.push((parent, END)) as u32
    }

    /// Returns the bytes in use.
    pub(super) fn memory(&self) -> usize {
        self.0.memory()
    }

    /// Removes the last list.
    pub(super) fn undo(&mut self) {
        self.0.pop();
    }

    pub(super) fn list(&self, first: u32) -> impl Iterator<Item = NodeId> {
        let mut link = first;
        std::iter::from_fn(move || {
            if link == END {
                return None;
            }
            let (parent, next) = self.0[link as usize];
            link = next;
            Some(parent)
        })
    }

    /// Concatenates two lists.
    pub(super) fn join(&mut self, one: u32, other: u32) -> u32 {
        // Lists are short; parents already present are not repeated.
        let links = &mut self.0;
        let mut last = one;
        loop {
            if links[last as usize].0 == links[other as usize].0 && links[other as usize].1 == END {
                return one;
            }
            if links[last as usize].1 == END {
                break;
            }
            last = links[last as usize].1;
        }
        links[last as usize].1 = other;
        one
    }
}
