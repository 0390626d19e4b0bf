//! Agreement of the verifier with the interpreter of the servers, on random specifications and scenarios.

use std::sync::atomic::{AtomicUsize, Ordering};

use dotgen_analysis::host::UnitResult;
use dotgen_loaders::unit;
use dotgen_timing::abstraction::{Budget, abstract_bounds};
use dotgen_timing::analytic::{meets_deadlines, response_bounds};
use dotgen_timing::explore::{Kind, Kinds, Limits};
use dotgen_timing::report::{CheckReport, Report, Soundness, Value, Verdict};
use dotgen_timing::scn::ast::{CheckKind, Path, Scenario};
use dotgen_timing::scn::names::Names;
use dotgen_timing::scn::parse;
use dotgen_timing::system::build::build;
use dotgen_timing::system::{TaskId, Ticks, TimedSystem};
use dotgen_timing::verify::{Cancel, Options, SystemInput, settings, verify};
use num_rational::Ratio;
use serde_json::{Value as Json, json};

use crate::agreement::expected::answers;
use crate::agreement::servers::chains::Chain;
use crate::agreement::servers::model::{Datum, read};
use crate::agreement::servers::random::{
    Texts, alike, chained, chained_steadily, occasional, patterned, periodic, preempted, quiet,
    requests, texts, varied,
};
use crate::agreement::servers::{CAP, Interpreter};
use crate::agreement::{all_agree, first, systems};

/// Returns the parts of an answer that are compared.
fn answer(report: &CheckReport) -> Json {
    let value = match report.value {
        Some(Value::Time(time)) if time >= f64::from(CAP) => json!("unbounded"),
        Some(Value::Time(time)) => json!(time as u32),
        Some(Value::Unbounded) => json!("unbounded"),
        None => Json::Null,
    };
    // For response times the value is compared.
    let verdict = match report.verdict {
        verdict if verdict.holds() => "proved",
        Verdict::Refuted => "refuted",
        other => return json!(format!("{other:?}: {:?}", report.note)),
    };
    if report.kind.is_time() { value } else { json!(verdict) }
}

fn compare(name: &str, texts: &Texts) -> Option<Result<(), String>> {
    let exactly = [Kind::ScheduleAbstraction].into_iter().collect();
    compare_without(name, texts, exactly)
}

/// A system, and the answers of the interpreter.
struct Answered {
    units: Vec<UnitResult>,
    scenario: Scenario,
    expected: Vec<(String, Json)>,
}

impl Answered {
    /// Returns the system of some texts. `None`: they have errors, or the system is too large.
    fn new(Texts { specifications, scenario }: &Texts) -> Option<Answered> {
        let units = specifications.iter().map(|file| unit(file));
        let units: Vec<UnitResult> = units.collect::<Result<_, _>>().ok()?;
        let specs: Vec<_> = units.iter().map(|unit| &*unit.spec).collect();
        let parsed = parse(scenario);
        assert_eq!(parsed.errors, [], "{scenario}");
        let system = read(&specs, &parsed.scenario);
        let expected = answers(&system, &parsed.scenario, 40_000)?;
        Some(Answered { units, scenario: parsed.scenario, expected })
    }

    fn input(&self) -> SystemInput<'_> {
        SystemInput { specs: self.units.iter().map(|unit| &*unit.spec).collect() }
    }

    fn system(&self, options: &Options) -> TimedSystem {
        let input = self.input();
        let names = Names::new(&input.specs);
        build(&names, &settings(&self.scenario, options), &|_| true).system
    }
}

fn verdict(name: &str, texts: &Texts, wrong: &[String]) -> Result<(), String> {
    let Texts { specifications, scenario } = texts;
    let shown = format!("{name}\n{}\n{scenario}", specifications.join("\n"));
    if wrong.is_empty() { Ok(()) } else { Err(format!("{}\n{shown}", wrong.join("\n"))) }
}

/// Compares bounds with the interpreter, without an exploration.
fn compare_bounds(name: &str, texts: &Texts) -> Option<Result<(), String>> {
    let answered = Answered::new(texts)?;
    let system = answered.system(&Options::default());
    Some(verdict(name, texts, &beyond_abstraction(&system, &answered.expected)))
}

