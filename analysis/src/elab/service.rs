//! Attributes, functions and activities (language reference, section 11).

use crate::finding::role::Role;
use rustc_hash::FxHashMap;
use smol_str::SmolStr;
use typed_index_collections::TiVec;

use super::{
    AccessKind, DefId, DefKind, Entity,
    context::Elaborator,
    property::{self, keyword, union},
    signature::NewParam,
    state::{NameList, PathSource, ServiceState},
};
use crate::{
    finding::{
        Finding,
        names::NameProblem,
        services::{DeclarationProblem, ImportedBy},
    },
    item_tree::{CodelDecl, Item, Name, Property, PropertyKind, ServiceDecl},
    model::{
        CodelKind, ComponentId, ComponentKind, Missing, Name as Text, Owner, OwnerBody, Service,
        ServiceId, ServiceKind, ServiceList, Src, TaskId,
    },
    release::Change,
};

/// Indexes into [`ServiceState::lists`].
const INTERRUPTS: usize = 0;
const BEFORE: usize = 1;
const AFTER: usize = 2;

pub(super) fn kind_text(kind: ServiceKind) -> &'static str {
    match kind {
        ServiceKind::Attribute => "an attribute",
        ServiceKind::Function => "a function",
        ServiceKind::Activity => "an activity",
    }
}

impl<'a> Elaborator<'a> {
    pub(super) fn service(&mut self, c: ComponentId, decl: &'a ServiceDecl) {
        let Some(name) = &decl.name else { return };
        let at = self.src(name.ptr);
        if name.text == "all" {
            self.error(at, DeclarationProblem::Reserved);
        }
        if self.taken_by_other(c, &name.text, at) {
            return;
        }
        let params = self.service_params(c, decl);
        let known = self.components[c].service_by_name.get(&name.text).copied();
        let service = if let Some(service) = known {
            let def = self.components[c].services[service].def;
            self.refer_as(at, def, AccessKind::Declaration);
            if !self.check_kind(c, service, decl.kind, at) {
                return;
            }
            self.merge_params(c, service, &params, at);
            self.spec.components[c].services[service].src = at;
            service
        } else {
            let service = self.new_service(c, decl, name);
            let outer = self.container.replace(self.components[c].services[service].def);
            for NewParam { param, name_src } in params {
                let node = param.src;
                self.add_param(c, service, param, name_src, node, DefKind::Parameter);
            }
            self.container = outer;
            service
        };
        if decl.kind == ServiceKind::Attribute && known.is_none() {
            let (visit, scope) = (self.visit, self.scope);
            let state = &mut self.components[c].services[service];
            state.paths =
                decl.params.iter().map(|decl| PathSource { decl, visit, scope }).collect();
        }
        let node = self.src(decl.ptr);
        self.spec.owner_bodies.push(OwnerBody {
            component: c,
            owner: Owner::Service(service),
            node,
        });
        let state = &mut self.components[c].services[service];
        state.locals_here.clear();
        let container = state.def;
        let outer = self.container.replace(container);
        self.for_each(&decl.properties, |this, item| match item {
            Item::Property(property) => {
                this.service_property(c, service, decl.kind, name, property);
            }
            Item::Pragma(pragma) => this.pragma(pragma),
            _ => {}
        });
        self.container = outer;
    }

    /// Returns true if a port or remote has the name, and reports it.
    pub(super) fn taken_by_other(&mut self, c: ComponentId, name: &Text, at: Src) -> bool {
        let state = &self.components[c];
        let component = &self.spec.components[c];
        let taken = if let Some(port) = state.port_by_name.get(name) {
            Some(("a port", component.ports[*port].src))
        } else {
            let remote = state.remote_by_name.get(name);
            remote.map(|remote| ("a remote service", component.remotes[*remote].src))
        };
        let Some((what, place)) = taken else {
            return false;
        };
        self.add_refused_name(c, name);

        self.report(
            Finding::new(NameProblem::Taken { name: name.clone(), what }, at)
                .related(place, Role::Declared),
        );
        true
    }

