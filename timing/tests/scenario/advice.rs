//! Advice: every change is made in the text and verified again, and the next smaller change is not enough.

use std::sync::Mutex;
use std::time::Duration;

use dotgen_timing::advice::{Change, Repairs, remedy, repairs};
use dotgen_timing::derive::{InterimResult, Quantity, sensitivity};
use dotgen_timing::report::{Report, Verdict};
use dotgen_timing::scn::ast::Policy;
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

use crate::scenario::load;

/// `control` needs `level`, which `tell` keeps for 8 ms of its 10.
const LIFT: &str = "component lift { version \"1\"; lang \"c\"; ids { long level; };
  task control { period 10 ms; codel<start> steer(inout level) yield pause::start wcet 3 ms; };
  task report { period 20 ms; codel<start> tell(in level) yield pause::start wcet 8 ms; };
  activity mend() { task report; codel<start> mend_start() yield ether wcet 9 ms; };
};";

fn scenario(items: &str) -> String {
    let semantics = if items.contains("semantics") { "" } else { "semantics published;" };
    format!("scenario s {{ {semantics} {items} check schedulable *; }}")
}

fn with<T>(
    specification: &str,
    scenario: &str,
    ask: impl Fn(&SystemInput, &dotgen_timing::scn::ast::Scenario) -> T,
) -> T {
    let unit = load(specification);
    let parsed = parse(scenario);
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    ask(&input, &parsed.scenario)
}

fn report(specification: &str, scenario: &str) -> Report {
    report_within(specification, scenario, &Options::default())
}

fn report_within(specification: &str, scenario: &str, options: &Options) -> Report {
    with(specification, scenario, |input, scenario| {
        verify(input, scenario, options, &Cancel::default())
    })
}

/// Returns the repairs, and the order in which they were reported.
fn found(specification: &str, scenario: &str) -> (Repairs, Vec<Change>) {
    let report = report(specification, scenario);
    with(specification, scenario, |input, scenario| {
        let told = Mutex::new(Vec::new());
        let tell = |change: &Change| told.lock().unwrap().push(change.clone());
        let (options, cancel) = (Options::default(), Cancel::default());
        let until = (&cancel, None);
        let found = repairs(input, scenario, &options, &report, until, (&|_| {}, &tell));
        (found, told.into_inner().unwrap())
    })
}

fn holds(specification: &str, scenario: &str) -> bool {
    let report = report(specification, scenario);
    assert!(!report.has_errors(), "{:?}", report.diagnostics);
    report.checks.iter().all(|check| check.verdict == Verdict::Proved)
}

/// Returns the specification and the scenario with a change made in their texts. A copy replaces the shared
/// data.
fn made(change: &Change, specification: &str, scenario: &str, by: f64) -> (String, String) {
    let (mut specification, mut scenario) = (specification.to_owned(), scenario.to_owned());
    let ms = |number: f64| format!("{} us", ((number + by) * 1000.0).round());
    let replace = |text: &mut String, near: &str, old: String, new: String| {
        let from = text.find(near).expect(near);
        let at = from + text[from..].find(&old).expect(&old);
        text.replace_range(at..at + old.len(), &new);
    };
    let name = |path: &str| path.split('.').nth(1).expect("a name").to_owned();
    match change {
        Change::Wcet { codel, now, at_most, .. } => replace(
            &mut specification,
            &name(codel),
            format!("wcet {now} ms"),
            format!("wcet {}", ms(*at_most)),
        ),
        Change::Period { task, now, needed, .. } => replace(
            &mut specification,
            &name(task),
            format!("period {now} ms"),
            format!("period {}", ms(*needed)),
        ),
        Change::Delay { task, needed, .. } => replace(
            &mut specification,
            &name(task),
            "ms;".to_owned(),
            format!("ms; delay {};", ms(*needed)),
        ),
        Change::Lock { .. } => {
            specification = specification.replace("(in level)", "()");
        }
        Change::Cores { now, needed } => {
            scenario = scenario.replace(&format!("cores {now}"), &format!("cores {needed}"));
        }
        Change::Policy { now, needed } => {
            let (now, needed) = (now.name(), needed.name());
            scenario = scenario.replace(&format!("policy {now}"), &format!("policy {needed}"));
        }
    }
    (specification, scenario)
}

