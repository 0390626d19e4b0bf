//! The part of a model that the checks of one body can see.
//!
//! Types are renumbered in order of occurrence, and components unrelated to the body are left out: changes in
//! the rest of the unit leave the view equal.

use rustc_hash::{FxHashMap, FxHashSet};
use smol_str::SmolStr;

use crate::model::{Component, Spec, Type, TypeId, TypeKind, visit::TypeIds as _};

/// A body of a component or interface, with everything it refers to.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct BodyView {
    /// The component of the body is in its state at the end of the body.
    pub(crate) spec: Spec,
    index: Option<u32>,
}

impl BodyView {
    /// The view of `component`, number `index` of `spec` (maybe in an earlier state).
    pub(crate) fn new(spec: &Spec, index: u32, component: &Component) -> BodyView {
        let mut numbering = Numbering { spec, numbers: FxHashMap::default(), order: Vec::new() };
        let mut component = component.clone();
        component.for_each_type_id(&mut |id| numbering.renumber(id));
        // A name among the states may be the name of an exception.
        let states: FxHashSet<&str> = component
            .all_codels()
            .flat_map(|codel| &component.codel(codel).yields)
            .map(|codel| codel.name.as_str())
            .collect();
        for (ty, id) in std::iter::zip(&spec.types, 0..) {
            let name = ty.name.as_ref().map(SmolStr::as_str);
            if matches!(ty.kind, TypeKind::Exception { .. })
                && name.is_some_and(|name| states.contains(name))
            {
                numbering.renumber(&mut TypeId(id));
            }
        }
        let mut visible = vec![false; spec.components.len()];
        mark_visible(spec, &component, &mut visible);
        if let Some(own) = visible.get_mut(index as usize) {
            *own = true;
        }
        let mut places = FxHashMap::default();
        for (old, _) in (0..).zip(&visible).filter(|pair| *pair.1) {
            let next = places.len() as u32;
            places.insert(old, next);
        }
        let mut own = Some(component);
        let mut components: Vec<Component> = Vec::with_capacity(places.len());
        for (old, component) in (0..).zip(&spec.components) {
            if !places.contains_key(&old) {
                continue;
            }
            let mut component = if let Some(component) = own.take_if(|_| old == index) {
                component
            } else {
                let mut component = component.clone();
                component.for_each_type_id(&mut |id| numbering.renumber(id));
                component
            };
            renumber_components(&mut component, |number| {
                // Its references are visible, or out of range.
                *number = places.get(number).copied().unwrap_or(u32::MAX);
            });
            components.push(component);
        }
        let mut types = Vec::new();
        while let Some(&old) = numbering.order.get(types.len()) {
            let mut ty = spec.types.get(old.0 as usize).cloned().unwrap_or(UNKNOWN);
            ty.for_each_type_id(&mut |id| numbering.renumber(id));
            types.push(ty);
        }
        BodyView {
            spec: Spec { release: spec.release, types, components, ..Spec::default() },
            index: places.get(&index).copied(),
        }
    }

    /// The component of the body.
    pub(crate) fn component(&self) -> Option<&Component> {
        self.spec.components.get(self.index? as usize)
    }
}

const UNKNOWN: Type = Type {
    kind: TypeKind::Unknown,
    name: None,
    scope: Vec::new(),
    src: crate::model::Src { visit: 0, item: 0, node: 0 },
    parent: None,
    masquerade: Vec::new(),
};

struct Numbering<'a> {
    spec: &'a Spec,
    numbers: FxHashMap<TypeId, TypeId>,
    order: Vec<TypeId>,
}

impl Numbering<'_> {
    fn renumber(&mut self, id: &mut TypeId) {
        debug_assert!((id.0 as usize) < self.spec.types.len());
        let next = TypeId(self.order.len() as u32);
        *id = *self.numbers.entry(*id).or_insert_with_key(|&old| {
            self.order.push(old);
            next
        });
    }
}

/// Marks the components that a component names, and recursively the components named by those.
fn mark_visible(spec: &Spec, from: &Component, visible: &mut [bool]) {
    let mut named: Vec<u32> = named_by(from).collect();
    while let Some(number) = named.pop() {
        if let Some(seen) = visible.get_mut(number as usize)
            && !std::mem::replace(seen, true)
        {
            named.extend(named_by(&spec.components[number as usize]));
        }
    }
}

/// Indexes of the components that a component names.
fn named_by(component: &Component) -> impl Iterator<Item = u32> {
    let tasks = component.tasks.iter().filter_map(|task| task.imported_from);
    let ports = component.ports.iter().filter_map(|port| port.imported_from);
    let services = component.services.iter();
    let services = services.filter_map(|service| service.imported_from);
    let remotes = component.remotes.iter().map(|remote| remote.interface);
    let named = component.provides.iter().chain(&component.uses);
    let named = named.chain(&component.extends).copied();
    named.chain(remotes).chain(tasks).chain(ports).chain(services)
}

/// Renumbers the components that a component names.
fn renumber_components(component: &mut Component, f: impl FnMut(&mut u32)) {
    let tasks = component.tasks.iter_mut().map(|task| &mut task.imported_from);
    let ports = component.ports.iter_mut().map(|port| &mut port.imported_from);
    let services = component.services.iter_mut();
    let services = services.map(|service| &mut service.imported_from);
    let imported = tasks.chain(ports).chain(services).flatten();
    let remotes = component.remotes.iter_mut().map(|remote| &mut remote.interface);
    let named = component.provides.iter_mut().chain(&mut component.uses);
    let named = named.chain(&mut component.extends);
    named.chain(remotes).chain(imported).for_each(f);
}
