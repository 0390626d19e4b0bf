//! Depth-first search for times without a bound.
//!
//! Breadth-first search finds the proof that a job can take for ever only after all earlier events. In
//! depth-first search, mostly with codels that take their longest time, a job that is kept from ending soon
//! exceeds any plausible time. If the run repeats itself meanwhile, it can continue like that for ever.

use super::Supervisor;
use crate::explore::measure::{Diverging, Gauge, How, Timing};
use crate::explore::reductions::Reduced;
use crate::explore::run::Run;
use crate::explore::search::chase::{Chase, Order};
use crate::explore::search::layers::Layers;
use crate::explore::search::watching::Watching;
use crate::explore::watch::{ResponseTime, Watch, Within};
use crate::system::Ticks;

/// Number of times that a chase without a repetition is prolonged.
const DOUBLED: u32 = 5;

impl<'a, R: Reduced> Supervisor<'a, R> {
    /// Returns the next time to examine, among those that may have no bound.
    pub(super) fn next_endless(&self, layers: &Layers<'a, R>) -> Option<usize> {
        let hunt = self.hunt.as_ref().ok()?;
        let gauges = layers.watching.gauges.iter().enumerate();
        let endless = |&(i, it): &(usize, &Gauge)| {
            it.active() && it.most.is_none() && !hunt.bounded.contains(&i)
        };
        let open: Vec<usize> = gauges.filter(endless).map(|it| it.0).collect();
        let turn = hunt.chases / Order::KINDS;
        open.get(turn as usize % open.len().max(1)).copied()
    }

    /// Runs some chases for a time without a bound.
    pub(super) fn hunt_endless(
        &mut self,
        layers: &Layers<'a, R>,
        gauge: usize,
    ) -> Option<Diverging> {
        let Gauge { of, limit, .. } = layers.watching.gauges[gauge];
        let mut watch = Watch::default();
        match of {
            Timing::Response(task) => watch.response.push(ResponseTime {
                task,
                limit: None,
                most: None,
            }),
            Timing::Within(it) => watch.within.push(Within {
                limit: None,
                ..layers.watching.watch.within[it].clone()
            }),
        }
        let gauges = Gauge::of(&watch, &How::Shared);
        let rules = &layers.watching.rules;
        let watching = Watching::new(rules, &watch, &gauges, layers.limits.without);
        let mut chase = Chase::new(watching, layers.limits, layers.cancel);
        for _ in 0..Order::KINDS {
            if !self.is_hunt_due(layers) {
                return None;
            }
            let order = self.hunt.as_mut().ok()?.next_order().steady();
            // A repetition may begin only after some time.
            for doubled in 0..DOUBLED {
                chase.lasts = Some(layers.patience.saturating_mul(1 << doubled));
                self.run_chase(layers, &mut chase, order, None);
                let Some((run, value)) = chase.lasted() else {
                    break;
                };
                if let Some(cycle) = chase.repetition(&run, value) {
                    return Some(Diverging {
                        gauge,
                        excess: limit.and_then(|limit| exceeding(&run, value, limit, cycle)),
                        proof: Some(run.repeating(cycle)),
                    });
                }
            }
            if let Ok(hunt) = &mut self.hunt
                && chase.is_exhausted()
                && !order.late
            {
                hunt.bounded.insert(gauge);
            }
        }
        None
    }
}

/// Returns the part of a run in which a time has just exceeded the limit. At the end of the given run, the
/// time has lasted for `value` base units, and the run repeats itself.
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
