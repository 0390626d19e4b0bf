//! Failures that come late.

use dotgen_timing::explore::Limits;
use dotgen_timing::report::Verdict;
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

use crate::effort::load;

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
