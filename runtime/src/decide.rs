//! The choice between possible actions.

use dotgen_timing::explore::Work;
use dotgen_timing::system::{ClientAction, FOREVER, Machine, MachineId, Ticks, TimedSystem, Yield};
use typed_index_collections::TiVec;

use crate::weights::Weights;

/// Chooses between possible actions. Every choice leads to a run of the system.
pub trait Decide {
    /// Returns the index of the action that comes first, among `steps` simultaneous actions.
    fn order(&mut self, steps: usize) -> usize;

    /// Returns the duration of work that begins now, in base units: from the least to the greatest time, both
    /// included. The greatest time may be [`FOREVER`].
    fn time(&mut self, work: &Work, least: Ticks, greatest: Ticks) -> Ticks;

    /// Returns the index of an outcome of work that ends, in a list of possible outcomes, which is never
    /// empty (see [`Action::Finish`](dotgen_timing::explore::Action::Finish)).
    fn outcome(&mut self, work: &Work, outcomes: &[usize]) -> usize;

    /// Returns true if time passes although an action is possible.
    fn waits(&mut self) -> bool;
}

/// The choice of execution times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Durations {
    /// Always the greatest time.
    Worst,
    /// Any time of the interval, with uniform probability.
    #[default]
    Random,
    /// Always the least time.
    Best,
}

/// One in this many codels throws an exception, and one in this many requests is refused by a codel, if that
/// is possible.
const ONE_IN_EXCEPTIONS: usize = 16;

/// Under the policy `fair`, a thread loses its core at one in this many opportunities.
const ONE_IN_PREEMPTIONS: usize = 8;

/// Chooses pseudo-randomly. The same seed gives the same choices.
#[derive(Debug, Clone)]
pub struct RandomDecisions<'s> {
    system: &'s TimedSystem,
    durations: Durations,
    /// Upper limit on the time beyond the least one, in base units, for work without a greatest time.
    max_extra_time: Ticks,
    /// By machine and state, whether the machine can go on for ever from there.
    goes_on: TiVec<MachineId, Vec<bool>>,
    weights: Option<&'s Weights>,
    dice: fastrand::Rng,
}

impl<'s> RandomDecisions<'s> {
    /// Creates the choices for runs of a system.
    pub fn new(system: &'s TimedSystem, durations: Durations, seed: u64) -> Self {
        RandomDecisions {
            max_extra_time: max_extra_time(system),
            goes_on: system.machines.iter().map(goes_on).collect(),
            weights: None,
            dice: fastrand::Rng::with_seed(seed),
            durations,
            system,
        }
    }

    /// Draws yields by weights, where there are some. A codel with weights throws no exception.
    pub fn with_weights(self, weights: Option<&'s Weights>) -> Self {
        RandomDecisions { weights, ..self }
    }

    /// Returns the place of an outcome drawn by weights; `None` if the work has none.
    fn weighted(&mut self, work: &Work, outcomes: &[usize]) -> Option<usize> {
        let Work::State { automaton, state, .. } = *work else { return None };
        let weights = self.weights?.of(self.system.automata[automaton].machine, state)?;
        let weight = |outcome: &usize| weights.get(*outcome).copied().unwrap_or(0);
        let sum = outcomes.iter().map(weight).sum::<u64>();
        if sum == 0 {
            return None;
        }
        let mut rest = self.dice.u64(..sum);
        outcomes.iter().position(|outcome| {
            let own = weight(outcome);
            let is_drawn = rest < own;
            rest = rest.saturating_sub(own);
            is_drawn
        })
    }

    /// Returns true if a permanent activity does not end for ever with an outcome. `stop` is what ends a run,
    /// and no step of it: a random choice would leave a task idle for all the rest.
    fn keeps_going(&self, work: &Work, outcome: usize) -> bool {
        let Work::State { automaton, .. } = *work else {
            return true;
        };
        let automaton = &self.system.automata[automaton];
        let after = match yield_of_outcome(self.system, work, outcome) {
            Some(Yield::Next(state) | Yield::Pause(state)) => Some(state),
            Some(Yield::End) | None => None,
        };
        let goes_on = &self.goes_on[automaton.machine];
        automaton.service.is_some()
            || after.is_some_and(|state| goes_on.get(state).copied().unwrap_or(false))
    }

