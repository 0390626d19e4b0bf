//! Sets of states, by key and box.
//!
//! Keys are interned byte strings. For each key there is a list of *covers*: boxes whose union contains every
//! inserted box. Two facts make this exact for reachability:
//!
//! * *Union.* The future of an executing codel depends only on when it ends. So states that differ only in
//!   the remaining time of one executor, over adjoining ranges, behave together like one state with the
//!   joined range.
//! * *Inclusion.* A state with wider windows can do whatever a state with narrower windows can. Observation
//!   clocks influence no action, and only their supremum is measured, so that an older clock covers a younger
//!   one.

mod table;

use rustc_hash::FxHasher;
use smallvec::SmallVec;
use std::hash::Hasher;

use self::table::Table;
use super::segments::Segments;
use super::state::{Frame, State};
use crate::system::Ticks;

const NONE: u32 = u32::MAX;

/// A key and a box, encoded for look-up.
#[derive(Debug, Default, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Encoded {
    pub(crate) key: Vec<u8>,
    /// Lower and upper bound of each active window, then the clocks.
    pub(crate) dims: Vec<Ticks>,
}

/// Encodes a state as key and box.
pub(crate) fn encode(l: &Frame, s: &State, out: &mut Encoded) {
    out.key.clear();
    out.dims.clear();
    // Most numbers are small. Without branches, many of them are encoded at once.
    if s.d.iter().fold(0, |most, &value| most.max(value)) < 255 {
        out.key.extend(s.d.iter().map(|&value| value as u8));
    } else {
        for &value in &s.d {
            if value < 255 {
                out.key.push(value as u8);
            } else {
                out.key.push(255);
                out.key.extend(value.to_le_bytes());
            }
        }
    }
    for &value in l.key_times(s) {
        varint(&mut out.key, value);
    }
    for executor in l.executing(s) {
        let (a, b) = l.window(s, executor);
        out.dims.push(a);
        out.dims.push(b);
    }
    out.dims.extend(l.clock_values(s));
}

/// Returns the state encoded as `key` and `dims`.
pub(crate) fn decode(l: &Frame, key: &[u8], dims: &[Ticks]) -> State {
    let mut s = State::default();
    decode_to(l, key, dims, &mut s);
    s
}

/// Decodes a state into the memory of another state.
pub(crate) fn decode_to(l: &Frame, key: &[u8], dims: &[Ticks], s: &mut State) {
    l.clear(s);
    let mut at = 0;
    let small = &key[..s.d.len()];
    if small.iter().fold(0, |most, &key| most.max(key)) < 255 {
        at = small.len();
        for (value, &key) in s.d.iter_mut().zip(small) {
            *value = u16::from(key);
        }
    } else {
        for value in &mut s.d {
            if key[at] < 255 {
                *value = u16::from(key[at]);
                at += 1;
            } else {
                *value = u16::from_le_bytes([key[at + 1], key[at + 2]]);
                at += 3;
            }
        }
    }
    for value in l.key_times_mut(s) {
        *value = read_varint(key, &mut at);
    }
    let mut at = 0;
    for executor in 0..l.executors() {
        if l.is_executing(s, executor) {
            l.set_window(s, executor, (dims[at], dims[at + 1]));
            at += 2;
        }
    }
    l.clock_values_mut(s).copy_from_slice(&dims[at..]);
}

fn varint(out: &mut Vec<u8>, mut value: u32) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn read_varint(key: &[u8], at: &mut usize) -> u32 {
    let mut value = 0;
    let mut shift = 0;
    loop {
        let byte = key[*at];
        *at += 1;
        value |= u32::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return value;
        }
        shift += 7;
    }
}

/// The geometry of boxes: `windows` pairs of bounds, then clocks.
#[derive(Debug, Clone, Copy)]
struct Shape {
    windows: usize,
    covering: Covering,
}

/// The relations between boxes that reduce a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Covering {
    /// Adjoining boxes are joined.
    pub(crate) union: bool,
    /// A larger box covers a smaller one. Otherwise a box covers only itself.
    pub(crate) inclusion: bool,
}

impl Default for Covering {
    fn default() -> Self {
        Covering { union: true, inclusion: true }
    }
}

impl Shape {
    fn covers(self, cover: &[Ticks], ticks: &[Ticks]) -> bool {
        let at = 2 * self.windows;
        match self.covering {
            Covering { inclusion: true, .. } => {}
            // A joined box stands for all of its parts.
            Covering { union: true, .. } if cover[at..] == ticks[at..] => {}
            _ => return cover == ticks,
        }
        let (wide, narrow) = (&cover[..2 * self.windows], &ticks[..2 * self.windows]);
        wide.chunks_exact(2).zip(narrow.chunks_exact(2)).all(|(w, n)| w[0] <= n[0] && n[1] <= w[1])
            && cover[2 * self.windows..].iter().zip(&ticks[2 * self.windows..]).all(|(c, i)| c >= i)
    }

    /// If the union of two boxes is a box, makes `it` that box.
    fn join(self, other: &[Ticks], ticks: &mut [Ticks]) -> bool {
        if !self.covering.union || other[2 * self.windows..] != ticks[2 * self.windows..] {
            return false;
        }
        let mut differing = None;
        for i in 0..self.windows {
            if other[2 * i..2 * i + 2] != ticks[2 * i..2 * i + 2] {
                if differing.is_some() {
                    return false;
                }
                differing = Some(i);
            }
        }
        let Some(i) = differing else { return true };
        let (a, b) = (other[2 * i], other[2 * i + 1]);
        let (c, d) = (ticks[2 * i], ticks[2 * i + 1]);
        if a > d.saturating_add(1) || c > b.saturating_add(1) {
            return false;
        }
        ticks[2 * i] = a.min(c);
        ticks[2 * i + 1] = b.max(d);
        true
    }
}

