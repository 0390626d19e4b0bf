//! Mutual exclusion of codels (section 6): by data of a component, and by ports.

use dotgen_analysis::model::mutex::{self, Excluded};
use dotgen_analysis::model::{
    self, CodelKind, CodelRef, Component, Owner, ParamSource, PortDir, PortId,
};
use dotgen_analysis::phrase::Phrase;
use typed_index_collections::{TiSlice, TiVec, ti_vec};

use super::indexed::{Built, not_a};
use super::settings::Settings;
use super::{Codel, CodelId};
use crate::diagnostic::Diagnostic;
use crate::scn::names::{Names, Target};
use crate::scn::semantics::{Exclusion, PortRule};

/// An output port: component and index.
type Port = (usize, PortId);

/// Fills in [`super::Codel::conflicts`].
pub(crate) fn exclude_codels(
    names: &Names,
    settings: &Settings,
    included: &[usize],
    out: &mut Built,
) {
    let live = live_codels(out);
    let semantics = settings.semantics();
    if semantics.fixed().exclusion == Exclusion::Data {
        for &c in included {
            exclude_data(names, c, &live, out);
        }
    } else {
        for &c in included {
            tickets(names, c, out);
        }
        if semantics.ports == PortRule::Copy {
            connections(names, settings, &mut out.diagnostics);
            return;
        }
    }
    let connections = connections(names, settings, &mut out.diagnostics);
    let mut users: Vec<(Port, CodelId)> = Vec::new();
    for (id, codel) in out.system.codels.iter_enumerated() {
        let Some((c, site)) = codel.site else {
            continue;
        };
        if !live[id] {
            continue;
        }
        for (_, port) in port_locks(names, &connections, (c, site)) {
            if !users.contains(&(port, id)) {
                users.push((port, id));
            }
        }
    }
    for &(port, one) in &users {
        for &(other_port, other) in &users {
            let fits = if semantics.fixed().exclusion == Exclusion::Data {
                !same_automaton(out, one, other)
            } else {
                out.system.codels[one].component != out.system.codels[other].component
            };
            if port == other_port && one < other && fits {
                out.system.exclude(one, other);
            }
        }
        // Two instances of an activity run at the same time only if a separate thread executes one of them.
        if out.system.platform.async_free {
            out.system.exclude(one, one);
        }
    }
}

/// Returns the ports that a codel names, each with the locks that its use takes.
fn port_locks(
    names: &Names,
    connections: &Connections,
    (c, codel): (usize, CodelRef),
) -> Vec<(Port, Port)> {
    let mut out = Vec::new();
    for param in &names.components[c].component.codel(codel).params {
        if let ParamSource::Port(p) = param.source {
            let locks = locks_of(names, connections, (c, p)).into_iter();
            out.extend(locks.map(|lock| ((c, p), lock)));
        }
    }
    out
}

/// The connections through which codels exclude each other.
pub struct SharedPorts<'n> {
    names: &'n Names<'n>,
    connections: Connections,
}

impl<'n> SharedPorts<'n> {
    /// Looks up the connections of a scenario.
    pub fn new(names: &'n Names<'n>, settings: &Settings) -> Self {
        SharedPorts { names, connections: connections(names, settings, &mut Vec::new()) }
    }

    /// Returns the connections that both codels (component, codel) use, as `sensor.scan → control.scan`: the
    /// output, then the inputs. An output that both codels name themselves has no inputs.
    pub fn of(&self, one: (usize, CodelRef), other: (usize, CodelRef)) -> Vec<String> {
        let path = |(c, p): Port| {
            let component = self.names.components[c].component;
            format!("{}.{}", component.name, component.ports[p].name)
        };
        let mut out = Vec::new();
        for (used, lock) in port_locks(self.names, &self.connections, one) {
            for (also, same) in port_locks(self.names, &self.connections, other) {
                let mut inputs = vec![used, also];
                inputs.retain(|input| *input != lock);
                inputs.dedup();
                if same == lock && !inputs.is_empty() {
                    let inputs: Vec<String> = inputs.into_iter().map(path).collect();
                    let text = format!("{} → {}", path(lock), inputs.join(" and "));
                    if !out.contains(&text) {
                        out.push(text);
                    }
                }
            }
        }
        out
    }
}

