//! Fiacre programs, read back: a reader of the printed subset, with the semantics of time transition systems
//! in whole units of time. Whole units suffice: all bounds are closed, except that of a limit that is passed.

use std::collections::{BTreeMap, HashMap, HashSet};

use dotgen_export::{Format, export};
use dotgen_timing::explore::Limits;
use dotgen_timing::report::Verdict;
use dotgen_timing::verify::Options;

use crate::random_systems::{published, random};
use crate::systems::{Dice, System};

/// Limit on states of a program.
const STATES: usize = 8_000;

/// Limit on states of the verifier. What it has not found by then has no verdict.
const VERIFIER_STATES: usize = 20_000;

/// Expression: a number, an element of a variable, or an operation.
enum Expr {
    Number(i16),
    Element(usize, Box<Expr>),
    Not(Box<Expr>),
    Binary(Operator, Box<Expr>, Box<Expr>),
}

#[derive(Clone, Copy)]
enum Operator {
    And,
    Or,
    Equal,
    Less,
    Greater,
    AtLeast,
    Plus,
    Minus,
}

/// `if CONDITION then TARGET := VALUE else TARGET := VALUE end`.
struct Update(Expr, Expr, Expr, Option<Expr>);

#[derive(Default)]
struct Transition {
    source: usize,
    guard: Vec<Expr>,
    port: String,
    updates: Vec<Update>,
    target: usize,
}

#[derive(Default)]
struct Process {
    states: Vec<String>,
    /// States in which no time passes.
    urgent: HashSet<usize>,
    transitions: Vec<Transition>,
}

/// Transitions of one process or two that fire together, with the bounds of their time.
struct Step {
    parts: Vec<(usize, usize)>,
    port: String,
    lower: i16,
    upper: Option<i16>,
    /// Place of its time in a state, if a time is neither always 0 nor without effect.
    clock: Option<usize>,
}

#[derive(Default)]
struct Program {
    processes: Vec<Process>,
    /// Offset and length of each variable.
    variables: Vec<(usize, usize)>,
    names: HashMap<String, usize>,
    size: usize,
    ports: BTreeMap<String, (i16, Option<i16>)>,
    /// By port, the ports that come before it.
    above: HashMap<String, HashSet<String>>,
    /// Process and state of each property.
    goals: Vec<(usize, usize)>,
}

/// Words of an expression or statement.
fn words(text: &str) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    let mut joins = false;
    for c in text.chars() {
        let is_word = c.is_ascii_alphanumeric() || c == '_';
        let continues = match out.last() {
            Some(last) if is_word => {
                joins && last.ends_with(|c: char| c.is_ascii_alphanumeric() || c == '_')
            }
            Some(last) => c == '=' && joins && matches!(&**last, ":" | ">" | "<"),
            None => false,
        };
        match out.last_mut() {
            Some(last) if continues => last.push(c),
            _ if c == ' ' => {}
            _ => out.push(c.to_string()),
        }
        joins = c != ' ';
    }
    out
}

impl Program {
    fn expr(&self, words: &mut std::slice::Iter<String>) -> Expr {
        let mut left = self.unary(words);
        while let Some(word) = words.as_slice().first() {
            let operator = match &**word {
                "and" => Operator::And,
                "or" => Operator::Or,
                "=" => Operator::Equal,
                "<" => Operator::Less,
                ">" => Operator::Greater,
                ">=" => Operator::AtLeast,
                "+" => Operator::Plus,
                "-" => Operator::Minus,
                _ => break,
            };
            words.next();
            left = Expr::Binary(operator, Box::new(left), Box::new(self.unary(words)));
        }
        left
    }

    fn unary(&self, words: &mut std::slice::Iter<String>) -> Expr {
        let word = words.next().expect("an operand");
        match &**word {
            "(" => {
                let inner = self.expr(words);
                assert_eq!(words.next().map(String::as_str), Some(")"));
                inner
            }
            "not" => Expr::Not(Box::new(self.unary(words))),
            "true" | "false" => Expr::Number(i16::from(word == "true")),
            _ => {
                if let Ok(number) = word.parse() {
                    return Expr::Number(number);
                }
                let variable = *self.names.get(word).unwrap_or_else(|| panic!("{word}"));
                if words.as_slice().first().is_none_or(|next| next != "[") {
                    return Expr::Element(variable, Box::new(Expr::Number(0)));
                }
                words.next();
                let index = self.expr(words);
                assert_eq!(words.next().map(String::as_str), Some("]"));
                Expr::Element(variable, Box::new(index))
            }
        }
    }

