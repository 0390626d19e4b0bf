//! Differences between the servers and the published models: every answer on 1 to 8 cores under both
//! semantics, and the point that causes each difference.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::Value;

use xtask::run::step;
use xtask::shared::optional;
use xtask::{root, target};

/// Maximum number of states. Results do not depend on a clock.
const MAX_STATES: &str = "400000";

/// Single points of the semantics: the keyword, the behaviour of the servers, the behaviour of the published
/// models.
const POINTS: &[(&str, &str, &str)] = &[
    ("ticks", "component", "task"),
    ("turns", "codel", "pause"),
    ("locks", "queue", "free"),
    ("ports", "copy", "lock"),
    ("pause", "events", "turns"),
    ("exceptions", "on", "off"),
    ("order", "on", "off"),
];

/// Answers by check and its subject.
type Answers = BTreeMap<String, String>;

/// Prints a table for each system.
pub(crate) fn semantics(dotgen: &Path) -> Result<()> {
    let systems = [
        ("RobNav, edf", "corpus/robnav/robnav.scn", "edf"),
        ("Quadcopter hovering, fifo", "corpus/quadcopter/hover.scn", "fifo"),
        ("examples/pump, fifo", "examples/pump/pump.scn", "fifo"),
        ("examples/outdoor, fifo", "examples/outdoor/outdoor.scn", "fifo"),
        ("examples/maneuver, fifo", "examples/maneuver/published.scn", "fifo"),
    ];
    for (name, path, policy) in systems {
        step(name);
        let scenario = match path.starts_with("corpus/") {
            true => optional(path),
            false => Some(root().join(path)),
        };
        let Some(scenario) = scenario else {
            continue;
        };
        let system = System::read(dotgen, &scenario, policy)?;
        println!("\n#### {name}\n\n| cores | answer | published | servers | point |");
        println!("| --- | --- | --- | --- | --- |");
        // Equal results for several numbers of cores share a row.
        let mut rows: Vec<(String, Vec<u32>)> = Vec::new();
        let mut same = 0;
        for cores in 1..=8 {
            let published = system.answers("published", cores, &[])?;
            let servers = system.answers("servers", cores, &[])?;
            let mut variants: [Option<Vec<Variant>>; 3] = Default::default();
            for (check, one) in &published {
                let Some(other) = servers.get(check) else {
                    continue;
                };
                if one == other {
                    same += 1;
                    continue;
                }
                // One point, or else as few together as cause the difference.
                let mut cause = None;
                let known = ![one, other].contains(&&"given up".to_owned());
                for (size, variants) in variants.iter_mut().enumerate().filter(|_| known) {
                    let variants = match variants {
                        Some(variant) => variant,
                        none => none.insert(system.variants(cores, size + 1)?),
                    };
                    cause = cause.or_else(|| point(variants, check, (one, other)));
                    if cause.is_some() {
                        break;
                    }
                }
                let point = cause.unwrap_or_else(|| match known {
                    true => "more than three together".to_owned(),
                    false => "not known".to_owned(),
                });
                let row = format!("{check} | {one} | {other} | {point}");
                match rows.iter_mut().find(|candidate| candidate.0 == row) {
                    Some(row) => row.1.push(cores),
                    None => rows.push((row, vec![cores])),
                }
            }
        }
        for (row, cores) in rows {
            println!("| {} | {row} |", ranges(&cores));
        }
        println!("\n{same} other answers are the same under both.");
    }
    Ok(())
}

/// `1, 3–8`
fn ranges(numbers: &[u32]) -> String {
    let mut out: Vec<(u32, u32)> = Vec::new();
    for &number in numbers {
        match out.last_mut() {
            Some(last) if last.1 + 1 == number => last.1 = number,
            _ => out.push((number, number)),
        }
    }
    let words = out.iter().map(|&(from, to)| match from == to {
        true => from.to_string(),
        false => format!("{from}–{to}"),
    });
    words.collect::<Vec<_>>().join(", ")
}

struct System<'a> {
    dotgen: &'a Path,
    policy: &'a str,
    /// Text of the scenario without checks and semantics, up to its last brace.
    text: String,
    /// The folder of the specifications.
    folder: PathBuf,
    file: PathBuf,
}