impl SharedPorts<'_> {
    /// Returns the data and ports that two codels of the system both use, in words.
    pub fn through(&self, one: &Codel, other: &Codel) -> Vec<Phrase> {
        let (Some((c, a)), Some((d, b))) = (one.site, other.site) else {
            return vec![Phrase::words("an attribute")];
        };
        let ports = self.of((c, a), (d, b)).into_iter();
        let mut words: Vec<Phrase> = ports.map(Phrase::words).collect();
        if c != d {
            return words;
        }
        let member = self.names.components[c];
        let component = member.component;
        let found = mutex::collisions(member.spec, component.codel(a), component.codel(b));
        for collision in found {
            let word = collision.shared.describe(component);
            if !words.contains(&word) {
                words.push(word);
            }
        }
        words
    }
}

/// Returns, by codel, whether it can run: as part of a machine with an automaton, or in the control task for
/// a requested service.
pub(super) fn live_codels(out: &Built) -> TiVec<CodelId, bool> {
    let mut live = ti_vec![false; out.system.codels.len()];
    for automaton in &out.system.automata {
        for state in &out.system.machines[automaton.machine].states {
            live[state.codel] = true;
        }
    }
    for client in &out.system.clients {
        for step in &client.steps {
            if let super::ClientAction::Send { service, .. } = step.action {
                let service = &out.system.services[service];
                for &codel in service.validate.iter().chain(&service.simple) {
                    live[codel] = true;
                }
            }
        }
    }
    live
}

/// Returns true if both codels belong to one permanent activity, which executes one codel at a time. (The
/// slots of one service do too, unless a separate thread executes some codels: ports deal with that.)
fn same_automaton(out: &Built, one: CodelId, other: CodelId) -> bool {
    let (Some((c, a)), Some((d, b))) = (out.system.codels[one].site, out.system.codels[other].site)
    else {
        return false;
    };
    c == d
        && a.owner == b.owner
        && (matches!(a.owner, Owner::Task(_)) || !out.system.platform.async_free)
}

fn exclude_data(names: &Names, c: usize, live: &TiSlice<CodelId, bool>, out: &mut Built) {
    let member = names.components[c];
    let component = member.component;
    let ids = |codel: CodelRef, out: &Built| -> Vec<CodelId> {
        let all = out.system.codels.iter_enumerated();
        let own = all.filter(|(id, entry)| entry.site == Some((c, codel)) && live[*id]);
        own.map(|(id, _)| id).collect()
    };
    for codel in component.all_codels() {
        let own = ids(codel, out);
        if own.is_empty() {
            continue;
        }
        for exclusion in mutex::exclusions(member.spec, component, codel) {
            let Excluded::Codel(other) = exclusion.with else {
                continue;
            };
            if exempt(component, codel, other) {
                continue;
            }
            for other in ids(other, out) {
                for &own in &own {
                    out.system.exclude(own, other);
                }
            }
        }
    }
    // An attribute: the control task accesses the data itself.
    for s in component.services.keys() {
        let Some(&service) = out.services.get(&(c, s)) else {
            continue;
        };
        let access = out.system.services[service].simple.last().copied();
        let Some(access) =
            access.filter(|&access| out.system.codels[access].site.is_none() && live[access])
        else {
            continue;
        };
        for other in mutex::service_exclusions(member.spec, component, s) {
            for other in ids(other, out) {
                out.system.exclude(access, other);
            }
        }
    }
}

/// Fills in the conflicts of each codel of a component in the servers. They come from the `mutex` lists of
/// the front end, which are not symmetric. A list applies to every use of its function by the same task.
fn tickets(names: &Names, c: usize, out: &mut Built) {
    let member = names.components[c];
    let component = member.component;
    let number = out.components[&c];
    let all = out.system.codels.iter_enumerated();
    let own = all.filter(|(_, codel)| codel.component == number);
    let own: Vec<CodelId> = own.map(|(id, _)| id).collect();
    // The thread that executes a codel (`None`: the control task), and its function.
    let function = |id: CodelId, out: &Built| {
        let (_, codel) = out.system.codels[id].site?;
        Some((component.task_of(codel), &component.codel(codel).name))
    };
    let copy_of = |s: model::ServiceId, out: &Built| -> Option<CodelId> {
        let service = &out.system.services[*out.services.get(&(c, s))?];
        let mut simple = service.simple.iter().copied();
        simple.find(|&codel| out.system.codels[codel].site.is_none())
    };
    for &id in &own {
        let Some((_, codel)) = out.system.codels[id].site else {
            continue;
        };
        for exclusion in mutex::exclusions(member.spec, component, codel) {
            let others: Vec<CodelId> = match exclusion.with {
                Excluded::Codel(other) => {
                    let what = Some((component.task_of(other), &component.codel(other).name));
                    let same = own.iter().copied();
                    same.filter(|&codel| function(codel, out) == what).collect()
                }
                Excluded::Service(s) => copy_of(s, out).into_iter().collect(),
            };
            let conflicts = &mut out.system.codels[id].conflicts;
            for codel in others {
                conflicts.insert(codel);
            }
        }
    }
    for s in component.services.keys() {
        let Some(copy) = copy_of(s, out) else {
            continue;
        };
        for other in mutex::service_exclusions(member.spec, component, s) {
            let what = Some((component.task_of(other), &component.codel(other).name));
            let same: Vec<CodelId> =
                (own.iter().copied()).filter(|&codel| function(codel, out) == what).collect();
            let conflicts = &mut out.system.codels[copy].conflicts;
            for codel in same {
                conflicts.insert(codel);
            }
        }
    }
}

