//! `provides` and `extends`: make the services of an interface services of the importer.

use crate::finding::role::Role;
use crate::{
    elab::{
        DefId,
        context::Elaborator,
        property::{join_doc, union},
        types::equal,
    },
    finding::{Finding, services::DeclarationProblem},
    model::{ComponentId, Param, ParamDir, Service, ServiceId, ServiceKind, Src},
    release::Change,
};

impl Elaborator<'_> {
    /// Adds the services of an interface, without their codels. Returns the pairs of their index in the
    /// interface and in the component, for adding the codels.
    pub(super) fn import_services(
        &mut self,
        c: ComponentId,
        interface: ComponentId,
        at: Src,
    ) -> Vec<(ServiceId, ServiceId)> {
        let mut pairs = Vec::new();
        for number in self.components[interface].services.keys() {
            let service = self.spec.components[interface].services[number].clone();
            if self.taken_by_other(c, &service.name, at) {
                continue;
            }
            let params = self.imported_params(c, interface, number, &service);
            let known = self.components[c].service_by_name.get(&service.name).copied();
            let own = if let Some(own) = known {
                if !self.check_kind(c, own, service.kind, at) {
                    continue;
                }
                let plain: Vec<&Param> = params
                    .iter()
                    .map(|(param, _)| param)
                    .filter(|param| param.dir != ParamDir::Local)
                    .collect();
                self.compare_params(c, own, &plain, at, Some(at));
                self.merge_locals(c, own, &params, at);
                let known = &mut self.spec.components[c].services[own];
                known.src = service.src;
                own
            } else {
                let def = self.components[interface].services[number].def;
                let own = self.insert_service(
                    c,
                    &service.name,
                    service.kind,
                    service.src,
                    def,
                    Some(interface),
                );
                for (param, def) in params {
                    self.push_param(c, own, param, def);
                }
                let paths = self.components[interface].services[number].paths.clone();
                self.components[c].services[own].paths = paths;
                own
            };
            self.import_service_properties(c, interface, number, own, &service, at);
            let codels = &self.components[interface].services[number].codels;
            self.import_states(c, codels.clone());
            pairs.push((number, own));
        }
        pairs
    }

    /// The parameters of a service of an interface, as the importing component sees them.
    fn imported_params(
        &mut self,
        c: ComponentId,
        interface: ComponentId,
        number: ServiceId,
        service: &Service,
    ) -> Vec<(Param, DefId)> {
        let state = &self.components[interface].services[number];
        let defs = state.params.clone();
        let mut params: Vec<Param> = service.params.clone();
        if service.kind == ServiceKind::Attribute {
            // Their paths start from the ids of the interface.
            let inits: Vec<_> = params.iter().map(|param| param.init.clone()).collect();
            let names: Vec<_> = params.iter().map(|param| param.name.clone()).collect();
            params.clear();
            for source in state.paths.clone() {
                let param = self.in_visit(source.visit, |this| {
                    this.within(source.scope, this.container, |this| {
                        this.attribute_param(c, source.decl)
                    })
                });
                let Some(mut param) = param else { continue };
                if let Some(known) = names.iter().position(|name| *name == param.name) {
                    param.init.clone_from(&inits[known]);
                }
                params.push(param);
            }
        }
        params.into_iter().zip(defs).collect()
    }

    fn merge_locals(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        params: &[(Param, DefId)],
        at: Src,
    ) {
        for (local, def) in params.iter().filter(|(param, _)| param.dir == ParamDir::Local) {
            let known = &self.spec.components[c].services[service];
            let old = known.params.iter().find(|param| param.name == local.name);
            let Some(old) = old else {
                self.push_param(c, service, local.clone(), *def);
                continue;
            };
            let same = old.dir == local.dir && equal(&self.spec, old.ty, local.ty);
            if !same {
                let place = old.src;
                self.report(
                    Finding::new(
                        DeclarationProblem::OtherLocal {
                            name: local.name.clone(),
                            service: known.name.clone(),
                        },
                        at,
                    )
                    .related(local.src, Role::InInterface)
                    .related(place, Role::Here),
                );
            }
        }
    }

    fn import_service_properties(
        &mut self,
        c: ComponentId,
        interface: ComponentId,
        number: ServiceId,
        own: ServiceId,
        service: &Service,
        at: Src,
    ) {
        let theirs = self.components[interface].services[number].clone();
        let task = service.task.and_then(|task| {
            let name = &self.spec.components[interface].tasks[task].name;
            self.components[c].task_by_name.get(name).copied()
        });
        let to = &mut self.spec.components[c].services[own];
        let state = &mut self.components[c].services[own];
        if let Some(doc) = &service.doc {
            join_doc(&mut to.doc, doc);
        }
        union(&mut to.throws, service.throws.iter().copied());
        union(&mut state.lists[0].names, theirs.lists[0].names.clone());
        let mut conflicts: Vec<(&'static str, Src, Src)> = Vec::new();
        let keeps_task = self.spec.release.has(Change::MergedProperties);
        let mut kept_task = false;
        for word in ["task", "before", "after"] {
            let Some(&place) = theirs.given.get(word) else {
                continue;
            };
            if let Some(&ours) = state.given.get(word) {
                if word == "task" && keeps_task {
                    kept_task = true;
                    continue;
                }
                conflicts.push((word, place, ours));
                continue;
            }
            state.given.insert(word, at);
            match word {
                "task" => to.task = task,
                "before" => state.lists[1] = theirs.lists[1].clone(),
                _ => state.lists[2] = theirs.lists[2].clone(),
            }
        }
        if kept_task {
            self.newer(Change::MergedProperties, "a second `task` of an activity", at);
        }
        for (word, place, ours) in conflicts {
            self.report(
                Finding::new(
                    DeclarationProblem::ServicePropertyImported {
                        service: service.name.clone(),
                        word,
                    },
                    at,
                )
                .related(place, Role::InInterface)
                .related(ours, Role::Other),
            );
        }
    }
}
