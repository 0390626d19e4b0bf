//! The process of a permanent activity, or of a place of an activity: its turns.

use dotgen_timing::explore::Action;
use dotgen_timing::system::{AutomatonId, FOREVER, Machine, Yield};

use crate::model::{Edge, LocationKind, Process, Relation, Update, all};

use super::super::layout::{Layout, Part, executed, number, wanted};
use super::super::published::{mode, permanent};
use super::super::unique::Unique;

struct Writer<'w> {
    layout: &'w Layout<'w>,
    part: &'w Part,
    id: AutomatonId,
    name: &'w str,
    machine: &'w Machine,
    /// By state, the locations in which its codel waits and executes; `None` if it cannot be entered.
    locations: Vec<Option<(String, String)>>,
    out: Process,
}

/// Returns the process of an activity.
pub(super) fn process(layout: &Layout, part: &Part, id: AutomatonId) -> Process {
    let machine = layout.system.machine_of(id);
    let name = layout.automaton_name(id);
    let comment = match layout.system.automata[id].service {
        Some(service) => format!("a place of {}", layout.system.service_path(service)),
        None => format!("the permanent activity of {}", machine.name),
    };
    let mut names = Unique::default();
    let locations = machine.states.iter().map(|state| {
        let mut name = |what: &str| names.take(&format!("{what}_{}", state.name), &state.name);
        (!state.yields.is_empty()).then(|| (name("waits"), name("executes")))
    });
    let locations = locations.collect();
    let out = Process::new(&format!("activity_{name}"), comment);
    let mut writer = Writer { layout, part, id, name, machine, locations, out };
    writer.add();
    writer.out
}

impl Writer<'_> {
    fn add(&mut self) {
        self.out.location("rests", LocationKind::Normal, "not in a turn");
        self.out.location("enters", LocationKind::Committed, "a turn begins");
        let turn = Edge::new("rests", "enters", "its turn begins");
        self.out.edge(turn.receives(&self.layout.turn(self.id)));
        let executor = usize::from(self.id);
        for (index, state) in self.machine.states.iter().enumerate() {
            let Some((waits, executes)) = self.locations[index].clone() else { continue };
            let codel = &self.layout.system.codels[state.codel];
            let words = self.layout.codel_in_words(state.codel);
            let clock = format!("x_{}", self.name);
            if !self.layout.is_lockless(state.codel) {
                let comment = format!("waits for the locks of {words}");
                self.out.location(&waits, LocationKind::Normal, comment);
                let edge = Edge::new(&waits, &executes, format!("begins {}", codel.path));
                let edge = edge.when(self.layout.is_free(state.codel, self.name)).sends("step");
                let executing = executed(self.name).set(number(state.codel));
                let edge = edge.with([executing, Update::Reset(clock.clone())]);
                self.out.edge(edge.begins(Action::Acquire { executor }));
            }
            let upper = (codel.upper != FOREVER).then_some(i64::from(codel.upper));
            let comment = format!("{words}: {}", self.layout.interval(codel.lower, codel.upper));
            self.out.bounded(&executes, &clock, upper, comment);
            let enter = Edge::new("enters", "", format!("its turn begins in {}", state.name));
            let is_there = self.layout.state(self.id).is(index);
            let enter = self.enter(enter.when(is_there), index);
            self.out.edges.extend(self.layout.ends_step(enter));
            for &by in &state.yields {
                self.ends(index, by);
            }
        }
    }

    /// Lets an edge lead to a state.
    fn enter(&self, edge: Edge, state: usize) -> Edge {
        let codel = self.machine.states[state].codel;
        let Some((waits, executes)) = self.locations[state].as_ref() else { return edge };
        let target = if self.layout.is_lockless(codel) { executes } else { waits };
        let edge = Edge { target: target.clone(), ..edge };
        edge.with(self.layout.begin(codel, self.name))
    }

    /// The ends of a codel with a yield.
    fn ends(&mut self, state: usize, by: Yield) {
        let Some((_, executes)) = self.locations[state].clone() else { return };
        let layout = self.layout;
        let codel = &layout.system.codels[self.machine.states[state].codel];
        let what = match by {
            Yield::Next(to) => self.machine.states[to].name.clone(),
            Yield::Pause(to) => format!("pause::{}", self.machine.states[to].name),
            Yield::End => "ether".to_owned(),
        };
        let edge = Edge::new(&executes, "rests", format!("ends with {what}"));
        let mut edge = edge.when_clock(&format!("x_{}", self.name), Relation::AtLeast, codel.lower);
        edge.action = layout.end_of_codel((self.id, usize::from(self.id)), state, Some(by));
        let idle = [executed(self.name).set(0_usize), wanted(self.name).set(0_usize)];
        let edge = edge.with(idle).with([layout.state(self.id).set(match by {
            Yield::Next(to) | Yield::Pause(to) => to,
            Yield::End => 0,
        })]);
        let task = layout.system.automata[self.id].task;
        let over = format!("over_{}", layout.task(task).name);
        let mode = layout.mode(self.id);
        if layout.system.automata[self.id].service.is_some() {
            let edge = match by {
                Yield::Next(to) => self.enter(edge, to).sends("step"),
                Yield::Pause(_) => edge.sends(&over),
                Yield::End => {
                    let ended = [mode.set(mode::ENDED), layout.interrupted(self.id).set(0_usize)];
                    edge.sends(&over).with(ended)
                }
            };
            self.out.edge(edge);
            return;
        }
        let is_periodic = layout.system.tasks[task].period.is_some();
        let started = format!("started_{}", self.part.name);
        // An aperiodic task has no first turn.
        let turns = is_periodic.then_some(permanent::FIRST_TURN);
        let firsts: Vec<usize> = std::iter::once(permanent::FIRST_CODEL).chain(turns).collect();
        for at in firsts.iter().copied().chain([permanent::RUNS]) {
            let first = at != permanent::RUNS;
            // Some guard holds for every mode.
            let is_at = if first {
                mode.clone().is(at)
            } else {
                all(firsts.iter().map(|&first| mode.clone().is_not(first)))
            };
            let channel = match at {
                permanent::FIRST_CODEL => &*started,
                permanent::FIRST_TURN => "step",
                _ => &over,
            };
            let edge = edge.clone().when(is_at);
            let edge = match by {
                // The first cycle of an aperiodic task follows its start.
                Yield::Next(_) if at == permanent::FIRST_CODEL && !is_periodic => {
                    edge.sends(channel).with([mode.clone().set(permanent::RUNS)])
                }
                Yield::Next(to) if at == permanent::FIRST_CODEL => {
                    let edge = edge.with([mode.clone().set(permanent::FIRST_TURN)]);
                    self.enter(edge, to).sends(channel)
                }
                Yield::Next(to) => self.enter(edge, to).sends("step"),
                Yield::Pause(_) => {
                    let runs = first.then(|| mode.clone().set(permanent::RUNS));
                    edge.sends(channel).with(runs)
                }
                Yield::End => edge.sends(channel).with([mode.clone().set(permanent::ENDED)]),
            };
            self.out.edge(edge);
        }
    }
}
