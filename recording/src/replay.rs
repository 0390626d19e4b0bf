//! A recorded run step by step beside the model that is verified.
//!
//! The rules are those of the explorer: a [`Stepper`] is led along the recorded steps, and each of them has
//! to be among what is possible there; between two steps time has to be free to pass. So a run without a
//! difference is a run of the model. Where a codel took another time than the model allows, or threw what it
//! does not declare, that is told and the run is followed further; any other difference ends it, because from
//! there on nobody knows the state that the run was in.
//!
//! What is recorded are steps by names ([`Step`]): numbers of the model appear only where several activities
//! of one service have to be told apart.

mod step;

use dotgen_timing::explore::{Action, Possible, Seen, Stepper, Watched, Work};
use dotgen_timing::system::{FOREVER, Ticks, TimedSystem};

pub use step::{Rule, Step};

/// Differences that are kept; all are counted.
const KEPT: usize = 100;

/// Possible steps that are told with a difference.
const TOLD: usize = 8;

/// What a run does that the model does not. Times are in units of the system.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[allow(missing_docs, reason = "the words of each variant say it")]
pub enum What {
    /// A codel, or a delay, took longer than it may.
    Longer { took: u64, limit: Ticks },
    /// It took less time than it must.
    Shorter { took: u64, limit: Ticks },
    /// It threw an exception, and declares none.
    Undeclared,
    /// It is not possible there; these steps would be.
    Impossible { possible: Vec<Step> },
    /// Something else, or time, came although this had to come first.
    Omitted { due: Step },
    /// The recording goes back in time.
    Backwards,
}

/// A difference.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Difference {
    /// Number of the recorded step, from 1.
    pub number: u64,
    /// The recorded step.
    pub step: Step,
    /// The rule that differs. It is that of the step, or of what had to happen first.
    pub rule: Rule,
    /// How.
    #[serde(flatten)]
    pub what: What,
}

/// What came of it.
#[derive(Debug, Clone, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct ReplayReport {
    /// Version of the form.
    pub format: u32,
    /// Steps of the recording.
    pub steps: u64,
    /// Those that were followed.
    pub followed: u64,
    /// Units of the system from the start to the last moment that was followed.
    pub time: u64,
    /// Requests that somebody outside sent, and activities that he interrupted: nothing of the model does
    /// that.
    pub from_outside: u64,
    /// The first differences.
    pub differences: Vec<Difference>,
    /// All of them.
    pub difference_count: u64,
}

/// See the [module](self).
pub struct Replay<'s> {
    system: &'s TimedSystem,
    stepper: Stepper<'s>,
    /// By codel: whether the specification lets it throw.
    throws: Vec<bool>,
    /// Clients from this one on stand for somebody outside.
    outside: usize,
    /// When executors began what they execute, and the time they may take.
    begun: Vec<(u64, (Ticks, Ticks))>,
    /// Executors whose end was let go, because they took longer.
    longer: Vec<bool>,
    /// Executors that had no core when time passed last.
    waited: Vec<bool>,
    possible: Possible,
    seen: Vec<Seen>,
    /// Nobody knows any more which state the run is in.
    lost: bool,
    report: ReplayReport,
}

/// A system in which every codel may throw: that some must not is looked at by [`Replay`].
pub fn opened(system: &TimedSystem) -> TimedSystem {
    let mut out = system.clone();
    for it in &mut out.codels {
        it.throws = true;
    }
    out
}

