//! Predicates on the discrete state.

use crate::system::{ClientId, CodelId, ComponentId, MachineId, ServiceId, TaskId};

/// A Boolean combination of atoms.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Predicate {
    /// Holds while the atom holds.
    Atom(Atom),
    /// Holds at the moment at which the atom stops holding.
    Leave(Atom),
    /// Negation.
    Not(Box<Predicate>),
    /// Conjunction.
    And(Box<Predicate>, Box<Predicate>),
    /// Disjunction.
    Or(Box<Predicate>, Box<Predicate>),
}

/// A fact about one state of the system. Numbers index into the tables of
/// [`crate::system::TimedSystem`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Atom {
    Task(TaskId, TaskState),
    /// One of the automata of a machine is in a codel state.
    State {
        machine: MachineId,
        state: usize,
        /// Waiting for locks, executing, or either.
        phase: StatePhase,
    },
    /// Some slot of an activity has a status. For `Void`, all slots have it.
    Slot(ServiceId, SlotStatus),
    /// The control task is handling a request for a service (functions, attributes, validation).
    Handling {
        service: ServiceId,
        /// One of its codels; `None`: any of them.
        codel: Option<CodelId>,
        /// Waiting for locks, executing, or either.
        phase: StatePhase,
    },
    /// The control task is handling some request, or its component is starting.
    ControlBusy(ComponentId),
    /// A client is at one of these steps ([`crate::system::Client::done`] after the last step).
    Client(ClientId, Vec<usize>),
    /// The timer of a task has just wrapped: the moment of its tick.
    Tick(TaskId),
    /// A comparison of data holds, or does not if `negated`: its number in the list of what is watched. Both
    /// are false before the port is written.
    Data {
        fact: usize,
        negated: bool,
    },
    /// A [monitor](super::Monitor) is violated: its number in the list of what is watched.
    Violated(usize),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TaskState {
    /// Between cycles.
    Idle,
    /// Released, without a core.
    Waiting,
    /// In its cycle.
    Running,
    /// Waiting or running.
    Active,
}

/// The phase of a codel state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StatePhase {
    /// Waiting for its locks.
    Lock,
    /// Executing.
    Exec,
    /// Either.
    Any,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SlotStatus {
    /// All slots are free.
    Void,
    /// Accepted, and waiting to begin.
    Wait,
    /// Running.
    Run,
    /// Interrupted.
    Stop,
    /// Not free.
    Active,
}

impl Predicate {
    /// Calls `found` with every atom.
    pub fn atoms(&self, found: &mut impl FnMut(&Atom)) {
        match self {
            Predicate::Atom(atom) | Predicate::Leave(atom) => found(atom),
            Predicate::Not(predicate) => predicate.atoms(found),
            Predicate::And(one, other) | Predicate::Or(one, other) => {
                one.atoms(found);
                other.atoms(found);
            }
        }
    }

    /// Returns true if the predicate holds only because the `absent` atoms never hold: then it says nothing
    /// about a run. The exception is the claim that one atom, or each of several atoms, never holds.
    pub(crate) fn is_vacuous(&self, absent: &dyn Fn(&Atom) -> bool) -> bool {
        match self {
            Predicate::And(one, other) => one.is_vacuous(absent) && other.is_vacuous(absent),
            Predicate::Not(predicate) => match &**predicate {
                Predicate::Atom(_) | Predicate::Leave(_) => false,
                Predicate::Or(one, other) => {
                    let not = |predicate: &Predicate| Predicate::Not(Box::new(predicate.clone()));
                    not(one).is_vacuous(absent) && not(other).is_vacuous(absent)
                }
                predicate => predicate.is_settled(absent, false),
            },
            predicate => predicate.is_settled(absent, true),
        }
    }

    /// Returns true if the predicate never holds because of the `absent` atoms.
    pub(crate) fn is_never(&self, absent: &dyn Fn(&Atom) -> bool) -> bool {
        self.is_settled(absent, false)
    }

    /// Returns true if the predicate always has this value because of the `absent` atoms.
    fn is_settled(&self, absent: &dyn Fn(&Atom) -> bool, value: bool) -> bool {
        match self {
            Predicate::Atom(atom) | Predicate::Leave(atom) => !value && absent(atom),
            Predicate::Not(predicate) => predicate.is_settled(absent, !value),
            Predicate::And(one, other) | Predicate::Or(one, other) => {
                let [one, other] =
                    [one, other].map(|predicate| predicate.is_settled(absent, value));
                // A conjunction is true if all operands are, a disjunction if one is.
                if matches!(self, Predicate::And(..)) == value {
                    one && other
                } else {
                    one || other
                }
            }
        }
    }

    /// Returns true if the predicate can hold because a moment is over: a tick, or with `leaves` the end of
    /// an atom. Then it may hold in states that no action enters, and predicates are evaluated after actions.
    /// `negated`: the same of its negation.
    pub fn needs_no_moment(&self, negated: bool, leaves: bool) -> bool {
        match self {
            Predicate::Atom(Atom::Tick(_)) => negated,
            Predicate::Leave(_) => negated && leaves,
            Predicate::Atom(_) => false,
            Predicate::Not(predicate) => predicate.needs_no_moment(!negated, leaves),
            Predicate::And(one, other) | Predicate::Or(one, other) => {
                one.needs_no_moment(negated, leaves) || other.needs_no_moment(negated, leaves)
            }
        }
    }

    /// Returns the negation. Before a port is written, a comparison of its data does not hold, and neither
    /// does its negation.
    pub(crate) fn negation(self) -> Predicate {
        let mut has_data = false;
        self.atoms(&mut |atom| has_data |= matches!(atom, Atom::Data { .. }));
        if !has_data {
            return Predicate::Not(Box::new(self));
        }
        let negation = |predicate: Box<Predicate>| Box::new(predicate.negation());
        match self {
            Predicate::Atom(Atom::Data { fact, negated }) => {
                Predicate::Atom(Atom::Data { fact, negated: !negated })
            }
            Predicate::Not(predicate) => *predicate,
            Predicate::And(one, other) => Predicate::Or(negation(one), negation(other)),
            Predicate::Or(one, other) => Predicate::And(negation(one), negation(other)),
            predicate => Predicate::Not(Box::new(predicate)),
        }
    }

    /// Returns the value in a state that was entered from another one. `atom` evaluates an atom in the
    /// present state (`true`) or in the previous one (`false`).
    pub fn eval(&self, atom: &impl Fn(&Atom, bool) -> bool) -> bool {
        match self {
            Predicate::Atom(proposition) => atom(proposition, true),
            Predicate::Leave(proposition) => atom(proposition, false) && !atom(proposition, true),
            Predicate::Not(predicate) => !predicate.eval(atom),
            Predicate::And(one, other) => one.eval(atom) && other.eval(atom),
            Predicate::Or(one, other) => one.eval(atom) || other.eval(atom),
        }
    }

    /// Returns the value in a state that is not being entered: no atom is being left.
    pub fn eval_still(&self, atom: &impl Fn(&Atom) -> bool) -> bool {
        self.eval(&|proposition, _| atom(proposition))
    }
}