    /// Returns true if the service declared before has this kind; reports it otherwise.
    pub(super) fn check_kind(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        kind: ServiceKind,
        at: Src,
    ) -> bool {
        let known = &self.spec.components[c].services[service];
        if known.kind == kind {
            return true;
        }

        let place = known.src;
        self.report(
            Finding::new(
                DeclarationProblem::OtherKind {
                    name: known.name.clone(),
                    was: kind_text(known.kind),
                    is: kind_text(kind),
                },
                at,
            )
            .related(place, Role::FirstDeclared),
        );
        false
    }

    fn new_service(&mut self, c: ComponentId, decl: &ServiceDecl, name: &Name) -> ServiceId {
        let at = self.src(name.ptr);
        let kind = match decl.kind {
            ServiceKind::Attribute => DefKind::Attribute,
            ServiceKind::Function => DefKind::Function,
            ServiceKind::Activity => DefKind::Activity,
        };
        let node = self.src(decl.ptr);
        let def = self.define(kind, &name.text, at, node, None);
        let service = self.insert_service(c, &name.text, decl.kind, at, def, None);
        self.set_entity(def, Entity::Service(c, service));
        service
    }

    pub(super) fn insert_service(
        &mut self,
        c: ComponentId,
        name: &Text,
        kind: ServiceKind,
        src: Src,
        def: DefId,
        imported_from: Option<ComponentId>,
    ) -> ServiceId {
        let services = &mut self.spec.components[c].services;
        let service = services.next_key();
        services.push(Service {
            name: name.clone(),
            src,
            kind,
            doc: None,
            task: None,
            params: Vec::new(),
            codels: TiVec::new(),
            throws: Vec::new(),
            interrupts: ServiceList::default(),
            before: ServiceList::default(),
            after: ServiceList::default(),
            imported_from,
        });
        let state = &mut self.components[c];
        state.services.push(ServiceState {
            def,
            params: Vec::new(),
            paths: Vec::new(),
            codels: Vec::new(),
            given: FxHashMap::default(),
            lists: Default::default(),
            locals_here: Vec::new(),
        });
        state.service_by_name.insert(name.clone(), service);
        service
    }

    // Properties

    fn service_property(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        kind: ServiceKind,
        name: &'a Name,
        property: &'a Property,
    ) {
        let at = self.src(property.ptr);
        let word = keyword(&property.kind);
        match &property.kind {
            PropertyKind::Doc(doc) => {
                let mut docs = self.spec.components[c].services[service].doc.take();
                self.add_doc(&mut docs, doc);
                self.spec.components[c].services[service].doc = docs;
            }
            PropertyKind::Throws(list) => {
                let added = self.throws(list, c, Some(Owner::Service(service)));
                union(&mut self.spec.components[c].services[service].throws, added);
            }
            PropertyKind::Interrupts(list) => {
                let names = self.name_list(list, word);
                let known = &mut self.components[c].services[service].lists[INTERRUPTS].names;
                for (name, src) in names {
                    if !known.iter().any(|(text, _)| *text == name) {
                        known.push((name, src));
                    }
                }
            }
            PropertyKind::Before(list) | PropertyKind::After(list) => {
                self.order(c, service, name, list, word, at);
            }
            PropertyKind::Task(task) => {
                if kind != ServiceKind::Activity {
                    let place = self.src(name.ptr);
                    self.report(
                        Finding::new(
                            DeclarationProblem::NoTask {
                                name: name.text.clone(),
                                kind: kind_text(kind),
                            },
                            place,
                        )
                        .related(at, Role::ThisProperty),
                    );
                } else if let Some(task) = task {
                    self.activity_task(c, service, task, word, at);
                }
            }
            PropertyKind::Local { ty, declarators } => {
                if kind == ServiceKind::Attribute {
                    let at = self.src(ty.ptr);
                    self.local_outside(at, "an attribute");
                } else {
                    self.locals(c, service, ty, declarators);
                }
            }
            PropertyKind::Validate(codel) => {
                self.codel_here(c, Owner::Service(service), codel, CodelKind::Validate);
            }
            PropertyKind::Codel(codel) => self.service_codel(c, service, kind, name, codel, at),
            other => {
                self.error(
                    at,
                    DeclarationProblem::NotInService {
                        kind: kind_text(kind),
                        word,
                        home: property::home(other),
                    },
                );
            }
        }
    }

