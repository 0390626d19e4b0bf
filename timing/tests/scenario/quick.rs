//! Quick bounds by response-time analysis.

use dotgen_timing::analytic::response_bounds;
use dotgen_timing::report::Verdict;
use dotgen_timing::scn::names::Names;
use dotgen_timing::scn::parse;
use dotgen_timing::scn::semantics::Preset;
use dotgen_timing::system::TaskId;
use dotgen_timing::system::build::build;
use dotgen_timing::system::settings::Settings;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

use super::{ROBOT, load};

mod priority;

/// Returns bounds on the response times of all tasks under the published semantics, in base units.
fn bounds(specification: &str, scenario: &str) -> String {
    bounds_under(Preset::Published, specification, scenario)
}

fn bounds_under(preset: Preset, specification: &str, scenario: &str) -> String {
    bounds_of(preset, &[specification], scenario)
}

fn bounds_of(preset: Preset, specifications: &[&str], scenario: &str) -> String {
    let units: Vec<_> = specifications.iter().map(|text| load(text)).collect();
    let specs: Vec<_> = units.iter().map(|unit| &*unit.spec).collect();
    let names = Names::new(&specs);
    let parsed = parse(&format!("scenario x {{ {scenario} }}"));
    assert_eq!(parsed.errors, []);
    let mut settings = Settings::new(&parsed.scenario);
    settings.preset = preset;
    let built = build(&names, &settings, &|_| true);
    assert!(!built.has_errors(), "{:?}", built.diagnostics);
    let bounds = response_bounds(&built.system, &Cancel::default());
    let lines = bounds.iter().enumerate().map(|(task, bound)| {
        let bound = bound.map_or("-".to_owned(), |bound| bound.to_string());
        format!("{} {bound}\n", built.system.task_path(TaskId::from(task)))
    });
    lines.collect()
}

