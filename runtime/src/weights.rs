//! Weights of yields, as the template of UPPAAL-SMC reads them (`all.proba`): one transition a line,
//! `OWNER::COMPONENT_STATE::COMPONENT_[pause_]STATE COUNT`, where the owner is a task or a service.

use dotgen_timing::system::{Machine, MachineId, TimedSystem, Yield};
use typed_index_collections::TiVec;

/// The weight of each yield, by machine and state. A state without weights has an empty list.
#[derive(Debug, Clone)]
pub struct Weights(TiVec<MachineId, Vec<Vec<u64>>>);

/// A line of a file of weights that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadLine {
    /// Line, from 1.
    pub line: usize,
    pub what: String,
}

impl Weights {
    /// Reads the weights of a system. Comments begin with `#`. The second result has the lines whose
    /// transitions the system does not have; a file may be about more components.
    ///
    /// # Errors
    ///
    /// A line that is no transition with a whole number.
    pub fn parse(text: &str, system: &TimedSystem) -> Result<(Weights, Vec<BadLine>), BadLine> {
        let mut out: TiVec<MachineId, Vec<Vec<u64>>> =
            system.machines.iter().map(|machine| vec![Vec::new(); machine.states.len()]).collect();
        let mut unknown = Vec::new();
        for (line, content) in (1..).zip(text.lines()) {
            let content = content.split('#').next().unwrap_or_default();
            let words: Vec<&str> = content.split_whitespace().collect();
            let (transition, count) = match words[..] {
                [] => continue,
                [transition, count] => (transition, count.parse::<u32>().ok()),
                _ => (content, None),
            };
            let parts: Vec<&str> = transition.split("::").collect();
            let (&[owner, from, to], Some(count)) = (&parts[..], count) else {
                let form = "is no `OWNER::COMPONENT_STATE::COMPONENT_STATE COUNT`";
                return Err(BadLine { line, what: format!("`{}` {form}", content.trim()) });
            };
            let mut known = false;
            for (id, machine) in system.machines.iter_enumerated() {
                for (state, outcome) in transitions(machine, owner, from, to) {
                    let weights = &mut out[id][state];
                    weights.resize(machine.states[state].yields.len(), 0);
                    weights[outcome] += u64::from(count);
                    known = true;
                }
            }
            if !known {
                unknown.push(BadLine { line, what: format!("`{transition}` is no transition") });
            }
        }
        Ok((Weights(out), unknown))
    }

    /// Returns the weights of the yields of a state, in their order; `None` if none is positive.
    pub(crate) fn of(&self, machine: MachineId, state: usize) -> Option<&[u64]> {
        let weights = self.0[machine].get(state)?;
        weights.iter().any(|weight| *weight > 0).then_some(&**weights)
    }
}

/// Returns state and yield of each transition of a machine with these names.
fn transitions(machine: &Machine, owner: &str, from: &str, to: &str) -> Vec<(usize, usize)> {
    let Some((component, name)) = machine.name.split_once('.') else { return Vec::new() };
    let state = |text: &str| text.strip_prefix(component)?.strip_prefix('_').map(str::to_owned);
    let (Some(from), Some(to)) = (state(from), state(to)) else { return Vec::new() };
    if name != owner {
        return Vec::new();
    }
    let paused = to.strip_prefix("pause_");
    let is = |next: usize, name: &str| machine.states[next].name == name;
    let fits = |transition: &Yield| match *transition {
        Yield::Next(next) => is(next, &to),
        Yield::Pause(next) => paused.is_some_and(|name| is(next, name)),
        Yield::End => to == "ether",
    };
    let mut out = Vec::new();
    for (number, state) in machine.states.iter().enumerate().filter(|(_, it)| it.name == from) {
        let place = state.yields.iter().position(fits);
        out.extend(place.map(|place| (number, place)));
    }
    out
}
