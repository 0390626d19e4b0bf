//! Cause-effect chains under the semantics of the servers, from section 19 by the obvious method.

use std::collections::{BTreeSet, HashSet};

use dotgen_timing::system::chain::ChainKind;

use super::model::Datum;
use super::possible::Step;
use super::state::{Control, Doing, State, Who};
use super::{CAP, Interpreter};

/// A holder of variables: an instance by component, task and slot, or a request without one.
type Holder = (usize, Option<(usize, usize)>);

/// A datum; a variable with its holder.
type Kept = (Datum, Option<Holder>);

#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
struct Followed {
    /// Data that depend on the followed datum.
    data: BTreeSet<Kept>,
    /// Threads whose codel has read such data.
    readers: BTreeSet<(usize, Who)>,
    age: u32,
}

/// A state, and the data followed from it on; `None` before the measurement.
type Node = (State, Option<Followed>);

/// A chain: its first and last datum, and whether no codel writes the first one.
pub(crate) struct Chain {
    pub(crate) kind: ChainKind,
    pub(crate) first: Datum,
    pub(crate) last: Datum,
    pub(crate) external: bool,
}

impl Interpreter<'_> {
    /// Returns the greatest time: `Some(Some(CAP))` if it is unbounded, `Some(None)` if no datum is ever
    /// followed, and `None` above `limit` nodes.
    pub(crate) fn chain(&self, chain: &Chain, limit: usize) -> Option<Option<u32>> {
        let mut greatest = None;
        let mut seen: HashSet<Node> = HashSet::new();
        let mut todo: Vec<Node> = Vec::new();
        let mut initial = State::initial(self.system, 0);
        for (c, component) in self.system.components.iter().enumerate() {
            if !component.tasks.is_empty() {
                self.start(&mut initial, c, 0);
            }
        }
        self.come_to(chain, (initial, None), (&[], false), &mut todo);
        while let Some(node) = todo.pop() {
            if !seen.insert(node.clone()) {
                continue;
            }
            if seen.len() > limit {
                return None;
            }
            let (s, followed) = node;
            if let Some(followed) = &followed
                && (chain.kind == ChainKind::Reaction
                    || followed.data.contains(&(chain.last.clone(), None)))
            {
                greatest = greatest.max(Some(followed.age));
            }
            let (steps, urgent) = self.possible(&s);
            for step in steps {
                self.follow(chain, (&s, &followed), step, &mut todo);
            }
            if !urgent {
                let later = followed
                    .map(|followed| Followed { age: (followed.age + 1).min(CAP), ..followed });
                self.come_to(chain, (self.pass(&s), later), (&[], false), &mut todo);
            }
        }
        Some(greatest)
    }

    fn follow(
        &self,
        chain: &Chain,
        (s, followed): (&State, &Option<Followed>),
        step: Step,
        todo: &mut Vec<Node>,
    ) {
        let n = self.perform(s, step, &mut self.blank());
        let ended = match step {
            Step::End(c, t, _) => Some((c, Who::Task(t))),
            Step::Handled(c, _) => Some((c, Who::Control)),
            _ => None,
        };
        let mut followed = followed.clone();
        let mut first_written = false;
        if let Some((c, who)) = ended {
            let (_, writes) = self.named(s, c, who);
            first_written = writes.iter().any(|entry| entry.0 == chain.first);
            if let Some(followed) = &mut followed {
                let depends = followed.readers.remove(&(c, who));
                for datum in writes {
                    let arrives = depends && datum.0 == chain.last;
                    match chain.kind {
                        ChainKind::Reaction if arrives => return,
                        // A new first datum is another datum.
                        ChainKind::Age if !depends || datum.0 == chain.first => {
                            followed.data.remove(&datum);
                        }
                        _ if depends => {
                            followed.data.insert(datum);
                        }
                        _ => {}
                    }
                }
            }
        }
        let executing =
            |s: &State, c: usize, who: Who| matches!(s.doing(c, who), Some(Doing::Executing(_)));
        let everybody =
            (0..n.components.len()).flat_map(|c| n.everybody(c).map(move |thread| (c, thread)));
        let began: Vec<(usize, Who)> = everybody
            .filter(|&(c, who)| executing(&n, c, who))
            .filter(|&(c, who)| ended == Some((c, who)) || !executing(s, c, who))
            .collect();
        if let Some(followed) = &mut followed {
            self.read(followed, &n, &began);
            followed.data.retain(|data| match data.1 {
                Some((c, Some((t, slot)))) => n.components[c].tasks[t].slots[slot].is_some(),
                Some((c, None)) => {
                    matches!(n.components[c].control, Control::Codel(..) | Control::Rest(..))
                }
                None => true,
            });
            if followed.data.is_empty() && followed.readers.is_empty() {
                return;
            }
        }
        self.come_to(chain, (n, followed), (&began, first_written), todo);
    }

    /// Adds a state, with every possible beginning of a measurement.
    fn come_to(
        &self,
        chain: &Chain,
        (s, followed): Node,
        (began, first_written): (&[(usize, Who)], bool),
        todo: &mut Vec<Node>,
    ) {
        if followed.is_none() {
            let mut followed = Followed::default();
            let first = (chain.first.clone(), None);
            if chain.external && chain.kind == ChainKind::Age {
                for &(c, who) in began {
                    if self.named(&s, c, who).0.contains(&first) {
                        let mut followed = Followed::default();
                        followed.readers.insert((c, who));
                        todo.push((s.clone(), Some(followed)));
                    }
                }
            } else if chain.external {
                followed.data.insert(first);
                todo.push((s.clone(), Some(followed)));
            } else if first_written {
                followed.data.insert(first);
                self.read(&mut followed, &s, began);
                todo.push((s.clone(), Some(followed)));
            }
        }
        todo.push((s, followed));
    }

    fn read(&self, followed: &mut Followed, s: &State, began: &[(usize, Who)]) {
        for &(c, who) in began {
            let (reads, _) = self.named(s, c, who);
            if reads.iter().any(|datum| followed.data.contains(datum)) {
                followed.readers.insert((c, who));
            }
        }
    }

    /// Returns the data that the present codel of a thread reads and writes.
    fn named(&self, s: &State, c: usize, who: Who) -> (Vec<Kept>, Vec<Kept>) {
        let slot = match (&s.components[c].control, who) {
            (Control::Codel(request, ..), Who::Control) => request.slot,
            (_, Who::Control) => None,
            (_, Who::Task(t)) => s.slot(c, t).map(|slot| (t, slot)),
        };
        let Some(codel) = s.codel(self.system, c, who) else {
            return Default::default();
        };
        let codel = &self.system.components[c].codels[codel];
        let kept = |datum: &Datum| match datum {
            Datum::Variable(..) => (datum.clone(), Some((c, slot))),
            _ => (datum.clone(), None),
        };
        let all = |list: &[Datum]| list.iter().map(kept).collect();
        (all(&codel.reads), all(&codel.writes))
    }
}
