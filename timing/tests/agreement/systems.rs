//! Random small systems.

pub(crate) mod periodic;
pub(crate) mod requests;

use dotgen_timing::property::{Atom, Predicate, StatePhase, TaskState};
use dotgen_timing::scn::semantics::{LockRule, Semantics};
use dotgen_timing::system::{
    Automaton, AutomatonId, Client, ClientAction, ClientStep, Codel, CodelId, CodelName, CodelSet,
    Component, ComponentId, FOREVER, Machine, MachineId, Platform, Policy, Service, ServiceId,
    State, Task, TaskId, TimedSystem, Yield, loop_contradictions,
};
use proptest::prelude::Rng;
use proptest::test_runner::{RngAlgorithm, TestRng};
use typed_index_collections::TiVec;

/// Pseudo-random choices from a seed.
pub(crate) struct Dice(TestRng);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        let mut bytes = [0; 32];
        bytes[..8].copy_from_slice(&seed.to_le_bytes());
        Dice(TestRng::from_seed(RngAlgorithm::ChaCha, &bytes))
    }

    pub(crate) fn below(&mut self, n: u32) -> u32 {
        self.0.next_u32() % n
    }

    pub(crate) fn in_ten(&mut self, n: u32) -> bool {
        self.below(10) < n
    }

    pub(crate) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len() as u32) as usize]
    }
}

/// Returns a system of one or two components with one to three tasks altogether, and pairs of predicates for
/// it.
pub(crate) fn random(dice: &mut Dice) -> (TimedSystem, Vec<(Predicate, Predicate)>) {
    let mut system = TimedSystem {
        unit: dotgen_analysis::model::Seconds::new(1, 1000),
        components: TiVec::new(),
        tasks: TiVec::new(),
        machines: TiVec::new(),
        automata: TiVec::new(),
        codels: TiVec::new(),
        services: TiVec::new(),
        clients: TiVec::new(),
        platform: Platform {
            cores: dice.pick(&[None, Some(1), Some(1), Some(2)]),
            policy: dice.pick(&[Policy::Fifo, Policy::Edf, Policy::Any]),
            semantics: Semantics {
                locks: dice.pick(&[LockRule::Free, LockRule::Free, LockRule::Fifo]),
                ..Semantics::PUBLISHED
            },
            async_free: dice.in_ten(3),
            aperiodic_core: dice.in_ten(7),
        },
    };
    let tasks = 1 + dice.below(3) as usize;
    let split =
        if tasks > 1 && dice.in_ten(4) { 1 + dice.below(tasks as u32 - 1) as usize } else { tasks };
    for c in 0..if split < tasks { 2 } else { 1 } {
        let range = if c == 0 { 0..split } else { split..tasks };
        let component = system.components.push_and_get_key(Component {
            name: format!("c{c}"),
            tasks: range.clone().map(TaskId::from).collect(),
            services: Vec::new(),
        });
        for t in range {
            let permanent = dice.in_ten(8).then(|| {
                let machine = machine(&mut system, dice, component, format!("c{c}.t{t}"));
                automaton(&mut system, t, machine, None)
            });
            let aperiodic = dice.in_ten(1);
            system.tasks.push(Task {
                places: 16,
                priority: None,
                affinity: None,
                name: format!("t{t}"),
                component,
                period: (!aperiodic).then(|| 3 + dice.below(5)),
                delay: u32::from(dice.in_ten(1)),
                keep_idle_tick: dice.in_ten(3),
                permanent,
                slots: Vec::new(),
                src: None,
            });
        }
    }
    let services = dice.below(3) as usize;
    for v in 0..services {
        service(&mut system, dice, v);
    }
    for v in system.services.keys() {
        for other in system.services.keys() {
            if system.services[v].component == system.services[other].component && dice.in_ten(4) {
                system.services[v].interrupts.push(other);
            }
        }
    }
    for one in 0..system.codels.len() {
        for other in 0..one {
            if dice.in_ten(2) {
                system.exclude(one.into(), other.into());
            }
        }
    }
    if services > 0 {
        for k in 0..=(dice.below(5) / 4) {
            let client = client(&system, dice, k);
            system.clients.push(client);
        }
    }
    // Often as in specifications: from 0 to the worst case. Then ends can be postponed, if nothing else is
    // observed.
    let from_zero = dice.in_ten(5);
    if from_zero {
        system.codels.iter_mut().for_each(|codel| codel.lower = 0);
    }
    let mut within = Vec::new();
    for _ in 0..if from_zero { dice.below(4) / 3 } else { dice.below(3) } {
        let p = predicate(&system, dice);
        let q = predicate(&system, dice);
        within.push((p, q));
    }
    (system, within)
}

