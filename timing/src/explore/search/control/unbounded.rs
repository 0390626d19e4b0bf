//! Depth-first search for times without a bound.
//!
//! Breadth-first search finds the proof that a job can take for ever only after all earlier events. In
//! depth-first search, mostly with codels that take their longest time, a job that is kept from ending soon
//! exceeds any plausible time. If the run repeats itself meanwhile, it can continue like that for ever.

use super::SearchControl;
use crate::explore::measure::{Divergence, Gauge, MeasurementMode, Timing};
use crate::explore::run::Run;
use crate::explore::search::depth_first::{DepthFirstSearch, Order};
use crate::explore::search::layers::Layers;
use crate::explore::search::observations::Observations;
use crate::explore::watch::{ResponseTime, Watch, Within};
use crate::system::{TaskId, Ticks};

/// Number of times that a search without a repetition is prolonged.
const MAX_DOUBLINGS: u32 = 5;

impl<'a> SearchControl<'a> {
    /// Returns the next time to examine, among those that may have no bound.
    pub(super) fn next_unbounded(&self, layers: &Layers<'a>) -> Option<usize> {
        let random_search = self.random_search.as_ref().ok()?;
        let gauges = layers.observations.gauges.iter().enumerate();
        let endless = |&(i, gauge): &(usize, &Gauge)| {
            gauge.active() && gauge.most.is_none() && !random_search.bounded.contains(&i)
        };
        let open: Vec<usize> = gauges.filter(endless).map(|gauge| gauge.0).collect();
        let turn = random_search.searches / Order::KINDS;
        open.get(turn as usize % open.len().max(1)).copied()
    }

    /// Runs some searches for a time without a bound.
    pub(super) fn search_unbounded(
        &mut self,
        layers: &Layers<'a>,
        gauge: usize,
    ) -> Option<Divergence> {
        let Gauge { of, limit, .. } = layers.observations.gauges[gauge];
        let mut watch = Watch::default();
        match of {
            Timing::Response(task) => watch.response.push(ResponseTime {
                task: TaskId::from(task),
                limit: None,
                most: None,
            }),
            Timing::Within(index) => watch
                .within
                .push(Within { limit: None, ..layers.observations.watch.within[index].clone() }),
        }
        let gauges = Gauge::of(&watch, &MeasurementMode::Shared);
        let rules = &layers.observations.rules;
        let observations = Observations::new(rules, &watch, &gauges, layers.limits.without);
        let mut search = DepthFirstSearch::new(observations, layers.limits, layers.cancel);
        for _ in 0..Order::KINDS {
            if !self.is_random_search_due(layers) {
                return None;
            }
            let order = self.random_search.as_mut().ok()?.next_order().steady();
            // A repetition may begin only after some time.
            for doubled in 0..MAX_DOUBLINGS {
                search.lasts = Some(layers.divergence_threshold.saturating_mul(1 << doubled));
                self.run_search(layers, &mut search, order, None);
                let Some((run, value)) = search.longest_run() else {
                    break;
                };
                if let Some(cycle) = search.repetition(&run, value) {
                    return Some(Divergence {
                        gauge,
                        excess: limit.and_then(|limit| exceeding(&run, value, limit, cycle)),
                        proof: Some(run.repeating(cycle)),
                    });
                }
            }
            if let Ok(random_search) = &mut self.random_search
                && search.is_exhausted()
                && !order.late
            {
                random_search.bounded.insert(gauge);
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
            steps: steps.take_while(|step| step.0 < end).collect(),
            end,
            ..Run::default()
        });
    };
    run.prolonged(cycle, more + 1)
}
