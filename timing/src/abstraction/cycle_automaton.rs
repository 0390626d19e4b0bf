//! The sequences of codels of a task: its permanent activity and its requested activities, pass by pass.
//!
//! The times of requests are left open. An activity that may be requested can begin in each cycle in which it
//! is not under way. An activity that a request can interrupt may be interrupted before each pass.

use rustc_hash::FxHashMap;

use super::refusal::Refusal;
use super::span::Span;
use crate::system::loops::{Visited, beginning, followers};
use crate::system::{Codel, CodelId, Machine, MachineId, State, TimedSystem, Yield};

/// Number of places and rests above which a task is refused.
const MAX_SITUATIONS: usize = 5_000;

/// The sequences of codels of a task.
#[derive(Debug, Clone)]
pub(super) struct CycleAutomaton {
    pub(super) places: Vec<Place>,
    /// Rests. The first one is the rest before the first cycle.
    pub(super) rests: Vec<Rest>,
    /// State at which the permanent activity, alone, has paused, by rest.
    pub(super) paused: Vec<Option<usize>>,
}

/// The execution of a codel.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub(super) struct Place {
    pub(super) codel: CodelId,
    /// Execution time, in base units.
    pub(super) time: Span,
    /// The codel may wait for its locks. Otherwise the time contains its waits.
    pub(super) waits: bool,
    /// Possible successors.
    pub(super) then: Vec<Successor>,
    /// Possible successors after an exception, if the codel may throw.
    pub(super) thrown: Vec<Successor>,
}

/// The successor of a codel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Successor {
    /// Another place in the same cycle.
    Goes(usize),
    /// The end of the cycle.
    Rests(usize),
    /// The end of the last cycle.
    Ends,
}

/// A task between two cycles.
#[derive(Debug, Clone, Default)]
pub(super) struct Rest {
    /// Possible beginnings of the next cycle: a codel, or the end of the cycle.
    pub(super) begins: Vec<Successor>,
    /// A tick may find no work.
    pub(super) skips: bool,
}

impl CycleAutomaton {
    /// Returns the rest in which the permanent activity, alone, has paused at a state.
    pub(super) fn paused_at(&self, state: usize) -> Option<usize> {
        self.paused.iter().position(|candidate| *candidate == Some(state))
    }
}

/// An activity that a task may execute.
#[derive(Debug, Clone, Copy)]
pub(super) struct Activity {
    pub(super) machine: MachineId,
    pub(super) permanent: bool,
    /// The activity can be requested again after its end.
    pub(super) again: bool,
    /// Some request interrupts the activity.
    pub(super) interrupted: bool,
}

/// The state of an activity.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum ActivityPosition {
    /// It has not begun.
    Before,
    /// It has ended for good.
    Over,
    /// It executes a codel in this pass.
    Next(Visited, IsInterrupted),
    /// It continues in the next pass.
    Goes(Visited, IsInterrupted),
    /// It continues in the next cycle.
    Pauses(usize, IsInterrupted),
}

/// True if an activity was interrupted.
type IsInterrupted = bool;

/// The states of all activities, and the activity that executes a codel.
type AutomatonState = (Vec<ActivityPosition>, Option<usize>);

/// Returns the cycle automaton of a task. The permanent activity, if there is one, is the first of
/// `activities`.
pub(super) fn cycle_automaton(
    system: &TimedSystem,
    activities: &[Activity],
) -> Result<CycleAutomaton, Refusal> {
    let mut builder = Builder {
        system,
        activities,
        known: FxHashMap::default(),
        todo: Vec::new(),
        out: CycleAutomaton { places: Vec::new(), rests: Vec::new(), paused: Vec::new() },
    };
    builder.first()?;
    while let Some((situation, number)) = builder.todo.pop() {
        if builder.known.len() > MAX_SITUATIONS {
            return Err(Refusal::Requests);
        }
        match situation.1 {
            Some(executes) => builder.place(&situation.0, executes, number)?,
            None => builder.rest(&situation.0, number)?,
        }
    }
    Ok(builder.out)
}

struct Builder<'b> {
    system: &'b TimedSystem,
    activities: &'b [Activity],
    known: FxHashMap<AutomatonState, Successor>,
    todo: Vec<(AutomatonState, usize)>,
    out: CycleAutomaton,
}

