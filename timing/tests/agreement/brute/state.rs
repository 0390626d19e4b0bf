//! States, the initial state, and the activities of executors.

use std::collections::BTreeSet;

use dotgen_timing::system::{AutomatonId, ClientAction, ClientId, CodelId, ComponentId, ServiceId};
use typed_index_collections::TiVec;

use super::Brute;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Status {
    Idle,
    Waiting,
    Running,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Mode {
    // Permanent activities.
    Unstarted,
    FirstCodel,
    FirstRun,
    Normal,
    Ended,
    // Slots.
    Void,
    Wait,
    Run,
    Stop,
    Ether,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Doing {
    Nothing,
    Locking,
    Executing(u32),
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Task {
    pub(super) status: Status,
    pub(super) tick: bool,
    pub(super) timer: Option<u32>,
    /// Time since the release.
    pub(super) age: u32,
    /// Position of the automaton that has its turn.
    pub(super) turn: usize,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Automaton {
    pub(super) mode: Mode,
    /// The `stop` state has been entered.
    pub(super) stopping: bool,
    pub(super) at: usize,
    pub(super) doing: Doing,
    /// A separate thread executes the codel.
    pub(super) separate: bool,
    pub(super) visits: Vec<u16>,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Step {
    Starting(usize),
    Ready,
    Validate(ServiceId, ClientId),
    Simple(ServiceId, ClientId, usize),
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Control {
    pub(super) step: Step,
    pub(super) doing: Doing,
    pub(super) signal: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Tracked {
    Over,
    Handled,
    Slot(AutomatonId),
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Client {
    /// `None`: before the first step.
    pub(super) at: Option<usize>,
    pub(super) clock: u32,
    pub(super) outstanding: bool,
    pub(super) tracked: Vec<Tracked>,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct State {
    pub(super) tasks: Vec<Task>,
    pub(super) automata: TiVec<AutomatonId, Automaton>,
    pub(super) controls: TiVec<ComponentId, Control>,
    pub(super) clients: TiVec<ClientId, Client>,
    pub(super) queue: Vec<usize>,
    pub(super) lock_queue: Vec<usize>,
    /// Open obligations of each observer: number of responses so far, and age.
    pub(super) obligations: Vec<BTreeSet<(usize, u32)>>,
}

impl Brute<'_> {
    pub(super) fn initial(&self) -> State {
        let sys = self.system;
        let mut s = State {
            tasks: sys
                .tasks
                .iter()
                .map(|_| Task { status: Status::Idle, tick: false, timer: None, age: 0, turn: 0 })
                .collect(),
            automata: sys
                .automata
                .iter()
                .map(|automaton| Automaton {
                    mode: if automaton.service.is_some() { Mode::Void } else { Mode::Unstarted },
                    stopping: false,
                    at: if automaton.service.is_some() {
                        sys.machines[automaton.machine].start
                    } else {
                        0
                    },
                    doing: Doing::Nothing,
                    separate: false,
                    visits: vec![0; sys.machines[automaton.machine].states.len()],
                })
                .collect(),
            controls: sys
                .components
                .iter()
                .map(|_| Control { step: Step::Starting(0), doing: Doing::Nothing, signal: false })
                .collect(),
            clients: sys
                .clients
                .iter()
                .map(|client| Client {
                    at: None,
                    clock: 0,
                    outstanding: false,
                    tracked: vec![Tracked::Over; client.trackers],
                })
                .collect(),
            queue: Vec::new(),
            lock_queue: Vec::new(),
            obligations: vec![BTreeSet::new(); self.within.len()],
        };
        for c in sys.components.keys() {
            self.start_from(&mut s, c, 0);
        }
        self.watch(None, &mut s);
        s
    }

    pub(super) fn executors(&self, s: &State) -> usize {
        s.automata.len() + s.controls.len() + s.clients.len()
    }

    pub(super) fn doing(&self, s: &State, e: usize) -> Doing {
        let (na, nc) = (s.automata.len(), s.controls.len());
        if e < na {
            s.automata[AutomatonId::from(e)].doing
        } else if e < na + nc {
            s.controls[ComponentId::from(e - na)].doing
        } else {
            let k = ClientId::from(e - na - nc);
            match s.clients[k].at.and_then(|at| self.system.clients[k].steps.get(at)) {
                Some(step) if matches!(step.action, ClientAction::Delay(..)) => {
                    Doing::Executing(s.clients[k].clock)
                }
                _ => Doing::Nothing,
            }
        }
    }

    pub(super) fn codel(&self, s: &State, e: usize) -> CodelId {
        let na = s.automata.len();
        if e < na {
            let a = AutomatonId::from(e);
            self.system.machine_of(a).states[s.automata[a].at].codel
        } else {
            match s.controls[ComponentId::from(e - na)].step {
                Step::Validate(service, _) => self.system.services[service].validate.unwrap(),
                Step::Simple(service, _, i) => self.system.services[service].simple[i],
                _ => unreachable!("no codel"),
            }
        }
    }

    pub(super) fn bounds(&self, s: &State, e: usize) -> (u32, u32) {
        let n = s.automata.len() + s.controls.len();
        if e < n {
            let codel = &self.system.codels[self.codel(s, e)];
            (codel.lower, codel.upper)
        } else {
            let k = ClientId::from(e - n);
            let at = s.clients[k].at.unwrap();
            match self.system.clients[k].steps[at].action {
                ClientAction::Delay(a, b) => (a, b),
                _ => unreachable!("not a delay"),
            }
        }
    }
}
