//! Coarser models, which have fewer states and never lower bounds.
//!
//! A task forgets between two jobs what it has done: it rests before its first job, or after some job. So
//! each job that could follow some rest can follow every job. A task that has ended only rests, and every
//! tick of it may find no work. Places with the same codel and the same successors are one place. The codels
//! of a job that waits for no lock are one codel.

use rustc_hash::FxHashMap;

use super::cycle_automaton::{CycleAutomaton, Place, Rest, Successor};
use super::model::Model;
use super::span::Span;
use crate::system::CodelId;

/// The rest after every job.
const REST: usize = 1;

impl<'s> Model<'s> {
    /// Returns the model whose tasks forget between two jobs what they have done.
    pub(super) fn coarse(&self) -> Model<'s> {
        let mut model = self.clone();
        let groups: Vec<usize> = model.threads.iter().map(|thread| thread.group).collect();
        for thread in &mut model.threads {
            let is_single = groups.iter().filter(|&&group| group == thread.group).count() == 1;
            let interference = self.interference[thread.group].as_ref();
            let longest = |codel: CodelId| match interference.filter(|_| thread.contends) {
                Some(interference) => interference.longest[codel],
                None => Some(0),
            };
            thread.cycle_automaton = (thread.cycle_automaton.as_ref())
                .map(|automaton| coarse(automaton, &|codel| longest(codel).filter(|_| is_single)));
            if !thread.paused.is_empty() {
                thread.paused = vec![REST];
            }
        }
        model
    }
}

/// Returns the automaton with one rest after the first cycle. `wait` is the longest time for which a codel
/// waits for locks, or `None` if that depends on other tasks.
fn coarse(automaton: &CycleAutomaton, wait: &dyn Fn(CodelId) -> Option<i64>) -> CycleAutomaton {
    let mut builder = Builder {
        automaton,
        places: Vec::new(),
        known: FxHashMap::default(),
        numbers: vec![None; automaton.places.len()],
        ends: false,
    };
    let first = builder.successors(&automaton.rests[0].begins);
    let later = automaton.rests.iter().skip(1);
    let begins: Vec<Successor> = later.flat_map(|rest| rest.begins.iter().copied()).collect();
    let begins = builder.successors(&begins);
    let begins = builder.whole_jobs(&begins, wait).unwrap_or(begins);
    let skips = builder.ends || automaton.rests.iter().skip(1).any(|rest| rest.skips);
    CycleAutomaton {
        rests: vec![
            Rest { begins: first, skips: automaton.rests[0].skips },
            Rest { begins, skips },
        ],
        places: builder.places,
        paused: vec![None; 2],
    }
}

struct Builder<'a> {
    automaton: &'a CycleAutomaton,
    places: Vec<Place>,
    known: FxHashMap<Place, usize>,
    /// Number of the place that stands for a place of the automaton.
    numbers: Vec<Option<usize>>,
    /// The task may end.
    ends: bool,
}

impl Builder<'_> {
    /// Returns the places that stand for some places, without repetition, in order.
    fn successors(&mut self, all: &[Successor]) -> Vec<Successor> {
        let mut out: Vec<Successor> = all.iter().map(|&one| self.successor(one)).collect();
        out.sort_unstable();
        out.dedup();
        out
    }

    fn successor(&mut self, successor: Successor) -> Successor {
        match successor {
            Successor::Goes(place) => Successor::Goes(self.place(place)),
            Successor::Rests(_) => Successor::Rests(REST),
            Successor::Ends => {
                self.ends = true;
                Successor::Rests(REST)
            }
        }
    }

    /// Returns the place that stands for a place, after those that stand for its successors.
    fn place(&mut self, place: usize) -> usize {
        let mut todo = vec![place];
        while let Some(&place) = todo.last() {
            let automaton = self.automaton;
            let from = &automaton.places[place];
            let open = from.then.iter().chain(&from.thrown).filter_map(|next| match next {
                Successor::Goes(next) if self.numbers[*next].is_none() => Some(*next),
                _ => None,
            });
            let open: Vec<usize> = open.collect();
            if !open.is_empty() {
                todo.extend(open);
                continue;
            }
            todo.pop();
            if self.numbers[place].is_none() {
                let merged = Place {
                    then: self.successors(&from.then),
                    thrown: self.successors(&from.thrown),
                    ..from.clone()
                };
                self.numbers[place] = Some(self.number(merged));
            }
        }
        self.numbers[place].unwrap_or_default()
    }

    fn number(&mut self, place: Place) -> usize {
        if let Some(&number) = self.known.get(&place) {
            return number;
        }
        self.known.insert(place.clone(), self.places.len());
        self.places.push(place);
        self.places.len() - 1
    }

    /// Returns one place for all jobs that begin in these ways, which takes as long as any of them; `None` if
    /// that depends on other tasks.
    fn whole_jobs(
        &mut self,
        begins: &[Successor],
        wait: &dyn Fn(CodelId) -> Option<i64>,
    ) -> Option<Vec<Successor>> {
        let mut spans: Vec<Option<Span>> = Vec::new();
        // Successors have lower numbers.
        for place in &self.places {
            let rest = place.then.iter().chain(&place.thrown).map(|next| match next {
                Successor::Goes(next) => spans[*next],
                _ => Some(Span::default()),
            });
            let rest = rest.reduce(|one, other| Some(one?.hull(other?))).flatten();
            let span = rest.zip(wait(place.codel)).map(|(rest, wait)| {
                let span = place.time.plus(rest);
                Span { to: span.to + wait, ..span }
            });
            spans.push(span);
        }
        let (mut out, mut jobs) = (Vec::new(), Vec::new());
        for &begin in begins {
            match begin {
                Successor::Goes(place) => jobs.push(place),
                other => out.push(other),
            }
        }
        let spans: Option<Vec<Span>> = jobs.iter().map(|&job| spans[job]).collect();
        let time = spans?.into_iter().reduce(Span::hull);
        if let (Some(time), Some(&first)) = (time, jobs.first()) {
            let job = Place {
                codel: self.places[first].codel,
                time,
                waits: false,
                then: vec![Successor::Rests(REST)],
                thrown: Vec::new(),
            };
            out.push(Successor::Goes(self.number(job)));
        }
        Some(out)
    }
}
