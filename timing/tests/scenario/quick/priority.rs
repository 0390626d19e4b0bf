//! Bounds under `policy priority`.

use dotgen_timing::scn::semantics::Preset;

use super::{bounds_of, bounds_under, periodic};

#[test]
fn under_priorities_a_thread_at_the_head_of_the_queue_without_a_core_keeps_others_waiting() {
    // `lo` excludes no codel. But `hi` waits behind its ticket while `mid` has the core.
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

#[test]
fn the_work_of_a_thread_that_holds_a_lock_counts_once() {
    // `a` waits for `b` before its codel, or `b` goes first: not both.
    let two = r"
        component two {
            ids { long x; };
            task a { period 10 ms; codel<start> a(inout x) yield pause::start wcet 1 ms; };
            task b { period 10 ms; codel<start> b(inout x) yield pause::start wcet 4 ms; };
        };
    ";
    let other = periodic("other", "period 10 ms;", 3);
    let scenario = "cores 1; policy priority;";
    insta::assert_snapshot!(bounds_of(Preset::Servers, &[two, &other], scenario), @r"
    two.a 8
    two.b 8
    other.t 8
    ");
}

#[test]
fn a_thread_ahead_that_goes_after_a_job_has_no_core_while_the_job_waits() {
    // `hi` takes 1 ms, and `lo` 2 ms before it. While one of them waits, both cores are at work for the
    // others: 24 ms, on two cores.
    let waiting = r"
        component waiting {
            ids { long x; };
            task hi { period 40 ms; priority 5; codel<start> a(inout x) yield pause::start wcet 1 ms; };
            task lo { period 40 ms; priority 9; codel<start> b(inout x) yield pause::start wcet 2 ms; };
        };
    ";
    let others =
        [("p", 1, 4), ("q", 1, 4), ("mid", 7, 8), ("next", 7, 8)].map(|(name, priority, wcet)| {
            periodic(name, &format!("period 40 ms; priority {priority};"), wcet)
        });
    let [p, q, mid, next] = &others;
    let all = [waiting, p, q, mid, next];
    let bounds = bounds_of(Preset::Servers, &all, "cores 2; policy priority;");
    assert!(bounds.starts_with("waiting.hi 15\n"), "{bounds}");
}
