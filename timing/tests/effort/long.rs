//! Long times: proofs with zones take the same effort for milliseconds and for minutes.

use super::published;
use dotgen_timing::explore::Limits;
use dotgen_timing::report::{Report, Verdict};
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

use crate::effort::{counting, load};

/// Tenants that exclude each other by time alone: each checks whether the room is let, moves in at most
/// `within` later, and uses the room `wait` after that if no other tenant has moved in meanwhile.
fn asked(within: u32, wait: u32) -> (String, String) {
    let (mut genom, mut scenario) = (String::new(), String::new());
    let lease = wait + 20 * wait / 10;
    for i in 1..=4 {
        let others: Vec<String> =
            (1..=4).filter(|&number| number != i).map(|number| format!("use{number}")).collect();
        genom += &format!(
            "task look{i} {{ }}; task lease{i} {{ }};
             activity ask{i}() {{ task look{i}; codel <start> ask(inout room) yield ether wcet 0 ms; }};
             activity let{i}() {{ task lease{i}; codel <start> keep(in room) yield ether wcet {lease} ms; }};
             activity use{i}() {{
               task look{i};
               codel <start> wait() yield pause::inside wcet {wait} ms;
               codel <inside> stay() yield ether wcet {wait} ms;
             }};
             function claim{i}() {{ interrupt {}; }};",
            others.join(", ")
        );
        scenario += &format!(
            "duration house.let{i}.start [{lease}, {lease}] ms;
             duration house.use{i}.start [{wait}, {wait}] ms;
             slots house.ask{i} 1; slots house.let{i} 1; slots house.use{i} 1;
             client tenant{i} {{ repeat * {{
               delay [0, *] ms; send house.ask{i}; await ended;
               delay [0, {within}] ms; send house.let{i}; send house.use{i}; send house.claim{i};
               await ended house.use{i}; await ended house.let{i};
             }} }}"
        );
    }
    let pair = "house.use1.inside.exec and house.use2.inside.exec";
    (
        format!("component house {{ version \"1\"; lang \"c\"; ids {{ long room; }}; {genom} }};"),
        format!("scenario house {{ {scenario} check always not ({pair}); }}"),
    )
}

fn answer(within: u32, wait: u32) -> (Report, usize) {
    answer_all(within, wait, "", &published())
}

/// Verifies the same system with more checks.
fn answer_all(within: u32, wait: u32, checks: &str, options: &Options) -> (Report, usize) {
    let (genom, scenario) = asked(within, wait);
    let unit = load(&genom);
    let scenario = parse(&scenario.replace(" check", &format!(" {checks} check")));
    assert_eq!(scenario.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    counting::peak(|| verify(&input, &scenario.scenario, options, &Cancel::default()))
}

#[test]
fn long_times_cost_nothing() {
    let (short, _) = answer(10, 11);
    let (long, _) = answer(10_000, 11_000);
    for report in [&short, &long] {
        assert_eq!(report.checks[0].verdict, Verdict::Proved);
        assert!(report.steps < 60_000, "{} steps", report.steps);
    }
    assert_eq!(short.steps, long.steps);
}

#[test]
fn what_is_proved_in_zones_stays_proved_when_the_rest_is_given_up() {
    let options = Options { limits: Limits { states: 40_000, ..Limits::default() }, ..published() };
    let checks = "check deadlock; check reachable house.look1 and house.look1.idle;
      check within tenant1.ask1 => house.use1.void <= 1 s;";
    let (report, _) = answer_all(10_000, 11_000, checks, &options);
    let verdicts: Vec<Verdict> = report.checks.iter().map(|check| check.verdict).collect();
    let (proved, refuted) = (Verdict::Proved, Verdict::Refuted);
    assert_eq!(verdicts, [proved, refuted, Verdict::Unknown, proved]);
}

#[test]
fn what_zones_show_to_be_possible_is_shown_by_a_run() {
    let (report, _) = answer(11, 11);
    assert_eq!(report.checks[0].verdict, Verdict::Refuted);
    assert!(!report.checks[0].counterexample.is_empty());
}

#[test]
fn zones_count_their_bytes_truly() {
    let (report, peak) = answer(100, 110);
    let counted = report.memory;
    assert!(
        counted > 1_000_000
            && counted / 4 * 3 < peak
            && peak < counted / 4 * 5 + crate::effort::FIXED,
        "{counted} bytes counted, {peak} used"
    );
}

/// Ten tasks of one component on one core: under FIFO, the shortest period waits for all others where their
/// ticks meet.
#[test]
fn a_late_miss_of_many_tasks_is_found() {
    let periods = [20, 5, 25, 100, 25, 25, 50, 25, 100, 10];
    let times = [4, 1, 21, 48, 20, 2, 25, 19, 30, 10];
    let tasks = periods.iter().zip(times).enumerate().map(|(number, (period, time))| {
        format!(
            "task t{number} {{ period {period} ms;
               codel <start> work{number}() yield pause::start, ether wcet {}.{} ms; }};",
            time / 10,
            time % 10
        )
    });
    let tasks: String = tasks.collect();
    let unit = load(&format!("component many {{ version \"1\"; lang \"c\"; {tasks} }};"));
    let scenario = parse("scenario many { cores 1; policy fifo; check schedulable many.t1; }");
    let limits = Limits { states: 100_000, ..Limits::default() };
    let options = Options { limits, ..Options::default() };
    let input = SystemInput { specs: vec![&unit.spec] };
    let report = verify(&input, &scenario.scenario, &options, &Cancel::default());
    assert_eq!(report.checks[0].verdict, Verdict::Refuted);
}