    fn update(&self, text: &str) -> Update {
        let all = words(text);
        let mut words = all.iter();
        let mut condition = Expr::Number(1);
        if all[0] == "if" {
            words.next();
            condition = self.expr(&mut words);
            assert_eq!(words.next().map(String::as_str), Some("then"));
        }
        let target = self.unary(&mut words);
        assert_eq!(words.next().map(String::as_str), Some(":="));
        let value = self.expr(&mut words);
        let mut other = None;
        if words.as_slice().first().is_some_and(|word| word == "else") {
            words.next();
            self.unary(&mut words);
            assert_eq!(words.next().map(String::as_str), Some(":="), "{text}");
            other = Some(self.expr(&mut words));
        }
        Update(condition, target, value, other)
    }

    /// Reads a program: the component first, since it declares the variables.
    fn read(text: &str) -> Program {
        let mut out = Program::default();
        let lines = text.lines().map(|line| line.trim().trim_end_matches(','));
        let lines: Vec<&str> =
            lines.filter(|line| !line.is_empty() && !line.starts_with("//")).collect();
        let component = lines.iter().position(|line| line.starts_with("component ")).expect("one");
        for line in &lines[component..] {
            if let Some((name, value)) = line.split_once(" := ") {
                let name = name.split(" : ").next().expect("a name").to_owned();
                let length = value.split(',').count();
                out.names.insert(name, out.variables.len());
                out.variables.push((out.size, length));
                out.size += length;
            } else if let Some((name, time)) = line.split_once(" : sync in ") {
                let (lower, upper) = time[1..].split_once(',').expect("two bounds");
                let is_open = i16::from(time.starts_with(']'));
                let lower = lower.parse::<i16>().expect("a number") + is_open;
                out.ports
                    .insert(name.to_owned(), (lower, upper.trim_end_matches(']').parse().ok()));
            } else if line.contains(" > ") {
                for (high, low) in line.split(", ").filter_map(|pair| pair.split_once(" > ")) {
                    out.above.entry(low.to_owned()).or_default().insert(high.to_owned());
                }
            }
        }
        out.read_processes(&lines[..component]);
        for line in lines.iter().filter(|line| line.starts_with("property ")) {
            let (path, state) = line.trim_end_matches(')').split_once("/state ").expect("a path");
            let process = path.rsplit('/').next().and_then(|number| number.parse::<usize>().ok());
            let process = process.expect("a number") - 1;
            let states = &out.processes[process].states;
            let state = states.iter().position(|name| name == state).expect("a state");
            out.goals.push((process, state));
        }
        out
    }

    fn read_processes(&mut self, lines: &[&str]) {
        let mut lines = lines.iter().peekable();
        let mut process = Process::default();
        let mut source = 0;
        let mut transition = Transition::default();
        while let Some(line) = lines.next() {
            let state = |process: &Process, name: &str| {
                process.states.iter().position(|state| state == name).expect("a state")
            };
            if line.starts_with("process ") {
                if !process.states.is_empty() {
                    self.processes.push(std::mem::take(&mut process));
                }
                while lines.next_if(|line| **line != "states").is_some() {}
                lines.next();
                while let Some(name) = lines.next_if(|line| **line != "init") {
                    process.states.push((*name).to_owned());
                }
                lines.next();
                assert_eq!(*lines.next().expect("init"), format!("to {}", process.states[0]));
            } else if let Some(name) = line.strip_prefix("from ") {
                source = state(&process, name);
            } else if let Some(guard) = line.strip_prefix("on ") {
                let words = words(guard.trim_end_matches(';'));
                transition.guard.push(self.expr(&mut words.iter()));
            } else if let Some(target) = line.strip_prefix("to ") {
                transition.source = source;
                transition.target = state(&process, target);
                process.transitions.push(std::mem::take(&mut transition));
            } else if *line == "wait [0,0]; loop" {
                process.urgent.insert(source);
            } else if let Some(statement) = line.strip_suffix(';') {
                if statement.contains(":=") {
                    transition.updates.push(self.update(statement));
                } else {
                    assert!(self.ports.contains_key(statement), "{statement}");
                    statement.clone_into(&mut transition.port);
                }
            } else {
                assert!(
                    ["type number", "type numbers", "select", "[]", "end"]
                        .iter()
                        .any(|word| line.starts_with(word)),
                    "{line}"
                );
            }
        }
        self.processes.push(process);
    }

