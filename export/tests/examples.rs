//! Exported models of the examples.

use std::path::Path;

use dotgen_export::{Format, Place, export};
use dotgen_timing::scn::ast::{Durations, Policy};
use dotgen_timing::scn::parse_check;
use dotgen_timing::verify::Options;

use crate::read_back::{Counts, compare_system};
use crate::systems::System;

fn example(path: &str) -> System {
    System::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(path))
}

fn pump(format: Format) -> String {
    let system = example("pump/pump.scn");
    files(&system, &|component, src| system.place(component, src), format)
}

fn files(system: &System, place: &Place, format: Format) -> String {
    let files = export(&system.prepared(&Options::default()), place, format);
    let files = files.expect("the example can be exported");
    let texts = files.iter().filter(|file| !file.name.ends_with(".xml"));
    let texts = texts.map(|file| format!("===== {} =====\n{}", file.name, file.text));
    texts.collect()
}

#[test]
fn pump_for_uppaal() {
    insta::assert_snapshot!(pump(Format::Uppaal));
}

/// The drawing has the locations, edges and queries of the text, each location in a place of its own.
#[test]
fn pump_as_a_drawing() {
    let prepared = example("pump/pump.scn").prepared(&Options::default());
    let files = export(&prepared, &|_, _| None, Format::Uppaal).expect("it is exported");
    let [network, queries, drawing] = &files[..] else { panic!("three files") };
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(&drawing.text, options);
    let document = document.expect("the drawing is XML");
    let elements = |name: &str| {
        document.descendants().filter(|node| node.has_tag_name(name)).collect::<Vec<_>>()
    };
    assert_eq!(elements("template").len(), network.text.matches("\nprocess ").count());
    assert_eq!(elements("transition").len(), network.text.matches(" -> ").count());
    let formulas = elements("formula");
    let asked = queries.text.lines().filter(|line| line.contains("A[]") || line.contains("sup{"));
    let asked: Vec<&str> = asked.collect();
    assert_eq!(formulas.iter().filter_map(roxmltree::Node::text).collect::<Vec<_>>(), asked);
    for template in elements("template") {
        let locations = template.children().filter(|node| node.has_tag_name("location"));
        let mut places: Vec<_> =
            locations.map(|location| (location.attribute("x"), location.attribute("y"))).collect();
        let count = places.len();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), count, "two locations in one place");
    }
    let guards = elements("label").into_iter().filter_map(|label| label.text());
    assert!(guards.into_iter().any(|text| text == "t_pump_control <= 20"));
}

#[test]
fn durations_are_in_the_header() {
    let text = |durations| {
        let options = Options { durations: Some(durations), ..Options::default() };
        let prepared = example("pump/pump.scn").prepared(&options);
        let files = export(&prepared, &|_, _| None, Format::TChecker).expect("it is exported");
        files.into_iter().map(|file| file.text).collect::<String>()
    };
    let (open, fixed) = (text(Durations::Open), text(Durations::Fixed));
    assert!(open.contains("\n# durations: explored from 0 on"), "{open}");
    assert!(fixed.contains("\n# durations: every codel takes exactly its worst case"), "{fixed}");
}

#[test]
fn pump_for_tchecker() {
    insta::assert_snapshot!(pump(Format::TChecker));
}

/// Returns the model of a task with one codel, without the scheduler and the variables.
fn small(format: Format) -> String {
    let specification = "component c { version \"1\"; lang \"c\"; task t { period 5 ms;
        codel<start> a() yield pause::start wcet 1 ms; }; };";
    let scenario = "scenario s { semantics servers; unit 1 ms; durations interval;
        check schedulable c.t; }";
    let system = System::of_texts(&[specification.to_owned()], scenario).expect("no errors");
    let text = files(&system, &|_, _| None, format);
    let (first, rest) = text.split_once("// what follows an action at once").expect("a scheduler");
    let (_, last) = rest.split_once("// the system\n").expect("a system");
    format!("{first}// …\n\n// the system\n{last}")
}

#[test]
fn small_system_in_fiacre() {
    insta::assert_snapshot!(small(Format::Fiacre));
}

#[test]
fn small_system_in_bip() {
    insta::assert_snapshot!(small(Format::Bip));
}

/// Clients, queues and observers in the languages in which the pump has thousands of lines.
#[test]
fn pump_in_fiacre_and_bip() {
    let fiacre = pump(Format::Fiacre);
    for part in [
        "\n    request_operator_pump_fill_client_operator_control_task_pump : sync,\n",
        "\n        restart_passed_job_pump_control_a_18 := 1;\n",
        "\n        sender_pump := 1;\n        at_pump := 0;\n        to places_fill\n",
    ] {
        assert!(fiacre.contains(part), "{part}");
    }
    let bip = pump(Format::Bip);
    for part in [
        "\n  data int core_queue_0, core_queue_1, core_queue_2\n",
        "\n  clock job_pump_control_a unit microsecond\n",
        "\n  connector Pair c_scheduler__settles_to_busy__task_pump_report__waits_to_begins(\
         scheduler.settles_to_busy, task_pump_report.waits_to_begins, \
         store.scheduler__settles_to_busy__task_pump_report__waits_to_begins)\n",
    ] {
        assert!(bip.contains(part), "{part}");
    }
}

/// Returns the refusals of the pump with options.
fn refusals(options: &Options) -> Vec<String> {
    let prepared = example("pump/pump.scn").prepared(options);
    let refusals =
        export(&prepared, &|_, _| None, Format::Uppaal).expect_err("the options are refused");
    refusals.iter().map(ToString::to_string).collect()
}

