//! The hash table of a set of states.
//!
//! A full table allocates a table of twice its size and copies itself. So a large set has many tables: each
//! doubles on its own, which takes a small part of the memory of the set.

use hashbrown::HashTable;

/// Number of entries from which on a table is divided.
const DIVIDED: usize = 1 << 16;

/// Number of parts of a divided table.
const PARTS: usize = 256;

/// Numbers, by hash.
#[derive(Debug)]
pub(super) struct Table {
    /// One table, or [`PARTS`] tables.
    parts: Vec<HashTable<u32>>,
    /// Capacity of all parts, in entries.
    capacity: usize,
}

impl Default for Table {
    fn default() -> Self {
        Table { parts: vec![HashTable::new()], capacity: 0 }
    }
}

impl Table {
    /// Removes all entries, and keeps the memory.
    pub(super) fn clear(&mut self) {
        self.parts.iter_mut().for_each(HashTable::clear);
    }

    /// Returns the number with this hash for which `is` returns true.
    pub(super) fn find(&self, hash: u64, mut is: impl FnMut(u32) -> bool) -> Option<u32> {
        self.parts[self.part(hash)].find(hash, |&number| is(number)).copied()
    }

    /// Adds a number that is not in the table. `hash_of` returns the hash of a number in the table.
    pub(super) fn insert(&mut self, hash: u64, number: u32, hash_of: impl Fn(u32) -> u64) {
        if self.parts.len() == 1 && self.parts[0].len() == DIVIDED {
            self.divide(&hash_of);
        }
        let part = self.part(hash);
        let table = &mut self.parts[part];
        let before = table.capacity();
        table.insert_unique(hash, number, |&number| hash_of(number));
        self.capacity += table.capacity() - before;
    }

    /// Returns the approximate number of bytes allocated.
    pub(super) fn memory(&self) -> usize {
        self.capacity * 5
    }

    /// Returns the part of a hash, from bits that a table of its size does not use itself.
    fn part(&self, hash: u64) -> usize {
        (hash >> 40) as usize & (self.parts.len() - 1)
    }

    fn divide(&mut self, hash_of: &impl Fn(u32) -> u64) {
        let whole = std::mem::take(&mut self.parts).into_iter().flatten();
        self.parts.resize_with(PARTS, HashTable::new);
        for number in whole {
            let hash = hash_of(number);
            let part = self.part(hash);
            self.parts[part].insert_unique(hash, number, |&number| hash_of(number));
        }
        self.capacity = self.parts.iter().map(HashTable::capacity).sum();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Spreads a number over all bits.
    fn hash(number: u32) -> u64 {
        u64::from(number + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15)
    }

    #[test]
    fn a_large_table_grows_in_small_steps() {
        let mut all = Table::default();
        for i in 0..1_000_000 {
            let before = all.memory();
            assert_eq!(all.find(hash(i), |table| table == i), None);
            all.insert(hash(i), i, hash);
            let grown = all.memory() - before;
            assert!(i < DIVIDED as u32 || grown * 64 < all.memory() + (1 << 20), "{grown} at {i}");
        }
        for i in (0..1_000_000).step_by(997) {
            assert_eq!(all.find(hash(i), |table| table == i), Some(i));
        }
        all.clear();
        assert_eq!(all.find(hash(7), |table| table == 7), None);
    }
}
