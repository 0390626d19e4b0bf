//! The parameters and local variables of services, and the comparison of repeated declarations (language
//! reference, section 11.4).

use super::{AccessKind, DefId, DefKind, Entity, context::Elaborator, types, words};
use crate::finding::role::Role;
use crate::{
    finding::{Finding, services::DeclarationProblem},
    item_tree::{Declarator, ParamDecl, ParamSpec, PathStep, ServiceDecl, TypeRef},
    model::{ComponentId, Param, ParamDir, ParamSource, ServiceId, Src, TypeId, TypeKind},
    release::Change,
};

/// A new parameter, with the place of its definition.
pub(super) struct NewParam {
    pub(super) param: Param,
    pub(super) name_src: Src,
}

impl<'a> Elaborator<'a> {
    pub(super) fn service_params(
        &mut self,
        c: ComponentId,
        decl: &'a ServiceDecl,
    ) -> Vec<NewParam> {
        let mut params: Vec<NewParam> = Vec::with_capacity(decl.params.len());
        let mut native = None;
        for param in &decl.params {
            let Some(new) = self.service_param(c, param) else {
                continue;
            };
            if native.is_none() && types::has_native(&self.spec, new.param.ty) {
                native = Some((new.param.name.clone(), new.param.src));
            }
            if let Some(first) = params.iter().find(|param| param.param.name == new.param.name) {
                let diagnostic = Finding::new(
                    DeclarationProblem::ParamTwice {
                        what: "parameter",
                        name: new.param.name.clone(),
                    },
                    new.param.src,
                )
                .related(first.param.src, Role::First);
                self.report(diagnostic);
                continue;
            }
            params.push(new);
        }
        if let (Some((param, place)), Some(name)) = (native, &decl.name) {
            let at = self.src(name.ptr);

            let diagnostic = Finding::new(
                DeclarationProblem::NativeParam { param, service: name.text.clone() },
                at,
            )
            .related(place, Role::Parameter);
            self.report(diagnostic);
        }
        params
    }

    fn service_param(&mut self, c: ComponentId, decl: &'a ParamDecl) -> Option<NewParam> {
        let src = self.src(decl.ptr);
        let (mut param, name_src) = match &decl.spec {
            ParamSpec::Typed { ty, declarator } => {
                let base = self.type_ref(ty);
                let declarator = declarator.as_ref()?;
                let ty = self.declared_type(base, declarator);
                let ty = self.data_type(ty, &declarator.name.text, src);
                let param = Param {
                    name: declarator.name.text.clone(),
                    src,
                    dir: decl.dir,
                    source: ParamSource::Local(None),
                    base: ty,
                    ty,
                    path: Vec::new(),
                    init: None,
                };
                (param, self.src(declarator.name.ptr))
            }
            ParamSpec::Path { path, rename, .. } => {
                let param = self.attribute_param(c, decl)?;
                let name = rename.as_deref().or_else(|| {
                    path.iter().rev().find_map(|step| match step {
                        PathStep::Member(name) => Some(name),
                        PathStep::Index(_) => None,
                    })
                });
                let name_src = name.map_or(src, |name| self.src(name.ptr));
                (param, name_src)
            }
        };
        if let Some(init) = &decl.init {
            param.init = self.initializer(init, param.ty);
        }
        Some(NewParam { param, name_src })
    }

    /// The type of a parameter or local variable, unless it is an object without data: a port, remote or
    /// event.
    fn data_type(&mut self, ty: TypeId, name: &str, at: Src) -> TypeId {
        let special = matches!(
            self.spec.ty(ty).kind,
            TypeKind::Port { .. }
                | TypeKind::Remote { .. }
                | TypeKind::Event
                | TypeKind::PauseEvent
        );
        if !special || !self.spec.release.has(Change::SpecialParameterTypes) {
            return ty;
        }
        // This error replaces the general one.
        self.retract("not-a-type");
        let kind = DeclarationProblem::SpecialParam {
            name: name.into(),
            what: words::describe(&self.spec, ty),
            ty: types::display(&self.spec, ty).into(),
        };
        let mut finding = Finding::new(kind, at);
        if let Some(place) = self.type_place(ty) {
            finding = finding.related(place, Role::Declared);
        }
        self.report(finding);
        self.unknown(at)
    }

    pub(super) fn add_param(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        param: Param,
        name_src: Src,
        node: Src,
        kind: DefKind,
    ) {
        let position = self.spec.components[c].services[service].params.len() as u32;
        let def = self.define(kind, &param.name, name_src, node, None);
        self.definitions[def].ty = Some(param.ty);
        self.set_entity(def, Entity::Param(c, service, position));
        self.push_param(c, service, param, def);
    }

    pub(super) fn push_param(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        param: Param,
        def: DefId,
    ) {
        self.spec.components[c].services[service].params.push(param);
        self.components[c].services[service].params.push(def);
    }

