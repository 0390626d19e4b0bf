//! Sequences that grow without a copy.
//!
//! A full vector allocates twice its size and copies itself: for a moment it needs three times the memory of
//! its contents, in one step that no limit can stop. A sequence of segments allocates one more segment. So a
//! search that compares its bytes with a limit every few steps exceeds the limit by a few segments at most.

use std::ops::{Index, IndexMut};

/// Upper limit on the bytes of a segment, unless a single slice is longer.
const BYTES: usize = 1 << 20;

/// A sequence of values. Slices that were added together stay together.
#[derive(Debug)]
pub(crate) struct Segments<T> {
    /// The first segment grows like any vector; each other segment has its full capacity from the start.
    segments: Vec<Vec<T>>,
    /// The segment that is being filled.
    current: usize,
    /// Capacity of all segments, in values.
    capacity: usize,
}

impl<T> Default for Segments<T> {
    fn default() -> Self {
        Segments { segments: vec![Vec::new()], current: 0, capacity: 0 }
    }
}

impl<T> Segments<T> {
    /// Capacity of a segment, as a power of two.
    const SHIFT: u32 = (BYTES / size_of::<T>()).ilog2();

    const SIZE: usize = 1 << Self::SHIFT;

    /// Removes all values, and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.segments.iter_mut().for_each(Vec::clear);
        self.current = 0;
    }

    /// Adds a value. Returns its index.
    pub(crate) fn push(&mut self, element: T) -> usize {
        let place = self.room(1);
        let segment = &mut self.segments[self.current];
        let before = segment.capacity();
        segment.push(element);
        self.capacity += segment.capacity() - before;
        place
    }

    /// Returns the number of values, if they are only added one by one.
    pub(crate) fn len(&self) -> usize {
        (self.current << Self::SHIFT) + self.segments[self.current].len()
    }

    /// Removes the last value, if values are only added one by one.
    pub(crate) fn pop(&mut self) -> Option<T> {
        if self.segments[self.current].is_empty() && self.current > 0 {
            self.current -= 1;
        }
        self.segments[self.current].pop()
    }

    /// Returns the bytes allocated.
    pub(crate) fn memory(&self) -> usize {
        self.capacity * size_of::<T>()
    }

    /// Moves on to the next segment if the values do not fit in the present one. Returns the index of the
    /// first value.
    fn room(&mut self, values: usize) -> usize {
        let len = self.segments[self.current].len();
        // An empty slice also needs an index within a segment.
        if len > 0 && len + values.max(1) > Self::SIZE {
            self.current += 1;
            if self.current == self.segments.len() {
                self.segments.push(Vec::new());
            }
            let next = &mut self.segments[self.current];
            if next.capacity() == 0 {
                next.reserve_exact(values.max(Self::SIZE));
                self.capacity += next.capacity();
            }
        }
        (self.current << Self::SHIFT) + self.segments[self.current].len()
    }
}

impl<T: Copy> Segments<T> {
    /// Adds values that stay together. Returns the index of the first value.
    pub(crate) fn extend(&mut self, values: &[T]) -> usize {
        let place = self.room(values.len());
        let segment = &mut self.segments[self.current];
        let before = segment.capacity();
        segment.extend_from_slice(values);
        self.capacity += segment.capacity() - before;
        place
    }

    /// Returns `len` values from an index on, which were added together.
    #[inline]
    pub(crate) fn slice(&self, place: usize, len: usize) -> &[T] {
        let at = place & (Self::SIZE - 1);
        &self.segments[place >> Self::SHIFT][at..at + len]
    }
}

impl<T> Index<usize> for Segments<T> {
    type Output = T;

    #[inline]
    fn index(&self, place: usize) -> &T {
        &self.segments[place >> Self::SHIFT][place & (Self::SIZE - 1)]
    }
}

impl<T> IndexMut<usize> for Segments<T> {
    #[inline]
    fn index_mut(&mut self, place: usize) -> &mut T {
        &mut self.segments[place >> Self::SHIFT][place & (Self::SIZE - 1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_stay_together_and_are_found_again() {
        let mut all = Segments::<u32>::default();
        let mut places = Vec::new();
        let text: Vec<u32> = (0..BYTES as u32).collect();
        // 1,000 values each, a slice longer than a segment between them.
        for i in 0..1000 {
            let len = if i == 500 { BYTES } else { 1000 };
            places.push((all.extend(&text[i..len.max(i)]), i, len));
        }
        for &(place, i, len) in &places {
            assert_eq!(all.slice(place, len - i), &text[i..len]);
        }
        all.clear();
        let memory = all.memory();
        assert_eq!(all.extend(&text[..1000]), 0);
        assert_eq!(all.memory(), memory);
    }

    #[test]
    fn growth_is_by_segments() {
        let mut all = Segments::<u64>::default();
        let mut before = 0;
        for i in 0..1_000_000 {
            assert_eq!(all.push(i), i as usize);
            assert!(all.memory() - before <= BYTES, "at {i}");
            before = all.memory();
        }
        for i in (0..1_000_000).rev() {
            assert_eq!(all.len(), i as usize + 1);
            assert_eq!((all[i as usize], all.pop()), (i, Some(i)));
        }
        assert_eq!((all.len(), all.pop()), (0, None));
    }
}