    fn value(&self, of: &Expr, memory: &[i16]) -> i16 {
        match of {
            Expr::Number(number) => *number,
            Expr::Element(variable, index) => memory[self.cell(*variable, index, memory)],
            Expr::Not(of) => 1 - self.value(of, memory),
            Expr::Binary(operator, left, right) => {
                let (left, right) = (self.value(left, memory), self.value(right, memory));
                match operator {
                    Operator::And => left & right,
                    Operator::Or => left | right,
                    Operator::Equal => i16::from(left == right),
                    Operator::Less => i16::from(left < right),
                    Operator::Greater => i16::from(left > right),
                    Operator::AtLeast => i16::from(left >= right),
                    Operator::Plus => left + right,
                    Operator::Minus => left - right,
                }
            }
        }
    }

    fn cell(&self, variable: usize, index: &Expr, memory: &[i16]) -> usize {
        let (offset, length) = self.variables[variable];
        let index = usize::try_from(self.value(index, memory)).expect("an index");
        assert!(index < length);
        offset + index
    }

    /// Returns the steps: transitions of a port of one process, and pairs of a port of two.
    fn steps(&self) -> Vec<Step> {
        let mut out = Vec::new();
        let mut clocks = self.processes.len() + self.size;
        for (port, &(lower, upper)) in &self.ports {
            let of = |process: &Process| -> Vec<usize> {
                let own = process.transitions.iter().enumerate();
                own.filter(|(_, transition)| transition.port == *port)
                    .map(|(index, _)| index)
                    .collect()
            };
            let owners: Vec<(usize, Vec<usize>)> =
                self.processes.iter().map(of).enumerate().collect();
            let owners: Vec<_> = owners.into_iter().filter(|(_, own)| !own.is_empty()).collect();
            let mut add = |parts| {
                let is_timed = lower > 0 || upper.is_some_and(|upper| upper > 0);
                let clock = is_timed.then(|| {
                    clocks += 1;
                    clocks - 1
                });
                out.push(Step { parts, port: port.clone(), lower, upper, clock });
            };
            match &owners[..] {
                [(one, own)] => {
                    for &index in own {
                        add(vec![(*one, index)]);
                    }
                }
                [(one, own), (other, others)] => {
                    for (&index, &second) in own
                        .iter()
                        .flat_map(|index| others.iter().map(move |second| (index, second)))
                    {
                        add(vec![(*one, index), (*other, second)]);
                    }
                }
                _ => panic!("{port} has {} processes", owners.len()),
            }
        }
        out
    }

    /// Returns the state after a step, with the times of all steps as before.
    fn fired(&self, step: &Step, state: &[i16]) -> Vec<i16> {
        let count = self.processes.len();
        let mut after = state.to_vec();
        for &(process, index) in &step.parts {
            let transition = &self.processes[process].transitions[index];
            after[process] = transition.target as i16;
            for Update(condition, target, value, other) in &transition.updates {
                let memory = &mut after[count..count + self.size];
                let holds = self.value(condition, memory) == 1;
                let value = if holds { Some(value) } else { other.as_ref() };
                if let (Some(value), Expr::Element(variable, index)) = (value, target) {
                    let cell = self.cell(*variable, index, memory);
                    memory[cell] = self.value(value, memory);
                }
            }
        }
        after
    }

    fn is_enabled(&self, step: &Step, state: &[i16]) -> bool {
        let count = self.processes.len();
        step.parts.iter().all(|&(process, index)| {
            let transition = &self.processes[process].transitions[index];
            let memory = &state[count..count + self.size];
            usize::try_from(state[process]) == Ok(transition.source)
                && transition.guard.iter().all(|guard| self.value(guard, memory) == 1)
        })
    }

