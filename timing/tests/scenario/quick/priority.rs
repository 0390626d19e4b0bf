//! Bounds under `policy priority`.

use dotgen_timing::scn::semantics::Preset;

use super::{bounds_of, bounds_under, periodic};

#[test]
fn under_priorities_a_thread_at_the_head_of_the_queue_without_a_core_keeps_others_waiting() {
    // `lo` excludes nobody. But `hi` waits behind its ticket while `mid` has the core.
    let specification = r"
        component c {
            ids { long x; long y; };
            task hi { period 50 ms; priority 1; codel<start> a(inout x) yield pause::start wcet 1 ms; };
            task lo { period 50 ms; priority 9; codel<start> b(inout y) yield pause::start wcet 1 ms; };
        };
        component d { task mid { period 40 ms; priority 5; codel<start> m() yield pause::start wcet 9 ms; }; };
    ";
    let bounds = bounds_under(Preset::Servers, specification, "cores 1; policy priority;");
    insta::assert_snapshot!(bounds, @r"
    c.hi 10
    c.lo 11
    d.mid 10
    ");
}

#[test]
fn a_task_that_may_be_late_delays_others_by_two_cycles() {
    // `hi` waits for `lo`, and `lo` for `mid`, past its deadline. Its cycle under way and that of its only
    // raised flag can come after a tick of `other`.
    let late = r"
        component c {
            ids { long x; };
            task hi { period 10 ms; priority 1; codel<start> a(inout x) yield pause::start wcet 1 ms; };
            task lo { period 90 ms; priority 9; codel<start> b(inout x) yield pause::start wcet 2 ms; };
        };
    ";
    let [other, mid] = [
        periodic("other", "period 10 ms; priority 2;", 7),
        periodic("mid", "period 90 ms; priority 5;", 9),
    ];
    let scenario = "cores 1; policy priority;";
    insta::assert_snapshot!(bounds_of(Preset::Servers, &[late, &other, &mid], scenario), @r"
    c.hi -
    c.lo 68
    other.t 9
    mid.t 58
    ");
}

#[test]
fn the_start_ups_of_a_component_count_once() {
    // The first pass of `a` can last 8 ms, and the first cycle of `b` as well: but 8 ms in all.
    let two = r"
        component two {
            task a { period 10 ms; codel<start> a() yield pause::start wcet 1 ms; };
            task b { period 10 ms; codel<start> b() yield pause::start wcet 3 ms; };
        };
    ";
    let other = periodic("other", "period 10 ms;", 4);
    let scenario = "cores 1; policy priority;";
    insta::assert_snapshot!(bounds_of(Preset::Servers, &[two, &other], scenario), @r"
    two.a 8
    two.b 8
    other.t 8
    ");
}

#[test]
fn an_activity_with_pauses_begins_in_one_cycle_of_its_task() {
    // In a run, `low` takes 8 ms. If each cycle of `busy` took 3 ms, it would have no bound.
    let busy = r#"
      component busy {
        version "1"; lang "c";
        task t { period 4 ms; priority 1; codel <start> work() yield pause::start wcet 1 ms; };
        activity go() {
          task t;
          codel <start> go_start() yield pause::wait wcet 2 ms;
          codel <wait> go_wait() yield pause::wait, ether wcet 1 ms;
        };
      };
    "#;
    let low = periodic("low", "period 12 ms; priority 2;", 3);
    let scenario = "cores 1; policy priority; client c { delay 23 ms; send busy.go; }";
    insta::assert_snapshot!(bounds_of(Preset::Servers, &[busy, &low], scenario), @r"
    busy.t 3
    low.t 11
    ");
}
