//! What happens where several things can.

use dotgen_timing::explore::Work;
use dotgen_timing::system::{ClientAction, FOREVER, Ticks, TimedSystem, Yield};

/// Chooses what happens next. Whatever it chooses, the result is a run of the system.
pub trait Decide {
    /// Which of so many simultaneous steps comes first.
    fn order(&mut self, steps: usize) -> usize;

    /// How long something takes that begins now: from the least to the greatest time, both included; the
    /// greatest may be [`FOREVER`].
    fn time(&mut self, work: &Work, least: Ticks, greatest: Ticks) -> Ticks;

    /// How something ends: the place in a list of possible outcomes (see
    /// [`Action::Finish`](dotgen_timing::explore::Action::Finish)), which is never empty.
    fn outcome(&mut self, work: &Work, outcomes: &[usize]) -> usize;

    /// Whether time passes although something could happen.
    fn waits(&mut self) -> bool;
}

/// How long codels take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Durations {
    /// Always the greatest time.
    Worst,
    /// Any time of the interval, each with the same probability.
    #[default]
    Random,
    /// Always the least time.
    Best,
}

/// One of so many codels throws an exception, and one of so many requests is refused by a codel, where
/// either is possible.
const UNUSUAL: usize = 16;

/// Under the policy `fair`, one of so many moments at which a thread could lose its core is used for that.
const SWAPS: usize = 8;

/// Chooses by chance, always the same for the same seed.
#[derive(Debug, Clone)]
pub struct Drawn<'s> {
    system: &'s TimedSystem,
    durations: Durations,
    /// What has no greatest time takes at most so much longer than its least.
    far: Ticks,
    dice: fastrand::Rng,
}

impl<'s> Drawn<'s> {
    /// For runs of a system.
    pub fn new(system: &'s TimedSystem, durations: Durations, seed: u64) -> Self {
        Drawn {
            far: far(system),
            dice: fastrand::Rng::with_seed(seed),
            durations,
            system,
        }
    }

    /// The outcomes that are no exceptions and no refusals.
    fn is_usual(&self, work: &Work, outcome: usize) -> bool {
        match *work {
            Work::State {
                automaton, state, ..
            } => {
                let states = &self.system.machine_of(automaton).states;
                (states.get(state)).is_some_and(|it| outcome < it.yields.len())
            }
            Work::Control { .. } => outcome == 0,
            Work::Delay { .. } => true,
        }
    }
}

/// Some of the longest cycles of a system.
fn far(system: &TimedSystem) -> Ticks {
    let periods = system.tasks.iter().filter_map(|it| it.period);
    let codels = system.codels.iter().map(|it| it.upper);
    let steps = system.clients.iter().flat_map(|it| &it.steps);
    let delays = steps.filter_map(|it| match it.action {
        ClientAction::Delay(_, upper) => Some(upper),
        _ => None,
    });
    let times = periods.chain(codels).chain(delays);
    let longest = times.filter(|&it| it != FOREVER).max();
    longest
        .unwrap_or(0)
        .max(1)
        .saturating_mul(8)
        .min(FOREVER / 4)
}

impl Decide for Drawn<'_> {
    fn order(&mut self, steps: usize) -> usize {
        match steps {
            0 | 1 => 0,
            _ => self.dice.usize(..steps),
        }
    }

    fn time(&mut self, work: &Work, least: Ticks, greatest: Ticks) -> Ticks {
        let greatest_drawn = match greatest {
            FOREVER => least.saturating_add(self.far).min(FOREVER - 1),
            it => it,
        };
        // A client is no codel, and what has no greatest time has no worst one.
        let durations = match work {
            Work::Delay { .. } => Durations::Random,
            _ if greatest == FOREVER => Durations::Random,
            _ => self.durations,
        };
        match durations {
            Durations::Worst => greatest_drawn,
            Durations::Best => least,
            Durations::Random if greatest_drawn <= least => least,
            Durations::Random => self.dice.u32(least..=greatest_drawn),
        }
    }

    fn outcome(&mut self, work: &Work, outcomes: &[usize]) -> usize {
        if outcomes.len() < 2 {
            return 0;
        }
        let usual = |it: &usize| self.is_usual(work, *it);
        let count = outcomes.iter().filter(|it| usual(it)).count();
        if count == 0 || count == outcomes.len() {
            return self.dice.usize(..outcomes.len());
        }
        let wanted = self.dice.usize(..UNUSUAL) != 0;
        let among = if wanted {
            count
        } else {
            outcomes.len() - count
        };
        let chosen = self.dice.usize(..among);
        let mut places = (outcomes.iter().enumerate())
            .filter(|(_, it)| self.is_usual(work, **it) == wanted)
            .map(|(place, _)| place);
        places.nth(chosen).unwrap_or(0)
    }

    fn waits(&mut self) -> bool {
        self.dice.usize(..SWAPS) != 0
    }
}

/// What an outcome of a codel of a state machine leads to; `None` is an exception.
pub fn yielded(system: &TimedSystem, work: &Work, outcome: usize) -> Option<Yield> {
    match *work {
        Work::State {
            automaton, state, ..
        } => {
            let states = &system.machine_of(automaton).states;
            states.get(state)?.yields.get(outcome).copied()
        }
        _ => None,
    }
}
