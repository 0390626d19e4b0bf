//! Importing interfaces with `provides`, `uses`, `extends` and `#pragma provides` (language reference,
//! section 15).
//!
//! An interface is imported in its state at that point. Codels and the parameters of attributes are resolved
//! again, for the importing component, after everything else was imported (deviations D13 and D14). Problems
//! are reported at the name in the importing property.

mod remotes;
mod services;

use super::{
    context::{Elaborator, ImportInProgress},
    property::{join_doc, union},
    scope::Clash,
};
use crate::finding::role::Role;
use crate::{
    finding::{Finding, names::NameProblem, services::DeclarationProblem},
    item_tree::Name,
    model::{
        ComponentId, ComponentKind, Gap, Missing, Name as Text, Owner, Port, PortDir, Src, TypeId,
        TypeKind,
    },
    release::Change,
};

/// Index into `super::component::ComponentState::lists` of the lists of a property.
fn list_of(word: &str) -> usize {
    match word {
        "uses" => 0,
        "extends" => 1,
        _ => 2,
    }
}

impl<'a> Elaborator<'a> {
    /// A `provides`, `uses` or `extends` property.
    pub(super) fn imports(&mut self, c: ComponentId, names: &'a [Name], word: &'static str) {
        let mut seen: Vec<(&Text, Src)> = Vec::with_capacity(names.len());
        let mut list: Vec<(ComponentId, Src)> = Vec::with_capacity(names.len());
        for name in names {
            let at = self.src(name.ptr);
            if let Some((_, first)) = seen.iter().find(|(text, _)| *text == &name.text) {
                let diagnostic =
                    Finding::new(NameProblem::ImportedTwice { name: name.text.clone() }, at)
                        .related(*first, Role::FirstHere);
                self.report(diagnostic);
                continue;
            }
            seen.push((&name.text, at));
            let Some(interface) = self.interface(
                &name.text,
                at,
                |name| NameProblem::UnknownInterface { name },
                |name| NameProblem::NotAnInterface { name },
            ) else {
                self.components[c].incomplete = true;
                self.spec.gaps.push(Gap {
                    component: Some(c),
                    missing: Missing::Interface { name: name.text.clone(), used: word == "uses" },
                });
                continue;
            };
            list.push((interface, at));
        }
        // The lists of an interface are added to those of its importer. If the importer's first list of this
        // kind is being read, the added entries are imported as well, and so twice.
        let which = list_of(word);
        let lists = &mut self.components[c].lists;
        let first = lists[which].is_empty();
        union(&mut lists[which], list.iter().map(|(number, _)| *number));
        let named = list.len();
        let mut next = 0;
        while let Some(&(interface, at)) = list.get(next) {
            if first {
                for &theirs in &self.components[interface].lists[which] {
                    if !list.iter().any(|(number, _)| *number == theirs) {
                        list.push((theirs, at));
                    }
                }
            }
            self.import(c, interface, word, at, next < named);
            next += 1;
        }
    }

    /// The interface of that name; reports an error if the name is something else.
    pub(super) fn interface(
        &mut self,
        name: &Text,
        at: Src,
        unknown: fn(Text) -> NameProblem,
        is_component: fn(Text) -> NameProblem,
    ) -> Option<ComponentId> {
        let Some(&found) = self.component_by_name.get(name) else {
            let interfaces = self
                .spec
                .components
                .iter()
                .filter(|component| component.kind == ComponentKind::Interface)
                .map(|component| component.name.as_str());
            let near = self.near(at, name, interfaces);

            self.unresolved(at, unknown(name.clone()), near);
            return None;
        };
        let def = self.components[found].def;
        self.refer(at, def);
        if self.spec.components[found].kind == ComponentKind::Component {
            let place = self.spec.components[found].src;
            self.report(
                Finding::new(is_component(name.clone()), at).related(place, Role::Component),
            );
            return None;
        }
        Some(found)
    }

    /// The interfaces that `#pragma provides` adds to every new component.
    pub(super) fn import_by_pragma(&mut self, c: ComponentId, at: Src) {
        for interface in self.pragma_provides.clone() {
            self.import(c, interface, "provides", at, true);
        }
        for name in self.pragma_unknown.clone() {
            let missing = Missing::Interface { name, used: false };
            self.spec.gaps.push(Gap { component: Some(c), missing });
        }
    }

