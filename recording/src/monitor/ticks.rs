//! Ticks of a periodic task, as far as the beginnings of its turns tell.
//!
//! Tick number *i* comes at *a* + *iP*. Its turn begins at some time *sᵢ* from then on, at most *L* later:
//! the greatest response time, or the period. So *a* lies in [*sᵢ* - *iP* - *L*, *sᵢ* - *iP*] for every *i*,
//! and a run of which these intervals have no moment in common has ticks that are not *P* apart.

use super::SLACK;
use super::What;

/// Turns at the start that may come out of step: what the timer counted while the server started.
const START_UP: u64 = 2;

/// What is known of a task.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Periodic {
    turns: u64,
    /// The turn that is number 0.
    known: Option<Phase>,
}

#[derive(Debug, Clone, Copy)]
struct Phase {
    /// Number of the last turn.
    number: i64,
    /// When tick 0 came: not before this,
    earliest: i64,
    /// and not after this.
    latest: i64,
}

impl Periodic {
    /// A turn begins. Returns what is wrong with it.
    pub(super) fn begins(&mut self, at: i64, period: i64, latest: i64) -> Option<What> {
        self.turns += 1;
        if self.turns <= START_UP {
            return None;
        }
        let fresh = Phase {
            number: 0,
            earliest: at.saturating_sub(latest),
            latest: at,
        };
        let Some(known) = &mut self.known else {
            self.known = Some(fresh);
            return None;
        };
        known.number += 1;
        let ticks = known.number.saturating_mul(period);
        let (earliest, last) = (
            at.saturating_sub(ticks).saturating_sub(latest),
            at.saturating_sub(ticks),
        );
        known.earliest = known.earliest.max(earliest);
        known.latest = known.latest.min(last);
        let off = known.earliest - known.latest;
        if off <= SLACK {
            return None;
        }
        let what = match known.latest == last {
            true => What::Early { by: off, period },
            false => What::Late { by: off, period },
        };
        self.known = Some(fresh);
        Some(what)
    }

    /// A moment at which the tick of the last turn has come for sure.
    pub(super) fn tick(&self, period: i64) -> Option<i64> {
        let known = self.known?;
        Some(
            known
                .latest
                .saturating_add(known.number.saturating_mul(period)),
        )
    }
}
