//! Results of strategies other than breadth-first search: failures, and times without a bound.

use dotgen_timing::property::PropertyKind;

use super::*;

/// Processes that exclude each other by time alone, after Fischer's protocol, with a wait that is too short:
/// a claim interrupts the claims of the others, but a claim that may still be made is not interrupted.
pub(crate) fn too_short_a_wait(processes: usize) -> (UnitResult, String) {
    let all = || 1..=processes;
    let of = |i: usize| {
        let others = all().filter(|&j| j != i).map(|j| format!("claim{j}"));
        format!(
            "task t{i} {{}}; task h{i} {{}};
             activity ask{i}() {{ task t{i}; codel <start> a{i}(inout id) yield ether wcet 0 ms; }};
             activity hold{i}() {{ task h{i}; codel <start> h{i}(in id) yield ether wcet 3 ms; }};
             activity claim{i}() {{ task t{i};
               codel <start> w{i}() yield pause::cs wcet 1 ms; codel <cs> c{i}() yield ether wcet 2 ms; }};
             function set{i}() {{ interrupt {}; }};",
            others.collect::<Vec<_>>().join(", ")
        )
    };
    let spec = all().map(of).collect::<String>();
    let unit =
        load(&format!("component f {{ version \"1\"; lang \"c\"; ids {{ long id; }}; {spec} }};"));
    let of = |i: usize| {
        format!(
            "duration f.hold{i}.start [3, 3] ms; duration f.claim{i}.start [1, 1] ms;
             slots f.ask{i} 1; slots f.hold{i} 1; slots f.claim{i} 1;
             client p{i} {{ repeat * {{
               delay [0, *] ms; send f.ask{i}; await ended;
               delay [0, 1] ms; send f.hold{i}; send f.claim{i}; send f.set{i};
               await ended f.claim{i}; await ended f.hold{i}; }} }}"
        )
    };
    let pairs = all().flat_map(|i| (1..i).map(move |j| (i, j)));
    let pairs = pairs.map(|(i, j)| format!("(f.claim{i}.cs.exec and f.claim{j}.cs.exec)"));
    let check = pairs.collect::<Vec<_>>().join(" or ");
    let clients = all().map(of).collect::<String>();
    let text = format!("scenario x {{ cores free; {clients} check always not ({check}); }}");
    (unit, text)
}

#[test]
fn what_fails_at_a_crowded_moment_is_found_soon_and_in_few_steps() {
    for processes in [3, 4, 5] {
        let (unit, text) = too_short_a_wait(processes);
        let input = SystemInput { specs: vec![&unit.spec] };
        // In order of time there are far more states than that before the failure.
        let mut options = published();
        options.limits.states = 12_000;
        let parsed = parse(&text);
        assert_eq!(parsed.errors, []);
        let report = verify(&input, &parsed.scenario, &options, &Cancel::default());
        assert_eq!(report.checks[0].verdict, Verdict::Refuted, "{processes}");
        // The failure needs one write and one wait of two processes; the others need not act.
        if processes == 3 {
            let run = &report.checks[0].counterexample;
            let inside = run.iter().filter(|run| run.what.contains(".cs begins"));
            assert_eq!(inside.count(), 2);
            assert_eq!(run.last().unwrap().time, 2.0);
        }
    }
}

#[test]
fn a_number_of_cores_is_refuted_at_a_crowded_moment() {
    let (unit, text) = too_short_a_wait(7);
    let busy = load(
        "component g { version \"1\"; lang \"c\"; ids { long b; };
           task a { period 10 ms; codel <start> x(inout b) yield pause::start wcet 6 ms; };
           task b { period 10 ms; codel <start> y(inout b) yield pause::start wcet 6 ms; };
         };",
    );
    let input = SystemInput { specs: vec![&unit.spec, &busy.spec] };
    let (text, _) = text.split_once("check").unwrap();
    let parsed = parse(&format!("{text} aperiodic free; check schedulable *; }}"));
    assert_eq!(parsed.errors, []);
    let mut options = published();
    options.limits.states = 20_000;
    let found = minimum_cores(&input, &parsed.scenario, &options, &Cancel::default()).unwrap();
    assert_eq!(found.tried[0], (1, Verdict::Refuted), "{found:?}");
}

/// Tasks that cannot all have the core, with no defined order.
fn overload(tasks: usize) -> (UnitResult, String) {
    let of = |i: usize| {
        format!(
            "task t{i} {{ period {} ms;
               codel <start> a{i}(inout x{i}) yield go wcet 1 ms;
               codel <go> b{i}(in x{i}) yield pause::start wcet 3 ms; }};",
            20 + 10 * (i % 2)
        )
    };
    let ids: String = (0..tasks).map(|i| format!("long x{i}; ")).collect();
    let tasks: String = (0..tasks).map(of).collect();
    let unit =
        load(&format!("component o {{ version \"1\"; lang \"c\"; ids {{ {ids} }}; {tasks} }};"));
    let text = "scenario x { cores 1; policy any; check response *; check no-overdue *; }";
    (unit, text.to_owned())
}

#[test]
fn that_a_task_can_starve_is_found_long_before_everything_is_known() {
    let (unit, text) = overload(9);
    let input = SystemInput { specs: vec![&unit.spec] };
    let parsed = parse(&text);
    assert_eq!(parsed.errors, []);
    let mut options = published();
    options.limits.states = 200_000;
    let report = verify(&input, &parsed.scenario, &options, &Cancel::default());
    for check in &report.checks {
        assert_eq!(check.verdict, Verdict::Refuted, "{} {}", check.kind, check.of);
        if check.kind == PropertyKind::Response {
            assert_eq!(check.value, Some(Value::Unbounded), "{}", check.of);
            assert!(check.cycle.is_some(), "{}: the run goes on for ever", check.of);
        }
    }
}
