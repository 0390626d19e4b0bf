//! The conformance suite, in process: verdicts, lines of errors and warnings, and the model of every
//! accepted case. The suite is not part of this repository; without it the test is skipped.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    sync::{Arc, Mutex},
};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::{
    codes::checks,
    diagnostic::{Diagnostic, Severity},
    host::{
        AnalysisHost, BatchInput, Change, Config, FileContent, Input, Loader, PackageFlags,
        UnitResult,
    },
    model_json,
    release::{Release, ReleaseChoice, ReleaseOrigin},
};
use serde_json::Value as Json;

/// Reads the disk, and runs the package tool in the environment of the case.
struct Disk {
    env: Mutex<Vec<(String, String)>>,
}

impl Loader for Disk {
    fn read(&self, path: &Utf8Path) -> FileContent {
        if path.is_dir() {
            return FileContent::Directory;
        }
        match fs::read(path) {
            Ok(bytes) => match String::from_utf8(bytes) {
                Ok(text) => FileContent::Text(text),
                Err(error) => {
                    FileContent::NotUtf8(String::from_utf8_lossy(error.as_bytes()).into_owned())
                }
            },
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => FileContent::Missing,
            Err(error) => FileContent::Unreadable(error.to_string()),
        }
    }

    fn packages(&self, arguments: &[String]) -> Result<PackageFlags, String> {
        let mut command = Command::new("pkg-config");
        command.arg("--cflags").args(arguments);
        command.env_remove("PKG_CONFIG_LIBDIR");
        for (name, value) in self.env.lock().unwrap().iter() {
            command.env(name, value);
        }
        let output = command.output().map_err(|error| error.to_string())?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned());
        }
        let mut flags = PackageFlags::default();
        for flag in String::from_utf8_lossy(&output.stdout).split_whitespace() {
            if let Some(dir) = flag.strip_prefix("-I") {
                flags.include_dirs.push(dir.into());
            } else if let Some(define) = flag.strip_prefix("-D") {
                let (name, value) = define.split_once('=').unwrap_or((define, "1"));
                flags.defines.push((name.into(), value.into()));
            }
        }
        Ok(flags)
    }
}

#[test]
fn every_case_of_2_99_39_passes() {
    every_case_passes(Release::V2_99_39);
}

#[test]
fn every_case_of_2_99_41_passes() {
    every_case_passes(Release::V2_99_41);
}

/// The cases as a release reads them: cases in which newer releases differ have a table of their own.
fn every_case_passes(release: Release) {
    let Some(root) = dotgen_loaders::shared("conformance") else {
        return;
    };
    let expected = fs::read_to_string(root.join("expected.json")).unwrap();
    let mut expected: Json = serde_json::from_str(&expected).unwrap();
    let differing = root.join(format!("expected-{release}.json"));
    if let Ok(text) = fs::read_to_string(differing) {
        let differing: Json = serde_json::from_str(&text).unwrap();
        let all = expected.as_object_mut().unwrap();
        all.extend(differing.as_object().unwrap().clone());
    }
    let filter = std::env::var("CASE").unwrap_or_default();
    let mut failures = Vec::new();
    let mut passed = 0;
    for (name, case) in expected.as_object().unwrap() {
        if !name.contains(&filter) {
            continue;
        }
        let needs = case["needs"].as_str();
        if needs.is_some_and(|need| Command::new(need).arg("--version").output().is_err()) {
            dotgen_loaders::skip(format_args!("{name} needs {}", needs.unwrap_or_default()));
            continue;
        }
        match check(&root, case, release) {
            Ok(()) => passed += 1,
            Err(why) => failures.push(format!("{name}: {why}")),
        }
    }
    assert!(
        failures.is_empty(),
        "{passed} passed, {} failed:\n{}",
        failures.len(),
        failures.join("\n")
    );
}

fn check(root: &Path, case: &Json, release: Release) -> Result<(), String> {
    let result = run(root, case, release);
    let diagnostics = &result.diagnostics;
    let (errors, mild): (Vec<&Diagnostic>, Vec<&Diagnostic>) = diagnostics
        .iter()
        .filter(|diagnostic| diagnostic.severity != Severity::Hint)
        .partition(|diagnostic| diagnostic.severity == Severity::Error);
    let want = case.get("ours").unwrap_or(case);
    if want["verdict"] == "accept" {
        if let Some(error) = errors.first() {
            return Err(format!("must be accepted, but: {}", show(error)));
        }
    } else {
        if errors.is_empty() {
            return Err("must be rejected".to_owned());
        }
        for error in want["errors"].as_array().into_iter().flatten() {
            let required = error["consequence"] != true;
            if required && !is_near(error, &errors) {
                let ours: Vec<String> = errors.iter().map(|error| show(error)).collect();
                return Err(format!("no error near {error}; ours:\n    {}", ours.join("\n    ")));
            }
        }
        check_codes(want, &errors)?;
    }
    if case.get("ours").is_none() {
        for warning in case["warnings"].as_array().into_iter().flatten() {
            if !is_near(warning, &mild) {
                return Err(format!("no warning near {warning}"));
            }
        }
    }
    if let Some(model) = case.get("model")
        && case.get("deviation").is_none()
    {
        let ours = model_json::to_json(&result.spec, None);
        compare(model, &ours, "model")?;
    }
    Ok(())
}

