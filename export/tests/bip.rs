//! BIP programs, read back: a strict reader of the printed subset, with time in whole steps. A step is the
//! greatest common divisor of all bounds. Whole steps suffice: all bounds are closed, except that of a limit
//! that is passed.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use dotgen_export::{Format, export};
use dotgen_timing::verify::Options;

use crate::fiacre::compare_random;
use crate::systems::System;

/// Limit on states of a program.
const STATES: usize = 8_000;

/// Value of an integer or clock before its first assignment.
const UNSET: i32 = i32::MIN;

enum Expr {
    Number(i32),
    /// An integer or clock, by its slot in a state.
    Slot(usize),
    Binary(String, Box<Expr>, Box<Expr>),
}

enum Statement {
    Set(usize, Expr),
    If(Expr, Vec<Statement>, Vec<Statement>),
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Urgency {
    Lazy,
    Delayable,
    Eager,
}

struct Transition {
    port: String,
    source: usize,
    target: usize,
    guard: Option<Expr>,
    urgency: Urgency,
    statements: Vec<Statement>,
}

/// An atom. Its place is in the slot with its number.
#[derive(Default)]
struct Atom {
    /// Slots by name.
    slots: HashMap<String, usize>,
    ports: Vec<String>,
    places: Vec<String>,
    transitions: Vec<Transition>,
    invariants: Vec<(usize, Expr)>,
    first: usize,
    initial: Vec<Statement>,
}

#[derive(Default)]
struct Program {
    words: Vec<String>,
    at: usize,
    atoms: Vec<Atom>,
    /// Number of the atom of each type.
    types: HashMap<String, usize>,
    /// Number of ends of each connector type.
    ends: HashMap<String, usize>,
    /// Number of the atom of each component.
    components: HashMap<String, usize>,
    /// Atom and port of each end.
    connectors: Vec<Vec<(usize, String)>>,
    slots: usize,
    /// Greatest bound of each clock, by slot.
    clocks: HashMap<usize, i32>,
    /// Length of a step of time.
    step: i32,
}

fn words(text: &str) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for line in text.lines() {
        let code = line.split("//").next().unwrap_or_default();
        let mut letters = code.chars().peekable();
        while let Some(c) = letters.next() {
            let mut word = c.to_string();
            if c.is_ascii_alphanumeric() {
                while let Some(next) =
                    letters.next_if(|next| next.is_ascii_alphanumeric() || *next == '_')
                {
                    word.push(next);
                }
            } else if "=<>!&|".contains(c) {
                word.extend(letters.next_if(|next| "=&|".contains(*next)));
            }
            if !c.is_whitespace() {
                out.push(word);
            }
        }
    }
    out
}

fn rank(operator: &str) -> usize {
    match operator {
        "||" => 1,
        "&&" => 2,
        "==" | "!=" | "<" | "<=" | ">" | ">=" => 3,
        "+" | "-" => 4,
        _ => 0,
    }
}

impl Program {
    fn peek(&self) -> &str {
        self.words.get(self.at).map_or("", String::as_str)
    }

    fn next(&mut self) -> String {
        self.at += 1;
        self.words[self.at - 1].clone()
    }

    fn take(&mut self, word: &str) -> bool {
        let is = self.peek() == word;
        self.at += usize::from(is);
        is
    }

    fn expect(&mut self, words: &str) {
        for word in words.split(' ') {
            let near = &self.words[self.at.saturating_sub(8)..=self.at.min(self.words.len() - 1)];
            assert!(self.peek() == word, "`{word}` is expected: {near:?}");
            self.at += 1;
        }
    }

    /// Reads a package.
    fn read(text: &str) -> Program {
        let mut out = Program { words: words(text), ..Program::default() };
        let atoms = out.words.windows(2).filter(|pair| *pair == ["atom", "type"]).count();
        out.slots = atoms;
        out.expect("package");
        out.next();
        out.expect("port type Event ( )");
        while !out.take("end") {
            let kind = out.next();
            out.expect("type");
            let name = out.next();
            match &*kind {
                "connector" => out.connector_type(name),
                "atom" => {
                    let atom = out.atom();
                    assert!(out.types.insert(name, out.atoms.len()).is_none());
                    out.atoms.push(atom);
                }
                "compound" => out.compound(),
                other => panic!("{other}"),
            }
        }
        assert_eq!(out.at, out.words.len());
        assert_eq!(out.components.len(), atoms);
        out
    }

