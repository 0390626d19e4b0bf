//! What delays the datum of a chain, from its write to the end of a run.

use typed_index_collections::{TiVec, ti_vec};

use super::findings::{Bound, Findings, Measured};
use super::observe::Observers;
use super::rules::token::{greatest_age, is_set};
use super::rules::{Action, Rules};
use super::run::Run;
use super::search::explore_by;
use super::spans::{ChainSpans, Spent, Subject, work_of};
use super::state::{Clocks, Stages, State};
use super::watch::{Limits, Watch, Within};
use crate::cancel::Cancel;
use crate::property::{Atom, Predicate, TaskState};
use crate::system::chain::{Chain, ChainKind, DataPlace};
use crate::system::{CodelId, TaskId, Ticks, TimedSystem};

/// Finds the supremum of a chain, by exploring all runs. It is the only entry of `within` in the findings;
/// `None` there if no write is ever marked.
pub fn explore_chain(
    system: &TimedSystem,
    chain: &Chain,
    limit: Option<Ticks>,
    limits: Limits,
    cancel: &Cancel,
) -> Findings {
    let never = || {
        let atom = Predicate::Atom(Atom::Task(TaskId::default(), TaskState::Idle));
        Predicate::And(Box::new(atom.clone()), Box::new(Predicate::Not(Box::new(atom))))
    };
    let watch = Watch {
        within: vec![Within { trigger: never(), responses: vec![never()], limit }],
        ..Watch::default()
    };
    let rules = Rules::for_chain(system, chain, &Clocks::none(system.tasks.len()));
    let mut found = explore_by(&rules, &watch, limits, cancel, &mut |_| {});
    if let Some(measurement) = found.within.iter().flatten().next() {
        found.chain = spans(system, chain, measurement);
    }
    for measurement in found.within.iter_mut().flatten() {
        without_marks(measurement);
    }
    found
}

fn spans(system: &TimedSystem, chain: &Chain, measured: &Measured) -> ChainSpans {
    let clocks = Clocks {
        within: vec![Stages { count: 1, measured: true }],
        ..Clocks::none(system.tasks.len())
    };
    let rules = Rules::for_chain(system, chain, &clocks);
    let focus = Focus::new(&rules, chain);
    let spent = |s: &State| focus.spends(s);
    let clock = |s: &State| rules.frame().observer_clock(s, 0);
    let age = |s: &State| clock(s).map_or(0, |clock| u64::from(s.t[clock]));
    let of_run = |run: &Run, age: &dyn Fn(&State) -> u64| {
        if run.left_out {
            Vec::new()
        } else {
            run.spans(&rules, &Observers::default(), age, &spent)
        }
    };
    let longest = &measured.longest;
    let length = longest.length_of_cycle();
    let late = measured.excess.as_ref().unwrap_or(longest);
    // An age without a bound comes from data that codels hand on to themselves, not from what goes on.
    let is_endless = length > 0 && chain.kind == ChainKind::Reaction;
    let cycle = if is_endless { of_run(longest, &|_| length) } else { Vec::new() };
    let waits = cycle.last().and_then(|span| match span.spent {
        Spent::Between(task) => Some(Subject::Job(task)),
        _ => None,
    });
    let codels = waits.map_or(Vec::new(), |subject| longest.executed_in_cycle(&rules, subject));
    ChainSpans { late: of_run(late, &age), cycle, codels }
}

/// Finds the codel that the measured datum waits for.
struct Focus<'r> {
    rules: &'r Rules<'r>,
    chain: &'r Chain,
    /// The number of codels after each codel on the shortest path to the last datum.
    after: TiVec<CodelId, usize>,
    subjects: TiVec<CodelId, Option<Subject>>,
}

impl<'r> Focus<'r> {
    fn new(rules: &'r Rules<'r>, chain: &'r Chain) -> Self {
        let system = rules.system();
        let subject = |codel: CodelId| Subject::of_codel(system, codel);
        Focus {
            after: codels_after(chain),
            subjects: system.codels.keys().map(subject).collect(),
            rules,
            chain,
        }
    }

