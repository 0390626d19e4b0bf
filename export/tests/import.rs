//! Traces come home: a counterexample that the reader of `.xta` finds, printed in the form of UPPAAL or
//! TChecker, becomes a run of the verifier.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use dotgen_export::model::Network;
use dotgen_export::{Format, Imported, export, import, translate};
use dotgen_timing::explore::Limits as WatchLimits;
use dotgen_timing::report::Verdict;
use dotgen_timing::scn::parse_check;
use dotgen_timing::verify::{Options, Prepared};
use dotgen_xta::{Answer, Limits, Trace};

use crate::random_systems::{published, random};
use crate::systems::{Dice, System};

/// Limit on symbolic states of a query.
const STATES: usize = 3_000;

/// The states of a trace: locations and values, and the edges of each transition with its time.
struct States<'t> {
    trace: &'t Trace,
    locations: Vec<(String, String)>,
    values: BTreeMap<String, i32>,
}

impl<'t> States<'t> {
    fn new(network: &Network, trace: &'t Trace) -> Self {
        let first = |process: &dotgen_export::model::Process| {
            (process.name.clone(), process.locations[0].name.clone())
        };
        let names = network.variables.iter().flat_map(|variable| {
            let elements = 0..variable.size.unwrap_or(1);
            elements.map(|index| match variable.size {
                Some(_) => format!("{}[{index}]", variable.name),
                None => variable.name.clone(),
            })
        });
        States {
            trace,
            locations: network.processes.iter().map(first).collect(),
            values: names.map(|name| (name, 0)).collect(),
        }
    }

    /// Takes a transition, and returns the process, source and target of each edge.
    fn take(&mut self, step: &'t dotgen_xta::Step) -> Vec<(&'t str, &'t str, &'t str)> {
        let edges = step.transition.split(", ").map(|edge| {
            let (source, target) = edge.split_once(" -> ").expect("an edge");
            let (process, source) = source.split_once('.').expect("a location");
            (process, source, target)
        });
        let edges: Vec<_> = edges.collect();
        for (process, _, target) in &edges {
            let own = self.locations.iter_mut().find(|pair| pair.0 == *process);
            (*target).clone_into(&mut own.expect("a process").1);
        }
        for change in &step.changes {
            *self.values.get_mut(&change.variable).expect("a variable") = change.after;
        }
        edges
    }

    fn values(&self, between: &str) -> String {
        let values = self.values.iter().map(|(name, value)| format!("{name}={value}"));
        values.collect::<Vec<_>>().join(between)
    }

    /// Returns the delay to a transition. The reader of `.xta` gives the infimum of times: a limit is only
    /// exceeded later.
    fn delay(&self, number: usize, is_strict: bool) -> String {
        let steps = &self.trace.steps;
        let before = number.checked_sub(1).map_or(0, |before| steps[before].time);
        let half = if is_strict && number + 1 == steps.len() { ".5" } else { "" };
        format!("{}{half}", steps[number].time - before)
    }

    fn for_uppaal(mut self, delays: Option<bool>) -> String {
        let mut out = "Verifying formula 1\n -- Formula is NOT satisfied.\n".to_owned();
        out.push_str("Showing counter example.\n");
        self.uppaal_state(&mut out);
        for (index, step) in self.trace.steps.iter().enumerate() {
            let delay = delays.map(|is_strict| self.delay(index, is_strict));
            if let Some(delay) = delay.filter(|delay| delay != "0") {
                let _ = writeln!(out, "\nDelay: {delay}");
                self.uppaal_state(&mut out);
            }
            out.push_str("\nTransitions:\n");
            for (process, source, target) in self.take(step) {
                let _ = writeln!(out, "  {process}.{source}->{process}.{target} {{ 1, tau, 1 }}");
            }
            self.uppaal_state(&mut out);
        }
        out
    }

    fn uppaal_state(&self, out: &mut String) {
        let locations = self.locations.iter().map(|(process, name)| format!("{process}.{name}"));
        let locations: Vec<_> = locations.collect();
        let (locations, values) = (locations.join(" "), self.values(" "));
        let clocks = "t(0)-x_c<=0 x_c-t_c<3 t(0)-#t=-2";
        let _ = writeln!(out, "\nState:\n( {locations} )\n{values} {clocks} #depth=0");
    }

