//! The execution time of a state machine without a pause.
//!
//! A *turn* is the execution of an automaton in one cycle of its task: from the state where it begins or
//! resumes to the next `pause::` or to `ether` (timed semantics, section 4). Below, a position is an index
//! into [`Machine::codels`].

use num_rational::Ratio;

use super::fsm::Machine;
use super::{Codel, Component, Seconds, TaskId};

/// The longest turn from some state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Turn {
    /// The sum is an upper bound, along these positions.
    Bounded {
        /// Sum of the execution times, in seconds.
        sum: Seconds,
        /// Positions in order.
        chain: Vec<usize>,
        /// True if a codel on the path has no execution time; it counts as zero.
        incomplete: bool,
    },
    /// The machine can cycle through these positions without end.
    Unbounded {
        /// Positions of the cycle, in order.
        cycle: Vec<usize>,
    },
}

impl<'m> Machine<'m> {
    pub fn at(&self, position: usize) -> &'m Codel {
        self.codels[position].1
    }

    /// States in which a turn can begin: `start`, `stop`, and the targets of `pause::`.
    pub(crate) fn turn_starts(&self) -> Vec<&'m str> {
        let mut out: Vec<&'m str> = Vec::new();
        for state in ["start", "stop"].into_iter().chain(self.resume_states()) {
            if self.position(state).is_some() && !out.contains(&state) {
                out.push(state);
            }
        }
        out
    }

    /// States in which a turn begins period after period: the targets of `pause::`.
    pub(crate) fn resume_states(&self) -> Vec<&'m str> {
        let mut out: Vec<&'m str> = Vec::new();
        let paused = self.codels.iter().flat_map(|(_, c)| &c.yields).filter(|s| s.paused);
        for state in paused.map(|s| s.name.as_str()) {
            if self.position(state).is_some() && !out.contains(&state) {
                out.push(state);
            }
        }
        out
    }

    /// Successors within the same turn.
    fn continues(&self, v: usize) -> impl Iterator<Item = usize> + '_ {
        self.at(v).yields.iter().filter(|s| !s.paused).filter_map(|s| self.position(&s.name))
    }

    /// Returns true if a wanted state is reached from `from` without a pause, or is `from` itself: a
    /// transition from that state to `from` that does not pause would close a cycle.
    pub fn reaches_without_pause(&self, from: &str, is_wanted: impl Fn(&str) -> bool) -> bool {
        let mut seen = vec![false; self.codels.len()];
        let mut pending: Vec<usize> = self.position(from).into_iter().collect();
        let mut found = is_wanted(from);
        while let Some(v) = pending.pop().filter(|_| !found) {
            if !std::mem::replace(&mut seen[v], true) {
                let mut yields = self.at(v).yields.iter();
                found = yields.any(|state| !state.paused && is_wanted(&state.name));
                pending.extend(self.continues(v));
            }
        }
        found
    }

    /// Cycles without `pause::`, one for each strongly connected group of states; each begins with its first
    /// vertex.
    pub(crate) fn cycles_without_pause(&self) -> Vec<Vec<usize>> {
        let mut out: Vec<Vec<usize>> = Vec::new();
        for v in 0..self.codels.len() {
            let known = |v: &usize| out.iter().flatten().any(|seen| seen == v);
            if known(&v) {
                continue;
            }
            if let Some(cycle) = self.cycle_through(v)
                && !cycle.iter().any(known)
            {
                out.push(cycle);
            }
        }
        out
    }

    /// A shortest cycle without `pause::` through a vertex.
    fn cycle_through(&self, v: usize) -> Option<Vec<usize>> {
        let mut before: Vec<Option<usize>> = vec![None; self.codels.len()];
        let mut queue = std::collections::VecDeque::from([v]);
        let mut seen = vec![false; self.codels.len()];
        seen[v] = true;
        while let Some(u) = queue.pop_front() {
            for next in self.continues(u) {
                if next == v {
                    let mut cycle = vec![u];
                    while let Some(p) = before[cycle[cycle.len() - 1]] {
                        cycle.push(p);
                    }
                    cycle.reverse();
                    return Some(cycle);
                }
                if !std::mem::replace(&mut seen[next], true) {
                    before[next] = Some(u);
                    queue.push_back(next);
                }
            }
        }
        None
    }

    /// The longest turn that begins in a state; `None` if no codel is bound to it.
    pub fn longest_turn(&self, state: &str) -> Option<Turn> {
        let start = self.position(state)?;
        let zero = || Ratio::from_integer(0);
        let mut best: Vec<Option<(Seconds, Option<usize>)>> = vec![None; self.codels.len()];
        let mut on_path = vec![false; self.codels.len()];
        // Depth-first with an explicit stack: a machine may be as long as its file.
        let mut stack = vec![(start, false)];
        while let Some((v, done)) = stack.pop() {
            if done {
                on_path[v] = false;
                let own = self.at(v).wcet.as_ref().map_or_else(zero, |q| q.value);
                let next = self
                    .continues(v)
                    .filter_map(|n| Some((best[n].as_ref()?.0, n)))
                    .max_by(|a, b| a.0.cmp(&b.0).then(b.1.cmp(&a.1)));
                best[v] = Some((own + next.map_or_else(zero, |n| n.0), next.map(|n| n.1)));
                continue;
            }
            if best[v].is_some() || on_path[v] {
                continue;
            }
            on_path[v] = true;
            stack.push((v, true));
            for next in self.continues(v) {
                if on_path[next] {
                    let cycle = self.cycle_through(next).unwrap_or_else(|| vec![next]);
                    return Some(Turn::Unbounded { cycle });
                }
                stack.push((next, false));
            }
        }
        let mut chain = vec![start];
        while let Some((_, Some(next))) = best[chain[chain.len() - 1]] {
            chain.push(next);
        }
        let sum = best[start].as_ref().map_or_else(zero, |b| b.0);
        let incomplete = self.within_turn(start).into_iter().any(|v| self.at(v).wcet.is_none());
        Some(Turn::Bounded { sum, chain, incomplete })
    }

    /// All vertices that a turn beginning at `start` may execute.
    fn within_turn(&self, start: usize) -> Vec<usize> {
        let mut seen = vec![false; self.codels.len()];
        let mut work = vec![start];
        while let Some(v) = work.pop() {
            if !std::mem::replace(&mut seen[v], true) {
                work.extend(self.continues(v));
            }
        }
        (0..seen.len()).filter(|&v| seen[v]).collect()
    }
}
impl Component {
    /// Longest steady turn of the permanent activity of a task, divided by its period; `None` without period,
    /// bound or any execution time.
    pub fn utilisation(&self, task: TaskId) -> Option<Seconds> {
        let task = self.tasks.get(task)?;
        let period = task.period.as_ref()?.value;
        if period <= Ratio::from_integer(0) {
            return None;
        }
        let machine = Machine::new(&task.codels);
        let turns = machine.resume_states().into_iter();
        let longest = turns.filter_map(|turn| match machine.longest_turn(turn)? {
            // Without any execution time nothing is known.
            Turn::Bounded { sum, .. } => (sum > Ratio::from_integer(0)).then_some(sum),
            Turn::Unbounded { .. } => None,
        });
        Some(longest.max()? / period)
    }
}
