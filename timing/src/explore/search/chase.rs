//! One search depth first. All rules and reductions are those of the search in order of time; only the order
//! differs, and states of all moments are compared with each other.
//!
//! Every state is followed as it was come to, and never joined with others: so the steps that led to it are a
//! run.

use std::hash::BuildHasher;

use rustc_hash::FxBuildHasher;

use super::goals::{Goal, Goals, PerGoal};
use super::layers::covering;
use super::watching::{Longest, Sight, Watching};
use crate::cancel::Cancel;
use crate::explore::findings::{Findings, Found};
use crate::explore::reductions::{Held, Reduced, Reductions};
use crate::explore::rules::{Action, Enabled, with_rules};
use crate::explore::run::Run;
use crate::explore::state::State;
use crate::explore::store::{Encoded, Store, encode};
use crate::explore::watch::{Limits, Stop, Watch};
use crate::system::{FOREVER, Ticks, TimedSystem};

/// Steps between two looks at what may end the search.
const LOOKS: u64 = 16;

/// Plausible times after which a run that goes on in the same way is given up.
const FAR: u64 = 4;

/// What is done first of what can be done in a state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Order {
    /// Time passes before anything that can wait.
    patient: bool,
    /// Codels that have an upper bound take as long as they can: what goes wrong mostly does so then. Not
    /// everything that can happen is looked at.
    pub(super) late: bool,
    /// Chooses among actions; `None`: the last of them first.
    dice: Option<u64>,
    /// Chooses the same whenever there is the same choice, so that what can go on for ever does.
    steady: bool,
}

impl Order {
    /// Orders that differ in more than luck.
    pub(super) const KINDS: u64 = 3;

    /// A different one for every number.
    pub(super) fn numbered(number: u64) -> Self {
        Order {
            patient: number % Self::KINDS == 1,
            late: number % Self::KINDS == 2,
            dice: (number > 0).then(|| number.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1),
            steady: false,
        }
    }

    /// The same, steadily, and mostly with codels that take as long as they can.
    pub(super) fn steady(self) -> Self {
        Order {
            late: self.late || self.patient,
            steady: true,
            ..self
        }
    }

    /// Puts actions in this order, the one to follow first last. What a task does that is to be `kept` from
    /// ending comes last.
    fn arrange(&mut self, list: &mut [(Action, Held)], kept: impl Fn(Action) -> bool) {
        if self.steady {
            let dice = self.dice;
            list.sort_by_cached_key(|it| (!kept(it.0), FxBuildHasher.hash_one((dice, it.0))));
            return;
        }
        let Some(dice) = &mut self.dice else { return };
        for i in (1..list.len()).rev() {
            // Xorshift.
            *dice ^= *dice << 13;
            *dice ^= *dice >> 7;
            *dice ^= *dice << 17;
            list.swap(i, (*dice % (i as u64 + 1)) as usize);
        }
    }
}

/// The number of a step among those that were taken.
type StepId = u32;

/// Before the first step.
const START: StepId = u32::MAX;

/// What led from one state to the next.
#[derive(Debug, Clone, Copy)]
enum Step {
    Act(Action),
    Pass(Ticks),
    /// What is alike was put in order.
    Order,
}

/// A state to go on from.
struct Open {
    s: State,
    held: Held,
    /// The last step to it, and its time.
    at: Sight<StepId>,
}

/// A search depth first.
pub(super) struct Chase<'a, R: Reduced> {
    /// The rules, and what was seen of what is watched: after which of the steps.
    watching: Watching<'a, R, StepId>,
    limits: Limits,
    cancel: &'a Cancel,
    passed: Store,
    /// Steps, each with the one before.
    trail: Vec<(StepId, Step)>,
    open: Vec<Open>,
    pub(super) steps: u64,
    /// Looks for a measured time, the only one, that is longer than this.
    pub(super) lasts: Option<Ticks>,
}

impl<'a, R: Reduced> Chase<'a, R> {
    pub(super) fn new(
        watching: Watching<'a, R, StepId>,
        limits: Limits,
        cancel: &'a Cancel,
    ) -> Self {
        Chase {
            passed: Store::new(watching.rules.frame().clocks(), covering(limits)),
            watching,
            limits,
            cancel,
            trail: Vec::new(),
            open: Vec::new(),
            steps: 0,
            lasts: None,
        }
    }

