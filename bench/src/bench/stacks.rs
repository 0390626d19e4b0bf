//! Random stacks: 3 to 6 components with periodic tasks, activities, aperiodic tasks, functions, locks, ports
//! and clients, on 1 to 4 cores. Counts the deadlines that are answered in a limited time.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};
use fastrand::Rng;
use serde_json::Value;

use xtask::run::step;
use xtask::target;

/// Periods of tasks, in ms.
const PERIODS: [u64; 8] = [1, 2, 4, 5, 10, 20, 25, 50];

/// Verifies the stacks with numbers from 0, each for some seconds, and prints the answers by semantics and
/// policy.
pub(crate) fn stacks(dotgen: &Path, count: u64, seconds: f64) -> Result<()> {
    step("Random stacks");
    let folder = target().join("bench").join("stacks");
    let mut rows: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for number in 0..count {
        let folder = folder.join(number.to_string());
        std::fs::create_dir_all(&folder)?;
        let mut stack = Stack { dice: Rng::with_seed(number), activities: Vec::new() };
        let group = stack.write(&folder)?;
        let output = Command::new(dotgen)
            .args(["verify", "stack.scn", "--format", "json", "--timeout", &seconds.to_string()])
            .current_dir(&folder)
            .output()?;
        let report: Value = serde_json::from_slice(&output.stdout).with_context(|| {
            format!("{}: {}", folder.display(), String::from_utf8_lossy(&output.stderr))
        })?;
        for check in report["checks"].as_array().into_iter().flatten() {
            let verdict = check["verdict"].as_str().unwrap_or_default().to_owned();
            *rows.entry(group.clone()).or_default().entry(verdict).or_default() += 1;
        }
    }
    println!("\n| semantics, policy | deadlines | proved | refuted | answered |");
    println!("| --- | --- | --- | --- | --- |");
    let mut all: BTreeMap<String, usize> = BTreeMap::new();
    for verdicts in rows.values() {
        verdicts
            .iter()
            .for_each(|(verdict, count)| *all.entry(verdict.clone()).or_default() += count);
    }
    rows.insert("together".to_owned(), all);
    for (group, verdicts) in rows {
        let of = |verdict: &str| verdicts.get(verdict).copied().unwrap_or(0);
        let total: usize = verdicts.values().sum();
        let open = of("unknown");
        let answered = 100.0 * (total - open) as f64 / total as f64;
        println!("| {group} | {total} | {} | {} | {answered:.0} % |", of("proved"), of("refuted"));
    }
    Ok(())
}

struct Stack {
    dice: Rng,
    /// Activities and functions that clients can request.
    activities: Vec<String>,
}

impl Stack {
    /// Writes the specifications and the scenario. Returns its semantics and policy.
    fn write(&mut self, folder: &Path) -> Result<String> {
        let components = self.dice.usize(3..=6);
        let cores = *self.pick(&[1, 2, 2, 3, 4, 4]);
        let policy = *self.pick(&["fifo", "fifo", "priority", "edf"]);
        let published = policy != "priority" && self.dice.f64() < 0.4;
        let semantics = if published { "published" } else { "servers" };
        let load = f64::from(cores) * (0.25 + self.dice.f64() / 2.0);
        let tasks: Vec<Vec<(u64, f64)>> = (0..components)
            .map(|_| {
                let count = *self.pick(&[1, 1, 2]);
                (0..count).map(|_| (*self.pick(&PERIODS), 0.2 + self.dice.f64())).collect()
            })
            .collect();
        let shares: f64 = tasks.iter().flatten().map(|task| task.1).sum();
        let mut scenario = String::from("scenario stack {\n");
        for (number, tasks) in tasks.iter().enumerate() {
            let text = self.component(number, tasks, load / shares);
            std::fs::write(folder.join(format!("c{number}.gen")), text)?;
            let _ = writeln!(scenario, "  use \"c{number}.gen\";");
        }
        for number in 1..components {
            let _ = writeln!(scenario, "  connect c{number}.q to c{}.p;", number - 1);
        }
        let _ =
            writeln!(scenario, "  cores {cores};\n  policy {policy};\n  semantics {semantics};");
        for client in 0..*self.pick(&[1, 1, 2]) {
            let _ = writeln!(scenario, "  client k{client} {{");
            let _ = writeln!(scenario, "    delay {} ms;", self.pick(&[0, 1, 5, 20]));
            let mut all = self.activities.clone();
            self.dice.shuffle(&mut all);
            for activity in all.iter().take(self.dice.usize(1..=5)) {
                let _ = write!(scenario, "    send {activity};");
                if self.dice.f64() < 0.6 {
                    scenario.push_str(" await ended;");
                }
                if self.dice.f64() < 0.4 {
                    let _ = write!(scenario, " delay {} ms;", self.pick(&[1, 10, 100]));
                }
                scenario.push('\n');
            }
            scenario.push_str("  }\n");
        }
        scenario.push_str("  check schedulable *;\n}\n");
        std::fs::write(folder.join("stack.scn"), scenario)?;
        Ok(format!("{semantics}, {policy}"))
    }

