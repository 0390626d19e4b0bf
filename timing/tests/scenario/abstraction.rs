//! The answers and refusals of the middle tier.

use dotgen_timing::system::TaskId;
use std::fmt::Write;

use dotgen_timing::abstraction::{Budget, Refusal, abstract_bounds};
use dotgen_timing::explore::Kind;
use dotgen_timing::report::{Layer, Report, Verdict};
use dotgen_timing::scn::names::Names;
use dotgen_timing::scn::parse;
use dotgen_timing::system::build::build;
use dotgen_timing::verify::{Cancel, Options, SystemInput, settings, verify};

use super::load;

/// Two components whose tasks share data and two cores.
const ARM: &str = r#"
component joint {
  version "1"; lang "c";
  ids { long state; long goal; };
  task servo {
    period 4 ms;
    codel<start> servo_start(out state) yield pause::read wcet 0.1 ms;
    codel<read> servo_read(out state) yield act, pause::read wcet 0.5 ms;
    codel<act> servo_act(in state, in goal) yield pause::read wcet 0.5 ms;
  };
  task plan {
    period 20 ms; delay 1 ms;
    codel<start> plan_start(out goal) yield pause::think wcet 0.1 ms;
    codel<think> plan_think() yield write wcet 6 ms;
    codel<write> plan_write(out goal) yield pause::think wcet 0.5 ms;
  };
};
component eye {
  version "1"; lang "c";
  task look {
    period 10 ms;
    codel<start> look_start() yield pause::look wcet 0.1 ms;
    codel<look> look_main() yield pause::look wcet 2 ms;
  };
};
"#;

fn bounds(specification: &str, scenario: &str) -> Result<String, Refusal> {
    let unit = load(specification);
    let names = Names::new(&[&unit.spec]);
    let parsed = parse(&format!("scenario x {{ {scenario} }}"));
    assert_eq!(parsed.errors, []);
    let settings = settings(&parsed.scenario, &Options::default());
    let built = build(&names, &settings, &|_| true);
    let bounds = abstract_bounds(&built.system, Budget::default(), &Cancel::default());
    let mut out = String::new();
    for (task, bound) in bounds.iter().enumerate() {
        let periodic = built.system.tasks[TaskId::from(task)].period.is_some();
        let path = built.system.task_path(TaskId::from(task));
        let _ = match bound {
            Ok(bound) => writeln!(out, "{path} {bound}"),
            Err(why) if periodic => writeln!(out, "{path}: {why}"),
            Err(_) => Ok(()),
        };
    }
    match bounds.iter().find_map(|bound| bound.err()) {
        Some(why) if !bounds.iter().any(Result::is_ok) => Err(why),
        _ => Ok(out),
    }
}

fn answers(scenario: &str, options: &Options) -> Report {
    let unit = load(ARM);
    let parsed = parse(&format!("scenario x {{ {scenario} }}"));
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    verify(&input, &parsed.scenario, options, &Cancel::default())
}

