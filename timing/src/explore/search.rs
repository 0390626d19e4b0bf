//! Exploration: strategies that follow the rules in different orders, and a search control.
//!
//! [`goals`] lists what is searched for. [`observations`] performs single steps and records what they show.
//! [`layers`] proceed from moment to moment, keep a [`graph`] and reconstruct runs. [`mod@depth_first`]
//! proceeds depth first, in random orders. The [`control`] divides the effort between these strategies and
//! ends the exploration.

mod control;
mod depth_first;
mod goals;
mod graph;
mod layers;
mod observations;
mod walks;

use self::control::{CarryOver, FindingsReceiver, SearchControl};
pub use self::depth_first::search_once;
use self::layers::Layers;
pub use self::walks::{Walked, bytes_of_walks, walk};
use super::findings::Findings;
use super::measure::{Gauge, MeasurementMode, Timing};
use super::rules::Rules;
use super::watch::{Limits, Stop, Watch};
use crate::cancel::Cancel;
use crate::system::TimedSystem;

/// Explores all runs of a system.
pub fn explore(system: &TimedSystem, watch: &Watch, limits: Limits, cancel: &Cancel) -> Findings {
    explore_with_reports(system, watch, limits, cancel, &mut |_| {})
}

/// Explores all runs of a system, and reports failures and reached predicates as soon as they are seen. Such
/// findings contain nothing else; a finding may be reported again.
pub fn explore_with_reports(
    system: &TimedSystem,
    watch: &Watch,
    limits: Limits,
    cancel: &Cancel,
    news: &mut dyn FnMut(&Findings),
) -> Findings {
    explore_by(&Rules::new(system), watch, limits, cancel, news)
}

pub(super) fn explore_by(
    rules: &Rules,
    watch: &Watch,
    limits: Limits,
    cancel: &Cancel,
    news: &mut dyn FnMut(&Findings),
) -> Findings {
    let mut gauges = Gauge::of(watch, &MeasurementMode::Shared);
    let mut findings = until_measured(rules, watch, &mut gauges, limits, cancel, news);
    // A time that grew suspiciously is measured alone, so that clocks do not multiply.
    for (i, gauge) in gauges.iter().enumerate() {
        let given_up = findings.stopped.is_some_and(|stop| stop != Stop::Answered);
        if gauge.how != MeasurementMode::Alone || given_up {
            continue;
        }
        let mut alone = Watch::default();
        let place = match gauge.of {
            Timing::Response(_) => {
                alone.response.push(watch.response[i]);
                &mut findings.response[i]
            }
            Timing::Within(i) => {
                alone.within.push(watch.within[i].clone());
                &mut findings.within[i]
            }
        };
        let mut own = Gauge::of(&alone, &MeasurementMode::UntilRepetition);
        own[0].excess.clone_from(&gauge.excess);
        let mut found = until_measured(rules, &alone, &mut own, limits, cancel, &mut |_| {});
        *place = found.response.pop().or(found.within.pop()).flatten();
        findings.absorb(&found);
    }
    findings
}

/// Explores, and starts again without measurements that diverge.
fn until_measured(
    rules: &Rules,
    watch: &Watch,
    gauges: &mut [Gauge],
    limits: Limits,
    cancel: &Cancel,
    news: FindingsReceiver,
) -> Findings {
    let mut carry_over = CarryOver::none(watch, limits);
    loop {
        let mut layers = Layers::new(rules, watch, gauges, limits, cancel);
        let mut control = SearchControl::new(carry_over, &mut *news);
        let diverging = layers.run(&mut control);
        cancel.ended(control.states(&layers));
        let Some(diverging) = diverging else {
            return control.findings(&layers);
        };
        carry_over = control.into_carry_over(&layers);
        gauges[diverging.gauge].note(diverging);
    }
}
