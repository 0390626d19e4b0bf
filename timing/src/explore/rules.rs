//! The rules: one step of the timed system, and nothing else.
//!
//! A set of rules is one type that implements [`Rules`]. Strategies (`search`), goals and the store of states
//! are written against the trait, and are compiled once for each set. So far there is one, [`published`]:
//! sections 3 to 9 of the timed semantics.
//!
//! # The contract
//!
//! What is on the other side of this trait relies on the following; a set of rules must keep all of it.
//!
//! **States.** A state is two arrays of numbers ([`State`]). Rules choose the places with
//! [`Places`](super::state::Places), and give a [`Frame`]. Equal numbers are equal states: what has no
//! meaning any more is set to 0 (dead variables), as states are compared as they are.
//!
//! **Executors.** Only executors take time. While one executes, its phase has the bit
//! [`phase::EXECUTING`](super::state::phase::EXECUTING), and its window tells when it may end: it may while
//! the lower bound is 0, it must when the upper one is. Otherwise its window is `(0, 0)`. Windows are set
//! when something begins to execute, to its least and greatest duration. Rules look at a window for nothing
//! but "may it end" and "must it", so that a state with wider windows can do whatever one with narrower
//! windows can (inclusion), and states with adjoining windows can be joined (union). What ends an execution
//! is [`Action::Finish`] of this executor, always and only.
//!
//! **Actions.** [`Rules::enabled`] lists the actions of the best rank present. Ranks are the rules' own;
//! those before the last are *committed*: parts of the step that made them possible, followed at once, which
//! nothing may come between. Within a rank any order is possible and followed. [`Enabled::urgent`] is set if
//! at least one action of the list must happen before time passes, whatever the windows; [`Enabled::forced`]
//! if some window is at its end. Time passes only in *calm* states, which are neither. [`Rules::apply`]
//! performs an action of the list; a free choice (a yield, whether a request is accepted) is several actions.
//! Both depend on the state alone. Not even they look at clocks.
//!
//! **Time.** [`Rules::next_moment`] tells how long nothing can become possible that was not: until then no
//! state needs to be looked at. [`Rules::elapse`] lets so much time pass or less, in one jump or in several
//! with the same effect. It also advances the clocks of jobs ([`Frame::elapse`] does so for windows and for
//! observers). Deadlines and timers that are read by `enabled` are times of the key.
//!
//! **Jobs.** [`Rules::job`] tells whether a task has a job whose response time is being measured, and if so,
//! whether it waits for a core. Its clock ([`Frame::response`]) is advanced while it has one, and set to 0
//! when it ends. The action by which a waiting job gets its core is [`Action::Grant`].
//!
//! **Without periodic tasks** times of the key are always 0 (zones do not look at them).
//!
//! # Adding a set of rules
//!
//! 1. A folder beside `published`, with a type that implements [`Rules`]. Actions that it needs are variants
//!    of [`Action`], with their lines in [`Action::renamed`](super::reductions::Renaming::action) and
//!    [`Rules::task_of`].
//! 2. Its reductions: [`Reduced`](super::reductions::Reduced). To begin with,
//!    [`NoReductions`](super::reductions::NoReductions): everything is followed, nothing is left out, and
//!    each of the known reductions is reported as off, because nobody has shown that it is sound for these
//!    rules.
//! 3. A line in `with_rules!`, which chooses the rules of a system.

mod moment;
pub(crate) mod published;
pub(crate) mod servers;
mod work;

pub use self::moment::{Moment, MomentKind};
pub use self::work::Work;
use super::state::{Clocks, Frame, State, TaskStatus};
use crate::property::Atom;
use crate::system::{Ticks, TimedSystem};

/// Something that happens without taking time. Executors are numbered: automata, then the control
/// tasks of components, then clients.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Action {
    /// What a client waited for has happened; it goes on.
    Proceed {
        /// The client.
        client: usize,
        /// Its next step.
        next: usize,
    },
    /// A task is released: takes its tick and asks for a core.
    Release {
        /// The task.
        task: usize,
    },
    /// A waiting task gets a core.
    Grant {
        /// The task.
        task: usize,
    },
    /// A timer wraps.
    Tick {
        /// The task.
        task: usize,
    },
    /// A codel takes its locks.
    Acquire {
        /// What executes it.
        executor: usize,
    },
    /// A codel or a delay ends.
    Finish {
        /// What executed it.
        executor: usize,
        /// For automata the index of the yield; for control tasks 0 is "accepted" (or done), 1
        /// "refused"; for clients the step after the delay.
        outcome: usize,
    },
    /// A task begins a pass (servers).
    Begin {
        /// The task.
        task: usize,
    },
    /// An executor takes a ticket for its next codel (servers).
    Ticket {
        /// The executor.
        executor: usize,
    },
    /// A task wakes the other tasks of its component (servers).
    Wake {
        /// The task.
        task: usize,
    },
    /// A thread takes the core of another (servers, policy `fair`).
    Preempt {
        /// Who had it.
        executor: usize,
        /// Who takes it.
        by: usize,
    },
    /// Of threads that have become ready at the same moment, one counts as the next (servers, policy
    /// `priority`).
    Ready {
        /// The thread.
        executor: usize,
    },
    /// The control task has executed its codels: it replies, and looks at all activities (servers).
    Reply {
        /// Its component.
        component: usize,
    },
    /// A component that was killed gets on with its end (servers).
    Shut {
        /// The component.
        component: usize,
    },
    /// The control task handles the end of activities.
    Signal {
        /// Its component.
        component: usize,
    },
    /// What was just written, or read, is marked, or not; no step of the system (see `explore::token`).
    Mark {
        /// Who has read it, where it is new whenever it is read.
        executor: Option<usize>,
        /// Whether it is marked.
        taken: bool,
    },
    /// The control task takes a client's request.
    Request {
        /// The client.
        client: usize,
        /// The client's next step.
        next: usize,
    },
}