    fn for_tchecker(mut self, delays: Option<bool>) -> String {
        let mut out = "REACHABLE true\n\ndigraph tank {\n".to_owned();
        self.tchecker_node(0, "initial=\"true\", ", &mut out);
        for (index, step) in self.trace.steps.iter().enumerate() {
            let edges = self.take(step);
            self.tchecker_node(index + 1, "", &mut out);
            let event = step.channel.as_deref().unwrap_or("alone");
            let edges: Vec<_> = edges.iter().map(|edge| format!("{}@{event}", edge.0)).collect();
            let delay = delays.map(|is_strict| {
                let delay = self.delay(index, is_strict);
                match delay.strip_suffix(".5").and_then(|whole| whole.parse::<i64>().ok()) {
                    Some(whole) => format!("{}/2", 2 * whole + 1),
                    None => delay,
                }
            });
            let delay = delay.map_or(String::new(), |delay| format!("delay=\"{delay}\", "));
            let _ = writeln!(
                out,
                "  {index} -> {} [{delay}guard=\"\", reset=\"\", vedge=\"<{}>\"]",
                index + 1,
                edges.join(",")
            );
        }
        out.push_str("}\n");
        out
    }

    fn tchecker_node(&self, number: usize, more: &str, out: &mut String) {
        let locations: Vec<&str> = self.locations.iter().map(|pair| pair.1.as_str()).collect();
        let _ = writeln!(
            out,
            "  {number} [{more}intval=\"{}\", labels=\"\", vloc=\"<{}>\", zone=\"(0<=x && y-x<1)\"]",
            self.values(","),
            locations.join(",")
        );
    }
}

/// A failure of a check, found in the exported network.
struct Found {
    prepared: Prepared,
    network: Network,
    trace: Trace,
}

/// Returns a failure or witness of each check of a system that a trace shows.
fn found(system: &System, options: &Options) -> Vec<Found> {
    let prepared = system.prepared(options);
    let mut out = Vec::new();
    for check in &prepared.checks {
        let mut alone = prepared.clone();
        alone.checks = vec![check.clone()];
        let Ok(files) = export(&alone, &|_, _| None, Format::Uppaal) else { continue };
        let network = translate(&alone, &|_, _| None).expect("it was exported");
        let read = dotgen_xta::read(&files[0].text).expect("the model is UPPAAL's");
        for query in dotgen_xta::queries(&files[1].text).expect("the queries are UPPAAL's") {
            let limits = Limits { states: STATES, ..Limits::default() };
            match read.answer(&query, &limits) {
                Answer::Holds { trace: Some(trace), .. }
                | Answer::Fails { trace: Some(trace), .. } => {
                    out.push(Found { prepared: alone.clone(), network: network.clone(), trace });
                }
                _ => {}
            }
        }
    }
    out
}

/// Imports a failure in all forms. Returns the imports.
fn imported(found: &Found) -> Vec<Imported> {
    let Found { prepared, network, trace } = found;
    let states = || States::new(network, trace);
    let mut out = Vec::new();
    let mut is_strict = false;
    for has_delays in [false, true] {
        let delays = has_delays.then_some(is_strict);
        for text in [states().for_uppaal(delays), states().for_tchecker(delays)] {
            let imported = import(prepared, &text).unwrap_or_else(|error| {
                let line = text.lines().nth(error.line.unwrap_or(1) - 1);
                panic!("{error}: {line:?}\n{text}")
            });
            let has_times = text.to_lowercase().contains("delay") && !is_strict;
            assert_eq!(imported.has_times, has_times, "{text}");
            assert_eq!(imported.notes.len(), usize::from(has_delays && is_strict));
            is_strict |= imported.run.end > trace.time as u64;
            out.push(imported);
        }
    }
    out
}

/// Imports all failures of a system. Returns their number.
fn compare(system: &System, options: &Options, name: &str) -> usize {
    let report = system.report(options);
    let all = found(system, options);
    for found in &all {
        let check = &found.prepared.checks[0].report;
        let subject = format!("{name}: {} {}", check.kind, check.of);
        let imports = imported(found);
        for imported in &imports {
            let end = imported.end.as_ref().unwrap_or_else(|| panic!("{subject}: no end"));
            assert_eq!(end.check, 0, "{subject}");
            let answer = report.checks.iter().find(|answer| answer.id == check.id);
            let verdict = answer.map_or(Verdict::Unknown, |answer| answer.verdict);
            if !matches!(verdict, Verdict::Unknown | Verdict::Nothing) {
                assert_eq!(end.holds, verdict.holds(), "{subject}");
            }
            let run = &imported.run;
            assert_eq!(run.impossible_step(&found.prepared.built.system), None, "{subject}");
            assert_eq!(run.steps, imports[0].run.steps, "{subject}");
            let later = i64::try_from(run.end).expect("a time") - found.trace.time;
            assert!((0..=1).contains(&later), "{subject}: {later}");
        }
    }
    all.len()
}

fn pump() -> System {
    System::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/pump/pump.scn"))
}