#[test]
fn the_quick_bound_is_there_at_once() {
    insta::assert_snapshot!(bounds(ROBOT, "cores 2;"), @r"
    sensor.acquire 6
    control.move 4
    ");
}

/// The start-up of `slow` executes from 10 to 13 ms, without a core: the first job of `fast` takes 4 ms.
const STARTS: &str = r#"
component c {
  version "1"; lang "c";
  ids { long a; };
  task fast {
    period 10 ms;
    codel <start> fast_start(inout a) yield pause::start wcet 1 ms;
  };
  task calm {
    period 50 ms;
    codel <start> calm_start() yield pause::main wcet 9 ms;
    codel <main> calm_main() yield pause::main wcet 1 ms;
  };
  task slow {
    period 50 ms;
    codel <start> slow_start(inout a) yield pause::main wcet 3 ms;
    codel <main> slow_main(inout a) yield pause::main wcet 1 ms;
  };
};
"#;

#[test]
fn with_one_core_start_ups_delay_the_job_that_has_it_and_jobs_do_not() {
    insta::assert_snapshot!(bounds(STARTS, "cores 1;"), @r"
    c.fast 6
    c.calm 6
    c.slow 6
    ");
}

/// Two tasks with a lock in common, of which one works most of the time.
const PAIR: &str = r#"
component pair {
  version "1"; lang "c";
  ids { long a; };
  task io {
    period 10 ms;
    codel <start> io_start() yield pause::read wcet 1 ms;
    codel <read> io_read() yield insert wcet 1 ms;
    codel <insert> io_insert(out a) yield pause::read wcet 1 ms;
  };
  task filter {
    period 10 ms;
    codel <start> filter_start(out a) yield filter wcet 2 ms;
    codel <filter> filter_main(inout a) yield pause::filter wcet 6 ms;
  };
};
"#;

#[test]
fn of_a_task_that_keeps_its_deadlines_the_rest_of_one_job_is_in_the_way() {
    // Not two jobs of the filter: the next one comes too late. Its start-up does not count either, because it
    // is over by then.
    insta::assert_snapshot!(bounds(PAIR, ""), @r"
    pair.io 8
    pair.filter 7
    ");
}

#[test]
fn a_task_that_may_be_late_can_have_a_second_job_at_once() {
    // One carried in, one on a pending tick, and those released meanwhile; for `io`, which is late then, the
    // same three.
    let late = PAIR.replace("wcet 6 ms", "wcet 9 ms");
    insta::assert_snapshot!(bounds(&late, ""), @r"
    pair.io 301
    pair.filter 12
    ");
}

/// Tasks of one period that write the same data, for nine tenths of the period together.
const SAME_TICKS: &str = r#"
component flight {
  version "1"; lang "c";
  ids { long a; };
  task control {
    period 10 ms;
    codel <start> control_start() yield main wcet 0 ms;
    codel <main> control_main(inout a) yield pause::main wcet 1 ms;
  };
  task filter {
    period 10 ms;
    codel <start> filter_start() yield main wcet 0 ms;
    codel <main> filter_main(inout a) yield pause::main wcet 6 ms;
  };
  task plan {
    period 20 ms;
    codel <start> plan_start() yield main wcet 0 ms;
    codel <main> plan_main(inout a) yield pause::main wcet 2 ms;
  };
};
"#;

#[test]
fn of_tasks_with_the_same_ticks_no_job_counts_twice() {
    let expected = "flight.control 9\nflight.filter 9\nflight.plan 9\n";
    assert_eq!(bounds(SAME_TICKS, ""), expected);
    // With as many cores as tasks, no job waits for one.
    assert_eq!(bounds(SAME_TICKS, "cores 3;"), expected);
}

/// A task without a period that executes an activity for a client.
const APERIODIC: &str = r#"
component arm {
  version "1"; lang "c";
  ids { long a; };
  task control { period 10 ms; codel <start> control_main(inout a) yield pause::start wcet 1 ms; };
  task work { };
  activity plan() {
    task work;
    codel <start> plan_start(inout a) yield write wcet 3 ms;
    codel <write> plan_write(inout a) yield ether wcet 1 ms;
  };
};
"#;

#[test]
fn activities_without_a_period_count_with_the_requests_of_a_window() {
    let client = |steps: &str| bounds(APERIODIC, &format!("client c {{ {steps} }}"));
    assert_eq!(client("send arm.plan;"), "arm.control 5\narm.work 5\n");
    // Two requests can be under way together, and each is executed once.
    assert_eq!(client("send arm.plan; send arm.plan;"), "arm.control 9\narm.work 10\n");
    assert_eq!(
        client("repeat * { send arm.plan; await ended; delay 20 ms; }"),
        "arm.control 5\narm.work 5\n"
    );
    // Any number of requests in no time.
    assert_eq!(client("repeat * { send arm.plan; await ended; }"), "arm.control -\narm.work 7\n");
}

/// Activities that take 4 and 5 of 10 ms.
const ACTIVITIES: &str = r#"
component arm {
  version "1"; lang "c";
  ids { long a; };
  task move { period 10 ms; };
  activity go() { task move; codel <start> go_main(out a) yield ether wcet 4 ms; };
  activity grasp() { task move; codel <start> grasp_main(out a) yield ether wcet 5 ms; };
};
"#;

#[test]
fn activities_that_are_awaited_do_not_come_together() {
    let client =
        |steps: &str| bounds(ACTIVITIES, &format!("client c {{ repeat * {{ {steps} }} }}"));
    let go = "send arm.go;";
    let grasp = "send arm.grasp;";
    // All slots: two instances of each.
    assert_eq!(client(&format!("{go} {grasp}")), "arm.move 18\n");
    let one = format!("{go} await ended; {grasp} await ended;");
    assert_eq!(client(&one), "arm.move 5\n");
    let either = format!("choice {{ {go} }} or {{ {grasp} }} await ended;");
    assert_eq!(client(&either), "arm.move 5\n");
    let both = format!("{go} {grasp} await ended arm.go; await ended arm.grasp;");
    assert_eq!(client(&both), "arm.move 9\n");
    // The end of `grasp` is not awaited, so there can be two instances.
    assert_eq!(client(&format!("{go} await ended; {grasp}")), "arm.move 14\n");
    // Each of two clients can have one.
    let two = format!("client c {{ repeat * {{ {one} }} }} client d {{ {go} }}");
    assert_eq!(bounds(ACTIVITIES, &two), "arm.move 9\n");
    let two = format!("slots arm.go 1; {two}");
    assert_eq!(bounds(ACTIVITIES, &two), "arm.move 9\n");
}

#[test]
fn of_activities_that_are_awaited_the_servers_execute_one_in_a_cycle() {
    let client = |steps: &str| {
        let scenario = format!("client c {{ repeat * {{ {steps} }} }}");
        bounds_under(Preset::Servers, ACTIVITIES, &scenario)
    };
    let one = "send arm.go; await ended; send arm.grasp; await ended;";
    assert_eq!(client(one), "arm.move 5\n");
    let both = "send arm.go; send arm.grasp; await ended arm.go; await ended arm.grasp;";
    assert_eq!(client(both), "arm.move 9\n");
    let two = format!("client c {{ repeat * {{ {one} }} }} client d {{ send arm.go; }}");
    assert_eq!(bounds_under(Preset::Servers, ACTIVITIES, &two), "arm.move 9\n");
    // Nothing is known of an activity that is not awaited, but that all places may have one.
    assert_eq!(client("send arm.go; await ended; send arm.grasp;"), "arm.move -\n");
}

#[test]
fn a_task_with_the_same_ticks_is_ahead_with_one_cycle() {
    // In each of three codels `track` could wait for 4 ms of `plan`, but `plan` has one cycle.
    let arm = "component arm {
      version \"1\"; lang \"c\";
      ids { long a; };
      task plan { period 10 ms;
        codel <start> p0() yield pause::run wcet 1 ms;
        codel <run> p1(out a) yield pause::run wcet 4 ms; };
      task track { period 10 ms;
        codel <start> t0() yield pause::wait wcet 1 ms;
        codel <wait> t1(in a) yield main wcet 1 ms;
        codel <main> t2(in a) yield wait, pause::wait wcet 1 ms; };
      };";
    let scenario = "loop once arm.track;";
    assert_eq!(bounds_under(Preset::Servers, arm, scenario), "arm.plan 5\narm.track 6\n");
}

/// A task that never releases its core, and two others.
const ENDLESS: &str = r#"
component bus {
  version "1"; lang "c";
  ids { long line; long state; };
  task comm {
    codel <start> comm_start(out line) yield poll wcet 1 ms;
    codel <poll> comm_poll() yield poll, read wcet 5 ms;
    codel <read> comm_read(out line) yield poll wcet 2 ms;
  };
  task fast {
    period 20 ms;
    codel <start> fast_start(out state) yield pause::run wcet 1 ms;
    codel <run> fast_run(in line, out state) yield pause::run wcet 3 ms;
  };
  task slow {
    period 50 ms;
    codel <start> slow_start(out state) yield pause::run wcet 1 ms;
    codel <run> slow_run(out state) yield pause::run wcet 8 ms;
  };
};
"#;

#[test]
fn who_works_for_ever_is_in_the_way_until_the_next_break() {
    // `fast` waits for one `read`, as the line is free for a millisecond then; but that free time can pass
    // eight times while `slow` is at work.
    let scenario = "duration bus.comm.poll [1,*] ms; loop once bus.comm;";
    insta::assert_snapshot!(bounds(ENDLESS, scenario), @r"
    bus.comm -
    bus.fast 29
    bus.slow 17
    ");
    // Without a break there is no bound.
    insta::assert_snapshot!(bounds(ENDLESS, "loop once bus.comm;"), @r"
    bus.comm -
    bus.fast -
    bus.slow 17
    ");
}

#[test]
fn jobs_on_the_same_core_do_not_wait_for_locks_of_each_other() {
    // One core for all but `comm`: 3 of `fast`, with 2 of `comm` before, then 8 of `slow`; or the other way
    // round.
    let scenario = "duration bus.comm.poll [1,*] ms; loop once bus.comm; cores 2;";
    insta::assert_snapshot!(bounds(ENDLESS, scenario), @r"
    bus.comm -
    bus.fast 13
    bus.slow 13
    ");
}

#[test]
fn on_cores_given_in_order_each_other_task_goes_first_at_most_once() {
    // `a` misses its deadlines: one core has more work than time. Nevertheless `b` and `c` wait for at most
    // one cycle of each other task, and on two cores `a` keeps one of them busy.
    let specification = r"
        component one { task a { period 10 ms; codel <start> f() yield pause::start wcet 11 ms; }; };
        component two { task b { period 20 ms; codel <start> g() yield pause::start wcet 3 ms; }; };
        component three { task c { period 40 ms; codel <start> h() yield pause::start wcet 2 ms; }; };
    ";
    let servers = |scenario| bounds_under(Preset::Servers, specification, scenario);
    insta::assert_snapshot!(servers("cores 1; policy fifo;"), @r"
    one.a -
    two.b 16
    three.c 16
    ");
    insta::assert_snapshot!(servers("cores 2; policy fifo;"), @r"
    one.a -
    two.b 5
    three.c 5
    ");
    insta::assert_snapshot!(servers("cores 1; policy edf;"), @r"
    one.a -
    two.b -
    three.c -
    ");
    insta::assert_snapshot!(servers("cores 3; policy edf;"), @r"
    one.a -
    two.b 3
    three.c 2
    ");
}

#[test]
fn a_task_without_a_period_may_keep_its_core_for_ever() {
    // A request that comes during the cycle of `a` prolongs it: `p` waits longer than one turn of `f` and one
    // of the activity.
    let specification = r"
        component bg { ids { long x; };
          task a { codel <start> f() yield pause::start wcet 5 ms; };
          activity act() { task a;
            codel <start> s1() yield s2 wcet 1 ms;
            codel <s2> s2() yield s3 wcet 1 ms;
            codel <s3> s3() yield ether wcet 1 ms;
          };
        };
        component tt { task p { period 20 ms; codel <start> g() yield pause::start wcet 1 ms; }; };
    ";
    let servers = |scenario| bounds_under(Preset::Servers, specification, scenario);
    insta::assert_snapshot!(servers("cores 1; policy fifo; client c { send bg.act; }"), @r"
    bg.a -
    tt.p -
    ");
    insta::assert_snapshot!(servers("cores 2; policy fifo; client c { send bg.act; }"), @r"
    bg.a -
    tt.p 1
    ");
}

#[test]
fn activities_that_a_client_requests_one_after_the_other_do_not_add_up() {
    let specification = r"
        component c {
            task t { period 10 ms; codel<start> a() yield pause::start wcet 1 ms; };
            activity x() { task t; codel<start> b() yield ether wcet 4 ms; };
            activity y() { task t; codel<start> d() yield ether wcet 5 ms; };
        };
    ";
    let both = |between: &str| {
        let scenario = format!("client k {{ send c.x; await ended; {between} send c.y; }}");
        [Preset::Servers, Preset::Published]
            .map(|preset| bounds_under(preset, specification, &scenario))
    };
    assert_eq!(both("delay 50 ms;"), ["c.t 6\n", "c.t 6\n"]);
    // Within one period too: the published models end an activity with its job, and a cycle of the servers
    // begins activities in its first pass only.
    assert_eq!(both("delay 5 ms;"), ["c.t 6\n", "c.t 6\n"]);
    assert_eq!(both(""), ["c.t 6\n", "c.t 6\n"]);
}

/// A value that is written, copied and published each 10 ms.
const CHAIN: &str = r#"
struct data { long value; };
component sensor {
  version "1"; lang "c";
  exception broken;
  port out data measure;
  task read {
    period 10 ms;
    codel <start> sensor_read(out measure) yield pause::start wcet 1 ms;
  };
};
component filter {
  version "1"; lang "c";
  exception broken;
  port in data measure;
  port out data mean;
  task filter {
    period 10 ms;
    codel <start> filter_start(in measure, out mean) yield pause::start wcet 1 ms;
  };
};
"#;

#[test]
fn a_task_that_may_throw_has_no_bound_on_a_reaction() {
    let reaction = |specification: &str| {
        let unit = load(specification);
        let check = "check reaction sensor.measure -> filter.mean <= 60 ms;";
        let parsed = parse(&format!("scenario x {{ {check} }}"));
        let input = SystemInput { specs: vec![&unit.spec] };
        let mut options = Options::default();
        options.limits.states = 1;
        verify(&input, &parsed.scenario, &options, &Cancel::default()).checks[0].verdict
    };
    assert_eq!(reaction(CHAIN), Verdict::Proved);
    let throws = CHAIN.replacen("period 10 ms;", "period 10 ms; throw broken;", 1);
    assert_eq!(reaction(&throws), Verdict::Proved, "the sensor only stops");
    let throws = CHAIN.replace("period 10 ms;", "period 10 ms; throw broken;");
    assert_ne!(reaction(&throws), Verdict::Proved);
}

/// Found by reading exported models back: the task `t2`, whose timer starts after the first codel of `t0`,
/// was said to meet no job of `t0`.
#[test]
fn a_timer_that_starts_after_a_codel_has_no_known_phase() {
    let text = "component c { ids { long f; };
        task t0 { period 3 ms; codel<start> a() yield pause::start wcet 1 ms; };
        task t1 { period 3 ms; }; task t2 { period 6 ms; delay 2 ms; }; };";
    assert_eq!(
        bounds(text, "unit 1 ms; cores 1; policy edf; durations interval;"),
        "c.t0 1\nc.t1 1\nc.t2 1\n"
    );
}

/// A component with one periodic task.
fn periodic(name: &str, task: &str, wcet: u32) -> String {
    format!(
        "component {name} {{ version \"1\"; lang \"c\"; task t {{ {task}
           codel <start> {name}_work() yield pause::start wcet {wcet} ms; }}; }};"
    )
}

#[test]
fn the_ticks_of_other_tasks_are_known() {
    // Together they take 4 ms, but the ticks 7, 19, … of the first one are no ticks of the other.
    let first = periodic("first", "period 12 ms; delay 7 ms; priority 1;", 2);
    let other = periodic("other", "period 4 ms; priority 2;", 2);
    let scenario = "cores 1; policy priority;";
    insta::assert_snapshot!(bounds_of(Preset::Servers, &[&first, &other], scenario), @r"
    first.t 2
    other.t 3
    ");
}

/// An aperiodic task with an activity of 2 ms, before all others.
const PLANNER: &str = r#"
component planner {
  version "1"; lang "c";
  task plan { priority 1; };
  activity go() { task plan; codel <start> plan_work() yield ether wcet 2 ms; };
};
"#;

#[test]
fn a_request_that_is_over_delays_no_later_job() {
    // All three together take 11 ms, but the activity has ended before the ticks coincide at 30 ms.
    let [often, rarely] = [
        periodic("often", "period 10 ms; priority 3;", 4),
        periodic("rarely", "period 30 ms; priority 2;", 5),
    ];
    let client = |rest: &str| {
        format!("cores 1; policy priority; client c {{ delay 11 ms; send planner.go; {rest} }}")
    };
    let specifications = [PLANNER, &often, &rarely];
    insta::assert_snapshot!(bounds_of(Preset::Servers, &specifications, &client("")), @r"
    planner.plan -
    often.t 9
    rarely.t 7
    ");
    let again = client("await ended; delay 8 ms; send planner.go;");
    insta::assert_snapshot!(bounds_of(Preset::Servers, &specifications, &again), @r"
    planner.plan -
    often.t -
    rarely.t 9
    ");
}

/// A task that waits for a long codel of another one, with a core.
const HELD: &str = r#"
component held {
  version "1"; lang "c";
  ids { long x; };
  task t { period 7 ms; codel <start> t_work(inout x) yield pause::start wcet 1 ms; };
  task plan { };
  activity go() { task plan; codel <start> plan_work(in x) yield ether wcet 3 ms; };
};
"#;

#[test]
fn a_codel_that_is_executed_once_counts_once_in_the_cycles_that_wait_for_it() {
    // The activity begins at a tick of both tasks: `other` waits 3 ms while `held` waits with a core, and
    // takes 4 ms in a run. Without the codel, the two cycles that can play a part would take 2 ms.
    let other = periodic("other", "period 21 ms;", 1);
    let client = "cores 2; policy any; client c { delay 42 ms; send held.go; }";
    insta::assert_snapshot!(bounds_of(Preset::Servers, &[&other, HELD], client), @r"
    other.t 5
    held.t 5
    held.plan -
    ");
}

#[test]
fn an_activity_begins_in_one_job_and_keeps_others_waiting_there() {
    // `low` waits once for `go_start`, whichever of its codels is late.
    let specification = r"
        component c {
            ids { long x; };
            task t { period 4 ms; codel<start> work() yield pause::start wcet 1 ms; };
            task low { period 40 ms;
                codel<start> a(inout x) yield next wcet 1 ms;
                codel<next> b(inout x) yield last wcet 1 ms;
                codel<last> d(inout x) yield pause::start wcet 1 ms; };
            activity go() { task t;
                codel<start> go_start(inout x) yield pause::wait wcet 2 ms;
                codel<wait> go_wait() yield pause::wait, ether wcet 1 ms; };
        };
    ";
    let scenario = "client k { delay 90 ms; send c.go; }";
    insta::assert_snapshot!(bounds(specification, scenario), @r"
    c.t 6
    c.low 5
    ");
}

#[test]
fn an_activity_without_pause_counts_once_in_the_cycles_of_its_task() {
    // In a run, `low` takes 7 ms: 1 ms and 2 ms at its tick, and 1 ms four later.
    let busy = r#"
      component busy {
        version "1"; lang "c";
        task t { period 4 ms; priority 1; codel <start> work() yield pause::start wcet 1 ms; };
        activity go() { task t; codel <start> go_work() yield ether wcet 2 ms; };
      };
    "#;
    let low = periodic("low", "period 12 ms; priority 2;", 3);
    let scenario = "cores 1; policy priority; client c { delay 23 ms; send busy.go; }";
    insta::assert_snapshot!(bounds_of(Preset::Servers, &[busy, &low], scenario), @r"
    busy.t 3
    low.t 8
    ");
}

#[test]
fn the_first_cycle_of_a_task_that_begins_late_delays_a_job() {
    // `late` begins at 32 ms, 2 ms after a tick of `often`, and takes 3 ms that one time.
    let often = periodic("often", "period 10 ms; priority 3;", 6);
    let rarely = periodic("rarely", "period 40 ms; delay 12 ms; priority 2;", 2);
    let late = r#"
      component late {
        version "1"; lang "c";
        task t {
          period 40 ms; delay 32 ms; priority 1;
          codel <start> late_start() yield pause::main wcet 3 ms;
          codel <main> late_main() yield pause::main wcet 1 ms;
        };
      };
    "#;
    let scenario = "cores 1; policy priority;";
    insta::assert_snapshot!(bounds_of(Preset::Servers, &[&often, &rarely, late], scenario), @r"
    often.t 9
    rarely.t 3
    late.t 1
    ");
}
