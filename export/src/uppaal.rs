//! The textual language of UPPAAL (`.xta`), and its queries (`.q`).

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
    ]
}

fn model(network: &Network) -> String {
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
    for process in &network.processes {
        print_process(process, &mut out);
    }
    let names: Vec<&str> = network.processes.iter().map(|process| process.name.as_str()).collect();
    let _ = writeln!(out, "\nsystem\n    {};", names.join(",\n    "));
    out
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
    let invariant = match &location.invariant {
        Some((clock, most)) => format!(" {{ {clock} <= {most} }}"),
        None => String::new(),
    };
    let _ = writeln!(out, "    // {}\n    {}{invariant}{end}", location.comment, location.name);
}

fn print_edge(edge: &Edge, end: char, out: &mut String) {
    let _ = writeln!(out, "    // {}\n    {} -> {} {{", edge.comment, edge.source, edge.target);
    let mut conditions: Vec<String> = Vec::new();
    match &edge.guard {
        Guard::And(all) => conditions.extend(all.iter().map(operand)),
        other => conditions.push(operand(other)),
    }
    for clock in &edge.clocks {
        conditions.push(format!("{} {} {}", clock.clock, clock.relation.text(), clock.value));
    }
    if !conditions.is_empty() {
        let _ = writeln!(out, "        guard {};", conditions.join("\n            && "));
    }
    match &edge.sync {
        Some(Sync::Send(channel)) => out.push_str(&format!("        sync {channel}!;\n")),
        Some(Sync::Receive(channel)) => out.push_str(&format!("        sync {channel}?;\n")),
        None => {}
    }
    if !edge.updates.is_empty() {
        let updates: Vec<String> = edge.updates.iter().map(update).collect();
        let _ = writeln!(out, "        assign {};", updates.join(",\n            "));
    }
    let _ = writeln!(out, "    }}{end}");
}

/// Prints a condition, in parentheses unless it is a comparison.
fn operand(of: &Guard) -> String {
    match of {
        Guard::Compare(left, relation, right) => {
            format!("{} {} {}", term(left), relation.text(), term(right))
        }
        Guard::And(_) | Guard::Or(_) => format!("({})", guard(of)),
    }
}

fn guard(of: &Guard) -> String {
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

fn term(of: &Term) -> String {
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
        match &query.kind {
            QueryKind::Never { process, location } => {
                let _ = writeln!(out, "A[] not {process}.{location}");
            }
            QueryKind::Reachable { process, location } => {
                let _ = writeln!(out, "E<> {process}.{location}");
            }
            QueryKind::Lively { process, location } => {
                let _ = writeln!(out, "A[] not (deadlock and {process}.{location})");
            }
            QueryKind::Greatest(clocks) => {
                for (condition, clock) in clocks {
                    let _ = writeln!(out, "sup{{{}}}: {clock}", guard(condition));
                }
            }
        }
        out.push('\n');
    }
    out
}
