//! Random small specifications and scenarios, as text, so that the comparison includes all parsers.

use std::fmt::Write;

use super::super::systems::Dice;

#[path = "random_patterns.rs"]
mod random_patterns;

/// A specification for each component, and a scenario.
pub(crate) struct Texts {
    pub(crate) specifications: Vec<String>,
    pub(crate) scenario: String,
}

/// Names for predicates and clients.
#[derive(Default)]
struct Known {
    /// `c.t.x`: states of machines.
    states: Vec<String>,
    activities: Vec<String>,
    tasks: Vec<String>,
    services: Vec<String>,
    /// All points are random: ports, priorities, and every point of the semantics; see [`varied`].
    varied: bool,
    /// There are no requests, and cores are granted in order of release.
    quiet: bool,
    /// There are no requests, any policy of cores applies, and all tasks have periods.
    periodic: bool,
    /// Tasks with and without a period come in any order, periods are long, and any order of cores applies.
    occasional: bool,
    /// Clients make requests that all components accept, and wait for outcomes of requests.
    requests: bool,
    /// Data flow, through ports and through variables of activities.
    chains: bool,
    /// Checks of patterns.
    patterns: bool,
    /// There is one component.
    alone: bool,
    /// Ports that codels of the present component may name.
    ports: &'static [&'static str],
}

/// Returns a system of one or two components with one to three tasks each and all features of the semantics
/// of the servers.
pub(crate) fn texts(dice: &mut Dice) -> Texts {
    draw(dice, Known::default())
}

/// Returns such a system with single points of the semantics, preemption, ports, and permanent activities
/// that throw.
pub(crate) fn varied(dice: &mut Dice) -> Texts {
    let varied = Known { varied: true, ..Known::default() };
    draw(dice, varied)
}

/// Returns such a system with checks of patterns.
pub(crate) fn patterned(dice: &mut Dice) -> Texts {
    let (varied, periodic) = (dice.in_ten(4), dice.in_ten(4));
    draw(dice, Known { varied, periodic, patterns: true, ..Known::default() })
}

/// Returns such a system with clients that abort, kill and connect, and wait for success or failure.
pub(crate) fn requests(dice: &mut Dice) -> Texts {
    let varied = dice.in_ten(4);
    let requests = Known { varied, requests: true, ..Known::default() };
    draw(dice, requests)
}

/// Returns such a system with data that flow through ports, members of `ids` and variables of activities, and
/// checks of chains.
pub(crate) fn chained(dice: &mut Dice) -> Texts {
    let chains = Known { chains: true, ..Known::default() };
    asking_chains(dice, chains)
}

/// Returns a system with chains through permanent activities of tasks with periods, none of which waits for a
/// core.
pub(crate) fn chained_steadily(dice: &mut Dice) -> Texts {
    let steady = Known { chains: true, quiet: true, periodic: true, ..Known::default() };
    let mut out = asking_chains(dice, steady);
    for cores in ["cores 1;", "cores 2;", "cores 4;"] {
        out.scenario = out.scenario.replace(cores, "cores free;");
    }
    out
}

fn asking_chains(dice: &mut Dice, known: Known) -> Texts {
    let mut out = draw(dice, known);
    let from = dice.pick(&["c.p", "c.p", "c.q"]);
    let to = match out.specifications.len() {
        1 => "c.r",
        _ => dice.pick(&["c.r", "d.q"]),
    };
    let lines = out.scenario.lines().filter(|line| !line.starts_with(" check") && *line != "}");
    let lines: Vec<&str> = lines.collect();
    out.scenario = format!(
        "{}\n check reaction {from} -> {to};\n check age {from} -> {to};\n}}\n",
        lines.join("\n")
    );
    out
}

/// Returns a system with permanent activities only, on few cores that are granted in order of release.
pub(crate) fn quiet(dice: &mut Dice) -> Texts {
    let quiet = Known { quiet: true, ..Known::default() };
    draw(dice, quiet)
}

/// Returns a system with permanent activities only, of tasks with periods.
pub(crate) fn periodic(dice: &mut Dice) -> Texts {
    let periodic = Known { quiet: true, periodic: true, ..Known::default() };
    draw(dice, periodic)
}

/// Returns a system with tasks with and without periods, in any order, and requests.
pub(crate) fn occasional(dice: &mut Dice) -> Texts {
    let occasional = Known { occasional: true, ..Known::default() };
    draw(dice, occasional)
}

