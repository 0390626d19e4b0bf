//! The effort of verifications: memory of searches, and time until a cancelled search ends.

mod counting;
mod long;

use std::collections::HashSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use self::counting::Counting;
use dotgen_analysis::host::UnitResult;
use dotgen_loaders::unit;
use dotgen_timing::derive::{
    InterimResult, largest_wcet, minimum_cores, sensitivity, smallest_period,
};
use dotgen_timing::explore::{Limits, Stop};
use dotgen_timing::report::{CheckReport, Value, Verdict};
use dotgen_timing::scn::ast::{Path, Scenario};
use dotgen_timing::scn::names::Names;
use dotgen_timing::scn::parse;
use dotgen_timing::scn::semantics::Preset;
use dotgen_timing::system::build::build;
use dotgen_timing::verify::{Cancel, Options, SystemInput, settings, verify};

/// The options of these tests: the published models.
fn published() -> Options {
    Options { semantics: Some(Preset::Published), ..Options::default() }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Three tasks of two components that share data and a port, with activities that any client can request.
const ROBOT: &str = r#"
typedef long scan_data;
component sensor {
  version "1"; lang "c";
  ids { long raw; long log; };
  port out scan_data scan;
  task acquire {
    period 10 ms;
    codel <start> init(out raw) yield read wcet 1 ms;
    codel <read> acquire_read(out raw) yield publish wcet 2 ms;
    codel <publish> acquire_publish(in raw, port out scan) yield pause::read wcet 3 ms;
  };
  task watch {
    period 15 ms;
    codel <start> look(in raw, out log) yield pause::start, again wcet 1 ms;
    codel <again> look_again(in raw) yield pause::start wcet 1 ms;
  };
  function reset() { codel reset_raw(out raw) wcet 1 ms; };
  activity record() {
    task acquire;
    codel <start> record_start(in raw) yield pause::start, ether wcet 1 ms;
    codel <stop> record_stop() yield ether wcet 1 ms;
    interrupts record;
  };
};
component control {
  version "1"; lang "c";
  ids { long goal; };
  port in scan_data scan;
  task move {
    period 7 ms;
    codel <start> init(out goal) yield step wcet 1 ms;
    codel <step> move_step(in goal, port in scan) yield pause::step wcet 1 ms;
  };
};
"#;

/// The checks that one exploration answers.
const CHECKS: &str = "scenario robot {
  cores 2;
  client user { delay [0,9] ms; send sensor.record; delay 3 ms; send sensor.record; send sensor.reset; }
  check schedulable *; check no-overdue *; check response * <= 3 ms; check deadlock;
  check always not sensor.record.stop;
  MORE
}";

fn load(text: &str) -> UnitResult {
    unit(text).expect("a specification without errors")
}

fn scenario(more: &str) -> Scenario {
    let parsed = parse(&CHECKS.replace("MORE", more));
    assert_eq!(parsed.errors, []);
    parsed.scenario
}

/// Checks with clocks of their own and without a bound, and checks that search for cycles.
const MORE: &str = "check within sensor.record.run => sensor.record.void <= 5 ms;
  check leadsto sensor.record.run => sensor.record.void;";

fn with<T>(more: &str, ask: impl Fn(&SystemInput, &Scenario) -> T) -> T {
    let unit = load(ROBOT);
    let input = SystemInput { specs: vec![&unit.spec] };
    ask(&input, &scenario(more))
}

fn limited(bytes: usize) -> Options {
    Options { limits: Limits { bytes, ..Limits::default() }, ..published() }
}

// ---- Ending -----------------------------------------------------------------------------------

/// Counts polls of the flag, and raises it at one of them.
struct Looks {
    seen: Arc<AtomicU64>,
    /// Greatest number of allocations between two polls, since `counting::mark`.
    gap: Arc<AtomicU64>,
}

fn raised_at(look: u64) -> (Cancel, Looks) {
    let looks = Looks { seen: Arc::default(), gap: Arc::default() };
    let (seen, gap) = (looks.seen.clone(), looks.gap.clone());
    counting::mark();
    let cancel = Cancel::asking(move || {
        gap.fetch_max(counting::since_mark(), Ordering::Relaxed);
        counting::mark();
        seen.fetch_add(1, Ordering::Relaxed) + 1 >= look
    });
    (cancel, looks)
}

impl Looks {
    fn seen(&self) -> u64 {
        self.seen.load(Ordering::Relaxed)
    }

    /// Returns the greatest number of allocations between two polls, before the first and after the last.
    fn gap(&self) -> u64 {
        self.gap.load(Ordering::Relaxed).max(counting::since_mark())
    }
}

#[test]
fn a_search_looks_every_few_steps_and_ends_when_cancelled() {
    with("", |input, scenario| {
        let run = |look| {
            let (cancel, looks) = raised_at(look);
            let report = verify(input, scenario, &published(), &cancel);
            (report, looks.seen())
        };
        let (whole, looks) = run(u64::MAX);
        assert!(whole.refuted() && looks > 500, "{:?}", whole.checks);
        for look in (1..looks).step_by(looks as usize / 40) {
            let ((one, seen), (other, _)) = (run(look), run(look + 1));
            let steps = other.steps - one.steps;
            assert!(steps <= 64, "{steps} steps after look {look}");
            assert!(seen - look < 50, "{} looks after number {look}", seen - look);
        }
    });
}