impl<'s> Replay<'s> {
    /// For a run of a system. `system` is the [opened](opened) form of the `verified` one; clients from
    /// `outside` on stand for somebody outside.
    pub fn new(system: &'s TimedSystem, verified: &TimedSystem, outside: Option<usize>) -> Self {
        let mut stepper = Stepper::new(system, &Watched::default());
        let mut seen = Vec::new();
        stepper.begin(&mut seen);
        let executors = stepper.executors();
        let mut out = Replay {
            throws: verified.codels.iter().map(|it| it.throws).collect(),
            outside: outside.unwrap_or(system.clients.len()),
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
            },
            system,
            stepper,
            seen,
        };
        out.look();
        out
    }

    /// The next recorded step.
    pub fn step(&mut self, step: &Step) {
        self.report.steps += 1;
        if self.lost || !self.until(step.time, step) {
            return;
        }
        if step.rule == Rule::Abort {
            return self.abort(step);
        }
        self.stepper.possible(&mut self.possible);
        let mut found = self.find(step);
        if found.is_none()
            && let Some(executor) = self.ends(step)
        {
            found = self.find_end(executor, step);
        }
        let Some(action) = found else {
            // What was tried for the end of a codel has gone by.
            self.stepper.possible(&mut self.possible);
            let actions = self.possible.actions().iter().take(TOLD);
            let possible = actions.map(|&it| Step::new(self.system, &self.stepper, it));
            let possible: Vec<Step> = possible.collect();
            self.lost = true;
            let due = possible.first().filter(|_| self.possible.is_committed());
            return match due.cloned() {
                Some(due) => self.differs(step, due.rule, What::Omitted { due }),
                None => self.differs(step, step.rule, What::Impossible { possible }),
            };
        };
        self.about(step, action);
        self.stepper.perform(action, &mut self.seen);
        self.look();
        self.report.followed += 1;
    }

    /// The recording has ended, at a time.
    pub fn end(mut self, time: u64) -> ReplayReport {
        if !self.lost {
            let end = Step {
                time,
                rule: Rule::End,
                of: String::new(),
                what: String::new(),
                to: String::new(),
            };
            // What was to happen at the very end may have been left out.
            self.until(time, &end);
            for executor in 0..self.longer.len() {
                self.tell_longer(executor, &end);
            }
        }
        self.report.time = self.stepper.now();
        self.report
    }

    /// The possible action that a step is.
    fn find(&self, step: &Step) -> Option<Action> {
        let mut actions = self.possible.actions().iter().copied();
        actions.find(|&it| Step::new(self.system, &self.stepper, it) == *step)
    }

    /// The action by which an executor ends that may not: it took less time than it must; or it has executed
    /// all it wanted to when it lost its core, and needs none any more.
    fn find_end(&mut self, executor: usize, step: &Step) -> Option<Action> {
        let (least, _) = self.stepper.window(executor)?;
        if least == 0 && self.waited[executor] {
            return None;
        }
        self.stepper.set_window(executor, (0, 0));
        self.stepper.possible(&mut self.possible);
        let found = self.find(step)?;
        if least > 0 {
            let (took, limit) = (self.took(executor), self.begun[executor].1.0);
            self.differs(step, step.rule, What::Shorter { took, limit });
        }
        Some(found)
    }

    /// Who ends with a step, if he executes what it says.
    fn ends(&self, step: &Step) -> Option<usize> {
        let ends = matches!(step.rule, Rule::End | Rule::Delay);
        let mut executing =
            (0..self.stepper.executors()).filter(|&it| ends && self.stepper.window(it).is_some());
        executing.find(|&executor| {
            let it = self.end_of(executor);
            (it.rule, &it.of, &it.what) == (step.rule, &step.of, &step.what)
        })
    }

    /// The step by which an executor would end.
    fn end_of(&self, executor: usize) -> Step {
        let ends = Action::Finish {
            executor,
            outcome: 0,
        };
        Step::new(self.system, &self.stepper, ends)
    }

    /// What is to be said of a step that is possible.
    fn about(&mut self, step: &Step, action: Action) {
        match action {
            Action::Finish { executor, .. } => {
                self.tell_longer(executor, step);
                let codel = self.stepper.work(executor).and_then(|it| it.codel());
                let throws = codel.is_none_or(|it| self.throws.get(it).is_some_and(|it| *it));
                // Whoever refuses a request does so with an exception, declared or not.
                let state = matches!(self.stepper.work(executor), Some(Work::State { .. }));
                if state && step.to == step::EXCEPTION && !throws {
                    self.differs(step, Rule::End, What::Undeclared);
                }
            }
            Action::Request { client, .. } if client >= self.outside => {
                self.report.from_outside += 1;
            }
            _ => {}
        }
    }

    /// Lets time pass until a step. `false`: the run is not followed further.
    fn until(&mut self, time: u64, step: &Step) -> bool {
        if time < self.stepper.now() {
            self.lost = true;
            self.differs(step, step.rule, What::Backwards);
            return false;
        }
        while self.stepper.now() < time {
            self.stepper.possible(&mut self.possible);
            if !self.possible.may_wait() {
                if self.overrun() {
                    continue;
                }
                let due = self.possible.actions().first();
                let due = due.map(|&it| Step::new(self.system, &self.stepper, it));
                self.lost = true;
                let Some(due) = due else { return false };
                self.differs(step, due.rule, What::Omitted { due });
                return false;
            }
            let left = time - self.stepper.now();
            let jump = self.stepper.next_moment_but(&|_| true);
            let jump = jump.map_or(left, u64::from).clamp(1, left);
            let jump = Ticks::try_from(jump).unwrap_or(FOREVER - 1);
            let window = |it: &Stepper<'_>, executor| it.window(executor);
            let executors = 0..self.stepper.executors();
            let before: Vec<_> = executors.map(|it| window(&self.stepper, it)).collect();
            self.stepper.pass(jump, &mut self.seen);
            self.seen.clear();
            for (executor, before) in before.into_iter().enumerate() {
                // Where there is no limit nobody sees whether it got on.
                let known = before.filter(|it| it.1 != FOREVER);
                self.waited[executor] =
                    known.is_some_and(|it| window(&self.stepper, executor) == Some(it));
            }
        }
        true
    }

    /// Lets go whoever has to end now, and did not: he takes longer.
    fn overrun(&mut self) -> bool {
        let mut any = false;
        for executor in 0..self.stepper.executors() {
            if self.stepper.window(executor).is_some_and(|it| it.1 == 0) {
                self.stepper.set_window(executor, (0, FOREVER));
                self.longer[executor] = true;
                any = true;
            }
        }
        any
    }

    fn tell_longer(&mut self, executor: usize, step: &Step) {
        if !std::mem::take(&mut self.longer[executor]) {
            return;
        }
        let whose = self.end_of(executor);
        let (took, limit) = (self.took(executor), self.begun[executor].1.1);
        let step = match step.what.is_empty() && step.of.is_empty() {
            // The recording has ended before it has.
            true => &whose,
            false => step,
        };
        self.differs(&step.clone(), whose.rule, What::Longer { took, limit });
    }

    fn took(&self, executor: usize) -> u64 {
        self.stepper.now() - self.begun[executor].0
    }

    fn abort(&mut self, step: &Step) {
        let place = step.what.parse().ok();
        let place = place.filter(|&it| it < self.stepper.places());
        let known = place.filter(|&it| Step::abort(self.system, &self.stepper, it) == *step);
        let Some(place) = known else {
            self.lost = true;
            let possible = Vec::new();
            return self.differs(step, Rule::Abort, What::Impossible { possible });
        };
        self.stepper.interrupt(place);
        self.report.from_outside += 1;
        self.report.followed += 1;
    }

    /// Who has begun something.
    fn look(&mut self) {
        let now = self.stepper.now();
        for it in self.seen.drain(..) {
            if let Seen::Begun { executor, time, .. } = it
                && let Some(begun) = self.begun.get_mut(executor)
            {
                *begun = (now, time);
            }
        }
    }

    fn differs(&mut self, step: &Step, rule: Rule, what: What) {
        self.report.difference_count += 1;
        if self.report.differences.len() < KEPT {
            self.report.differences.push(Difference {
                number: self.report.steps,
                step: step.clone(),
                rule,
                what,
            });
        }
    }
}