/// Returns a system under preemption, with all other points of the semantics as they are.
pub(crate) fn preempted(dice: &mut Dice) -> Texts {
    let quiet = dice.in_ten(4);
    let mut out = draw(dice, Known { quiet, periodic: quiet, ..Known::default() });
    for specification in &mut out.specifications {
        let lines = specification.lines().map(|line| {
            if line.starts_with("  period") && dice.in_ten(7) {
                format!("{line}\n  priority {};\n", dice.below(4))
            } else {
                format!("{line}\n")
            }
        });
        *specification = lines.collect();
    }
    let lines = out.scenario.lines().map(|line| match line.split_once(" durations ") {
        Some((_, durations)) => {
            let (cores, policy) =
                (dice.pick(&["1", "1", "2", "3"]), dice.pick(&["priority", "priority", "fair"]));
            format!(" cores {cores}; policy {policy}; durations {durations}\n")
        }
        None => format!("{line}\n"),
    });
    out.scenario = lines.collect();
    out
}

/// Returns a system of two equal components with equal clients, or of a component with two equal clients.
/// Sometimes they differ, or only one of them is observed.
pub(crate) fn alike(dice: &mut Dice) -> Texts {
    let varied = dice.in_ten(4);
    let known = Known { varied, requests: dice.in_ten(3), alone: true, ..Known::default() };
    let Texts { mut specifications, scenario } = draw(dice, known);
    let together = dice.in_ten(2);
    let copy = |line: &str| if together { line.to_owned() } else { of_second(line) };
    let mut out = String::new();
    let mut client = String::new();
    let mut depth = 0;
    for line in scenario.lines() {
        let _ = writeln!(out, "{line}");
        if line.starts_with(" client") || depth > 0 {
            let count = |brace: char| line.matches(brace).count();
            let _ = match depth {
                0 => writeln!(client, " client l{} {{", out.len()),
                _ => writeln!(client, "{}", copy(line)),
            };
            depth = depth + count('{') - count('}');
            if depth == 0 {
                out.push_str(&std::mem::take(&mut client));
            }
        } else if let Some((head, predicate)) = line.split_once(": reachable ") {
            let predicate = predicate.trim_end_matches(';');
            let other = copy(predicate);
            let with = dice.pick(&["or", "or", "and"]);
            let _ = writeln!(out, "{head}x: reachable ({predicate}) {with} ({other});");
        } else if line.starts_with(" slots") || line.starts_with(" affinity") {
            let _ = writeln!(out, "{}", copy(line));
        }
    }
    if !together {
        let second = specifications[0].replace("component c {", "component d {");
        let differs = dice.in_ten(1);
        specifications.push(if differs {
            second.replacen("wcet 1 ms", "wcet 2 ms", 1)
        } else {
            second
        });
    }
    Texts { specifications, scenario: out }
}

/// Returns a line with the names of the first component replaced by those of the second.
fn of_second(line: &str) -> String {
    let mut out = String::new();
    let mut inside = false;
    for (at, character) in line.char_indices() {
        let ends = line[at + character.len_utf8()..].starts_with(['.', ';']);
        let name = character == 'c' && !inside && ends;
        out.push(if name { 'd' } else { character });
        inside = character.is_alphanumeric() || character == '_' || character == '.';
    }
    out
}

fn draw(dice: &mut Dice, mut known: Known) -> Texts {
    let two = dice.in_ten(if known.quiet { 7 } else { 3 });
    let count = 1 + usize::from(two && !known.alone);
    let specifications = (0..count).map(|c| component(dice, c, count, &mut known));
    let mut specifications: Vec<String> = specifications.collect();
    let scenario = scenario(dice, &known);
    if scenario.contains("pause turns") {
        // An aperiodic task would loop in no time, and time could not pass.
        for specification in &mut specifications {
            *specification = specification.replace("wcet 0 ms", "wcet 1 ms");
        }
    }
    Texts { specifications, scenario }
}

