//! The construction of the state graph, within a budget.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rustc_hash::FxHashMap;

use super::Budget;
use super::batch::Batches;
use super::model::Model;
use super::refusal::Refusal;
use super::state::{MISSED, Out, State, TaskProgress, TaskTimes};
use crate::cancel::Cancel;

/// Number of states that are followed at most if a deadline may be missed.
const AFTER_MISS: usize = 20_000;

/// Returns the bytes of a state with its key, as the lists of them double.
fn bytes_of_state(model: &Model) -> usize {
    let place = 2 * size_of::<TaskProgress>() + size_of::<TaskTimes>();
    let fixed =
        size_of::<State>() + size_of::<(Box<[TaskProgress]>, usize)>() + 4 * size_of::<usize>();
    2 * fixed + model.threads.len() * (place + 4 * size_of::<i64>())
}

/// The state graph of one part of a system.
pub(super) struct Search<'m> {
    model: &'m Model<'m>,
    cancel: &'m Cancel,
    batches: Option<Batches<'m>>,
    /// Upper limit on the states that are followed.
    budget: usize,
    /// Upper limit on the states that are kept.
    room: usize,
    known: FxHashMap<Box<[TaskProgress]>, usize>,
    states: Vec<State>,
    /// States that have become wider since they were followed.
    open: Vec<bool>,
    /// Open states, those with the fewest steps first, so that states are merged before they are followed.
    next: BinaryHeap<Reverse<(usize, usize)>>,
    /// Longest response time so far, by thread, in base units.
    worst: Vec<i64>,
}

impl<'m> Search<'m> {
    /// Prepares a search. With `batches`, busy windows are taken in one step if that proves their deadlines.
    pub(super) fn new(
        model: &'m Model<'m>,
        batches: Option<Batches<'m>>,
        budget: Budget,
        cancel: &'m Cancel,
    ) -> Self {
        Search {
            model,
            cancel,
            batches,
            budget: budget.states,
            room: budget.bytes / bytes_of_state(model),
            known: FxHashMap::default(),
            states: Vec::new(),
            open: Vec::new(),
            next: BinaryHeap::new(),
            worst: vec![0; model.threads.len()],
        }
    }

    /// Returns, by thread, a bound on its response time in base units.
    pub(super) fn run(mut self) -> Result<Vec<i64>, Refusal> {
        for s in self.model.initial() {
            self.add(s);
        }
        let mut looked_at = 0;
        let mut following = Vec::new();
        while let Some(Reverse((_, number))) = self.next.pop() {
            if !std::mem::take(&mut self.open[number]) {
                continue;
            }
            looked_at += 1;
            let over = looked_at > self.budget || self.states.len() > self.room;
            // A search with a small budget is tried again with batches.
            let is_last = self.budget >= AFTER_MISS;
            if looked_at > AFTER_MISS || over {
                let missed = self.worst.iter().position(|number| *number == MISSED);
                if let Some(thread) = missed.filter(|_| is_last) {
                    let task = self.model.threads[thread].task;
                    return Err(Refusal::MayMiss { task });
                }
                if over {
                    return Err(Refusal::States { looked_at });
                }
            }
            if looked_at.is_multiple_of(64) && self.cancel.is_over() {
                return Err(Refusal::Cancelled);
            }
            let s = self.states[number].clone();
            let mut out = Out {
                states: &mut following,
                worst: &mut self.worst,
            };
            let batch = self
                .batches
                .as_ref()
                .is_some_and(|batch| batch.follow(&s, &mut out));
            if !batch {
                self.model.follow(&s, &mut out)?;
            }
            for s in following.drain(..) {
                self.add(s);
            }
        }
        Ok(self.worst)
    }

    fn add(&mut self, s: State) {
        let key = s.key();
        let number = match self.known.get(&key) {
            Some(&number) => {
                if !self.states[number].widen(&s) {
                    return;
                }
                number
            }
            None => {
                let number = self.states.len();
                self.known.insert(key, number);
                self.states.push(s);
                self.open.push(false);
                number
            }
        };
        if !self.open[number] {
            self.open[number] = true;
            let steps = self.states[number].steps;
            self.next.push(Reverse((steps, number)));
        }
    }
}
