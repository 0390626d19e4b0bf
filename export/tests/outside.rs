//! Exported models, judged by TChecker: each check has the answer of the verifier. `DOTGEN_TCHECKER` names
//! the program `tck-reach`; `DOTGEN_CASE`, if set, a part of the name of the only scenarios to try.

use std::path::{Path, PathBuf};
use std::process::Command;

use dotgen_export::{Format, export};
use dotgen_timing::report::{CheckReport, Value, Verdict};
use dotgen_timing::verify::{Prepared, PreparedCheck, Question};
use num_rational::Ratio;

use crate::systems::System;

/// Time that TChecker gets for one question, in seconds.
const SECONDS: &str = "60";

/// Limit in seconds that unbounded times exceed.
const FAR: i128 = 3;

/// Counts of one scenario, or of all.
#[derive(Default)]
struct Counts {
    agree: usize,
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
    judge(&scenarios);
}

#[test]
fn examples() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let names = ["pump/pump.scn", "motor/motor.scn", "class/class.scn", "maneuver/maneuver.scn"];
    let paths = names.map(|name| folder.join(name));
    let scenarios: Vec<PathBuf> = paths.into_iter().filter(|path| path.exists()).collect();
    judge(&scenarios);
}

/// Asks TChecker about every check of some scenarios.
fn judge(scenarios: &[PathBuf]) {
    let Some(program) = std::env::var_os("DOTGEN_TCHECKER") else {
        return dotgen_loaders::skip("DOTGEN_TCHECKER names no program `tck-reach`");
    };
    let only = std::env::var("DOTGEN_CASE").unwrap_or_default();
    let mut counts = Counts::default();
    for path in scenarios {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        if name.contains(&only) {
            scenario(Path::new(&program), path, &name, &mut counts);
        }
    }
    eprintln!("{} answers agree", counts.agree);
    counts.slow.iter().for_each(|slow| eprintln!("no answer in {SECONDS} s: {slow}"));
    counts.refused.iter().for_each(|refused| eprintln!("{refused}"));
    assert!(counts.differ.is_empty(), "{}", counts.differ.join("\n"));
}

fn scenario(program: &Path, path: &Path, name: &str, counts: &mut Counts) {
    let system = System::read(path);
    let prepared = system.prepared();
    let report = system.report();
    for check in &prepared.checks {
        let subject = format!("{name}: {} {}", check.report.kind, check.report.of);
        let answer = report.checks.iter().find(|answer| answer.id == check.report.id);
        let Some(answer) = answer else { continue };
        for (question, reachable) in questions(&prepared, check, answer) {
            let mut alone = prepared.clone();
            alone.checks = vec![PreparedCheck { question, ..check.clone() }];
            let files = match export(&alone, Format::TChecker) {
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
        if answer.verdict == Verdict::Unknown {
            return Vec::new();
        }
        let reachable = if matches!(question, Question::Reachable(_)) { holds } else { !holds };
        return vec![(question, reachable)];
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
fn reaches(program: &Path, network: &str) -> Option<bool> {
    let label = network.lines().find_map(|line| line.split_once("labels:"));
    let label = label.expect("the network has a label").1.trim_end_matches('}');
    let file = std::env::temp_dir().join(format!("dotgen-export-{}.tck", std::process::id()));
    std::fs::write(&file, network).expect("the file can be written");
    let mut command = Command::new("timeout");
    command.arg(SECONDS).arg(program).args(["-a", "covreach", "-l", label]).arg(&file);
    let output = command.output().expect("the program starts");
    let _ = std::fs::remove_file(&file);
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!errors.contains("ERROR"), "{errors}\n{network}");
    let answer = text.lines().find_map(|line| line.strip_prefix("REACHABLE "));
    answer.map(|answer| answer.trim() == "true")
}