fn component(dice: &mut Dice, c: usize, of: usize, known: &mut Known) -> String {
    let name = ["c", "d"][c];
    let mut out = format!(
        "component {name} {{\n version \"1\"; lang \"c\";\n ids {{ long f0; long f1; }};\n exception bad;\n"
    );
    if known.chains {
        out.insert_str(0, "struct dt { long v; };\n");
        let (text, params): (_, &[&str]) = match c {
            0 => (
                " port out dt p; port in dt q; port out dt r;\n",
                &["out p", "in q", "in q, out f0", "in f0, out p", "in f0, out r", "in f1, out r"],
            ),
            _ => (
                " port in dt p; port out dt q;\n",
                &["in p, out f0", "in p, out q", "in f0, out q"],
            ),
        };
        out.push_str(text);
        known.ports = params;
    } else if known.varied && dice.in_ten(5) {
        out.insert_str(0, "struct dt { long v; };\n");
        let (text, params): (_, &[&str]) = match c {
            0 => (" port out dt p; port in dt q;\n", &["out p", "out p", "in q"]),
            _ => (" port in dt p; port out dt q;\n", &["in p", "in p", "out q"]),
        };
        out.push_str(text);
        known.ports = params;
    } else {
        known.ports = &[];
    }
    let tasks = 1 + dice.below(if of == 1 { 3 } else { 2 });
    let mut periodic = Vec::new();
    for t in 0..tasks {
        let has_period = if known.occasional {
            dice.in_ten(6) || (t + 1 == tasks && !periodic.contains(&true))
        } else {
            known.periodic || dice.in_ten(7)
        };
        periodic.push(has_period);
        let _ = writeln!(out, " task t{t} {{");
        if has_period {
            let period = if known.periodic || known.occasional {
                dice.pick(&[4, 6, 8, 12, 12, 16])
            } else {
                dice.pick(&[3, 4, 6, 6, 8])
            };
            let _ = writeln!(out, "  period {period} ms;");
            if dice.in_ten(3) {
                let _ = writeln!(out, "  delay {} ms;", 1 + dice.below(3));
            }
        }
        if known.varied && dice.in_ten(4) {
            let _ = writeln!(out, "  priority {};", dice.below(3));
        }
        if (known.varied || known.periodic || known.occasional) && dice.in_ten(1) {
            out.push_str("  throw bad;\n");
        }
        known.tasks.push(format!("{name}.t{t}"));
        if dice.in_ten(if known.periodic { 9 } else { 6 }) {
            let path = format!("{name}.t{t}");
            machine(dice, &mut out, &format!("t{t}"), &path, false, known);
        }
        out.push_str(" };\n");
    }
    let services = if known.quiet { 0 } else { dice.below(if of == 1 { 4 } else { 3 }) };
    for s in 0..services {
        let path = format!("{name}.s{s}");
        let kind = dice.pick(&["activity", "activity", "activity", "function", "attribute"]);
        let params = match kind {
            "attribute" => dice.pick(&["in f0", "out f1"]),
            _ if known.chains => "inout long x",
            _ => "",
        };
        let ports = known.ports;
        if params == "inout long x" {
            known.ports = match c {
                0 => &[
                    "in q, local out x",
                    "in f0, local out x",
                    "local inout x",
                    "local in x, out r",
                    "local in x, out p",
                    "local in x, out f1",
                ],
                _ => &["in p, local out x", "local in x, out q", "local in x, out f0"],
            };
        }
        let _ = writeln!(out, " {kind} s{s}({params}) {{");
        if kind == "activity" {
            let _ = writeln!(out, "  task t{};", dice.below(tasks));
        }
        if dice.in_ten(2) {
            let (params, wcet) = (params_of(dice, known), time(dice));
            let _ = writeln!(out, "  validate v{s}({params}) wcet {wcet} ms;");
        }
        if kind == "activity" {
            let stops = dice.in_ten(5);
            machine(dice, &mut out, &format!("s{s}"), &path, stops, known);
            known.activities.push(path.clone());
        } else if kind == "function" {
            for i in 0..dice.below(3) {
                let (params, wcet) = (params_of(dice, known), time(dice));
                let _ = writeln!(out, "  codel g{s}_{i}({params}) wcet {wcet} ms;");
            }
        }
        if dice.in_ten(2) {
            out.push_str("  throw bad;\n");
        }
        if kind != "attribute" && dice.in_ten(5) {
            let _ = writeln!(out, "  interrupts s{};", dice.below(services));
        }
        if dice.in_ten(1) {
            let _ = writeln!(out, "  after s{};", dice.below(services));
        }
        if dice.in_ten(1) {
            let _ = writeln!(out, "  before s{};", dice.below(services));
        }
        out.push_str(" };\n");
        known.services.push(path);
        known.ports = ports;
    }
    out.push_str("};\n");
    // An exception that no codel throws is not an error, but the component would throw it.
    out.replace(
        " exception bad;\n",
        if out.contains("throw bad") { " exception bad;\n" } else { "" },
    )
}

fn params_of(dice: &mut Dice, known: &Known) -> &'static str {
    if !known.ports.is_empty() && dice.in_ten(if known.chains { 8 } else { 4 }) {
        return dice.pick(known.ports);
    }
    dice.pick(&["", "", "in f0", "inout f0", "inout f0", "in f1", "inout f1"])
}

