//! Call hierarchy: states of a machine through `yield`, services through `interrupt`.
//!
//! An item is identified by names, not by places, so that it stays valid after edits.

use std::ops::Range;

use camino::Utf8PathBuf;
use serde::{Deserialize, Serialize};
use smol_str::SmolStr;

use super::{FileView, SymbolKind, resolve::targets_at};
use crate::{
    elab::DefKind,
    model::{Codel, Component, Owner, ServiceId, Src},
    source_map::bytes,
};

/// Identifies a state of a machine, or a service.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct CallKey {
    /// The component or interface.
    pub component: SmolStr,
    /// The task or service.
    pub owner: SmolStr,
    /// True if `owner` is a task.
    pub task: bool,
    /// The state; `None` for the service itself.
    pub state: Option<SmolStr>,
}

/// A state or service with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CallItem {
    pub name: String,
    /// Codel and machine.
    pub detail: String,
    pub kind: SymbolKind,
    /// The file.
    pub path: Utf8PathBuf,
    /// The range of the name.
    pub range: Range<usize>,
    /// The key for further queries.
    pub key: CallKey,
}

/// A neighbour, with the mentions that connect it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Call {
    /// The neighbour.
    pub item: CallItem,
    /// The names in `yield` or `interrupt` lists, in the file of the caller.
    pub ranges: Vec<Range<usize>>,
}

/// The states or services under the cursor.
pub(crate) fn prepare(view: &FileView<'_>, at: usize) -> Option<Vec<CallItem>> {
    let (range, targets) = targets_at(view, at)?;
    let elaborated = view.elaborated();
    let mut out: Vec<CallItem> = Vec::new();
    let here = |src: Src| {
        let place = view.place(src);
        place.is_some_and(|(file, found)| file == view.file && found.contains_range(range))
    };
    for target in &targets {
        let super::resolve::Target::Definition(id) = target else {
            continue;
        };
        let definition = elaborated.definition(*id);
        for component in &elaborated.spec.components {
            for owner in component.owners() {
                for codel in component.codels_of(owner) {
                    let mentioned = codel.triggers.iter().chain(&codel.yields);
                    let states: Vec<&SmolStr> = match definition.kind {
                        DefKind::State => {
                            let named = mentioned.filter(|state| state.name == definition.name);
                            named
                                .filter(|trigger| here(trigger.src))
                                .map(|trigger| &trigger.name)
                                .collect()
                        }
                        DefKind::Codel if here(codel.src) => {
                            codel.triggers.iter().map(|trigger| &trigger.name).collect()
                        }
                        _ => Vec::new(),
                    };
                    for state in states {
                        out.extend(item(view, component, owner, Some(state)));
                    }
                }
            }
            if let DefKind::Attribute | DefKind::Function | DefKind::Activity = definition.kind {
                let own = component.services.iter_enumerated();
                let found = own.filter(|(_, service)| service.name == definition.name);
                let of_it = definition.container.is_some_and(|container| {
                    let container = &elaborated.definition(container).name;
                    *container == component.name
                        || component.provides.iter().chain(&component.extends).any(|provided| {
                            elaborated.spec.components[*provided].name == *container
                        })
                });
                for (index, _) in found.filter(|_| of_it) {
                    out.extend(item(view, component, Owner::Service(index), None));
                }
            }
        }
    }
    let mut seen = rustc_hash::FxHashSet::default();
    out.retain(|call_item| seen.insert(call_item.key.clone()));
    (!out.is_empty()).then_some(out)
}

/// The callers of an item.
pub(crate) fn incoming(view: &FileView<'_>, key: &CallKey) -> Vec<Call> {
    calls(view, key, true)
}

/// The targets of an item.
pub(crate) fn outgoing(view: &FileView<'_>, key: &CallKey) -> Vec<Call> {
    calls(view, key, false)
}

fn calls(view: &FileView<'_>, key: &CallKey, incoming: bool) -> Vec<Call> {
    let spec = &view.elaborated().spec;
    let Some(component) = spec.components.iter().find(|component| component.name == key.component)
    else {
        return Vec::new();
    };
    let Some(owner) = find_owner(component, key) else {
        return Vec::new();
    };
    let mut out: Vec<Call> = Vec::new();
    let mut add = |item: Option<CallItem>, mention: Option<Src>| {
        let Some(item) = item else { return };
        let range = mention.and_then(|mention| view.place(mention)).map(|place| bytes(place.1));
        match out.iter_mut().find(|call| call.item.key == item.key) {
            Some(known) => known.ranges.extend(range),
            None => out.push(Call { item, ranges: range.into_iter().collect() }),
        }
    };
    if let Some(state) = &key.state {
        for codel in component.codels_of(owner) {
            let bound = |codel: &Codel| codel.triggers.iter().any(|trigger| trigger.name == *state);
            if incoming {
                for to in codel.yields.iter().filter(|candidate| candidate.name == *state) {
                    for from in &codel.triggers {
                        let item = item(view, component, owner, Some(&from.name));
                        add(item, Some(to.src));
                    }
                }
            } else if bound(codel) {
                for to in &codel.yields {
                    add(item(view, component, owner, Some(&to.name)), Some(to.src));
                }
            }
        }
    } else {
        let Owner::Service(own) = owner else {
            return out;
        };
        for index in component.services.keys() {
            let (from, to) = if incoming { (index, own) } else { (own, index) };
            let list = &component.services[from].interrupts;
            if list.all || list.services.contains(&to) {
                let mention = mention(view, component, from, &component.services[to].name);
                add(item(view, component, Owner::Service(index), None), mention);
            }
        }
    }
    out
}

