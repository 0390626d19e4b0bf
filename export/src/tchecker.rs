//! The language of TChecker (`doc/file-format.md` of TChecker 0.8).

use std::fmt::Write as _;

use crate::File;
use crate::model::{
    Edge, Guard, Location, LocationKind, Network, Process, Relation, Sync, Term, Update,
};

/// Event of edges without synchronisation.
pub(crate) const ALONE: &str = "alone";

/// Prints a network with a label for each query.
pub(crate) fn print(network: &Network) -> File {
    let mut out = String::new();
    for line in &network.header {
        comment(&mut out, line);
    }
    queries(network, &mut out);
    let _ = writeln!(out, "\nsystem:{}\n", network.name);
    let _ = writeln!(out, "event:{ALONE}");
    for (channel, meaning) in &network.channels {
        comment(&mut out, meaning);
        let _ = writeln!(out, "event:{channel}");
    }
    out.push('\n');
    for variable in &network.variables {
        comment(&mut out, &variable.comment);
        let size = variable.size.unwrap_or(1);
        let _ = writeln!(out, "int:{size}:0:{}:0:{}", variable.most, variable.name);
    }
    out.push('\n');
    for clock in &network.clocks {
        comment(&mut out, &clock.comment);
        let _ = writeln!(out, "clock:1:{}", clock.name);
    }
    for process in &network.processes {
        print_process(process, &mut out);
    }
    out.push('\n');
    synchronisations(network, &mut out);
    File { name: format!("{}.tck", network.name), text: out }
}

fn comment(out: &mut String, text: &str) {
    let _ = writeln!(out, "# {text}");
}

fn queries(network: &Network, out: &mut String) {
    for query in &network.queries {
        // The limit of a check of a time is a query, and a check of deadlocks is refused.
        let Some((_, location, _)) = query.goal() else { continue };
        comment(out, "");
        comment(out, &format!("{}: tck-reach -l {location}", query.name));
        for line in &query.comment {
            comment(out, &format!("  {line}"));
        }
    }
}

fn print_process(process: &Process, out: &mut String) {
    out.push('\n');
    comment(out, &process.comment);
    let _ = writeln!(out, "process:{}", process.name);
    for (index, location) in process.locations.iter().enumerate() {
        print_location(process, location, index == 0, out);
    }
    for edge in &process.edges {
        print_edge(process, edge, out);
    }
}

fn print_location(process: &Process, location: &Location, is_first: bool, out: &mut String) {
    let mut attributes = Vec::new();
    if is_first {
        attributes.push("initial:".to_owned());
    }
    match location.kind {
        LocationKind::Normal => {}
        LocationKind::Urgent => attributes.push("urgent:".to_owned()),
        LocationKind::Committed => attributes.push("committed:".to_owned()),
    }
    if let Some((clock, most)) = &location.invariant {
        attributes.push(format!("invariant:{clock} <= {most}"));
    }
    if location.is_goal {
        attributes.push(format!("labels:{}", location.name));
    }
    comment(out, &location.comment);
    let attributes = attributes.join(":");
    let _ = writeln!(out, "location:{}:{}{{{attributes}}}", process.name, location.name);
}

fn print_edge(process: &Process, edge: &Edge, out: &mut String) {
    let event = match &edge.sync {
        Some(Sync::Send(channel) | Sync::Receive(channel)) => channel,
        None => ALONE,
    };
    let mut provided: Vec<String> = Vec::new();
    match &edge.guard {
        Guard::And(all) => provided.extend(all.iter().map(guard)),
        other => provided.push(guard(other)),
    }
    for clock in &edge.clocks {
        provided.push(format!("{} {} {}", clock.clock, clock.relation.text(), clock.value));
    }
    let mut attributes = Vec::new();
    if !provided.is_empty() {
        attributes.push(format!("provided:{}", provided.join(" && ")));
    }
    if !edge.updates.is_empty() {
        let updates: Vec<String> = edge.updates.iter().map(update).collect();
        attributes.push(format!("do:{}", updates.join("; ")));
    }
    comment(out, &edge.comment);
    let (name, attributes) = (&process.name, attributes.join(" : "));
    let _ = writeln!(out, "edge:{name}:{}:{}:{event}{{{attributes}}}", edge.source, edge.target);
}

/// Prints a condition as a conjunct: TChecker has no disjunction but that of an `if`.
fn guard(of: &Guard) -> String {
    match of {
        Guard::Compare(left, relation, right) => compare(left, *relation, right),
        Guard::And(_) | Guard::Or(_) => format!("{} == 1", truth(of)),
    }
}

fn compare(left: &Term, relation: Relation, right: &Term) -> String {
    format!("{} {} {}", term(left), relation.text(), term(right))
}

/// Prints the number 1 if a condition holds, else 0.
fn truth(of: &Guard) -> String {
    match of {
        Guard::Compare(left, relation, right) => {
            format!("(if {} then 1 else 0)", compare(left, *relation, right))
        }
        Guard::And(all) if all.is_empty() => "1".to_owned(),
        Guard::And(_) => format!("(if {} then 1 else 0)", conjunction(of)),
        Guard::Or(some) => some.iter().rev().fold("0".to_owned(), |rest, one| {
            format!("(if {} then 1 else {rest})", conjunction(one))
        }),
    }
}

fn conjunction(of: &Guard) -> String {
    match of {
        Guard::And(all) if !all.is_empty() => {
            let parts: Vec<String> = all.iter().map(guard).collect();
            parts.join(" && ")
        }
        other => guard(other),
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
            format!("(if {} then {} else {})", conjunction(condition), term(yes), term(no))
        }
    }
}

fn update(of: &Update) -> String {
    match of {
        Update::Set(target, value) => format!("{} = {}", term(target), term(value)),
        Update::Reset(clock) => format!("{clock} = 0"),
    }
}

/// Pairs the senders of each channel with its receivers.
fn synchronisations(network: &Network, out: &mut String) {
    for (channel, _) in &network.channels {
        let with = |wanted: &Sync| -> Vec<&str> {
            let has = |process: &&Process| {
                process.edges.iter().any(|edge| edge.sync.as_ref() == Some(wanted))
            };
            network.processes.iter().filter(has).map(|process| process.name.as_str()).collect()
        };
        let receivers = with(&Sync::Receive(channel.clone()));
        for sender in with(&Sync::Send(channel.clone())) {
            for receiver in receivers.iter().filter(|&&receiver| receiver != sender) {
                let _ = writeln!(out, "sync:{sender}@{channel}:{receiver}@{channel}");
            }
        }
    }
}
