//! The language Fiacre 3.0, as `frac` of TINA reads it, with the properties that `frac` adds.

mod clocks;
mod plan;

use std::collections::BTreeSet;
use std::fmt::Write as _;

use self::clocks::names;
use self::plan::{Machine, Plan, Port, Transition};
use crate::File;
use crate::model::{Guard, Location, LocationKind, Network, Relation, Term, Update, Variable};
use crate::translate::Refusal;

/// Words of Fiacre and of its properties. A location with such a name gets a `_`.
const RESERVED: &[&str] = &[
    "absent",
    "after",
    "always",
    "and",
    "any",
    "append",
    "array",
    "assert",
    "before",
    "between",
    "bool",
    "case",
    "channel",
    "component",
    "const",
    "deadlockfree",
    "dequeue",
    "do",
    "else",
    "elsif",
    "empty",
    "end",
    "enqueue",
    "enter",
    "event",
    "extern",
    "false",
    "first",
    "foreach",
    "from",
    "full",
    "function",
    "if",
    "in",
    "init",
    "int",
    "is",
    "leadsto",
    "leave",
    "loop",
    "ltl",
    "nat",
    "none",
    "not",
    "null",
    "of",
    "on",
    "or",
    "out",
    "par",
    "port",
    "present",
    "priority",
    "process",
    "property",
    "queue",
    "read",
    "record",
    "return",
    "select",
    "state",
    "states",
    "sync",
    "tag",
    "then",
    "to",
    "true",
    "type",
    "union",
    "unless",
    "until",
    "value",
    "var",
    "wait",
    "where",
    "while",
    "within",
    "write",
];

/// Notes on the translation, for the head comment.
const NOTES: &[&str] = &[
    "a port `now_…`, `…_now`, `…_then` or `…_both` leaves a committed location: it comes before all others",
    "a port `wait_PROCESS_A_B` is taken A to B units of time after its state is entered",
    "`wait [0,0]; loop`: time does not pass in the state",
];

/// Prints a network with a property for each query.
///
/// # Errors
///
/// Everything that Fiacre cannot say.
pub(crate) fn print(network: &Network) -> Result<File, Vec<Refusal>> {
    let plan = Plan::new(network)?;
    let mut out = String::new();
    for line in network.header.iter().map(|line| &**line).chain(NOTES.iter().copied()) {
        let _ = writeln!(out, "// {line}");
    }
    out.push('\n');
    types(&plan, &mut out);
    for machine in &plan.machines {
        print_machine(machine, &plan, &mut out);
    }
    component(network, &plan, &mut out);
    properties(network, &plan, &mut out);
    Ok(File { name: format!("{}.fcr", network.name), text: out })
}

/// Returns the greatest number of a program, in variables or as an index.
fn greatest(plan: &Plan) -> i64 {
    let size = |variable: &Variable| variable.size.map_or(0, |size| size as i64 - 1);
    plan.variables.iter().map(|variable| variable.most.max(size(variable))).max().unwrap_or(1)
}

/// Prints the types. Fiacre converts no number to a smaller type, so all numbers have one type, which is also
/// the type of the indices of all arrays.
fn types(plan: &Plan, out: &mut String) {
    let most = greatest(plan);
    let _ = writeln!(out, "type number is 0..{most}\ntype numbers is array {} of number", most + 1);
}

fn type_of(variable: &Variable) -> &'static str {
    if variable.size.is_some() { "numbers" } else { "number" }
}

/// Returns the ports of a process, and the variables that it names.
fn interface<'p>(machine: &'p Machine, plan: &'p Plan) -> (BTreeSet<&'p str>, Vec<&'p Variable>) {
    let ports = machine.transitions.iter().map(|transition| &*transition.port).collect();
    let used = |variable: &&Variable| {
        machine.transitions.iter().any(|transition| names(&transition.edge, &variable.name))
    };
    (ports, plan.variables.iter().filter(used).collect())
}

fn print_machine(machine: &Machine, plan: &Plan, out: &mut String) {
    let (ports, variables) = interface(machine, plan);
    let ports: Vec<String> = ports.iter().map(|port| format!("{port} : sync")).collect();
    let _ = write!(out, "\n// {}\nprocess {}", machine.comment, machine.name);
    if !ports.is_empty() {
        let _ = write!(out, " [\n    {}\n]", ports.join(",\n    "));
    }
    if !variables.is_empty() {
        let arguments: Vec<String> = (variables.iter())
            .map(|variable| format!("&{} : {}", variable.name, type_of(variable)))
            .collect();
        let _ = write!(out, " (\n    {}\n)", arguments.join(",\n    "));
    }
    out.push_str(" is\nstates\n");
    let last = machine.locations.len().saturating_sub(1);
    for (index, location) in machine.locations.iter().enumerate() {
        let end = if index == last { "" } else { "," };
        let _ = writeln!(out, "    // {}\n    {}{end}", location.comment, state(&location.name));
    }
    if let Some(first) = machine.locations.first() {
        let _ = writeln!(out, "init\n    to {}", state(&first.name));
    }
    for location in &machine.locations {
        print_location(location, machine, out);
    }
}

fn print_location(location: &Location, machine: &Machine, out: &mut String) {
    let own =
        machine.transitions.iter().filter(|transition| transition.edge.source == location.name);
    let mut alternatives: Vec<String> = own.map(alternative).collect();
    if location.kind == LocationKind::Urgent {
        alternatives.push("        wait [0,0]; loop\n".to_owned());
    }
    if alternatives.is_empty() {
        return;
    }
    let _ = writeln!(out, "from {}", state(&location.name));
    match &alternatives[..] {
        [only] => out.push_str(only),
        several => {
            let _ = write!(out, "    select\n{}    end\n", several.join("    []\n"));
        }
    }
}

