//! Replay of a recorded run in the verified model.
//!
//! The rules are those of the explorer. The replay leads a [`Stepper`] along the recorded steps. Each step
//! must be among the possible actions, and time must be free to pass between two steps. So a run without a
//! difference is a run of the model. If a codel took another time than the model allows, or threw an
//! undeclared exception, the difference is reported and the replay continues. Any other difference ends the
//! replay, because the state of the run is unknown from there on.
//!
//! A recorded step ([`Step`]) consists of names. Numbers of the model appear only to distinguish several
//! activities of one service.

mod step;

use dotgen_timing::explore::{Action, Possible, Seen, Stepper, Watched, Work};
use dotgen_timing::system::{ClientId, CodelId, FOREVER, Ticks, TimedSystem};
use num_rational::Ratio;
use typed_index_collections::TiVec;

pub use step::{Rule, Step};

/// Upper limit on the kept differences; all are counted.
const MAX_KEPT_DIFFERENCES: usize = 100;

/// Upper limit on the possible steps listed with a difference.
const MAX_LISTED_STEPS: usize = 8;

/// The kind and details of a difference. Times are in units of the system.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum DifferenceKind {
    /// A codel, or a delay, took longer than its greatest time.
    Longer { took: u64, limit: Ticks },
    /// A codel, or a delay, took less than its least time.
    Shorter { took: u64, limit: Ticks },
    /// A codel threw an exception, and declares none.
    Undeclared,
    /// The step is not possible; the steps in `possible` are.
    Impossible { possible: Vec<Step> },
    /// Another step, or time, came although `due` had to come first.
    Omitted { due: Step },
    /// The time of the step is before that of the previous step.
    Backwards,
}

/// A difference between a recorded run and the model.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Difference {
    /// Number of the recorded step, from 1.
    pub number: u64,
    /// The recorded step.
    pub step: Step,
    /// Violated rule: that of the step, or of the step that had to come first.
    pub rule: Rule,
    /// Kind and details.
    #[serde(flatten)]
    pub what: DifferenceKind,
}

/// A step of a replayed run, for its checks.
#[derive(Debug, Clone, Copy)]
pub enum Observed<'e> {
    Event(&'e Seen),
    /// Time has passed.
    Moment,
    /// The run has ended, because no event could follow.
    NothingLeft,
}

#[derive(Debug, Clone, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct ReplayReport {
    /// Version of the JSON form.
    pub format: u32,
    /// Number of steps of the recording.
    pub steps: u64,
    /// Number of steps that were replayed.
    pub followed: u64,
    /// Units of the system from the start to the last replayed moment.
    pub time: u64,
    /// Requests and interruptions from outside. They correspond to no client of the model.
    pub from_outside: u64,
    /// First differences.
    pub differences: Vec<Difference>,
    /// Number of all differences.
    pub difference_count: u64,
    /// Number of those differences that are violations by codels, which a run counts as well: their times and
    /// exceptions. With these the run is one of the model.
    pub violation_count: u64,
}

/// Replays a recorded run in the model. See the [module](self).
pub struct Replay<'s> {
    system: &'s TimedSystem,
    stepper: Stepper<'s>,
    /// Permission to throw in the specification, by codel.
    throws: TiVec<CodelId, bool>,
    /// First client that stands for requests from outside.
    outside: ClientId,
    /// Start of the work of executors, with its least and greatest time.
    begun: Vec<(u64, (Ticks, Ticks))>,
    /// Executors that took longer than their greatest time, and may continue.
    longer: Vec<bool>,
    /// Executors that had no core when time last passed.
    waited: Vec<bool>,
    possible: Possible,
    seen: Vec<Seen>,
    /// Receives the run, until components are shut down.
    observe: &'s mut dyn FnMut(&Stepper<'_>, Observed),
    /// The state of the run is unknown.
    lost: bool,
    /// Components are being shut down.
    ending: bool,
    report: ReplayReport,
}

/// Returns a system in which every codel may throw: [`Replay`] itself checks undeclared exceptions.
pub fn with_any_exception(system: &TimedSystem) -> TimedSystem {
    let mut out = system.clone();
    for codel in &mut out.codels {
        codel.throws = true;
    }
    out
}

