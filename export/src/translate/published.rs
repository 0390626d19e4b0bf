//! The integers, clocks and channels of the published models, and the conditions and updates made of them.

use dotgen_timing::property::SlotStatus;
use dotgen_timing::system::{AutomatonId, CodelId, Policy, ServiceId, TaskId};

use crate::model::{Clock, Edge, Guard, Network, Term, Update, Variable, all, any, var};

use super::layout::{Layout, Part, TaskPart, executed, number, position, step, wanted};

/// Values of the mode of a permanent activity.
pub(super) mod permanent {
    pub(crate) const FIRST_CODEL: usize = 1;
    /// In its first turn, past the first codel.
    pub(crate) const FIRST_TURN: usize = 2;
    pub(crate) const RUNS: usize = 3;
    pub(crate) const ENDED: usize = 4;
}

/// Values of the mode of an activity.
pub(super) mod mode {
    pub(crate) const FREE: usize = 0;
    pub(crate) const ACCEPTED: usize = 1;
    pub(crate) const RUNS: usize = 2;
    pub(crate) const STOPS: usize = 3;
    pub(crate) const ENDED: usize = 4;
}

/// Number of components that have begun to start.
pub(super) const BOOTED: &str = "booted";

/// Declares the integers, clocks and channels of all components.
pub(super) fn declare(layout: &Layout, network: &mut Network) {
    let system = layout.system;
    let codels = system.codels.len();
    let Network { variables, clocks, channels, .. } = network;
    let mut declare = |name: String, size: Option<usize>, most: usize, comment: &str| {
        let comment = comment.to_owned();
        variables.push(Variable { name, size, most: most as i64, comment });
    };
    let mut clock = |name: String, comment: String| clocks.push(Clock { name, comment });
    let mut channel = |name: String, comment: &str| channels.push((name, comment.to_owned()));
    let what = "number of components whose start has begun";
    declare(BOOTED.into(), None, layout.parts.len(), what);
    channel("begin".into(), "a task begins a cycle");
    let mut executors: Vec<&str> = Vec::new();
    for part in &layout.parts {
        let name = &part.name;
        let most = part.tasks.len();
        declare(format!("starting_{name}"), None, most, "task that is being started, from 0");
        let what = "step of the control task: 0 not started, 1 ready, 2 handles a request";
        declare(format!("control_{name}"), None, step::CODELS, what);
        channel(format!("started_{name}"), "the first codel of a task has ended");
        declare(format!("ended_{name}"), None, 1, "1: an activity has ended, not handled yet");
        if part.control {
            let clients = system.clients.len();
            declare(format!("sender_{name}"), None, clients, "client of the request, from 1");
        }
        if part.has_control_codels() {
            executors.push(name);
        }
        for task in &part.tasks {
            let name = &task.name;
            let what =
                "position: 0 not started, 1 between cycles, 2 waits for a core, 3 in a cycle";
            declare(format!("position_{name}"), None, position::CYCLE, what);
            declare(
                format!("due_{name}"),
                None,
                1,
                "1: a tick has come since the last cycle began",
            );
            let automata = layout.automata(task.id);
            declare(format!("turn_{name}"), None, automata.len(), "next activity of the cycle");
            if layout.inserts(task) {
                let what = "place in the queue for cores that is compared";
                declare(format!("at_{name}"), None, system.tasks.len(), what);
            }
            channel(format!("over_{name}"), "a turn is over");
            if task.period.is_some() {
                channel(format!("start_{name}"), "the timer starts");
            }
            for automaton in automata {
                let name = layout.automaton_name(automaton);
                let states = system.machine_of(automaton).states.len();
                let what = match system.automata[automaton].service {
                    None => {
                        "0 not started, 1 first codel, 2 first turn, 3 runs with its task, 4 ended"
                    }
                    Some(_) => "0 none, 1 accepted, 2 runs, 3 stops, 4 has ended",
                };
                declare(format!("mode_{name}"), None, mode::ENDED, what);
                declare(format!("state_{name}"), None, states, "codel state of its next turn");
                if system.automata[automaton].service.is_some() {
                    let what = "1: interrupted, not noticed yet";
                    declare(format!("interrupted_{name}"), None, 1, what);
                }
                executors.push(name);
                channel(format!("turn_{name}"), "its turn begins");
            }
        }
    }
    for name in executors {
        let what = "codel that it waits for or executes, from 1; 0: none";
        declare(format!("wants_{name}"), None, codels, what);
        declare(format!("codel_{name}"), None, codels, "codel that it executes; 0: none");
        clock(format!("x_{name}"), format!("time of the codel that {name} executes"));
    }
    for part in &layout.parts {
        for task in &part.tasks {
            if task.period.is_some() {
                clock(task.timer(), format!("time since the last tick of {}", task.name));
            }
            if layout.by_deadline() {
                clock(waits_clock(task), format!("time since the release of {}", task.name));
            }
        }
    }
}

