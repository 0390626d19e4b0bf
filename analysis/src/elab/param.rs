//! Parameters of codels and attributes: the data they name (language reference, sections 11.1 and 12).

mod path;

use super::{AccessKind, DefId, DefKind, context::Elaborator};
use crate::finding::role::Role;
use crate::{
    finding::{Finding, codels::CodelProblem},
    item_tree::{Name, ParamDecl, ParamSpec, PathStep},
    model::{
        CodelKind, ComponentId, Name as Text, Param, ParamDir, ParamSource, PathElement, PortDir,
        PortId, RemoteId, ServiceId, SourceKind, Src, TypeId, TypeKind,
    },
};
use smol_str::SmolStr;

/// The access of a codel to the data of a parameter.
fn codel_access(dir: ParamDir) -> AccessKind {
    match dir {
        ParamDir::In | ParamDir::Local => AccessKind::Read,
        ParamDir::Out => AccessKind::Write,
        ParamDir::Inout => AccessKind::ReadWrite,
    }
}

/// The access of an attribute to the ids: an `in` parameter is sent by the client (language reference, 11.1).
fn attribute_access(dir: ParamDir) -> AccessKind {
    match dir {
        ParamDir::In | ParamDir::Local => AccessKind::Write,
        ParamDir::Out => AccessKind::Read,
        ParamDir::Inout => AccessKind::ReadWrite,
    }
}

/// The meaning of the first name of a path.
#[derive(Debug, Clone, Copy)]
enum Target {
    /// A member of the ids.
    Ids(TypeId),
    /// A parameter or local variable of the service, by index.
    Local(u32),
    Port(PortId),
    Remote(RemoteId),
}

impl Target {
    fn describe(self) -> &'static str {
        match self {
            Self::Ids(_) => "a member of the ids",
            Self::Local(_) => "a parameter of the service",
            Self::Port(_) => "a port",
            Self::Remote(_) => "a remote service",
        }
    }

    fn keyword(self) -> &'static str {
        match self {
            Self::Ids(_) => "ids",
            Self::Local(_) => "local",
            Self::Port(_) => "port",
            Self::Remote(_) => "remote",
        }
    }
}

/// The parts of a parameter given as a path.
struct PathParts<'a> {
    decl: &'a ParamDecl,
    first: &'a Name,
    rest: &'a [PathStep],
    rename: Option<&'a Name>,
    access: AccessKind,
    at: Src,
}

impl<'a> Elaborator<'a> {
    /// A parameter of a codel; `None` if it does not resolve, which was reported.
    pub(super) fn codel_param(
        &mut self,
        c: ComponentId,
        service: Option<ServiceId>,
        decl: &'a ParamDecl,
        kind: CodelKind,
    ) -> Option<Param> {
        let ParamSpec::Path { source, path, rename } = &decl.spec else {
            return None;
        };
        let at = self.src(decl.ptr);
        let rename = rename.as_deref();
        let Some((PathStep::Member(first), rest)) = path.split_first() else {
            let rename = rename?;
            if let Some((source, _)) = source
                && *source != SourceKind::Ids
            {
                let what = match source {
                    SourceKind::Local => "a parameter or local variable",
                    SourceKind::Port => "a port",
                    _ => "a remote service",
                };

                self.error(at, CodelProblem::WholeIds { name: rename.text.clone(), what });
                return None;
            }
            return self.whole_ids(c, decl, rename, codel_access(decl.dir));
        };
        let written = PathParts { decl, first, rest, rename, access: codel_access(decl.dir), at };
        let target = match source {
            Some((source, _)) => self.explicit_target(c, service, *source, &written)?,
            None => self.implicit_target(c, service, &written)?,
        };
        match target {
            Target::Ids(member) => self.ids_param(c, member, &written),
            Target::Local(local) => self.local_param(c, service?, local, &written, kind),
            Target::Port(port) => self.port_param(c, port, &written),
            Target::Remote(remote) => self.remote_param(c, remote, &written),
        }
    }