/// The place in the `interrupts` of a service that names another one.
fn mention(view: &FileView<'_>, component: &Component, from: ServiceId, to: &str) -> Option<Src> {
    let elaborated = view.elaborated();
    let from = &component.services[from];
    let node = elaborated.definitions.iter().find(|definition| definition.src == from.src)?.node;
    let (file, range) = view.place(node)?;
    let mut inside = elaborated.references.iter().filter(|reference| {
        !reference.is_declaration()
            && elaborated.definition(reference.target).name == to
            && view
                .place(reference.at)
                .is_some_and(|(in_file, at)| in_file == file && range.contains_range(at))
    });
    inside.next().map(|reference| reference.at)
}

fn find_owner(component: &Component, key: &CallKey) -> Option<Owner> {
    component.owners().find(|&owner| {
        matches!(owner, Owner::Task(_)) == key.task && *component.owner_name(owner) == key.owner
    })
}

fn item(
    view: &FileView<'_>,
    component: &Component,
    owner: Owner,
    state: Option<&SmolStr>,
) -> Option<CallItem> {
    let (name, task, src, kind) = match owner {
        Owner::Task(i) => {
            let task = &component.tasks[i];
            (&task.name, true, task.src, SymbolKind::Task)
        }
        Owner::Service(i) => {
            let service = &component.services[i];
            (&service.name, false, service.src, SymbolKind::from(service.kind))
        }
    };
    let key = CallKey {
        component: component.name.clone(),
        owner: name.clone(),
        task,
        state: state.cloned(),
    };
    let Some(state) = state else {
        let (file, range) = view.place(src)?;
        return Some(CallItem {
            name: name.to_string(),
            detail: format!("service of {}", component.name),
            kind,
            path: file.path(view.db).clone(),
            range: bytes(range),
            key,
        });
    };
    let codels = component.codels_of(owner);
    let trigger = codels.iter().find_map(|codel| {
        let found = codel.triggers.iter().find(|trigger| trigger.name == *state)?;
        Some((found.src, Some(&codel.name)))
    });
    let mention = || {
        let mut all = codels.iter().flat_map(|codel| &codel.yields);
        Some((all.find(|codel| codel.name == *state)?.src, None))
    };
    let (src, codel) = trigger.or_else(mention)?;
    let (file, range) = view.place(src)?;
    let machine = format!("{}::{name}", component.name);
    Some(CallItem {
        name: state.to_string(),
        detail: match codel {
            Some(codel) => format!("codel {codel} · {machine}"),
            None => machine,
        },
        kind: SymbolKind::State,
        path: file.path(view.db).clone(),
        range: bytes(range),
        key,
    })
}

#[cfg(test)]
mod tests {
    use crate::{ide::Call, test_support::Fixture};

    const TEXT: &str = "component c {
  task t {
    codel<start> f() yield go, pause::wait;
    codel<wait, go> g() yield wait, ether;
  };
  function h() { interrupt i; };
  function i() { interrupt all; };
};
";

    fn show(calls: &[Call]) -> Vec<String> {
        let show = |call: &Call| format!("{} ({})", call.item.name, call.ranges.len());
        calls.iter().map(show).collect()
    }

    #[track_caller]
    fn check(mark: &str, incoming: &[&str], outgoing: &[&str]) {
        let text = TEXT.replacen(&mark.replace("$0", ""), mark, 1);
        let fixture = Fixture::new(&text);
        let analysis = fixture.analysis();
        let items = analysis.call_hierarchy(&fixture.at()).unwrap().unwrap();
        let path = &fixture.at().path;
        let key = &items[0].key;
        assert_eq!(show(&analysis.incoming_calls(path, key).unwrap()), incoming);
        assert_eq!(show(&analysis.outgoing_calls(path, key).unwrap()), outgoing);
    }

    #[test]
    fn states() {
        check("pause::wait$0", &["start (1)", "wait (1)", "go (1)"], &["wait (1)", "ether (1)"]);
        check("codel<start$0>", &[], &["go (1)", "wait (1)"]);
        check("f$0()", &[], &["go (1)", "wait (1)"]);
        check("ether$0", &["wait (1)", "go (1)"], &[]);
    }

    #[test]
    fn services() {
        check("function h$0", &["i (0)"], &["i (1)"]);
        check("function i$0", &["h (1)", "i (0)"], &["h (0)", "i (0)"]);
    }
}
