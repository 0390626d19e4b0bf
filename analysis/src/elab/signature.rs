//! The parameters and local variables of services, and how repeated declarations compare (language
//! reference, section 11.4).

use super::{
    Access, DefId, DefKind, ElabDiagnostic, Entity,
    context::Elaborator,
    param::{dir_text, direction},
    types,
};
use crate::{
    item_tree::{Declarator, ParamDecl, ParamSpec, PathStep, ServiceDecl, TypeRef},
    release::Change,
    model::{Param, ParamDir, ParamSource, Src, TypeId, TypeKind},
};

/// A parameter just read, with its definition's place.
pub(super) struct NewParam {
    pub(super) param: Param,
    pub(super) name_src: Src,
}

impl<'a> Elaborator<'a> {
    pub(super) fn service_params(&mut self, index: u32, decl: &'a ServiceDecl) -> Vec<NewParam> {
        let mut params: Vec<NewParam> = Vec::with_capacity(decl.params.len());
        let mut native = None;
        for param in &decl.params {
            let Some(new) = self.service_param(index, param) else {
                continue;
            };
            if native.is_none() && types::has_native(&self.spec, new.param.ty) {
                native = Some((new.param.name.clone(), new.param.src));
            }
            if let Some(first) = params.iter().find(|it| it.param.name == new.param.name) {
                let message = format!("a parameter called `{}` exists already", new.param.name);
                let diagnostic = ElabDiagnostic::new("param-duplicate", new.param.src, message)
                    .related(first.param.src, "the first one");
                self.report(diagnostic);
                continue;
            }
            params.push(new);
        }
        if let (Some((param, place)), Some(name)) = (native, &decl.name) {
            let at = self.src(name.ptr);
            let message = format!(
                "parameter `{param}` of `{}` holds a native type; native data stays inside a \
                 component (local variables and ids may hold it)",
                name.text
            );
            let diagnostic =
                ElabDiagnostic::new("service-native", at, message).related(place, "the parameter");
            self.report(diagnostic);
        }
        params
    }