    /// The services that a service must run before or after.
    fn order(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        name: &Name,
        list: &'a [Name],
        word: &'static str,
        at: Src,
    ) {
        let names = self.name_list(list, word);
        if self.once_in_service(c, service, word, at) {
            let which = if word == "before" { BEFORE } else { AFTER };
            for (text, src) in &names {
                if *text == name.text {
                    self.error(*src, DeclarationProblem::ListsItself { name: text.clone(), word });
                }
            }
            self.components[c].services[service].lists[which] = NameList { names };
        }
    }

    /// The task that runs an activity.
    fn activity_task(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        task: &Name,
        word: &'static str,
        at: Src,
    ) {
        let again = self.components[c].services[service].given.contains_key(word);
        if again && self.spec.release.has(Change::MergedProperties) {
            // The first one counts.
            self.task_named(c, task, at);
            self.newer(Change::MergedProperties, "a second `task` of an activity", at);
        } else if self.once_in_service(c, service, word, at)
            && let Some(task) = self.task_named(c, task, at)
        {
            self.spec.components[c].services[service].task = Some(task);
        }
    }

    /// A codel other than `validate`, in its place for the kind of service.
    fn service_codel(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        kind: ServiceKind,
        name: &Name,
        codel: &'a CodelDecl,
        at: Src,
    ) {
        let stateful = codel.triggers.is_some();
        match (kind, stateful) {
            (ServiceKind::Activity, false) => {
                self.misplaced_codel(name, codel, at, DeclarationProblem::CodelWithoutState);
                let owner = Owner::Service(service);
                self.misplaced_params(c, owner, codel, CodelKind::Fsm);
                return;
            }
            (ServiceKind::Attribute | ServiceKind::Function, true) => {
                let kind = kind_text(kind);
                self.misplaced_codel(name, codel, at, DeclarationProblem::CodelWithState { kind });
                let owner = Owner::Service(service);
                self.misplaced_params(c, owner, codel, CodelKind::Fsm);
                return;
            }
            (ServiceKind::Attribute, false) => {
                self.newer_or(
                    Change::AttributeCodels,
                    "a codel of an attribute",
                    at,
                    Finding::new(DeclarationProblem::AttributeCodel, at),
                );
            }
            _ => {}
        }
        let kind = if stateful { CodelKind::Fsm } else { CodelKind::Simple };
        self.codel_here(c, Owner::Service(service), codel, kind);
    }

    fn misplaced_codel(
        &mut self,
        service: &Name,
        codel: &CodelDecl,
        property: Src,
        kind: DeclarationProblem,
    ) {
        let compiler_at = self.src(service.ptr);
        let at = codel.name.as_ref().map_or(property, |name| self.src(name.ptr));
        self.report(
            // The reference compiler reports it at the service.
            Finding::new(kind, compiler_at).related(at, Role::ThisCodel),
        );
    }

    fn once_in_service(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        word: &'static str,
        at: Src,
    ) -> bool {
        let state = &mut self.components[c].services[service];
        let mut given = std::mem::take(&mut state.given);
        let first = self.once(&mut given, word, at);
        self.components[c].services[service].given = given;
        first
    }

    /// The task that an activity names; a missing one is reported.
    fn task_named(&mut self, c: ComponentId, task: &Name, at: Src) -> Option<TaskId> {
        let state = &self.components[c];
        let Some(&found) = state.task_by_name.get(&task.text) else {
            if self.is_excused(c, &task.text) {
                let name = task.text.clone();
                self.lack_of(c, Missing::Task { name });
                return None;
            }
            let names = state.task_by_name.keys().map(SmolStr::as_str);
            let near = self.near(self.src(task.ptr), &task.text, names);

            self.unresolved(at, DeclarationProblem::UnknownTask { name: task.text.clone() }, near);
            return None;
        };
        let def = state.tasks[found].def;
        self.refer(self.src(task.ptr), def);
        Some(found)
    }