fn run(root: &Path, case: &Json, release: Release) -> UnitResult {
    let file: PathBuf = root.join(case["file"].as_str().unwrap());
    let here = file.parent().unwrap().to_str().unwrap().to_owned();
    let fill = |json: &Json| json.as_str().unwrap().replace("{case}", &here);
    let mut input = BatchInput {
        inputs: vec![Input::File(Utf8PathBuf::from_path_buf(file.clone()).unwrap())],
        ..BatchInput::default()
    };
    for argument in case["args"].as_array().into_iter().flatten() {
        let argument = fill(argument);
        if let Some(dir) = argument.strip_prefix("-I") {
            input.include_dirs.push(dir.into());
        } else if let Some(define) = argument.strip_prefix("-D") {
            let (name, value) = define.split_once('=').unwrap_or((define, "1"));
            input.defines.push((name.into(), value.into()));
        }
    }
    let env = case["env"].as_object().into_iter().flatten();
    let env = env.map(|(name, value)| (name.clone(), fill(value))).collect();
    let mut host = AnalysisHost::new(Arc::new(Disk { env: Mutex::new(env) }));
    let origin = ReleaseOrigin::CommandLine;
    host.apply(Change {
        config: Some(Config {
            release: Some(ReleaseChoice { release, origin }),
            ..Config::default()
        }),
        ..Change::default()
    });
    host.analysis().batch(&input).unwrap()
}

/// The code of a rule: the code of the suite, except for rules about state machines and shared data, which
/// are named like the lints of their kind.
fn code_of(check: &str) -> &str {
    match check {
        "fsm-unreached" => "fsm/unreachable-state",
        "fsm-undefined" => "fsm/undefined-state",
        "fsm-stop" => "fsm/stop-without-ether",
        "fsm-duplicate" => "fsm/duplicate-state",
        "event-duplicate" => "fsm/duplicate-yield",
        "event-paused-ether" => "fsm/paused-ether",
        "codel-paused-trigger" => "fsm/paused-trigger",
        "async-codel-conflict" => "async/shared-resource",
        "async-service-conflict" => "async/shared-attribute",
        other => other,
    }
}

fn is_check(id: &str) -> bool {
    checks::CODES.iter().any(|code| code.id == id)
}

/// If the suite expects only a rule of the elaborator, dotgen must report the same rule.
fn check_codes(want: &Json, errors: &[&Diagnostic]) -> Result<(), String> {
    let wanted: Vec<&Json> = want["errors"].as_array().into_iter().flatten().collect();
    let ids = |line: &Json| {
        let here = wanted.iter().filter(|error| error["line"] == *line);
        here.filter_map(|error| error["check"].as_str()).map(code_of).collect::<Vec<_>>()
    };
    for error in wanted.iter().filter(|error| error["consequence"] != true) {
        let codes = ids(&error["line"]);
        if codes.is_empty() || codes.iter().any(|code| !is_check(code) && *code != "dropped") {
            continue;
        }
        let ours: Vec<&&Diagnostic> = errors
            .iter()
            .filter(|diagnostic| is_near(error, std::slice::from_ref(diagnostic)))
            .collect();
        if !ours.is_empty() && !ours.iter().any(|error| codes.contains(&error.code)) {
            return Err(format!("none of {codes:?}, but {}", show(ours[0])));
        }
    }
    Ok(())
}

fn show(diagnostic: &Diagnostic) -> String {
    let (first, _) = lines(diagnostic);
    format!(
        "{}:{first}: {}: {}",
        diagnostic.path.file_name().unwrap_or_default(),
        diagnostic.code,
        diagnostic.message
    )
}

/// First and last line, from 1.
fn lines(diagnostic: &Diagnostic) -> (usize, usize) {
    let text = fs::read(&diagnostic.path).unwrap_or_default();
    let line = |offset: usize| {
        let before = &text[..offset.min(text.len())];
        1 + before.iter().filter(|byte| **byte == b'\n').count()
    };
    (line(diagnostic.range.start), line(diagnostic.range.end))
}

