//! The flow of data from codel to codel: through ports, data of a component, and variables of a service
//! (section 19).
//!
//! A path into a value is a place of its own if some codel names it. An access to a value is an access to all
//! of its named parts. All outputs of a codel may depend on all of its inputs.

use std::collections::{BTreeMap, BTreeSet};

use dotgen_analysis::model::{
    CodelKind, Owner, Param, ParamDir, ParamSource, PathElement, PortDir, PortId, ServiceId,
};
use typed_index_collections::{TiSlice, TiVec};

use super::chain::{Chain, ChainKind, DataPlace};
use super::indexed::{Built, not_a};
use super::locks::{Connections, connections, live_codels, locks_of};
use super::settings::Settings;
use crate::diagnostic::Diagnostic;
use crate::scn::ast::Path;
use crate::scn::names::{Names, Target};
use crate::system::CodelId;

/// Number of paths of the data that are listed. Further paths are only mentioned.
const MAX_LISTED_PATHS: usize = 6;

/// Upper limit on the partial paths that the search extends.
const STEPS: usize = 20_000;

/// A chain, and the codels on it.
pub(crate) struct FoundChain {
    pub(crate) chain: Chain,
    /// Components on the chain, numbered as in [`Names`].
    pub(crate) components: Vec<usize>,
    /// Paths of the data: each lists the codels that carry the data, in order.
    pub(crate) ways: Vec<Vec<CodelId>>,
    /// There are further paths.
    pub(crate) more: bool,
}

/// The variable or port from which the paths of a place start.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Root {
    Port(usize, PortId),
    Ids(usize),
    /// A variable of a service: component, service, number.
    Variable(usize, ServiceId, u32),
}

type Key = (Root, Vec<String>);

/// A question: from a port to a port, through these codels and ports.
pub(crate) struct ChainQuery<'a> {
    pub(crate) kind: ChainKind,
    pub(crate) from: &'a Path,
    pub(crate) to: &'a Path,
    pub(crate) via: &'a [Path],
}

/// Finds the chain between two ports.
pub(crate) fn chain(
    names: &Names,
    settings: &Settings,
    built: &Built,
    asked: &ChainQuery,
) -> Result<FoundChain, Diagnostic> {
    let connections = connections(names, settings, &mut Vec::new());
    let flow = Flow { names, built, connections };
    let first = flow.source(asked.from)?;
    let last = flow.source(asked.to)?;
    if flow.is_input(&last) {
        let message = format!(
            "`{}` is an input that nothing in the system writes; name the output at which the chain ends",
            asked.to.text()
        );
        return Err(Diagnostic::error("scn-chain-end", asked.to.range(), message));
    }
    let external = flow.is_input(&first);
    let mut uses = flow.uses();
    flow.restrict(asked.via, &mut uses)?;
    let ends = (flow.key(&first), flow.key(&last));
    let relevant = relevant(&uses, &ends);
    if !relevant.contains(&ends.1) || !relevant.contains(&ends.0) {
        return Err(no_path_diagnostic(asked));
    }
    for usage in &mut uses {
        usage.reads.retain(|key| relevant.contains(key));
        usage.writes.retain(|key| relevant.contains(key));
    }
    let (ways, more) = ways(&uses, &ends);
    let mut shared: BTreeMap<&Key, usize> = BTreeMap::new();
    let mut local: BTreeMap<(usize, ServiceId), Vec<&Key>> = BTreeMap::new();
    for key in &relevant {
        if let Root::Variable(c, s, _) = &key.0 {
            local.entry((*c, *s)).or_default().push(key);
        } else {
            let number = shared.len();
            shared.insert(key, number);
        }
    }
    let place = |key: &Key| match &key.0 {
        Root::Variable(c, s, _) => {
            let list = local.get(&(*c, *s))?;
            Some(DataPlace::Local(list.iter().position(|local| *local == key)?))
        }
        _ => shared.get(key).map(|&number| DataPlace::Shared(number)),
    };
    let places = |list: &BTreeSet<Key>| list.iter().filter_map(place).collect();
    let number = |key: &Key| shared.get(key).copied().unwrap_or(0);
    let chain = Chain {
        kind: asked.kind,
        shared: shared.len(),
        locals: local.values().map(Vec::len).max().unwrap_or(0),
        reads: uses.iter().map(|usage| places(&usage.reads)).collect(),
        writes: uses.iter().map(|usage| places(&usage.writes)).collect(),
        carries: uses.iter().map(|usage| usage.carries).collect(),
        first: number(&ends.0),
        last: number(&ends.1),
        external,
    };
    let on_way =
        |accesses: &&DataAccesses| !accesses.writes.is_empty() || !accesses.reads.is_empty();
    let mut components: Vec<usize> =
        uses.iter().filter(on_way).map(|usage| usage.component).collect();
    components.extend([first.0, last.0]);
    components.sort_unstable();
    components.dedup();
    Ok(FoundChain { chain, components, ways, more })
}

