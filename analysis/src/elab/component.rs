//! Components and interfaces: their bodies, ids and ports (language reference, sections 5.3, 8, 10).

use crate::finding::role::Role;
use rustc_hash::{FxHashMap, FxHashSet};
use typed_index_collections::TiVec;

use super::{
    AccessKind, BodyEnd, DefId, DefKind, Entity,
    context::Elaborator,
    scope::{Clash, ScopeId},
    state::ComponentState,
    types,
};
use crate::{
    finding::{Finding, names::NameProblem, services::DeclarationProblem},
    item_tree::{Item, Name, PortDecl, PropertyKind, Ptr},
    model::{
        Body, Component, ComponentId, ComponentKind, Name as Text, Port, PortDir, ScopeKind, Src,
        TypeId, TypeKind,
    },
    release::Change,
};

impl<'a> Elaborator<'a> {
    /// A declaration of a component or interface.
    pub(super) fn component(
        &mut self,
        interface: bool,
        name: &Name,
        body: Option<&'a [Item]>,
        ptr: Ptr,
    ) {
        let at = self.src(name.ptr);
        let kind = if interface { ComponentKind::Interface } else { ComponentKind::Component };
        let index = match self.component_by_name.get(&name.text).copied() {
            Some(index) => {
                if !self.reopen(index, kind, at) {
                    return;
                }
                index
            }
            None => self.new_component(kind, name, ptr),
        };
        let Some(body) = body else { return };
        let state = &self.components[index];
        let (scope, def) = (state.scope, state.def);
        self.spec.bodies.push(Body { visit: self.visit, item: Some(ptr.item), component: index });
        let outer = self.component.replace(index);
        self.within(scope, Some(def), |this| {
            this.for_each(body, |this, item| this.export(index, item));
            this.close(index);
        });
        self.component = outer;
    }

    fn reopen(&mut self, c: ComponentId, kind: ComponentKind, at: Src) -> bool {
        let known = &self.spec.components[c];
        let state = &self.components[c];
        let def = state.def;
        if known.kind != kind {
            let (was, is) = match kind {
                ComponentKind::Component => ("an interface", "a component"),
                ComponentKind::Interface => ("a component", "an interface"),
            };

            let place = self.definitions[def].src;
            self.report(
                Finding::new(NameProblem::OtherKind { name: known.name.clone(), was, is }, at)
                    .related(place, Role::FirstDeclared),
            );
            return false;
        }
        if let Some(closing) = state.closing {
            let snapshot = &mut self.closings[closing].snapshot;
            if snapshot.is_none() {
                *snapshot = Some(Box::new(known.clone()));
            }
        }
        self.refer_as(at, def, AccessKind::Declaration);
        true
    }

    fn new_component(&mut self, kind: ComponentKind, name: &Name, ptr: Ptr) -> ComponentId {
        let at = self.src(name.ptr);
        let node = self.src(ptr);
        let def_kind = match kind {
            ComponentKind::Component => DefKind::Component,
            ComponentKind::Interface => DefKind::Interface,
        };
        let scope = self.open_module(name, def_kind, at, node);
        let def = match self.scopes.get(scope).def {
            Some(def) => def,
            None => self.define(def_kind, &name.text, at, node, None),
        };
        let index = self.spec.components.next_key();
        self.set_entity(def, Entity::Component(index));
        self.component_by_name.insert(name.text.clone(), index);
        // Ids have a scope before they have members.
        let ids = Text::new_static("ids");
        if let Some(clash @ (Clash::Name(_) | Clash::Enclosing)) =
            self.scopes.clash(scope, &ids, true)
        {
            self.report_clash(scope, &ids, at, clash);
        }
        let pause = self.pause_scope(scope, at);
        self.spec.components.push(Component {
            name: name.text.clone(),
            kind,
            src: at,
            doc: None,
            version: None,
            lang: None,
            email: None,
            requires: self.spec.pragma_requires.clone(),
            codels_requires: Vec::new(),
            clock_rate: None,
            stack: None,
            ids: None,
            provides: Vec::new(),
            uses: Vec::new(),
            extends: Vec::new(),
            throws: Vec::new(),
            tasks: TiVec::new(),
            ports: TiVec::new(),
            services: TiVec::new(),
            remotes: TiVec::new(),
        });
        self.components.push(ComponentState {
            def,
            scope,
            pause,
            ids: None,
            given: FxHashMap::default(),
            tasks: TiVec::new(),
            services: TiVec::new(),
            ports: TiVec::new(),
            remotes: TiVec::new(),
            task_by_name: FxHashMap::default(),
            service_by_name: FxHashMap::default(),
            port_by_name: FxHashMap::default(),
            remote_by_name: FxHashMap::default(),
            lost: FxHashSet::default(),
            incomplete: false,
            imported: Vec::new(),
            lists: Default::default(),
            closing: None,
        });
        if kind == ComponentKind::Component {
            for state in ["ether", "start", "stop"] {
                let state = Text::new_static(state);
                let event = self.named(TypeKind::Event, scope, state.clone(), at);
                self.declare_at(scope, &state, at, event);
            }
            let outer = self.component.replace(index);
            self.within(scope, Some(def), |this| this.import_by_pragma(index, at));
            self.component = outer;
        }
        index
    }

