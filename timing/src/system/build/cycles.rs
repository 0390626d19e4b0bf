//! Cycles of states without a pause, and contradictory loop limits.

use dotgen_analysis::model::Src;

use super::Builder;
use crate::diagnostic::remark::Remark;
use crate::diagnostic::{Diagnostic, Place};
use crate::system::{Machine, loop_contradictions, loops};

impl Builder<'_> {
    /// Determines how loop limits count, and reports cycles without a limit and contradictory limits.
    pub(super) fn loops(&mut self) {
        let mut found = Vec::new();
        for machine in self.out.system.machines.keys() {
            let system = &self.out.system;
            let used = system.automata.iter().find(|automaton| automaton.machine == machine);
            let Some(used) = used else { continue };
            let aperiodic = system.tasks[used.task].period.is_none();
            let permanent = used.service.is_none();
            let rule = self.loop_rules.get(&machine).cloned().unwrap_or_default();
            let definition = &system.machines[machine];
            let cycles = loops::pauseless_cycles(definition);
            let rounds = aperiodic
                && permanent
                && (0..definition.states.len()).any(|state| !loops::can_pause(definition, state));
            if definition.loop_limit.is_none() {
                let can_be_limited = rounds || loops::can_be_limited(definition);
                for cycle in cycles {
                    let names: Vec<&str> =
                        cycle.iter().map(|&at| &*definition.states[at].name).collect();
                    let remark = Remark::StateCycle {
                        machine: definition.name.clone(),
                        cycle: names.join(" → "),
                        can_be_limited,
                    };
                    found.push(remark.warning(rule.clone(), self.around(definition, &cycle)));
                }
                continue;
            }
            let entry = &mut self.out.system.machines[machine];
            if cycles.is_empty() {
                // The machine has no loop to count.
                entry.loop_limit = None;
                continue;
            }
            entry.rounds = rounds;
            let machine = &self.out.system.machines[machine];
            let limits = match machine.loop_limit {
                Some(1) => "no limit helps, as what led there can be repeated",
                _ => "a greater limit need not help",
            };
            for at in loop_contradictions(machine) {
                let (name, state) = (&machine.name, &machine.states[at].name);
                let mut error = Diagnostic::error(
                    "scn-contradictory-loop",
                    rule.clone(),
                    format!(
                        "the scenario is contradictory: under its loop limit, {name} can go nowhere from state \
                         `{state}`; {limits}: let the codel of `{state}` yield `pause::` or `ether` as well, or \
                         leave the turns without a limit: `loop free {name};`",
                    ),
                );
                error.places = self.codel_place(machine, at, None, "nowhere to go from here");
                found.push(error);
            }
        }
        for diagnostic in found {
            self.report(diagnostic);
        }
    }

    /// Returns the places of a cycle of states: one for each `yield`, in order.
    fn around(&self, machine: &Machine, cycle: &[usize]) -> Vec<Place> {
        let steps = cycle.windows(2).flat_map(|step| {
            let next = &machine.states[step[1]].name;
            let what = format!("`{}` → `{next}`", machine.states[step[0]].name);
            self.codel_place(machine, step[0], Some(next), &what)
        });
        steps.collect()
    }

    /// Returns the codel of a state, or the place at which the codel yields another state.
    fn codel_place(
        &self,
        machine: &Machine,
        state: usize,
        next: Option<&str>,
        what: &str,
    ) -> Vec<Place> {
        let codel = machine.states[state].codel;
        let Some((c, site)) = self.out.system.codels[codel].site else {
            return Vec::new();
        };
        let codel = self.names.components[c].component.codel(site);
        let yielded = codel.yields.iter();
        let yielded = yielded.filter(|state| !state.paused && Some(state.name.as_str()) == next);
        let src: Src = yielded.map(|state| state.src).next().unwrap_or(codel.src);
        vec![self.place(c, src, what)]
    }
}