    /// Begins anew, and goes on for so many steps, never beyond the moment `end`. `beside` are states and
    /// bytes that are in use already. `false` if a limit ended it.
    pub(super) fn run(
        &mut self,
        mut order: Order,
        steps: u64,
        end: u64,
        beside: (usize, usize),
    ) -> bool {
        self.begin();
        let mut enabled = Enabled::default();
        let mut first = Vec::new();
        let mut followed = Vec::new();
        let mut it = Encoded::default();
        while !self.is_over() && self.steps < steps {
            let Some(Open {
                mut s,
                mut held,
                mut at,
            }) = self.open.pop()
            else {
                break;
            };
            self.steps += 1;
            if self.steps % LOOKS == 1 && self.out_of_bounds(beside) {
                return false;
            }
            let trail = &mut self.trail;
            let watching = &mut self.watching;
            let ordered = watching.settle(&mut s, &mut held, &mut enabled, |action| {
                at.parent = push(trail, at.parent, Step::Act(action));
                at
            });
            if ordered {
                at.parent = push(trail, at.parent, Step::Order);
            }
            encode(watching.rules.frame(), &s, &mut it);
            if held != 0 {
                it.key.extend(held.to_le_bytes());
            }
            if self.passed.insert(&it, 0, |_, _| 0).is_none() {
                continue;
            }
            if self.has_gone_far(at) {
                break;
            }
            let watching = &self.watching;
            watching.followed((&s, held), &enabled, &mut first, &mut followed);
            if order.late {
                let l = watching.rules.frame();
                followed.retain(|&(action, _)| {
                    !matches!(action, Action::Finish { executor, .. }
                        if !matches!(l.window(&s, executor).1, 0 | FOREVER))
                });
            }
            order.arrange(&mut followed, |it| watching.is_measured(it));
            let calm = enabled.is_calm();
            let jump = calm.then(|| self.jump(&s, order)).flatten();
            let jump = jump.filter(|&it| at.time + u64::from(it) <= end);
            if !order.patient {
                jump.into_iter().for_each(|jump| self.pass(&s, at, jump));
            }
            for &(action, held) in &followed {
                self.act(&s, held, at, action);
            }
            if order.patient {
                jump.into_iter().for_each(|jump| self.pass(&s, at, jump));
            }
        }
        true
    }

    fn begin(&mut self) {
        self.watching.begin_anew();
        self.passed.clear();
        self.trail.clear();
        self.open.clear();
        self.steps = 0;
        let at = Sight {
            parent: START,
            time: 0,
        };
        let s = self.watching.rules.initial();
        self.watching.check(None, &s, at);
        self.open.push(Open { s, held: 0, at });
    }

    /// Whether everything was seen, or enough.
    fn is_over(&self) -> bool {
        let Watching { seen, .. } = &self.watching;
        let answered = || self.watching.all_measured() && seen.goals.values().all(Option::is_some);
        seen.enough || answered() || self.longest().is_some()
    }

    /// Whether a run has gone on for so long that nothing new is to be expected.
    fn has_gone_far(&self, at: Sight<StepId>) -> bool {
        self.lasts.is_some_and(|it| at.time > FAR * u64::from(it))
    }

    /// The longest time seen, if that is longer than what is looked for.
    fn longest(&self) -> Option<Longest<StepId>> {
        let longest = self.watching.seen.longest.first().copied().flatten()?;
        self.lasts
            .is_some_and(|it| longest.value > it)
            .then_some(longest)
    }

    /// A run at whose end something lasts as long as was looked for, and how long.
    pub(super) fn lasted(&mut self) -> Option<(Run, Ticks)> {
        let Longest { value, at } = self.longest()?;
        Some((self.run_to(at, None), value))
    }

    /// Where a run at whose end something has lasted so long repeats itself meanwhile.
    pub(super) fn repetition(&self, run: &Run, value: Ticks) -> Option<(u64, u64)> {
        let Watching {
            rules,
            observers,
            gauges,
            ..
        } = &self.watching;
        let of = gauges.first().map(|it| it.of);
        let age = |s: &State| of.map_or((0, 0), |it| it.age(rules.frame(), s));
        run.repetition(rules, (observers, value), &age, self.cancel)
    }

    /// Whether nothing is left to be looked at, of everything there is.
    pub(super) fn is_exhausted(&self) -> bool {
        self.open.is_empty() && !self.is_over()
    }

    /// Whether there is nothing more to look for, or to look at.
    pub(super) fn is_done(&self) -> bool {
        self.open.is_empty() || self.is_over()
    }

    fn out_of_bounds(&self, (states, bytes): (usize, usize)) -> bool {
        let (states, bytes) = (states + self.states(), bytes + self.memory());
        Stop::reason(states, bytes, self.limits, self.cancel).is_some()
    }

    /// How long to let time pass.
    fn jump(&self, s: &State, order: Order) -> Option<Ticks> {
        let Watching {
            rules, reductions, ..
        } = &self.watching;
        if !order.late {
            return reductions.next_moment(rules, s);
        }
        let waiters = reductions.waiters(rules, s);
        rules.next_moment(s, &|executor| {
            let waits = waiters.as_ref();
            rules.frame().window(s, executor).1 != FOREVER
                || waits.is_some_and(|it| it.can_wait(rules.system(), executor))
        })
    }

    fn pass(&mut self, s: &State, at: Sight<StepId>, jump: Ticks) {
        let mut s = s.clone();
        let at = Sight {
            parent: push(&mut self.trail, at.parent, Step::Pass(jump)),
            time: at.time + u64::from(jump),
        };
        self.watching.rules.elapse(&mut s, jump);
        self.look_at_clocks(&mut s, at);
        self.open.push(Open { s, held: 0, at });
    }