    /// The scope `pause` of a component.
    fn pause_scope(&mut self, scope: ScopeId, at: Src) -> ScopeId {
        let pause_name = Text::new_static("pause");
        if let Some(&pause) = self.scopes.get(scope).children.get(&pause_name) {
            pause
        } else {
            if let Some(clash) = self.scopes.clash(scope, &pause_name, true) {
                // The component is called `pause`, or its module has a member of that name.
                self.report_clash(scope, &pause_name, at, clash);
            }
            self.scopes.open(scope, &pause_name, ScopeKind::Module, None, false)
        }
    }

    /// One item of a body.
    fn export(&mut self, c: ComponentId, item: &'a Item) {
        match item {
            Item::Property(property) => self.component_property(c, property),
            Item::Ids { members, keyword, .. } => self.ids(c, members, *keyword),
            Item::Task { name: Some(name), properties, ptr } => {
                self.task(c, name, properties, *ptr);
            }
            Item::Port(decl) => self.port(c, decl),
            Item::Service(decl) => self.service(c, decl),
            _ => {
                self.idl_statement(item);
            }
        }
    }

    /// The end of a body.
    fn close(&mut self, c: ComponentId) {
        self.close_services(c);
        let state = &mut self.components[c];
        state.closing = Some(self.closings.len());
        self.closings.push(BodyEnd { component: c, snapshot: None });
    }

    // Ids

    fn ids(&mut self, c: ComponentId, items: &'a [Item], keyword: Ptr) {
        let at = self.src(keyword);
        let first = self.components[c].ids.is_none();
        let Some(scope) = self.open_ids(c, at) else {
            // The name `ids` is taken; the members are still read, for their references.
            let scope = self.scopes.open(
                self.scope,
                &Text::new_static("ids"),
                ScopeKind::Struct,
                None,
                true,
            );
            self.within(scope, self.container, |this| this.members(items, DefKind::IdsMember));
            return;
        };
        let def = self.scopes.get(scope).def;
        // The ids can be used as a type once they have members.
        let (outer, name) = (self.components[c].scope, Text::new_static("ids"));
        let hidden = if first { self.scopes.get_mut(outer).names.remove(&name) } else { None };
        let members = self.within(scope, def, |this| this.members(items, DefKind::IdsMember));
        if let Some(ids) = hidden {
            self.scopes.get_mut(outer).names.insert(name, ids);
        }
        self.add_to_ids(c, members);
        if let Some(ids) = self.spec.components[c].ids {
            self.adopt(scope, ids);
        }
    }

    /// The scope of the ids, created with the ids themselves if there are none yet.
    pub(super) fn open_ids(&mut self, c: ComponentId, at: Src) -> Option<ScopeId> {
        let state = &self.components[c];
        if let Some(scope) = state.ids {
            return Some(scope);
        }
        let name = Text::new_static("ids");
        let outer = state.scope;
        if let Some(clash) = self.scopes.clash(outer, &name, true) {
            self.report_clash(outer, &name, at, clash);
            return None;
        }
        let kind = TypeKind::Struct { members: Vec::new() };
        let container = self.container.replace(state.def);
        let ids = self.named(kind, outer, name.clone(), at);
        let def = self.define(DefKind::Ids, &name, at, at, Some(ids));
        self.container = container;
        self.scopes.get_mut(outer).names.insert(name.clone(), ids);
        let scope = self.scopes.open(outer, &name, ScopeKind::Struct, Some(def), false);
        self.components[c].ids = Some(scope);
        self.spec.components[c].ids = Some(ids);
        Some(scope)
    }