fn is_near(want: &Json, diagnostics: &[&Diagnostic]) -> bool {
    let also = want["also"].as_array().into_iter().flatten();
    let wanted: Vec<usize> = std::iter::once(&want["line"])
        .chain(also)
        .filter_map(|line| Some(line.as_u64()? as usize))
        .collect();
    diagnostics.iter().any(|diagnostic| {
        let (first, last) = lines(diagnostic);
        diagnostic.path.file_name() == want["file"].as_str()
            && wanted.iter().any(|line| first.abs_diff(*line) <= 1 || (first..=last).contains(line))
    })
}

/// Keys of the summary that mean "not given" when absent.
const OPTIONAL: &[&str] = &[
    "doc",
    "version",
    "lang",
    "email",
    "clock-rate",
    "ids",
    "period",
    "delay",
    "priority",
    "stack",
    "scheduling",
    "task",
    "member",
    "of",
    "init",
    "value",
    "mutex",
    "cases",
    "switch",
    "valuekind",
    "triggers",
    "yields",
];

/// Compares the output of the reference with dotgen's, which may have further keys in objects.
fn compare(want: &Json, ours: &Json, at: &str) -> Result<(), String> {
    let differ = || Err(format!("{at} should be {want}, is {ours}"));
    match (want, ours) {
        (Json::String(any), _) if any == "*" => Ok(()),
        // Parameters of remote attributes are paths in the reference, names in dotgen.
        (Json::String(want), Json::String(ours)) if at.contains(".remotes[") => {
            if want.trim_start_matches('.') == ours { Ok(()) } else { differ() }
        }
        // The reference includes the end of the line in the last argument of `_Pragma("requires …")`.
        (Json::String(want), Json::String(ours)) if at.contains(".requires") => {
            if want.trim_end() == ours { Ok(()) } else { differ() }
        }
        (Json::Object(want), Json::Object(ours)) => {
            for (key, value) in want {
                let Some(other) = ours.get(key) else {
                    return Err(format!("{at}.{key} is missing; should be {value}"));
                };
                compare(value, other, &format!("{at}.{key}"))?;
            }
            // Names of types are keys too. The summary leaves the stack of a component out.
            let is_component = ours.contains_key("ports");
            let extra = ours.keys().find(|key| {
                let omitted = is_component && key.as_str() == "stack";
                !want.contains_key(*key)
                    && !omitted
                    && (OPTIONAL.contains(&key.as_str()) || key.starts_with("::"))
            });
            match extra {
                Some(key) => Err(format!("{at}.{key} should not be there: {}", ours[key])),
                None => Ok(()),
            }
        }
        (Json::Array(want), Json::Array(ours)) if want.len() == ours.len() => {
            for (i, (a, b)) in want.iter().zip(ours).enumerate() {
                compare(a, b, &format!("{at}[{i}]"))?;
            }
            Ok(())
        }
        (Json::Number(a), Json::Number(b)) => {
            let (Some(a), Some(b)) = (a.as_f64(), b.as_f64()) else {
                return differ();
            };
            if (a - b).abs() <= 1e-5 * a.abs().max(b.abs()) { Ok(()) } else { differ() }
        }
        _ if want == ours => Ok(()),
        _ => differ(),
    }
}

/// Every published specification is accepted, without a warning about the language, with stand-ins for its
/// includes. Its packages are assumed to be installed.
#[test]
fn published_specifications_are_accepted() {
    let Some(root) = dotgen_loaders::shared("corpus") else {
        return;
    };
    let mut checked = 0;
    for (folder, include) in
        [("components", "components/standins"), ("robnav", "robnav"), ("quadcopter", "quadcopter")]
    {
        let mut pending = vec![root.join(folder)];
        while let Some(path) = pending.pop() {
            if path.is_dir() && path != root.join("components/standins") {
                pending.extend(fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
                continue;
            }
            if path.extension().is_none_or(|extension| extension != "gen") {
                continue;
            }
            let input = BatchInput {
                inputs: vec![Input::File(Utf8PathBuf::from_path_buf(path.clone()).unwrap())],
                include_dirs: vec![root.join(include).to_str().unwrap().into()],
                ..BatchInput::default()
            };
            let host = AnalysisHost::new(Arc::new(Installed(Disk { env: Mutex::default() })));
            let unit = host.analysis().batch(&input).unwrap();
            let found = unit.diagnostics.iter();
            let found: Vec<String> = found
                .filter(|diagnostic| {
                    diagnostic.severity == Severity::Error || is_check(diagnostic.code)
                })
                .map(show)
                .collect();
            assert!(found.is_empty(), "{}: {found:#?}", path.display());
            checked += 1;
        }
    }
    assert!(checked > 15, "only {checked} specifications");
}

/// A disk with every package installed.
struct Installed(Disk);

impl Loader for Installed {
    fn read(&self, path: &Utf8Path) -> FileContent {
        self.0.read(path)
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags::default())
    }
}