impl Builder<'_> {
    fn machine(&self, activity: usize) -> &Machine {
        &self.system.machines[self.activities[activity].machine]
    }

    fn begins(&self, activity: usize, state: usize) -> Visited {
        let machine = self.machine(activity);
        beginning(machine, machine.loop_limit, state)
    }

    /// Adds the rest before the first cycle, in which only the permanent activity can begin.
    fn first(&mut self) -> Result<(), Refusal> {
        self.out.rests.push(Rest::default());
        self.out.paused.push(None);
        let mut at = vec![ActivityPosition::Before; self.activities.len()];
        if self.activities.first().is_some_and(|activity| activity.permanent) {
            at[0] = ActivityPosition::Next(self.begins(0, self.machine(0).start), false);
        }
        self.out.rests[0].begins = self.proceed(&at)?;
        Ok(())
    }

    fn number(&mut self, situation: AutomatonState) -> Successor {
        if let Some(&successor) = self.known.get(&situation) {
            return successor;
        }
        let (successor, number) = match situation.1 {
            Some(_) => {
                self.out.places.push(Place::default());
                let number = self.out.places.len() - 1;
                (Successor::Goes(number), number)
            }
            None if situation.0.iter().all(|position| *position == ActivityPosition::Over) => {
                return Successor::Ends;
            }
            None => {
                self.out.rests.push(Rest::default());
                self.out.paused.push(match &situation.0[..] {
                    [ActivityPosition::Pauses(at, false)] => Some(*at),
                    _ => None,
                });
                let number = self.out.rests.len() - 1;
                (Successor::Rests(number), number)
            }
        };
        self.known.insert(situation.clone(), successor);
        self.todo.push((situation, number));
        successor
    }

    fn place(
        &mut self,
        at: &[ActivityPosition],
        executes: usize,
        number: usize,
    ) -> Result<(), Refusal> {
        let ActivityPosition::Next(visited, stops) = &at[executes] else {
            return Ok(());
        };
        let machine = self.machine(executes);
        let state = &machine.states[visited.0];
        let codel = state.codel;
        let over = self.over(executes);
        let following = followers(machine, visited);
        let mut next: Vec<ActivityPosition> = following
            .into_iter()
            .map(|follower| ActivityPosition::Goes(follower, *stops))
            .collect();
        next.extend(state.yields.iter().filter_map(|transition| match *transition {
            Yield::Next(_) => None,
            Yield::Pause(to) => Some(ActivityPosition::Pauses(to, *stops)),
            Yield::End => Some(over.clone()),
        }));
        let throws = self.system.codels[codel].throws;
        let with = |position: ActivityPosition| {
            let mut at = at.to_vec();
            at[executes] = position;
            at
        };
        let all: Vec<Vec<ActivityPosition>> = next.into_iter().map(with).collect();
        let thrown = throws.then(|| with(self.after_failure(executes, *stops).unwrap_or(over)));
        let mut then: Vec<Successor> = Vec::new();
        for position in &all {
            then.extend(self.proceed(position)?);
        }
        then.dedup();
        let thrown = match thrown {
            Some(exception) => self.proceed(&exception)?,
            None => Vec::new(),
        };
        let Codel { lower, upper, .. } = self.system.codels[codel];
        self.out.places[number] = Place {
            codel,
            time: Span { from: i64::from(lower), to: i64::from(upper) },
            waits: true,
            then,
            thrown,
        };
        Ok(())
    }

    fn rest(&mut self, at: &[ActivityPosition], number: usize) -> Result<(), Refusal> {
        let mut begins = Vec::new();
        for positions in self.begin_pass(at, true)? {
            begins.extend(self.proceed_in_pass(&positions));
        }
        // A task asks for a core only if it has work, unless the activity to begin is interrupted meanwhile.
        if self.activities.iter().all(|activity| !activity.interrupted) {
            begins.retain(|successor| matches!(successor, Successor::Goes(_)));
        }
        let mut all = at.iter().enumerate();
        let paused = all.any(|(activity, position)| match position {
            ActivityPosition::Pauses(_, stops) => self.after_failure(activity, *stops).is_none(),
            _ => false,
        });
        self.out.rests[number] = Rest { begins, skips: !paused };
        Ok(())
    }

    /// Returns the state of an activity that has ended.
    fn over(&self, activity: usize) -> ActivityPosition {
        if self.activities[activity].again {
            ActivityPosition::Before
        } else {
            ActivityPosition::Over
        }
    }

    /// Returns the state of an activity that may have failed. Any other activity may fail as well in some
    /// runs, so that there would be a rest for each set of failed activities. Instead a failed activity
    /// counts as paused, and need not be resumed.
    fn after_failure(&self, activity: usize, stops: IsInterrupted) -> Option<ActivityPosition> {
        if self.activities[activity].again {
            return None;
        }
        let states = &self.machine(activity).states;
        let throws = |state: &&State| self.system.codels[state.codel].throws;
        states.iter().find(throws)?;
        let mut yields = states.iter().flat_map(|state| &state.yields);
        yields.find_map(|state| match *state {
            Yield::Pause(to) => Some(ActivityPosition::Pauses(to, stops)),
            _ => None,
        })
    }

    /// Returns the possible successors in a pass, or after it.
    fn proceed(&mut self, at: &[ActivityPosition]) -> Result<Vec<Successor>, Refusal> {
        let next = at.iter().any(|position| matches!(position, ActivityPosition::Next(..)));
        let goes = at.iter().any(|position| matches!(position, ActivityPosition::Goes(..)));
        if next || !goes {
            return Ok(self.proceed_in_pass(at));
        }
        let mut out = Vec::new();
        for positions in self.begin_pass(at, false)? {
            out.extend(self.proceed_in_pass(&positions));
        }
        Ok(out)
    }

    /// Returns the possible successors in a pass. The permanent activity has the first slot; the slots of
    /// others are not known.
    fn proceed_in_pass(&mut self, at: &[ActivityPosition]) -> Vec<Successor> {
        let next =
            (0..at.len()).filter(|&position| matches!(at[position], ActivityPosition::Next(..)));
        let mut next: Vec<usize> = next.collect();
        if next.first() == Some(&0) && self.activities[0].permanent {
            next.truncate(1);
        }
        if next.is_empty() {
            return vec![self.number((at.to_vec(), None))];
        }
        let all = next.into_iter().map(|position| (at.to_vec(), Some(position)));
        all.collect::<Vec<_>>().into_iter().map(|state| self.number(state)).collect()
    }

    /// Returns the possible beginnings of a pass. Only the first pass of a cycle begins and resumes
    /// activities.
    fn begin_pass(
        &self,
        at: &[ActivityPosition],
        first: bool,
    ) -> Result<Vec<Vec<ActivityPosition>>, Refusal> {
        let mut out: Vec<Vec<ActivityPosition>> = vec![Vec::new()];
        for (activity, position) in at.iter().enumerate() {
            let mut ways = vec![match position {
                ActivityPosition::Goes(visited, stops) => {
                    ActivityPosition::Next(visited.clone(), *stops)
                }
                ActivityPosition::Pauses(state, stops) if first => {
                    ActivityPosition::Next(self.begins(activity, *state), *stops)
                }
                other => other.clone(),
            }];
            if let ActivityPosition::Pauses(_, stops) = position
                && first
                && self.after_failure(activity, *stops).is_some()
            {
                ways.push(position.clone());
            }
            match position {
                ActivityPosition::Before if first && !self.activities[activity].permanent => {
                    let start = self.machine(activity).start;
                    ways.push(ActivityPosition::Next(self.begins(activity, start), false));
                }
                ActivityPosition::Goes(_, false) | ActivityPosition::Pauses(_, false)
                    if self.activities[activity].interrupted =>
                {
                    ways.push(match self.machine(activity).stop {
                        Some(stop) => ActivityPosition::Next(self.begins(activity, stop), true),
                        None => self.over(activity),
                    });
                }
                _ => {}
            }
            // Every activity that may begin doubles them.
            if out.len() * ways.len() > MAX_SITUATIONS {
                return Err(Refusal::Requests);
            }
            let before = std::mem::take(&mut out);
            for begun in before {
                for way in &ways {
                    let mut begun = begun.clone();
                    begun.push(way.clone());
                    out.push(begun);
                }
            }
        }
        Ok(out)
    }
}