/// Returns a system of any of the other kinds without periodic tasks, with some long times, and predicates
/// that may be reached in it.
pub(crate) fn aperiodic(dice: &mut Dice) -> (TimedSystem, Vec<Predicate>) {
    let mut system = match dice.below(3) {
        0 => random(dice).0,
        1 => competing(dice),
        _ => requests::requests(dice),
    };
    for task in &mut system.tasks {
        task.period = None;
        task.delay = 0;
    }
    for codel in &mut system.codels {
        if dice.in_ten(3) {
            codel.upper = codel.upper.saturating_add(dice.below(9));
        }
    }
    // Often a fixed time, because that separates others.
    for codel in &mut system.codels {
        if dice.in_ten(3) && codel.upper != FOREVER {
            codel.lower = codel.upper;
        }
    }
    let goals = (0..4)
        .map(|_| {
            let random = predicate(&system, dice);
            if dice.in_ten(6) {
                Predicate::And(Box::new(random), Box::new(predicate(&system, dice)))
            } else {
                random
            }
        })
        .collect();
    (system, goals)
}

/// Returns a system of two to four tasks that compete for locks and cores, without services and mostly
/// without obstacles to reductions. Ticks follow each other, because there are few different periods.
pub(crate) fn competing(dice: &mut Dice) -> TimedSystem {
    let mut system = empty(dice);
    system.platform.policy = dice.pick(&[Policy::Fifo, Policy::Fifo, Policy::Edf, Policy::Any]);
    let tasks = 2 + dice.below(3) as usize;
    let from_zero = dice.in_ten(7);
    for t in 0..tasks {
        let component = placed(&mut system, dice, t);
        let permanent = dice.in_ten(9).then(|| {
            let name = format!("{}.t{t}", system.components[component].name);
            let machine = machine(&mut system, dice, component, name);
            automaton(&mut system, t, machine, None)
        });
        system.tasks.push(Task {
            places: 16,
            priority: None,
            affinity: None,
            name: format!("t{t}"),
            component,
            period: (!dice.in_ten(1)).then(|| dice.pick(&[2, 3, 4, 4, 6])),
            delay: 0,
            keep_idle_tick: false,
            permanent,
            slots: Vec::new(),
            src: None,
        });
    }
    for codel in &mut system.codels {
        if codel.upper != FOREVER {
            codel.upper = codel.upper.min(2);
        }
        codel.lower = if from_zero { 0 } else { codel.lower.min(codel.upper) };
    }
    for one in 0..system.codels.len() {
        for other in 0..one {
            if dice.in_ten(3) {
                system.exclude(one.into(), other.into());
            }
        }
    }
    system
}