    pub(super) fn add_to_ids(&mut self, c: ComponentId, added: Vec<TypeId>) {
        let Some(ids) = self.spec.components[c].ids else {
            return;
        };
        if let TypeKind::Struct { members } = &mut self.spec.types[ids].kind {
            members.extend(added);
        }
        self.move_to_end(ids);
    }

    // Names that were refused

    pub(super) fn add_refused_name(&mut self, c: ComponentId, name: &Text) {
        let lost = &mut self.components[c].lost;
        lost.insert(name.clone());
    }

    /// Returns true if a name that is not found in a component may be missing because of an error that was
    /// already reported.
    pub(super) fn is_excused(&self, c: ComponentId, name: &Text) -> bool {
        let state = &self.components[c];
        state.incomplete || state.lost.contains(name)
    }

    // Ports

    fn port(&mut self, c: ComponentId, decl: &'a PortDecl) {
        let keyword = self.src(decl.keyword);
        let data = self.type_ref(&decl.ty);
        let (Some(name), Some(out)) = (&decl.name, decl.out) else {
            return;
        };
        let at = self.src(name.ptr);
        let anonymous = self.spec.ty(data).name.is_none() && !self.is_unknown(data);
        if anonymous {
            self.error(
                keyword,
                DeclarationProblem::AnonymousPort {
                    name: name.text.clone(),
                    ty: types::display(&self.spec, data).into(),
                },
            );
        } else if types::has_native(&self.spec, data) {
            self.error(
                keyword,
                DeclarationProblem::NativePort {
                    name: name.text.clone(),
                    ty: types::display(&self.spec, data).into(),
                },
            );
        }
        let mut docs = None;
        self.for_each(&decl.properties, |this, item| {
            let property = match item {
                Item::Property(property) => property,
                Item::Pragma(pragma) => return this.pragma(pragma),
                _ => return,
            };
            if let PropertyKind::Doc(text) = &property.kind {
                this.add_doc(&mut docs, text);
            } else {
                let at = this.src(property.ptr);
                let word = super::property::keyword(&property.kind);

                this.error(at, DeclarationProblem::NotInPort { word });
            }
        });
        let dir = if out { PortDir::Out } else { PortDir::In };
        let port = Port {
            name: name.text.clone(),
            src: at,
            dir,
            multiple: decl.multiple,
            data,
            ty: data,
            doc: docs,
            imported_from: None,
        };
        let node = self.src(decl.ptr);
        let def = self.define(DefKind::Port, &name.text, at, node, None);
        self.add_port(c, port, false, def, at);
    }

    /// Adds a port to a component, with its type object. With `used`, the port is the reverse of a port of a
    /// used interface, so it has a type of its own.
    pub(super) fn add_port(
        &mut self,
        c: ComponentId,
        mut port: Port,
        used: bool,
        def: DefId,
        at: Src,
    ) -> bool {
        let state = &self.components[c];
        let taken = state.service_by_name.get(&port.name).copied();
        if let Some(service) = taken {
            let place = self.spec.components[c].services[service].src;

            self.report(
                Finding::new(NameProblem::Taken { name: port.name.clone(), what: "a service" }, at)
                    .related(place, Role::Service),
            );
            self.add_refused_name(c, &port.name);
            return false;
        }
        let scope = state.scope;
        let number = self.spec.components[c].ports.next_key();
        let kind = TypeKind::Port { component: c, port: number };
        if let Some(clash) = self.scopes.clash(scope, &port.name, false) {
            self.report_clash(scope, &port.name, at, clash);
            self.add_refused_name(c, &port.name);
            return false;
        }
        let provided = port.imported_from.is_some() && !used;
        let alias = provided && self.spec.release.has(Change::ProvidedPortTypes);
        let kind = if alias { TypeKind::Typedef { ty: port.ty } } else { kind };
        let ty = self.named(kind, scope, port.name.clone(), port.src);
        self.type_defs[ty] = Some(def);
        if port.imported_from.is_none() {
            self.definitions[def].ty = Some(ty);
            self.set_entity(def, Entity::Port(c, number));
        }
        self.declare_at(scope, &port.name, at, ty);
        if !alias {
            port.ty = ty;
        }
        let state = &mut self.components[c];
        state.port_by_name.insert(port.name.clone(), number);
        state.ports.push(def);
        self.spec.components[c].ports.push(port);
        true
    }
}