    /// Returns the states after a step, or after a unit of time.
    fn next(&self, steps: &[Step], state: &[i16]) -> Vec<Vec<i16>> {
        let time = |step: &Step| step.clock.map_or(0, |clock| state[clock]);
        let able: Vec<&Step> = steps.iter().filter(|step| self.is_enabled(step, state)).collect();
        let ready: Vec<&&Step> = able.iter().filter(|step| time(step) >= step.lower).collect();
        let mut out = Vec::new();
        for step in &ready {
            let above = self.above.get(&step.port);
            if above.is_some_and(|above| ready.iter().any(|high| above.contains(&high.port))) {
                continue;
            }
            let mut after = self.fired(step, state);
            for known in steps {
                let Some(clock) = known.clock else { continue };
                let process = |part: &(usize, usize)| step.parts.iter().any(|own| own.0 == part.0);
                if known.parts.iter().any(process) || !self.is_enabled(known, &after) {
                    after[clock] = 0;
                }
            }
            out.push(after);
        }
        let mut processes = self.processes.iter().zip(state);
        let stops = processes.any(|(process, &at)| process.urgent.contains(&(at as usize)));
        let is_late = |step: &&Step| step.upper.is_some_and(|upper| time(step) >= upper);
        if !stops && !able.iter().any(is_late) {
            let mut after = state.to_vec();
            for (step, clock) in able.iter().filter_map(|step| Some((step, step.clock?))) {
                after[clock] = (after[clock] + 1).min(step.upper.unwrap_or(step.lower));
            }
            out.push(after);
        }
        out
    }

    /// Returns true if the state of a property is reached; `None` if there are too many states.
    fn is_reached(&self) -> Option<bool> {
        let steps = self.steps();
        let clocks = steps.iter().filter(|step| step.clock.is_some()).count();
        let first = vec![0_i16; self.processes.len() + self.size + clocks];
        let (mut seen, mut open) = (HashSet::from([first.clone()]), vec![first]);
        while let Some(state) = open.pop() {
            let is_goal = |&(process, goal): &(usize, usize)| state[process] == goal as i16;
            if self.goals.iter().any(is_goal) {
                return Some(true);
            }
            for after in self.next(&steps, &state) {
                if seen.len() > STATES {
                    return None;
                }
                if seen.insert(after.clone()) {
                    open.push(after);
                }
            }
        }
        Some(false)
    }
}

/// Returns whether the state of the check of a model is reached, and whether the check holds then; `None` if
/// there are too many states.
type Answer = fn(&str) -> Option<(bool, bool)>;

/// Compares the answers to each check of a system with those of the verifier. Returns how many checks have a
/// state that is not reached, and how many have one that is.
fn compare(system: &System, path: &str, format: Format, answer: Answer) -> [usize; 2] {
    let limits = Limits { states: VERIFIER_STATES, ..Limits::default() };
    let options = Options { limits, ..Options::default() };
    let (prepared, report) = (system.prepared(&options), system.report(&options));
    let mut equal = [0, 0];
    for check in &prepared.checks {
        let known = report.checks.iter().find(|known| known.id == check.report.id);
        let mut alone = prepared.clone();
        alone.checks = vec![check.clone()];
        let Ok(files) = export(&alone, &|_, _| None, format) else { continue };
        let (Some((reached, is_wanted)), Some(known)) = (answer(&files[0].text), known) else {
            continue;
        };
        if matches!(known.verdict, Verdict::Unknown | Verdict::Nothing) {
            continue;
        }
        let subject = format!("{path}: {} {}", check.report.kind, check.report.of);
        assert_eq!(reached, known.verdict.holds() == is_wanted, "{subject}");
        equal[usize::from(reached)] += 1;
    }
    equal
}

/// Compares the models of random systems with the verifier.
pub(crate) fn compare_random(systems: u64, format: Format, answer: Answer) {
    let (mut equal, mut tried) = ([0, 0], 0);
    for seed in 0..dotgen_loaders::times(systems) {
        let draw = [random::texts, random::patterned, published][seed as usize % 3];
        let texts = draw(&mut Dice::new(seed));
        let Some(system) = System::of_texts(&texts.specifications, &texts.scenario) else {
            continue;
        };
        tried += 1;
        let found = compare(&system, &format!("seed {seed}"), format, answer);
        equal = [equal[0] + found[0], equal[1] + found[1]];
    }
    eprintln!("{equal:?} answers of {tried} systems are equal");
    assert!(equal.iter().all(|&count| count > 5), "{equal:?}");
}

#[test]
fn random_systems_have_the_answers_of_the_verifier() {
    compare_random(24, Format::Fiacre, |text| {
        let reached = Program::read(text).is_reached()?;
        Some((reached, text.contains("the check holds if false")))
    });
}
