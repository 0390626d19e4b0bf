//! Bounds on the reaction time of cause-effect chains under the semantics of the servers (section 19),
//! without waits for cores.
//!
//! A chain leads through codels of permanent activities of periodic tasks, in components that do not shut
//! down because one of them throws. If every cycle of the task
//! executes the codel, whatever state it resumes, the first execution that begins after some moment reads the
//! data visible then. Cycles follow each other by at most a period, and each takes at most its length (see
//! `servers`). So the codel has ended, and its output is visible, a period and a length after that moment. A
//! later codel of the same cycle has ended by then, too. A datum that depends on the first one continues to
//! do so whatever else is written, because the first arrival ends the measurement. So the times add up (the
//! bound of A. Davare et al., *Period optimization for hard real-time distributed automotive systems*, DAC
//! 2007), and any path of the data gives a bound.
//!
//! A moment before the start of a task waits for this start: tasks of a component are started one after the
//! other, each after the first pass of the previous one, and begin with a tick.

use super::servers::{self, Turns, Window};
use super::situations::situations;
use super::windows::{ClientWindow, shuts_down, whole_run};
use crate::scn::semantics::Semantics;
use crate::system::loops::pauseless_cycles;
use crate::system::{CodelId, Machine, TaskId, Ticks, TimedSystem, Yield};

/// Returns a bound on the reaction time of a chain, in base units. The data go by any of some paths; each
/// path lists the codels that carry the data, in order. Returns `None` if this method finds no bound.
pub fn reaction_bound(system: &TimedSystem, ways: &[Vec<CodelId>]) -> Option<Ticks> {
    let platform = &system.platform;
    let simple = platform.semantics == Semantics::SERVERS
        && platform.cores.is_none()
        && servers::is_within_components(system)
        && !system.has_builtin(|_| true);
    if !simple {
        return None;
    }
    let turns = Turns::new(system, &situations(system));
    let client = ClientWindow::any_time(whole_run(system));
    let tasks = Tasks { system, window: Window::new(&turns, client, None) };
    ways.iter().filter_map(|way| tasks.way(way)).min()
}

struct Tasks<'s> {
    system: &'s TimedSystem,
    window: Window<'s>,
}

/// Codels of one path that every cycle of a task executes one after the other.
struct Stage<'s> {
    task: TaskId,
    machine: &'s Machine,
    first: CodelId,
    last: CodelId,
}

impl Tasks<'_> {
    /// Returns the latest time at which the data of moment 0 have passed the whole path. A later moment waits
    /// no longer, because less of the start is left.
    fn way(&self, way: &[CodelId]) -> Option<Ticks> {
        let mut stages: Vec<Stage> = Vec::new();
        for &codel in way {
            if let Some(stage) = stages.last_mut()
                && follows(stage.machine, stage.last, codel)
            {
                stage.last = codel;
                continue;
            }
            let (task, machine) = self.executes(codel)?;
            stages.push(Stage { task, machine, first: codel, last: codel });
        }
        let mut at: Ticks = 0;
        for stage in &stages {
            at = at.checked_add(self.round(stage.task)?)?;
            at = at.max(self.started(stage)?);
        }
        Some(at).filter(|_| !stages.is_empty())
    }

    /// Returns the task whose permanent activity executes a codel in every cycle, except possibly the first.
    fn executes(&self, codel: CodelId) -> Option<(TaskId, &Machine)> {
        let system = self.system;
        let has = |machine: &Machine| machine.states.iter().any(|state| state.codel == codel);
        let mut all = system.tasks.iter_enumerated().filter_map(|(task, entry)| {
            let machine = system.machine_of(entry.permanent?);
            has(machine).then_some((task, machine))
        });
        let (task, machine) = all.next().filter(|_| all.next().is_none())?;
        let yields = || machine.states.iter().flat_map(|state| &state.yields);
        let ends = yields().any(|transition| *transition == Yield::End);
        let mut resumed = yields().filter_map(|transition| match *transition {
            Yield::Pause(state) => Some(state),
            _ => None,
        });
        let always = !ends
            && !shuts_down(system, system.tasks[task].component)
            && pauseless_cycles(machine).is_empty()
            && resumed.all(|state| meets(machine, state, codel));
        always.then_some((task, machine))
    }

    /// Returns a period and the length of a cycle: less than two periods, for a later task less than one and
    /// a half (see `servers`).
    fn round(&self, task: TaskId) -> Option<Ticks> {
        let period = self.system.tasks[task].period?;
        let length = self.length(task)?;
        let in_time = match self.place(task)? {
            0 => length < period,
            _ => length.checked_mul(2)? < period,
        };
        period.checked_add(length).filter(|_| in_time)
    }

    fn length(&self, task: TaskId) -> Option<Ticks> {
        self.window.cycle(task)
    }

    /// Returns the index of a task in its component.
    fn place(&self, task: TaskId) -> Option<usize> {
        let component = &self.system.components[self.system.tasks[task].component];
        component.tasks.iter().position(|other| *other == task)
    }

    /// Returns the latest end of the first cycle that executes a stage.
    fn started(&self, stage: &Stage) -> Option<Ticks> {
        let component = &self.system.components[self.system.tasks[stage.task].component];
        let mut at: Ticks = 0;
        for &task in component.tasks.iter().take(self.place(stage.task)? + 1) {
            let definition = &self.system.tasks[task];
            // A tick that has come is kept; otherwise the next tick comes after a period, the first one
            // possibly later.
            let tick = definition.period?.checked_add(definition.delay)?;
            at = at.checked_add(tick)?.checked_add(self.length(task)?)?;
        }
        if meets(stage.machine, stage.machine.start, stage.first) {
            Some(at)
        } else {
            at.checked_add(self.round(stage.task)?)
        }
    }
}

/// Returns true if a turn that begins with a state executes a codel, whatever the yields.
fn meets(machine: &Machine, state: usize, codel: CodelId) -> bool {
    let mut seen = vec![false; machine.states.len()];
    let mut todo = vec![state];
    while let Some(at) = todo.pop() {
        if machine.states[at].codel == codel || std::mem::replace(&mut seen[at], true) {
            continue;
        }
        for transition in &machine.states[at].yields {
            match *transition {
                Yield::Next(next) => todo.push(next),
                Yield::Pause(_) | Yield::End => return false,
            }
        }
    }
    true
}

/// Returns true if a turn that has executed a codel executes another one after it, whatever the yields.
fn follows(machine: &Machine, codel: CodelId, next: CodelId) -> bool {
    let mut states = machine.states.iter().filter(|state| state.codel == codel);
    states.all(|candidate| {
        candidate.yields.iter().all(|transition| match *transition {
            Yield::Next(state) => meets(machine, state, next),
            Yield::Pause(_) | Yield::End => false,
        })
    })
}
