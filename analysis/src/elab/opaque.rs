//! Placeholders for unresolved parts, so that independent parts are still elaborated.

use super::{context::Elaborator, types::resolve_aliases};
use crate::{
    item_tree::{Name, ParamDecl, ParamSpec, Path, PathStep},
    model::{
        ComponentId, Gap, Missing, Name as Text, Param, ParamSource, PathElement, Scope, ScopeKind,
        ServiceId, SourceKind, Src, TypeId, TypeKind,
    },
    unit::is_standin,
};

impl<'a> Elaborator<'a> {
    /// Records an unresolved part.
    pub(super) fn record_unresolved(&mut self, missing: Missing) {
        let component = self.component;
        self.spec.gaps.push(Gap { component, missing });
    }

    /// Records a task or service that is not found and may come from an unknown interface.
    pub(super) fn lack_of(&mut self, c: ComponentId, missing: Missing) {
        let gap = Gap { component: Some(c), missing };
        if self.components[c].incomplete && !self.spec.gaps.contains(&gap) {
            self.spec.gaps.push(gap);
        }
    }

    /// A type of which only the name is known, most likely from a file that was not read.
    pub(super) fn opaque_type(&mut self, path: &Path, at: Src) -> TypeId {
        let id = self.unknown(at);
        if let Some((last, scopes)) = path.segments.split_last() {
            let module = |name: &Name| Scope { kind: ScopeKind::Module, name: name.text.clone() };
            let ty = &mut self.spec.types[id];
            ty.name = Some(last.text.clone());
            ty.scope = scopes.iter().map(module).collect();
        }
        id
    }

    /// A placeholder for a parameter of a codel that does not resolve: the function still has this parameter.
    /// Its type is named like the types of ports and remote services, since it may be one.
    pub(super) fn opaque_param(
        &mut self,
        c: ComponentId,
        service: Option<ServiceId>,
        decl: &ParamDecl,
    ) -> Option<Param> {
        let ParamSpec::Path { path, rename, source } = &decl.spec else {
            return None;
        };
        fn member(step: &PathStep) -> Option<&Name> {
            match step {
                PathStep::Member(name) => Some(name),
                PathStep::Index(_) => None,
            }
        }
        let (first, last) = (path.iter().find_map(member), path.iter().rev().find_map(member));
        // Members of the ids are named by their last name, everything else by the first.
        let whole = matches!(source, Some((known, _)) if *known != SourceKind::Ids)
            || first.is_some_and(|name| self.local_named(c, service, &name.text).is_some());
        let own = if whole { first } else { last };
        let name = rename.as_deref().or(own)?.text.clone();
        let src = self.src(decl.ptr);
        if let ParamSpec::Path { source, .. } = &decl.spec
            && let Some(first) = first
            && !self.is_source(c, service, &first.text)
        {
            let kind = source.map(|source| source.0);
            self.record_unresolved(Missing::Source {
                name: first.text.clone(),
                kind,
                dir: decl.dir,
                service,
            });
        }
        let scope = self.components[c].scope;
        let named = first.map_or_else(|| name.clone(), |name| name.text.clone());
        let ty = self.named(TypeKind::Unknown, scope, named, src);
        if let Some((name, scope)) = self.inside_unknown() {
            let ty = &mut self.spec.types[ty];
            (ty.name, ty.scope) = (Some(name), scope);
        }
        Some(Param {
            name,
            src,
            dir: decl.dir,
            source: ParamSource::Opaque,
            base: ty,
            ty,
            path: Vec::new(),
            init: None,
        })
    }

    /// Returns true if a component or service has an ids member, parameter, port or remote service of that
    /// name.
    fn is_source(&self, c: ComponentId, service: Option<ServiceId>, name: &Text) -> bool {
        let state = &self.components[c];
        self.ids_member(c, name).is_some()
            || self.local_named(c, service, name).is_some()
            || state.port_by_name.contains_key(name)
            || state.remote_by_name.contains_key(name)
    }

    /// Returns true if a type is declared by a stand-in, with unknown members.
    pub(super) fn is_from_stand_in(&self, ty: TypeId) -> bool {
        let last = resolve_aliases(&self.spec, ty);
        let visit = self.visits.get(self.spec.ty(last).src.visit);
        visit.is_some_and(|visit| is_standin(visit.path.as_ref()))
    }

    /// Records the use of a member of an unknown type.
    pub(super) fn lack_member(&mut self, ty: TypeId, rest: &'a [PathStep]) {
        let Some(of) = self.spec.full_name(ty) else {
            return;
        };
        let path = rest.iter().map(|step| match step {
            PathStep::Member(name) => PathElement::Member(name.text.clone()),
            PathStep::Index(_) => PathElement::Index(0),
        });
        let path = path.collect();
        self.record_unresolved(Missing::Member { of: of.into(), path });
    }

    /// Name and scope for a type inside of an unknown one, if the last recorded gap was such a type.
    fn inside_unknown(&self) -> Option<(Text, Vec<Scope>)> {
        let Some(Missing::Member { of, path }) = self.spec.gaps.last().map(|gap| &gap.missing)
        else {
            return None;
        };
        let (outer, own) = of.rsplit_once("::").unwrap_or(("", of));
        let mut name = own.to_owned();
        for element in path {
            match element {
                PathElement::Member(member) => name = format!("{name}_{member}"),
                PathElement::Index(_) => name.push_str("_element"),
            }
        }
        let scopes = outer.split("::").filter(|part| !part.is_empty());
        let scopes = scopes.map(|scope| Scope { kind: ScopeKind::Module, name: scope.into() });
        Some((name.into(), scopes.collect()))
    }
}
