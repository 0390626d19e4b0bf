//! The comparison of a run with the checks of its scenario and with proved bounds.

use dotgen_timing::explore::{RunState, Seen, Work};
use dotgen_timing::property::DataFact;
use dotgen_timing::system::{TaskId, Ticks};
use dotgen_timing::verify::{Prepared, Question};

use crate::engine::End;
use crate::watch::CodelViolation;

/// The result of a run for a check. A run never proves that a check holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The run shows nothing about the check: [`Idle`] says why.
    #[default]
    NotExercised,
    /// It was exercised, and no violation was seen.
    Kept,
    /// The same, in a run in which codels were simulated: nothing is known about the program.
    Simulated,
    /// The check was violated.
    Violated,
    /// The expected event was seen: for people, the check is kept.
    Seen,
    /// The expected event was not seen: for people, the check was not exercised.
    NotSeen,
}

/// The reason why a run shows nothing about a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Idle {
    /// The task executed no codel.
    NoCodel { task: usize },
    /// No codel was executed at all.
    NothingExecuted,
    /// No codel is executed that writes the compared data: number of the comparison.
    NoData { fact: usize },
    /// The compared data was not written: number of the comparison.
    NotWritten { fact: usize },
    /// The first predicate of the check did not become true.
    NoTrigger,
    /// Nothing happened that the pattern is about.
    NoPattern,
    /// The first predicate became true, and the run ended before the second one did.
    NotAnswered,
    /// The expected event did not come.
    NotSeen,
}

/// A moment of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    /// Index of the run, from 0.
    pub run: u64,
    /// Time since the start of the run, in base units.
    pub time: u64,
}

/// The answer to a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CheckResult {
    pub verdict: Verdict,
    /// First moment at which the verdict was known.
    pub at: Option<Moment>,
    /// Greatest time measured for the check, in base units.
    pub greatest: Option<Ticks>,
    /// Number of violations.
    pub violations: u64,
    /// Number of runs in which the check was violated, or the expected event was seen.
    pub in_runs: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Violation {
    /// The check with this index is violated.
    Check(usize),
    /// A response time exceeds its proved bound: an assumption does not hold, or dotgen has an error. Times
    /// are in base units.
    BeyondBound {
        task: usize,
        /// Response time so far.
        response: Ticks,
        bound: Ticks,
    },
    /// The codel misbehaved: index in [`RunChecker::broken`].
    CodelViolation(usize),
}

/// Compares runs with checks and bounds.
#[derive(Debug)]
pub struct RunChecker<'p> {
    prepared: &'p Prepared,
    /// Index of each check in the watch list.
    places: Vec<Option<usize>>,
    /// Bounds on response times in base units, by task.
    bounds: Vec<Option<Ticks>>,
    /// Longest response time so far and its moment, by task.
    longest: Vec<Option<(Ticks, Moment)>>,
    /// Answers, by check.
    pub answers: Vec<CheckResult>,
    /// The first violation of each kind, with its moment.
    pub violations: Vec<(Moment, Violation)>,
    /// Number of occurrences of each violation.
    pub times: Vec<u64>,
    /// Misbehaviour of codels, without repetition; for overruns, the greatest one.
    pub broken: Vec<CodelViolation>,
    /// Number of all violations.
    pub count: u64,
    /// Tasks of lost components: the model continues, but these tasks execute nothing.
    gone: Vec<bool>,
    run: u64,
    /// Checks whose limit is exceeded at present.
    exceeded: Vec<bool>,
    /// Tasks whose bound is exceeded at present.
    beyond: Vec<bool>,
    /// Checks whose predicate was true in this run.
    reached: Vec<bool>,
    /// Checks that were violated in this run.
    violated: Vec<bool>,
    /// Comparisons of data that no run evaluates.
    absent: Vec<bool>,
    /// Comparisons of data that a run has evaluated.
    known: Vec<bool>,
    /// Checks that would be exercised if their comparisons of data were known.
    awaits_data: Vec<bool>,
}