    /// The names in a list of services.
    fn name_list(&mut self, list: &'a [Name], word: &str) -> Vec<(Text, Src)> {
        let mut names: Vec<(Text, Src)> = Vec::with_capacity(list.len());
        for name in list {
            let at = self.src(name.ptr);
            if let Some((_, first)) = names.iter().find(|(text, _)| *text == name.text) {
                let diagnostic = Finding::new(
                    DeclarationProblem::NamedTwice { name: name.text.clone(), word: word.into() },
                    at,
                )
                .related(*first, Role::FirstHere);
                self.report(diagnostic);
            } else {
                names.push((name.text.clone(), at));
            }
        }
        names
    }

    // The end of the body

    /// Resolves the lists of services, and checks that activities are complete.
    pub(super) fn close_services(&mut self, c: ComponentId) {
        for s in self.spec.components[c].services.keys() {
            let lists = self.components[c].services[s].lists.clone();
            let mut resolved = lists.iter().map(|name_list| self.resolve_list(c, name_list));
            let (interrupts, before, after) = (resolved.next(), resolved.next(), resolved.next());
            drop(resolved);
            let service = &mut self.spec.components[c].services[s];
            service.interrupts = interrupts.unwrap_or_default();
            service.before = before.unwrap_or_default();
            service.after = after.unwrap_or_default();
            if self.spec.components[c].kind == ComponentKind::Component {
                self.check_activity(c, s);
            }
        }
    }

    fn resolve_list(&mut self, c: ComponentId, list: &NameList) -> ServiceList {
        let mut resolved = ServiceList::default();
        for (name, at) in &list.names {
            if name == "all" {
                resolved.all = true;
                continue;
            }
            let state = &self.components[c];
            match state.service_by_name.get(name).copied() {
                Some(service) => {
                    let def = state.services[service].def;
                    if self.listed.insert(*at) {
                        self.refer(*at, def);
                    }
                    resolved.services.push(service);
                }
                None if self.is_excused(c, name) => {
                    let name = name.clone();
                    self.lack_of(c, Missing::Service { name });
                }
                None => {
                    let candidates = state.service_by_name.keys().map(SmolStr::as_str);
                    let near = self.near(*at, name, candidates);
                    let remote = state.remote_by_name.contains_key(name);
                    let name = name.clone();
                    let component = self.spec.components[c].name.clone();
                    let kind = if remote {
                        DeclarationProblem::OnlyRemote { name, component }
                    } else {
                        DeclarationProblem::UnknownService { name, component }
                    };

                    self.unresolved(*at, kind, near);
                }
            }
        }
        resolved
    }

    fn check_activity(&mut self, c: ComponentId, service: ServiceId) {
        let component = &self.spec.components[c];
        let activity = &component.services[service];
        if activity.kind != ServiceKind::Activity {
            return;
        }
        let state = &self.components[c];
        if state.incomplete {
            return;
        }
        let given = &state.services[service].given;
        let at = activity.src;
        let importer = activity.imported_from.map(|_| component.name.clone());
        let by = ImportedBy(importer);
        let no_task = activity.task.is_none() && !given.contains_key("task");
        let starts = activity
            .codels
            .iter()
            .any(|codel| codel.triggers.iter().any(|trigger| trigger.name == "start"));
        let name = activity.name.clone();
        if no_task {
            let (name, by) = (name.clone(), by.clone());
            let kind = match component.tasks.first() {
                Some(task) => {
                    DeclarationProblem::ActivityWithoutTask { name, by, task: task.name.clone() }
                }
                None => DeclarationProblem::ActivityWithoutAnyTask { name, by },
            };

            self.error(at, kind);
        }
        if !starts {
            self.error(at, DeclarationProblem::ActivityWithoutStart { name, by });
        }
    }
}