/// The pump misses a deadline: the first failure of one of its checks on one core.
fn miss() -> Found {
    let checks = parse_check("response pump.control <= 1 ms").expect("a check");
    let options = Options { cores: Some(Some(1)), checks, ..Options::default() };
    found(&pump(), &options).pop().expect("a failure")
}

#[test]
fn the_pump_on_one_core() {
    let found = miss();
    let imports = imported(&found);
    let end = imports[0].end.as_ref().expect("it ends in a failure");
    assert_eq!((end.name.as_str(), end.holds), ("response pump.control", false));
    assert_eq!((imports[0].form, imports[1].form), ("UPPAAL", "TChecker"));
    // As version 5 prints it.
    let text = States::new(&found.network, &found.trace).for_uppaal(None);
    let text = text.replace("Showing counter example.", " -- Showing witness trace:");
    let text = text.replace("Transitions:", "Transition:");
    let imported = import(&found.prepared, &text).expect("a run");
    assert_eq!(imported.run, imports[0].run);
}

/// Imports failures of random systems.
fn compare_random(draw: fn(&mut Dice) -> random::Texts, first: u64) {
    let limits = WatchLimits { states: 100_000, ..WatchLimits::default() };
    let options = Options { limits, ..Options::default() };
    let (mut seed, mut count) = (first, 0);
    while (count as u64) < dotgen_loaders::times(8) {
        seed += 1;
        let texts = draw(&mut Dice::new(seed));
        if let Some(system) = System::of_texts(&texts.specifications, &texts.scenario) {
            count += compare(&system, &options, &format!("seed {seed}"));
        }
    }
    eprintln!("{count} traces up to seed {seed}");
}

#[test]
fn random_systems() {
    compare_random(random::texts, 0);
}

#[test]
fn random_patterns() {
    compare_random(random::patterned, 1000);
}

#[test]
fn random_published_systems() {
    compare_random(published, 2000);
}

/// In the exported model, loops with a limit are unfolded: its states and yields have other numbers.
#[test]
fn loops_with_limits() {
    for (name, system) in crate::checks::looping() {
        let task = if name.contains("c.t0") { "t0" } else { "t1" };
        let codel = if name.contains("c.t0") { "y" } else { "z" };
        let checks = [format!("response c.{task} <= 3 ms"), format!("never c.{task}.{codel}.exec")];
        let checks = checks.iter().flat_map(|check| parse_check(check).expect("a check"));
        let options = Options { checks: checks.collect(), ..Options::default() };
        assert!(compare(&system, &options, name) > 0, "{name}");
    }
}

#[test]
fn predicates_in_time() {
    assert!(compare(&crate::checks::system(), &Options::default(), "checks") > 20);
}

/// A graph of `tck-reach`, without integers: they are only needed where edges differ in nothing else.
const TANK: &str = include_str!("tank.dot");

/// Returns the pump with the check that the trace violates, which also has no witness.
fn tank() -> Prepared {
    let checks = parse_check("response pump.control <= 1 ms").expect("a check");
    pump().prepared(&Options { checks, ..Options::default() })
}

fn error(prepared: &Prepared, text: &str) -> String {
    import(prepared, text).expect_err("the trace is wrong").to_string()
}

#[test]
fn a_graph_without_integers() {
    let imported = import(&tank(), TANK).expect("a run");
    assert_eq!((imported.form, imported.transitions, imported.run.end), ("TChecker", 54, 43));
    let end = imported.end.expect("it ends in the failure");
    assert_eq!((end.check, &*end.name, end.holds), (0, "response pump.control", false));
    // A part of a run ends in no failure.
    let from = TANK.find("  54 [").expect("the last node");
    let last = TANK.lines().skip_while(|line| !line.starts_with("  54 [")).nth(1).unwrap_or("");
    let part = format!("{}{}", &TANK[..from], &TANK[from..].replacen(last, "}", 1));
    let part = part.lines().filter(|line| !line.starts_with("  54 [")).collect::<Vec<_>>();
    let imported = import(&tank(), &part.join("\n")).expect("a run");
    assert_eq!((imported.transitions, imported.end), (53, None));
}

#[test]
fn traces_of_other_models_name_the_line() {
    let other = pump().prepared(&Options::default());
    assert_eq!(
        error(&other, TANK),
        "line 6: the model has no transition `scheduler: prepares -> looks` with `alone` here"
    );
    let two = parse_check("schedulable pump.control").expect("a check");
    let options = Options { cores: Some(None), checks: two, ..Options::default() };
    let found = error(&pump().prepared(&options), TANK);
    assert!(found.starts_with("line ") && found.contains("in the model"), "{found}");
    let found = error(&tank(), &TANK.replace("54 [", "54 [intval=\"cores_used=3\", "));
    assert_eq!(found, "line 111: `cores_used` is 3, but 1 in the model");
    let found = error(&tank(), &TANK.replace("54 [", "54 [intval=\"cores=3\", "));
    assert_eq!(found, "line 111: `cores` is not in the model");
    let late = TANK.replace("53 -> 54 [", "53 -> 54 [delay=\"3\", ");
    assert!(error(&tank(), &late).ends_with("the model has other times for this transition"));
}

