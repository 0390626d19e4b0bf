//! What the network cannot contain, by name.

use std::fmt;

use dotgen_timing::property::predicate::Atom;
use dotgen_timing::scn::semantics::{Cycle, LockRule, Semantics};
use dotgen_timing::system::{ClientAction, Policy};
use dotgen_timing::verify::Prepared;

use super::layout::Layout;

/// A construct that is not translated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// The construct, as scenarios and specifications write it.
    pub construct: String,
    /// Its place: a check ([`check_name`](super::check_name)), a client, a service or a state machine; `None`
    /// for the whole scenario.
    pub place: Option<String>,
}

impl Refusal {
    pub(crate) fn new(construct: &str, place: Option<String>) -> Refusal {
        Refusal { construct: construct.to_owned(), place }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "not exported: `{}`", self.construct)?;
        match &self.place {
            Some(place) => write!(f, " of {place}"),
            None => Ok(()),
        }
    }
}

/// Returns everything in a system that is not translated, except its checks.
pub(super) fn of_system(prepared: &Prepared) -> Vec<Refusal> {
    let system = &prepared.built.system;
    let mut out = Vec::new();
    if prepared.built.has_errors() || prepared.report.has_errors() {
        out.push(Refusal::new("a scenario with errors", None));
    }
    let (own, servers) = (system.platform.semantics, Semantics::SERVERS);
    let is_servers = Semantics { preset: servers.preset, ports: servers.ports, ..own } == servers;
    let is_published = own.fixed().cycle == Cycle::Jobs && own.locks == LockRule::Free;
    if !is_servers && !is_published {
        out.push(Refusal::new(&format!("semantics {}", own.text()), None));
    }
    let policy = system.platform.policy;
    let known = match policy {
        Policy::Fifo | Policy::Any => true,
        Policy::Edf => is_published,
        Policy::Priority | Policy::Fair => false,
    };
    if system.platform.cores.is_some() && !known {
        out.push(Refusal::new(&format!("policy {policy:?}").to_lowercase(), None));
    }
    for machine in system.machines.iter().filter(|_| system.platform.async_free) {
        if machine.states.iter().any(|state| state.is_async) {
            out.push(Refusal::new("async free", Some(machine.name.clone())));
        }
    }
    // Others are unfolded.
    let limited = system.machines.iter().filter(|machine| machine.loop_limit.is_some());
    out.extend(limited.map(|machine| Refusal::new("loop", Some(machine.name.clone()))));
    for client in &system.clients {
        let mut refuse = |construct: &str| {
            let refusal = Refusal::new(construct, Some(client.name.clone()));
            if !out.contains(&refusal) {
                out.push(refusal);
            }
        };
        if client.awaits_event.is_some() {
            refuse("measure");
        }
        for step in &client.steps {
            match &step.action {
                ClientAction::Send { service, .. } => {
                    if let Some(builtin) = system.services[*service].builtin {
                        refuse(builtin.name());
                    }
                }
                ClientAction::AwaitOutcome(..)
                | ClientAction::AwaitAny
                | ClientAction::AwaitAccepted
                | ClientAction::AwaitEnded(_)
                | ClientAction::Delay(..) => {}
            }
        }
    }
    out.extend(prepared.chains.iter().map(|chain| Refusal::new(chain, None)));
    out
}

/// Returns the refusal of an atom that has no variable in the network.
pub(super) fn of_atom(layout: &Layout, atom: &Atom, check: &str) -> Option<Refusal> {
    let system = layout.system;
    let construct = match atom {
        Atom::ControlBusy(component) if !layout.jobs && !layout.part(*component).notes_start() => {
            format!("control task of {}", system.components[*component].name)
        }
        Atom::Tick(task) => format!("{}.tick", system.task_path(*task)),
        Atom::Data { .. } => "comparison of data".to_owned(),
        _ => return None,
    };
    Some(Refusal::new(&construct, Some(check.to_owned())))
}
