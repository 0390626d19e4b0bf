//! From the timed system to a network of timed automata, by the rules of the servers (section 21 of the timed
//! semantics) or of the published models ([`jobs`]).
//!
//! By the rules of the servers, there is one process for each task, timer, control task and client, and one
//! `scheduler`. An action of the verifier is one edge of a process, or a chain of edges through committed
//! locations. Its last edge sends `step` to the scheduler, which does what must follow at once: clients
//! proceed, tasks ask for a core, cores are granted, in this order. Then the scheduler is `busy`: no time
//! passes. It becomes `calm`, and time may pass, when no action remains that must happen first. Ends of
//! codels and ticks are bounded by invariants.

mod activities;
mod checks;
mod client;
mod control;
mod declare;
mod jobs;
mod layout;
mod monitors;
mod names;
mod predicates;
mod published;
mod refusals;
mod requests;
mod scheduler;
mod sequences;
mod task;
mod timer;
mod unique;

use dotgen_analysis::model::{Seconds, Src};
use dotgen_timing::system::unfolded;
use dotgen_timing::verify::Prepared;

use crate::model::Network;

pub use self::checks::check_name;
use self::layout::Layout;
pub use self::refusals::Refusal;
use self::unique::identifier;

/// Gives the place of a declaration, as `FILE:LINE`: the number of its component in
/// [`Names::components`](dotgen_timing::scn::names::Names::components), and the declaration.
pub type Place<'p> = dyn Fn(usize, Src) -> Option<String> + 'p;

/// Translates a system and its checks. Comments have the places of declarations.
///
/// # Errors
///
/// Everything that the network cannot contain.
pub fn translate(prepared: &Prepared, place: &Place) -> Result<Network, Vec<Refusal>> {
    let original = &prepared.built.system;
    let mut prepared = prepared.clone();
    for machine in &mut prepared.built.system.machines {
        if machine.loop_limit.is_some()
            && let Some(unfolded) = unfolded(machine)
        {
            *machine = unfolded;
        }
    }
    let prepared = &prepared;
    let refusals = refusals::of_system(prepared);
    if !refusals.is_empty() {
        return Err(refusals);
    }
    let layout = Layout::new(prepared, original, place);
    let mut network = Network {
        name: identifier(&prepared.report.scenario),
        header: header(prepared),
        nanoseconds: nanoseconds(prepared.built.system.unit),
        ..Network::default()
    };
    network.header.extend(layout.renamed.iter().cloned());
    if layout.jobs {
        published::declare(&layout, &mut network);
    }
    layout.declare(&mut network);
    let checks = checks::Checks::new(&layout, prepared)?;
    checks.declare(&mut network);
    if layout.jobs {
        jobs::add(&layout, &checks, &mut network);
    }
    for part in layout.parts.iter().filter(|_| !layout.jobs) {
        for task in &part.tasks {
            network.processes.extend(timer::process(&layout, task, &checks));
            network.processes.push(task::process(&layout, part, task, &checks));
        }
        if part.control {
            network.processes.push(control::process(&layout, part));
        }
    }
    for client in layout.system.clients.keys() {
        network.processes.push(client::process(&layout, client));
    }
    network.processes.push(scheduler::process(&layout, &checks));
    network.queries = checks.queries();
    network.drop_unmatched();
    match shared_name(&network) {
        Some(name) => Err(vec![Refusal::new("two parts with one name", Some(name.to_owned()))]),
        None => Ok(network),
    }
}

/// Returns a name that parts of different kinds have, as the process `control_task_a` of the component `a`
/// and the variable `control_task_a` of the component `task_a`.
fn shared_name(network: &Network) -> Option<&str> {
    let Network { variables, clocks, channels, processes, .. } = network;
    let mut all: Vec<&str> = (variables.iter().map(|variable| &*variable.name))
        .chain(clocks.iter().map(|clock| &*clock.name))
        .chain(channels.iter().map(|(channel, _)| &**channel))
        .chain(processes.iter().map(|process| &*process.name))
        .collect();
    all.sort_unstable();
    all.windows(2).find(|names| names[0] == names[1]).map(|names| names[0])
}

/// Returns a time in nanoseconds; `None` if it is not a whole number of them.
fn nanoseconds(time: Seconds) -> Option<i64> {
    let time = time * Seconds::from_integer(1_000_000_000);
    time.is_integer().then(|| i64::try_from(time.to_integer()).ok())?
}

/// First words of the line of the head comment that says the unit of all times.
pub(crate) const UNIT_LINE: &str = "all times are numbers of ";

fn header(prepared: &Prepared) -> Vec<String> {
    let system = &prepared.built.system;
    let base = layout::in_words(system.unit, 1);
    let cores = match system.platform.cores {
        None => "no limit on cores".to_owned(),
        Some(count) => format!("cores {count}, policy {:?}", system.platform.policy).to_lowercase(),
    };
    let assumptions = prepared.built.assumptions.iter();
    let durations = assumptions.filter(|assumption| assumption.starts_with("durations:")).cloned();
    let mut out = vec![
        format!("{}: formal model, written by dotgen export", prepared.report.scenario),
        format!("semantics {}; {cores}", prepared.report.semantics),
        format!("{UNIT_LINE}{base}"),
    ];
    out.extend(durations);
    out
}