#[test]
fn what_is_not_translated_is_refused_by_name() {
    let edf = Options { policy: Some(Policy::Edf), ..Options::default() };
    assert_eq!(refusals(&edf), ["not exported: `policy edf`"]);
    let mixed = "scenario s { semantics published; locks fifo; check deadlock; }";
    let text = "component c { ids { long f; }; };".to_owned();
    let system = System::of_texts(&[text], mixed).expect("the specification has no error");
    let prepared = system.prepared(&Options::default());
    let refused = export(&prepared, &|_, _| None, Format::Uppaal).expect_err("it is refused");
    assert_eq!(refused[0].to_string(), "not exported: `semantics published with locks fifo`");
}

#[test]
fn fiacre_and_bip_have_neither_deadlocks_nor_greatest_times() {
    let checks =
        ["deadlock", "response pump.control"].map(|check| parse_check(check).expect(check));
    for check in checks {
        let options = Options { checks: check.clone(), ..Options::default() };
        let prepared = example("pump/pump.scn").prepared(&options);
        for (format, tool) in [(Format::Fiacre, "Fiacre"), (Format::Bip, "BIP")] {
            let refusals = export(&prepared, &|_, _| None, format).expect_err("refused");
            let refusals: Vec<String> = refusals.iter().map(ToString::to_string).collect();
            let [refusal] = &refusals[..] else { panic!("{refusals:?}") };
            assert!(refusal.contains(tool), "{refusal}");
        }
        assert!(export(&prepared, &|_, _| None, Format::Uppaal).is_ok());
    }
}

/// `a_b` with the task `c`, and `a` with the task `b_c`; a client with the name of a component.
#[test]
fn parts_with_one_name_get_a_number() {
    let component = |name: &str, task: &str| {
        format!(
            "component {name} {{ version \"1\"; lang \"c\"; task {task} {{ period 5 ms;
             codel<start> {name}_{task}() yield pause::start wcet 1 ms; }};
             function f() {{}}; }};"
        )
    };
    let texts = [component("a_b", "c"), component("a", "b_c")];
    let scenario = "scenario s { semantics servers; unit 1 ms; client a { send a.f; }
        check schedulable *; }";
    let system = System::of_texts(&texts, scenario).expect("no errors");
    let mut counts = Counts::default();
    compare_system(&system, "two components", 20_000, &mut counts);
    assert_eq!((counts.refused, counts.equal), (0, 2), "{counts:?}");
    for format in [Format::Uppaal, Format::TChecker, Format::Fiacre, Format::Bip] {
        let files = export(&system.prepared(&Options::default()), &|_, _| None, format);
        let text = files.expect("it is exported").swap_remove(0).text;
        for line in [
            "the task `a.b_c` is named `a_b_c_2`: the name `a_b_c` was taken",
            "the client `a` is named `a_2`: the name `a` was taken",
        ] {
            assert!(text.contains(line), "{text}");
        }
    }
}

#[test]
fn a_predicate_without_a_moment_is_refused() {
    let specification = "component c { version \"1\"; lang \"c\"; task t { period 5 ms;
        codel<start> a() yield pause::start wcet 1 ms; }; };";
    let scenario = "scenario s { semantics servers; unit 1 ms;
        check never leave c.t.start.exec or not leave c.t.start.exec; }";
    let system = System::of_texts(&[specification.to_owned()], scenario).expect("no errors");
    let prepared = system.prepared(&Options::default());
    let found = export(&prepared, &|_, _| None, Format::Uppaal).expect_err("it is refused");
    let [refusal] = &found[..] else { panic!("{found:?}") };
    assert!(refusal.to_string().starts_with("not exported: `not leave`"), "{refusal}");
}

#[test]
fn a_time_without_a_limit_is_refused_where_there_is_no_greatest_value() {
    let specification = "component c { version \"1\"; lang \"c\"; task t { period 5 ms;
        codel<start> a() yield pause::start wcet 1 ms; }; };";
    let scenario = "scenario s { semantics servers; unit 1 ms; check slow: response c.t; }";
    let system = System::of_texts(&[specification.to_owned()], scenario).expect("no errors");
    let prepared = system.prepared(&Options::default());
    let refused =
        |format| export(&prepared, &|_, _| None, format).err().map_or(0, |found| found.len());
    let formats = [Format::Uppaal, Format::TChecker, Format::Fiacre, Format::Bip];
    assert_eq!(formats.map(refused), [0, 1, 1, 1]);
    // Another check of the same time has a limit.
    let scenario = scenario
        .replace("check slow: response c.t;", "check response c.t; check response c.t <= 5 ms;");
    let system = System::of_texts(&[specification.to_owned()], &scenario).expect("no errors");
    let prepared = system.prepared(&Options::default());
    let refused =
        |format| export(&prepared, &|_, _| None, format).err().map_or(0, |found| found.len());
    assert_eq!(formats.map(refused), [0, 1, 1, 1]);
}

#[test]
fn asynchronous_codels_with_a_thread_of_their_own_are_refused() {
    let specification = "component c { version \"1\"; lang \"c\"; task t { period 5 ms;
        async codel<start> a() yield pause::start wcet 1 ms; }; };";
    let scenario = "scenario s { semantics servers; unit 1 ms; async free; check schedulable *; }";
    let system = System::of_texts(&[specification.to_owned()], scenario).expect("no errors");
    let prepared = system.prepared(&Options::default());
    let found = export(&prepared, &|_, _| None, Format::Uppaal).expect_err("it is refused");
    let found: Vec<String> = found.iter().map(ToString::to_string).collect();
    assert_eq!(found, ["not exported: `async free` of c.t"]);
}