impl<'a> System<'a> {
    fn read(dotgen: &'a Path, scenario: &Path, policy: &'a str) -> Result<Self> {
        let text = std::fs::read_to_string(scenario)?;
        let folder = std::path::absolute(scenario.parent().context("no folder")?)?;
        let kept = text.lines().filter(|line| {
            let line = line.trim_start();
            !line.starts_with("check ")
                && !line.starts_with("semantics ")
                && !line.starts_with("locks ")
        });
        let text = kept.collect::<Vec<_>>().join("\n");
        let text = text.replace("use \"", &format!("use \"{}/", folder.display()));
        let end = text.rfind('}').context("a scenario without end")?;
        let directory = target().join("semantics");
        std::fs::create_dir_all(&directory)?;
        Ok(System {
            dotgen,
            policy,
            text: text[..end].to_owned(),
            folder,
            file: directory.join("scenario.scn"),
        })
    }

    /// The answers for each task, with some points set separately.
    fn answers(&self, preset: &str, cores: u32, points: &[(&str, &str)]) -> Result<Answers> {
        let chosen = points.iter().map(|(word, rule)| format!("  {word} {rule};\n"));
        let chosen: String = chosen.collect();
        let text =
            format!("{}\n{chosen}  check schedulable *;\n  check response *;\n}}\n", self.text);
        std::fs::write(&self.file, text)?;
        let output = Command::new(self.dotgen)
            .args(["verify", "--format", "json", "--max-states", MAX_STATES])
            .args(["--semantics", preset, "--durations", "fixed"])
            .args(["--cores", &cores.to_string(), "--policy", self.policy])
            .arg("-I")
            .arg(self.folder.join("idl"))
            .arg(&self.file)
            .output()?;
        // Some points cannot be combined with the others: the published models have no order of services.
        if !points.is_empty() && output.status.code() == Some(2) {
            return Ok(Answers::new());
        }
        let report: Value = serde_json::from_slice(&output.stdout)
            .with_context(|| String::from_utf8_lossy(&output.stderr).into_owned())?;
        let checks = report["checks"].as_array().context("no checks")?;
        let answer = |json: &Value| {
            let value = match &json["value"] {
                Value::Null => String::new(),
                Value::String(text) => text.clone(),
                value => format!("{value} {}", report["unit"].as_str().unwrap_or("ms")),
            };
            match (json["verdict"].as_str().unwrap_or("?"), &*value) {
                ("unknown", _) => "given up".to_owned(),
                (verdict, "") => verdict.to_owned(),
                (_, value) => value.to_owned(),
            }
        };
        let key = |value: &Value| {
            let word = |key: &str| value[key].as_str().unwrap_or("?").to_owned();
            format!("{} {}", word("check"), word("of"))
        };
        Ok(checks.iter().map(|check| (key(check), answer(check))).collect())
    }

    /// The answers with `size` points from the other semantics, for each choice of points.
    fn variants(&self, cores: u32, size: usize) -> Result<Vec<Variant>> {
        let choices = 0u32..1 << POINTS.len();
        let choices = choices.filter(|choice| choice.count_ones() as usize == size);
        let variant = |chosen: u32| {
            let chosen = || (0..POINTS.len()).filter(move |point| chosen >> point & 1 == 1);
            let published: Vec<_> =
                chosen().map(|point| (POINTS[point].0, POINTS[point].2)).collect();
            let servers: Vec<_> =
                chosen().map(|point| (POINTS[point].0, POINTS[point].1)).collect();
            let words: Vec<String> =
                chosen().map(|point| format!("`{}`", POINTS[point].0)).collect();
            Ok(Variant {
                words: words.join(" with "),
                servers: self.answers("servers", cores, &published)?,
                published: self.answers("published", cores, &servers)?,
            })
        };
        choices.map(variant).collect()
    }
}

/// Answers with some points from the other semantics.
struct Variant {
    words: String,
    servers: Answers,
    published: Answers,
}

/// The points that cause the difference between the servers and the published models, if some of these
/// variants show it.
fn point(variants: &[Variant], check: &str, (one, other): (&str, &str)) -> Option<String> {
    let is =
        |answers: &Answers, wanted: &str| answers.get(check).is_some_and(|answer| answer == wanted);
    let makes = |variant: &&Variant| is(&variant.servers, one) || is(&variant.published, other);
    let found: Vec<&str> = variants.iter().filter(makes).map(|variant| &*variant.words).collect();
    (!found.is_empty()).then(|| found.join(" or "))
}
