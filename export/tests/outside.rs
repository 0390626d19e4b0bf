//! Exported models, judged by TChecker: each check has the answer of the verifier. `DOTGEN_TCHECKER` names
//! the program `tck-reach`; `DOTGEN_CASE`, if set, a part of the name of the only scenarios to try.

use std::path::{Path, PathBuf};
use std::process::Command;

use dotgen_export::{Format, export};
use dotgen_timing::explore::Limits as WatchLimits;
use dotgen_timing::report::{CheckReport, Soundness, Value, Verdict};
use dotgen_timing::scn::ast::{Durations, Policy};
use dotgen_timing::scn::semantics::Preset;
use dotgen_timing::verify::{Options, Prepared, PreparedCheck, Question};
use num_rational::Ratio;

use crate::random_systems::{published, random};
use crate::systems::{Dice, System};

/// Time that TChecker gets for one question, in seconds.
const SECONDS: &str = "60";

/// Time for one question of many, in seconds.
const FEW_SECONDS: &str = "5";

/// Limit in seconds that unbounded times exceed.
const FAR: i128 = 3;

/// Counts of one scenario, or of all.
#[derive(Default)]
struct Counts {
    agree: usize,
    /// Checks without a value of the verifier.
    without: usize,
    slow: Vec<String>,
    refused: Vec<String>,
    differ: Vec<String>,
}

#[test]
fn servers() {
    let Some(folder) = dotgen_loaders::shared("servers") else { return };
    let mut scenarios: Vec<PathBuf> = (std::fs::read_dir(folder).expect("the folder exists"))
        .map(|entry| entry.expect("the folder is readable").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "scn"))
        .collect();
    scenarios.sort();
    judge(&scenarios, SECONDS, &Options::default());
}

#[test]
fn servers_with_other_options() {
    let Some(folder) = dotgen_loaders::shared("servers") else { return };
    let mut scenarios: Vec<PathBuf> = (std::fs::read_dir(folder).expect("the folder exists"))
        .map(|entry| entry.expect("the folder is readable").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "scn"))
        .collect();
    scenarios.sort();
    let on = |cores, policy, durations| Options {
        cores: Some(cores),
        policy: Some(policy),
        durations: Some(durations),
        ..Options::default()
    };
    judge(&scenarios, FEW_SECONDS, &on(Some(1), Policy::Fifo, Durations::Fixed));
    judge(&scenarios, FEW_SECONDS, &on(Some(1), Policy::Any, Durations::Interval));
    judge(&scenarios, FEW_SECONDS, &on(Some(2), Policy::Fifo, Durations::Interval));
    judge(&scenarios, FEW_SECONDS, &on(None, Policy::Fifo, Durations::Interval));
    let published = Options { semantics: Some(Preset::Published), ..Options::default() };
    judge(&scenarios, FEW_SECONDS, &published);
}

#[test]
fn random_systems() {
    let Some(program) = std::env::var_os("DOTGEN_TCHECKER") else {
        return dotgen_loaders::skip("no data: DOTGEN_TCHECKER names no program `tck-reach`");
    };
    let limits = WatchLimits { states: 100_000, ..WatchLimits::default() };
    let options = Options { limits, ..Options::default() };
    let mut counts = Counts::default();
    for seed in 0..dotgen_loaders::times(20) {
        let draw = if seed % 2 == 0 { random::texts } else { published };
        let texts = draw(&mut Dice::new(seed));
        if let Some(of) = System::of_texts(&texts.specifications, &texts.scenario) {
            let asked = (Path::new(&program), FEW_SECONDS);
            system(asked, &of, &format!("seed {seed}"), &options, &mut counts);
        }
    }
    report(&counts, FEW_SECONDS);
}

#[test]
fn examples() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let names = ["pump/pump.scn", "motor/motor.scn", "class/class.scn", "maneuver/maneuver.scn"];
    let paths = names.map(|name| folder.join(name));
    let scenarios: Vec<PathBuf> = paths.into_iter().filter(|path| path.exists()).collect();
    judge(&scenarios, SECONDS, &Options::default());
}

#[test]
fn checks() {
    let Some(program) = std::env::var_os("DOTGEN_TCHECKER") else {
        return dotgen_loaders::skip("no data: DOTGEN_TCHECKER names no program `tck-reach`");
    };
    let mut counts = Counts::default();
    let asked = (Path::new(&program), FEW_SECONDS);
    system(asked, &crate::checks::system(), "checks", &Options::default(), &mut counts);
    report(&counts, FEW_SECONDS);
}

/// Asks TChecker about every check of some scenarios.
fn judge(scenarios: &[PathBuf], seconds: &str, options: &Options) {
    let Some(program) = std::env::var_os("DOTGEN_TCHECKER") else {
        return dotgen_loaders::skip("no data: DOTGEN_TCHECKER names no program `tck-reach`");
    };
    let only = std::env::var("DOTGEN_CASE").unwrap_or_default();
    let mut counts = Counts::default();
    for path in scenarios {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        if name.contains(&only) {
            let asked = (Path::new(&program), seconds);
            scenario(asked, path, &name, options, &mut counts);
        }
    }
    report(&counts, seconds);
}