/// Upper limit on allocations between two polls: a measure of work that needs no cooperation of the program.
/// Ten thousand take about a millisecond.
const WORK: u64 = 10_000;

/// Verifies without a cancellation, then with the flag raised early, in the middle and late.
fn cancelled_anywhere(more: &str, ask: impl Fn(&SystemInput, &Scenario, &Cancel)) {
    with(more, |input, scenario| {
        let run = |look| {
            let (cancel, looks) = raised_at(look);
            ask(input, scenario, &cancel);
            looks
        };
        let whole = run(u64::MAX);
        assert!(whole.gap() < WORK, "{} allocations without a look", whole.gap());
        let all = whole.seen();
        assert!(all > 100, "only {all} looks");
        for look in [1, 2, all / 10, all / 2, all - all / 10] {
            let looks = run(look);
            let after = looks.seen() - look;
            assert!(after < 100, "{after} looks after number {look} of {all}");
            assert!(looks.gap() < WORK, "{} allocations", looks.gap());
        }
    });
}

#[test]
fn checks_of_all_kinds_end_when_cancelled() {
    cancelled_anywhere(MORE, |input, scenario, cancel| {
        verify(input, scenario, &published(), cancel);
    });
}

#[test]
fn derived_questions_end_when_cancelled() {
    let options = published();
    cancelled_anywhere("", |input, scenario, cancel| {
        minimum_cores(input, scenario, &options, cancel).unwrap();
    });
    cancelled_anywhere("", |input, scenario, cancel| {
        let codel = Path::of("control.move.step");
        largest_wcet(input, scenario, &options, &codel, cancel).unwrap();
    });
    cancelled_anywhere("", |input, scenario, cancel| {
        let task = Path::of("sensor.watch");
        smallest_period(input, scenario, &options, &task, cancel).unwrap();
    });
    cancelled_anywhere("", |input, scenario, cancel| {
        sensitivity(input, scenario, &options, cancel, &|_| {}).unwrap();
    });
}

#[test]
fn a_machine_with_very_many_turns_is_built_quickly() {
    let states: Vec<String> = (0..14).map(|number| format!("s{number}")).collect();
    let all = states.join(", ");
    let codels: String = (states.iter())
        .map(|state| format!("codel <{state}> do_{state}() yield {all}, ether;"))
        .collect();
    let unit = load(&format!(
        "component c {{ version \"1\"; lang \"c\";
           task t {{ period 1 s; codel <start> begin() yield {all}; {codels} }}; }};"
    ));
    let names = Names::new(&[&unit.spec]);
    let scenario = parse("scenario x { loop 3; }").scenario;
    let settings = settings(&scenario, &published());
    counting::mark();
    assert!(!build(&names, &settings, &|_| true).has_errors());
    assert!(counting::since_mark() < 2_000_000);
}

// ---- Memory -----------------------------------------------------------------------------------

/// Bytes for the model, the report and the names, which do not grow with the number of states.
const FIXED: usize = 200_000;

#[test]
fn bytes_are_counted_truly() {
    for more in ["", MORE] {
        with(more, |input, scenario| {
            let ask = || verify(input, scenario, &published(), &Cancel::default());
            let (report, peak) = counting::peak(ask);
            let counted = report.memory;
            assert!(counted > 5 * FIXED, "only {counted} bytes: this shows nothing");
            assert!(
                counted / 4 * 3 < peak && peak < counted / 4 * 5 + FIXED,
                "{counted} bytes counted, {peak} used"
            );
        });
    }
}

#[test]
fn a_search_without_memory_gives_up_honestly() {
    let whole =
        with(MORE, |input, scenario| verify(input, scenario, &published(), &Cancel::default()));
    for bytes in [50_000, 200_000, 400_000, 800_000, 1_200_000] {
        let (report, peak) = counting::peak(|| {
            with(MORE, |input, scenario| {
                verify(input, scenario, &limited(bytes), &Cancel::default())
            })
        });
        // The specification is parsed within the measurement as well; lists of states double when they are
        // full.
        assert!(peak < 2 * bytes + 5 * FIXED, "{peak} bytes used with a limit of {bytes}");
        assert!(report.unknown());
        for (check, known) in report.checks.iter().zip(&whole.checks) {
            let text = format!("{bytes}: {} {}, {:?}", check.kind, check.of, check.value);
            // Never a proof, never a refutation of a valid check, and times are lower bounds.
            assert!(check.verdict == Verdict::Unknown || check.verdict == known.verdict, "{text}");
            assert!(check.verdict != Verdict::Proved, "{text}");
            if let (Some(Value::Time(time)), Some(Value::Time(known))) = (check.value, known.value)
            {
                assert!(time <= known, "{text}, in truth {known}");
            }
            if let (Verdict::Refuted, Some(Value::Time(time)), Some(Value::Time(limit))) =
                (check.verdict, check.value, check.bound)
            {
                assert!(time > limit, "{text}");
            }
            let says_so = check.note.as_deref().is_some_and(|note| note.starts_with("gave up at"));
            let has_run = !check.counterexample.is_empty();
            assert!(says_so || has_run, "{text}");
            let shown = check.verdict == Verdict::Refuted && check.value == Some(Value::Unbounded);
            assert!(says_so || check.value.is_none() || shown, "{text}");
        }
    }
}

