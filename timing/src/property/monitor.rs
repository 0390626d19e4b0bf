//! Monitors: automata that watch predicates along a run, one for each pattern of section 10 of the timed
//! semantics.

use super::{Atom, Predicate};
use crate::scn::ast::MonitorKind;
use crate::system::Ticks;

/// An automaton that is violated when the pattern is.
#[derive(Debug, Clone)]
pub struct Monitor {
    pub kind: MonitorKind,
    /// The predicates of the kind, in its order.
    pub predicates: Vec<Predicate>,
    /// Time in base units for which [`MonitorKind::Absent`] watches; otherwise 0.
    pub time: Ticks,
}

/// The location of a monitor that watches nothing yet.
pub(crate) const INITIAL: u16 = 0;
/// The location of a violated monitor.
pub(crate) const VIOLATED: u16 = 1;
/// Between the first predicate and the second.
const OPEN: u16 = 2;
/// Between the first predicate and the second, after the third has held.
const SEEN: u16 = 3;
/// Nothing can violate the monitor any more.
const OVER: u16 = 4;

impl Monitor {
    /// The location of a monitor that watches nothing yet.
    pub const INITIAL: u16 = INITIAL;
    /// The location of a violated monitor.
    pub const VIOLATED: u16 = VIOLATED;

    /// Returns true if a step shows something about the pattern: the predicate without which it says nothing
    /// becomes true (`opens`), or an interval that must end has ended. The locations are those before and
    /// after the step.
    pub fn is_exercised(&self, (before, now): (u16, u16), opens: bool) -> bool {
        if self.kind.closing().is_none() {
            return opens;
        }
        matches!(before, OPEN | SEEN) && matches!(now, INITIAL | VIOLATED)
    }

    /// Returns the predicate with which everything begins that the pattern is about.
    pub fn opening(&self) -> &Predicate {
        &self.predicates[self.kind.opening()]
    }

    /// Returns the location after a step from `location`, in a state in which `holds` gives the values of the
    /// predicates. `rises` is set if the first predicate has become true by this step. `left` is the time
    /// that is still watched; it begins again when it has to.
    pub fn next(
        &self,
        location: u16,
        rises: bool,
        left: &mut Ticks,
        holds: impl Fn(usize) -> bool,
    ) -> u16 {
        if matches!(location, VIOLATED | OVER) {
            return location;
        }
        match self.kind {
            MonitorKind::Absent => {
                if rises {
                    *left = self.time;
                }
                if *left > 0 && holds(1) { VIOLATED } else { INITIAL }
            }
            MonitorKind::Precedes if holds(0) => OVER,
            MonitorKind::Precedes if holds(1) => VIOLATED,
            MonitorKind::NeverBefore if holds(0) => {
                if location == SEEN {
                    VIOLATED
                } else {
                    OVER
                }
            }
            MonitorKind::NeverBefore if holds(1) => SEEN,
            MonitorKind::NeverAfter if location == OPEN || holds(0) => {
                if holds(1) {
                    VIOLATED
                } else {
                    OPEN
                }
            }
            MonitorKind::NeverBetween | MonitorKind::SomeBetween | MonitorKind::NeverUntil => {
                self.interval(location, holds)
            }
            _ => location,
        }
    }

    /// Returns the next location of the kinds with an interval from one predicate to another.
    fn interval(&self, location: u16, holds: impl Fn(usize) -> bool) -> u16 {
        if holds(1) {
            let is_wrong = match self.kind {
                MonitorKind::NeverBetween => location == SEEN,
                MonitorKind::SomeBetween => location == OPEN,
                _ => false,
            };
            return if is_wrong { VIOLATED } else { INITIAL };
        }
        let is_open = location != INITIAL || holds(0);
        match (is_open && holds(2), self.kind) {
            (true, MonitorKind::NeverUntil) => VIOLATED,
            (true, _) => SEEN,
            (false, _) if is_open && location != SEEN => OPEN,
            (false, _) => location,
        }
    }
}

impl Predicate {
    /// Returns the predicate that holds as soon as a monitor is violated. The number is that of the monitor
    /// in the list of what is watched.
    pub(crate) fn violated(monitor: usize) -> Predicate {
        Predicate::Atom(Atom::Violated(monitor))
    }
}

#[cfg(test)]
mod tests {
    use super::{INITIAL, Monitor, MonitorKind, VIOLATED};
    use crate::property::{Atom, Predicate, TaskState};

    /// Follows letters of `pqr` (those that hold), one word for each state. Returns the first violated state.
    fn violated_at(kind: MonitorKind, states: &str) -> Option<usize> {
        let any = Predicate::Atom(Atom::Task(0.into(), TaskState::Idle));
        let monitor = Monitor { kind, predicates: vec![any; 3], time: 2 };
        let (mut location, mut left, mut before) = (INITIAL, 0, false);
        states.split(' ').position(|state| {
            let holds = |index: usize| state.contains(['p', 'q', 'r'][index]);
            let rises = holds(0) && !before;
            before = holds(0);
            location = monitor.next(location, rises, &mut left, holds);
            left = left.saturating_sub(1);
            location == VIOLATED
        })
    }

    #[test]
    fn each_kind_is_violated_by_what_it_forbids_alone() {
        use MonitorKind::*;
        for (kind, kept, violated) in [
            (Absent, "q p - q", "- p q"),
            (Absent, "p p q", "p - p q"),
            (Absent, "- -", "pq"),
            (Precedes, "- p q", "- q p"),
            (Precedes, "pq", "q"),
            (NeverBefore, "q q", "q - p"),
            (NeverBefore, "- pq q", "q p"),
            (NeverAfter, "q q -", "p - q"),
            (NeverAfter, "q p", "pq"),
            (NeverBetween, "r p q r p r", "p r q"),
            (NeverBetween, "p qr", "- pr q"),
            (SomeBetween, "p r q q p", "p - q"),
            (SomeBetween, "pr q", "r p q"),
            (NeverUntil, "r p q r", "p r"),
            (NeverUntil, "pqr r", "p q p - r"),
        ] {
            assert_eq!(violated_at(kind, kept), None, "{kind:?}: {kept}");
            assert!(violated_at(kind, violated).is_some(), "{kind:?}: {violated}");
        }
    }
}