    fn spends(&self, s: &State) -> Spent {
        let Focus { rules, chain, .. } = *self;
        let Some(token) = &rules.token else { return Spent::Nothing };
        let holders = rules.holders();
        let marked = |place: DataPlace| {
            let held = |holder: usize| is_set(s, token.marked_place(place, holder));
            match place {
                DataPlace::Shared(_) => held(0),
                DataPlace::Local(_) => (0..holders).any(held),
            }
        };
        let last = DataPlace::Shared(chain.last);
        if chain.kind == ChainKind::Age && marked(last) {
            // The old datum remains until the next one comes. The place farthest from the last one that still
            // has it delays that.
            let places = chain.writes.iter().flatten().copied().filter(|&place| marked(place));
            let oldest = places.max_by_key(|&place| self.distance(place)).unwrap_or(last);
            let writers = chain.writes.iter_enumerated().filter(|(_, all)| all.contains(&oldest));
            return self.of_codel(writers.map(|(codel, _)| codel).next(), s);
        }
        let carriers = (0..token.executors)
            .filter(|&executor| is_set(s, token.marked_executor(executor)))
            .filter_map(|executor| Some((executor, rules.codel_and_holder(s, executor)?.0)));
        if let Some((executor, codel)) = carriers.min_by_key(|(_, codel)| self.after[*codel]) {
            return work_of(rules, s, executor, codel);
        }
        let readers = chain.reads.iter_enumerated().filter(|(codel, reads)| {
            chain.carries[*codel] && reads.iter().any(|&place| marked(place))
        });
        self.of_codel(readers.map(|(codel, _)| codel).min_by_key(|&codel| self.after[codel]), s)
    }

    /// Returns the number of codels from a place to the last datum; 0 if there is no path.
    fn distance(&self, place: DataPlace) -> usize {
        let chain = self.chain;
        if place == DataPlace::Shared(chain.last) {
            return 0;
        }
        let readers = chain.reads.iter_enumerated();
        let readers =
            readers.filter(|(codel, reads)| chain.carries[*codel] && reads.contains(&place));
        let nearest = readers.map(|(codel, _)| self.after[codel]).min();
        nearest.and_then(|after| after.checked_add(1)).unwrap_or(0)
    }

    fn of_codel(&self, codel: Option<CodelId>, s: &State) -> Spent {
        let subject = codel.and_then(|codel| self.subjects[codel]);
        subject.map_or(Spent::Nothing, |subject| subject.spends(self.rules, s))
    }
}

/// See [`Focus::after`].
fn codels_after(chain: &Chain) -> TiVec<CodelId, usize> {
    let mut after = ti_vec![usize::MAX; chain.writes.len()];
    loop {
        let before: TiVec<CodelId, usize> = after.clone();
        for (codel, writes) in chain.writes.iter_enumerated() {
            let from = |place: &DataPlace| match *place {
                DataPlace::Shared(index) if index == chain.last => Some(0),
                place => {
                    let readers = chain.reads.iter_enumerated();
                    let readers = readers
                        .filter(|(reader, reads)| chain.carries[*reader] && reads.contains(&place));
                    readers.map(|(codel, _)| before[codel].saturating_add(1)).min()
                }
            };
            after[codel] = writes.iter().filter_map(from).min().unwrap_or(usize::MAX);
        }
        if after == before {
            return after;
        }
    }
}

/// Removes marks from runs: they are not actions of the system.
fn without_marks(measurement: &mut Measured) {
    let strip = |run: &mut Run| {
        let is_mark = |action: &Action| matches!(action, Action::Mark { .. });
        if let Some(cycle) = &mut run.cycle {
            let before = run.steps.iter().take(*cycle);
            *cycle -= before.filter(|step| is_mark(&step.1)).count();
        }
        run.steps.retain(|step| !is_mark(&step.1));
    };
    strip(&mut measurement.longest);
    if let Some(excess) = &mut measurement.excess {
        strip(excess);
    }
}

/// Returns true if the measured value of a chain is exact.
pub fn is_exact(system: &TimedSystem, chain: &Chain, bound: Bound) -> bool {
    match (chain.kind, bound) {
        (ChainKind::Age, Bound::Finite(value)) => value < greatest_age(system),
        _ => true,
    }
}