/// A set of states.
#[derive(Debug, Default)]
pub(crate) struct Store {
    table: Table,
    keys: Segments<Key>,
    key_bytes: Segments<u8>,
    covers: Segments<Cover>,
    dims: Segments<Ticks>,
    clocks: usize,
    covering: Covering,
}

#[derive(Debug)]
struct Key {
    start: usize,
    len: u32,
    hash: u64,
    first: u32,
}

#[derive(Debug)]
struct Cover {
    start: usize,
    len: u32,
    next: u32,
    /// A tag of the owner of the store.
    tag: u32,
}

impl Store {
    /// Creates an empty set of states with this many clocks.
    pub(crate) fn new(clocks: usize, covering: Covering) -> Self {
        Store { clocks, covering, ..Store::default() }
    }

    /// Removes all states, and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.table.clear();
        self.keys.clear();
        self.key_bytes.clear();
        self.covers.clear();
        self.dims.clear();
    }

    /// Adds a state. Returns its key, or `None` if a cover already contains the state. `on_join` gets the
    /// tags of covers that became part of the new cover, and returns the tag of the new cover.
    pub(crate) fn insert(
        &mut self,
        encoding: &Encoded,
        tag: u32,
        mut on_join: impl FnMut(u32, u32) -> u32,
    ) -> Option<u32> {
        let hash = hash(&encoding.key);
        let shape =
            Shape { windows: (encoding.dims.len() - self.clocks) / 2, covering: self.covering };
        let found = self.table.find(hash, |k| {
            let key = &self.keys[k as usize];
            key.hash == hash && self.bytes_of(key) == encoding.key
        });
        let k = if let Some(k) = found {
            k
        } else {
            let k = self.keys.push(Key {
                start: self.key_bytes.extend(&encoding.key),
                len: encoding.key.len() as u32,
                hash,
                first: NONE,
            }) as u32;
            let keys = &self.keys;
            self.table.insert(hash, k, |k| keys[k as usize].hash);
            k
        };

        let mut cover = self.keys[k as usize].first;
        while cover != NONE {
            let record = &self.covers[cover as usize];
            let dims = self.dims.slice(record.start, record.len as usize);
            if shape.covers(dims, &encoding.dims) {
                return None;
            }
            cover = record.next;
        }

        // Join the box with adjoining covers, until there are none; drop covers that it contains.
        let mut dims: SmallVec<[Ticks; 32]> = SmallVec::from_slice(&encoding.dims);
        let mut tag = tag;
        // A join may let covers adjoin that were examined before, so the list is examined again.
        let mut again = true;
        while again {
            again = false;
            let mut before = NONE;
            let mut cover = self.keys[k as usize].first;
            while cover != NONE {
                let record = &self.covers[cover as usize];
                let next = record.next;
                let other = self.dims.slice(record.start, record.len as usize);
                let covered = shape.covers(&dims, other);
                if covered || shape.join(other, &mut dims) {
                    again |= !covered;
                    tag = if covered { tag } else { on_join(tag, record.tag) };
                    if before == NONE {
                        self.keys[k as usize].first = next;
                    } else {
                        self.covers[before as usize].next = next;
                    }
                } else {
                    before = cover;
                }
                cover = next;
            }
        }
        let cover = self.covers.push(Cover {
            start: self.dims.extend(&dims),
            len: dims.len() as u32,
            next: self.keys[k as usize].first,
            tag,
        });
        self.keys[k as usize].first = cover as u32;
        Some(k)
    }

    /// Returns the covers of the key with these bytes.
    pub(crate) fn find(&self, key: &[u8]) -> impl Iterator<Item = (&[Ticks], u32)> {
        let hash = hash(key);
        let found = self.table.find(hash, |k| {
            let entry = &self.keys[k as usize];
            entry.hash == hash && self.bytes_of(entry) == key
        });
        found.into_iter().flat_map(|k| self.covers(k))
    }

    /// Returns the bytes of a key.
    pub(crate) fn key(&self, key: u32) -> &[u8] {
        self.bytes_of(&self.keys[key as usize])
    }

    fn bytes_of(&self, key: &Key) -> &[u8] {
        self.key_bytes.slice(key.start, key.len as usize)
    }

    /// Returns the number of keys.
    pub(crate) fn len(&self) -> usize {
        self.keys.len()
    }

    /// Returns the number of covers of all keys, including covers that have been joined.
    pub(crate) fn count(&self) -> usize {
        self.covers.len()
    }

    /// Returns the covers of a key with their tags.
    pub(crate) fn covers(&self, key: u32) -> impl Iterator<Item = (&[Ticks], u32)> {
        let mut cover = self.keys[key as usize].first;
        std::iter::from_fn(move || {
            if cover == NONE {
                return None;
            }
            let record = &self.covers[cover as usize];
            cover = record.next;
            let dims = self.dims.slice(record.start, record.len as usize);
            Some((dims, record.tag))
        })
    }

    /// Returns the approximate number of bytes in use.
    pub(crate) fn memory(&self) -> usize {
        self.table.memory()
            + self.keys.memory()
            + self.key_bytes.memory()
            + self.covers.memory()
            + self.dims.memory()
    }
}

fn hash(key: &[u8]) -> u64 {
    let mut hasher = FxHasher::default();
    hasher.write(key);
    hasher.finish()
}

/// Returns true if a box of this layout contains a point (or smaller box).
pub(crate) fn holds(layout: &Frame, cover: &[Ticks], ticks: &[Ticks]) -> bool {
    let clocks = layout.clocks();
    Shape { windows: (ticks.len() - clocks) / 2, covering: Covering::default() }
        .covers(cover, ticks)
}