fn compare_without(name: &str, texts: &Texts, without: Kinds) -> Option<Result<(), String>> {
    let answered = Answered::new(texts)?;
    let options = Options {
        limits: Limits {
            states: 400_000,
            bytes: 1 << 28,
            threads: 1,
            without,
            ..Limits::default()
        },
        ..Options::default()
    };
    let report = verify(&answered.input(), &answered.scenario, &options, &Cancel::default());
    if report.has_errors() {
        return Some(verdict(name, texts, &[format!("{:?}", report.diagnostics)]));
    }
    let mut wrong = beyond_abstraction(&answered.system(&options), &answered.expected);
    for (check, want) in answered.expected {
        let found = report.checks.iter().find(|report| {
            let name = format!("{} {}", report.kind, report.of);
            report.name.as_ref().map_or(name == check, |name| *name == check)
        });
        let Some(found) = found else {
            wrong.push(format!("{check} is not answered"));
            continue;
        };
        if let Some(step) = found.kept.as_ref().and_then(|run| run.impossible_step()) {
            wrong.push(format!("{check}: step {step} of its run is not possible"));
        }
        // Without execution times, or after an incomplete exploration, there is nothing to compare. Bounds
        // were compared above.
        let says_nothing = matches!(found.verdict, Verdict::Nothing | Verdict::Unknown);
        if says_nothing || found.soundness == Soundness::UpperBound {
            continue;
        }
        let want =
            if found.kind.is_time() { want["value"].clone() } else { want["verdict"].clone() };
        let got = answer(found);
        if want != got {
            wrong.push(format!("{check}: expected {want}, found {got}"));
        }
    }
    Some(verdict(name, texts, &wrong))
}

/// Reports bounds of response-time analysis and of the middle tier that some run exceeds, and bounds although
/// a deadline is missed.
fn beyond_abstraction(system: &TimedSystem, expected: &[(String, Json)]) -> Vec<String> {
    let quick = response_bounds(system, &Cancel::default());
    let few = system.platform.cores.is_some() && quick.iter().any(Option::is_some);
    QUICK_ON_CORES.fetch_add(usize::from(few), Ordering::Relaxed);
    let mut wrong = exceeded(system, ("response-time analysis", &quick.raw), expected);
    // A rare system has a large model, which would take as long as all others. It is explored each night.
    let states = if cases() < 100 { 40_000 } else { Budget::default().states };
    let small = Budget { states, ..Budget::default() };
    wrong.extend(beyond_bounds(system, small, expected));
    // With busy windows from the start.
    let batches = Budget { before_coarse: 0, ..small };
    wrong.extend(beyond_bounds(system, batches, expected));
    // With a coarser model from the start.
    let coarse = Budget { batches: false, ..batches };
    wrong.extend(beyond_bounds(system, coarse, expected));
    wrong
}

fn beyond_bounds(system: &TimedSystem, budget: Budget, expected: &[(String, Json)]) -> Vec<String> {
    let bounds = abstract_bounds(system, budget, &Cancel::default());
    if bounds.iter().all(Result::is_err) {
        return Vec::new();
    }
    ABSTRACTED.fetch_add(1, Ordering::Relaxed);
    let aperiodic = system.tasks.iter().any(|task| task.period.is_none());
    if aperiodic || system.requested().contains(&true) {
        AT_ANY_TIME.fetch_add(1, Ordering::Relaxed);
    }
    let late = |tasks: &[TaskId]| {
        let has_period = |&&task: &&TaskId| system.tasks[task].period.is_some();
        let first = tasks.iter().position(|task| !has_period(&task));
        first.is_some_and(|at| tasks[at..].iter().any(|task| bounds[*task].is_ok()))
    };
    let late = system.components.iter().any(|component| late(&component.tasks));
    LATE.fetch_add(usize::from(late), Ordering::Relaxed);
    let mut tasks = system.tasks.iter().zip(&bounds);
    let open = tasks.any(|task| task.0.period.is_some() && task.1.is_err());
    OPEN.fetch_add(usize::from(open), Ordering::Relaxed);
    let bounds: Vec<Option<Ticks>> = bounds.into_iter().map(Result::ok).collect();
    exceeded(system, ("the middle tier", &bounds), expected)
}