impl<'s> Replay<'s> {
    /// Creates a replay. `system` is the [form with any exception](with_any_exception) of the `verified`
    /// system. Clients from `outside` on stand for requests from outside. `observe` receives the events of
    /// `watched` until components are shut down.
    pub fn new(
        system: &'s TimedSystem,
        verified: &TimedSystem,
        outside: Option<ClientId>,
        watched: &Watched,
        observe: &'s mut dyn FnMut(&Stepper<'_>, Observed),
    ) -> Self {
        let mut stepper = Stepper::new(system, watched);
        let mut seen = Vec::new();
        stepper.begin(&mut seen);
        let executors = stepper.executors();
        let mut out = Replay {
            throws: verified.codels.iter().map(|codel| codel.throws).collect(),
            outside: outside.unwrap_or(system.clients.next_key()),
            begun: vec![(0, (0, FOREVER)); executors],
            longer: vec![false; executors],
            waited: vec![false; executors],
            possible: Possible::default(),
            lost: false,
            report: ReplayReport {
                format: 1,
                steps: 0,
                followed: 0,
                time: 0,
                from_outside: 0,
                differences: Vec::new(),
                difference_count: 0,
                violation_count: 0,
            },
            system,
            stepper,
            seen,
            observe,
            ending: false,
        };
        out.look();
        out
    }

    /// Sets a comparison of data, from the next step on.
    pub fn set_fact(&mut self, fact: usize, holds: bool) {
        self.stepper.set_fact(fact, holds);
    }

    /// Replays the next recorded step.
    pub fn step(&mut self, step: &Step) {
        self.report.steps += 1;
        if self.lost || !self.advance_to(step.time, step) {
            return;
        }
        match step.rule {
            Rule::Abort => return self.abort(step),
            Rule::Stop => {
                self.ending = true;
                self.stepper.shut_down();
                self.report.followed += 1;
                return;
            }
            _ => {}
        }
        self.stepper.possible(&mut self.possible);
        let mut found = self.find(step);
        if found.is_none()
            && let Some(executor) = self.ends(step)
        {
            found = self.find_end(executor, step);
        }
        let Some(action) = found else {
            // Restores the possible actions, which the search for an early end has changed.
            self.stepper.possible(&mut self.possible);
            let actions = self.possible.actions().iter().take(MAX_LISTED_STEPS);
            let possible = actions.map(|&action| Step::new(self.system, &self.stepper, action));
            let possible: Vec<Step> = possible.collect();
            self.lost = true;
            let due = possible.first().filter(|_| self.possible.is_committed());
            return match due.cloned() {
                Some(due) => {
                    self.record_difference(step, due.rule, DifferenceKind::Omitted { due });
                }
                None => {
                    self.record_difference(
                        step,
                        step.rule,
                        DifferenceKind::Impossible { possible },
                    );
                }
            };
        };
        self.check_action(step, action);
        self.stepper.perform(action, &mut self.seen);
        self.look();
        self.report.followed += 1;
    }

    /// Ends the replay, at a time in units of the system.
    pub fn end(mut self, time: u64) -> ReplayReport {
        if !self.lost {
            let end = Step {
                time,
                rule: Rule::End,
                of: String::new(),
                what: String::new(),
                to: String::new(),
                executed: None,
            };
            // The last event of the run may be missing in the recording.
            self.advance_to(time, &end);
            for executor in 0..self.longer.len() {
                self.record_overrun(executor, &end);
            }
        }
        self.stepper.possible(&mut self.possible);
        let is_stuck = self.possible.actions().is_empty()
            && self.stepper.next_moment_but(&|_| false).is_none();
        if is_stuck && !self.lost && !self.ending {
            (self.observe)(&self.stepper, Observed::NothingLeft);
        }
        self.report.time = self.stepper.now();
        self.report
    }

    /// Returns the possible action that corresponds to a step.
    fn find(&self, step: &Step) -> Option<Action> {
        let mut actions = self.possible.actions().iter().copied();
        actions.find(|&action| Step::new(self.system, &self.stepper, action).is_alike(step))
    }

    /// Returns the action by which an executor ends although the model forbids it. Either the work took less
    /// than its least time. Or the work was complete when the executor was preempted, and needs no core any
    /// more.
    fn find_end(&mut self, executor: usize, step: &Step) -> Option<Action> {
        let (least, _) = self.stepper.window(executor)?;
        if least == 0 && self.waited[executor] {
            return None;
        }
        self.stepper.set_window(executor, (0, 0));
        self.stepper.possible(&mut self.possible);
        let found = self.find(step)?;
        // On the real clock, what takes less than stated is no violation.
        if least > 0 && step.executed.is_none() {
            let (took, limit) = (self.took(executor), self.begun[executor].1.0);
            self.record_difference(step, step.rule, DifferenceKind::Shorter { took, limit });
        }
        Some(found)
    }

    /// Returns the executor that ends with a step, if it executes the work of the step.
    fn ends(&self, step: &Step) -> Option<usize> {
        let ends = matches!(step.rule, Rule::End | Rule::Delay);
        let mut executing =
            (0..self.stepper.executors()).filter(|&at| ends && self.stepper.window(at).is_some());
        executing.find(|&executor| {
            let end = self.end_of(executor);
            (end.rule, &end.of, &end.what) == (step.rule, &step.of, &step.what)
        })
    }

    /// Returns the step by which an executor would end.
    fn end_of(&self, executor: usize) -> Step {
        let ends = Action::Finish { executor, outcome: 0 };
        Step::new(self.system, &self.stepper, ends)
    }

    /// Reports the differences of a step that is possible.
    fn check_action(&mut self, step: &Step, action: Action) {
        match action {
            Action::Finish { executor, .. } => {
                self.record_overrun(executor, step);
                let codel = self.stepper.work(executor).and_then(|work| work.codel());
                let throws = codel
                    .is_none_or(|codel| self.throws.get(codel).is_some_and(|exception| *exception));
                // A refusal of a request is an exception, declared or not.
                let state = matches!(self.stepper.work(executor), Some(Work::State { .. }));
                if state && step.to == step::EXCEPTION && !throws {
                    self.record_difference(step, Rule::End, DifferenceKind::Undeclared);
                }
            }
            Action::Request { client, .. } if client >= self.outside => {
                self.report.from_outside += 1;
            }
            _ => {}
        }
    }

    /// Lets time pass until a step. Returns false if the replay cannot continue.
    fn advance_to(&mut self, time: u64, step: &Step) -> bool {
        if time < self.stepper.now() {
            self.lost = true;
            self.record_difference(step, step.rule, DifferenceKind::Backwards);
            return false;
        }
        while self.stepper.now() < time {
            self.stepper.possible(&mut self.possible);
            if !self.possible.may_wait() {
                if self.overrun() {
                    continue;
                }
                let due = self.possible.actions().first();
                let due = due.map(|&action| Step::new(self.system, &self.stepper, action));
                self.lost = true;
                let Some(due) = due else { return false };
                self.record_difference(step, due.rule, DifferenceKind::Omitted { due });
                return false;
            }
            let left = time - self.stepper.now();
            let jump = self.stepper.next_moment_but(&|_| true);
            let jump = jump.map_or(left, u64::from).clamp(1, left);
            let jump = Ticks::try_from(jump).unwrap_or(FOREVER - 1);
            let window = |stepper: &Stepper<'_>, executor| stepper.window(executor);
            let executors = 0..self.stepper.executors();
            let before: Vec<_> =
                executors.map(|executor| window(&self.stepper, executor)).collect();
            self.stepper.pass(jump, &mut self.seen);
            self.look();
            if !self.ending {
                (self.observe)(&self.stepper, Observed::Moment);
            }
            for (executor, before) in before.into_iter().enumerate() {
                // Without a greatest time, the window does not show whether the work progressed.
                let known = before.filter(|window| window.1 != FOREVER);
                self.waited[executor] =
                    known.is_some_and(|old| window(&self.stepper, executor) == Some(old));
            }
        }
        true
    }

    /// Lets executors continue that have reached their greatest time. Returns true if there are any.
    fn overrun(&mut self) -> bool {
        let mut any = false;
        for executor in 0..self.stepper.executors() {
            if self.stepper.window(executor).is_some_and(|window| window.1 == 0) {
                self.stepper.set_window(executor, (0, FOREVER));
                self.longer[executor] = true;
                any = true;
            }
        }
        any
    }

    fn record_overrun(&mut self, executor: usize, step: &Step) {
        let longer = std::mem::take(&mut self.longer[executor]);
        let limit = self.begun[executor].1.1;
        let took = match step.executed {
            // As in the run: the exchange of messages is no part of it.
            // A codel without a stated time has the limit 0.
            Some(nanos) if limit != FOREVER && limit > 0 => {
                let unit = self.system.unit * Ratio::from_integer(1_000_000_000);
                let units = (Ratio::from_integer(i128::from(nanos)) / unit).ceil().to_integer();
                let took = u64::try_from(units).unwrap_or(u64::MAX);
                (took > u64::from(limit)).then_some(took)
            }
            Some(_) => None,
            None => longer.then(|| self.took(executor)),
        };
        let Some(took) = took else { return };
        let whose = self.end_of(executor);
        let step = if step.what.is_empty() && step.of.is_empty() { &whose } else { step };
        self.record_difference(&step.clone(), whose.rule, DifferenceKind::Longer { took, limit });
    }

    fn took(&self, executor: usize) -> u64 {
        self.stepper.now() - self.begun[executor].0
    }

    fn abort(&mut self, step: &Step) {
        let place = step.what.parse().ok();
        let place = place.filter(|&place| place < self.stepper.places());
        let known = place.filter(|&place| Step::abort(self.system, &self.stepper, place) == *step);
        let Some(place) = known else {
            self.lost = true;
            let possible = Vec::new();
            return self.record_difference(
                step,
                Rule::Abort,
                DifferenceKind::Impossible { possible },
            );
        };
        self.stepper.interrupt(place);
        self.report.from_outside += 1;
        self.report.followed += 1;
    }

    /// Records the start of new work.
    fn look(&mut self) {
        let now = self.stepper.now();
        for observation in self.seen.drain(..) {
            if !self.ending {
                (self.observe)(&self.stepper, Observed::Event(&observation));
            }
            if let Seen::Begun { executor, time, .. } = observation
                && let Some(begun) = self.begun.get_mut(executor)
            {
                *begun = (now, time);
            }
        }
    }

    fn record_difference(&mut self, step: &Step, rule: Rule, what: DifferenceKind) {
        self.report.difference_count += 1;
        let by_codel = matches!(
            what,
            DifferenceKind::Longer { .. }
                | DifferenceKind::Shorter { .. }
                | DifferenceKind::Undeclared
        );
        self.report.violation_count += u64::from(by_codel);
        if self.report.differences.len() < MAX_KEPT_DIFFERENCES {
            self.report.differences.push(Difference {
                number: self.report.steps,
                step: step.clone(),
                rule,
                what,
            });
        }
    }
}