    /// Imports an interface. `named` is true if the property names it directly, not through another
    /// interface.
    fn import(
        &mut self,
        c: ComponentId,
        interface: ComponentId,
        word: &'static str,
        at: Src,
        named: bool,
    ) {
        let component = &mut self.spec.components[c];
        let list = match word {
            "uses" => &mut component.uses,
            "extends" => &mut component.extends,
            _ => &mut component.provides,
        };
        union(list, [interface]);
        for which in 0..self.components[c].lists.len() {
            let theirs = self.components[interface].lists[which].clone();
            union(&mut self.components[c].lists[which], theirs);
        }
        // An interface that names itself imports all its contents a second time.
        let imported = &self.components[c].imported;
        let again = if interface == c {
            Some("an interface that names itself imports all it has once more")
        } else if imported.contains(&interface) && !named {
            Some(
                "what this interface imports by the same property is imported a second time; let \
                 one use `provides` and the other `extends`",
            )
        } else if imported.contains(&interface) {
            Some("the component has this interface already, so it is imported twice")
        } else {
            None
        };
        let theirs = self.components[interface].imported.clone();
        let imported = &mut self.components[c].imported;
        union(imported, theirs);
        union(imported, [interface]);
        let outer = self.importing.replace(ImportInProgress { at, again });
        let uses = word == "uses";
        if !uses || !self.spec.release.has(Change::NoPropertiesOfUsed) {
            self.import_properties(c, interface, at);
        }
        self.import_ids(c, interface, at);
        self.import_tasks(c, interface, at);
        self.import_ports(c, interface, uses, at);
        let services = if uses {
            self.import_as_remotes(c, interface, at);
            Vec::new()
        } else {
            self.import_services(c, interface, at)
        };
        self.import_remotes(c, interface, at);
        for task in self.components[interface].tasks.keys() {
            let name = &self.spec.components[interface].tasks[task].name;
            let own = self.components[c].task_by_name.get(name);
            let Some(own) = own.copied() else { continue };
            for codel in self.components[interface].tasks[task].codels.clone() {
                self.add_codel(c, Owner::Task(own), codel);
            }
        }
        for (theirs, own) in services {
            let codels = &self.components[interface].services[theirs].codels;
            for codel in codels.clone() {
                self.add_codel(c, Owner::Service(own), codel);
            }
        }
        self.importing = outer;
    }

    fn import_properties(&mut self, c: ComponentId, interface: ComponentId, at: Src) {
        let from = &self.spec.components[interface];
        let (doc, requires, codels_requires, throws) = (
            from.doc.clone(),
            from.requires.clone(),
            from.codels_requires.clone(),
            from.throws.clone(),
        );
        let (version, lang, email, clock_rate, stack) = (
            from.version.clone(),
            from.lang.clone(),
            from.email.clone(),
            from.clock_rate.clone(),
            from.stack.clone(),
        );
        // Default values of an interface are not explicitly given.
        let theirs = &self.components[interface].given;
        let explicit = |word: &str| theirs.contains_key(word);
        let version = version.filter(|_| explicit("version"));
        let lang = lang.filter(|_| explicit("lang"));
        let separate = self.spec.release.has(Change::SeparateInterfaceDocs);
        let to = &mut self.spec.components[c];
        if let Some(doc) = doc.filter(|_| !separate) {
            join_doc(&mut to.doc, &doc);
        }
        union(&mut to.requires, requires);
        union(&mut to.codels_requires, codels_requires);
        union(&mut to.throws, throws);
        let word = "codels-requires";
        let state = &self.components[interface];
        if let Some(&theirs) = state.given.get(word) {
            let state = &mut self.components[c];
            if let Some(&own) = state.given.get(word) {
                self.newer_or(
                    Change::MergedProperties,
                    "a second `codels-requires`",
                    at,
                    Finding::new(DeclarationProblem::RequiresImported, at)
                        .related(theirs, Role::InInterface)
                        .related(own, Role::Other),
                );
            } else {
                state.given.insert(word, at);
            }
        }
        let mut once =
            |word: &'static str, value: &str| self.import_once(c, interface, word, value, at);
        let version = version.filter(|version| once("version", version));
        let lang = lang.filter(|language| once("lang", language));
        let email = email.filter(|email| once("email", email));
        let clock_rate = clock_rate.filter(|_| once("clock-rate", ""));
        let stack = stack.filter(|_| once("stack", ""));
        let to = &mut self.spec.components[c];
        to.version = version.or(to.version.take());
        to.lang = lang.or(to.lang.take());
        to.email = email.or(to.email.take());
        to.clock_rate = clock_rate.or(to.clock_rate.take());
        to.stack = stack.or(to.stack.take());
    }

    /// Records that a property that does not merge is imported; reports it if it was already given.
    fn import_once(
        &mut self,
        c: ComponentId,
        interface: ComponentId,
        word: &'static str,
        value: &str,
        at: Src,
    ) -> bool {
        if self.repeats_first(c, word, value) {
            self.newer(Change::MergedProperties, "a property that is repeated", at);
            return false;
        }
        let theirs = self.components[interface].given.get(word).copied();
        let given = &mut self.components[c].given;
        let Some(&own) = given.get(word) else {
            given.insert(word, at);
            return true;
        };
        let name = &self.spec.components[interface].name;

        let mut diagnostic = Finding::new(
            DeclarationProblem::PropertyImported { interface: name.clone(), word },
            at,
        );
        if let Some(theirs) = theirs {
            diagnostic = diagnostic.related(theirs, Role::InInterface);
        }
        self.report(diagnostic.related(own, Role::Other));
        false
    }