/// Reports the bounds of a method that some run exceeds, and bounds that prove a deadline although it is
/// missed.
fn exceeded(
    system: &TimedSystem,
    (method, bounds): (&str, &[Option<Ticks>]),
    expected: &[(String, Json)],
) -> Vec<String> {
    let answer = |kind: &str, task: usize, what: &str| {
        let of = format!("{kind} {}", system.task_path(TaskId::from(task)));
        let expected = expected.iter().find(|entry| entry.0 == of);
        expected.map_or(Json::Null, |(_, json)| json[what].clone())
    };
    let mut wrong = Vec::new();
    for (task, bound) in bounds.iter().enumerate() {
        let Some(ticks) = *bound else {
            continue;
        };
        let unit = system.unit * Ratio::from_integer(1000);
        let bound = unit * Ratio::from_integer(i128::from(ticks));
        let kept = match answer("response", task, "value") {
            Json::Number(number) => number
                .as_i64()
                .is_some_and(|number| Ratio::from_integer(i128::from(number)) <= bound),
            answer => answer.is_null(),
        };
        if !kept {
            wrong.push(format!(
                "response of {task}: {}, {method} says {bound}",
                answer("response", task, "value")
            ));
        }
        if answer("response", task, "value") == json!(to_integer(bound)) {
            REACHED.fetch_add(1, Ordering::Relaxed);
        }
        let meets = meets_deadlines(system, TaskId::from(task), Some(ticks));
        for kind in ["schedulable", "no-overdue"].into_iter().filter(|_| meets) {
            if answer(kind, task, "verdict") == json!("refuted") {
                wrong.push(format!("{kind} of {task} fails, proved by {method}"));
            }
        }
    }
    wrong
}

fn to_integer(ratio: Ratio<i128>) -> i64 {
    i64::try_from(ratio.to_integer()).unwrap_or(-1)
}

/// Number of systems for which the middle tier has bounds.
static ABSTRACTED: AtomicUsize = AtomicUsize::new(0);

/// Number of systems with a number of cores and bounds of response-time analysis.
static QUICK_ON_CORES: AtomicUsize = AtomicUsize::new(0);

/// Number of systems with events at any time: requests, or codels of tasks without a period.
static AT_ANY_TIME: AtomicUsize = AtomicUsize::new(0);

/// Number of systems with a bound for a task that is declared after a task without a period.
static LATE: AtomicUsize = AtomicUsize::new(0);

/// Number of systems with bounds for some tasks only.
static OPEN: AtomicUsize = AtomicUsize::new(0);

/// Number of bounds that are the exact values.
static REACHED: AtomicUsize = AtomicUsize::new(0);

#[test]
fn patterns_agree_with_the_interpreter_of_the_servers() {
    all_agree(first(), cases(), 3, |seed| {
        let mut dice = systems::Dice::new(seed);
        compare(&format!("seed {seed}"), &patterned(&mut dice))
    });
}

#[test]
fn the_middle_tier_is_never_below_the_interpreter_of_the_servers() {
    all_agree(first(), cases(), 3, |seed| {
        let texts = periodic(&mut systems::Dice::new(seed));
        // Answers with and without the middle tier are compared.
        if seed.is_multiple_of(2) {
            compare(&format!("seed {seed}"), &texts)
        } else {
            compare_without(&format!("seed {seed}"), &texts, Kinds::NONE)
        }
    });
    let (abstracted, reached) =
        (ABSTRACTED.load(Ordering::Relaxed), REACHED.load(Ordering::Relaxed));
    eprintln!("{abstracted} systems have bounds, {reached} of which are reached");
    assert!(abstracted as u64 >= cases() / 5, "bounds are compared");
}

#[test]
fn the_middle_tier_is_never_below_the_interpreter_on_what_comes_at_any_time() {
    all_agree(first(), cases(), 3, |seed| {
        let texts = occasional(&mut systems::Dice::new(seed));
        compare_without(&format!("seed {seed}"), &texts, Kinds::NONE)
    });
    let [bounded, late, open] =
        [&AT_ANY_TIME, &LATE, &OPEN].map(|counter| counter.load(Ordering::Relaxed));
    eprintln!("{bounded} systems with requests or tasks without period have bounds");
    eprintln!("{late} for a task declared after one without, {open} for some tasks only");
    assert!(bounded as u64 >= cases() / 5, "bounds are compared");
    assert!(late as u64 >= cases() / 20, "bounds are compared");
}