#[test]
fn tasks_that_share_locks_and_cores_have_bounds_of_what_can_come_together() {
    // In base units of 0.1 ms. `servo` waits for one codel of `plan`, and never for a core.
    insta::assert_snapshot!(bounds(ARM, "cores 2; policy edf;").unwrap(), @r"
    joint.servo 15
    joint.plan 65
    eye.look 20
    ");
    insta::assert_snapshot!(bounds(ARM, "cores free;").unwrap(), @r"
    joint.servo 15
    joint.plan 65
    eye.look 20
    ");
}

#[test]
fn deadlines_are_proved_by_the_middle_tier_where_analysis_knows_nothing() {
    let report = answers(
        "cores 1; policy edf; check schedulable eye.look; check no-overdue eye.look;",
        &Options::default(),
    );
    for check in &report.checks {
        assert_eq!(check.verdict, Verdict::Proved, "{check:?}");
        assert_eq!(check.by, Some(Layer::ScheduleAbstraction), "{check:?}");
    }
    // No exploration was needed.
    assert_eq!(report.states, 0);
    let lines = report.reductions.lines();
    let used = "used; not for joint.servo: a deadline may be missed, as far as it can tell";
    assert_eq!(lines, [("schedule-abstraction", used.to_owned())]);
}

#[test]
fn an_exact_value_is_reached_by_its_bound_or_below() {
    let scenario = "cores 2; policy edf; check response *;";
    let found = answers(scenario, &Options::default());
    let mut options = Options::default();
    options.limits.without = [Kind::ScheduleAbstraction].into_iter().collect();
    let exact = answers(scenario, &options);
    for (found, exact) in found.checks.iter().zip(&exact.checks) {
        assert_eq!(exact.by, None);
        assert_eq!(found.verdict, Verdict::Proved);
        assert_eq!(found.value, exact.value, "{}", found.of);
    }
}

#[test]
fn what_is_not_treated_is_refused_with_its_reason() {
    let refused = |specification: &str, scenario: &str| bounds(specification, scenario).err();
    let preempted = refused(ARM, "cores 2; policy priority;");
    assert_eq!(preempted, Some(Refusal::Preemption));
    let points = refused(ARM, "cores 2; policy edf; turns pause;");
    assert_eq!(points, Some(Refusal::Semantics));
    // The only core may be held by an aperiodic task for ever.
    let aperiodic = ARM.replace("period 4 ms;", "");
    let aperiodic = refused(&aperiodic, "cores 1; policy fifo;");
    assert_eq!(aperiodic, Some(Refusal::Aperiodic));
    let builtin = refused(ARM, "cores free; client c { kill eye; }");
    assert_eq!(builtin, Some(Refusal::Requests));
    let published = refused(ARM, "semantics published; cores 2;");
    assert_eq!(published, Some(Refusal::StartUp));
}

#[test]
fn a_task_without_a_bound_leaves_the_bounds_of_the_others() {
    let open = |specification: &str, scenario: &str, reason: &str| {
        let found = bounds(specification, scenario).unwrap();
        let (open, bounded): (Vec<&str>, Vec<&str>) =
            found.lines().partition(|line| line.contains(':'));
        assert_eq!(open, [format!("joint.servo: {reason}")]);
        assert_eq!(bounded.len(), 2, "{found}");
    };
    let round = ARM.replace("yield act, pause::read", "yield act, read");
    open(&round, "cores 3; policy edf;", "a turn need not come to a pause");
    // `plan` executes a codel without locks for more than a period of `servo`, on the only core. The response
    // time of `servo` has a bound, which is above its period.
    let late = "a deadline may be missed, as far as it can tell";
    let found = bounds(ARM, "cores 1; policy fifo;").unwrap();
    let servo = found.lines().find_map(|line| line.strip_prefix("joint.servo "));
    assert!(servo.unwrap().parse::<u32>().unwrap() > 50, "{found}");
    assert_eq!(found.lines().count(), 3, "{found}");
    // `--explain` names the task, and the checks of the others are answered.
    let report = answers("cores 1; policy fifo; check schedulable *;", &Options::default());
    let verdicts = report.checks.iter().map(|check| check.verdict);
    let expected = [Verdict::Refuted, Verdict::Proved, Verdict::Proved];
    assert_eq!(verdicts.collect::<Vec<_>>(), expected);
    let lines = report.reductions.lines();
    let line = format!("used; not for joint.servo: {late}");
    assert_eq!(lines[0], ("schedule-abstraction", line));
}

/// Returns components with two to four tasks each, one of which has no period. `turn` is the number of the
/// task that is declared first, and `back` reverses the order of components and services.
fn ordered(components: usize, turn: usize, back: bool) -> String {
    let mut all = Vec::new();
    for c in 0..components {
        let mut tasks = Vec::new();
        for (t, period) in [5, 10, 20, 40][..2 + c.min(2)].iter().enumerate() {
            let period = match (c, t) {
                (1, 0) => String::new(),
                _ => format!("period {period} ms;"),
            };
            let field = ["inout a", "in a", "inout b", "in b"][t];
            tasks.push(format!(
                "task t{t} {{ {period}
                 codel<start> s{t}({field}) yield pause::main wcet 0.2 ms;
                 codel<main> m{t}({field}) yield pause::main, more wcet 0.3 ms;
                 codel<more> n{t}() yield pause::main wcet 0.{t}1 ms; }};"
            ));
        }
        let first = turn % tasks.len();
        tasks.rotate_left(first);
        let mut services = [
            "function halt() { codel h(out a) wcet 0.1 ms; };",
            "activity go() { task t1; codel<start> g(out b) yield ether wcet 0.2 ms; };",
        ];
        if back {
            services.reverse();
        }
        all.push(format!(
            "component c{c} {{ version \"1\"; lang \"c\"; ids {{ long a; long b; }}; {} {} }};",
            tasks.concat(),
            services.concat(),
        ));
    }
    if back {
        all.reverse();
    }
    all.concat()
}