/// Ten independent tasks on one core, one codel of which takes longer than the shortest period: the system
/// has too many states.
#[test]
fn a_large_search_stays_within_its_memory() {
    let periods = [5, 10, 20, 25, 40, 50, 80, 100, 125, 200];
    let ids: String = (0..10).map(|number| format!("long x{number};")).collect();
    let tasks = periods.iter().enumerate().map(|(i, period)| {
        let wcet = if i == 9 { 6_000 } else { period * 50 };
        format!(
            "task t{i} {{ period {period} ms;
               codel <start> c{i}(inout x{i}) yield pause::start wcet {wcet} us; }};"
        )
    });
    let tasks: String = tasks.collect();
    let unit =
        load(&format!("component ten {{ version \"1\"; lang \"c\"; ids {{ {ids} }}; {tasks} }};"));
    let input = SystemInput { specs: vec![&unit.spec] };
    let scenario = parse("scenario ten { cores 1; check schedulable *; check response *; }");
    let bytes = 80 << 20;
    let options = Options { limits: Limits { bytes, ..Limits::default() }, ..Options::default() };
    let ask = || verify(&input, &scenario.scenario, &options, &Cancel::default());
    let (report, peak) = counting::peak(ask);
    let stopped =
        |report: &CheckReport| report.gave_up.is_some_and(|gave_up| gave_up.reason == Stop::Memory);
    assert!(report.checks.iter().any(stopped), "{:?}", report.checks);
    // One more segment of each sequence, at most.
    assert!(peak < bytes + bytes / 8, "{peak} bytes used with a limit of {bytes}");
    assert!(report.memory > bytes / 2, "{} bytes counted", report.memory);
}

/// Returns the answers with this number of threads, and the number of threads that polled for a cancellation.
fn by_threads<T>(threads: usize, ask: impl Fn(&Options, &Cancel) -> T) -> (T, usize) {
    let seen = Arc::new(Mutex::new(HashSet::new()));
    let own = seen.clone();
    let cancel = Cancel::asking(move || {
        own.lock().unwrap().insert(std::thread::current().id());
        false
    });
    let options = Options { limits: Limits { threads, ..Limits::default() }, ..published() };
    let answer = ask(&options, &cancel);
    let looked = seen.lock().unwrap().len();
    (answer, looked)
}

#[test]
fn the_number_of_threads_changes_no_derived_answer() {
    let ask = |threads, bytes| {
        let told = Mutex::new(Vec::new());
        let (found, looked) = by_threads(threads, |options, cancel| {
            let mut options = options.clone();
            options.limits.bytes = bytes;
            let tell = |interim_result: InterimResult| {
                if let InterimResult::Asking(progress) = interim_result {
                    told.lock().unwrap().push(progress.clone());
                }
            };
            with("", |input, scenario| {
                sensitivity(input, scenario, &options, cancel, &tell).unwrap()
            })
        });
        assert_eq!(looked > 1, threads > 1, "{looked} threads of {threads}");
        let told = told.into_inner().unwrap();
        assert_eq!(told.len(), 1 + found.wcet.len() + found.period.len());
        assert!(told.is_sorted_by_key(|mutex| mutex.done));
        serde_json::to_value(found).unwrap()
    };
    // The second run has less memory for each search than some of them need.
    for bytes in [Limits::default().bytes, 400_000] {
        assert_eq!(ask(1, bytes), ask(4, bytes));
    }
}

/// Each value has a share of the states: one that is given up does not keep later ones from an answer.
#[test]
fn a_number_of_cores_that_is_given_up_is_followed_by_the_next() {
    let tasks = (0..6).map(|number| {
        let period = [20, 21, 22, 23, 25, 26][number];
        format!(
            "task t{number} {{ period {period} ms;
               codel <start> c{number}() yield pause::start wcet 3300 us; }};"
        )
    });
    let tasks: String = tasks.collect();
    let unit = load(&format!("component six {{ version \"1\"; lang \"c\"; {tasks} }};"));
    let input = SystemInput { specs: vec![&unit.spec] };
    let scenario = parse("scenario six { policy any; check schedulable *; }");
    let mut options = Options::default();
    options.limits.states = 20_000;
    let cancel = Cancel::default();
    let found = minimum_cores(&input, &scenario.scenario, &options, &cancel).unwrap();
    assert_eq!(found.tried.first(), Some(&(1, Verdict::Unknown)), "{found:?}");
    assert!(found.cores.is_some_and(|cores| cores > 1), "{found:?}");
}
