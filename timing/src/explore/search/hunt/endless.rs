//! Hunts for times that have no bound.
//!
//! A search in order of time comes to the proof that a job can take for ever only after everything that can
//! happen until then. Going straight on, mostly with codels that take as long as they can, a job that is kept
//! from ending soon takes longer than any plausible one; if the run repeats itself meanwhile, it can go on
//! like that.

use super::Order;
use super::chase::Chase;
use crate::explore::measure::{Diverging, Gauge, How, Timing};
use crate::explore::reductions::Reduced;
use crate::explore::rules::Action;
use crate::explore::run::Run;
use crate::explore::search::Search;
use crate::explore::watch::{ResponseTime, Watch, Within};
use crate::system::Ticks;

/// How often a chase is prolonged that goes on but does not repeat itself.
const DOUBLED: u32 = 5;

impl<R: Reduced> Search<'_, R> {
    /// Times that may have no bound, as far as is known.
    fn may_be_endless(&self) -> impl Iterator<Item = usize> {
        let all = self.gauges.iter().enumerate();
        let hunt = self.hunt.as_ref();
        let bounded = move |it: usize| hunt.is_some_and(|hunt| hunt.bounded.contains(&it));
        all.filter(move |&(i, it)| it.active() && it.most.is_none() && !bounded(i))
            .map(|(i, _)| i)
    }

    /// Whether an action is one of a task whose response time is measured.
    pub(super) fn is_measured(&self, action: Action) -> bool {
        let Some(task) = self.rules.task_of(action) else {
            return false;
        };
        self.gauges.iter().any(|it| it.of == Timing::Response(task))
    }

    /// The time whose turn it is.
    pub(super) fn next_endless(&self) -> Option<usize> {
        let n = self.may_be_endless().count();
        let turn = self.hunt.as_ref()?.chases / Order::KINDS;
        self.may_be_endless().nth(turn as usize % n.max(1))
    }

    /// Some chases for a time without bound.
    pub(super) fn hunt_endless(&mut self, gauge: usize) {
        let Gauge { of, limit, .. } = self.gauges[gauge];
        let mut watch = Watch::default();
        match of {
            Timing::Response(task) => watch.response.push(ResponseTime {
                task,
                limit: None,
                most: None,
            }),
            Timing::Within(it) => watch.within.push(Within {
                limit: None,
                ..self.watch.within[it].clone()
            }),
        }
        let gauges = Gauge::of(&watch, &How::Shared);
        let search = Search::new(&self.rules, &watch, &gauges, self.limits, self.cancel);
        let mut chase = Chase::new(search);
        for _ in 0..Order::KINDS {
            let due = self.is_hunt_due();
            let Some(order) = due.then(|| self.next_order()).flatten() else {
                return;
            };
            let order = order.steady();
            // A run that repeats itself may do so only after it has gone on for some time.
            for doubled in 0..DOUBLED {
                chase.lasts = Some(self.patience.saturating_mul(1 << doubled));
                self.run_chase(&mut chase, order, None);
                let Some((run, value)) = chase.lasted() else {
                    break;
                };
                if let Some(cycle) = chase.repetition(&run, value) {
                    self.diverging = Some(Diverging {
                        gauge,
                        excess: limit.and_then(|limit| exceeding(&run, value, limit, cycle)),
                        proof: Some(run.repeating(cycle)),
                    });
                    return;
                }
            }
            if let Some(hunt) = &mut self.hunt
                && chase.is_exhausted()
                && !order.late
            {
                hunt.bounded.insert(gauge);
            }
        }
    }
}

/// Of a run at whose end something has lasted so long, and repeats itself: one in which it has just lasted
/// longer than a limit.
fn exceeding(run: &Run, value: Ticks, limit: Ticks, cycle: (u64, u64)) -> Option<Run> {
    let Some(more) = limit.checked_sub(value) else {
        let end = run.end - u64::from(value - limit - 1);
        let steps = run.steps.iter().copied();
        return Some(Run {
            steps: steps.take_while(|it| it.0 < end).collect(),
            end,
            ..Run::default()
        });
    };
    run.prolonged(cycle, more + 1)
}