/// Returns the number of systems. The interpreter of the servers needs a fifth of a second for each.
fn cases() -> u64 {
    dotgen_loaders::times(20)
}

#[test]
fn the_verifier_agrees_with_the_interpreter_of_the_servers() {
    all_agree(first(), cases(), 2, |seed| {
        compare(&format!("seed {seed}"), &texts(&mut systems::Dice::new(seed)))
    });
}

#[test]
fn the_verifier_agrees_with_the_interpreter_of_the_servers_on_every_point() {
    all_agree(first(), cases(), 3, |seed| {
        let texts = varied(&mut systems::Dice::new(seed));
        compare(&format!("seed {seed}"), &texts)
    });
}

#[test]
fn the_verifier_agrees_with_the_interpreter_of_the_servers_on_aborts_kills_and_outcomes() {
    all_agree(first(), cases(), 3, |seed| {
        let texts = requests(&mut systems::Dice::new(seed));
        compare(&format!("seed {seed}"), &texts)
    });
}

#[test]
fn the_verifier_agrees_with_the_interpreter_of_the_servers_on_equal_parts() {
    all_agree(first(), cases() / 2, 6, |seed| {
        let texts = alike(&mut systems::Dice::new(seed));
        compare(&format!("seed {seed}"), &texts)
    });
}

/// The first job of a task is not measured. Its end, after a tick was kept, ends a repetition.
#[test]
fn no_repetition_leads_across_the_end_of_the_first_job() {
    let texts = alike(&mut systems::Dice::new(90_212));
    assert_eq!(compare("seed 90212", &texts), Some(Ok(())));
}

#[test]
fn the_verifier_agrees_with_the_interpreter_of_the_servers_on_cores_given_in_order() {
    all_agree(first(), cases(), 3, |seed| {
        compare(&format!("seed {seed}"), &quiet(&mut systems::Dice::new(seed)))
    });
    let bounded = QUICK_ON_CORES.load(Ordering::Relaxed);
    eprintln!("{bounded} systems with a number of cores have bounds of response-time analysis");
    assert!(bounded as u64 >= cases() / 20, "bounds are compared");
}

#[test]
fn bounds_under_preemption_are_never_below_the_interpreter_of_the_servers() {
    all_agree(first(), 10 * cases(), 3, |seed| {
        compare_bounds(&format!("seed {seed}"), &preempted(&mut systems::Dice::new(seed)))
    });
}

/// Bounds are quick to compare, so there are more systems than explorations: the faults that random systems
/// have found so far came once in a hundred.
#[test]
fn bounds_are_never_below_the_interpreter_of_the_servers() {
    all_agree(first(), 10 * cases(), 3, |seed| {
        let mut dice = systems::Dice::new(seed);
        let texts = match seed % 4 {
            0 => texts(&mut dice),
            1 => quiet(&mut dice),
            2 => periodic(&mut dice),
            _ => occasional(&mut dice),
        };
        compare_bounds(&format!("seed {seed}"), &texts)
    });
}

/// Compares reaction time and age of chains. Returns `None` if no data flow.
fn compare_chains(seed: u64) -> Option<Result<(), String>> {
    let mut dice = systems::Dice::new(seed);
    // Many have errors, or no path for the data.
    let steadily = seed.is_multiple_of(2);
    (0..3).find_map(|_| {
        let texts = if steadily { chained_steadily(&mut dice) } else { chained(&mut dice) };
        compare_chain(seed, &texts)
    })
}