    fn connector_type(&mut self, name: String) {
        let mut ends = Vec::new();
        self.expect("(");
        while !self.take(")") {
            self.expect("Event");
            ends.push(self.next());
            self.take(",");
        }
        self.expect("define");
        for end in &ends {
            self.expect(end);
        }
        self.expect("end");
        assert!(self.ends.insert(name, ends.len()).is_none());
    }

    fn atom(&mut self) -> Atom {
        let mut atom = Atom::default();
        self.expect("( )");
        while !self.take("end") {
            match &*self.next() {
                "data" => {
                    self.expect("int");
                    self.slot(&mut atom);
                    while self.take(",") {
                        self.slot(&mut atom);
                    }
                }
                "clock" => {
                    let slot = self.slot(&mut atom);
                    self.clocks.insert(slot, 0);
                    self.expect("unit");
                    let unit = self.next();
                    assert!(
                        ["second", "millisecond", "microsecond", "nanosecond"].contains(&&*unit)
                    );
                }
                "export" => {
                    self.expect("port Event");
                    let port = self.next();
                    assert!(!atom.ports.contains(&port), "{port}");
                    atom.ports.push(port);
                    self.expect("( )");
                }
                "place" => {
                    atom.places.push(self.next());
                    while self.take(",") {
                        atom.places.push(self.next());
                    }
                }
                "initial" => {
                    self.expect("to");
                    atom.first = self.place(&atom);
                    atom.initial = self.action(&atom);
                }
                "on" => {
                    let transition = self.transition(&atom);
                    atom.transitions.push(transition);
                }
                "invariant" => {
                    self.next();
                    self.expect("at");
                    let place = self.place(&atom);
                    self.expect("provided");
                    let condition = self.operand(&atom);
                    atom.invariants.push((place, condition));
                }
                other => panic!("{other}"),
            }
        }
        let distinct: HashSet<&String> = atom.places.iter().collect();
        assert_eq!(distinct.len(), atom.places.len());
        atom
    }

    fn slot(&mut self, atom: &mut Atom) -> usize {
        let name = self.next();
        assert!(atom.slots.insert(name.clone(), self.slots).is_none(), "{name}");
        self.slots += 1;
        self.slots - 1
    }

    fn place(&mut self, atom: &Atom) -> usize {
        let name = self.next();
        atom.places.iter().position(|place| *place == name).unwrap_or_else(|| panic!("{name}"))
    }

    fn transition(&mut self, atom: &Atom) -> Transition {
        let port = self.next();
        assert!(atom.ports.contains(&port), "{port}");
        self.expect("from");
        let source = self.place(atom);
        self.expect("to");
        let target = self.place(atom);
        let guard = self.take("provided").then(|| self.operand(atom));
        let urgency = match &*self.next() {
            "lazy" => Urgency::Lazy,
            "delayable" => Urgency::Delayable,
            "eager" => Urgency::Eager,
            other => panic!("{other}"),
        };
        let statements = self.action(atom);
        Transition { port, source, target, guard, urgency, statements }
    }

    fn action(&mut self, atom: &Atom) -> Vec<Statement> {
        if !self.take("do") {
            return Vec::new();
        }
        self.expect("{");
        let out = self.statements(atom);
        self.expect("}");
        out
    }

    fn statements(&mut self, atom: &Atom) -> Vec<Statement> {
        let mut out = Vec::new();
        while !["}", "else", "fi"].contains(&self.peek()) {
            if self.take("if") {
                let condition = self.operand(atom);
                self.expect("then");
                let yes = self.statements(atom);
                let no = if self.take("else") { self.statements(atom) } else { Vec::new() };
                self.expect("fi");
                out.push(Statement::If(condition, yes, no));
                continue;
            }
            let name = self.next();
            let slot = *atom.slots.get(&name).unwrap_or_else(|| panic!("{name}"));
            self.expect("=");
            let value = self.expr(atom, 1);
            self.expect(";");
            let is_reset = matches!(value, Expr::Number(0));
            assert!(is_reset || !self.clocks.contains_key(&slot), "{name}");
            out.push(Statement::Set(slot, value));
        }
        assert!(!out.is_empty(), "an empty block");
        out
    }