#[test]
fn what_is_not_a_trace_is_refused() {
    let tank = tank();
    for (text, message) in [
        ("", "neither a trace of UPPAAL"),
        ("0\n1\n.\n0 1 -5;\n.\n", "an `.xtr` file of UPPAAL has numbers instead of names"),
        ("digraph tank {\n}\n", "the graph is empty: TChecker has found no run"),
        ("digraph tank {\n", "the graph breaks off"),
        ("digraph tank {\n0 [vloc=\"<a>\"]\n}\n", "the graph needs one node with `initial`"),
        ("State: ( a.b ) x\n", "line 1: `x` is not a part of a state"),
        ("State: ( a.b )\nState: ( a.b )\n", "line 2: a transition is expected"),
        ("State: ( a.b )\nTransitions:\n", "the trace breaks off after a transition"),
        ("State: ( a.b )\nDelay: soon\n", "line 2: `soon` is not a time"),
        ("State: ( a.b )\nVerifying formula 2\nState: ( a.b )\n", "line 3: a second trace"),
        ("State: ( a.b )\n", "line 1: 1 locations, but the model has 7 processes"),
    ] {
        let found = error(&tank, text);
        assert!(found.starts_with(message), "{found}");
    }
    let graph = TANK.replacen("\n}", "\n  0 -> 2 [vedge=\"<scheduler@alone>\"]\n}", 1);
    assert!(error(&tank, &graph).contains("a second edge leaves a node"), "{graph}");
    let aside = TANK.replacen("\n}", "\n  99 [vloc=\"<a>\"]\n}", 1);
    assert!(error(&tank, &aside).contains("not on the path"));
}

/// Texts with a part removed, doubled or changed: an error, or a run of the system.
#[test]
fn damaged_traces() {
    let found = miss();
    let states = || States::new(&found.network, &found.trace);
    let texts =
        [states().for_uppaal(Some(false)), states().for_tchecker(Some(false)), TANK.to_owned()];
    let mut dice = Dice::new(7);
    let (mut errors, mut runs) = (0, 0);
    for round in 0..300 * dotgen_loaders::times(1) {
        let text = &texts[round as usize % texts.len()];
        let mut at = || dice.below(text.len() as u32) as usize;
        let (mut from, mut to) = (at(), at());
        if from > to {
            std::mem::swap(&mut from, &mut to);
        }
        let to = to.min(from + dice.pick(&[1, 3, 30, 3000]));
        let damaged = match dice.below(4) {
            0 => text[..from].to_owned(),
            1 => format!("{}{}", &text[..from], &text[to..]),
            2 => format!("{}{}", &text[..to], &text[from..]),
            _ => {
                let new =
                    dice.pick(&["0", "9", "<", "\"", "]", "}", ",", " ", "\n", "-", ".", "é"]);
                format!("{}{new}{}", &text[..from], &text[from + 1..])
            }
        };
        match import(&found.prepared, &damaged) {
            Ok(imported) => {
                let system = &found.prepared.built.system;
                assert_eq!(imported.run.impossible_step(system), None, "{damaged}");
                runs += 1;
            }
            Err(_) => errors += 1,
        }
    }
    assert!(errors > runs && runs > 0, "{errors} errors, {runs} runs");
}

/// Runs that TChecker itself has found, if `DOTGEN_TCHECKER` names the program `tck-reach`.
#[test]
fn runs_of_tchecker() {
    let Some(program) = std::env::var_os("DOTGEN_TCHECKER") else {
        return dotgen_loaders::skip("no data: DOTGEN_TCHECKER names no program `tck-reach`");
    };
    let prepared = tank();
    let files = export(&prepared, &|_, _| None, Format::TChecker).expect("it is exported");
    let file = std::env::temp_dir().join(format!("dotgen-import-{}.tck", std::process::id()));
    std::fs::write(&file, &files[0].text).expect("the file can be written");
    for certificate in ["symbolic", "concrete"] {
        let mut command = std::process::Command::new(&program);
        command.args(["-a", "reach", "-l", "check_1_response", "-C", certificate]).arg(&file);
        let output = command.output().expect("the program starts");
        let text = String::from_utf8_lossy(&output.stdout);
        let imported = import(&prepared, &text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert!(imported.end.is_some_and(|end| !end.holds), "{text}");
    }
    let _ = std::fs::remove_file(&file);
}
