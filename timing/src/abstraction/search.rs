//! The construction of the state graph, within a budget.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rustc_hash::FxHashMap;

use super::batch::Batches;
use super::model::Model;
use super::refusal::Refusal;
use super::state::{Out, State, TaskProgress, TaskTimes};
use crate::cancel::Cancel;
use crate::system::TaskId;

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
    /// Upper limit on the states that are kept.
    room: usize,
    /// Number of states that have been followed.
    followed: usize,
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
        bytes: usize,
        cancel: &'m Cancel,
    ) -> Self {
        let mut search = Search {
            model,
            cancel,
            batches,
            room: bytes / bytes_of_state(model),
            followed: 0,
            known: FxHashMap::default(),
            states: Vec::new(),
            open: Vec::new(),
            next: BinaryHeap::new(),
            worst: vec![0; model.threads.len()],
        };
        model.initial().into_iter().for_each(|state| search.add(state));
        search
    }

    /// Follows up to this number of states in all, and returns, by thread, a bound on its response time in
    /// base units. A search that is given up can be run again with a higher limit. Unless it `goes_on`, it
    /// ends soon after a possible miss.
    pub(super) fn run(&mut self, limit: usize, goes_on: bool) -> Result<Vec<i64>, Refusal> {
        let mut following = Vec::new();
        while let Some(&Reverse((_, number))) = self.next.peek() {
            let over = self.followed >= limit || self.states.len() > self.room;
            if over || (self.followed >= AFTER_MISS && !goes_on) {
                if let Some(task) = self.missed().filter(|_| limit >= AFTER_MISS) {
                    return Err(Refusal::MayMiss { task });
                }
                if over {
                    let looked_at = self.followed;
                    return Err(Refusal::States { looked_at });
                }
            }
            self.next.pop();
            if !std::mem::take(&mut self.open[number]) {
                continue;
            }
            self.followed += 1;
            if self.followed.is_multiple_of(64) && self.cancel.is_over() {
                return Err(Refusal::Cancelled);
            }
            let s = self.states[number].clone();
            let mut out = Out { states: &mut following, worst: &mut self.worst };
            let batch = self.batches.as_ref().is_some_and(|batch| batch.follow(&s, &mut out));
            if !batch {
                let followed = self.model.follow(&s, &mut out);
                if let Err(refusal) = followed {
                    // The state counts as not followed, if the search is run again.
                    self.reopen(number);
                    return Err(refusal);
                }
            }
            for s in following.drain(..) {
                self.add(s);
            }
        }
        Ok(self.worst.clone())
    }

    /// Returns a task that may miss a deadline.
    fn missed(&self) -> Option<TaskId> {
        let mut all = self.model.threads.iter().zip(&self.worst);
        let missed = all.find(|(thread, worst)| **worst >= thread.period)?;
        Some(missed.0.task)
    }

    fn add(&mut self, s: State) {
        let key = s.key();
        let number = if let Some(&number) = self.known.get(&key) {
            if !self.states[number].widen(&s) {
                return;
            }
            number
        } else {
            let number = self.states.len();
            self.known.insert(key, number);
            self.states.push(s);
            self.open.push(false);
            number
        };
        self.reopen(number);
    }

    /// Opens a state, if it is not open.
    fn reopen(&mut self, number: usize) {
        if !self.open[number] {
            self.open[number] = true;
            let steps = self.states[number].steps;
            self.next.push(Reverse((steps, number)));
        }
    }
}
