//! Checks as observers: locations of the scheduler that are reached if a check fails, or if it has a witness.

use dotgen_timing::property::predicate::{Atom, Predicate};
use dotgen_timing::report::CheckReport;
use dotgen_timing::system::TaskId;
use dotgen_timing::verify::{Prepared, PreparedCheck, Question};

use crate::model::{
    Clock, ClockGuard, Edge, Guard, LocationKind, Network, Process, Query, QueryKind, Relation,
    Update, Variable, all, any, var,
};

use super::layout::{Layout, TaskPart, position};
use super::monitors::Watch;
use super::predicates::{self, Conditions};
use super::refusals::{self, Refusal};
use super::sequences::Sequence;
use super::unique::identifier;

/// Name of the process that observes.
pub(super) const SCHEDULER: &str = "scheduler";

/// Its location in which time passes.
pub(super) const CALM: &str = "calm";

/// The checks of a system.
pub(super) struct Checks<'c> {
    layout: &'c Layout<'c>,
    entries: Vec<Entry<'c>>,
    /// Atoms that predicates leave: each has a variable with its value in the state before.
    left: Vec<&'c Atom>,
}

/// A check.
struct Entry<'c> {
    /// Number of the check, from 1.
    number: usize,
    /// Kind and subject, after the name if the check has one.
    name: String,
    /// Name of its location.
    goal: String,
    question: &'c Question,
}

/// Returns the name of a check in models and refusals: kind and subject, after its own name if it has one.
pub fn check_name(report: &CheckReport) -> String {
    let words = format!("{} {}", report.kind, report.of);
    report.name.as_ref().map(|name| format!("{name}: {words}")).unwrap_or(words)
}

/// The clocks of a response time: the present job's is `a` or `b`, as a variable says.
const SIDES: [(usize, &str); 2] = [(0, "a"), (1, "b")];