    /// A parameter of an attribute: a path into the ids.
    pub(super) fn attribute_param(&mut self, c: ComponentId, decl: &'a ParamDecl) -> Option<Param> {
        let ParamSpec::Path { path, rename, .. } = &decl.spec else {
            return None;
        };
        let at = self.src(decl.ptr);
        let rename = rename.as_deref();
        let Some((PathStep::Member(first), rest)) = path.split_first() else {
            return self.whole_ids(c, decl, rename?, attribute_access(decl.dir));
        };
        let written =
            PathParts { decl, first, rest, rename, access: attribute_access(decl.dir), at };
        let Target::Ids(member) = self.explicit_target(c, None, SourceKind::Ids, &written)? else {
            return None;
        };
        self.ids_param(c, member, &written)
    }

    // The meaning of a name

    pub(super) fn ids_member(&self, c: ComponentId, name: &str) -> Option<TypeId> {
        let scope = self.components[c].ids?;
        let member = *self.scopes.get(scope).names.get(name)?;
        matches!(self.spec.ty(member).kind, TypeKind::StructMember { .. }).then_some(member)
    }

    pub(super) fn local_named(
        &self,
        c: ComponentId,
        service: Option<ServiceId>,
        name: &str,
    ) -> Option<u32> {
        let service = &self.spec.components[c].services[service?];
        let found = service.params.iter().position(|param| param.name == name)?;
        Some(found as u32)
    }

    fn explicit_target(
        &mut self,
        c: ComponentId,
        service: Option<ServiceId>,
        source: SourceKind,
        written: &PathParts<'a>,
    ) -> Option<Target> {
        let name = &written.first.text;
        let state = &self.components[c];
        let component = &self.spec.components[c];
        let name = name.clone();
        let (found, kind) = match source {
            SourceKind::Ids => {
                if component.ids.is_none() {
                    self.report_no_ids(c, written.at);
                    return None;
                }
                let found = self.ids_member(c, &name).map(Target::Ids);
                (found, CodelProblem::UnknownMember { name: name.clone() })
            }
            SourceKind::Local => {
                let found = self.local_named(c, service, &name).map(Target::Local);
                (found, CodelProblem::UnknownLocal { name: name.clone() })
            }
            SourceKind::Port => {
                let found = state.port_by_name.get(&name).copied().map(Target::Port);
                (found, CodelProblem::UnknownPort { name: name.clone() })
            }
            SourceKind::Remote => {
                let found = state.remote_by_name.get(&name).copied();
                let kind = CodelProblem::UnknownRemote { name: name.clone() };
                (found.map(Target::Remote), kind)
            }
        };
        if found.is_none() && !self.is_excused(c, &name) {
            let candidates = self.sources(c, service, Some(source));
            let candidates = candidates.iter().map(SmolStr::as_str);
            let near = self.near(self.src(written.first.ptr), &name, candidates);

            self.unresolved(written.at, kind, near);
        }
        found
    }

    fn implicit_target(
        &mut self,
        c: ComponentId,
        service: Option<ServiceId>,
        written: &PathParts<'a>,
    ) -> Option<Target> {
        let name = &written.first.text;
        let state = &self.components[c];
        let mut found = [
            self.ids_member(c, name).map(Target::Ids),
            self.local_named(c, service, name).map(Target::Local),
            state.port_by_name.get(name).copied().map(Target::Port),
            state.remote_by_name.get(name).copied().map(Target::Remote),
        ]
        .into_iter()
        .flatten();
        match (found.next(), found.next()) {
            (Some(only), None) => Some(only),
            (Some(a), Some(b)) => {
                let diagnostic = Finding::new(
                    CodelProblem::Ambiguous {
                        name: name.clone(),
                        one: a.describe(),
                        other: b.describe(),
                        source: b.keyword(),
                        dir: written.decl.dir.word(),
                    },
                    written.at,
                );
                let places = [a, b].map(|target| self.target_def(c, service, target));
                let diagnostic = places
                    .into_iter()
                    .zip([a, b])
                    .filter_map(|(def, target)| Some((def?, target)))
                    .fold(diagnostic, |diagnostic, (def, target)| {
                        let place = self.definitions[def].src;
                        diagnostic.related(place, Role::Meaning(target.describe()))
                    });
                self.report(diagnostic);
                None
            }
            (None, _) if self.is_excused(c, name) => None,
            (None, _) => {
                let candidates = self.sources(c, service, None);
                let candidates = candidates.iter().map(SmolStr::as_str);
                let near = self.near(self.src(written.first.ptr), name, candidates);
                let places = match service {
                    Some(_) => {
                        "no member of the ids, no parameter of this service, no port and no remote \
                         service"
                    }
                    None => "no member of the ids, no port and no remote service",
                };

                self.unresolved(
                    written.at,
                    CodelProblem::Unknown { name: name.clone(), places },
                    near,
                );
                None
            }
        }
    }