    /// Compares the parameters of a repeated declaration with those of the first.
    pub(super) fn merge_params(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        params: &[NewParam],
        at: Src,
    ) {
        for (position, new) in params.iter().enumerate() {
            let known = self.spec.components[c].services[service].params.get(position);
            let known = known.filter(|param| param.dir != ParamDir::Local);
            if known.is_some_and(|param| param.name == new.param.name)
                && let Some(&def) = self.components[c].services[service].params.get(position)
            {
                self.refer_as(new.name_src, def, AccessKind::Declaration);
            }
        }
        let params: Vec<&Param> = params.iter().map(|param| &param.param).collect();
        self.compare_params(c, service, &params, at, None);
    }

    /// Reports parameters that differ from those of the service. `at` is the second declaration; with
    /// `import`, problems are reported there.
    pub(super) fn compare_params(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        params: &[&Param],
        at: Src,
        import: Option<Src>,
    ) {
        let known = &self.spec.components[c].services[service];
        let expected: Vec<&Param> =
            known.params.iter().filter(|param| param.dir != ParamDir::Local).collect();
        let mut problems: Vec<Finding> = Vec::new();
        for (old, new) in expected.iter().zip(params) {
            let place = import.unwrap_or(new.src);
            if old.name != new.name {
                problems.push(
                    Finding::new(
                        DeclarationProblem::OtherName {
                            service: known.name.clone(),
                            old: old.name.clone(),
                            new: new.name.clone(),
                        },
                        place,
                    )
                    .related(old.src, Role::Earlier),
                );
            } else if let Some(kind) = self.conflict(old, new) {
                problems.push(Finding::new(kind, place).related(old.src, Role::Earlier));
            }
        }
        if let Some(extra) = params.get(expected.len()) {
            problems.push(
                Finding::new(
                    DeclarationProblem::ParamExtra {
                        service: known.name.clone(),
                        name: extra.name.clone(),
                    },
                    import.unwrap_or(extra.src),
                )
                .related(known.src, Role::Earlier),
            );
        }
        if let Some(missing) = expected.get(params.len()) {
            problems.push(
                Finding::new(
                    DeclarationProblem::ParamMissing {
                        service: known.name.clone(),
                        name: missing.name.clone(),
                    },
                    import.unwrap_or(at),
                )
                .related(missing.src, Role::MissingParameter),
            );
        }
        for problem in problems {
            self.report(problem);
        }
    }

    fn conflict(&self, old: &Param, new: &Param) -> Option<DeclarationProblem> {
        let name = new.name.clone();
        if old.dir != new.dir {
            return Some(DeclarationProblem::OtherDirection {
                name,
                old: old.dir.word(),
                new: new.dir.word(),
            });
        }
        (!types::equal(&self.spec, old.ty, new.ty)).then(|| DeclarationProblem::OtherType {
            name,
            old: types::display(&self.spec, old.ty).into(),
            new: types::display(&self.spec, new.ty).into(),
        })
    }

    /// Adds local variables, or compares them with existing ones of the same name.
    pub(super) fn locals(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        ty: &'a TypeRef,
        declarators: &'a [Declarator],
    ) {
        let base = self.type_ref(ty);
        for declarator in declarators {
            let src = self.src(declarator.name.ptr);
            let name = &declarator.name.text;
            let ty = self.declared_type(base, declarator);
            let ty = self.data_type(ty, name, src);
            let local = Param {
                name: name.clone(),
                src,
                dir: ParamDir::Local,
                source: ParamSource::Local(None),
                base: ty,
                ty,
                path: Vec::new(),
                init: None,
            };
            let here = &mut self.components[c].services[service].locals_here;
            let again = here.contains(name);
            here.push(name.clone());
            self.add_local(c, service, local, src, again);
        }
    }

    /// Adds a local variable of the service. `again`: the same declaration of the service already has a
    /// variable of its name.
    fn add_local(
        &mut self,
        c: ComponentId,
        service: ServiceId,
        local: Param,
        src: Src,
        again: bool,
    ) {
        let state = &self.components[c].services[service];
        let known = &self.spec.components[c].services[service];
        let position = known.params.iter().position(|param| param.name == local.name);
        let Some(position) = position else {
            self.add_param(c, service, local, src, src, DefKind::Local);
            return;
        };
        let old = &known.params[position];
        let def = state.params.get(position).copied();
        let place = old.src;
        // A variable from an earlier declaration of the service may be repeated.
        let same_declaration = again || old.dir != ParamDir::Local;
        if same_declaration {
            let what = if old.dir == ParamDir::Local { "local variable" } else { "parameter" };

            self.report(
                Finding::new(
                    DeclarationProblem::ParamTwice { what, name: local.name.clone() },
                    src,
                )
                .related(place, Role::First),
            );
            return;
        }
        if let Some(kind) = self.conflict(old, &local) {
            self.report(Finding::new(kind, src).related(place, Role::Earlier));
        }
        if let Some(def) = def {
            self.refer_as(src, def, AccessKind::Declaration);
        }
    }
}