/// The actions of a state.
#[derive(Debug, Default)]
pub(crate) struct Enabled {
    /// All of the best rank.
    pub(crate) actions: Vec<Action>,
    /// At least one of them must happen before time passes, whatever the windows.
    pub(crate) urgent: bool,
    /// They are of a rank before the last: part of the step that made them possible.
    pub(crate) committed: bool,
    /// Some executing codel has come to the end of its window.
    pub(crate) forced: bool,
}

impl Enabled {
    /// Whether time may pass.
    pub(crate) fn is_calm(&self) -> bool {
        !self.urgent && !self.forced
    }
}

/// A set of rules, applied to one system. What it has to keep to is said in the [module](self).
pub(crate) trait Rules: Sized {
    /// The same rules for the same system, with clocks for what is measured.
    fn with_clocks(&self, clocks: &Clocks) -> Self;

    /// The system.
    fn system(&self) -> &TimedSystem;

    /// Where the common parts of a state are.
    fn frame(&self) -> &Frame;

    // ---- Steps -----------------------------------------------------------------------------

    /// The state at time 0, before anything has happened.
    fn initial(&self) -> State;

    /// Lists the actions of a state.
    fn enabled(&self, s: &State, out: &mut Enabled);

    /// Performs an action that is enabled.
    fn apply(&self, s: &mut State, action: Action);

    /// How long nothing needs to be looked at after a calm state: until the next moment at which something
    /// may happen, or, for executors whose end `can_wait`, has to. `None`: for ever.
    fn next_moment(&self, s: &State, can_wait: &dyn Fn(usize) -> bool) -> Option<Ticks>;

    /// Lets time pass, at most until the next moment.
    fn elapse(&self, s: &mut State, time: Ticks);

    /// Whether time brings an executor nearer to the end of what it executes.
    fn gets_on(&self, _s: &State, _executor: usize) -> bool {
        true
    }

    // ---- What is to be seen ----------------------------------------------------------------

    /// What the job of a task does.
    fn job(&self, s: &State, task: usize) -> TaskStatus;

    /// The task whose start-up a task waits for before its first job: one before it in its component, or
    /// itself. `None`: the start-up is over.
    fn awaits_start_up(&self, s: &State, task: usize) -> Option<usize>;

    /// Whether a tick of a task has come before its job has ended.
    fn missed(&self, s: &State, task: usize) -> bool;

    /// Whether a job waits for a core for as long as the period of its task. Its response time is measured.
    fn overdue(&self, s: &State, task: usize) -> bool {
        let (period, clock) = (
            self.system().tasks[task].period,
            self.frame().response[task],
        );
        let (Some(period), Some(clock)) = (period, clock) else {
            return false;
        };
        self.job(s, task) == TaskStatus::Waiting && s.t[clock] >= period
    }

    /// Whether a task may wait for a core after an action although it did not before.
    fn may_begin_to_wait(&self, action: Action, task: usize) -> bool {
        action == Action::Release { task }
    }

    /// The value of an atom of a predicate.
    fn atom(&self, s: &State, atom: &Atom) -> bool;

    /// Whether a request for a service was ever refused by [`Rules::apply`] for want of a slot.
    fn has_refused(&self, service: usize) -> bool;

    /// Whether two waiting instances of a service were ever seen to interrupt each other by [`Rules::apply`].
    fn has_ended_restarts(&self, _service: usize) -> bool {
        false
    }

    /// The task an action is one of; `None` for those of control tasks and clients.
    fn task_of(&self, action: Action) -> Option<usize>;

    /// Least and greatest time of what an executor executes.
    fn duration(&self, s: &State, executor: usize) -> (Ticks, Ticks);

    /// What an executor takes a ticket or waits for, or executes; `None` if that is nothing.
    fn work(&self, s: &State, executor: usize) -> Option<Work>;

    /// The step a client is at; [`Client::done`](crate::system::Client::done) after the last, one more before
    /// the first.
    fn position(&self, s: &State, client: usize) -> usize;

    /// How many places for activities there are, those of permanent activities included. They are numbered as
    /// in [`Work::State`].
    fn places(&self) -> usize;

    /// The automaton of the activity that has a place: accepted, running, or ended and not yet reported.
    fn activity(&self, s: &State, place: usize) -> Option<usize>;

    /// Interrupts the activity that has a place, as a service that interrupts it would.
    fn interrupt_activity(&self, s: &mut State, place: usize);

    /// The service whose request a control task is handling, and whether it is already refused.
    fn handling(&self, s: &State, component: usize) -> Option<(usize, bool)>;

    /// The place of the activity whose request a control task is handling; `None` if it has none, or is given
    /// one later.
    fn requested_place(&self, _s: &State, _component: usize) -> Option<usize> {
        None
    }

    /// An action in words: what it did to the first state, to become the second. `None`: the initial state.
    fn tell(
        &self,
        change: (&State, &State),
        action: Option<Action>,
        time: u64,
        out: &mut Vec<Moment>,
    );
}

/// Calls a function that is generic in the rules: its first argument are those of a system, without clocks.
macro_rules! with_rules {
    ($system:expr, $function:ident ( $($argument:expr),* $(,)? )) => {{
        let system: &$crate::system::TimedSystem = $system;
        if system.platform.semantics.is_published() {
            $function(
                &$crate::explore::rules::published::Published::new(system),
                $($argument),*
            )
        } else {
            $function(
                &$crate::explore::rules::servers::Servers::new(system),
                $($argument),*
            )
        }
    }};
}

pub(crate) use with_rules;
