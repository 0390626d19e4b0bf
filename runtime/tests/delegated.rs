//! Threads that execute cycles by themselves, on random systems: what they do is a run of the model, codels
//! that exclude each other never overlap, and nothing is lost. The hosts are simulated, with delays of every
//! message.

use std::cell::Cell;

use dotgen_runtime::decide::Durations;
use dotgen_runtime::engine::End;
use dotgen_runtime::live::{HostedComponent, HostedComponents, Live};
use dotgen_runtime::profile::Profile;
use dotgen_runtime::real_clock::Pace;
use dotgen_runtime::refine;
use dotgen_runtime::simulation::{Execution, Plan, Record, simulate_recorded};
use dotgen_runtime::watch::PortUpdate;
use dotgen_timing::explore::{Action, Stepper};
use dotgen_timing::scn::names::Names;
use dotgen_timing::scn::parse;
use dotgen_timing::system::{CodelId, ComponentId};
use dotgen_timing::verify::{Options, Prepared, SystemInput, prepare, settings};
use num_rational::Ratio;

use crate::random_systems::{load, random, systems::Dice};
use crate::replayed::{Recording, replay};
use crate::simulated_hosts::{MS, Simulated};

/// Duration of a run, in nanoseconds.
const RUN_NANOS: u64 = 600_000_000;

/// Counts the ends of executed codels.
struct Ends<'s> {
    recording: Recording<'s>,
    parts: &'s HostedComponents<'s>,
    ended: u64,
}

impl Record for Ends<'_> {
    fn on_action(&mut self, stepper: &Stepper, action: Action, executed: Option<u64>) {
        if let Action::Finish { executor, .. } = action {
            let codel = stepper.work(executor).and_then(|work| work.codel());
            let real = codel.is_some_and(|codel| self.parts.codel(codel).is_some());
            self.ended += u64::from(real);
        }
        self.recording.on_action(stepper, action, executed);
    }

    fn interrupt(&mut self, stepper: &Stepper, place: usize) {
        self.recording.interrupt(stepper, place);
    }

    fn on_ending(&mut self, stepper: &Stepper) {
        self.recording.on_ending(stepper);
    }

    fn on_port_update(&mut self, _: &Stepper, _: &PortUpdate) {}

    fn end(&mut self, stepper: &Stepper) {
        self.recording.end(stepper);
    }
}

/// Counts of a run.
#[derive(Debug, Default)]
struct Shown {
    executed: u64,
    delegated: u64,
    answered: usize,
    requests: u64,
    replied: u64,
    lost: usize,
}

/// Runs a random system; `None` if it is not legal.
fn run_random(seed: u64) -> Option<Shown> {
    let mut dice = Dice::new(seed);
    let texts = match seed % 3 {
        0 => random::periodic(&mut dice),
        1 => random::texts(&mut dice),
        _ => random::varied(&mut dice),
    };
    run(seed, &texts, &mut dice, &|_| ())
}