fn no_path_diagnostic(asked: &ChainQuery) -> Diagnostic {
    let (from, to) = (asked.from.text(), asked.to.text());
    let via = if asked.via.is_empty() { "" } else { " by these codels" };
    let message = format!(
        "no data go from `{from}` to `{to}`{via}: no codel that is executed reads what depends on the one and writes the \
         other; request the activities that do, `connect` the ports between, or name other ports"
    );
    Diagnostic::error("scn-no-way", asked.from.range().start..asked.to.range().end, message)
}

/// The data accesses of a codel.
#[derive(Debug, Default)]
struct DataAccesses {
    component: usize,
    reads: BTreeSet<Key>,
    writes: BTreeSet<Key>,
    carries: bool,
}

struct Flow<'a> {
    names: &'a Names<'a>,
    built: &'a Built,
    connections: Connections,
}

impl Flow<'_> {
    /// Returns the port that holds the data of a named port: the port itself, or the output that feeds it.
    fn source(&self, path: &Path) -> Result<(usize, PortId), Diagnostic> {
        let Target::Port(c, p) = self.names.resolve(path)? else {
            return Err(not_a("port", path));
        };
        match &locks_of(self.names, &self.connections, (c, p))[..] {
            [] => Ok((c, p)),
            [one] => Ok(*one),
            several => {
                let several = several.iter().map(|&output| format!("`{}`", self.port(output)));
                let message = format!(
                    "`{}` is connected to several outputs; name one of them: {}",
                    path.text(),
                    several.collect::<Vec<_>>().join(", ")
                );
                Err(Diagnostic::error("scn-chain-end", path.range(), message))
            }
        }
    }

    fn port(&self, (c, p): (usize, PortId)) -> String {
        let component = self.names.components[c].component;
        format!("{}.{}", component.name, component.ports[p].name)
    }

    fn is_input(&self, &(c, p): &(usize, PortId)) -> bool {
        self.names.components[c].component.ports[p].dir == PortDir::In
    }

    fn key(&self, &(c, p): &(usize, PortId)) -> Key {
        (Root::Port(c, p), Vec::new())
    }

    /// Returns the places that each codel reads and writes: every named part of its parameters.
    fn uses(&self) -> TiVec<CodelId, DataAccesses> {
        let live = live_codels(self.built);
        let named = |id: CodelId| -> Vec<(ParamDir, Key)> {
            if !live[id] {
                return Vec::new();
            }
            self.named(id)
        };
        let all: TiVec<CodelId, Vec<(ParamDir, Key)>> = live.keys().map(named).collect();
        let mut keys: BTreeSet<&Key> = all.iter().flatten().map(|(_, key)| key).collect();
        // A chain begins and ends with all of the data of a port.
        let whole: Vec<Key> = (keys.iter())
            .filter(|key| matches!(key.0, Root::Port(..)))
            .map(|key| (key.0.clone(), Vec::new()))
            .collect();
        keys.extend(&whole);
        let parts = |of: &Key| {
            let inside = |key: &&&Key| key.0 == of.0 && key.1.starts_with(&of.1);
            keys.iter().filter(inside).map(|key| (*key).clone()).collect::<Vec<Key>>()
        };
        let of_codel = |(id, list): (CodelId, &Vec<(ParamDir, Key)>)| {
            let mut out = DataAccesses {
                component: self.component_of(id),
                carries: true,
                ..DataAccesses::default()
            };
            for (dir, key) in list {
                // Writing a part of a port writes the port.
                let all = match &key.0 {
                    Root::Port(..) => parts(&(key.0.clone(), Vec::new())),
                    _ => parts(key),
                };
                if matches!(dir, ParamDir::In | ParamDir::Inout) {
                    out.reads.extend(all.iter().cloned());
                }
                if matches!(dir, ParamDir::Out | ParamDir::Inout) {
                    out.writes.extend(all);
                }
            }
            out
        };
        all.iter_enumerated().map(of_codel).collect()
    }

    fn component_of(&self, id: CodelId) -> usize {
        let number = self.built.system.codels[id].component;
        let mut all = self.built.components.iter();
        all.find(|component| *component.1 == number).map_or(0, |component| *component.0)
    }

    /// Returns the places that a codel names. An attribute without a codel copies the values of a request,
    /// which its validation may have changed.
    fn named(&self, id: CodelId) -> Vec<(ParamDir, Key)> {
        let c = self.component_of(id);
        let component = self.names.components[c].component;
        let path = |param: &Param| -> Vec<String> {
            let element = |element: &PathElement| match element {
                PathElement::Member(name) => name.to_string(),
                PathElement::Index(index) => format!("[{index}]"),
            };
            param.path.iter().map(element).collect()
        };
        let Some((_, site)) = self.built.system.codels[id].site else {
            let service = |s: &ServiceId| {
                let number = self.built.services.get(&(c, *s));
                number.is_some_and(|&service| {
                    self.built.system.services[service].simple.contains(&id)
                })
            };
            let mut services = component.services.keys();
            let Some(s) = services.find(service) else {
                return Vec::new();
            };
            let params = (0..).zip(&component.services[s].params);
            let copied = params.filter(|(_, param)| {
                param.source == ParamSource::Ids
                    && matches!(param.dir, ParamDir::In | ParamDir::Inout)
            });
            let copy = |(i, param): (u32, &Param)| {
                let value = (Root::Variable(c, s, i), Vec::new());
                let member = (Root::Ids(c), path(param));
                [(ParamDir::In, value), (ParamDir::Out, member)]
            };
            return copied.flat_map(copy).collect();
        };
        let mut out = Vec::new();
        for param in &component.codel(site).params {
            match (param.source, site.owner) {
                (ParamSource::Ids, _) => out.push((param.dir, (Root::Ids(c), path(param)))),
                (ParamSource::Port(p), _) => {
                    let sources = locks_of(self.names, &self.connections, (c, p));
                    let sources = if sources.is_empty() { vec![(c, p)] } else { sources };
                    let of = |(c, p)| (param.dir, (Root::Port(c, p), path(param)));
                    out.extend(sources.into_iter().map(of));
                }
                (ParamSource::Local(Some(i)), Owner::Service(s)) => {
                    out.push((param.dir, (Root::Variable(c, s, i), path(param))));
                }
                _ => {}
            }
        }
        out
    }

    /// Applies `via`. If codels of a component are named, only these codels carry data there. If ports of a
    /// component are named, only these ports are written there.
    fn restrict(
        &self,
        via: &[Path],
        uses: &mut TiSlice<CodelId, DataAccesses>,
    ) -> Result<(), Diagnostic> {
        let mut codels: BTreeMap<usize, BTreeSet<CodelId>> = BTreeMap::new();
        let mut ports: BTreeMap<usize, BTreeSet<PortId>> = BTreeMap::new();
        for path in via {
            let target = self.names.resolve(path)?;
            if let Target::Port(c, p) = target {
                let sources = locks_of(self.names, &self.connections, (c, p));
                for (c, p) in sources {
                    ports.entry(c).or_default().insert(p);
                }
                continue;
            }
            let fits = |id: &CodelId| self.is_part(*id, &target);
            let named: Vec<CodelId> = uses.keys().filter(fits).collect();
            let Some(&one) = named.first() else {
                return Err(not_a("codel, task, service or port", path));
            };
            codels.entry(uses[one].component).or_default().extend(named);
        }
        for (id, usage) in uses.iter_mut_enumerated() {
            usage.carries = codels.get(&usage.component).is_none_or(|list| list.contains(&id));
            if let Some(list) = ports.get(&usage.component)
                && usage.writes.iter().any(|key| matches!(&key.0, Root::Port(..)))
            {
                let named = |key: &Key| matches!(&key.0, Root::Port(_, p) if list.contains(p));
                usage.carries &= usage.writes.iter().any(named);
            }
        }
        Ok(())
    }

    /// Returns true if a codel is, or belongs to, the target of a path.
    fn is_part(&self, id: CodelId, target: &Target) -> bool {
        let codel = &self.built.system.codels[id];
        let Some((c, site)) = codel.site else {
            return false;
        };
        let component = self.names.components[c].component;
        match target {
            Target::Component(of) => *of == c,
            Target::Task(of, t) => {
                let fsm = component.codel(site).kind == CodelKind::Fsm;
                *of == c && fsm && component.task_of(site) == Some(*t)
            }
            Target::Service(of, s) => *of == c && site.owner == Owner::Service(*s),
            Target::State(of, owner, _, state) => {
                *of == c && site.owner == *owner && codel.path.own() == *state
            }
            Target::Codel(of, s, index) => {
                *of == c && site.owner == Owner::Service(*s) && site.index == *index
            }
            _ => false,
        }
    }
}