/// Returns the clock of the wait for a core under EDF.
pub(super) fn waits_clock(task: &TaskPart) -> String {
    format!("w_{}", task.name)
}

impl Layout<'_> {
    /// Returns the activities of a task that can run, in the order of their turns.
    pub(super) fn automata(&self, task: TaskId) -> Vec<AutomatonId> {
        let task = &self.system.tasks[task];
        let requested = self.system.requested();
        let service = |automaton: &AutomatonId| self.system.automata[*automaton].service;
        let can_run = |automaton: &AutomatonId| service(automaton).is_none_or(|of| requested[of]);
        task.permanent.iter().chain(&task.slots).copied().filter(can_run).collect()
    }

    /// Returns the places of the activities of a service.
    pub(super) fn places(&self, service: ServiceId) -> &[AutomatonId] {
        let is_requested = self.system.requested()[service];
        if is_requested { &self.system.services[service].slots } else { &[] }
    }

    pub(super) fn by_deadline(&self) -> bool {
        self.cores().is_some() && self.system.platform.policy == Policy::Edf
    }

    /// Returns true if a task gets its place in the queue for cores by its deadline.
    pub(super) fn inserts(&self, task: &TaskPart) -> bool {
        task.needs_core && self.by_deadline()
    }

    pub(super) fn mode(&self, automaton: AutomatonId) -> Term {
        var(&format!("mode_{}", self.automaton_name(automaton)))
    }

    pub(super) fn state(&self, automaton: AutomatonId) -> Term {
        var(&format!("state_{}", self.automaton_name(automaton)))
    }

    pub(super) fn interrupted(&self, automaton: AutomatonId) -> Term {
        var(&format!("interrupted_{}", self.automaton_name(automaton)))
    }

    pub(super) fn turn(&self, automaton: AutomatonId) -> String {
        format!("turn_{}", self.automaton_name(automaton))
    }

    /// Returns the condition that an activity has work in a cycle.
    pub(super) fn can_run(&self, automaton: AutomatonId) -> Guard {
        let mode = self.mode(automaton);
        match self.system.automata[automaton].service {
            None => mode.is(permanent::RUNS),
            Some(_) => any([mode.clone().is(mode::RUNS), mode.is(mode::STOPS)]),
        }
    }

    /// Returns the condition that a task begins a cycle.
    pub(super) fn is_released(&self, task: &TaskPart) -> Guard {
        let works =
            any(self.automata(task.id).into_iter().map(|automaton| self.can_run(automaton)));
        let due = task.due().is(1_usize);
        let begins = match (task.period, self.system.tasks[task.id].keep_idle_tick) {
            (None, _) => works,
            (Some(_), true) => all([due, works]),
            (Some(_), false) => due,
        };
        all([task.position().is(position::IDLE), begins])
    }

    /// Returns the conditions that some task asks for a core, and that some other task begins a cycle.
    pub(super) fn releases(&self) -> [Guard; 2] {
        [true, false].map(|asks| {
            let tasks = self.parts.iter().flat_map(|part| &part.tasks);
            let tasks = tasks.filter(|task| (task.needs_core && !self.inserts(task)) == asks);
            any(tasks.map(|task| self.is_released(task)))
        })
    }

    /// Returns the condition that the locks of a codel are free for an executor.
    pub(super) fn is_free(&self, codel: CodelId, executor: &str) -> Guard {
        all(self.blocked(codel, executor).iter().map(Guard::negated))
    }

    /// Returns true if a codel excludes no other codel.
    pub(super) fn is_lockless(&self, codel: CodelId) -> bool {
        self.system.codels[codel].conflicts.is_empty()
    }

    /// Returns the updates that begin to wait for a codel, or to execute it if it excludes no other one.
    pub(super) fn begin(&self, codel: CodelId, executor: &str) -> Vec<Update> {
        let mut out = vec![wanted(executor).set(number(codel))];
        if self.is_lockless(codel) {
            out.push(executed(executor).set(number(codel)));
            out.push(Update::Reset(format!("x_{executor}")));
        }
        out
    }

    /// Returns the condition that an action must happen before time passes.
    pub(super) fn must_act(&self) -> Guard {
        let mut out = Vec::new();
        let mut acquires = |name: &str, codel: CodelId| {
            if !self.is_lockless(codel) {
                let waits = wanted(name).is(number(codel));
                let waits = all([waits, executed(name).is(0_usize)]);
                out.push(all([waits, self.is_free(codel, name)]));
            }
        };
        for part in &self.parts {
            for automaton in part.tasks.iter().flat_map(|task| self.automata(task.id)) {
                for state in &self.system.machine_of(automaton).states {
                    acquires(self.automaton_name(automaton), state.codel);
                }
            }
            for &codel in part.services.iter().flat_map(|(_, codels)| codels) {
                acquires(&part.name, codel);
            }
        }
        for part in self.parts.iter().filter(|part| part.control) {
            out.push(all([part.step().is(step::READY), part.own("ended").is(1_usize)]));
        }
        any(out)
    }

    /// Returns the condition that all components have begun to start.
    pub(super) fn has_booted(&self) -> Guard {
        var(BOOTED).is(self.parts.len())
    }

    /// Returns the edges that end a step, of an action or of the start of a component at time 0.
    pub(super) fn ends_step(&self, edge: Edge) -> [Edge; 2] {
        let boots = var(BOOTED).set(var(BOOTED).plus(1));
        let at_start = edge.clone().when(self.has_booted().negated()).with([boots]);
        [at_start, edge.when(self.has_booted()).sends("step")]
    }
}

impl Part {
    /// Returns the condition that the control task takes a request: ends of activities are reported first.
    pub(super) fn takes_requests(&self) -> Guard {
        all([self.step().is(step::READY), self.own("ended").is(0_usize)])
    }
}

/// Returns the condition that an activity of a service has a status.
pub(super) fn has_status(layout: &Layout, service: ServiceId, status: SlotStatus) -> Guard {
    let has = |id: &AutomatonId| {
        let (mode, interrupted) = (layout.mode(*id), layout.interrupted(*id));
        match status {
            SlotStatus::Void | SlotStatus::Active => mode.is_not(mode::FREE),
            SlotStatus::Wait => mode.is(mode::ACCEPTED),
            SlotStatus::Run => all([mode.is(mode::RUNS), interrupted.is(0_usize)]),
            // An interrupted activity counts as stopping at once.
            SlotStatus::Stop => {
                let noticed = mode.clone().is(mode::STOPS);
                any([noticed, all([mode.is(mode::RUNS), interrupted.is(1_usize)])])
            }
        }
    };
    let some = any(layout.places(service).iter().map(has));
    if status == SlotStatus::Void { some.negated() } else { some }
}