fn time(dice: &mut Dice) -> u32 {
    dice.pick(&[0, 1, 1, 1, 2, 2, 3])
}

/// Returns one to three states, and sometimes `stop`.
fn machine(
    dice: &mut Dice,
    out: &mut String,
    owner: &str,
    path: &str,
    stops: bool,
    known: &mut Known,
) {
    let states = &["start", "x", "y"][..=(dice.below(3) as usize)];
    let permanent = owner.starts_with('t');
    for (i, state) in states.iter().enumerate() {
        let mut yields: Vec<String> = Vec::new();
        for first in [true, false] {
            // The first yield leads to the next state, so that all states can be reached.
            let onwards = states.get(i + 1).filter(|_| first || dice.in_ten(4));
            let to = match onwards {
                Some(next) if dice.in_ten(5) => (*next).to_owned(),
                Some(next) => format!("pause::{next}"),
                None if !first && dice.in_ten(7) => break,
                None if permanent || dice.in_ten(7) => format!("pause::{}", dice.pick(states)),
                None => "ether".to_owned(),
            };
            if !yields.contains(&to) {
                yields.push(to);
            }
        }
        let (params, wcet) = (params_of(dice, known), time(dice));
        let yields = yields.join(", ");
        let _ = writeln!(
            out,
            "  codel<{state}> {owner}_{state}({params}) yield {yields} wcet {wcet} ms;"
        );
        known.states.push(format!("{path}.{state}"));
    }
    if stops {
        let (params, wcet) = (params_of(dice, known), time(dice));
        let to = if dice.in_ten(2) {
            format!("pause::{}", dice.pick(states))
        } else {
            "ether".to_owned()
        };
        let _ = writeln!(out, "  codel<stop> {owner}_stop({params}) yield {to} wcet {wcet} ms;");
        known.states.push(format!("{path}.stop"));
    }
}

fn scenario(dice: &mut Dice, known: &Known) -> String {
    let mut out = "scenario s {\n semantics servers;\n unit 1 ms;\n".to_owned();
    let cores = dice.pick(&["free", "free", "free", "1", "1", "2"]);
    let policy = if known.varied {
        dice.pick(&["fifo", "edf", "any", "priority", "priority", "fair"])
    } else {
        dice.pick(&["fifo", "fifo", "edf", "any"])
    };
    let (cores, policy) = match known.quiet || known.occasional {
        true if known.periodic || known.occasional => (
            dice.pick(&["free", "1", "2", "2", "4"]),
            dice.pick(&["fifo", "fifo", "edf", "edf", "any"]),
        ),
        true => (dice.pick(&["1", "2", "2"]), "fifo"),
        false => (cores, policy),
    };
    let durations = if known.quiet {
        dice.pick(&["fixed", "interval", "interval"])
    } else {
        dice.pick(&["fixed", "fixed", "fixed", "interval"])
    };
    let _ = writeln!(out, " cores {cores}; policy {policy}; durations {durations};");
    if dice.in_ten(2) {
        out.push_str(" aperiodic free;\n");
    }
    if known.varied {
        points(dice, known, (cores, policy), &mut out);
    }
    if dice.in_ten(1) {
        let _ = writeln!(out, " slots {} {};", known.tasks[0], 1 + dice.below(3));
    }
    for k in 0..if known.services.is_empty() { 0 } else { 1 + dice.below(6) / 5 } {
        let _ = writeln!(out, " client k{k} {{");
        let again = dice.in_ten(2);
        if again {
            out.push_str("  repeat * {\n");
        }
        for step in 0..=dice.below(3) {
            if known.requests && dice.in_ten(3) {
                asks(dice, known, &mut out);
            }
            if dice.in_ten(6) {
                let from = dice.below(9);
                let to = from + if dice.in_ten(3) { dice.below(4) } else { 0 };
                let _ = writeln!(out, "  delay [{from},{to}] ms;");
            }
            let all: Vec<&str> = known.services.iter().map(String::as_str).collect();
            let sent = dice.pick(&all);
            let aborts = known.requests && known.activities.iter().any(|activity| activity == sent);
            if aborts && dice.in_ten(2) {
                let _ = writeln!(out, "  a{step}: send {sent};\n  delay {} ms;", dice.below(6));
                let _ = writeln!(out, "  abort a{step};");
            } else {
                let _ = writeln!(out, "  send {sent};");
            }
            if aborts && dice.in_ten(4) {
                let _ = writeln!(out, "  delay {} ms;\n  abort {sent};", dice.below(9));
            }
            if known.requests && dice.in_ten(3) {
                outcome(dice, known, sent, &mut out);
            } else if dice.in_ten(3) {
                out.push_str("  await ended;\n");
            }
        }
        if again {
            out.push_str("  delay 5 ms;\n }\n");
        }
        out.push_str(" }\n");
    }
    out.push_str(" check schedulable *; check no-overdue *; check response *;\n");
    for i in 0..if known.quiet { 0 } else { 2 } {
        let (p, q) = (predicate(dice, known), predicate(dice, known));
        let _ = writeln!(out, " check r{i}: reachable {p};");
        if i == 0 && dice.in_ten(6) {
            let mut own = Dice::new(u64::from(dice.below(1 << 16)));
            let then = if own.in_ten(3) {
                format!(" then {}", predicate(&mut own, known))
            } else {
                String::new()
            };
            let _ = writeln!(out, " check w: within {p} => {q}{then};");
        }
    }
    if known.patterns {
        random_patterns::add(dice, known, &mut out);
    }
    out.push_str("}\n");
    out
}