    fn pick<'t, T>(&mut self, from: &'t [T]) -> &'t T {
        &from[self.dice.usize(..from.len())]
    }

    /// Returns the parameter of a codel: nothing, or a member of the ids, or a port.
    fn parameter(&mut self, has_input: bool) -> &'static str {
        let all = ["", "in a", "inout a", "out b", "out p", "in q"];
        all[self.dice.usize(..all.len() - usize::from(!has_input))]
    }

    /// Returns a component whose tasks, with a period and a share of the load each, use `scale` times it.
    fn component(&mut self, number: usize, tasks: &[(u64, f64)], scale: f64) -> String {
        let has_input = number > 0;
        let mut out = format!(
            "#ifndef VALUE\n#define VALUE\ntypedef long value;\n#endif\ncomponent c{number} {{\n  version \"1\";\n  lang \"c\";\n  ids {{ long a, b; }};\n  port out value p;\n"
        );
        if has_input {
            out.push_str("  port in value q;\n");
        }
        for (task, &(period, share)) in tasks.iter().enumerate() {
            let work = (share * scale).min(0.7) * period as f64 * 1000.0;
            let count = *self.pick(&[1, 1, 2, 3]);
            let wcet = ((work / count as f64) as u64).max(10);
            let priority = self.dice.u32(1..=20);
            let _ = writeln!(out, "  task t{task} {{ period {period} ms; priority {priority};");
            for codel in 0..count {
                let state = if codel == 0 { "start".to_owned() } else { format!("s{codel}") };
                let next = if codel + 1 == count {
                    "pause::start".into()
                } else {
                    format!("s{}", codel + 1)
                };
                let parameter = self.parameter(has_input);
                let _ = writeln!(
                    out,
                    "    codel<{state}> t{task}_{codel}({parameter}) yield {next} wcet {wcet} us;"
                );
            }
            out.push_str("  };\n");
        }
        for activity in 0..*self.pick(&[0, 1, 1, 2]) {
            let task = self.dice.usize(..tasks.len());
            let work = tasks[task].0 as f64 * 1000.0 * (0.02 + self.dice.f64() / 10.0);
            self.activity(&mut out, (number, activity), &format!("t{task}"), work as u64);
        }
        if self.dice.f64() < 0.45 {
            out.push_str("  task plan { };\n");
            let work = self.dice.u64(500..=6000);
            self.activity(&mut out, (number, 9), "plan", work);
        }
        if self.dice.f64() < 0.6 {
            let parameter = *self.pick(&["", "in a", "inout a", "out b"]);
            let wcet = self.dice.u32(10..=100);
            let _ = writeln!(
                out,
                "  function set() {{ codel set_value({parameter}) wcet {wcet} us; }};"
            );
            self.activities.push(format!("c{number}.set"));
        }
        out.push_str("};\n");
        out
    }

    /// Adds an activity: a single codel, a loop that ends at any time, or one that lasts until it is
    /// interrupted. Aperiodic tasks have the first kind.
    fn activity(
        &mut self,
        out: &mut String,
        (component, number): (usize, usize),
        task: &str,
        wcet: u64,
    ) {
        let name = format!("do{number}");
        self.activities.push(format!("c{component}.{name}"));
        let mut codel = |state: &str, to: &str, wcet: u64| {
            let parameter = self.parameter(component > 0);
            format!("    codel<{state}> {name}_{state}({parameter}) yield {to} wcet {wcet} us;\n")
        };
        let mut kinds = vec![codel("start", "ether", wcet)];
        kinds.push(codel("start", "go", wcet / 2 + 1) + &codel("go", "pause::go, ether", wcet));
        let codels = codel("start", "go", wcet) + &codel("go", "pause::go, stop", wcet / 2 + 1);
        kinds.push(codels + &codel("stop", "ether", 20));
        let kind = if task == "plan" { 0 } else { self.dice.usize(..kinds.len()) };
        let _ = writeln!(out, "  activity {name}() {{ task {task};");
        out.push_str(&kinds[kind]);
        if self.dice.f64() < 0.4 {
            let _ = writeln!(out, "    interrupts {name};");
        }
        out.push_str("  };\n");
    }
}
