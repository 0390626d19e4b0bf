//! The textual language of UPPAAL (`.xta`) with its queries (`.q`), and both as a drawing (`.xml`).

mod xml;

use std::fmt::Write as _;

use crate::File;
use crate::model::{
    Edge, Guard, Location, LocationKind, Network, Process, QueryKind, Sync, Term, Update,
};

/// Prints a network and its queries.
pub(crate) fn print(network: &Network) -> Vec<File> {
    vec![
        File { name: format!("{}.xta", network.name), text: model(network) },
        File { name: format!("{}.q", network.name), text: queries(network) },
        File { name: format!("{}.xml", network.name), text: xml::print(network) },
    ]
}

fn model(network: &Network) -> String {
    let mut out = declarations(network);
    for process in &network.processes {
        print_process(process, &mut out);
    }
    out.push_str(&system(network));
    out
}

/// Prints the head comment, integers, clocks and channels.
fn declarations(network: &Network) -> String {
    let mut out = String::new();
    for line in &network.header {
        let _ = writeln!(out, "// {line}");
    }
    out.push('\n');
    for variable in &network.variables {
        let size = variable.size.map_or(String::new(), |size| format!("[{size}]"));
        let _ = writeln!(out, "// {}", variable.comment);
        let _ = writeln!(out, "int[0,{}] {}{size};", variable.most, variable.name);
    }
    out.push('\n');
    for clock in &network.clocks {
        let _ = writeln!(out, "// {}\nclock {};", clock.comment, clock.name);
    }
    out.push('\n');
    for (channel, meaning) in &network.channels {
        let _ = writeln!(out, "// {meaning}\nchan {channel};");
    }
    out
}

fn system(network: &Network) -> String {
    let names: Vec<&str> = network.processes.iter().map(|process| process.name.as_str()).collect();
    format!("\nsystem\n    {};\n", names.join(",\n    "))
}

fn print_process(process: &Process, out: &mut String) {
    let _ = writeln!(out, "\n// {}\nprocess {}() {{\nstate", process.comment, process.name);
    let last = process.locations.len().saturating_sub(1);
    for (index, location) in process.locations.iter().enumerate() {
        let end = if index == last { ';' } else { ',' };
        print_location(location, end, out);
    }
    for (kind, word) in [(LocationKind::Committed, "commit"), (LocationKind::Urgent, "urgent")] {
        let of_kind = process.locations.iter().filter(|location| location.kind == kind);
        let names: Vec<&str> = of_kind.map(|location| location.name.as_str()).collect();
        if !names.is_empty() {
            let _ = writeln!(out, "{word}\n    {};", names.join(",\n    "));
        }
    }
    if let Some(first) = process.locations.first() {
        let _ = writeln!(out, "init\n    {};", first.name);
    }
    if !process.edges.is_empty() {
        out.push_str("trans\n");
    }
    let last = process.edges.len().saturating_sub(1);
    for (index, edge) in process.edges.iter().enumerate() {
        print_edge(edge, if index == last { ';' } else { ',' }, out);
    }
    out.push_str("}\n");
}

fn print_location(location: &Location, end: char, out: &mut String) {
    let invariant = invariant(location).map_or(String::new(), |text| format!(" {{ {text} }}"));
    let _ = writeln!(out, "    // {}\n    {}{invariant}{end}", location.comment, location.name);
}

fn invariant(location: &Location) -> Option<String> {
    location.invariant.as_ref().map(|(clock, most)| format!("{clock} <= {most}"))
}

fn print_edge(edge: &Edge, end: char, out: &mut String) {
    let _ = writeln!(out, "    // {}\n    {} -> {} {{", edge.comment, edge.source, edge.target);
    let parts = [
        ("guard", conditions(edge).join("\n            && ")),
        ("sync", synchronisation(edge)),
        ("assign", updates(edge).join(",\n            ")),
    ];
    for (word, text) in parts.iter().filter(|(_, text)| !text.is_empty()) {
        let _ = writeln!(out, "        {word} {text};");
    }
    let _ = writeln!(out, "    }}{end}");
}

/// Returns the conditions of an edge, all of which must hold.
fn conditions(edge: &Edge) -> Vec<String> {
    let mut out: Vec<String> = match &edge.guard {
        Guard::And(all) => all.iter().map(operand).collect(),
        other => vec![operand(other)],
    };
    for clock in &edge.clocks {
        out.push(format!("{} {} {}", clock.clock, clock.relation.text(), clock.value));
    }
    out
}

/// Returns the end of a channel; empty if the process acts alone.
fn synchronisation(edge: &Edge) -> String {
    match &edge.sync {
        Some(Sync::Send(channel)) => format!("{channel}!"),
        Some(Sync::Receive(channel)) => format!("{channel}?"),
        None => String::new(),
    }
}

fn updates(edge: &Edge) -> Vec<String> {
    edge.updates.iter().map(update).collect()
}

/// Prints a condition, in parentheses unless it is a comparison.
pub(crate) fn operand(of: &Guard) -> String {
    match of {
        Guard::Compare(left, relation, right) => {
            format!("{} {} {}", term(left), relation.text(), term(right))
        }
        Guard::And(_) | Guard::Or(_) => format!("({})", guard(of)),
    }
}

pub(crate) fn guard(of: &Guard) -> String {
    let join = |list: &[Guard], word: &str, none: &str| {
        let parts: Vec<String> = list.iter().map(operand).collect();
        if parts.is_empty() { none.to_owned() } else { parts.join(word) }
    };
    match of {
        Guard::Compare(..) => operand(of),
        Guard::And(all) => join(all, " && ", "true"),
        Guard::Or(some) => join(some, " || ", "false"),
    }
}

pub(crate) fn term(of: &Term) -> String {
    match of {
        Term::Number(number) => number.to_string(),
        Term::Variable(name) => name.clone(),
        Term::Element(array, index) => format!("{array}[{}]", term(index)),
        Term::Sum(left, number) if *number < 0 => format!("{} - {}", term(left), -number),
        Term::Sum(left, number) => format!("{} + {number}", term(left)),
        Term::If(condition, yes, no) => {
            format!("({} ? {} : {})", operand(condition), term(yes), term(no))
        }
    }
}

fn update(of: &Update) -> String {
    match of {
        Update::Set(target, value) => format!("{} = {}", term(target), term(value)),
        Update::Reset(clock) => format!("{clock} = 0"),
    }
}

fn queries(network: &Network) -> String {
    let mut out = format!("/*\n{}\n*/\n", network.header.join("\n"));
    for query in &network.queries {
        let _ = writeln!(out, "/*\n{}", query.name);
        for line in &query.comment {
            let _ = writeln!(out, "{line}");
        }
        out.push_str("*/\n");
        for formula in formulas(&query.kind) {
            let _ = writeln!(out, "{formula}");
        }
        out.push('\n');
    }
    out
}

/// Returns the formulas of a query.
fn formulas(kind: &QueryKind) -> Vec<String> {
    match kind {
        QueryKind::Never { process, location } => vec![format!("A[] not {process}.{location}")],
        QueryKind::Reachable { process, location } => vec![format!("E<> {process}.{location}")],
        QueryKind::Lively { process, location } => {
            vec![format!("A[] not (deadlock and {process}.{location})")]
        }
        QueryKind::Greatest(clocks) => {
            let greatest = clocks.iter();
            greatest
                .map(|(condition, clock)| format!("sup{{{}}}: {clock}", guard(condition)))
                .collect()
        }
    }
}