/// Returns true for pairs that never exclude each other, although they share data: a codel of an activity and
/// one of an activity that interrupts it; two codels of one task; two codels of the control task.
fn exempt(component: &Component, one: CodelRef, other: CodelRef) -> bool {
    if component.task_of(one) == component.task_of(other) {
        return true;
    }
    let fsm = |codel: CodelRef| component.codel(codel).kind == CodelKind::Fsm;
    let interrupts = |a: model::ServiceId, b: model::ServiceId| {
        let list = &component.services[a].interrupts;
        list.all || list.services.contains(&b)
    };
    match (one.owner, other.owner) {
        (Owner::Service(a), Owner::Service(b)) if fsm(one) && fsm(other) => {
            interrupts(a, b) || interrupts(b, a)
        }
        _ => false,
    }
}

/// The connections of input ports in a scenario.
pub(super) type Connections = Vec<(Port, Option<Port>)>;

pub(super) fn connections(
    names: &Names,
    settings: &Settings,
    diagnostics: &mut Vec<Diagnostic>,
) -> Connections {
    let mut out = Vec::new();
    for (from, to) in &settings.connect {
        let port = |path, dir: PortDir| match names.resolve(path) {
            Ok(Target::Port(c, p)) => {
                let port = &names.components[c].component.ports[p];
                if port.dir == dir {
                    Ok((c, p))
                } else {
                    let word = if dir == PortDir::In { "an input" } else { "an output" };
                    let message = format!(
                        "`{}` is not {word} port; write `connect INPUT to OUTPUT;`",
                        path.text()
                    );
                    Err(Diagnostic::error("scn-port-direction", path.range(), message))
                }
            }
            Ok(_) => Err(not_a("port", path)),
            Err(error) => Err(error),
        };
        let input = port(from, PortDir::In);
        let output = to.as_ref().map(|to| port(to, PortDir::Out)).transpose();
        match (input, output) {
            (Ok(input), Ok(output)) => out.push((input, output)),
            (input, output) => {
                for error in input.err().into_iter().chain(output.err()) {
                    if !diagnostics.contains(&error) {
                        diagnostics.push(error);
                    }
                }
            }
        }
    }
    out
}

/// Returns the output ports that feed an input port: component (as in [`Names::components`]) and index. The
/// locks of an input port are those of these outputs.
pub fn sources(names: &Names, settings: &Settings, port: Port) -> Vec<Port> {
    let connections = connections(names, settings, &mut Vec::new());
    locks_of(names, &connections, port)
}

/// Returns the locks that the use of a port takes: an output port itself, or the outputs that feed an input
/// port, by the scenario or by equal name.
pub(super) fn locks_of(names: &Names, connections: &Connections, (c, p): Port) -> Vec<Port> {
    let port = &names.components[c].component.ports[p];
    if port.dir == PortDir::Out {
        return vec![(c, p)];
    }
    let mut stated = connections.iter().filter(|(input, _)| *input == (c, p)).peekable();
    if stated.peek().is_some() {
        return stated.filter_map(|(_, output)| *output).collect();
    }
    let mut found = Vec::new();
    for (d, member) in names.components.iter().enumerate() {
        for (q, other) in member.component.ports.iter_enumerated() {
            if d != c && other.dir == PortDir::Out && other.name == port.name {
                found.push((d, q));
            }
        }
    }
    // A simple port has a single source: the first.
    if !port.multiple {
        found.truncate(1);
    }
    found
}