impl<'p> RunChecker<'p> {
    /// Creates a judge for a system whose tasks have these bounds on their response times.
    pub fn new(
        prepared: &'p Prepared,
        places: Vec<Option<usize>>,
        bounds: Vec<Option<Ticks>>,
    ) -> Self {
        let facts = prepared.built.data.iter().flatten().count();
        let answers = prepared.checks.iter().map(|check| CheckResult {
            verdict: match check.question {
                Question::Reachable(_) | Question::Eventually(_) => Verdict::NotSeen,
                _ => Verdict::NotExercised,
            },
            ..CheckResult::default()
        });
        RunChecker {
            answers: answers.collect(),
            exceeded: vec![false; prepared.checks.len()],
            beyond: vec![false; bounds.len()],
            reached: vec![false; prepared.checks.len()],
            violated: vec![false; prepared.checks.len()],
            absent: vec![false; facts],
            known: vec![false; facts],
            awaits_data: vec![false; prepared.checks.len()],
            violations: Vec::new(),
            times: Vec::new(),
            broken: Vec::new(),
            gone: vec![false; bounds.len()],
            longest: vec![None; bounds.len()],
            count: 0,
            run: 0,
            prepared,
            places,
            bounds,
        }
    }

    /// Leaves checks unanswered if `has_data` says that no run evaluates a comparison of data in them.
    pub fn find_data(&mut self, has_data: &dyn Fn(&DataFact) -> bool) {
        let facts = self.prepared.built.data.iter().flatten();
        self.absent = facts.map(|fact| !has_data(fact)).collect();
        for check in 0..self.answers.len() {
            if self.lacks_data(check) {
                self.answers[check].verdict = Verdict::NotExercised;
            }
        }
    }

    fn lacks_data(&self, check: usize) -> bool {
        self.prepared.checks[check].data.iter().any(|&fact| self.absent[fact])
    }

    /// Records an event.
    pub fn on_event(&mut self, state: &impl RunState, seen: &Seen) {
        let now = Moment { run: self.run, time: state.now() };
        self.note_data(state);
        match *seen {
            Seen::Missed { task } | Seen::Overdue { task } | Seen::Job { task, .. }
                if self.gone[task] => {}
            Seen::Missed { task } => self
                .each(now, |question| matches!(question, Question::Schedulable(of) if *of == task)),
            Seen::Overdue { task } => self
                .each(now, |question| matches!(question, Question::NoOverdue(of) if *of == task)),
            Seen::Job { task, response } => {
                self.lasts_job(now, task, response);
                self.over(|question| matches!(question, Question::Response(of, _) if *of == task));
                self.beyond[task] = false;
            }
            Seen::Reached { predicate } => self.reached(now, predicate),
            Seen::Answered { within, after } => {
                for check in 0..self.answers.len() {
                    if self.places[check] == Some(within) && self.is_within(check) {
                        self.exercise(check);
                        self.lasts(now, check, after);
                        self.exceeded[check] = false;
                    }
                }
            }
            Seen::Opened { monitor } | Seen::Violated { monitor } => {
                for check in 0..self.answers.len() {
                    let question = &self.prepared.checks[check].question;
                    if self.places[check] == Some(monitor)
                        && matches!(question, Question::Pattern(_))
                    {
                        self.exercise(check);
                        if matches!(*seen, Seen::Violated { .. }) {
                            self.violate(now, check);
                        }
                    }
                }
            }
            Seen::Ended { work, .. } => self.executed(&work),
            Seen::Asked { .. }
            | Seen::Begun { .. }
            | Seen::Requested { .. }
            | Seen::Refused { .. } => {}
        }
    }

    /// Notes the comparisons of data that have become known. From here on, a check that lacked one is
    /// exercised.
    fn note_data(&mut self, state: &impl RunState) {
        let fresh = |fact: &usize| !self.known[*fact] && state.knows_fact(*fact);
        let fresh: Vec<usize> = (0..self.known.len()).filter(fresh).collect();
        for &fact in &fresh {
            self.known[fact] = true;
        }
        for check in (0..self.answers.len()).filter(|_| !fresh.is_empty()) {
            if self.awaits_data[check] {
                self.exercise(check);
            }
        }
    }

    /// Records that a codel was executed: it exercises the checks of its task, and those that hold at every
    /// moment.
    fn executed(&mut self, work: &Work) {
        if work.codel().is_none() {
            return;
        }
        for check in 0..self.answers.len() {
            let exercised = match self.prepared.checks[check].question {
                Question::Schedulable(of) | Question::NoOverdue(of) | Question::Response(of, _) => {
                    matches!(*work, Work::State { task, .. } if task == of)
                }
                Question::Always(_) | Question::Deadlock => true,
                _ => false,
            };
            if exercised {
                self.exercise(check);
            }
        }
    }

    fn exercise(&mut self, check: usize) {
        if self.prepared.checks[check].data.iter().any(|&fact| !self.known[fact]) {
            self.awaits_data[check] = true;
            return;
        }
        let verdict = &mut self.answers[check].verdict;
        if *verdict == Verdict::NotExercised {
            *verdict = Verdict::Kept;
        }
    }