    /// Every name that a parameter could use.
    fn sources(
        &self,
        c: ComponentId,
        service: Option<ServiceId>,
        only: Option<SourceKind>,
    ) -> Vec<Text> {
        let state = &self.components[c];
        let wanted = |source| only.is_none_or(|other| other == source);
        let mut names: Vec<Text> = Vec::new();
        if let Some(scope) = state.ids.filter(|_| wanted(SourceKind::Ids)) {
            names.extend(self.scopes.get(scope).names.keys().cloned());
        }
        if let Some(service) = service.filter(|_| wanted(SourceKind::Local)) {
            let service = &self.spec.components[c].services[service];
            names.extend(service.params.iter().map(|param| param.name.clone()));
        }
        if wanted(SourceKind::Port) {
            names.extend(state.port_by_name.keys().cloned());
        }
        if wanted(SourceKind::Remote) {
            names.extend(state.remote_by_name.keys().cloned());
        }
        names
    }

    fn target_def(
        &self,
        c: ComponentId,
        service: Option<ServiceId>,
        target: Target,
    ) -> Option<DefId> {
        let state = &self.components[c];
        match target {
            Target::Ids(member) => self.type_defs[member],
            Target::Local(local) => {
                let service = state.services.get(service?)?;
                service.params.get(local as usize).copied()
            }
            Target::Port(port) => state.ports.get(port).copied(),
            Target::Remote(remote) => state.remotes.get(remote).copied(),
        }
    }

    fn report_no_ids(&mut self, c: ComponentId, at: Src) {
        if self.components[c].incomplete {
            return;
        }
        let name = &self.spec.components[c].name;

        self.error(at, CodelProblem::NoIds { component: name.clone() });
    }

    // One function for each source

    fn whole_ids(
        &mut self,
        c: ComponentId,
        decl: &'a ParamDecl,
        rename: &'a Name,
        access: AccessKind,
    ) -> Option<Param> {
        let at = self.src(decl.ptr);
        let Some(ids) = self.spec.components[c].ids else {
            self.report_no_ids(c, at);
            return None;
        };
        if let Some(def) = self.type_defs[ids] {
            self.refer_as(self.src(rename.ptr), def, access);
        }
        Some(Param {
            name: rename.text.clone(),
            src: at,
            dir: decl.dir,
            source: ParamSource::Ids,
            base: ids,
            ty: ids,
            path: Vec::new(),
            init: None,
        })
    }

    fn ids_param(
        &mut self,
        c: ComponentId,
        member: TypeId,
        written: &PathParts<'a>,
    ) -> Option<Param> {
        let ids = self.spec.components[c].ids?;
        self.refer_target(c, None, Target::Ids(member), written);
        let mut path = vec![PathElement::Member(written.first.text.clone())];
        let ty = self.walk(self.spec.member_type(member), written, &mut path)?;
        let last = written.rest.iter().rev().find_map(|step| match step {
            PathStep::Member(name) => Some(name),
            PathStep::Index(_) => None,
        });
        let name = self.param_name(written, last.unwrap_or(written.first));
        Some(Param {
            name,
            src: written.at,
            dir: written.decl.dir,
            source: ParamSource::Ids,
            base: ids,
            ty,
            path,
            init: None,
        })
    }