fn compare_chain(seed: u64, texts: &Texts) -> Option<Result<(), String>> {
    let shown = || format!("seed {seed}\n{}\n{}", texts.specifications.join("\n"), texts.scenario);
    let units = texts.specifications.iter().map(|file| unit(file));
    let units: Vec<UnitResult> = units.collect::<Result<_, _>>().ok()?;
    let specs: Vec<_> = units.iter().map(|unit| &*unit.spec).collect();
    let parsed = parse(&texts.scenario);
    let system = read(&specs, &parsed.scenario);
    let options = Options {
        limits: Limits { states: 400_000, bytes: 1 << 28, threads: 1, ..Limits::default() },
        ..Options::default()
    };
    let report = verify(&SystemInput { specs }, &parsed.scenario, &options, &Cancel::default());
    if report.diagnostics.iter().any(|diagnostic| diagnostic.code == "scn-no-way") {
        return None;
    }
    if report.has_errors() || !parsed.errors.is_empty() {
        return Some(Err(format!("{:?}: {}", report.diagnostics, shown())));
    }
    // Bounds of analysis alone.
    let none = Options { limits: Limits { states: 1, ..options.limits }, ..options };
    let input = SystemInput { specs: units.iter().map(|unit| &*unit.spec).collect() };
    let quick = verify(&input, &parsed.scenario, &none, &Cancel::default());
    let interpreter = Interpreter::new(&system, &[], &[]);
    let checks = parsed.scenario.checks().map(|check| &check.kind);
    for (check, found) in checks.zip(&report.checks) {
        let CheckKind::Chain(kind, path, _) = check else {
            continue;
        };
        let datum = |path: &Path| {
            let text = path.text();
            let (component, port) = text.split_once('.').expect("a port");
            let alone = texts.specifications.len() == 1;
            let component = if port == "q" && !alone { "d" } else { component };
            Datum::Port(component.to_owned(), port.to_owned())
        };
        let first = datum(&path.from);
        let chain = Chain {
            kind: *kind,
            external: first == Datum::Port("c".to_owned(), "q".to_owned()),
            first,
            last: datum(&path.to),
        };
        let expected = interpreter.chain(&chain, 15_000)?;
        if found.verdict == Verdict::Unknown {
            return None;
        }
        if let Some(wrong) = below(&quick, found, expected) {
            return Some(Err(format!("{wrong}: {}", shown())));
        }
        let want = match expected {
            Some(CAP) => json!("unbounded"),
            Some(interpreter) => json!(interpreter),
            None => Json::Null,
        };
        let got = match found.verdict {
            Verdict::Nothing => Json::Null,
            _ => answer(found),
        };
        if want != got {
            let what = format!("{} {}", found.kind, found.of);
            return Some(Err(format!("{what}: expected {want}, found {got}: {}", shown())));
        }
    }
    Some(Ok(()))
}

/// Reports a bound of analysis below the exact value.
fn below(quick: &Report, check: &CheckReport, expected: Option<u32>) -> Option<String> {
    let bound = quick.checks.iter().find(|report| report.id == check.id)?;
    let Some(Value::Time(time)) = bound.value.filter(|_| bound.soundness == Soundness::UpperBound)
    else {
        return None;
    };
    BOUNDS.fetch_add(1, Ordering::Relaxed);
    let expected = f64::from(expected.unwrap_or(0));
    (time < expected).then(|| format!("{} {}: {time} is below {expected}", check.kind, check.of))
}

/// Number of bounds on chains that were compared.
static BOUNDS: AtomicUsize = AtomicUsize::new(0);

#[test]
fn the_verifier_agrees_with_the_interpreter_of_the_servers_on_chains() {
    let cases = 2 * cases();
    all_agree(first(), cases, 50, compare_chains);
    let bounds = BOUNDS.load(Ordering::Relaxed);
    assert!(bounds >= cases as usize / 50, "bounds are compared: {bounds}");
}

fn agree_on(specification: &str, scenario: &str) {
    let texts = Texts {
        specifications: vec![specification.to_owned()],
        scenario: format!("scenario s {{ semantics servers; unit 1 ms; {scenario} }}"),
    };
    match compare("one system", &texts) {
        Some(Ok(())) => {}
        other => panic!("{other:?}"),
    }
}

/// A task without work inserts nothing into a queue: a request may be handled before its wake-up is consumed,
/// and so be served in the same cycle.
#[test]
fn a_request_may_come_before_a_wake_up_is_consumed() {
    agree_on(
        "component c {
           version \"1\"; lang \"c\";
           task t0 { period 8 ms; codel<start> a() yield x wcet 1 ms; codel<x> b() yield pause::x wcet 1 ms; };
           task t1 { period 3 ms; };
           activity s() { task t1; codel<start> d() yield pause::start wcet 2 ms; };
         };",
        "cores 1; policy fifo; durations fixed;
         client k { delay 5 ms; send c.s; }
         check schedulable *; check response *;
         check r: within c.s.waiting => c.s.run;",
    );
}

