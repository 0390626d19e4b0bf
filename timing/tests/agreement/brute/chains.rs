//! Cause-effect chains, from section 19 by the obvious method. At any write of the first datum (at any
//! moment, if no codel writes it) a measurement may begin, and the data that depend on this datum are
//! followed step by step.

use std::collections::{BTreeSet, HashSet};

use dotgen_timing::explore::Action;
use dotgen_timing::system::chain::{Chain, ChainKind, DataPlace};

use super::state::{Doing, Mode, State, Step};
use super::{Brute, CAP};
use dotgen_timing::system::{AutomatonId, ComponentId};

/// A place: shared, or the variable of an instance, or of the request that a control task handles.
type Datum = (DataPlace, Option<usize>);

#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
struct Followed {
    /// Places with data that depend on the followed datum.
    places: BTreeSet<Datum>,
    /// Executors whose codel has read such data.
    readers: BTreeSet<usize>,
    age: u32,
}

/// A state, and the data followed from it on; `None` before the measurement.
type Node = (State, Option<Followed>);

impl Brute<'_> {
    /// Returns the greatest time: `Some(Some(CAP))` if it is unbounded, `Some(None)` if no datum is ever
    /// followed, and `None` above `limit` states.
    pub(crate) fn chain(&self, chain: &Chain, limit: usize) -> Option<Option<u32>> {
        let mut greatest = None;
        let mut seen: HashSet<Node> = HashSet::new();
        let mut todo: Vec<Node> = Vec::new();
        let initial = self.initial();
        let began = self.begun(None, &initial, None);
        self.come_to(chain, (initial, None), (&began, false), &mut todo);
        while let Some(node) = todo.pop() {
            if !seen.insert(node.clone()) {
                continue;
            }
            if seen.len() > limit {
                return None;
            }
            let (s, followed) = node;
            if let Some(followed) = &followed {
                let counts = match chain.kind {
                    ChainKind::Reaction => true,
                    ChainKind::Age => {
                        followed.places.contains(&(DataPlace::Shared(chain.last), None))
                    }
                };
                if counts {
                    greatest = greatest.max(Some(followed.age));
                }
            }
            let (actions, urgent) = self.actions(&s);
            for action in actions {
                self.step(chain, (&s, &followed), action, &mut todo);
            }
            if !urgent {
                let later = followed
                    .map(|followed| Followed { age: (followed.age + 1).min(CAP), ..followed });
                self.come_to(chain, (self.pass(&s), later), (&[], false), &mut todo);
            }
        }
        Some(greatest)
    }

    fn step(
        &self,
        chain: &Chain,
        (s, followed): (&State, &Option<Followed>),
        action: Action,
        todo: &mut Vec<Node>,
    ) {
        let n = self.perform(s, action, &mut self.blank());
        let codels = s.automata.len() + s.controls.len();
        let ended = match action {
            Action::Finish { executor, .. } if executor < codels => Some(executor),
            _ => None,
        };
        let mut followed = followed.clone();
        let mut first_written = false;
        if let Some(e) = ended {
            let codel = self.codel(s, e);
            first_written = chain.writes[codel].contains(&DataPlace::Shared(chain.first));
            if let Some(followed) = &mut followed {
                let depends = followed.readers.remove(&e);
                for &place in &chain.writes[codel] {
                    let datum = self.datum(e, place);
                    if depends
                        && place == DataPlace::Shared(chain.last)
                        && chain.kind == ChainKind::Reaction
                    {
                        // The datum has arrived.
                        return;
                    }
                    let new_first =
                        place == DataPlace::Shared(chain.first) && chain.kind == ChainKind::Age;
                    if depends && !new_first {
                        followed.places.insert(datum);
                    } else if chain.kind == ChainKind::Age {
                        followed.places.remove(&datum);
                    }
                }
            }
        }
        let automata = s.automata.len();
        if let (Some(followed), Some(e)) = (&mut followed, ended)
            && e >= automata
        {
            // The variables of a request become those of its instance.
            let born = |&a: &AutomatonId| {
                s.automata[a].mode == Mode::Void && n.automata[a].mode != Mode::Void
            };
            for a in s.automata.keys().filter(born) {
                let of_request = followed.places.iter().filter(|place| place.1 == Some(e));
                let own: Vec<Datum> =
                    of_request.map(|request| (request.0, Some(a.into()))).collect();
                followed.places.extend(own);
            }
        }
        let began = self.begun(Some(s), &n, ended);
        if let Some(followed) = &mut followed {
            self.read(chain, followed, &n, &began);
            // Variables last as long as the instance, or the handling of the request.
            followed.places.retain(|place| match place.1 {
                Some(e) if e < automata => n.automata[AutomatonId::from(e)].mode != Mode::Void,
                Some(e) => !matches!(n.controls[ComponentId::from(e - automata)].step, Step::Ready),
                None => true,
            });
            if followed.places.is_empty() && followed.readers.is_empty() {
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
        (began, first_written): (&[usize], bool),
        todo: &mut Vec<Node>,
    ) {
        if followed.is_none() {
            let first = (DataPlace::Shared(chain.first), None);
            let mut begin = |followed: Followed| todo.push((s.clone(), Some(followed)));
            if !chain.external {
                if first_written {
                    let mut followed = Followed::default();
                    followed.places.insert(first);
                    self.read(chain, &mut followed, &s, began);
                    begin(followed);
                }
            } else if chain.kind == ChainKind::Reaction {
                let mut followed = Followed::default();
                followed.places.insert(first);
                begin(followed);
            } else {
                for &e in began {
                    let codel = self.codel(&s, e);
                    if chain.reads[codel].contains(&first.0) && chain.carries[codel] {
                        let mut followed = Followed::default();
                        followed.readers.insert(e);
                        begin(followed);
                    }
                }
            }
        }
        todo.push((s, followed));
    }

    fn read(&self, chain: &Chain, followed: &mut Followed, s: &State, began: &[usize]) {
        for &e in began {
            let codel = self.codel(s, e);
            let mut reads = chain.reads[codel].iter();
            if chain.carries[codel]
                && reads.any(|&place| followed.places.contains(&self.datum(e, place)))
            {
                followed.readers.insert(e);
            }
        }
    }

    fn datum(&self, e: usize, place: DataPlace) -> Datum {
        match place {
            DataPlace::Shared(_) => (place, None),
            DataPlace::Local(_) => (place, Some(e)),
        }
    }

    /// Returns the executors that have begun a codel in a step.
    fn begun(&self, before: Option<&State>, s: &State, ended: Option<usize>) -> Vec<usize> {
        let executing = |s: &State, e: usize| matches!(self.doing(s, e), Doing::Executing(_));
        let codels = s.automata.len() + s.controls.len();
        (0..codels)
            .filter(|&e| executing(s, e))
            .filter(|&e| ended == Some(e) || !before.is_some_and(|state| executing(state, e)))
            .collect()
    }
}
