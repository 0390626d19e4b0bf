//! Random systems of periodic tasks without requests.

use dotgen_timing::scn::semantics::LockRule;
use dotgen_timing::system::{CodelSet, FOREVER, Policy, State, TaskId, TimedSystem, Yield};

use super::{Dice, automaton, codel, competing};

/// Returns two to four periodic tasks that compete for locks and cores, and whose start-up takes no time.
pub(crate) fn periodic(dice: &mut Dice) -> TimedSystem {
    let mut system = competing(dice);
    system.platform.policy = dice.pick(&[Policy::Fifo, Policy::Edf, Policy::Edf, Policy::Any]);
    system.platform.semantics.locks =
        dice.pick(&[LockRule::Free, LockRule::Free, LockRule::Free, LockRule::Fifo]);
    for t in 0..system.tasks.len() {
        let task = &mut system.tasks[TaskId::from(t)];
        task.period = Some(dice.pick(&[4, 6, 6, 8, 12, 12]));
        task.delay = if dice.in_ten(2) { 1 + dice.below(4) } else { 0 };
        if task.permanent.is_none() {
            let component = task.component;
            let codel = codel(&mut system, dice, component, format!("t{t}.s0"));
            let machine = system.machines.push_and_get_key(dotgen_timing::system::Machine {
                name: format!("t{t}"),
                states: vec![State {
                    name: "s0".to_owned(),
                    codel,
                    yields: vec![Yield::Pause(0)],
                    is_async: false,
                }],
                start: 0,
                stop: None,
                loop_limit: None,
                rounds: false,
            });
            system.tasks[TaskId::from(t)].permanent =
                Some(automaton(&mut system, t, machine, None));
        }
    }
    for codel in &mut system.codels {
        if codel.upper == FOREVER {
            codel.upper = 2;
            codel.lower = codel.lower.min(2);
        }
        if dice.in_ten(1) {
            codel.upper += 1;
        }
    }
    // Tasks that share only cores, and return to the same place, can be treated in busy windows.
    let plain = dice.in_ten(4);
    if plain {
        for codel in &mut system.codels {
            codel.conflicts = CodelSet::default();
        }
        system.platform.cores = Some(dice.pick(&[1, 1, 2]));
    }
    for machine in &mut system.machines {
        let start = machine.states[machine.start].codel;
        (system.codels[start].lower, system.codels[start].upper) = (0, 0);
        machine.loop_limit = None;
        for (at, state) in machine.states.iter_mut().enumerate() {
            for transition in &mut state.yields {
                *transition = match *transition {
                    Yield::Next(to) if to > at && at != machine.start => Yield::Next(to),
                    Yield::Next(to) | Yield::Pause(to) => Yield::Pause(to),
                    Yield::End => Yield::Pause(0),
                };
                if plain && at != machine.start {
                    *transition = Yield::Pause(at);
                }
            }
        }
    }
    system
}
