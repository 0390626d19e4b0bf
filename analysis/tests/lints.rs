//! Each lint: the example of its manual page triggers it, a near miss does not; suppression comments; and
//! findings in real specifications.

mod fixes;

use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_analysis::{
    codes::lints::CODES,
    diagnostic::{Diagnostic, Severity},
    host::{AnalysisHost, BatchInput, Change, Config, Input},
};
use dotgen_loaders::{Disk, pages::Page};
use expect_test::expect;

fn check(input: BatchInput, config: Config) -> Vec<Diagnostic> {
    let mut host = AnalysisHost::new(Arc::new(Disk));
    host.apply(Change { config: Some(config), ..Change::default() });
    host.analysis().batch(&input).unwrap().diagnostics.to_vec()
}

/// A configuration that enables each rule.
fn strict() -> Config {
    let mut config = Config::default();
    config.lints.cores = Some(1);
    for code in CODES.iter().filter(|code| !code.on) {
        let severity = Some(dotgen_analysis::diagnostic::Severity::Hint);
        config.severities.push((code.id.to_owned(), severity));
    }
    config
}

fn text(text: &str) -> BatchInput {
    let input = Input::Text { name: "/fixture/main.gen".into(), text: text.into() };
    BatchInput { inputs: vec![input], ..BatchInput::default() }
}

fn codes_of(source: &str) -> Vec<&'static str> {
    let found = check(text(source), strict());
    if let Some(error) = found
        .iter()
        .find(|check| check.severity == Severity::Error && !check.code.starts_with("fsm/un"))
    {
        panic!("the fixture is rejected: {}: {}\n{source}", error.code, error.message);
    }
    found.iter().map(|check| check.code).collect()
}

#[test]
fn each_codel_without_execution_time_is_named() {
    let spec = "component c { task t { period 5 ms; codel<start> f() yield a wcet 1 ms; \
                codel<a> g() yield pause::b; codel<b> h() yield pause::a; }; };";
    let found = check(text(spec), strict());
    let missing = found.iter().filter(|check| check.code == "timing/missing-wcet");
    let messages: Vec<String> = missing.map(|check| check.message.to_string()).collect();
    let of = |codel: &str| {
        format!(
            "codel `{codel}` has no execution time and counts as taking none; add `wcet` with the measured \
             worst case"
        )
    };
    assert_eq!(messages, [of("g"), of("h")]);
}

