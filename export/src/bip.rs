//! The language BIP 2 with the clocks of RT-BIP.
//!
//! Every process is an atom with its places and the clocks that no other process names. BIP has no shared
//! variables, so one more atom, the *store*, has all integers and the other clocks. Every interaction joins
//! the store: its transition has the guard and the updates of the edge, or of both edges of a channel.

mod plan;
mod scalars;

use std::fmt::Write as _;

use self::plan::{COMMITTED, Interaction, Machine, Plan, Transition};
use crate::File;
use crate::model::Network;
use crate::translate::{Refusal, UNIT_LINE};

/// Words of BIP. A package with such a name gets a `_`.
const RESERVED: &str = "as at atom bool clock component compound connector data define delayable do down \
    eager else end export extern false fi float from function if initial int internal invariant lazy on \
    operator package place places port priority provided refine string then to true type unit up use";

/// Notes on the translation, for the head comment.
const NOTES: &[&str] = &[
    "`store`: the variables; an interaction joins one process, or the two of a channel, and the store",
    "`committed`: number of processes that must act before all others",
    "`now`: time in a place where no time passes",
];

/// Prints a network, with a comment for each query.
///
/// # Errors
///
/// Everything that BIP cannot say.
pub(crate) fn print(network: &Network) -> Result<File, Vec<Refusal>> {
    let plan = Plan::new(network)?;
    let name = match &*network.name {
        name if RESERVED.split(' ').any(|word| word == name) => format!("{name}_"),
        name => name.to_owned(),
    };
    let mut out = String::new();
    for line in &network.header {
        let line = match line.strip_prefix(UNIT_LINE) {
            Some(_) => &format!("{UNIT_LINE}{}s", plan.unit),
            None => line,
        };
        let _ = writeln!(out, "// {line}");
    }
    for line in NOTES {
        let _ = writeln!(out, "// {line}");
    }
    queries(network, &mut out);
    let _ = writeln!(out, "\npackage {name}\n\nport type Event()\n");
    for (kind, parts) in [("Alone", "process"), ("Pair", "sender receiver")] {
        let ends: Vec<String> = parts.split(' ').map(|part| format!("Event {part}")).collect();
        let ends = ends.join(", ");
        let _ = writeln!(out, "connector type {kind}({ends}, Event store)");
        let _ = writeln!(out, "  define {parts} store\nend\n");
    }
    for machine in &plan.machines {
        print_process(&plan, machine, &mut out);
    }
    print_store(&plan, &mut out);
    print_system(&plan, &mut out);
    out.push_str("\nend\n");
    Ok(File { name: format!("{name}.bip"), text: out })
}

/// Prints the place that answers each query.
fn queries(network: &Network, out: &mut String) {
    for query in &network.queries {
        // The limit of a check of a time is a query with a place.
        let Some((process, location, is_wanted)) = query.goal() else { continue };
        let verb = if is_wanted { "holds" } else { "fails" };
        let _ = writeln!(out, "//\n// {}", query.name);
        let _ = writeln!(out, "//   {verb} if `{process}` reaches the place `{location}`");
    }
}

fn print_process(plan: &Plan, machine: &Machine, out: &mut String) {
    let process = machine.process;
    let _ = writeln!(out, "// {}\natom type {}()", process.comment, type_of(&process.name));
    for (clock, meaning) in &machine.clocks {
        let _ = writeln!(out, "  // {meaning}\n  clock {clock} unit {}", plan.unit);
    }
    ports(machine.ports.iter().map(String::as_str), out);
    let last = process.locations.len().saturating_sub(1);
    for (index, location) in process.locations.iter().enumerate() {
        let word = if index == 0 { "  place\n" } else { "" };
        let end = if index == last { "" } else { "," };
        let _ = writeln!(out, "{word}    // {}\n    {}{end}", location.comment, location.name);
    }
    let first = process.locations.first().map_or("", |location| &location.name);
    let resets: Vec<String> =
        machine.clocks.iter().map(|(name, _)| format!("{name} = 0;")).collect();
    initial(first, &resets, out);
    for transition in &machine.transitions {
        print_transition(transition, out);
    }
    for (place, clock, most) in &machine.invariants {
        let _ = writeln!(out, "  invariant at_{place} at {place} provided ({clock} <= {most})");
    }
    out.push_str("end\n\n");
}

fn print_store(plan: &Plan, out: &mut String) {
    out.push_str("// the variables and clocks that processes share\natom type Store()\n");
    let mut assignments = vec![format!("{COMMITTED} = {};", plan.committed)];
    let _ = writeln!(out, "  // number of processes in committed places\n  data int {COMMITTED}");
    for variable in &plan.network.variables {
        let names = scalars::names(variable);
        let _ = writeln!(out, "  // {}\n  data int {}", variable.comment, names.join(", "));
        assignments.extend(names.iter().map(|name| format!("{name} = 0;")));
    }
    for (clock, meaning) in &plan.clocks {
        let _ = writeln!(out, "  // {meaning}\n  clock {clock} unit {}", plan.unit);
        assignments.push(format!("{clock} = 0;"));
    }
    ports(plan.interactions.iter().map(|interaction| &*interaction.name), out);
    out.push_str("  place\n    // its only place\n    here\n");
    initial("here", &assignments, out);
    for Interaction { transition, .. } in &plan.interactions {
        print_transition(transition, out);
    }
    out.push_str("end\n\n");
}

fn ports<'n>(names: impl Iterator<Item = &'n str>, out: &mut String) {
    for name in names {
        let _ = writeln!(out, "  export port Event {name}()");
    }
}

fn initial(place: &str, assignments: &[String], out: &mut String) {
    let _ = write!(out, "\n  initial to {place}");
    statements(assignments, out);
    out.push('\n');
}

fn statements(list: &[String], out: &mut String) {
    match list {
        [] => {}
        [only] => {
            let _ = write!(out, "\n    do {{ {only} }}");
        }
        several => {
            let _ = write!(out, "\n    do {{\n      {}\n    }}", several.join("\n      "));
        }
    }
    out.push('\n');
}

fn print_transition(transition: &Transition, out: &mut String) {
    let Transition { port, source, target, conditions, urgency, updates, comment } = transition;
    let _ = write!(out, "  // {comment}\n  on {port} from {source} to {target}");
    if !conditions.is_empty() {
        let _ = write!(out, "\n    provided ({})", conditions.join("\n      && "));
    }
    let _ = write!(out, "\n    {urgency}");
    statements(updates, out);
}

fn print_system(plan: &Plan, out: &mut String) {
    out.push_str("// the system\ncompound type System()\n");
    for machine in &plan.machines {
        let name = &machine.process.name;
        let _ = writeln!(out, "  component {} {name}()", type_of(name));
    }
    out.push_str("  component Store store()\n\n");
    for Interaction { name, parts, .. } in &plan.interactions {
        let kind = if parts.len() == 1 { "Alone" } else { "Pair" };
        let ends: Vec<String> =
            parts.iter().map(|(process, port)| format!("{process}.{port}, ")).collect();
        let _ = writeln!(out, "  connector {kind} c_{name}({}store.{name})", ends.concat());
    }
    out.push_str("end\n");
}

/// Returns the name of the type of an atom.
fn type_of(process: &str) -> String {
    let mut letters = process.chars();
    letters.next().map_or(String::new(), |first| {
        format!("{}{}", first.to_ascii_uppercase(), letters.as_str())
    })
}