fn alternative(transition: &Transition) -> String {
    let Transition { edge, port } = transition;
    let mut out = format!("        // {}\n", edge.comment);
    if !edge.guard.is_true() {
        let _ = writeln!(out, "        on {};", guard(&edge.guard));
    }
    let _ = writeln!(out, "        {port};");
    for of in &edge.updates {
        let _ = writeln!(out, "        {};", update(of));
    }
    let _ = writeln!(out, "        to {}", state(&edge.target));
    out
}

fn component(network: &Network, plan: &Plan, out: &mut String) {
    let name = &network.name;
    let _ = writeln!(out, "\n// the system\ncomponent main_{name} is");
    let last = plan.variables.len().saturating_sub(1);
    for (index, variable) in plan.variables.iter().enumerate() {
        let word = if index == 0 { "var\n" } else { "" };
        let end = if index == last { "" } else { "," };
        let value = match variable.size {
            None => "0".to_owned(),
            Some(_) => format!("[{}]", vec!["0"; greatest(plan) as usize + 1].join(", ")),
        };
        let _ = writeln!(
            out,
            "{word}    // {}\n    {} : {} := {value}{end}",
            variable.comment,
            variable.name,
            type_of(variable)
        );
    }
    let ports: Vec<String> = (plan.ports.iter())
        .map(|(name, port)| format!("    {name} : sync in {}", interval(port)))
        .collect();
    let _ = writeln!(out, "port\n{}", ports.join(",\n"));
    let mut priorities = Vec::new();
    for (name, port) in &plan.ports {
        let later = plan.ports.iter().filter(|(_, other)| port.class < other.class);
        let pairs: Vec<String> = later.map(|(other, _)| format!("{name} > {other}")).collect();
        if !pairs.is_empty() {
            priorities.push(format!("    {}", pairs.join(", ")));
        }
    }
    if !priorities.is_empty() {
        let _ = writeln!(out, "priority\n{}", priorities.join(",\n"));
    }
    let instances: Vec<String> = (plan.machines.iter())
        .map(|machine| {
            let (ports, variables) = interface(machine, plan);
            let mut text = machine.name.clone();
            if !ports.is_empty() {
                let ports: Vec<&str> = ports.into_iter().collect();
                let _ = write!(text, " [{}]", ports.join(", "));
            }
            if !variables.is_empty() {
                let arguments = variables.iter().map(|variable| format!("&{}", variable.name));
                let _ = write!(text, " ({})", arguments.collect::<Vec<_>>().join(", "));
            }
            text
        })
        .collect();
    let _ = writeln!(out, "par * in\n    {}\nend\n\nmain_{name}", instances.join("\n||  "));
}

fn interval(port: &Port) -> String {
    let open = if port.is_open { ']' } else { '[' };
    let lower = port.time.0;
    port.time.1.map_or(format!("{open}{lower},...["), |upper| format!("{open}{lower},{upper}]"))
}

fn properties(network: &Network, plan: &Plan, out: &mut String) {
    for query in &network.queries {
        // The limit of a check of a time is a property.
        let Some((process, location, is_wanted)) = query.goal() else { continue };
        let meaning = if is_wanted {
            "the check holds if false: a run reaches the state"
        } else {
            "the check holds if true"
        };
        let number = 1 + plan.machines.iter().take_while(|machine| machine.name != process).count();
        let state = state(location);
        let _ = writeln!(out, "\n// {}: {meaning}", query.name);
        let path = format!("main_{}/{number}/state {state}", network.name);
        let _ = writeln!(out, "property {location} is ltl [] not ({path})\nassert {location}");
    }
}

fn state(name: &str) -> String {
    if RESERVED.contains(&name) { format!("{name}_") } else { name.to_owned() }
}

fn guard(of: &Guard) -> String {
    let join = |list: &[Guard], word: &str, none: &str| {
        let parts: Vec<String> = list.iter().map(guard).collect();
        if parts.is_empty() { none.to_owned() } else { format!("({})", parts.join(word)) }
    };
    match of {
        Guard::Compare(left, relation, right) => {
            let (left, right) = (term(left), term(right));
            match relation {
                Relation::Equal => format!("({left} = {right})"),
                Relation::NotEqual => format!("not ({left} = {right})"),
                Relation::Less | Relation::AtLeast | Relation::Greater => {
                    format!("({left} {} {right})", relation.text())
                }
            }
        }
        Guard::And(all) => join(all, " and ", "true"),
        Guard::Or(some) => join(some, " or ", "false"),
    }
}

fn term(of: &Term) -> String {
    match of {
        Term::Number(number) => number.to_string(),
        Term::Variable(name) => name.clone(),
        Term::Element(array, index) => format!("{array}[{}]", term(index)),
        Term::Sum(left, number) if *number < 0 => format!("({} - {})", term(left), -number),
        Term::Sum(left, number) => format!("({} + {number})", term(left)),
        Term::If(condition, yes, no) => {
            format!("({} ? {} : {})", guard(condition), term(yes), term(no))
        }
    }
}

fn update(of: &Update) -> String {
    match of {
        Update::Set(target, Term::If(condition, yes, no)) => {
            let (condition, target_text) = (guard(condition), term(target));
            let keeps = **no == *target;
            let other =
                if keeps { String::new() } else { format!(" else {target_text} := {}", term(no)) };
            format!("if {condition} then {target_text} := {}{other} end", term(yes))
        }
        Update::Set(target, value) => format!("{} := {}", term(target), term(value)),
        // Clocks are intervals, or processes with variables.
        Update::Reset(_) => "null".to_owned(),
    }
}