    fn operand(&mut self, atom: &Atom) -> Expr {
        let word = self.next();
        if word == "(" {
            let inner = self.expr(atom, 1);
            self.expect(")");
            return inner;
        }
        match word.parse() {
            _ if ["false", "true"].contains(&&*word) => Expr::Number(i32::from(word == "true")),
            Ok(number) => Expr::Number(number),
            Err(_) => Expr::Slot(*atom.slots.get(&word).unwrap_or_else(|| panic!("{word}"))),
        }
    }

    /// Reads operators of at least a rank.
    fn expr(&mut self, atom: &Atom, least: usize) -> Expr {
        let mut left = self.operand(atom);
        while rank(self.peek()) >= least {
            let operator = self.next();
            let right = self.expr(atom, rank(&operator) + 1);
            if let (Expr::Slot(slot), Expr::Number(number)) = (&left, &right)
                && let Some(most) = self.clocks.get_mut(slot)
            {
                assert_eq!(rank(&operator), 3);
                *most = (*most).max(*number);
                self.step = divisor(self.step, *number);
            }
            left = Expr::Binary(operator, Box::new(left), Box::new(right));
        }
        left
    }

    fn compound(&mut self) {
        self.next();
        self.expect(")");
        let mut names = HashSet::new();
        while !self.take("end") {
            match &*self.next() {
                "component" => {
                    let kind = self.next();
                    let name = self.next();
                    self.expect("( )");
                    let atom = *self.types.get(&kind).unwrap_or_else(|| panic!("{kind}"));
                    assert!(self.components.insert(name, atom).is_none());
                }
                "connector" => {
                    let kind = self.next();
                    assert!(names.insert(self.next()));
                    self.expect("(");
                    let mut ends = Vec::new();
                    while !self.take(")") {
                        let component = self.next();
                        self.expect(".");
                        let (atom, port) = (self.components[&component], self.next());
                        assert!(self.atoms[atom].ports.contains(&port), "{component}.{port}");
                        ends.push((atom, port));
                        self.take(",");
                    }
                    assert_eq!(self.ends[&kind], ends.len());
                    let atoms: HashSet<usize> = ends.iter().map(|(atom, _)| *atom).collect();
                    assert_eq!(atoms.len(), ends.len(), "an atom joins an interaction once");
                    self.connectors.push(ends);
                }
                other => panic!("{other}"),
            }
        }
    }

    fn value(&self, of: &Expr, state: &[i32]) -> i32 {
        match of {
            Expr::Number(number) => *number,
            Expr::Slot(slot) => {
                assert_ne!(state[*slot], UNSET);
                let factor = if self.clocks.contains_key(slot) { self.step } else { 1 };
                state[*slot] * factor
            }
            Expr::Binary(operator, left, right) => {
                let left = self.value(left, state);
                if (operator == "&&" && left == 0) || (operator == "||" && left == 1) {
                    return left;
                }
                let right = self.value(right, state);
                match &**operator {
                    "&&" | "||" => right,
                    "==" => i32::from(left == right),
                    "!=" => i32::from(left != right),
                    "<" => i32::from(left < right),
                    "<=" => i32::from(left <= right),
                    ">" => i32::from(left > right),
                    ">=" => i32::from(left >= right),
                    "+" => left + right,
                    _ => left - right,
                }
            }
        }
    }

    fn perform(&self, statements: &[Statement], state: &mut [i32]) {
        for statement in statements {
            match statement {
                Statement::Set(slot, value) => state[*slot] = self.value(value, state),
                Statement::If(condition, yes, no) => {
                    let holds = self.value(condition, state) == 1;
                    self.perform(if holds { yes } else { no }, state);
                }
            }
        }
    }

    /// Returns the transitions of each enabled interaction.
    fn enabled(&self, state: &[i32]) -> Vec<Vec<(usize, &Transition)>> {
        let find = |(atom, port): &(usize, String)| {
            let mut able = self.atoms[*atom].transitions.iter().filter(|transition| {
                transition.port == *port
                    && usize::try_from(state[*atom]) == Ok(transition.source)
                    && transition.guard.as_ref().is_none_or(|guard| self.value(guard, state) == 1)
            });
            let found = able.next()?;
            assert!(able.next().is_none(), "two transitions of {port}");
            Some((*atom, found))
        };
        self.connectors.iter().filter_map(|ends| ends.iter().map(find).collect()).collect()
    }