/// Returns the places that the first datum can reach, and from which the last one can be reached.
fn relevant(uses: &TiSlice<CodelId, DataAccesses>, (first, last): &(Key, Key)) -> BTreeSet<Key> {
    let spread = |from: &Key, forward: bool| {
        let mut out = BTreeSet::from([from.clone()]);
        loop {
            let before = out.len();
            for usage in uses.iter().filter(|usage| usage.carries) {
                let (tail, head) = if forward {
                    (&usage.reads, &usage.writes)
                } else {
                    (&usage.writes, &usage.reads)
                };
                if tail.iter().any(|tail| out.contains(tail)) {
                    out.extend(head.iter().cloned());
                }
            }
            if out.len() == before {
                return out;
            }
        }
    };
    let (there, back) = (spread(first, true), spread(last, false));
    there.intersection(&back).cloned().collect()
}

/// Returns paths of the data from codel to codel, without repetition, and whether there are more.
fn ways(
    uses: &TiSlice<CodelId, DataAccesses>,
    (first, last): &(Key, Key),
) -> (Vec<Vec<CodelId>>, bool) {
    let mut out: Vec<Vec<CodelId>> = Vec::new();
    let mut steps = 0;
    let begins = |usage: &CodelId| uses[*usage].carries && uses[*usage].reads.contains(first);
    let mut open: Vec<Vec<CodelId>> = uses.keys().filter(begins).map(|usage| vec![usage]).collect();
    open.reverse();
    while let Some(way) = open.pop() {
        steps += 1;
        if steps > STEPS || out.len() > MAX_LISTED_PATHS {
            break;
        }
        let Some(&at) = way.last() else { continue };
        if uses[at].writes.contains(last) {
            out.push(way);
            continue;
        }
        for next in uses.keys().rev() {
            let goes_on = uses[next].carries
                && !way.contains(&next)
                && uses[at].writes.intersection(&uses[next].reads).any(|key| key != first);
            if goes_on {
                open.push(way.iter().copied().chain([next]).collect());
            }
        }
    }
    let more = out.len() > MAX_LISTED_PATHS || steps > STEPS;
    out.truncate(MAX_LISTED_PATHS);
    (out, more)
}
