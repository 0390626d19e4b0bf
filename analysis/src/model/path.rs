//! The execution time of a machine on its path through given states.

use num_rational::Ratio;
use rustc_hash::{FxHashMap, FxHashSet};

use super::Seconds;
use super::fsm::Machine;

/// The result for the paths through given states.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Way {
    /// The path with the longest execution time.
    Longest {
        /// The states, the given ones and those between.
        states: Vec<String>,
        /// Sum of the worst-case execution times of the codels of all its states, including the last one, in
        /// seconds. Time in pauses is not included.
        time: Seconds,
        /// Number of pauses.
        pauses: usize,
        /// True if a codel on it has no execution time; it counts as zero.
        incomplete: bool,
    },
    /// Between two of the states the machine can cycle without limit.
    Endless {
        /// The states of the cycle, in order, the first one again at the end.
        cycle: Vec<String>,
    },
    /// There is no path.
    Broken {
        /// The last state that is reached.
        from: String,
        /// The next given state, which is not reached.
        to: String,
    },
}

/// The best known path from a position to a goal.
#[derive(Debug, Clone, PartialEq, Eq)]
enum BestPath {
    /// In progress.
    Open,
    /// The goal is not reached from there.
    Never,
    /// Time up to the goal without the goal's own, in seconds, and the next state, with true if it pauses
    /// before.
    Time(Seconds, (String, bool)),
}

/// States after the first, each with whether there is a pause before it.
type PathTail = Vec<(String, bool)>;

impl Machine<'_> {
    /// The path with the longest execution time from the first of these states through the others to the
    /// last. A direct transition from one of them to the next is taken if it exists; otherwise any states may
    /// be between. `ether` can be the last. `None` for fewer than two states.
    pub fn way(&self, states: &[&str]) -> Option<Way> {
        let (&first, rest) = states.split_first()?;
        if rest.is_empty() {
            return None;
        }
        let mut all = vec![first.to_owned()];
        let (mut pauses, mut from) = (0, first);
        for &to in rest {
            match self.leg(from, to) {
                Ok(Some(leg)) => {
                    pauses += leg.iter().filter(|leg| leg.1).count();
                    all.extend(leg.into_iter().map(|leg| leg.0));
                }
                Ok(None) => {
                    let (from, to) = (from.to_owned(), to.to_owned());
                    return Some(Way::Broken { from, to });
                }
                Err(cycle) => return Some(Way::Endless { cycle }),
            }
            from = to;
        }
        let mut time: Seconds = Ratio::from_integer(0);
        let mut incomplete = false;
        for (_, codel) in all.iter().filter_map(|text| self.codel(text)) {
            match &codel.wcet {
                Some(wcet) => time += wcet.value,
                None => incomplete = true,
            }
        }
        Some(Way::Longest { states: all, time, pauses, incomplete })
    }

    /// The transition from one state to another, or the longest path if there is none; see
    /// [`Machine::longest_between`].
    fn leg(&self, from: &str, to: &str) -> Result<Option<PathTail>, Vec<String>> {
        let yields = self.codel(from).map(|codel| codel.1.yields.iter());
        let direct = yields.into_iter().flatten().filter(|codel| codel.name == to);
        match direct.min_by_key(|codel| codel.paused) {
            Some(codel) => Ok(Some(vec![(to.to_owned(), codel.paused)])),
            None => self.longest_between(from, to),
        }
    }

    /// The longest path from one state to another, without the first, each state with true if there is a
    /// pause before it. `Ok(None)` if there is no path.
    ///
    /// # Errors
    /// Returns a cycle if paths of any length exist.
    fn longest_between(&self, from: &str, to: &str) -> Result<Option<PathTail>, Vec<String>> {
        let mut best: FxHashMap<String, BestPath> = FxHashMap::default();
        // Paths never contain `from` or `to` as inner states: the next choice of the reader is at the end of
        // the leg.
        let inner = |state: &str| state != from && state != to && self.position(state).is_some();
        // The states that lead to the goal: only cycles through those matter.
        let leads = self.states_leading_to(from, to);
        // Depth-first with an explicit stack: a machine may be as long as its file.
        let mut stack: Vec<(String, bool)> = vec![(from.to_owned(), false)];
        while let Some((state, done)) = stack.pop() {
            let Some((_, codel)) = self.codel(&state) else {
                continue;
            };
            if done {
                let zero = Ratio::from_integer(0);
                let own = codel.wcet.as_ref().map_or(zero, |wcet| wcet.value);
                let mut found = BestPath::Never;
                for next in &codel.yields {
                    let beyond = match best.get(next.name.as_str()) {
                        _ if next.name == to => zero,
                        Some(BestPath::Time(time, _)) => *time,
                        _ => continue,
                    };
                    let longer = match &found {
                        BestPath::Time(known, _) => own + beyond > *known,
                        _ => true,
                    };
                    if longer {
                        let step = (next.name.to_string(), next.paused);
                        found = BestPath::Time(own + beyond, step);
                    }
                }
                best.insert(state, found);
                continue;
            }
            if best.contains_key(&state) {
                continue;
            }
            best.insert(state.clone(), BestPath::Open);
            stack.push((state.clone(), true));
            for next in &codel.yields {
                let name = next.name.as_str();
                if !inner(name) || !leads.contains(name) {
                    continue;
                }
                match best.get(name) {
                    // An open state is on the current path.
                    Some(BestPath::Open) => {
                        let open =
                            stack.iter().filter(|stack| stack.1).map(|stack| stack.0.clone());
                        let mut cycle: Vec<String> =
                            open.skip_while(|stack| stack != name).collect();
                        cycle.push(name.to_owned());
                        return Err(cycle);
                    }
                    Some(BestPath::Time(..) | BestPath::Never) => {}
                    None => stack.push((name.to_owned(), false)),
                }
            }
        }
        let mut leg = Vec::new();
        let mut at = from.to_owned();
        while let Some(BestPath::Time(_, next)) = best.get(&at) {
            leg.push(next.clone());
            if next.0 == to {
                return Ok(Some(leg));
            }
            at.clone_from(&next.0);
        }
        Ok(None)
    }

    /// The states from which a path leads to a goal without passing its start.
    fn states_leading_to(&self, from: &str, to: &str) -> FxHashSet<String> {
        let mut before: FxHashMap<&str, Vec<&str>> = FxHashMap::default();
        for (_, codel) in &self.codels {
            for next in &codel.yields {
                let states = codel.triggers.iter().map(|trigger| trigger.name.as_str());
                before.entry(&next.name).or_default().extend(states);
            }
        }
        let mut found = FxHashSet::default();
        let mut pending = vec![to];
        while let Some(state) = pending.pop() {
            for &text in before.get(state).into_iter().flatten() {
                if found.insert(text.to_owned()) && text != from {
                    pending.push(text);
                }
            }
        }
        found
    }
}