    fn service_param(&mut self, index: u32, decl: &'a ParamDecl) -> Option<NewParam> {
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
                    dir: direction(decl.dir),
                    source: ParamSource::Local(None),
                    base: ty,
                    ty,
                    path: Vec::new(),
                    init: None,
                };
                (param, self.src(declarator.name.ptr))
            }
            ParamSpec::Path { path, rename, .. } => {
                let param = self.attribute_param(index, decl)?;
                let name = rename.as_ref().or_else(|| {
                    path.iter().rev().find_map(|it| match it {
                        PathStep::Member(name) => Some(name),
                        PathStep::Index(_) => None,
                    })
                });
                let name_src = name.map_or(src, |it| self.src(it.ptr));
                (param, name_src)
            }
        };
        if let Some(init) = &decl.init {
            param.init = self.initializer(init, param.ty);
        }
        Some(NewParam { param, name_src })
    }

    /// The type of a parameter or local variable, unless it is something that holds no data: a port, remote or event
    /// itself.
    fn data_type(&mut self, ty: TypeId, name: &str, at: Src) -> TypeId {
        let special = matches!(
            self.spec.ty(ty).kind,
            TypeKind::Port { .. } | TypeKind::Remote { .. } | TypeKind::Event | TypeKind::PauseEvent
        );
        if !special || !self.spec.release.has(Change::SpecialParameterTypes) {
            return ty;
        }
        let what = types::describe(&self.spec, ty);
        let message = format!(
            "`{name}` cannot be {what}: `{}` holds no data; use the type of its data",
            types::display(&self.spec, ty)
        );
        let mut diagnostic = ElabDiagnostic::new("param-special", at, message);
        if let Some(place) = self.type_place(ty) {
            diagnostic = diagnostic.related(place, "declared here");
        }
        self.report(diagnostic);
        self.unknown(at)
    }

    pub(super) fn add_param(
        &mut self,
        index: u32,
        service: u32,
        param: Param,
        name_src: Src,
        node: Src,
        kind: DefKind,
    ) {
        let position = self.spec.components[index as usize].services[service as usize]
            .params
            .len() as u32;
        let def = self.define(kind, &param.name, name_src, node, None);
        self.definitions[def.0 as usize].ty = Some(param.ty);
        self.set_entity(def, Entity::Param(index, service, position));
        self.push_param(index, service, param, def);
    }

    pub(super) fn push_param(&mut self, index: u32, service: u32, param: Param, def: DefId) {
        let (c, s) = (index as usize, service as usize);
        self.spec.components[c].services[s].params.push(param);
        self.components[c].services[s].params.push(def);
    }

    /// Compares the parameters of a repeated declaration with those of the first.
    pub(super) fn merge_params(&mut self, index: u32, service: u32, params: &[NewParam], at: Src) {
        let (c, s) = (index as usize, service as usize);
        for (position, new) in params.iter().enumerate() {
            let known = self.spec.components[c].services[s].params.get(position);
            let known = known.filter(|it| it.dir != ParamDir::Local);
            if known.is_some_and(|it| it.name == new.param.name)
                && let Some(&def) = self.components[c].services[s].params.get(position)
            {
                self.refer_as(new.name_src, def, Access::None, true);
            }
        }
        let params: Vec<&Param> = params.iter().map(|it| &it.param).collect();
        self.compare_params(index, service, &params, at, None);
    }

    /// Reports where parameters differ from those that the service has. `at` is the second
    /// declaration; with `import`, problems are reported there.
    pub(super) fn compare_params(
        &mut self,
        index: u32,
        service: u32,
        params: &[&Param],
        at: Src,
        import: Option<Src>,
    ) {
        let known = &self.spec.components[index as usize].services[service as usize];
        let expected: Vec<&Param> = known
            .params
            .iter()
            .filter(|it| it.dir != ParamDir::Local)
            .collect();
        let mut problems: Vec<ElabDiagnostic> = Vec::new();
        for (old, new) in expected.iter().zip(params) {
            let place = import.unwrap_or(new.src);
            if old.name != new.name {
                let message = format!(
                    "`{}` was declared before with parameter `{}` in this place, not `{}`",
                    known.name, old.name, new.name
                );
                problems.push(
                    ElabDiagnostic::new("service-param-name", place, message)
                        .related(old.src, "the earlier declaration"),
                );
            } else if let Some(message) = self.conflict(old, new) {
                problems.push(
                    ElabDiagnostic::new("service-param-conflict", place, message)
                        .related(old.src, "the earlier declaration"),
                );
            }
        }
        if let Some(extra) = params.get(expected.len()) {
            let message = format!(
                "`{}` was declared before without parameter `{}`",
                known.name, extra.name
            );
            problems.push(
                ElabDiagnostic::new("service-param-extra", import.unwrap_or(extra.src), message)
                    .related(known.src, "the earlier declaration"),
            );
        }
        if let Some(missing) = expected.get(params.len()) {
            let message = format!(
                "`{}` was declared before with parameter `{}`, which is missing here; repeat all \
                 parameters",
                known.name, missing.name
            );
            problems.push(
                ElabDiagnostic::new("service-param-missing", import.unwrap_or(at), message)
                    .related(missing.src, "the missing parameter"),
            );
        }
        for problem in problems {
            self.report(problem);
        }
    }

    fn conflict(&self, old: &Param, new: &Param) -> Option<String> {
        if old.dir != new.dir {
            return Some(format!(
                "`{}` was declared before as `{}`, not `{}`",
                new.name,
                dir_text(old.dir),
                dir_text(new.dir)
            ));
        }
        (!types::equal(&self.spec, old.ty, new.ty)).then(|| {
            format!(
                "`{}` was declared before with type `{}`, not `{}`",
                new.name,
                types::display(&self.spec, old.ty),
                types::display(&self.spec, new.ty)
            )
        })
    }

    /// Adds local variables, or compares them with those of the same name.
    pub(super) fn locals(
        &mut self,
        index: u32,
        service: u32,
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
            let here = &mut self.components[index as usize].services[service as usize].locals_here;
            let again = here.contains(name);
            here.push(name.clone());
            self.add_local(index, service, local, src, again);
        }
    }

    /// Adds a local variable of the service. `again`: one of the same declaration of
    /// the service has its name.
    fn add_local(&mut self, index: u32, service: u32, local: Param, src: Src, again: bool) {
        let state = &self.components[index as usize].services[service as usize];
        let known = &self.spec.components[index as usize].services[service as usize];
        let position = known.params.iter().position(|it| it.name == local.name);
        let Some(position) = position else {
            self.add_param(index, service, local, src, src, DefKind::Local);
            return;
        };
        let old = &known.params[position];
        let def = state.params.get(position).copied();
        let place = old.src;
        // A variable that an earlier declaration of the service has may be repeated.
        let same_declaration = again || old.dir != ParamDir::Local;
        if same_declaration {
            let what = if old.dir == ParamDir::Local {
                "local variable"
            } else {
                "parameter"
            };
            let message = format!("a {what} called `{}` exists already", local.name);
            self.report(
                ElabDiagnostic::new("param-duplicate", src, message)
                    .related(place, "the first one"),
            );
            return;
        }
        if let Some(message) = self.conflict(old, &local) {
            self.report(
                ElabDiagnostic::new("service-param-conflict", src, message)
                    .related(place, "the earlier declaration"),
            );
        }
        if let Some(def) = def {
            self.refer_as(src, def, Access::None, true);
        }
    }
}