    /// Returns the reason why a check was not exercised; `None` if it was.
    pub fn idle(&self, check: usize) -> Option<Idle> {
        if !matches!(self.answers[check].verdict, Verdict::NotExercised | Verdict::NotSeen) {
            return None;
        }
        let mut data = self.prepared.checks[check].data.iter().copied();
        if let Some(fact) = data.clone().find(|&fact| self.absent[fact]) {
            return Some(Idle::NoData { fact });
        }
        if let Some(fact) = data.find(|&fact| !self.known[fact]) {
            return Some(Idle::NotWritten { fact });
        }
        Some(match self.prepared.checks[check].question {
            Question::Schedulable(task)
            | Question::NoOverdue(task)
            | Question::Response(task, _) => Idle::NoCodel { task },
            Question::Always(_) | Question::Deadlock => Idle::NothingExecuted,
            Question::LeadsTo(..) if self.answers[check].greatest.is_some() => Idle::NotAnswered,
            Question::Within(..) | Question::LeadsTo(..) => Idle::NoTrigger,
            Question::Pattern(_) => Idle::NoPattern,
            Question::Eventually(_) | Question::Reachable(_) => Idle::NotSeen,
        })
    }

    /// Compares the longest response times so far with bounds that became known only now.
    pub fn bound_late(&mut self, bounds: &[Option<Ticks>]) {
        for (task, &bound) in bounds.iter().enumerate() {
            let known = self.bounds[task];
            let Some(bound) = bound.filter(|&bound| known.is_none_or(|known| bound < known)) else {
                continue;
            };
            self.bounds[task] = Some(bound);
            let of_task = |violation: &Violation| match *violation {
                Violation::BeyondBound { task: of, .. } => of == task,
                _ => false,
            };
            if let Some((response, when)) = self.longest[task].filter(|(time, _)| *time > bound)
                && !self.violations.iter().any(|violation| of_task(&violation.1))
            {
                let violation = Violation::BeyondBound { task, response, bound };
                self.note(when, violation);
            }
        }
    }

    /// Records a violation by a codel.
    pub fn on_violation(&mut self, state: &impl RunState, violation: CodelViolation) {
        let now = Moment { run: self.run, time: state.now() };
        if let CodelViolation::Lost { component, .. } = &violation {
            let system = &self.prepared.built.system;
            for (task, gone) in self.gone.iter_mut().enumerate() {
                *gone |= system.components[system.tasks[TaskId::from(task)].component].name
                    == *component;
            }
        }
        let known = self.broken.iter_mut().position(|known| match (known, &violation) {
            (
                CodelViolation::Overrun { codel: a, took, .. },
                CodelViolation::Overrun { codel: b, took: new, .. },
            ) => {
                let same = *a == *b;
                if same {
                    *took = (*took).max(*new);
                }
                same
            }
            (a, b) => *a == *b,
        });
        if let (Some(_), CodelViolation::Overrun { known: true, .. }) = (known, &violation) {
            return;
        }
        let place = known.unwrap_or_else(|| {
            self.broken.push(violation);
            self.broken.len() - 1
        });
        self.note(now, Violation::CodelViolation(place));
    }

    /// Updates times that are still running, after time has passed.
    pub fn moment(&mut self, state: &impl RunState) {
        let now = Moment { run: self.run, time: state.now() };
        for task in 0..self.bounds.len() {
            if self.gone[task] {
                continue;
            }
            if let Some(so_far) = state.job(task) {
                self.lasts_job(now, task, so_far);
            }
        }
        for check in 0..self.places.len() {
            if let (Some(place), true) = (self.places[check], self.is_within(check))
                && let Some(so_far) = state.awaited(place)
            {
                // Without a limit, only an answer shows anything.
                if matches!(self.prepared.checks[check].question, Question::Within(..)) {
                    self.exercise(check);
                }
                self.lasts(now, check, so_far);
            }
        }
    }

    /// Records that a run ends, or begins to: nothing that is awaited comes any more.
    pub fn end_checks(&mut self, state: &impl RunState, end: End) {
        let now = Moment { run: self.run, time: state.now() };
        if end == End::NothingLeft {
            self.each(now, |question| matches!(question, Question::Deadlock));
            for check in 0..self.places.len() {
                // The awaited event can no longer come.
                let awaited = match (&self.prepared.checks[check].question, self.places[check]) {
                    (Question::LeadsTo(..) | Question::Within(..), Some(place)) => {
                        state.awaited(place).is_some()
                    }
                    (Question::Eventually(_), _) => !self.reached[check],
                    _ => false,
                };
                if awaited && !self.exceeded[check] {
                    self.violate(now, check);
                }
            }
        }
    }