/// Returns a system with a task that polls for ever, periodic tasks that share locks with it and each other,
/// and least times of 0: suitable for all reductions.
pub(crate) fn polling(dice: &mut Dice) -> TimedSystem {
    let mut system = empty(dice);
    system.platform.policy = dice.pick(&[Policy::Fifo, Policy::Fifo, Policy::Edf]);
    let periodic = 1 + dice.below(2) as usize;
    for t in 0..=periodic {
        let component = placed(&mut system, dice, t);
        let name = format!("{}.t{t}", system.components[component].name);
        let spans: &[(u32, u32)] = if t == 0 {
            &[(0, 1), (1, FOREVER), (0, 1), (0, 1)]
        } else {
            &[(0, 1), (0, 2), (0, 1)]
        };
        let states: Vec<State> = (0..spans.len())
            .map(|i| {
                let path = format!("{name}.s{i}");
                let codel = codel(&mut system, dice, component, path);
                (system.codels[codel].lower, system.codels[codel].upper) = spans[i];
                let yields = match (t, i) {
                    (0, 0) => vec![Yield::Next(1)],
                    (0, 1) if dice.in_ten(5) => vec![Yield::Next(2), Yield::Next(3)],
                    (0, 1 | 2) => vec![Yield::Next(i + 1)],
                    (0, _) if dice.in_ten(3) => vec![Yield::Next(1), Yield::Next(3)],
                    (0, _) => vec![Yield::Next(1)],
                    (_, 0) => vec![Yield::Pause(1)],
                    (_, 1) if dice.in_ten(5) => vec![Yield::Pause(1), Yield::Next(2)],
                    _ => vec![Yield::Pause(1)],
                };
                State { name: format!("s{i}"), codel, yields, is_async: false }
            })
            .collect();
        let machine = system.machines.push_and_get_key(Machine {
            name: name.clone(),
            states,
            start: 0,
            stop: None,
            loop_limit: (t == 0 && dice.in_ten(7)).then_some(1),
            rounds: true,
        });
        let permanent = automaton(&mut system, t, machine, None);
        system.tasks.push(Task {
            places: 16,
            priority: None,
            affinity: None,
            name: format!("t{t}"),
            component,
            period: (t > 0).then(|| 4 + dice.below(5)),
            delay: 0,
            keep_idle_tick: false,
            permanent: Some(permanent),
            slots: Vec::new(),
            src: None,
        });
    }
    for one in 0..system.codels.len() {
        for other in 0..one {
            // Start-up codels often exclude everything, polling hardly anything.
            let likely = if one < 4 && other < 4 { 0 } else { 3 };
            let polls = one == 1 || other == 1;
            if dice.in_ten(likely) && (!polls || dice.in_ten(2)) {
                system.exclude(one.into(), other.into());
            }
        }
    }
    system
}

/// Returns the component of the next task: the last one or a new one, as tasks of a component are
/// consecutive.
fn placed(system: &mut TimedSystem, dice: &mut Dice, task: usize) -> ComponentId {
    if task == 0 || dice.in_ten(6) {
        system.components.push(Component {
            name: format!("c{}", system.components.len()),
            tasks: Vec::new(),
            services: Vec::new(),
        });
    }
    let component = ComponentId::from(system.components.len() - 1);
    system.components[component].tasks.push(TaskId::from(task));
    component
}

fn empty(dice: &mut Dice) -> TimedSystem {
    TimedSystem {
        unit: dotgen_analysis::model::Seconds::new(1, 1000),
        components: TiVec::new(),
        tasks: TiVec::new(),
        machines: TiVec::new(),
        automata: TiVec::new(),
        codels: TiVec::new(),
        services: TiVec::new(),
        clients: TiVec::new(),
        platform: Platform {
            cores: dice.pick(&[None, Some(1), Some(2), Some(2), Some(3)]),
            policy: Policy::Fifo,
            semantics: Semantics::PUBLISHED,
            async_free: false,
            aperiodic_core: dice.in_ten(7),
        },
    }
}

fn automaton(
    system: &mut TimedSystem,
    task: usize,
    machine: MachineId,
    service: Option<ServiceId>,
) -> AutomatonId {
    system.automata.push_and_get_key(Automaton { task: TaskId::from(task), machine, service })
}

fn codel(
    system: &mut TimedSystem,
    dice: &mut Dice,
    component: ComponentId,
    path: String,
) -> CodelId {
    let upper = dice.below(4);
    let lower = if dice.in_ten(5) { upper } else { dice.below(upper + 1) };
    let forever = dice.below(40) == 0;
    system.codels.push_and_get_key(Codel {
        throws: false,
        path: CodelName::of_service(&format!("c{}", usize::from(component)), &path),
        component,
        lower,
        upper: if forever { FOREVER } else { upper },
        conflicts: CodelSet::default(),
        site: None,
        src: None,
    })
}