    fn local_param(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        local: u32,
        written: &PathParts<'a>,
        kind: CodelKind,
    ) -> Option<Param> {
        self.refer_target(c, Some(service), Target::Local(local), written);
        let known = &self.spec.components[c].services[service];
        let known = &known.params[local as usize];
        let (base, dir, place) = (known.ty, known.dir, known.src);
        let mut path = Vec::new();
        let ty = self.walk(base, written, &mut path)?;
        // In a state machine, another state or a later turn may read the value.
        let is_lost = !matches!(kind, CodelKind::Validate | CodelKind::Fsm);
        if dir == ParamDir::In && written.decl.dir != ParamDir::In && is_lost {
            let diagnostic = Finding::new(
                CodelProblem::WritesInput { name: written.first.text.clone() },
                written.at,
            )
            .related(place, Role::Parameter);
            self.report(diagnostic);
        }
        let name = self.param_name(written, written.first);
        Some(Param {
            name,
            src: written.at,
            dir: written.decl.dir,
            source: ParamSource::Local(Some(local)),
            base,
            ty,
            path,
            init: None,
        })
    }

    fn port_param(
        &mut self,
        c: ComponentId,
        port: PortId,
        written: &PathParts<'a>,
    ) -> Option<Param> {
        self.refer_target(c, None, Target::Port(port), written);
        let known = &self.spec.components[c].ports[port];
        let (dir, data, place) = (known.dir, known.data, known.src);
        let name = &written.first.text;
        if !written.rest.is_empty() {
            self.error(written.at, CodelProblem::PortMember { name: name.clone() });
            return None;
        }
        match (dir, written.decl.dir) {
            (PortDir::In, ParamDir::Out) => {
                let diagnostic =
                    Finding::new(CodelProblem::WritesInputPort { name: name.clone() }, written.at)
                        .related(place, Role::Port);
                self.report(diagnostic);
            }
            (PortDir::In, ParamDir::Inout) => {
                let diagnostic =
                    Finding::new(CodelProblem::InoutInputPort { name: name.clone() }, written.at)
                        .related(place, Role::Port);
                self.report(diagnostic);
            }
            _ => {}
        }
        let name = self.param_name(written, written.first);
        Some(Param {
            name,
            src: written.at,
            dir: written.decl.dir,
            source: ParamSource::Port(port),
            base: data,
            ty: data,
            path: Vec::new(),
            init: None,
        })
    }

    fn remote_param(
        &mut self,
        c: ComponentId,
        remote: RemoteId,
        written: &PathParts<'a>,
    ) -> Option<Param> {
        self.refer_target(c, None, Target::Remote(remote), written);
        let ty = self.spec.components[c].remotes[remote].ty;
        let name = &written.first.text;
        if !written.rest.is_empty() {
            self.error(written.at, CodelProblem::RemoteMember { name: name.clone() });
            return None;
        }
        if written.decl.dir != ParamDir::In {
            self.error(written.at, CodelProblem::RemoteDirection { name: name.clone() });
        }
        let name = self.param_name(written, written.first);
        Some(Param {
            name,
            src: written.at,
            dir: ParamDir::In,
            source: ParamSource::Remote(remote),
            base: ty,
            ty,
            path: Vec::new(),
            init: None,
        })
    }

    fn refer_target(
        &mut self,
        c: ComponentId,
        service: Option<ServiceId>,
        target: Target,
        written: &PathParts<'a>,
    ) {
        if let Some(def) = self.target_def(c, service, target) {
            let at = self.src(written.first.ptr);
            self.refer_as(at, def, written.access);
        }
    }

    /// The name of a parameter, after renaming.
    fn param_name(&mut self, written: &PathParts<'a>, default: &Name) -> Text {
        let Some(rename) = written.rename else {
            return default.text.clone();
        };
        if self.importing.is_none() {
            let at = self.src(rename.ptr);
            self.define(DefKind::CodelParameter, &rename.text, at, written.at, None);
        }
        rename.text.clone()
    }
}