#[test]
fn deviations_from_the_compiler_are_remarks() {
    let spec = "const char c = 'x';\nunion u switch (enum e { a, b }) { case a: long x; };\n\
                const unsigned long n = 0xFFFFFFFF;\nconst long long m = -(2147483648);\n\
                component k { ids { long x; }; task t { codel<start> f(in x) yield ether; };\n\
                attribute a(in x = 4294967296 - 4294967295); };\n";
    let found = check(text(spec), Config::default());
    let all = found.iter().filter(|check| check.code == "genom3/deviation");
    let shown: Vec<String> = all
        .inspect(|check| assert_eq!(check.severity, Severity::Information))
        .map(|check| format!("{}: {}\n", &spec[check.range.clone()], check.message))
        .collect();
    assert!(found.iter().all(|check| check.severity != Severity::Error), "{found:?}");
    expect![[r"
        'x': genom3 refuses the character 'x' (deviation D03): it converts a character literal to no type; write it as a string of one character, which both accept
        enum e { a, b }: genom3 refuses the union `u` (deviation D04): its switch is an enum declared in place; declare the enum before the union
        0xFFFFFFFF: genom3 reads `0xFFFFFFFF` as -1 (deviation D07): it keeps 32 bits of an integer, and refuses the value where it no longer fits; keep integers below 2147483648 if genom3 must read the specification
        2147483648: genom3 reads `2147483648` as -2147483648 (deviation D07): it keeps 32 bits of an integer, and refuses the value where it no longer fits; keep integers below 2147483648 if genom3 must read the specification
        4294967296: genom3 reads `4294967296` as 0 (deviation D07): it keeps 32 bits of an integer, and refuses the value where it no longer fits; keep integers below 2147483648 if genom3 must read the specification
        4294967295: genom3 reads `4294967295` as -1 (deviation D07): it keeps 32 bits of an integer, and refuses the value where it no longer fits; keep integers below 2147483648 if genom3 must read the specification
    "]]
    .assert_eq(&shown.concat());

    let mut off = Config::default();
    off.severities.push(("genom3/deviation".to_owned(), None));
    let found = check(text(spec), off);
    assert!(found.iter().all(|check| check.code != "genom3/deviation"), "{found:?}");
    let allowed = "// dotgen: allow(genom3/deviation) read by dotgen only\nconst char c = 'x';\n";
    assert_eq!(check(text(allowed), Config::default()), []);
}

#[test]
fn every_finding_of_the_examples_can_be_allowed_at_its_place() {
    for code in CODES {
        let page = Page::read(code.id).unwrap();
        for source in page.texts("genom", false) {
            let mut source = source.to_owned();
            // Another round for each finding of the code: each has its own declaration.
            for _ in 0..8 {
                let mut host = AnalysisHost::new(Arc::new(Disk));
                let path = Utf8PathBuf::from("/fixture/main.gen");
                host.apply(Change {
                    files: vec![(path.clone(), Some(source.clone()))],
                    config: Some(strict()),
                    ..Change::default()
                });
                let analysis = host.analysis();
                let all = analysis.diagnostics(&path).unwrap();
                let mut found = all.iter().filter(|check| check.code == code.id);
                let Some(fix) = found.find_map(|check| analysis.allowing(check).unwrap()) else {
                    break;
                };
                for edit in fix.edits {
                    source.replace_range(edit.range, &edit.new_text);
                }
            }
            let found = codes_of(&source);
            let is_rule = !code.id.starts_with("lint/") && code.severity != Severity::Error;
            assert_ne!(found.contains(&code.id), is_rule, "{}: {found:?}\n{source}", code.id);
        }
    }
}

#[test]
fn every_example_triggers_its_code() {
    for code in CODES {
        let page = Page::read(code.id).unwrap();
        assert!(!page.texts("genom", false).is_empty(), "{}", code.id);
        for corrected in [false, true] {
            for text in page.texts("genom", corrected) {
                let found = codes_of(text);
                assert_ne!(found.contains(&code.id), corrected, "{}: {found:?}\n{text}", code.id);
            }
        }
    }
}

/// For each code, a specification that nearly triggers it.
const NEAR_MISSES: &[(&str, &str)] = &[
    (
        "fsm/busy-loop",
        "component c { task t { period 5 ms; codel<start> f() yield main; codel<main> g() yield \
            pause::main, ether; }; };",
    ),
    (
        "fsm/no-termination",
        "component c { exception e; task t { period 5 ms; }; activity a() { task t; throw e; codel<start> \
            f() yield run; codel<run> g() yield run; }; };",
    ),
    (
        "fsm/pause-in-aperiodic-task",
        "component c { task t { period 1 s; codel<start> f() yield pause::start, ether; }; };",
    ),
    (
        "fsm/dead-end",
        "component c { task t { period 1 s; codel<start> f() yield a, b; codel<a> g() yield ether; codel<b> \
            h() yield ether; }; };",
    ),
    (
        "fsm/codel-named-as-event",
        "component c { task t { period 1 s; codel<start> c_t_start() yield pause::start, ether; }; };",
    ),
    (
        "fsm/missing-stop",
        "component c { ids { long speed; }; task t { period 5 ms; }; activity go() { task t; interrupts go; \
            codel<start> f(out speed) yield pause::start, ether; codel<stop> g(out speed) yield ether; }; };",
    ),
    (
        "port/write-race",
        "struct s { long x; }; component c { port out s p; task t { period 5 ms; codel<start> f(out p) \
            yield pause::main; codel<main> h(out p) yield pause::main; }; task u { period 5 ms; \
            codel<start> g(out p) yield ether; }; };",
    ),
    (
        "port/never-written",
        "struct s { long x; }; component c { port out s p; task t { codel<start> f(out p) yield ether; }; };",
    ),
    (
        "port/never-read",
        "struct s { long x; }; component c { port in s p; task t { codel<start> f(in p) yield ether; }; };",
    ),
    (
        "ids/never-written",
        "component k { ids { long x; }; task t { codel<start> f(in x) yield ether; }; attribute set(in x); \
            };",
    ),
    (
        "ids/never-read",
        "component c { ids { long x; }; task t { codel<start> f(out ::ids) yield ether; }; attribute \
            get(out x); };",
    ),
    (
        "ids/read-before-write",
        "component c { ids { long x; }; task t { period 5 ms; codel<start> i(out x) yield main; codel<main> \
            f(in x) yield pause::main; }; attribute set(in x); };",
    ),
    (
        "lock/long-hold",
        "component c { ids { long x; long y; }; task slow { period 1 s; codel<start> f(out x) yield \
            pause::start wcet 100 ms; }; task fast { period 10 ms; codel<start> g(in y) yield pause::start \
            wcet 1 ms; }; };",
    ),
    (
        "lock/self-blocking",
        "component c { ids { long x; }; task t { period 5 ms; }; activity a() { task t; local long z; async \
            codel<start> f(out z) yield copy; codel<copy> k(in z, out x) yield ether; }; activity b() { \
            task t; codel<start> g(in x) yield ether; }; };",
    ),
    (
        "timing/missing-wcet",
        "component c { task t { period 5 ms; codel<start> f() yield main; codel<main> g() yield \
            pause::main; }; };",
    ),
    (
        "timing/wcet-exceeds-period",
        "component c { task t { period 5 ms; codel<start> f() yield pause::main wcet 3 ms; codel<main> g() \
            yield pause::main wcet 4 ms; }; };",
    ),
    (
        "timing/overutilised",
        "component c { task t { period 10 ms; codel<start> f() yield pause::start wcet 4 ms; }; task u { \
            period 10 ms; codel<start> g() yield pause::start wcet 4 ms; }; };",
    ),
    (
        "timing/no-period",
        "component c { task t { period 1 s; codel<start> f() yield pause::start wcet 1 ms; }; };",
    ),
    (
        "timing/suspicious-unit",
        "component c { task t { period 5 s; codel<start> f() yield pause::start wcet 26 ms; }; };",
    ),
    (
        "service/concurrent-instances",
        "component c { ids { long x; }; task t { period 5 ms; }; activity go() { task t; interrupts go; \
            codel<start> f(out x) yield pause::start, ether; }; };",
    ),
    (
        "service/blind-validate",
        "component c { ids { long x; }; attribute set(in x) { validate check(local in x); }; };",
    ),
    ("service/long-function", "component c { function f() { codel g() wcet 200 us; }; };"),
    (
        "service/order-cycle",
        "component c { function f() { before g; }; function g() { after f; }; };",
    ),
    (
        "unused/exception",
        "component c { exception e_used; task t { throw e_used; codel<start> f() yield ether; }; };",
    ),
    (
        "unused/type",
        "component c { struct s { long x; }; port out s p; task t { codel<start> f(out p) yield ether; }; };",
    ),
    (
        "unused/local",
        "component c { task t { period 1 s; }; activity a() { task t; local long x; codel<start> f(out x) \
            yield ether; }; };",
    ),
    ("style/missing-doc", "component c { doc \"d\"; function f() { doc \"e\"; }; };"),
    (
        "style/naming",
        "component c { function set_speed(); function get_speed(); function stop(); };",
    ),
    ("style/order", "component c { ids { long x; }; attribute a(in x); function f(); };"),
    (
        "genom3/deviation",
        "const char c = \"x\"; const long n = 0x7fffffff; enum e { a, b }; \
         union u switch (e) { case a: long x; };",
    ),
    (
        "lint/unused-suppression",
        "component c {\n// dotgen: allow(service/order-cycle) on purpose\nfunction f() { before g; };\nfunction g() { before f; };\n};",
    ),
    (
        "lint/no-reason",
        "component c {\n// dotgen: allow(service/order-cycle) on purpose\nfunction f() { before g; };\nfunction g() { before f; };\n};",
    ),
];

#[test]
fn no_near_miss_triggers_its_code() {
    for code in CODES {
        let Some((_, near)) = NEAR_MISSES.iter().find(|miss| miss.0 == code.id) else {
            panic!("{} has no near miss", code.id);
        };
        let found = codes_of(near);
        assert!(!found.contains(&code.id), "{}: {near}", code.id);
    }
}

#[test]
fn rules_of_taste_are_off_by_default() {
    let found = check(text("component c { function f(); };"), Config::default());
    assert!(found.iter().all(|check| !check.code.starts_with("style/")), "{found:?}");
}

#[test]
fn a_comment_allows_a_finding_where_it_stands() {
    let circle = |comment: &str, place: &str| {
        let (above, behind) = if place == "above" { (comment, "") } else { ("", comment) };
        let source = format!(
            "component c {{\n  {above}\n  function f() {{ before g; }}; {behind}\n  function g() {{ before f; }};\n}};\n"
        );
        codes_of(&source)
    };
    let comment = "// dotgen: allow(service/order-cycle) both are slow";
    assert!(circle("", "above").contains(&"service/order-cycle"));
    for place in ["above", "behind"] {
        let found = circle(comment, place);
        assert!(
            !found.contains(&"service/order-cycle") && !found.contains(&"lint/unused-suppression"),
            "{place}: {found:?}"
        );
    }
    let found = circle("// dotgen: allow(port/write-race) why", "above");
    assert!(
        found.contains(&"service/order-cycle") && found.contains(&"lint/unused-suppression"),
        "{found:?}"
    );
}

/// The specifications of the shared test data that represent software in use.
fn corpus() -> Vec<(Utf8PathBuf, Utf8PathBuf)> {
    let mut out = Vec::new();
    let shared = dotgen_loaders::optional("corpus");
    let Some(shared) = shared.and_then(|path| Utf8PathBuf::from_path_buf(path).ok()) else {
        return out;
    };
    for (folder, include) in
        [("components", "components/standins"), ("robnav", "robnav"), ("quadcopter", "quadcopter")]
    {
        let Ok(entries) = shared.join(folder).read_dir_utf8() else {
            continue;
        };
        for entry in entries.flatten().filter(|entry| entry.path().is_dir()) {
            let Ok(files) = entry.path().read_dir_utf8() else {
                continue;
            };
            for file in files.flatten() {
                if file.path().extension() == Some("gen") {
                    out.push((file.path().to_owned(), shared.join(include)));
                }
            }
        }
    }
    out.sort();
    out
}

#[test]
fn real_specifications_are_healthy() {
    let mut report = String::new();
    for (path, include) in corpus() {
        let lines = std::fs::read_to_string(&path).unwrap().lines().count();
        let input = BatchInput {
            inputs: vec![Input::File(path.clone())],
            include_dirs: vec![include],
            ..BatchInput::default()
        };
        let found = check(input, Config::default());
        let count = |severity| found.iter().filter(|check| check.severity == severity).count();
        assert_eq!(count(Severity::Error), 0, "{path}: {found:#?}");
        let warnings = count(Severity::Warning);
        assert!(warnings * 100 <= lines.max(100), "{path}: {warnings} warnings in {lines} lines");
        let name = path.file_name().unwrap_or_default();
        let text = std::fs::read_to_string(&path).unwrap();
        for check in found.iter().filter(|check| check.path == path) {
            let line = 1 + text[..check.range.start].matches('\n').count();
            let severity = format!("{:?}", check.severity).to_lowercase();
            report.push_str(&format!(
                "{name}:{line}: {severity} {}: {}\n",
                check.code, check.message
            ));
        }
    }
    if !report.is_empty() {
        // Reviewed: each line must be something its author would want to know.
        expect![[r"
            arucotag.gen:91: hint fsm/busy-loop: state cycle without pause in task `detect`: poll → poll; the task can be kept busy by it for any time; yield `pause::poll` if each round may wait
            d435.gen:47: hint unused/exception: exception `e_mem` is never thrown
            d435.gen:69: hint fsm/busy-loop: state cycle without pause in task `main`: poll → pub → poll; the task can be kept busy by it for any time; yield `pause::poll` if each round may wait
            d435.gen:69: information lock/self-blocking: codel `d435_main_poll` of task `main` runs asynchronously with `info.started` of the ids and `pipe` of the ids, which codel `d435_connect` of activity `connect` of the same task `main` also uses: the task goes on meanwhile and must wait for it, or both touch the data at once; copy what the asynchronous codel needs into a `local` variable
            maneuver.gen:45: hint unused/type: type `motion` is never used
            maneuver.gen:135: hint fsm/missing-stop: activity `take_off` can be interrupted (by `take_off`) and writes the ids `trajectory`, but has no `codel<stop>` to leave it in a consistent state
            maneuver.gen:155: hint fsm/missing-stop: activity `goto` can be interrupted (by `take_off`) and writes the ids `trajectory`, but has no `codel<stop>` to leave it in a consistent state
            maneuver.gen:219: hint fsm/missing-stop: activity `replay` can be interrupted (by `take_off`) and writes the ids `trajectory`, but has no `codel<stop>` to leave it in a consistent state
            maneuver.gen:247: hint fsm/missing-stop: activity `stop` can be interrupted (by `take_off`) and writes the ids `trajectory`, but has no `codel<stop>` to leave it in a consistent state
            maneuver.gen:247: hint service/concurrent-instances: activity `stop` does not interrupt itself: two requests run two instances in turn, and both write `trajectory`; add `interrupts stop;` if only one should be active
            nhfc.gen:169: information fsm/busy-loop: state cycle without pause in task `main`: control → emergency → control; within one period it can go round any number of times, so its execution time has no bound; yield `pause::control` if each round may wait
            nhfc.gen:187: hint fsm/missing-stop: activity `servo` can be interrupted (by `servo`) and writes the ids `reference`, but has no `codel<stop>` to leave it in a consistent state
            nhfc.gen:258: hint fsm/missing-stop: activity `set_wo_zero` can be interrupted (by `set_wo_zero`) and writes the ids `bias`, but has no `codel<stop>` to leave it in a consistent state
            realsense.gen:48: hint unused/exception: exception `e_mem` is never thrown
            realsense.gen:107: hint fsm/busy-loop: state cycle without pause in task `visual`: sleep → poll → sleep; the task can be kept busy by it for any time; yield `pause::sleep` if each round may wait
            realsense.gen:121: hint fsm/busy-loop: state cycle without pause in task `inertial`: sleep → poll → sleep; the task can be kept busy by it for any time; yield `pause::sleep` if each round may wait
            realsense.gen:135: hint fsm/busy-loop: state cycle without pause in task `depth`: sleep → poll → sleep; the task can be kept busy by it for any time; yield `pause::sleep` if each round may wait
            maneuver.gen:33: hint unused/exception: exception `e_sys` is never thrown
            maneuver.gen:152: hint fsm/missing-stop: activity `waypoint` can be interrupted (by `waypoint`) and writes the ids `start`, but has no `codel<stop>` to leave it in a consistent state
            maneuver.gen:190: information fsm/busy-loop: state cycle without pause in task `exec`: wait → main → wait; within one period it can go round any number of times, so its execution time has no bound; yield `pause::wait` if each round may wait
            mikrokopter.gen:35: hint unused/exception: exception `e_baddev` is never thrown
            mikrokopter.gen:38: hint unused/exception: exception `e_range` is never thrown
            mikrokopter.gen:43: warning port/write-race: port `imu` is written by codels of different tasks (`main` and `comm`): which value readers see depends on scheduling; let one task write it, or give each its own port
            mikrokopter.gen:210: hint fsm/busy-loop: state cycle without pause in task `comm`: poll → nodata → poll; the task can be kept busy by it for any time; yield `pause::poll` if each round may wait
            mikrokopter.gen:215: hint fsm/busy-loop: state cycle without pause in task `comm`: recv → recv; the task can be kept busy by it for any time; yield `pause::recv` if each round may wait
            nhfc.gen:35: hint unused/exception: exception `e_sys` is never thrown
            optitrack.gen:28: hint unused/exception: exception `e_connection` is never thrown
            optitrack.gen:28: hint unused/exception: exception `e_timeout` is never thrown
            optitrack.gen:29: hint unused/exception: exception `e_addrinfo` is never thrown
            optitrack.gen:30: hint unused/exception: exception `e_network` is never thrown
            optitrack.gen:31: hint unused/exception: exception `e_access` is never thrown
            optitrack.gen:32: hint unused/exception: exception `e_publish` is never thrown
            pom.gen:31: hint port/never-read: no codel reads the input port `bodies`
            roblaser.gen:21: hint unused/exception: exception `INVALID_RANGE` is never thrown
            robloco.gen:20: hint unused/exception: exception `INVALID_RECT` is never thrown
            robloco.gen:25: hint port/never-read: no codel reads the input port `E_real_map`
            robmap.gen:18: hint ids/never-read: the ids member `explored_map` is written, but nothing ever reads it
            robmotion.gen:15: hint ids/never-read: the ids member `current_speed` is written, but nothing ever reads it
            robmotion.gen:85: hint fsm/missing-stop: activity `GotoPosition` can be interrupted (by `GotoPosition`) and writes the ids `goal_position`, but has no `codel<stop>` to leave it in a consistent state
        "]].assert_eq(&report);
    }
}