    fn import_ids(&mut self, c: ComponentId, interface: ComponentId, at: Src) {
        let Some(theirs) = self.spec.components[interface].ids else {
            return;
        };
        let TypeKind::Struct { members } = &self.spec.ty(theirs).kind else {
            return;
        };
        let members = members.clone();
        let first = self.spec.components[c].ids.is_none();
        let Some(scope) = self.open_ids(c, at) else {
            return;
        };
        if let Some(own) = self.spec.components[c].ids.filter(|_| first) {
            // Templates see the origin of the members.
            self.spec.types[own].src = self.spec.ty(theirs).src;
        }
        let mut added: Vec<TypeId> = Vec::new();
        for member in members {
            let Some(name) = self.spec.ty(member).name.clone() else {
                continue;
            };
            let origin = self.origin(member);
            match self.scopes.clash(scope, &name, false) {
                // One interface imported in two ways.
                Some(Clash::Name(known)) if self.origin(known) == origin => {}
                Some(clash @ (Clash::Name(_) | Clash::Scope(_))) => {
                    self.report_clash(scope, &name, at, clash);
                }
                _ => {
                    let kind = self.spec.ty(member).kind.clone();
                    let src = self.spec.ty(member).src;
                    let copy = self.named(kind, scope, name.clone(), src);
                    self.type_defs[copy] = self.type_defs[member];
                    self.origins.insert(copy, origin);
                    self.scopes.get_mut(scope).names.insert(name, copy);
                    added.push(copy);
                }
            }
        }
        self.add_to_ids(c, added);
    }

    /// The ids member of an interface that a member was copied from; itself if it was not copied.
    fn origin(&self, member: TypeId) -> TypeId {
        self.origins.get(&member).copied().unwrap_or(member)
    }

    fn import_tasks(&mut self, c: ComponentId, interface: ComponentId, at: Src) {
        for number in self.components[interface].tasks.keys() {
            let task = self.spec.components[interface].tasks[number].clone();
            let def = self.components[interface].tasks[number].def;
            let known = self.components[c].task_by_name.get(&task.name);
            let own = match known.copied() {
                Some(own) => own,
                None => self.new_task(c, &task.name, task.src, def, Some(interface)),
            };
            let mut conflicts: Vec<&'static str> = Vec::new();
            let to = &mut self.spec.components[c].tasks[own];
            let given = &mut self.components[c].tasks[own].given;
            let mut once = |word: &'static str, brought: bool| {
                if brought && given.contains_key(word) {
                    conflicts.push(word);
                    return false;
                }
                if brought {
                    given.insert(word, at);
                }
                brought
            };
            if once("period", task.period.is_some()) {
                to.period = task.period;
            }
            if once("delay", task.delay.is_some()) {
                to.delay = task.delay;
            }
            if once("priority", task.priority.is_some()) {
                to.priority = task.priority;
            }
            if once("scheduling", task.real_time) {
                to.real_time = true;
            }
            if once("stack", task.stack.is_some()) {
                to.stack = task.stack;
            }
            if let Some(doc) = &task.doc {
                join_doc(&mut to.doc, doc);
            }
            union(&mut to.throws, task.throws);
            let place = to.src;
            for word in conflicts {
                let theirs = self.components[interface].tasks[number].given.get(word);
                let mut diagnostic = Finding::new(
                    DeclarationProblem::TaskPropertyImported { task: task.name.clone(), word },
                    at,
                );
                if let Some(theirs) = theirs {
                    diagnostic = diagnostic.related(*theirs, Role::InInterface);
                }
                self.report(diagnostic.related(place, Role::OtherTask));
            }
            self.check_delay(c, own);
            let codels = &self.components[interface].tasks[number].codels;
            self.import_states(c, codels.clone());
        }
    }

    fn import_ports(&mut self, c: ComponentId, interface: ComponentId, uses: bool, at: Src) {
        for number in self.components[interface].ports.keys() {
            let port = self.spec.components[interface].ports[number].clone();
            let def = self.components[interface].ports[number];
            let dir = match (uses, port.dir) {
                (true, PortDir::In) => PortDir::Out,
                (true, PortDir::Out) => PortDir::In,
                (false, dir) => dir,
            };
            let port = Port { dir, imported_from: Some(interface), ..port };
            self.add_port(c, port, uses, def, at);
        }
    }
}