/// Adds a request that all components accept.
fn asks(dice: &mut Dice, known: &Known, out: &mut String) {
    let component = &dice.pick(&known.tasks.iter().collect::<Vec<_>>())[..1];
    let activities: Vec<&str> = known.activities.iter().map(String::as_str).collect();
    let _ = match dice.below(5) {
        0 => writeln!(out, "  kill {component};"),
        1 | 2 if !activities.is_empty() => writeln!(out, "  abort {};", dice.pick(&activities)),
        3 => writeln!(out, "  delay {} ms;\n  connect {component};", dice.below(5)),
        _ => writeln!(out, "  connect {component};"),
    };
}

/// Adds a wait for an outcome of a request, or different steps for each outcome.
fn outcome(dice: &mut Dice, known: &Known, sent: &str, out: &mut String) {
    let services: Vec<&str> = known.services.iter().map(String::as_str).collect();
    let other = dice.pick(&services);
    let of = dice.pick(&["", sent]);
    let _ = match dice.below(4) {
        0 => writeln!(out, "  await ended ok {of};"),
        1 => writeln!(out, "  await ended failed {of};"),
        2 => writeln!(
            out,
            "  choice {{ await ended ok {of}; send {other}; }} or {{ await ended failed {of}; delay 3 ms; }}"
        ),
        _ => writeln!(
            out,
            "  choice {{ await ended failed {of}; send {other}; }} or {{ await ended ok {of}; }} or {{ \
                delay 4 ms; }}"
        ),
    };
}

/// Adds single points of the semantics.
fn points(dice: &mut Dice, known: &Known, (cores, policy): (&str, &str), out: &mut String) {
    let lines = [
        ("ticks", &["component", "task"][..]),
        ("turns", &["codel", "pause"]),
        ("locks", &["queue", "free", "fifo"]),
        ("ports", &["copy", "lock"]),
        ("pause", &["events", "turns"]),
        ("exceptions", &["on", "off"]),
        ("order", &["on", "off"]),
    ];
    for (word, rules) in lines {
        if dice.in_ten(3) {
            let _ = writeln!(out, " {word} {};", dice.pick(rules));
        }
    }
    if let (Ok(cores), "priority" | "fair") = (cores.parse::<u32>(), policy) {
        for task in &known.tasks {
            if dice.in_ten(3) {
                let _ = writeln!(out, " affinity {task} {};", 1 + dice.below(cores));
            }
        }
    }
}

fn predicate(dice: &mut Dice, known: &Known) -> String {
    let mut pick = |all: &[String]| {
        let all: Vec<&str> = all.iter().map(String::as_str).collect();
        dice.pick(&all).to_owned()
    };
    let state = (!known.states.is_empty()).then(|| pick(&known.states));
    let activity = (!known.activities.is_empty()).then(|| pick(&known.activities));
    let task = pick(&known.tasks);
    match (dice.below(10), state, activity) {
        (0..4, Some(state), _) => format!("{state}.exec"),
        (4, Some(state), _) => format!("{state}.lock"),
        (5..8, _, Some(state)) => format!("{state}.{}", dice.pick(&["run", "void", "waiting"])),
        (8, _, Some(state)) => format!("not {state}.void"),
        _ => format!("{task}.{}", dice.pick(&["running", "idle"])),
    }
}
