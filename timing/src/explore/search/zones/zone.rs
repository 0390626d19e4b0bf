//! Sets of remaining times.
//!
//! A *zone* is the set of all nonnegative values for the remaining times of some executors that satisfy upper
//! bounds on each and on their differences: a difference bound matrix (D. Dill, *Timing assumptions and
//! verification of finite-state concurrent systems*, 1989). Usual zones describe the time since an event;
//! these zones describe the time until the end of an execution. Remaining times only decrease, down to 0, so
//! that no extrapolation is needed: there are finitely many zones.

use smallvec::SmallVec;

use crate::system::{FOREVER, Ticks};

/// Greatest bound that zones can have.
pub(super) const GREATEST: Ticks = 1 << 29;

/// The absence of a bound.
const NONE: i32 = i32::MAX;

/// A nonempty set of remaining times.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Zone {
    /// Executors, in ascending order.
    executors: SmallVec<[u16; 12]>,
    /// Upper bounds of differences, row by row: of 0 and the executors, less 0 and the executors. They are as
    /// tight as possible.
    bounds: Vec<i32>,
}

impl Zone {
    /// Returns the zone of no executor.
    pub(super) fn new() -> Self {
        Zone { executors: SmallVec::new(), bounds: vec![0] }
    }

    /// Returns the number of rows of the matrix.
    fn rows(&self) -> usize {
        self.executors.len() + 1
    }

    fn row(&self, executor: usize) -> Option<usize> {
        let at = self.executors.iter();
        let mut at = at.map(|&executor| executor as usize);
        at.position(|index| index == executor).map(|index| index + 1)
    }

    fn at(&self, row: usize, column: usize) -> i32 {
        self.bounds[row * self.rows() + column]
    }

    /// Returns the shortest and longest time of each executor, in base units.
    pub(super) fn windows(&self) -> impl Iterator<Item = (usize, (Ticks, Ticks))> {
        self.executors.iter().enumerate().map(|(i, &executor)| {
            let longest = match self.at(i + 1, 0) {
                NONE => FOREVER,
                number => number as Ticks,
            };
            (executor as usize, (-self.at(0, i + 1) as Ticks, longest))
        })
    }

    /// Lets any possible time pass.
    pub(super) fn pass(&mut self) {
        for i in 1..self.rows() {
            // No other remaining time can become less than 0.
            let least = (1..self.rows()).map(|j| self.at(j, i)).fold(0, i32::min);
            self.bounds[i] = least;
        }
    }

    /// Keeps the times with which an executor ends now, and removes the executor. There must be such times.
    pub(super) fn end(&mut self, executor: usize) {
        let Some(row) = self.row(executor) else {
            return;
        };
        let n = self.rows();
        debug_assert_eq!(self.at(0, row), 0, "it can end now");
        for i in 0..n {
            for j in 0..n {
                let by_way = sum(self.at(i, row), self.at(0, j));
                let bound = &mut self.bounds[i * n + j];
                *bound = (*bound).min(by_way);
            }
        }
        let rest = self.executors.iter().map(|&executor| executor as usize);
        let rest: SmallVec<[usize; 12]> = rest.filter(|&index| index != executor).collect();
        self.set_executors(&rest, |_| unreachable!("all of them were there"));
    }

    /// Changes the executors, which must be in ascending order. A new executor gets any time of its `window`.
    pub(super) fn set_executors(
        &mut self,
        executors: &[usize],
        window: impl Fn(usize) -> (Ticks, Ticks),
    ) {
        if self.executors.iter().map(|&executor| executor as usize).eq(executors.iter().copied()) {
            return;
        }
        // The row of each executor in the old matrix, or its window.
        let known = |&index: &usize| self.row(index).ok_or_else(|| window(index));
        let rows: SmallVec<[Result<usize, (Ticks, Ticks)>; 12]> =
            std::iter::once(Ok(0)).chain(executors.iter().map(known)).collect();
        let longest = |row: &Result<usize, (Ticks, Ticks)>| match *row {
            Ok(row) => self.at(row, 0),
            Err((_, FOREVER)) => NONE,
            Err((_, longest)) => longest as i32,
        };
        let shortest = |row: &Result<usize, (Ticks, Ticks)>| match *row {
            Ok(row) => -self.at(0, row),
            Err((shortest, _)) => shortest as i32,
        };
        let mut bounds = Vec::with_capacity(rows.len() * rows.len());
        for (i, one) in rows.iter().enumerate() {
            for (j, other) in rows.iter().enumerate() {
                bounds.push(match (one, other) {
                    _ if i == j => 0,
                    (&Ok(one), &Ok(other)) => self.at(one, other),
                    _ => sum(longest(one), -shortest(other)),
                });
            }
        }
        self.bounds = bounds;
        self.executors = executors.iter().map(|&executor| executor as u16).collect();
    }