    fn act(&mut self, s: &State, mut held: Held, at: Sight<StepId>, action: Action) {
        let mut s = s.clone();
        let at = Sight {
            parent: push(&mut self.trail, at.parent, Step::Act(action)),
            ..at
        };
        self.watching.step(&mut s, action, &mut held, at);
        self.open.push(Open { s, held, at });
    }

    fn look_at_clocks(&mut self, s: &mut State, at: Sight<StepId>) {
        self.watching.waiting_after_jump(s, at);
        for gauge in 0..self.watching.gauges.len() {
            self.watching.longest_after_jump(gauge, s, at);
        }
    }

    /// Runs to what was seen.
    pub(super) fn caught(&mut self) -> PerGoal<Option<Run>> {
        let Watching { goals, seen, .. } = &self.watching;
        let sights = goals.each(|id| seen.goals[id].map(|at| (at, goals.get(id))));
        let run = |it: Option<(Sight<StepId>, Goal<'a>)>| {
            it.map(|(at, goal)| match goal {
                Goal::Missed(task) => self.run_to(at, Some((task, R::missed))),
                Goal::Overdue(task) => self.run_to(at, Some((task, R::overdue))),
                Goal::Reached(_) => self.run_to(at, None),
            })
        };
        sights.map(run)
    }

    /// The run that ends with a step, and is about a task if something is shown of one: its steps are taken
    /// again, and called as they were before anything was put in order.
    fn run_to(&mut self, at: Sight<StepId>, about: Option<(usize, Shown<R>)>) -> Run {
        let mut steps = Vec::new();
        let mut last = at.parent;
        while let Some(&(before, step)) = self.trail.get(last as usize) {
            steps.push(step);
            last = before;
        }
        let mut s = self.watching.rules.initial();
        let mut names = self.watching.reductions.orbits().identity();
        let mut run = Run::default();
        for step in steps.into_iter().rev() {
            match step {
                Step::Act(action) => {
                    run.steps.push((run.end, names.action(action)));
                    let now = Sight {
                        time: run.end,
                        ..at
                    };
                    self.watching.step(&mut s, action, &mut 0, now);
                }
                Step::Pass(time) => {
                    run.end += u64::from(time);
                    let now = Sight {
                        time: run.end,
                        ..at
                    };
                    self.watching.rules.elapse(&mut s, time);
                    self.look_at_clocks(&mut s, now);
                }
                Step::Order => {
                    let Watching {
                        rules, reductions, ..
                    } = &self.watching;
                    if let Some(order) = reductions.order(rules, &mut s) {
                        names = names.after(&order.inverse());
                    }
                }
            }
        }
        let Some((task, shown)) = about else {
            return run;
        };
        let watching = &self.watching;
        let mut alike = watching.reductions.orbits().of_task(task).iter().copied();
        match alike.find(|&it| shown(&watching.rules, &s, it)) {
            Some(it) if names.task(it) != task => watching.exchanged(&run, names.task(it), task),
            _ => run,
        }
    }

    /// Services of which a request was refused.
    pub(super) fn refused(&self) -> Vec<usize> {
        (0..self.watching.rules.system().services.len())
            .filter(|&it| self.watching.has_refused(it))
            .collect()
    }

    /// The number of states that were looked at.
    pub(super) fn states(&self) -> usize {
        self.passed.len()
    }

    /// Bytes in use, roughly.
    pub(super) fn memory(&self) -> usize {
        let open = size_of::<Open>() + self.watching.rules.frame().state_bytes();
        self.passed.memory()
            + self.trail.capacity() * size_of::<(StepId, Step)>()
            + self.open.capacity() * open
    }
}

/// Only chases a system: what the states of one chase of this number show, of those a [`Watch`] can be
/// answered by.
pub fn chase(
    system: &TimedSystem,
    watch: &Watch,
    (number, steps): (u64, u64),
    limits: Limits,
    cancel: &Cancel,
) -> Findings {
    with_rules!(system, chase_by(watch, (number, steps), limits, cancel))
}

fn chase_by<R: Reduced>(
    rules: &R,
    watch: &Watch,
    (number, steps): (u64, u64),
    limits: Limits,
    cancel: &Cancel,
) -> Findings {
    let watching = Watching::new(rules, watch, &[], limits.without);
    let mut chase = Chase::new(watching, limits, cancel);
    let room = chase.run(Order::numbered(number), steps, u64::MAX, (0, 0));
    let goals = Goals::of(watch);
    let found = |run: Option<Run>| run.map(|run| Found { run });
    let mut caught = chase.caught().into_values().map(found);
    let [missed, overdue, reached] = goals.split(goals.each(|_| caught.next().flatten()));
    Findings {
        missed,
        overdue,
        reached,
        refused: chase.refused(),
        states: chase.states(),
        steps: chase.steps,
        bytes: chase.memory(),
        stopped: (!room || !chase.is_done()).then_some(Stop::States),
        ..Findings::default()
    }
}

/// Whether a state shows something of a task.
type Shown<R> = fn(&R, &State, usize) -> bool;

/// Adds a step after another.
fn push(trail: &mut Vec<(StepId, Step)>, before: StepId, step: Step) -> StepId {
    trail.push((before, step));
    trail.len() as u32 - 1
}