/// Prints the counts, and fails if answers differ.
fn report(counts: &Counts, seconds: &str) {
    eprintln!("{} answers agree, {} checks have no value", counts.agree, counts.without);
    counts.slow.iter().for_each(|slow| eprintln!("no answer in {seconds} s: {slow}"));
    counts.refused.iter().for_each(|refused| eprintln!("{refused}"));
    assert!(counts.differ.is_empty(), "{}", counts.differ.join("\n"));
}

fn scenario(
    program: (&Path, &str),
    path: &Path,
    name: &str,
    options: &Options,
    counts: &mut Counts,
) {
    system(program, &System::read(path), name, options, counts);
}

/// Asks TChecker about every check of a system.
fn system(
    program: (&Path, &str),
    system: &System,
    name: &str,
    options: &Options,
    counts: &mut Counts,
) {
    let prepared = system.prepared(options);
    let report = system.report(options);
    for check in &prepared.checks {
        let subject = format!("{name}: {} {}", check.report.kind, check.report.of);
        let answer = report.checks.iter().find(|answer| answer.id == check.report.id);
        let Some(answer) = answer else { continue };
        let questions = questions(&prepared, check, answer);
        counts.without += usize::from(questions.is_empty());
        for (question, reachable) in questions {
            let mut alone = prepared.clone();
            alone.checks = vec![PreparedCheck { question, ..check.clone() }];
            let files = match export(
                &alone,
                &|component, src| system.place(component, src),
                Format::TChecker,
            ) {
                Ok(files) => files,
                Err(refusals) => {
                    let refusals: Vec<String> = refusals.iter().map(ToString::to_string).collect();
                    counts.refused.push(format!("{subject}: {}", refusals.join("; ")));
                    continue;
                }
            };
            match reaches(program, &files[0].text) {
                Some(found) if found == reachable => counts.agree += 1,
                Some(found) => counts.differ.push(format!(
                    "{subject}: {:?} {:?}; TChecker: reachable {found}, expected {reachable}: {:?}",
                    answer.verdict, answer.value, alone.checks[0].question
                )),
                None => counts.slow.push(subject.clone()),
            }
        }
    }
}

/// Returns the questions about a check, each with the expected reachability of its location.
fn questions(
    prepared: &Prepared,
    check: &PreparedCheck,
    answer: &CheckReport,
) -> Vec<(Question, bool)> {
    let question = check.question.clone();
    let with_limit = |limit: u32| match &question {
        Question::Response(task, _) => Question::Response(*task, Some(limit)),
        Question::Within(p, list, _) => Question::Within(p.clone(), list.clone(), Some(limit)),
        other => other.clone(),
    };
    if !matches!(question, Question::Response(..) | Question::Within(..)) {
        let holds = answer.verdict.holds();
        if matches!(answer.verdict, Verdict::Unknown | Verdict::Nothing) {
            return Vec::new();
        }
        let reachable = if matches!(question, Question::Reachable(_)) { holds } else { !holds };
        return vec![(question, reachable)];
    }
    if matches!(answer.soundness, Soundness::UpperBound | Soundness::LowerBound) {
        return Vec::new();
    }
    match answer.value {
        Some(Value::Unbounded) => {
            let far = prepared.ticks(Ratio::from_integer(FAR));
            vec![(with_limit(far as u32), true)]
        }
        Some(Value::Time(time)) => {
            let ticks = (time / prepared.time(1)).round() as u32;
            let mut out = vec![(with_limit(ticks), false)];
            if ticks > 0 {
                out.push((with_limit(ticks - 1), true));
            }
            out
        }
        None => Vec::new(),
    }
}

/// Returns the answer of TChecker to the only query of a network; `None` if there is none in time.
fn reaches((program, seconds): (&Path, &str), network: &str) -> Option<bool> {
    let label = network.lines().find_map(|line| line.split_once("labels:"));
    let label = label.expect("the network has a label").1.trim_end_matches('}');
    let file = std::env::temp_dir().join(format!(
        "dotgen-export-{}-{:?}.tck",
        std::process::id(),
        std::thread::current().id()
    ));
    std::fs::write(&file, network).expect("the file can be written");
    let mut command = Command::new("timeout");
    command.arg(seconds).arg(program).args(["-a", "covreach", "-l", label]).arg(&file);
    let output = command.output().expect("the program starts");
    let _ = std::fs::remove_file(&file);
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!errors.contains("ERROR"), "{errors}\n{network}");
    let answer = text.lines().find_map(|line| line.strip_prefix("REACHABLE "));
    answer.map(|answer| answer.trim() == "true")
}
