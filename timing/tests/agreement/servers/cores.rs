//! Cores under preemption (section 22): the ready threads, and those that have a core.

use dotgen_timing::scn::ast::Policy;

use super::Interpreter;
use super::model::System;
use super::possible::Step;
use super::state::{Control, Doing, Phase, State, Who};

/// The priority of a task that states none, if other tasks state one.
const UNSTATED: u32 = 255;

impl System {
    pub(crate) fn preempts(&self) -> bool {
        self.cores.is_some() && matches!(self.policy, Policy::Priority | Policy::Fair)
    }

    /// Returns the priority, or the period if no task states a priority; the lower number goes first.
    fn priority(&self, c: usize, who: Who) -> u64 {
        let mut all = self.components.iter().flat_map(|component| &component.tasks);
        let stated = all.any(|task| task.priority.is_some());
        let of = |t: usize| {
            let task = &self.components[c].tasks[t];
            if stated {
                u64::from(task.priority.unwrap_or(UNSTATED))
            } else {
                task.period.map_or(u64::MAX, u64::from)
            }
        };
        match who {
            Who::Task(t) => of(t),
            Who::Control => (0..self.components[c].tasks.len()).map(of).min().unwrap_or(0),
        }
    }
}

impl Interpreter<'_> {
    pub(super) fn preempts(&self) -> bool {
        self.cores.is_some() && self.system.preempts()
    }

    /// Returns the ready threads: those that can act once they have a core.
    fn all_ready(&self, s: &State) -> Vec<(usize, Who)> {
        let all =
            (0..s.components.len()).flat_map(|c| s.everybody(c).map(move |thread| (c, thread)));
        all.filter(|&(c, who)| self.is_ready(s, c, who)).collect()
    }

    fn is_ready(&self, s: &State, c: usize, who: Who) -> bool {
        if who.task().is_some_and(|t| !self.needs_core(c, t)) {
            return false;
        }
        match s.doing(c, who) {
            Some(Doing::Queued) => return self.may_leave(s, c, who),
            Some(_) => return true,
            None => {}
        }
        match who {
            Who::Task(t) => {
                let task = &s.components[c].tasks[t];
                task.wake || task.phase == Phase::Between || self.wants(s, c, t)
            }
            Who::Control => match s.components[c].control {
                Control::Ready => s.components[c].signal || self.is_asked(s, c),
                Control::Rest(..) => true,
                _ => false,
            },
        }
    }

    fn is_asked(&self, s: &State, c: usize) -> bool {
        let mut all = s.clients.iter().enumerate();
        all.any(|(k, client)| self.asked(s, k) == Some(c) && !client.outstanding)
    }

    /// Returns the first threads of a list that fit on the cores, each bound task alone on its core.
    fn fit(&self, order: &[(usize, Who)]) -> Vec<(usize, Who)> {
        let tied = |&(c, who): &(usize, Who)| {
            let t = who.task()?;
            self.system.components[c].tasks[t].affinity
        };
        let mut out: Vec<(usize, Who)> = Vec::new();
        for order in order {
            let free = out.iter().all(|other| tied(other).is_none() || tied(other) != tied(order));
            if free && out.len() < self.cores.unwrap_or(usize::MAX) {
                out.push(*order);
            }
        }
        out
    }

    /// Returns true if a thread has a core, or needs none.
    pub(super) fn has_core(&self, s: &State, c: usize, who: Who) -> bool {
        if !self.preempts() || who.task().is_some_and(|t| !self.needs_core(c, t)) {
            return true;
        }
        if self.system.policy == Policy::Fair {
            s.on.contains(&(c, who))
        } else {
            let mut order = s.ready.clone();
            order.sort_by_key(|&(c, who)| self.system.priority(c, who));
            self.fit(&order).contains(&(c, who))
        }
    }

    /// Returns true if a thread has a core, or may get one.
    pub(super) fn may_get_core(&self, s: &State, c: usize, who: Who) -> bool {
        let mut open = Vec::new();
        if self.preempts() {
            self.gives(s, &mut open);
        }
        !open.is_empty() || self.has_core(s, c, who)
    }

    /// Removes threads from the cores that cannot act any more.
    pub(super) fn no_more_ready(&self, s: &mut State) {
        if self.preempts() {
            let ready = self.all_ready(s);
            s.ready.retain(|thread| ready.contains(thread));
            s.on.retain(|thread| ready.contains(thread));
            // The order in which threads of different priorities became ready is irrelevant.
            s.ready.sort_by_key(|&(c, who)| self.system.priority(c, who));
        }
    }

    /// Adds the steps of threads that have become ready: they are listed in any order, or take a free core.
    pub(super) fn gives(&self, s: &State, out: &mut Vec<Step>) {
        for pair in self.all_ready(s) {
            if self.system.policy == Policy::Priority {
                if !s.ready.contains(&pair) {
                    out.push(Step::Queue(pair));
                }
            } else if !s.on.contains(&pair) {
                let mut order = s.on.clone();
                order.push(pair);
                if self.fit(&order).len() == order.len() {
                    out.push(Step::Give(pair));
                }
            }
        }
    }

    /// Adds swaps: without priorities any ready thread may take the core of another at any moment.
    pub(super) fn swaps(&self, s: &State, out: &mut Vec<Step>) {
        if !self.preempts() || self.system.policy != Policy::Fair {
            return;
        }
        for pair in self.all_ready(s).into_iter().filter(|pair| !s.on.contains(pair)) {
            for &other in &s.on {
                let mut order = s.on.clone();
                order.retain(|order| *order != other);
                order.push(pair);
                if self.fit(&order).len() == order.len() {
                    out.push(Step::Swap(pair, other));
                }
            }
        }
    }

    /// Returns the thread of a step; `None` if the step needs no core.
    pub(super) fn thread(&self, s: &State, step: Step) -> Option<(usize, Who)> {
        match step {
            Step::Ask(c, t) | Step::Begin(c, t) | Step::Wake(c, t) => Some((c, Who::Task(t))),
            Step::Ticket(c, who) | Step::Leave(c, who) => Some((c, who)),
            Step::Rest(c) | Step::Report(c) => Some((c, Who::Control)),
            Step::Request(k, _) => Some((self.asked(s, k)?, Who::Control)),
            _ => None,
        }
    }
}