    fn is_allowed(&self, state: &[i32]) -> bool {
        let mut atoms = self.atoms.iter().zip(state);
        atoms.all(|(atom, &at)| {
            let mut here = atom.invariants.iter().filter(|(place, _)| *place == at as usize);
            here.all(|(_, condition)| self.value(condition, state) == 1)
        })
    }

    /// Returns the states after an interaction, or after a step of time.
    fn after(&self, state: &[i32]) -> Vec<Vec<i32>> {
        let enabled = self.enabled(state);
        let mut later = state.to_vec();
        for (&slot, most) in &self.clocks {
            later[slot] = (later[slot] + 1).min(most / self.step + 1);
        }
        let stays = |parts: &Vec<(usize, &Transition)>| match parts
            .iter()
            .map(|(_, transition)| transition.urgency)
            .max()
        {
            Some(Urgency::Eager) => false,
            Some(Urgency::Delayable) => parts.iter().all(|(_, transition)| {
                transition.guard.as_ref().is_none_or(|guard| self.value(guard, &later) == 1)
            }),
            _ => true,
        };
        let mut out = Vec::new();
        if enabled.iter().all(stays) {
            out.push(later.clone());
        } else {
            assert!(!self.is_allowed(&later), "an urgency says more than the invariants");
        }
        for parts in &enabled {
            let mut after = state.to_vec();
            for (atom, transition) in parts {
                after[*atom] = transition.target as i32;
                self.perform(&transition.statements, &mut after);
            }
            out.push(after);
        }
        out.retain(|state| self.is_allowed(state));
        out
    }

    /// Returns true if an atom reaches a place; `None` if there are too many states.
    fn reaches(&self, component: &str, place: &str) -> Option<bool> {
        let atom = self.components[component];
        let goal = self.atoms[atom].places.iter().position(|name| name == place).expect(place);
        let mut first = vec![UNSET; self.slots];
        for (number, atom) in self.atoms.iter().enumerate() {
            first[number] = atom.first as i32;
            self.perform(&atom.initial, &mut first);
        }
        let (mut seen, mut open) = (HashSet::from([first.clone()]), vec![first]);
        while let Some(state) = open.pop() {
            if state[atom] == goal as i32 {
                return Some(true);
            }
            for after in self.after(&state) {
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

/// Greatest common divisor.
fn divisor(a: i32, b: i32) -> i32 {
    if b == 0 { a } else { divisor(b, a % b) }
}

/// Returns the atom and the place that answer the check of a program, and whether the check holds then.
fn goal(text: &str) -> Option<(&str, &str, bool)> {
    let (line, is_wanted) = text.lines().find_map(|line| {
        let fails = line.strip_prefix("//   fails if ").map(|rest| (rest, false));
        fails.or_else(|| line.strip_prefix("//   holds if ").map(|rest| (rest, true)))
    })?;
    let names: Vec<&str> = line.split('`').collect();
    let [_, component, _, place, _] = names[..] else { panic!("{line}") };
    Some((component, place, is_wanted))
}

#[test]
fn random_systems_have_the_answers_of_the_verifier() {
    compare_random(14, Format::Bip, |text| {
        let (component, place, is_wanted) = goal(text)?;
        Some((Program::read(text).reaches(component, place)?, is_wanted))
    });
}

/// Programs of all patterns, and of the pump.
#[test]
fn each_check_has_a_place() {
    let pump = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/pump/pump.scn");
    let mut read = 0;
    for system in [crate::checks::system(), System::read(&pump)] {
        let prepared = system.prepared(&Options::default());
        for check in &prepared.checks {
            let mut alone = prepared.clone();
            alone.checks = vec![check.clone()];
            let Ok(files) = export(&alone, &|_, _| None, Format::Bip) else { continue };
            let program = Program::read(&files[0].text);
            let (component, place, _) = goal(&files[0].text).expect("a goal");
            let atom = &program.atoms[program.components[component]];
            let place = atom.places.iter().position(|name| name == place).expect("a place");
            assert!(atom.transitions.iter().any(|transition| transition.target == place));
            read += 1;
        }
    }
    assert!(read > 50, "{read}");
}
