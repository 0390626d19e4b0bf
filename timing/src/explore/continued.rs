//! The continuation of a run by chosen steps.

use super::rules::{Action, Enabled, Moment, Rules};
use super::run::{Run, advance};
use super::state::State;
use crate::system::{Ticks, TimedSystem};

/// Upper limit on committed steps without a choice that are performed at once.
const SETTLING: usize = 64;

/// A possible next step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NextStep {
    Action(Action),
    /// Time passes until the next moment, in base units.
    Wait(Ticks),
}

/// A run that was continued.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Continued {
    /// The run with the chosen steps. Committed steps without a choice follow at once.
    pub run: Run,
    /// Number of steps of the run before each choice.
    pub before: Vec<usize>,
    /// The possible next steps, each with its first line for readers, if it has one. Any of them may be next.
    pub next: Vec<(NextStep, Option<Moment>)>,
}

impl Run {
    /// Continues the first `steps` steps of a run of a system. Each choice is an index into the list of next
    /// steps at that point; the first one that is beyond its list ends the continuation.
    pub fn continued(&self, system: &TimedSystem, steps: usize, choices: &[usize]) -> Continued {
        continued(&Rules::new(system), self, steps, choices)
    }
}

/// A run that is being continued.
struct Walk<'r> {
    rules: &'r Rules<'r>,
    s: State,
    run: Run,
    enabled: Enabled,
}

fn continued(rules: &Rules, run: &Run, steps: usize, choices: &[usize]) -> Continued {
    let steps = run.steps[..steps.min(run.steps.len())].to_vec();
    let mut walk =
        Walk { rules, s: rules.initial(), enabled: Enabled::default(), run: Run::default() };
    for (time, action) in steps {
        if time > walk.run.end {
            advance(rules, &mut walk.s, (time - walk.run.end) as Ticks);
            walk.run.end = time;
        }
        walk.perform(action);
    }
    walk.settle();
    let mut before = Vec::new();
    for &choice in choices {
        let Some(&next) = walk.steps().get(choice) else {
            break;
        };
        before.push(walk.run.steps.len());
        match next {
            NextStep::Action(action) => walk.perform(action),
            NextStep::Wait(time) => {
                walk.rules.elapse(&mut walk.s, time);
                walk.run.end += u64::from(time);
            }
        }
        walk.settle();
    }
    Continued {
        next: walk.steps().into_iter().map(|step| (step, walk.first_moment(step))).collect(),
        run: walk.run,
        before,
    }
}

impl Walk<'_> {
    fn perform(&mut self, action: Action) {
        self.rules.apply(&mut self.s, action);
        self.run.steps.push((self.run.end, action));
    }

    /// Performs committed steps without a choice.
    fn settle(&mut self) {
        for _ in 0..SETTLING {
            self.rules.enabled(&self.s, &mut self.enabled);
            match self.enabled.actions[..] {
                [action] if self.enabled.committed => self.perform(action),
                _ => break,
            }
        }
    }

    /// Returns the first line of a next step for readers.
    fn first_moment(&self, step: NextStep) -> Option<Moment> {
        let NextStep::Action(action) = step else {
            return None;
        };
        let mut after = self.s.clone();
        self.rules.apply(&mut after, action);
        let mut moments = Vec::new();
        let change = (&self.s, &after);
        (self.rules).tell(change, Some(action), self.run.end, &mut moments);
        moments.into_iter().next()
    }

    fn steps(&self) -> Vec<NextStep> {
        let actions = self.enabled.actions.iter().copied();
        let wait =
            if self.enabled.is_calm() { self.rules.next_moment(&self.s, &|_| false) } else { None };
        let wait = wait.map(NextStep::Wait);
        actions.map(NextStep::Action).chain(wait).collect()
    }
}
