//! `uses`: makes the services of an interface remote services, including those that it uses itself.

use crate::finding::role::Role;
use crate::{
    elab::{DefId, context::Elaborator, property::union},
    finding::{Finding, names::NameProblem},
    model::{ComponentId, ParamDir, Remote, Src, TypeId, TypeKind},
    release::Change,
};

impl Elaborator<'_> {
    pub(super) fn import_as_remotes(&mut self, c: ComponentId, interface: ComponentId, at: Src) {
        let with_locals = self.spec.release.has(Change::RemoteCallsWithoutLocals);
        for number in self.components[interface].services.keys() {
            let from = &self.spec.components[interface];
            let service = &from.services[number];
            let mut throws = from.throws.clone();
            if let Some(task) = service.task {
                union(&mut throws, from.tasks[task].throws.iter().copied());
            }
            union(&mut throws, service.throws.iter().copied());
            let remote = Remote {
                name: service.name.clone(),
                src: service.src,
                kind: service.kind,
                params: service
                    .params
                    .iter()
                    .filter(|param| with_locals || param.dir != ParamDir::Local)
                    .cloned()
                    .collect(),
                ty: TypeId(0),
                interface,
                service: number,
                throws,
            };
            let def = self.components[interface].services[number].def;
            self.add_remote(c, remote, def, at);
        }
    }

    pub(super) fn import_remotes(&mut self, c: ComponentId, interface: ComponentId, at: Src) {
        for number in self.components[interface].remotes.keys() {
            let remote = self.spec.components[interface].remotes[number].clone();
            let def = self.components[interface].remotes[number];
            self.add_remote(c, remote, def, at);
        }
    }

    fn add_remote(&mut self, c: ComponentId, mut remote: Remote, def: DefId, at: Src) {
        let state = &self.components[c];
        if let Some(&service) = state.service_by_name.get(&remote.name) {
            let place = self.spec.components[c].services[service].src;
            self.report(
                Finding::new(NameProblem::RemoteTaken { name: remote.name.clone() }, at)
                    .related(place, Role::Service)
                    .related(remote.src, Role::RemoteService),
            );
            self.add_refused_name(c, &remote.name);
            return;
        }
        let scope = state.scope;
        if let Some(clash) = self.scopes.clash(scope, &remote.name, false) {
            self.report_clash(scope, &remote.name, at, clash);
            self.add_refused_name(c, &remote.name);
            return;
        }
        let number = self.spec.components[c].remotes.next_key();
        let kind = TypeKind::Remote { component: c, remote: number };
        let ty = self.named(kind, scope, remote.name.clone(), remote.src);
        self.type_defs[ty] = Some(def);
        self.declare_at(scope, &remote.name, at, ty);
        remote.ty = ty;
        let state = &mut self.components[c];
        state.remote_by_name.insert(remote.name.clone(), number);
        state.remotes.push(def);
        self.spec.components[c].remotes.push(remote);
    }
}
