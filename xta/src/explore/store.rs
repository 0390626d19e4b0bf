//! The states found so far.

use std::rc::Rc;

use rustc_hash::FxHashMap;

use crate::zone::Zone;

/// A symbolic state with the state that it was reached from.
pub(crate) struct Node {
    pub(crate) parent: Option<u32>,
    /// Index of the integers.
    pub(crate) entry: u32,
    pub(crate) zone: Zone,
    /// Set if a larger state was found, so that the state need not be expanded.
    pub(crate) covered: bool,
}

/// Integers that occur in states, with what depends on them alone.
pub(crate) struct Entry {
    packed: Rc<[u8]>,
    pub(crate) can_delay: bool,
    nodes: Vec<u32>,
}

#[derive(Default)]
pub(crate) struct Store {
    index: FxHashMap<Rc<[u8]>, u32>,
    pub(crate) entries: Vec<Entry>,
    pub(crate) nodes: Vec<Node>,
}

impl Store {
    pub(crate) fn find(&self, packed: &[u8]) -> Option<u32> {
        self.index.get(packed).copied()
    }

    pub(crate) fn enter(&mut self, packed: Vec<u8>, can_delay: bool) -> u32 {
        let packed: Rc<[u8]> = packed.into();
        let entry = self.entries.len() as u32;
        self.entries.push(Entry { packed: packed.clone(), can_delay, nodes: Vec::new() });
        self.index.insert(packed, entry);
        entry
    }

    pub(crate) fn discrete(&self, entry: u32) -> Vec<i32> {
        unpack(&self.entries[entry as usize].packed)
    }

    /// Adds a state, unless a state includes it.
    pub(crate) fn add(&mut self, parent: Option<u32>, entry: u32, zone: Zone) -> Option<u32> {
        let known = &mut self.entries[entry as usize].nodes;
        if known.iter().any(|node| self.nodes[*node as usize].zone.includes(&zone)) {
            return None;
        }
        let nodes = &mut self.nodes;
        known.retain(|node| {
            let node = &mut nodes[*node as usize];
            node.covered = zone.includes(&node.zone);
            !node.covered
        });
        let node = nodes.len() as u32;
        known.push(node);
        nodes.push(Node { parent, entry, zone, covered: false });
        Some(node)
    }
}

/// Integers as bytes: one for values from -64 to 63.
pub(crate) fn pack(discrete: &[i32]) -> Vec<u8> {
    let mut out = Vec::with_capacity(discrete.len() + 8);
    for value in discrete {
        let mut rest = ((value << 1) ^ (value >> 31)) as u32;
        while rest >= 0x80 {
            out.push(rest as u8 | 0x80);
            rest >>= 7;
        }
        out.push(rest as u8);
    }
    out
}

fn unpack(packed: &[u8]) -> Vec<i32> {
    let mut out = Vec::with_capacity(packed.len());
    let (mut value, mut shift) = (0u32, 0u32);
    for byte in packed {
        value |= u32::from(byte & 0x7f) << shift;
        shift += 7;
        if byte & 0x80 == 0 {
            out.push((value >> 1) as i32 ^ -((value & 1) as i32));
            (value, shift) = (0, 0);
        }
    }
    out
}
