//! The state machines that a host needs to stop without the engine.

use dotgen_timing::system::{CodelId, ComponentId, Machine, TimedSystem, Yield};
use num_rational::Ratio;

use super::{HostedComponents, lane};
use crate::hosts::{DelegatedState, DelegatedYield, HostMachine};

impl HostedComponents<'_> {
    /// Returns the machines of the activities of a component, each once.
    pub fn machines(&self, system: &TimedSystem, component: ComponentId) -> Vec<HostMachine> {
        let mut out: Vec<HostMachine> = Vec::new();
        let automata = system.automata.iter();
        for automaton in automata.filter(|of| system.tasks[of.task].component == component) {
            let machine = &system.machines[automaton.machine];
            let task = &system.tasks[automaton.task];
            let nanos = system.unit * Ratio::from_integer(1_000_000_000);
            let period = nanos * Ratio::from_integer(task.period.unwrap_or(0).into());
            let host_machine = HostMachine {
                name: machine.name.clone(),
                lane: lane(automaton.task),
                period: u64::try_from(period.to_integer()).unwrap_or(0),
                states: machine.states.iter().map(|at| self.state(machine, at.codel)).collect(),
                stop: machine.stop,
            };
            if !out.contains(&host_machine) {
                out.push(host_machine);
            }
        }
        out
    }

    fn state(&self, machine: &Machine, codel: CodelId) -> DelegatedState {
        let follows = |event: &String| {
            let next = match self.yield_of(codel, machine, event)? {
                Yield::Next(to) => DelegatedYield::Next(to),
                Yield::Pause(to) => DelegatedYield::Pause(to),
                Yield::End => return None,
            };
            Some((event.clone(), next))
        };
        DelegatedState {
            codel: self.codel(codel).unwrap_or(HostMachine::SIMULATED),
            next: self.events(codel).iter().filter_map(follows).collect(),
        }
    }

    /// Returns the yield that an event stands for; `None` if the codel does not declare the event.
    pub(super) fn yield_of(&self, codel: CodelId, machine: &Machine, event: &str) -> Option<Yield> {
        if !self.declares(codel, event) {
            return None;
        }
        let mut words = event.rsplit("::");
        let name = words.next()?;
        let paused = words.next() == Some("pause");
        let to = machine.states.iter().position(|state| state.name == name);
        Some(match to {
            Some(to) if paused => Yield::Pause(to),
            Some(to) => Yield::Next(to),
            None => Yield::End,
        })
    }
}
