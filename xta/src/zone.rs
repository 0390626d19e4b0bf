//! Zones as difference bound matrices.
//!
//! Index 0 is the constant 0, the others are clocks. A cell `(i, j)` bounds `x_i - x_j`. Its value is
//! `2 v + 1` for `<= v` and `2 v` for `< v`. All matrices are closed under shortest paths, except where said.

/// No bound.
pub(crate) const INFINITE: i32 = i32::MAX;

/// `<= 0`
pub(crate) const ZERO: i32 = 1;

/// Largest value of a bound. Larger ones are an error of the model.
pub(crate) const LARGEST_BOUND: i32 = 1 << 27;

/// A bound `x_i - x_j < v` or `<= v`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Constraint {
    pub(crate) i: u32,
    pub(crate) j: u32,
    pub(crate) bound: i32,
}

impl Constraint {
    /// The constraint that holds where this one does not.
    pub(crate) fn negated(self) -> Constraint {
        Constraint { i: self.j, j: self.i, bound: 1 - self.bound }
    }
}

pub(crate) fn at_most(value: i32) -> i32 {
    2 * value + 1
}

pub(crate) fn below(value: i32) -> i32 {
    2 * value
}

fn add(a: i32, b: i32) -> i32 {
    if a == INFINITE || b == INFINITE {
        return INFINITE;
    }
    // The sum of the values, which is strict if one of the two is.
    ((a >> 1) + (b >> 1)) * 2 + (a & b & 1)
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Zone {
    size: usize,
    cells: Box<[i32]>,
}

impl Zone {
    /// All clocks are 0.
    pub(crate) fn origin(size: usize) -> Zone {
        Zone { size, cells: vec![ZERO; size * size].into() }
    }

    pub(crate) fn get(&self, i: usize, j: usize) -> i32 {
        self.cells[i * self.size + j]
    }

    fn set(&mut self, i: usize, j: usize, bound: i32) {
        self.cells[i * self.size + j] = bound;
    }

    /// Intersects with a constraint. Returns whether the zone is not empty. An empty zone must not be used.
    #[must_use]
    pub(crate) fn constrain(&mut self, constraint: Constraint) -> bool {
        let Constraint { i, j, bound } = constraint;
        let (i, j, n) = (i as usize, j as usize, self.size);
        if bound >= self.get(i, j) {
            return true;
        }
        if add(bound, self.get(j, i)) < ZERO {
            return false;
        }
        self.set(i, j, bound);
        for a in 0..n {
            let through = add(self.get(a, i), bound);
            if through == INFINITE {
                continue;
            }
            for b in 0..n {
                let path = add(through, self.get(j, b));
                if path < self.get(a, b) {
                    self.set(a, b, path);
                }
            }
        }
        true
    }

    /// Intersects with constraints. Returns whether the zone is not empty.
    #[must_use]
    pub(crate) fn constrain_all(&mut self, constraints: &[Constraint]) -> bool {
        constraints.iter().all(|constraint| self.constrain(*constraint))
    }

    /// Lets time pass.
    pub(crate) fn up(&mut self) {
        for i in 1..self.size {
            self.set(i, 0, INFINITE);
        }
    }

    /// Adds what reaches the zone by letting time pass.
    pub(crate) fn down(&mut self) {
        for j in 1..self.size {
            let lowest = (1..self.size).map(|i| self.get(i, j)).fold(ZERO, i32::min);
            self.set(0, j, lowest);
        }
    }

    /// The zone of new clocks, each of which is an old clock or the constant 0, plus a value.
    pub(crate) fn project(&self, sources: &[(usize, i32)]) -> Zone {
        let size = sources.len();
        let mut cells = Vec::with_capacity(size * size);
        for (from, plus) in sources {
            for (to, minus) in sources {
                let bound = self.get(*from, *to);
                cells.push(if bound == INFINITE { bound } else { bound + 2 * (plus - minus) });
            }
        }
        Zone { size, cells: cells.into() }
    }

    pub(crate) fn includes(&self, other: &Zone) -> bool {
        self.cells.iter().zip(&other.cells).all(|(large, small)| large >= small)
    }

    /// The parts of the zone in which not all constraints hold, as constraints to add. They are disjoint.
    pub(crate) fn without(&self, constraints: &[Constraint]) -> Vec<Vec<Constraint>> {
        let mut rest = self.clone();
        let mut before = Vec::new();
        let mut out = Vec::new();
        for constraint in constraints {
            let mut part = rest.clone();
            if part.constrain(constraint.negated()) {
                let mut all: Vec<Constraint> = before.clone();
                all.push(constraint.negated());
                out.push(all);
            }
            before.push(*constraint);
            if !rest.constrain(*constraint) {
                break;
            }
        }
        out
    }

    /// All finite bounds.
    pub(crate) fn constraints(&self) -> Vec<Constraint> {
        let mut out = Vec::new();
        for i in 0..self.size {
            for j in 0..self.size {
                let bound = self.get(i, j);
                if i != j && bound != INFINITE {
                    out.push(Constraint { i: i as u32, j: j as u32, bound });
                }
            }
        }
        out
    }

    /// Extrapolation Extra+LU of Behrmann, Bouyer, Larsen and Pelánek (2006), then closure. The constants
    /// of index 0 are unused. A constant of -1 says that the clock is not compared from this side.
    pub(crate) fn extrapolate(&mut self, lower: &[i32], upper: &[i32]) {
        let n = self.size;
        let first: Vec<i32> = (0..n).map(|j| self.get(0, j)).collect();
        let mut changed = false;
        for i in 0..n {
            for j in 0..n {
                let old = self.get(i, j);
                if i == j || old == INFINITE {
                    continue;
                }
                let past_upper = j != 0 && beyond(first[j], upper[j]);
                let far = i != 0
                    && (lower[i] < 0
                        || (old >> 1) > lower[i]
                        || beyond(first[i], lower[i])
                        || past_upper);
                let new = match (i, past_upper) {
                    (0, true) if upper[j] < 0 => ZERO,
                    (0, true) => below(-upper[j]),
                    _ if far => INFINITE,
                    _ => old,
                };
                if new > old {
                    self.set(i, j, new);
                    changed = true;
                }
            }
        }
        if changed {
            self.close();
        }
    }

    fn close(&mut self) {
        let n = self.size;
        for k in 0..n {
            for i in 0..n {
                let left = self.get(i, k);
                if left == INFINITE {
                    continue;
                }
                for j in 0..n {
                    let path = add(left, self.get(k, j));
                    if path < self.get(i, j) {
                        self.set(i, j, path);
                    }
                }
            }
        }
    }
}

/// Reports whether the lower bound in a cell `(0, j)` is above a constant.
fn beyond(cell: i32, constant: i32) -> bool {
    let (value, weak) = (-(cell >> 1), cell & 1 == 1);
    // `x >= value` or `x > value`.
    value > constant || (value == constant && !weak)
}