#[test]
fn the_order_of_declarations_changes_no_verdict() {
    let client = "client c { send c0.go; repeat * { send c1.halt; delay 10 ms; } }";
    for (components, scenario) in [
        (4, format!("cores free; {client}")),
        (2, format!("cores 3; policy fifo; {client}")),
        (2, "cores 3; policy edf;".to_owned()),
    ] {
        let periodic = [4, 12][components / 4];
        for (turn, back) in (0..4).flat_map(|number| [(number, false), (number, true)]) {
            let found = bounds(&ordered(components, turn, back), &scenario).unwrap();
            let bounded = found.lines().filter(|line| !line.contains(':'));
            assert_eq!(bounded.count(), periodic, "{scenario} {turn} {back}: {found}");
        }
    }
}

#[test]
fn what_comes_at_any_time_is_counted_wherever_it_can_come() {
    // `servo` waits for one codel of `plan`, and the control task holds `goal` for 0.3 ms before each of the
    // two.
    let asked = ARM.replace(
        "  task servo {",
        "  function aim() { codel aim(out goal) wcet 0.3 ms; };\n  task servo {",
    );
    let client = "client c { repeat * { send joint.aim; delay 1 ms; } }";
    insta::assert_snapshot!(bounds(&asked, &format!("cores free; {client}")).unwrap(), @r"
    joint.servo 21
    joint.plan 71
    eye.look 20
    ");
    // An activity is executed after the permanent one, in the same cycle.
    let (rest, end) = ARM.trim_end().rsplit_once("};").unwrap();
    let blink = "activity blink() { task look; codel<start> blink() yield ether wcet 0.7 ms; }; };";
    let look = format!("{rest}{blink}{end}");
    let client = "client c { send eye.blink; }";
    insta::assert_snapshot!(bounds(&look, &format!("cores free; {client}")).unwrap(), @r"
    joint.servo 15
    joint.plan 65
    eye.look 27
    ");
    // An aperiodic task may hold one of the cores for ever.
    let aperiodic = ARM.replace("period 10 ms;", "");
    insta::assert_snapshot!(bounds(&aperiodic, "cores 3; policy fifo;").unwrap(), @r"
    joint.servo 15
    joint.plan 65
    ");
}

/// All jobs are released at the same moment, so that there are too many sets of jobs that can be done first.
#[test]
fn fifty_periodic_tasks_on_one_core_keep_their_deadlines() {
    let mut specification = String::new();
    for i in 0..50 {
        let period = [60, 80, 120, 240][i % 4];
        let _ = writeln!(
            specification,
            "component c{i} {{ version \"1\"; lang \"c\"; task t {{ period {period} ms;
             codel<start> s{i}() yield pause::main wcet 0 ms;
             codel<main> m{i}() yield pause::main wcet 1 ms; }}; }};"
        );
    }
    for semantics in ["servers", "published"] {
        let scenario = format!("semantics {semantics}; cores 1; policy edf;");
        let found = bounds(&specification, &scenario);
        assert_eq!(found.map(|bound| bound.lines().count()), Ok(50), "{semantics}");
    }
}

#[test]
fn sixty_activities_that_may_begin_at_any_time_are_refused_at_once() {
    let activities: String = (0..60).fold(String::new(), |mut out, i| {
        let codel = format!("codel<start> f{i}() yield pause::start, ether wcet 1 us;");
        _ = writeln!(out, "activity a{i}() {{ task t; {codel} }};");
        out
    });
    let specification = format!(
        "component c {{ version \"1\"; lang \"c\"; task t {{ period 10 ms; }};\n{activities}}};\n"
    );
    let sends: Vec<String> = (0..60).map(|i| format!("{{ send c.a{i}; }}")).collect();
    let scenario =
        format!("cores 2; client any {{ repeat * {{ choice {} }} }}", sends.join(" or "));
    assert_eq!(bounds(&specification, &scenario), Err(Refusal::Requests));
}