/// Runs a system whose hosts are changed by `prepare_hosts`; `None` if it is not legal.
fn run(
    seed: u64,
    texts: &random::Texts,
    dice: &mut Dice,
    prepare_hosts: &dyn Fn(&mut Simulated<'_>),
) -> Option<Shown> {
    let units = load(&texts.specifications)?;
    let mut scenario = texts.scenario.clone();
    if seed % 4 == 1 {
        scenario = scenario.replace("semantics servers;", "semantics published;");
    }
    for cores in 1..=4 {
        scenario = scenario.replace(&format!("cores {cores};"), "cores free;");
    }
    let scenario = parse(&scenario).scenario;
    let specs: Vec<_> = units.iter().map(|unit| &*unit.spec).collect();
    let names = Names::new(&specs);
    let options = Options::default();
    let prepared = prepare(&SystemInput { specs: specs.clone() }, &scenario, &options);
    if prepared.report.has_errors() {
        return None;
    }
    let settings = settings(&scenario, &options);
    let hosted = names.components.iter().map(|&member| {
        // Some codels are simulated.
        let codels = member.component.all_codels();
        let codels = codels.map(|codel| member.component.codel(codel).name.clone());
        let missing = codels.filter(|_| seed.is_multiple_of(6) && dice.in_ten(3));
        Some(HostedComponent { member, missing: missing.collect() })
    });
    let no_inputs = |_: &str| None;
    let parts = HostedComponents::new(&prepared, &names, &settings, hosted.collect(), &no_inputs);
    let mut opened: Prepared = prepared.clone();
    let is_real = |codel: CodelId| parts.codel(codel).is_some();
    refine::open(&mut opened, &is_real);
    refine::scale(&mut opened);
    refine::release(&mut opened, &is_real);
    if !seed.is_multiple_of(5) {
        opened.built.system.clients.clear();
    }
    let first = refine::add_outside(&mut opened);
    let parts = parts.with_outside(first);
    let system = &opened.built.system;
    let nanos = (system.unit * Ratio::from_integer(1_000_000_000)).to_integer() as u64;
    let mut hosts = Simulated::new(system, &parts, seed);
    prepare_hosts(&mut hosts);
    let last = ComponentId::from(system.components.len() - 1);
    let loses = seed % 7 == 3;
    let stops = seed % 7 == 4;
    if loses {
        hosts.lose(last, 300 * MS + u64::from(dice.below(20_000_000)));
    }
    if stops {
        hosts.stop(last, 300 * MS + u64::from(dice.below(20_000_000)));
    }
    // Some runs are interrupted.
    let polls = Cell::new(0);
    let interrupt_after = match seed % 3 {
        1 => dice.below(2_000),
        _ => u32::MAX,
    };
    let interrupted = || {
        polls.set(polls.get() + 1);
        polls.get() > interrupt_after
    };
    let mut live = Live::new(system, &parts, &mut hosts, false, false);
    let execution =
        Execution { live: &mut live, pace: Some(Pace { nanos }), follow: None, violated: None };
    let plan = Plan {
        until: RUN_NANOS / nanos,
        runs: 1,
        seed,
        durations: Durations::Random,
        weights: None,
        stop_at_violation: false,
        record: false,
    };
    let mut recording = Ends { recording: Recording::new(system), parts: &parts, ended: 0 };
    let none: Option<&mut Profile<Vec<u8>>> = None;
    let outcome = simulate_recorded(
        &opened,
        vec![None; system.tasks.len()],
        &plan,
        none,
        Some(&mut recording),
        Some(execution),
        &interrupted,
    );
    let shown = || format!("seed {seed}\n{}\n{}", texts.specifications.join("\n"), texts.scenario);
    if outcome.end == End::Standstill {
        return None;
    }
    let end = outcome.end;
    assert!(matches!(end, End::Done | End::Interrupted), "{end:?}\n{}", shown());
    assert!(end == End::Done || polls.get() > interrupt_after, "{}", shown());
    // However a run ends, all its components execute their `stop` codels.
    let in_order = outcome.unfinished.is_empty();
    assert!(in_order || loses || stops, "{:?}\n{}", outcome.unfinished, shown());
    let until = 7 * MS + nanos * outcome.time;
    drop(outcome);
    let planned = ["was planned to be lost", "did not answer within 2 s"];
    let expected: &[&str] = match (loses, stops) {
        (true, _) if end == End::Done || !hosts.lost.is_empty() => &planned[..1],
        // A process that stands still is noticed if the engine waits for it.
        (_, true) if !hosts.lost.is_empty() => &planned[1..],
        _ => &[],
    };
    assert_eq!(hosts.lost, expected, "{}", shown());
    let ended = recording.ended;
    let recording = recording.recording;
    let report = replay(system, &recording.steps, recording.end);
    assert_eq!(report.difference_count, 0, "{:#?}\n{}", report.differences.first(), shown());
    let (executed, delegated) = (hosts.executed, hosts.delegated);
    // The codels of a lost component are simulated.
    let whole = !loses && !stops;
    assert!(ended <= executed || !whole, "{ended} of {executed}\n{}", shown());
    // The model follows within some messages, or periods after a recall.
    let until = until.saturating_sub(60 * MS);
    let old = hosts.ends.iter().filter(|&&end| end < until).count() as u64;
    assert!(ended >= old || !whole, "{ended} of {old}\n{}", shown());
    // The engine waits instead of asking for the time again and again.
    let events = hosts.received + recording.steps.len() as u64 + RUN_NANOS / MS;
    assert!(hosts.waits < 4 * events, "{} of {events}\n{}", hosts.waits, shown());
    let answered = hosts.answered.borrow().len();
    Some(Shown {
        executed,
        delegated,
        answered,
        // Not all that were planned come before an interruption.
        requests: if end == End::Done { hosts.requests } else { hosts.replied.len() as u64 },
        replied: hosts.replied.len() as u64,
        lost: hosts.lost.len(),
    })
}

/// Returns the least number of systems.
fn systems_to_run() -> u64 {
    dotgen_loaders::times(25)
}

#[test]
fn cycles_without_the_engine_are_runs_of_the_model() {
    let (mut all, mut runs, mut seed) = (Shown::default(), 0, 0);
    while runs < systems_to_run() {
        assert!(seed < 20 * systems_to_run() + 100, "few systems are legal");
        if let Some(shown) = run_random(seed) {
            runs += 1;
            all.executed += shown.executed;
            all.delegated += shown.delegated;
            all.answered += shown.answered;
            all.requests += shown.requests;
            all.replied += shown.replied;
            all.lost += shown.lost;
        }
        seed += 1;
    }
    println!("{all:?} of {runs} random systems");
    assert!(all.delegated * 8 > all.executed, "{all:?}");
    assert!(all.answered as u64 > runs, "{all:?}");
    assert!(all.replied * 20 > all.requests * 19, "{all:?}");
}

#[test]
fn a_thread_does_not_run_ahead_of_a_task_that_waits_for_locks() {
    // In the queue for locks, `fast` waits behind `set`, which waits for `slow`.
    let specification = "component c {
       version \"1\"; lang \"c\"; ids { long f; long g; };
       task fast { period 1 ms; codel<start> fast_start(inout f) yield pause::start; };
       task slow { period 200 ms; codel<start> slow_start(inout g) yield pause::start; };
       function other() { codel read_f(in f); };
       function set() { codel set_g(inout g); };
     };";
    let scenario = "scenario s { semantics servers; unit 1 ms; cores free; check response *; }";
    let texts = random::Texts {
        specifications: vec![specification.to_owned()],
        scenario: scenario.to_owned(),
    };
    let seed = 2;
    let shown = run(seed, &texts, &mut Dice::new(seed), &|hosts| {
        hosts.fix("c.slow.start", 150 * MS);
        hosts.only_request("set", 430 * MS);
    });
    let shown = shown.expect("it is legal");
    assert!(shown.delegated > 100, "{shown:?}");
}