#[test]
fn what_repairs_is_found_verified_and_no_larger_than_needed() {
    // The obstacle is a lock; a core; an order.
    let apart = LIFT.replace("(in level)", "()");
    let systems = [
        (LIFT, "cores 2; policy fifo;", "lock"),
        (&apart, "cores 1; policy fifo;", "cores"),
        (&apart, "semantics servers; cores 1; policy fifo;", "policy"),
    ];
    for (specification, items, expected) in systems {
        let scenario = scenario(items);
        assert!(!holds(specification, &scenario));
        let (found, mut told) = found(specification, &scenario);
        assert!(!found.incomplete);
        let kind = |change: &Change| serde_json::to_value(change).unwrap()["change"].clone();
        let kinds: Vec<_> = found.changes.iter().map(kind).collect();
        assert!(kinds.contains(&expected.into()), "{expected}: {kinds:?}");
        assert!(kinds.contains(&"wcet".into()), "{kinds:?}");
        for change in &found.changes {
            let (specification, scenario) = made(change, specification, &scenario, 0.0);
            assert!(holds(&specification, &scenario), "{change:?}");
        }
        let sizes: Vec<_> = found.changes.iter().map(Change::size).collect();
        assert!(sizes.is_sorted(), "{sizes:?}");
        for change in &found.changes {
            let at = told.iter().position(|told| told == change);
            told.remove(at.expect("told"));
        }
        assert_eq!(told, []);
    }
}

#[test]
fn a_longest_time_is_the_longest() {
    let scenario = scenario("cores 2; policy fifo; unit 1 ms;");
    let (found, _) = found(LIFT, &scenario);
    let times: Vec<&Change> =
        found.changes.iter().filter(|change| matches!(change, Change::Wcet { .. })).collect();
    assert!(!times.is_empty());
    for time in times {
        let (specification, scenario) = made(time, LIFT, &scenario, 1.0);
        assert!(!holds(&specification, &scenario), "{time:?}");
    }
}

#[test]
fn what_holds_needs_no_repair_and_without_patience_nothing_is_tried() {
    let fine = LIFT.replace("8 ms", "1 ms");
    let scenario = scenario("cores 2; policy fifo;");
    assert_eq!(found(&fine, &scenario).0, Repairs::default());
    let report = report(LIFT, &scenario);
    with(LIFT, &scenario, |input, scenario| {
        let cancel = Cancel::default();
        let until = (&cancel, Some(Duration::ZERO));
        let options = Options::default();
        let found = repairs(
            input,
            scenario,
            &options,
            &report,
            until,
            (&|_| {}, &|change| panic!("{change:?}")),
        );
        assert_eq!(found.changes, []);
        assert!(found.incomplete);
    });
}

/// A change must repair all failures, not only the nearest one.
#[test]
fn a_change_that_repairs_one_of_two_tasks_is_none() {
    let two = LIFT.replace(
        "activity mend",
        "task hopeless { period 5 ms; codel<start> h() yield pause::start wcet 6 ms; }; activity mend",
    );
    let (found, _) = found(&two, &scenario("cores 3; policy fifo;"));
    assert_eq!(found.changes, []);
}

#[test]
fn a_policy_under_which_no_job_is_released_any_more_is_no_repair() {
    // `hi` waits for `lo`, and `lo` for `mid`. With a policy that does not preempt, `poll` keeps the core.
    let late = r#"component late { version "1"; lang "c"; ids { long x; };
      task poll { priority 9; codel<start> listen() yield start wcet 1 ms; };
      task hi { period 10 ms; priority 1; codel<start> a(inout x) yield pause::start wcet 1 ms; };
      task lo { period 60 ms; priority 8; codel<start> b(inout x) yield pause::start wcet 2 ms; };
      task mid { period 20 ms; priority 2; codel<start> c() yield pause::start wcet 9 ms; };
    };"#;
    let of = |policy: &str| scenario(&format!("semantics servers; cores 1; policy {policy};"));
    let verdicts = |policy: &str| -> Vec<Verdict> {
        report(late, &of(policy)).checks.iter().map(|check| check.verdict).collect()
    };
    assert!(verdicts("priority").contains(&Verdict::Refuted));
    assert!(verdicts("fifo").contains(&Verdict::Vacuous));
    let (found, _) = found(late, &of("priority"));
    let is_policy = |change: &Change| matches!(change, Change::Policy { .. });
    assert!(!found.changes.iter().any(is_policy), "{:?}", found.changes);
}