    /// Prepares for the next run.
    pub(crate) fn next_run(&mut self) {
        for (check, answer) in self.answers.iter_mut().enumerate() {
            answer.in_runs += u64::from(self.reached[check] || self.violated[check]);
        }
        self.violated.fill(false);
        self.exceeded.fill(false);
        self.beyond.fill(false);
        self.gone.fill(false);
        self.reached.fill(false);
        self.run += 1;
    }

    /// Returns the name of a check, if it has one.
    pub fn name_of(&self, check: usize) -> Option<&str> {
        self.prepared.checks[check].report.name.as_deref()
    }

    /// Returns true if there was a violation.
    pub(crate) fn has_violations(&self) -> bool {
        self.count > 0
    }

    fn is_within(&self, check: usize) -> bool {
        matches!(self.prepared.checks[check].question, Question::Within(..) | Question::LeadsTo(..))
    }

    fn each(&mut self, now: Moment, concerned: impl Fn(&Question) -> bool) {
        for check in 0..self.answers.len() {
            if concerned(&self.prepared.checks[check].question) {
                self.violate(now, check);
            }
        }
    }

    fn over(&mut self, concerned: impl Fn(&Question) -> bool) {
        for (check, exceeded) in self.exceeded.iter_mut().enumerate() {
            *exceeded &= !concerned(&self.prepared.checks[check].question);
        }
    }

    fn reached(&mut self, now: Moment, predicate: usize) {
        for check in 0..self.answers.len() {
            if self.places[check] != Some(predicate) {
                continue;
            }
            match self.prepared.checks[check].question {
                Question::Always(_) => self.violate(now, check),
                Question::Reachable(_) | Question::Eventually(_) if !self.lacks_data(check) => {
                    self.reached[check] = true;
                    let answer = &mut self.answers[check];
                    if answer.verdict == Verdict::NotSeen {
                        answer.verdict = Verdict::Seen;
                        answer.at = Some(now);
                    }
                }
                _ => {}
            }
        }
    }

    fn lasts_job(&mut self, now: Moment, task: usize, time: Ticks) {
        for check in 0..self.answers.len() {
            if matches!(self.prepared.checks[check].question, Question::Response(of, _) if of == task)
            {
                self.lasts(now, check, time);
            }
        }
        if self.longest[task].is_none_or(|(longest, _)| time > longest) {
            self.longest[task] = Some((time, now));
        }
        if let Some(bound) = self.bounds[task].filter(|&bound| time > bound)
            && !std::mem::replace(&mut self.beyond[task], true)
        {
            self.note(now, Violation::BeyondBound { task, response: time, bound });
        }
    }

    /// Updates the greatest time of a check.
    fn lasts(&mut self, now: Moment, check: usize, time: Ticks) {
        if self.lacks_data(check) {
            return;
        }
        let answer = &mut self.answers[check];
        answer.greatest = answer.greatest.max(Some(time));
        let limit = match self.prepared.checks[check].question {
            Question::Response(_, limit) | Question::Within(_, _, limit) => limit,
            _ => None,
        };
        let exceeds = limit.is_some_and(|limit| time > limit);
        if exceeds && !std::mem::replace(&mut self.exceeded[check], true) {
            self.violate(now, check);
        }
    }

    fn violate(&mut self, now: Moment, check: usize) {
        if self.lacks_data(check) {
            return;
        }
        let answer = &mut self.answers[check];
        answer.violations += 1;
        self.violated[check] = true;
        if answer.verdict != Verdict::Violated {
            answer.verdict = Verdict::Violated;
            answer.at = Some(now);
        }
        self.note(now, Violation::Check(check));
    }

    fn note(&mut self, now: Moment, violation: Violation) {
        self.count += 1;
        let same = |other: &Violation| match (*other, violation) {
            (Violation::BeyondBound { task: a, .. }, Violation::BeyondBound { task: b, .. }) => {
                a == b
            }
            (a, b) => a == b,
        };
        if let Some(place) = self.violations.iter().position(|violation| same(&violation.1)) {
            self.times[place] += 1;
        } else {
            self.violations.push((now, violation));
            self.times.push(1);
        }
    }
}