    /// Returns the zone with renamed executors.
    pub(super) fn renamed(&self, name: impl Fn(usize) -> usize) -> Zone {
        let named = self.executors.iter().enumerate();
        let mut named: SmallVec<[(u16, usize); 12]> =
            named.map(|(i, &number)| (name(number as usize) as u16, i + 1)).collect();
        named.sort_unstable();
        let rows = || std::iter::once(0).chain(named.iter().map(|pair| pair.1));
        Zone {
            executors: named.iter().map(|pair| pair.0).collect(),
            bounds: rows()
                .flat_map(|i| rows().map(move |j| (i, j)))
                .map(|(i, j)| self.at(i, j))
                .collect(),
        }
    }

    /// Returns true if the zone contains all values of another zone of the same executors.
    pub(super) fn covers(&self, other: &Zone) -> bool {
        debug_assert_eq!(self.executors, other.executors);
        let mut bounds = self.bounds.iter().zip(&other.bounds);
        bounds.all(|(wide, narrow)| wide >= narrow)
    }

    /// Returns the bytes in use.
    pub(super) fn memory(&self) -> usize {
        size_of::<Zone>() + self.bounds.capacity() * size_of::<i32>()
    }
}

/// Returns the sum of two bounds.
fn sum(one: i32, other: i32) -> i32 {
    if one == NONE || other == NONE { NONE } else { one + other }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zone(windows: &[(Ticks, Ticks)]) -> Zone {
        let mut out = Zone::new();
        let executors: Vec<usize> = (0..windows.len()).collect();
        out.set_executors(&executors, |index| windows[index]);
        out
    }

    fn windows(zone: &Zone) -> Vec<(usize, (Ticks, Ticks))> {
        zone.windows().collect()
    }

    #[test]
    fn what_ends_after_another_keeps_its_distance() {
        let mut zone = zone(&[(3, 5), (10, 10), (0, FOREVER)]);
        zone.pass();
        assert_eq!(windows(&zone), [(0, (0, 5)), (1, (5, 10)), (2, (0, FOREVER))]);
        zone.end(0);
        assert_eq!(windows(&zone), [(1, (5, 7)), (2, (0, FOREVER))]);
    }

    #[test]
    fn the_first_to_end_bounds_the_others() {
        let mut zone = zone(&[(0, 4), (6, 9)]);
        zone.pass();
        assert_eq!(windows(&zone), [(0, (0, 4)), (1, (2, 9))]);
        let before = zone.clone();
        zone.end(0);
        zone.set_executors(&[1, 2], |_| (1, 2));
        assert_eq!(windows(&zone), [(1, (2, 9)), (2, (1, 2))]);
        zone.pass();
        assert_eq!(windows(&zone), [(1, (0, 9)), (2, (0, 2))]);
        assert!(before.covers(&before));
    }

    #[test]
    fn wider_zones_cover_narrower_ones() {
        let (wide, narrow) = (zone(&[(0, 9), (0, 9)]), zone(&[(2, 5), (0, 9)]));
        assert!(wide.covers(&narrow));
        assert!(!narrow.covers(&wide));
        // The same windows, but one zone has a distance between the two times.
        let mut apart = zone(&[(0, 0), (9, 9)]);
        apart.pass();
        let free = zone(&[(0, 0), (9, 9)]);
        assert!(apart.covers(&free));
    }

    #[test]
    fn names_move_with_their_times() {
        let zone = zone(&[(1, 2), (3, 4)]).renamed(|index| 1 - index);
        assert_eq!(windows(&zone), [(0, (3, 4)), (1, (1, 2))]);
    }
}