    /// Returns true if an outcome is neither an exception nor a refusal.
    fn is_usual(&self, work: &Work, outcome: usize) -> bool {
        match *work {
            Work::State { automaton, state, .. } => {
                let states = &self.system.machine_of(automaton).states;
                (states.get(state)).is_some_and(|state| outcome < state.yields.len())
            }
            Work::Control { .. } => outcome == 0,
            Work::Delay { .. } => true,
        }
    }
}

/// Returns by state whether some yields from there never end the machine.
fn goes_on(machine: &Machine) -> Vec<bool> {
    let mut out = vec![true; machine.states.len()];
    loop {
        let before = out.clone();
        for (at, state) in machine.states.iter().enumerate() {
            out[at] = state.yields.iter().any(|transition| match *transition {
                Yield::Next(next) | Yield::Pause(next) => {
                    before.get(next).copied().unwrap_or(false)
                }
                Yield::End => false,
            });
        }
        if out == before {
            return out;
        }
    }
}

/// Returns eight times the longest finite time of a system, in base units.
fn max_extra_time(system: &TimedSystem) -> Ticks {
    let periods = system.tasks.iter().filter_map(|task| task.period);
    let codels = system.codels.iter().map(|codel| codel.upper);
    let steps = system.clients.iter().flat_map(|client| &client.steps);
    let delays = steps.filter_map(|step| match step.action {
        ClientAction::Delay(_, upper) => Some(upper),
        _ => None,
    });
    let times = periods.chain(codels).chain(delays);
    let longest = times.filter(|&time| time != FOREVER).max();
    longest.unwrap_or(0).max(1).saturating_mul(8).min(FOREVER / 4)
}

impl Decide for RandomDecisions<'_> {
    fn order(&mut self, steps: usize) -> usize {
        match steps {
            0 | 1 => 0,
            _ => self.dice.usize(..steps),
        }
    }

    fn time(&mut self, work: &Work, least: Ticks, greatest: Ticks) -> Ticks {
        let greatest_drawn = match greatest {
            FOREVER => least.saturating_add(self.max_extra_time).min(FOREVER - 1),
            tick => tick,
        };
        // A client is not a codel, and work without a greatest time has no worst case.
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
        if let Some(place) = self.weighted(work, outcomes) {
            return place;
        }
        let going: Vec<usize> =
            (0..outcomes.len()).filter(|&place| self.keeps_going(work, outcomes[place])).collect();
        if !going.is_empty() && going.len() < outcomes.len() {
            let outcomes: Vec<usize> = going.iter().map(|&place| outcomes[place]).collect();
            return going[self.outcome(work, &outcomes)];
        }
        let usual = |outcome: &usize| self.is_usual(work, *outcome);
        let count = outcomes.iter().filter(|outcome| usual(outcome)).count();
        if count == 0 || count == outcomes.len() {
            return self.dice.usize(..outcomes.len());
        }
        let wanted = self.dice.usize(..ONE_IN_EXCEPTIONS) != 0;
        let among = if wanted { count } else { outcomes.len() - count };
        let chosen = self.dice.usize(..among);
        let mut places = (outcomes.iter().enumerate())
            .filter(|(_, outcome)| self.is_usual(work, **outcome) == wanted)
            .map(|(place, _)| place);
        places.nth(chosen).unwrap_or(0)
    }

    fn waits(&mut self) -> bool {
        self.dice.usize(..ONE_IN_PREEMPTIONS) != 0
    }
}

/// Returns the yield that an outcome of a state machine's codel stands for; `None` for an exception.
pub(crate) fn yield_of_outcome(system: &TimedSystem, work: &Work, outcome: usize) -> Option<Yield> {
    match *work {
        Work::State { automaton, state, .. } => {
            let states = &system.machine_of(automaton).states;
            states.get(state)?.yields.get(outcome).copied()
        }
        _ => None,
    }
}