/// A core is held until its thread has made the wake-ups that follow the last pass. `a` wakes `w` as `a`
/// ends. So `w` asks for the core before it is free, and may get it before `x`, which has waited for longer.
#[test]
fn a_task_that_is_woken_asks_for_a_core_before_it_is_free() {
    let specification = "component c {
           version \"1\"; lang \"c\";
           task w { codel<start> w() yield pause::start wcet 2 ms; };
           task a { period 10 ms; codel<start> a() yield ether wcet 3 ms; };
         };
         component d {
           version \"1\"; lang \"c\";
           task x { period 10 ms; delay 1 ms; codel<start> x() yield pause::start wcet 1 ms; };
         };";
    for (policy, value) in [("fifo", 3), ("edf", 3), ("any", 5)] {
        let longest = format!("cores 1; policy {policy}; durations fixed; check response *;");
        agree_on(specification, &longest);
        let unit = unit(specification).expect("it has no errors");
        let parsed = parse(&format!("scenario s {{ semantics servers; {longest} }}"));
        let input = SystemInput { specs: vec![&unit.spec] };
        let (options, cancel) = (Options::default(), Cancel::default());
        let report = verify(&input, &parsed.scenario, &options, &cancel);
        let of_x = report.checks.iter().find(|check| check.of == "d.x");
        let found = of_x.and_then(|check| check.value);
        assert_eq!(found, Some(Value::Time(f64::from(value))), "{policy}");
    }
}

/// The slot of a permanent activity that has ended is free when the control task has handled its end.
#[test]
fn a_request_may_come_before_the_end_of_the_permanent_activity_is_handled() {
    agree_on(
        "component c {
           version \"1\"; lang \"c\";
           task t { period 6 ms; };
           activity s() { task t; codel<start> a() yield ether wcet 1 ms; };
         };",
        "cores free; durations fixed; slots c.t 1;
         client k { send c.s; await ended; delay [7, 10] ms; send c.s; }
         check schedulable *; check response *;
         check w: within not c.s.run => c.s.run;",
    );
}

/// Ticks that come while a ready task has no core are missed deadlines, although its cycle has not begun.
#[test]
fn a_tick_while_a_task_waits_for_its_first_core_is_a_miss() {
    agree_on(
        "component c {
           version \"1\"; lang \"c\";
           task hi { period 20 ms; priority 1; codel<start> a() yield pause::start wcet 12 ms; };
           task lo { period 5 ms; delay 1 ms; priority 9; codel<start> b() yield pause::start wcet 1 ms; };
         };",
        "cores 1; policy priority; durations fixed;
         check schedulable *; check no-overdue *; check response *;",
    );
}

/// Tasks bound to one core share it, however many cores there are.
#[test]
fn tasks_tied_to_one_core_wait_for_each_other_whatever_the_number_of_cores() {
    agree_on(
        "component c {
           version \"1\"; lang \"c\";
           task hi { period 20 ms; priority 1; codel<start> a() yield pause::start wcet 12 ms; };
           task lo { period 5 ms; priority 9; codel<start> b() yield pause::start wcet 1 ms; };
         };",
        "cores 4; policy priority; durations fixed; affinity c.hi 1; affinity c.lo 1;
         check schedulable *; check no-overdue *; check response *;",
    );
}

/// A component whose permanent activity throws in its first pass takes no requests, even after later ticks.
#[test]
fn a_component_does_not_start_when_a_permanent_activity_throws_in_its_first_pass() {
    agree_on(
        "component c {
           version \"1\"; lang \"c\"; exception bad;
           task t { period 6 ms; throw bad; codel<start> a() yield ether wcet 1 ms; };
           activity s() { task t; codel<start> d() yield ether wcet 2 ms; };
         };",
        "cores free; durations fixed;
         client k { delay 9 ms; send c.s; }
         check schedulable *; check response *;
         check w: within c.t.start.exec => c.s.run;",
    );
}
