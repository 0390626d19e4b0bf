//! The part of a model that the checks of one body can see.
//!
//! Types are renumbered in the order in which they are met, and components that the body has nothing
//! to do with are emptied: what the rest of the unit looks like does not show.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::model::{Component, Spec, Type, TypeId, TypeKind, visit::TypeIds as _};

/// A body of a component or interface, with what it refers to.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct BodyView {
    /// Components keep their indexes; the one of the body is as it is at its end.
    pub(crate) spec: Spec,
    index: Option<u32>,
}

impl BodyView {
    /// The view of `component`, number `index` of `spec` (maybe in an earlier state).
    pub(crate) fn new(spec: &Spec, index: u32, component: &Component) -> BodyView {
        let mut numbering = Numbering {
            spec,
            numbers: FxHashMap::default(),
            order: Vec::new(),
        };
        let mut component = component.clone();
        component.for_each_type_id(&mut |id| numbering.renumber(id));
        // A name among the states may be that of an exception.
        let states: FxHashSet<&str> = component
            .all_codels()
            .flat_map(|it| &component.codel(it).yields)
            .map(|it| it.name.as_str())
            .collect();
        for (ty, id) in std::iter::zip(&spec.types, 0..) {
            let name = ty.name.as_ref().map(|it| it.as_str());
            if matches!(ty.kind, TypeKind::Exception { .. })
                && name.is_some_and(|it| states.contains(it))
            {
                numbering.renumber(&mut TypeId(id));
            }
        }
        let mut visible = vec![false; spec.components.len()];
        mark_visible(spec, &component, &mut visible);
        let mut components: Vec<Component> = Vec::with_capacity(spec.components.len());
        for (it, visible) in std::iter::zip(&spec.components, visible) {
            components.push(if components.len() == index as usize {
                std::mem::replace(&mut component, emptied(it))
            } else if visible {
                let mut it = it.clone();
                it.for_each_type_id(&mut |id| numbering.renumber(id));
                it
            } else {
                emptied(it)
            });
        }
        let mut types = Vec::new();
        while let Some(&old) = numbering.order.get(types.len()) {
            let mut ty = spec.types.get(old.0 as usize).cloned().unwrap_or(UNKNOWN);
            ty.for_each_type_id(&mut |id| numbering.renumber(id));
            types.push(ty);
        }
        BodyView {
            spec: Spec {
                release: spec.release,
                types,
                components,
                ..Spec::default()
            },
            index: Some(index),
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
    src: crate::model::Src {
        visit: 0,
        item: 0,
        node: 0,
    },
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

/// Marks the components that a component names, and those they name in turn.
fn mark_visible(spec: &Spec, from: &Component, visible: &mut [bool]) {
    let imported = from.tasks.iter().filter_map(|it| it.imported_from);
    let imported = imported.chain(from.ports.iter().filter_map(|it| it.imported_from));
    let imported = imported.chain(from.services.iter().filter_map(|it| it.imported_from));
    let named = from.provides.iter().chain(&from.uses).chain(&from.extends);
    let named = named
        .copied()
        .chain(from.remotes.iter().map(|it| it.interface));
    for it in named.chain(imported) {
        if let Some(seen) = visible.get_mut(it as usize)
            && !std::mem::replace(seen, true)
        {
            mark_visible(spec, &spec.components[it as usize], visible);
        }
    }
}

/// The name and the kind of a component.
fn emptied(component: &Component) -> Component {
    Component {
        name: component.name.clone(),
        kind: component.kind,
        src: crate::model::Src::default(),
        doc: None,
        version: None,
        lang: None,
        email: None,
        requires: Vec::new(),
        codels_requires: Vec::new(),
        clock_rate: None,
        stack: None,
        ids: None,
        provides: Vec::new(),
        uses: Vec::new(),
        extends: Vec::new(),
        throws: Vec::new(),
        tasks: Vec::new(),
        ports: Vec::new(),
        services: Vec::new(),
        remotes: Vec::new(),
    }
}