fn machine(
    system: &mut TimedSystem,
    dice: &mut Dice,
    component: ComponentId,
    name: String,
) -> MachineId {
    let n = 1 + dice.below(3) as usize;
    let states = (0..n)
        .map(|i| {
            let codel = codel(system, dice, component, format!("{name}.s{i}"));
            let mut yields = Vec::new();
            for _ in 0..=dice.below(2) {
                let to = dice.below(n as u32) as usize;
                let end = match dice.below(4) {
                    0 => Yield::End,
                    1 if to > i || dice.in_ten(2) => Yield::Next(to),
                    _ => Yield::Pause(to),
                };
                if !yields.contains(&end) {
                    yields.push(end);
                }
            }
            State { name: format!("s{i}"), codel, yields, is_async: dice.in_ten(2) }
        })
        .collect();
    let mut machine = Machine {
        name,
        states,
        start: 0,
        stop: dice.in_ten(6).then(|| dice.below(n as u32) as usize),
        loop_limit: dice.in_ten(3).then(|| 1 + dice.below(2) as u16),
        rounds: dice.in_ten(3),
    };
    if !loop_contradictions(&machine).is_empty() {
        machine.loop_limit = None;
    }
    system.machines.push_and_get_key(machine)
}

fn service(system: &mut TimedSystem, dice: &mut Dice, v: usize) {
    let task = dice.below(system.tasks.len() as u32) as usize;
    let component = system.tasks[TaskId::from(task)].component;
    let name = format!("v{v}");
    let path = format!("c{}.{name}", usize::from(component));
    let validate =
        dice.in_ten(2).then(|| codel(system, dice, component, format!("{path}.validate")));
    let activity = dice.in_ten(7);
    let mut slots = Vec::new();
    let mut simple = Vec::new();
    if activity {
        let machine = machine(system, dice, component, path);
        for _ in 0..=dice.below(2) {
            slots.push(automaton(system, task, machine, Some(system.services.next_key())));
        }
        system.tasks[TaskId::from(task)].slots.extend(&slots);
    } else {
        for i in 0..dice.below(2) {
            simple.push(codel(system, dice, component, format!("{path}.f{i}")));
        }
    }
    let id = system.services.push_and_get_key(Service {
        after: Vec::new(),
        before: Vec::new(),
        builtin: None,
        name,
        component,
        validate,
        simple,
        slots,
        activity,
        interrupts: Vec::new(),
        src: None,
    });
    system.components[component].services.push(id);
}

fn client(system: &TimedSystem, dice: &mut Dice, k: u32) -> Client {
    let n = 1 + dice.below(4) as usize;
    let trackers = 1 + dice.below(2) as usize;
    let steps = (0..n)
        .map(|i| {
            let action = match dice.below(6) {
                0 => ClientAction::AwaitAccepted,
                1 => ClientAction::AwaitEnded(dice.below(trackers as u32) as usize),
                2 => {
                    let a = dice.below(3);
                    let b = if dice.in_ten(2) { FOREVER } else { a + dice.below(3) };
                    ClientAction::Delay(a, b)
                }
                _ => ClientAction::Send {
                    service: (dice.below(system.services.len() as u32) as usize).into(),
                    trackers: (0..trackers).filter(|_| dice.in_ten(7)).collect(),
                    accepted: Vec::new(),
                    aborts: None,
                },
            };
            let mut next = vec![i + 1];
            if dice.in_ten(2) {
                let other = dice.below(n as u32 + 1) as usize;
                if other != i + 1 {
                    next.push(other);
                }
            }
            ClientStep { action, next, label: None }
        })
        .collect();
    Client { name: format!("k{k}"), steps, first: vec![0], trackers, awaits_event: None }
}

pub(crate) fn predicate(system: &TimedSystem, dice: &mut Dice) -> Predicate {
    let atom = if dice.in_ten(5) {
        let state = dice.pick(&[
            TaskState::Idle,
            TaskState::Waiting,
            TaskState::Running,
            TaskState::Active,
        ]);
        Atom::Task(TaskId::from(dice.below(system.tasks.len() as u32) as usize), state)
    } else if system.machines.is_empty() {
        Atom::Task(TaskId::default(), TaskState::Active)
    } else {
        let machine = dice.below(system.machines.len() as u32) as usize;
        let machine = MachineId::from(machine);
        let states = system.machines[machine].states.len() as u32;
        Atom::State {
            machine,
            state: dice.below(states) as usize,
            phase: dice.pick(&[StatePhase::Lock, StatePhase::Exec, StatePhase::Any]),
        }
    };
    match dice.below(8) {
        0 => Predicate::Leave(atom),
        1 => Predicate::Not(Box::new(Predicate::Atom(atom))),
        2 => Predicate::Or(Box::new(Predicate::Atom(atom)), Box::new(predicate(system, dice))),
        _ => Predicate::Atom(atom),
    }
}
