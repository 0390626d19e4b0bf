//! The rules: a single step of the timed system.
//!
//! There is one set of rules, [`Rules`], for every reading of the points of the semantics: sections
//! 3 to 9, 21 and 22 of the timed semantics. For a chain they follow data as well (`rules::data`).
//!
//! # The contract
//!
//! The users of the rules rely on the following; the rules keep all of it.
//!
//! **States.** A state is two arrays of numbers ([`State`]). Rules choose the places with
//! [`Places`](super::state::Places), and give a [`Frame`]. Equal numbers are equal states: numbers without a
//! meaning in the present state are set to 0 (dead variables), because states are compared by their numbers.
//!
//! **Executors.** Only executors take time. While one executes, its phase has the bit
//! [`phase::EXECUTING`](super::state::phase::EXECUTING), and its window gives its end: the executor may end
//! while the lower bound is 0, and must end when the upper bound is 0. Otherwise its window is `(0, 0)`. A
//! window is set when an execution begins, to its least and greatest duration. Rules use a window only to
//! decide "may it end" and "must it", so that a state with wider windows can do whatever one with narrower
//! windows can (inclusion), and states with adjoining windows can be joined (union). An execution ends with
//! [`Action::Finish`] of its executor, always and only.
//!
//! **Actions.** [`Rules::enabled`] lists the actions of the best rank present.  All ranks but the last
//! are *committed*: these actions are parts of the step that made them possible, and are followed at
//! once, with no other action in between. Within a rank any order is possible and followed.
//! [`Enabled::urgent`] is set if at least one action of the list must happen before time passes, whatever
//! the windows; [`Enabled::forced`] is set if some window is at its end. Time passes only in *calm*
//! states, which are neither. [`Rules::apply`] performs an action of the list; a free choice (a yield,
//! the acceptance of a request) is several actions. Both methods depend on the state alone, and not on
//! clocks.
//!
//! **Time.** [`Rules::next_moment`] returns the time for which no new action can become possible: until then
//! no state needs to be examined. [`Rules::elapse`] lets that much time pass or less, in one jump or in
//! several with the same effect. It also advances the clocks of jobs ([`Frame::elapse`] does so for windows
//! and for observers). Deadlines and timers that `enabled` reads are times of the key.
//!
//! **Jobs.** [`Rules::job`] returns the status of a task: whether it has a job whose response time is being
//! measured, and whether the job waits for a core. The clock of the job ([`Frame::response`]) advances while
//! there is a job, and is set to 0 at the end of the job. A waiting job gets its core by the action
//! [`Action::Grant`].
//!
//! **Without periodic tasks** times of the key are always 0.
//!
//! # Adding a reading of a point
//!
//! 1. A value of the point in `points`, and a keyword in [`crate::scn::semantics`].
//! 2. The code where the readings differ names the point. Actions that it needs are variants of [`Action`],
//!    with their lines in [`Rules::task_of`].
//! 3. Each reduction: sound for the reading, with its proof, or off with the reason
//!    ([`Reduction::applies`](super::reductions::Reduction::applies)).

mod atoms;
mod control_task;
mod cores;
mod data;
mod describe;
mod idle;
mod jobs;
pub(crate) mod layout;
mod moment;
mod passes;
mod perform;
pub(crate) mod points;
mod possible;
mod reach;
mod shutdown;
pub(crate) mod status;
mod system_rules;
mod time;
pub(super) mod token;
mod work;

pub use self::moment::{Moment, MomentKind};
pub(crate) use self::system_rules::Rules;
pub use self::work::{IdleTurn, Work};
use crate::system::{ClientId, ComponentId};

/// An action: an event that takes no time. Executors are numbered: automata, then the control tasks of
/// components, then clients. (With passes there are tasks instead of automata.)
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Action {
    /// A client proceeds, because the event that it waited for has happened.
    Proceed {
        client: ClientId,
        /// Next step.
        next: usize,
    },
    /// A task is released: it takes its tick and asks for a core.
    Release { task: usize },
    /// A waiting task gets a core.
    Grant { task: usize },
    /// A timer wraps.
    Tick { task: usize },
    /// A codel takes its locks.
    Acquire { executor: usize },
    /// A codel or a delay ends.
    Finish {
        executor: usize,
        /// For automata the index of the yield; for control tasks 0 for "accepted" (or done) and 1 for
        /// "refused"; for clients the step after the delay.
        outcome: usize,
    },
    /// A task begins a pass (passes).
    Begin { task: usize },
    /// An executor takes a ticket for its next codel (passes).
    Ticket { executor: usize },
    /// A task wakes the other tasks of its component (passes).
    Wake { task: usize },
    /// A thread takes the core of another (policy `fair`).
    Preempt {
        /// Executor that has the core.
        executor: usize,
        /// Executor that takes the core.
        by: usize,
    },
    /// A thread counts as the next one of several that have become ready at the same moment (policy
    /// `priority`).
    Ready {
        /// The thread.
        executor: usize,
    },
    /// The control task has executed its codels: it replies, and handles the end of activities (passes).
    Reply { component: ComponentId },
    /// A killed component proceeds with its shutdown (passes).
    Shut { component: ComponentId },
    /// The control task handles the end of activities.
    Signal { component: ComponentId },
    /// The last write, or read, is marked or not; not a step of the system (see `rules::data`).
    Mark {
        /// Executor that has read the datum, if the datum is new at every read.
        executor: Option<usize>,
        /// The datum is marked.
        taken: bool,
    },
    /// The control task takes a client's request.
    Request {
        client: ClientId,
        /// Next step of the client.
        next: usize,
    },
}

/// The actions of a state.
#[derive(Debug, Default)]
pub(crate) struct Enabled {
    /// All actions of the best rank.
    pub(crate) actions: Vec<Action>,
    /// At least one action must happen before time passes, whatever the windows.
    pub(crate) urgent: bool,
    /// The actions are of a rank before the last: parts of the step that made them possible.
    pub(crate) committed: bool,
    /// Some executing codel has reached the end of its window.
    pub(crate) forced: bool,
}

impl Enabled {
    /// Removes the requests of clients, which may then wait.
    pub(crate) fn without_requests(&mut self) {
        let before = self.actions.len();
        self.actions.retain(|action| !matches!(action, Action::Request { .. }));
        if self.actions.len() < before {
            let takes_time =
                |action: &Action| matches!(action, Action::Finish { .. } | Action::Preempt { .. });
            self.urgent = !self.actions.iter().all(takes_time);
        }
    }

    /// Returns true if time may pass.
    pub(crate) fn is_calm(&self) -> bool {
        !self.urgent && !self.forced
    }
}