#[test]
fn limits_come_by_use_without_what_nobody_asks_for_and_say_what_breaks_first() {
    let fine = LIFT.replace("wcet 8 ms", "wcet 4 ms");
    let asked = |items: &str| {
        with(&fine, &scenario(items), |input, scenario| {
            let told = Mutex::new(Vec::new());
            let tell = |interim_result: InterimResult| {
                told.lock().unwrap().extend(match interim_result {
                    InterimResult::Asking(_) => None,
                    InterimResult::Cores(_) => Some("cores".to_owned()),
                    InterimResult::Wcet(wcet) | InterimResult::Period(wcet) => {
                        Some(wcet.of.clone())
                    }
                });
            };
            let cancel = Cancel::default();
            let found = sensitivity(input, scenario, &Options::default(), &cancel, &tell).unwrap();
            (told.into_inner().unwrap(), found)
        })
    };
    let (told, found) = asked("cores 2; policy fifo; unit 1 ms;");
    let order = ["cores", "lift.control", "lift.control.start", "lift.report", "lift.report.start"];
    assert_eq!(told, order);
    let next = found.next_to_break.expect("something breaks first");
    let all = found.wcet.iter().map(|wcet| (Quantity::Wcet, &wcet.of));
    let all: Vec<_> =
        all.chain(found.period.iter().map(|period| (Quantity::Period, &period.of))).collect();
    assert!(all.contains(&(next.quantity, &next.of)));
    assert!(next.factor > 1.0 && next.factor < 2.0, "{next:?}");
    let (told, _) = asked("cores 2; policy fifo; unit 1 ms; client k { send lift.mend; }");
    assert!(told.contains(&"lift.mend.start".to_owned()), "{told:?}");
    assert!(!told.contains(&Policy::Fifo.name().to_owned()));
}

#[test]
fn a_remedy_makes_all_checks_of_the_task_hold() {
    // With 5 ms for `tell` no tick is missed, but the response is below 6 ms only with less.
    let scenario = scenario("check response lift.control <= 6 ms;");
    let report = report(LIFT, &scenario);
    let refuted = report.checks.iter().filter(|check| check.of == "lift.control");
    let refuted: Vec<_> =
        refuted.filter(|check| check.verdict == Verdict::Refuted || check.exceeds()).collect();
    assert_eq!(refuted.len(), 2);
    let found = with(LIFT, &scenario, |input, scenario| {
        let check = (&report, refuted[0]);
        remedy(input, scenario, &Options::default(), check, &Cancel::default())
    });
    let found = found.expect("a remedy");
    let (specification, scenario) = made(&found, LIFT, &scenario, 0.0);
    assert!(holds(&specification, &scenario), "{found:?}");
}

/// A specification of one or two components with tasks that often miss their deadlines, and a scenario.
fn random_system(random: &mut fastrand::Rng) -> (String, String) {
    let mut specification = String::new();
    for (component, tasks) in [("left", 1..=2), ("right", 0..=2)] {
        let tasks: Vec<usize> = (0..random.usize(tasks)).collect();
        if tasks.is_empty() {
            continue;
        }
        specification += &format!(
            "component {component} {{ version \"1\"; lang \"c\"; ids {{ long a; long b; }};\n"
        );
        for task in tasks {
            let period = [5, 8, 10, 20][random.usize(..4)];
            let member = ["a", "b"][random.usize(..2)];
            let access = ["in", "out", "inout"][random.usize(..3)];
            let wcet = random.usize(1..=6);
            specification += &format!(
                "  task {component}_{task} {{ period {period} ms; codel<start> f_{component}_{task}({access} {member}) \
                 yield pause::start wcet {wcet} ms; }};\n"
            );
        }
        specification += "};\n";
    }
    let cores = random.usize(1..=2);
    let policy = ["fifo", "edf"][random.usize(..2)];
    let semantics = ["servers", "published"][random.usize(..2)];
    let durations = ["fixed", "interval"][random.usize(..2)];
    let limit = random.usize(4..=12);
    let scenario = scenario(&format!(
        "semantics {semantics}; durations {durations}; cores {cores}; policy {policy}; \
         check response left.left_0 <= {limit} ms;"
    ));
    (specification, scenario)
}

#[test]
fn every_remedy_of_a_random_miss_makes_all_checks_of_the_task_hold() {
    let misses = dotgen_loaders::times(15);
    let mut random = fastrand::Rng::with_seed(41);
    let (mut tried, mut healed) = (0, 0);
    let mut options = Options::default();
    options.limits.states = 10_000;
    while tried < misses {
        let (specification, scenario) = random_system(&mut random);
        let before = report_within(&specification, &scenario, &options);
        assert!(!before.has_errors(), "{:?}", before.diagnostics);
        let late = |check: &&dotgen_timing::report::CheckReport| check.verdict == Verdict::Refuted;
        for check in before.checks.iter().filter(late) {
            tried += 1;
            let found = with(&specification, &scenario, |input, scenario| {
                remedy(input, scenario, &options, (&before, check), &Cancel::default())
            });
            let Some(change) = found else { continue };
            healed += 1;
            let (specification, scenario) = made(&change, &specification, &scenario, 0.0);
            let after = report_within(&specification, &scenario, &options);
            let mut of_task = after.checks.iter().filter(|after| after.of == check.of);
            let holds = of_task.all(|after| after.verdict == Verdict::Proved && !after.exceeds());
            assert!(holds, "{change:?}\n{specification}\n{scenario}\n{:#?}", after.checks);
        }
    }
    assert!(healed * 2 > tried, "only {healed} of {tried} misses have a remedy");
    println!("{healed} of {tried} misses have a remedy");
}
