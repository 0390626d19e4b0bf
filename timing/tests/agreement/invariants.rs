//! Agreement of invariants with exploration: no conjunction that they exclude is ever reached.

use std::sync::atomic::{AtomicUsize, Ordering};

use dotgen_loaders::unit;
use dotgen_timing::explore::{Limits, Watch, explore};
use dotgen_timing::invariants::never_holds;
use dotgen_timing::property::{Atom, Predicate, SlotStatus, StatePhase, TaskState};
use dotgen_timing::scn::names::Names;
use dotgen_timing::scn::parse;
use dotgen_timing::system::build::build;
use dotgen_timing::system::{ClientId, CodelId, MachineId, ServiceId, TaskId, TimedSystem};
use dotgen_timing::verify::{Cancel, Options, settings};

use crate::agreement::servers::random::{Texts, requests, texts, varied};
use crate::agreement::systems::{self, Dice};
use crate::agreement::{all_agree, cases, first};

/// Number of pairs of literals that are tried in each system.
const PAIRS: usize = 60;

/// Number of excluded conjunctions, and of systems with one.
static EXCLUDED: AtomicUsize = AtomicUsize::new(0);
static SYSTEMS: AtomicUsize = AtomicUsize::new(0);

/// Returns a random atom of a system.
fn atom(system: &TimedSystem, dice: &mut Dice) -> Atom {
    let below = |dice: &mut Dice, n: usize| dice.below(n as u32) as usize;
    let phases = [StatePhase::Lock, StatePhase::Exec, StatePhase::Exec, StatePhase::Any];
    let phase = dice.pick(&phases);
    match dice.below(8) {
        0 => {
            let states = [TaskState::Idle, TaskState::Waiting, TaskState::Running];
            Atom::Task(TaskId::from(below(dice, system.tasks.len())), dice.pick(&states))
        }
        1 if !system.services.is_empty() => {
            let statuses = [SlotStatus::Void, SlotStatus::Run, SlotStatus::Active];
            Atom::Slot(below(dice, system.services.len()).into(), dice.pick(&statuses))
        }
        2 if !system.services.is_empty() => {
            let service = ServiceId::from(below(dice, system.services.len()));
            let it = &system.services[service];
            let codels: Vec<CodelId> = it.validate.iter().chain(&it.simple).copied().collect();
            let codel = (!codels.is_empty()).then(|| codels[below(dice, codels.len())]);
            Atom::Handling { service, codel, phase }
        }
        3 => Atom::ControlBusy(below(dice, system.components.len()).into()),
        4 if !system.clients.is_empty() => {
            let client = ClientId::from(below(dice, system.clients.len()));
            let step = below(dice, system.clients[client].done() + 1);
            Atom::Client(client, vec![step])
        }
        _ if system.machines.is_empty() => Atom::Task(TaskId::default(), TaskState::Active),
        _ => {
            let machine = MachineId::from(below(dice, system.machines.len()));
            let state = below(dice, system.machines[machine].states.len());
            Atom::State { machine, state, phase }
        }
    }
}

fn literal(system: &TimedSystem, dice: &mut Dice) -> Predicate {
    let atom = Predicate::Atom(atom(system, dice));
    if dice.in_ten(2) { Predicate::Not(Box::new(atom)) } else { atom }
}

/// Returns the pairs of codels, in states of machines, of which one waits for the other: often in one
/// direction only.
fn waiting_pairs(system: &TimedSystem) -> Vec<Predicate> {
    let machines = system.machines.iter_enumerated();
    let states: Vec<(Atom, CodelId)> = machines
        .flat_map(|(machine, it)| {
            let states = it.states.iter().enumerate();
            states.map(move |(state, of)| {
                let phase = StatePhase::Exec;
                let atom = Atom::State { machine, state, phase };
                (atom, of.codel)
            })
        })
        .collect();
    let mut out = Vec::new();
    for (one, codel) in &states {
        for (other, _) in
            (states.iter()).filter(|(_, other)| system.codels[*codel].conflicts.contains(*other))
        {
            let [one, other] = [one, other].map(|atom| Box::new(Predicate::Atom(atom.clone())));
            out.push(Predicate::And(one, other));
        }
    }
    out
}

/// Returns conjunctions that invariants exclude in a system.
pub(crate) fn excluded(seed: u64, system: &TimedSystem) -> Vec<Predicate> {
    let mut dice = Dice::new(seed ^ 0x1e57);
    let pair = |dice: &mut Dice| {
        let [one, other] = [(); 2].map(|()| Box::new(literal(system, dice)));
        Predicate::And(one, other)
    };
    let random = (0..PAIRS).map(|_| pair(&mut dice));
    let pairs = waiting_pairs(system).into_iter().take(PAIRS).chain(random);
    pairs.filter(|both| never_holds(system, both)).collect()
}

fn compare(seed: u64, system: &TimedSystem) -> Option<Result<(), String>> {
    let excluded = excluded(seed, system);
    if excluded.is_empty() {
        return Some(Ok(()));
    }
    EXCLUDED.fetch_add(excluded.len(), Ordering::Relaxed);
    SYSTEMS.fetch_add(1, Ordering::Relaxed);
    let watch = Watch { reach: excluded, ..Watch::default() };
    let limits = Limits { states: 100_000, bytes: 1 << 28, threads: 1, ..Limits::default() };
    let found = explore(system, &watch, limits, &Cancel::default());
    let reached = found.reached.iter().position(Option::is_some);
    Some(match reached {
        Some(at) => Err(format!("seed {seed}: {:?} is reached\n{system:#?}", watch.reach[at])),
        None => Ok(()),
    })
}

/// Returns the system of a specification and scenario.
fn built(texts: &Texts) -> Option<TimedSystem> {
    let units: Result<Vec<_>, String> =
        texts.specifications.iter().map(|text| unit(text)).collect();
    let units = units.ok()?;
    let parsed = parse(&texts.scenario);
    let specs: Vec<_> = units.iter().map(|unit| &*unit.spec).collect();
    let names = Names::new(&specs);
    let settings = settings(&parsed.scenario, &Options::default());
    Some(build(&names, &settings, &|_| true).system)
}

/// Returns a random system of any kind.
pub(crate) fn system(seed: u64) -> Option<TimedSystem> {
    let mut dice = Dice::new(seed);
    match seed % 4 {
        0 => Some(systems::random(&mut dice).0),
        1 => built(&texts(&mut dice)),
        2 => built(&varied(&mut dice)),
        _ => built(&requests(&mut dice)),
    }
}

#[test]
fn what_invariants_exclude_is_never_reached() {
    all_agree(first(), cases(), 2, |seed| compare(seed, &system(seed)?));
    let [excluded, systems] = [&EXCLUDED, &SYSTEMS].map(|count| count.load(Ordering::Relaxed));
    eprintln!("{excluded} conjunctions are excluded, in {systems} systems");
    assert!(systems as u64 >= cases() / 2, "conjunctions are compared");
}