impl<'c> Checks<'c> {
    pub(super) fn new(
        layout: &'c Layout<'c>,
        prepared: &'c Prepared,
    ) -> Result<Checks<'c>, Vec<Refusal>> {
        let mut out = Checks { layout, entries: Vec::new(), left: Vec::new() };
        let mut refusals = Vec::new();
        for (index, check) in prepared.checks.iter().enumerate() {
            let PreparedCheck { report, question, .. } = check;
            let name = check_name(report);
            let goal = format!("check_{}_{}", index + 1, identifier(report.kind.word()));
            let mut parts: Vec<&Predicate> = Vec::new();
            match question {
                Question::Within(p, list, _) => parts.extend(std::iter::once(p).chain(list)),
                Question::Always(p) | Question::Reachable(p) => parts.push(p),
                Question::Pattern(monitor) => parts.extend(&monitor.predicates),
                Question::LeadsTo(..) | Question::Eventually(_) => {
                    refusals.push(Refusal::new(report.kind.word(), Some(name.clone())));
                }
                Question::Deadlock if prepared.checks.iter().any(has_limit) => {
                    let construct = format!("{} next to a check of a time", report.kind.word());
                    refusals.push(Refusal::new(&construct, Some(name.clone())));
                }
                Question::Deadlock
                | Question::Schedulable(_)
                | Question::NoOverdue(_)
                | Question::Response(..) => {}
            }
            let negated = matches!(question, Question::Always(_));
            for predicate in parts {
                // The verifier also looks after time has passed, the network after actions only.
                if predicate.needs_no_moment(negated, true) {
                    refusals.push(Refusal::new("not leave", Some(name.clone())));
                }
                predicates::left(predicate, &mut out.left);
                let mut atoms = Vec::new();
                atoms_of(predicate, &mut atoms);
                refusals
                    .extend(atoms.iter().filter_map(|atom| refusals::of_atom(layout, atom, &name)));
            }
            out.entries.push(Entry { number: index + 1, name, goal, question });
        }
        if refusals.is_empty() { Ok(out) } else { Err(refusals) }
    }

    /// Returns true if the response time of a task is measured.
    fn measures(&self, task: &TaskPart) -> bool {
        self.entries.iter().any(|entry| match *entry.question {
            Question::Response(of, _) | Question::NoOverdue(of) => TaskId::from(of) == task.id,
            _ => false,
        })
    }

    /// Returns the observers of predicates that follow each other.
    fn withins(&self) -> impl Iterator<Item = Sequence<'_>> {
        self.entries.iter().filter_map(|entry| match entry.question {
            Question::Within(trigger, responses, _) => {
                Some(Sequence { number: entry.number, name: &entry.name, trigger, responses })
            }
            _ => None,
        })
    }

    /// Returns the monitors of patterns.
    fn patterns(&self) -> impl Iterator<Item = Watch<'_>> {
        self.entries.iter().filter_map(|entry| match entry.question {
            Question::Pattern(monitor) => {
                Some(Watch { number: entry.number, name: &entry.name, monitor })
            }
            _ => None,
        })
    }

    pub(super) fn declare(&self, network: &mut Network) {
        let mut variable = |name: String, comment: String| {
            network.variables.push(Variable { name, size: None, most: 1, comment });
        };
        let mut clocks = Vec::new();
        let tasks = self.layout.parts.iter().flat_map(|part| &part.tasks);
        for task in tasks.filter(|task| self.measures(task)) {
            if !self.layout.jobs {
                let what = format!("clock of the present job of {}: 0 a, 1 b", task.name);
                variable(format!("measures_{}", task.name), what);
            }
            for (_, side) in self.sides() {
                let comment = format!("age of a job of {}", task.name);
                clocks.push(Clock { name: format!("job_{}_{side}", task.name), comment });
            }
        }
        network.clocks.extend(clocks);
        for sequence in self.withins() {
            sequence.declare(network);
        }
        for watch in self.patterns() {
            watch.declare(network);
        }
        let mut variable = |name: String, comment: String| {
            network.variables.push(Variable { name, size: None, most: 1, comment });
        };
        for index in 0..self.left.len() {
            variable(format!("held_before_{index}"), "1: held before the last action".to_owned());
        }
    }

    /// Returns the cases of a tick: when, updates, and a comment.
    pub(super) fn at_tick(&self, task: &TaskPart) -> Vec<(Guard, Vec<Update>, &'static str)> {
        if !self.measures(task) || self.layout.jobs {
            return vec![(Guard::always(), Vec::new(), "a tick")];
        }
        let measures = task.flag("measures");
        let due = task.due();
        let mut out = vec![(due.clone().is(1_usize), Vec::new(), "a tick, while one is kept")];
        for (number, side) in SIDES {
            let other = SIDES[1 - number].1;
            let of = all([due.clone().is(0_usize), measures.clone().is(number)]);
            let reset = |side: &str| vec![Update::Reset(format!("job_{}_{side}", task.name))];
            let idle = all([of.clone(), task.position().below(position::WAITS)]);
            out.push((idle, reset(side), "a tick: a job begins"));
            let busy = all([of, task.position().at_least(position::WAITS)]);
            out.push((busy, reset(other), "a tick, which is kept for the next job"));
        }
        out
    }

    /// Returns the cases of the end of a cycle: when, updates, and a comment.
    pub(super) fn at_end(&self, task: &TaskPart) -> Vec<(Guard, Vec<Update>, &'static str)> {
        if !self.measures(task) {
            return vec![(Guard::always(), Vec::new(), "the cycle is over")];
        }
        let (measures, first) = (task.flag("measures"), task.first());
        let mut out = Vec::new();
        for (number, side) in SIDES {
            let guard = all([first.clone().is(1_usize), measures.clone().is(number)]);
            let reset = vec![Update::Reset(format!("job_{}_{side}", task.name))];
            out.push((guard, reset, "the first cycle is over: a kept tick counts from now"));
            let guard = all([
                first.clone().is(0_usize),
                task.due().is(1_usize),
                measures.clone().is(number),
            ]);
            let other = vec![measures.clone().set(1 - number)];
            out.push((guard, other, "the cycle is over: a kept tick begins the next job"));
        }
        let guard = all([first.is(0_usize), task.due().is(0_usize)]);
        out.push((guard, Vec::new(), "the cycle is over"));
        out
    }

    /// Returns the updates of the release of a task, with which a job of the published models begins.
    pub(super) fn at_release(&self, task: &TaskPart) -> Option<Update> {
        self.measures(task).then(|| Update::Reset(format!("job_{}_a", task.name)))
    }

    /// Returns the clocks of a response time: a job of the published models keeps no tick.
    fn sides(&self) -> &'static [(usize, &'static str)] {
        if self.layout.jobs { &SIDES[..1] } else { &SIDES }
    }

    /// Returns the clocks of the present job of a task, each with the condition that it counts while another
    /// condition holds.
    fn clocks(&self, task: &TaskPart, while_: &Guard) -> Vec<(Guard, String)> {
        let of_side = |&(number, side): &(usize, &str)| {
            let measures =
                if self.layout.jobs { Guard::always() } else { task.flag("measures").is(number) };
            (all([while_.clone(), measures]), format!("job_{}_{side}", task.name))
        };
        self.sides().iter().map(of_side).collect()
    }

    /// Returns the condition that a task has a job.
    fn job(&self, task: &TaskPart) -> Guard {
        let active = task.position().at_least(position::WAITS);
        if self.layout.jobs {
            return active;
        }
        let begun = all([task.position().is(position::IDLE), task.due().is(1_usize)]);
        all([task.first().is(0_usize), any([active, begun])])
    }

    /// Returns the condition that the first cycle of a task, which is not measured, is over.
    fn is_measured(&self, task: &TaskPart) -> Guard {
        if self.layout.jobs { Guard::always() } else { task.first().is(0_usize) }
    }

    fn conditions(&self) -> Conditions<'_> {
        Conditions { layout: self.layout, left: &self.left }
    }

    /// Returns the first locations of the observers, in order, and `looks`.
    fn stations(&self) -> Vec<String> {
        let withins = self.withins().map(|sequence| sequence.first());
        let patterns = self.patterns().map(|watch| watch.first());
        withins.chain(patterns).chain(["looks".to_owned()]).collect()
    }

    /// Returns the location that follows an action.
    pub(super) fn first_location(&self) -> String {
        self.stations().swap_remove(0)
    }

    /// Adds the locations that observe the state after an action, up to `settles`.
    pub(super) fn observe(&self, out: &mut Process) {
        let stations = self.stations();
        let mut next = stations.iter().skip(1);
        for sequence in self.withins() {
            sequence.add(&self.conditions(), next.next().map_or("looks", String::as_str), out);
        }
        for watch in self.patterns() {
            watch.add(&self.conditions(), next.next().map_or("looks", String::as_str), out);
        }
        out.location("looks", LocationKind::Committed, "compares the state with the checks");
        let mut edge = Edge::new("looks", "settles", "all checks have seen the state");
        for (index, atom) in self.left.iter().enumerate() {
            let now = predicates::atom(self.layout, atom);
            edge.updates.push(var(&format!("held_before_{index}")).set_to(now));
        }
        out.edge(edge);
    }

    /// Adds the locations that are goals.
    pub(super) fn goals(&self, out: &mut Process) {
        for entry in &self.entries {
            out.location(&entry.goal, LocationKind::Normal, entry.name.clone());
            if let Some(location) = out.locations.last_mut() {
                location.is_goal = true;
            }
            for (source, guard, clock) in self.reached(entry) {
                let edge = Edge::new(source, &entry.goal, entry.name.clone());
                let mut edge = edge.when(guard);
                edge.clocks.extend(clock);
                out.edge(edge);
            }
        }
    }

    /// Returns the conditions under which a goal is reached: in a location, over integers, over a clock.
    fn reached(&self, entry: &Entry) -> Vec<(&'static str, Guard, Option<ClockGuard>)> {
        match entry.question {
            Question::Schedulable(task) => {
                let task = self.layout.task(TaskId::from(*task));
                let missed = all([
                    task.due().is(1_usize),
                    self.is_measured(task),
                    task.position().at_least(position::WAITS),
                ]);
                vec![("looks", missed, None)]
            }
            Question::NoOverdue(task) => {
                let task = self.layout.task(TaskId::from(*task));
                let waits = all([task.position().is(position::WAITS), self.is_measured(task)]);
                let period = task.period.unwrap_or(0);
                self.jobs(task, &waits, Relation::AtLeast, period)
            }
            Question::Response(task, Some(limit)) => {
                let task = self.layout.task(TaskId::from(*task));
                self.jobs(task, &self.job(task), Relation::Greater, i64::from(*limit))
            }
            Question::Within(_, _, Some(limit)) => {
                let late = |(open, clock): (Guard, String)| {
                    let value = i64::from(*limit);
                    (CALM, open, Some(ClockGuard { clock, relation: Relation::Greater, value }))
                };
                self.ages(entry).into_iter().map(late).collect()
            }
            Question::Pattern(_) => {
                let mut watches = self.patterns().filter(|watch| watch.number == entry.number);
                watches.next().map(|watch| ("looks", watch.violated(), None)).into_iter().collect()
            }
            Question::Always(p) => vec![("looks", self.conditions().after(p).negated(), None)],
            Question::Reachable(p) => vec![("looks", self.conditions().after(p), None)],
            _ => Vec::new(),
        }
    }

    /// Returns the clocks of open obligations of `within`, each with the condition that it counts.
    fn ages(&self, entry: &Entry) -> Vec<(Guard, String)> {
        let mut withins = self.withins().filter(|within| within.number == entry.number);
        withins.next().map(|sequence| sequence.ages()).unwrap_or_default()
    }

    /// Returns the conditions on the clock of a task's present job.
    fn jobs(
        &self,
        task: &TaskPart,
        while_: &Guard,
        relation: Relation,
        value: i64,
    ) -> Vec<(&'static str, Guard, Option<ClockGuard>)> {
        let clocks = self.clocks(task, while_).into_iter();
        let guard = |(guard, clock)| (CALM, guard, Some(ClockGuard { clock, relation, value }));
        clocks.map(guard).collect()
    }

    /// Returns the queries of all checks.
    pub(super) fn queries(&self) -> Vec<Query> {
        let mut out = Vec::new();
        for entry in &self.entries {
            let (process, location) = (SCHEDULER.to_owned(), entry.goal.clone());
            let mut add = |kind: QueryKind, comment: &str| {
                let comment = vec![comment.to_owned()];
                out.push(Query {
                    check: entry.number - 1,
                    name: entry.name.clone(),
                    comment,
                    kind,
                });
            };
            match entry.question {
                Question::Reachable(_) => {
                    add(QueryKind::Reachable { process, location }, "a run reaches the location");
                }
                Question::Response(task, limit) => {
                    if limit.is_some() {
                        add(QueryKind::Never { process, location }, "holds if it is never reached");
                    }
                    let task = self.layout.task(TaskId::from(*task));
                    let clocks = self.clocks(task, &self.job(task));
                    add(QueryKind::Greatest(clocks), "the response time is the greater value");
                }
                Question::Within(_, _, limit) => {
                    if limit.is_some() {
                        add(QueryKind::Never { process, location }, "holds if it is never reached");
                    }
                    add(QueryKind::Greatest(self.ages(entry)), "the longest time");
                }
                Question::Deadlock => {
                    let (process, location) = (SCHEDULER.to_owned(), CALM.to_owned());
                    add(QueryKind::Lively { process, location }, "an action always follows");
                }
                _ => add(QueryKind::Never { process, location }, "holds if it is never reached"),
            }
        }
        out
    }
}

/// Returns true if a check has a goal that is reached while time passes. Such a goal hides a deadlock.
fn has_limit(check: &PreparedCheck) -> bool {
    matches!(
        check.question,
        Question::NoOverdue(_) | Question::Response(_, Some(_)) | Question::Within(_, _, Some(_))
    )
}

/// Collects the atoms of a predicate.
fn atoms_of<'p>(predicate: &'p Predicate, out: &mut Vec<&'p Atom>) {
    match predicate {
        Predicate::Atom(atom) | Predicate::Leave(atom) => out.push(atom),
        Predicate::Not(of) => atoms_of(of, out),
        Predicate::And(one, other) | Predicate::Or(one, other) => {
            atoms_of(one, out);
            atoms_of(other, out);
        }
    }
}
