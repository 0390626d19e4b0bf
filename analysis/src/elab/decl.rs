//! Modules, constants and type declarations (language reference, sections 4.1, 4.2, 5 and 6).

use super::{
    AccessKind, DefId, DefKind,
    context::{Elaborator, ForwardDeclaration},
    convert::{convert, explain_misfit},
    scope::{Clash, ScopeId},
    types,
    value::Const,
};
use crate::finding::role::Role;
use crate::{
    finding::{
        Finding,
        names::NameProblem,
        values::{Purpose, ValueProblem},
    },
    item_tree::{
        ConstDecl, Declarator, ExceptionDecl, Item, Name, Ptr, TypeDecl, TypeDeclKind, TypeRef,
    },
    model::{ScopeKind, Src, TypeId, TypeKind},
};

impl<'a> Elaborator<'a> {
    /// A statement at the top of a specification.
    pub(super) fn statement(&mut self, item: &'a Item) {
        match item {
            Item::Component { interface, name: Some(name), body, ptr } => {
                self.component(*interface, name, body.as_deref(), *ptr);
            }
            _ => {
                self.idl_statement(item);
            }
        }
    }

    /// A statement that may stand in modules and components too. Returns true if it was one.
    pub(super) fn idl_statement(&mut self, item: &'a Item) -> bool {
        match item {
            Item::Module { name: Some(name), items, ptr } => self.module(name, items, *ptr),
            Item::Const(decl) => self.const_decl(decl),
            Item::Typedef { ty, declarators, ptr } => self.typedef(ty, declarators, *ptr),
            Item::Native { name: Some(name), ptr } => {
                self.new_type(TypeKind::Native, DefKind::Native, name, *ptr);
            }
            Item::Exceptions { exceptions, ptr } => {
                for exception in exceptions {
                    self.exception(exception, *ptr);
                }
            }
            Item::Type(decl) => {
                self.type_decl(decl);
            }
            Item::Forward { union, name: Some(name), ptr } => self.forward(name, *ptr, *union),
            Item::Pragma(pragma) => self.pragma(pragma),
            _ => return false,
        }
        true
    }

    fn module(&mut self, name: &'a Name, items: &'a [Item], ptr: Ptr) {
        let at = self.src(name.ptr);
        let scope = self.open_module(name, DefKind::Module, at, self.src(ptr));
        let def = self.scopes.get(scope).def;
        self.within(scope, def, |this| {
            this.for_each(items, |this, item| {
                this.idl_statement(item);
            });
        });
    }

    /// The scope of a module, component or interface: the existing one, or a new one.
    pub(super) fn open_module(
        &mut self,
        name: &Name,
        kind: DefKind,
        at: Src,
        node: Src,
    ) -> ScopeId {
        let data = self.scopes.get(self.scope);
        let existing = data.children.get(&name.text).copied();
        let clash = self.scopes.clash(self.scope, &name.text, true);
        if let (Some(Clash::Scope(_)), Some(scope)) = (clash, existing) {
            let is_module = self.scopes.get(scope).kind == ScopeKind::Module;
            let def = self.scopes.get(scope).def;
            if is_module && let Some(def) = def {
                let known = self.definitions[def].kind;
                if kind == DefKind::Module || known == kind {
                    self.refer_as(at, def, AccessKind::Declaration);
                } else if known == DefKind::Module {
                    // A component whose scope is that of an existing module.
                    let new = self.define(kind, &name.text, at, node, None);
                    self.scopes.get_mut(scope).def = Some(new);
                }
                return scope;
            }
        }
        if let Some(clash) = clash {
            self.report_clash(self.scope, &name.text, at, clash);
        }
        let def = self.define(kind, &name.text, at, node, None);
        self.scopes.open(self.scope, &name.text, ScopeKind::Module, Some(def), clash.is_some())
    }

    fn const_decl(&mut self, decl: &'a ConstDecl) {
        let ty = self.type_ref(&decl.ty);
        let value = self.eval(&decl.value);
        let Some(name) = &decl.name else { return };
        let at = self.src(name.ptr);
        let kind = if value == Const::Unknown || self.is_unknown(ty) {
            TypeKind::Unknown
        } else {
            match convert(&self.spec, &value, ty) {
                Ok(converted) => {
                    self.check_string_length(&value, ty, self.src(decl.value.ptr));
                    TypeKind::Const { ty, value: converted }
                }
                Err(misfit) => {
                    let diagnostic = Finding::new(
                        explain_misfit(
                            &self.spec,
                            misfit,
                            &value,
                            ty,
                            Purpose::Constant(name.text.clone()),
                        ),
                        at,
                    );
                    self.report(diagnostic);
                    TypeKind::Unknown
                }
            }
        };
        let id = self.named(kind, self.scope, name.text.clone(), at);
        self.define(DefKind::Const, &name.text, at, self.src(decl.ptr), Some(id));
        self.declare(self.scope, name, id);
    }

    /// Warns about a string constant longer than the bound of its type.
    pub(super) fn check_string_length(&mut self, value: &Const, ty: TypeId, at: Src) {
        let last = types::resolve_aliases(&self.spec, ty);
        if let (Const::Str(text), TypeKind::String { bound: Some(bound) }) =
            (value, &self.spec.ty(last).kind)
            && text.len() as u64 > *bound
        {
            self.error(at, ValueProblem::StringTooLong { length: text.len(), bound: *bound });
        }
    }

    fn typedef(&mut self, ty: &'a TypeRef, declarators: &'a [Declarator], ptr: Ptr) {
        let base = self.type_ref(ty);
        for declarator in declarators {
            let ty = self.declared_type(base, declarator);
            self.new_type(TypeKind::Typedef { ty }, DefKind::Typedef, &declarator.name, ptr);
        }
    }

    /// Creates and declares a named type without scope of its own.
    fn new_type(&mut self, kind: TypeKind, def: DefKind, name: &Name, ptr: Ptr) -> TypeId {
        let at = self.src(name.ptr);
        let id = self.named(kind, self.scope, name.text.clone(), at);
        self.define(def, &name.text, at, self.src(ptr), Some(id));
        self.declare(self.scope, name, id);
        id
    }

    fn forward(&mut self, name: &Name, ptr: Ptr, union: bool) {
        let at = self.src(name.ptr);
        if let Some(&previous) = self.scopes.get(self.scope).names.get(&name.text) {
            let same = match self.spec.ty(previous).kind {
                TypeKind::ForwardStruct { .. } => !union,
                TypeKind::ForwardUnion { .. } => union,
                _ => false,
            };
            if same {
                if let Some(def) = self.type_defs[previous] {
                    self.refer_as(at, def, AccessKind::Declaration);
                }
                return;
            }
        }
        let (kind, def) = if union {
            (TypeKind::ForwardUnion { definition: None }, DefKind::Union)
        } else {
            (TypeKind::ForwardStruct { definition: None }, DefKind::Struct)
        };
        let id = self.new_type(kind, def, name, ptr);
        let declared = self.scopes.get(self.scope).names.get(&name.text) == Some(&id);
        self.forwards.push(ForwardDeclaration { ty: id, file: self.file(), excused: !declared });
    }

    /// A struct, union or enum with its body, as a statement or inline.
    pub(super) fn type_decl(&mut self, decl: &'a TypeDecl) -> TypeId {
        let Some(name) = &decl.name else {
            return self.unknown(self.src(decl.ptr));
        };
        let node = self.src(decl.ptr);
        match &decl.kind {
            TypeDeclKind::Enum { enumerators } => self.enumeration(name, enumerators, node),
            TypeDeclKind::Struct { members } => {
                let inside = self.open_type(name, ScopeKind::Struct, DefKind::Struct, node);
                let members = self.within(inside.scope, Some(inside.def), |this| {
                    this.members(members, DefKind::Member)
                });
                self.close_type(name, &inside, TypeKind::Struct { members })
            }
            TypeDeclKind::Union { switch, cases } => self.union(name, switch, cases, node),
        }
    }

    fn exception(&mut self, decl: &'a ExceptionDecl, ptr: Ptr) {
        let node = self.src(ptr);
        let inside = self.open_type(&decl.name, ScopeKind::Exception, DefKind::Exception, node);
        let members = self.within(inside.scope, Some(inside.def), |this| {
            this.members(&decl.members, DefKind::Member)
        });
        self.close_type(&decl.name, &inside, TypeKind::Exception { members });
    }

    /// Opens the scope of a struct, union or exception.
    pub(super) fn open_type(
        &mut self,
        name: &Name,
        kind: ScopeKind,
        def_kind: DefKind,
        node: Src,
    ) -> OpenBody {
        let at = self.src(name.ptr);
        let mut completes = None;
        let mut clash = self.scopes.clash(self.scope, &name.text, true);
        if let Some(Clash::Name(previous)) = clash {
            let matching = match self.spec.ty(previous).kind {
                TypeKind::ForwardStruct { .. } => kind == ScopeKind::Struct,
                TypeKind::ForwardUnion { .. } => kind == ScopeKind::Union,
                _ => false,
            };
            let file = self.file();
            if matching && let Some(forward) = self.forward_of(previous) {
                let same_file = forward.file == file;
                completes = Some(previous);
                clash = None;
                if !same_file {
                    let place = types::place(&self.spec, previous);

                    self.report(
                        Finding::new(NameProblem::DefinedElsewhere { name: name.text.clone() }, at)
                            .related(place, Role::Declared),
                    );
                }
            }
        }
        if let Some(clash) = clash {
            self.report_clash(self.scope, &name.text, at, clash);
        }
        let known = completes.and_then(|ty| self.type_defs[ty]);
        let def = match known {
            Some(def) => {
                let definition = &mut self.definitions[def];
                let earlier = std::mem::replace(&mut definition.src, at);
                definition.node = node;
                self.refer_as(earlier, def, AccessKind::Declaration);
                def
            }
            None => self.define(def_kind, &name.text, at, node, None),
        };
        // If the name is not taken, it is recorded for its uses.
        let declared = matches!(clash, None | Some(Clash::Enclosing));
        let scope = self.scopes.open(self.scope, &name.text, kind, Some(def), !declared);
        OpenBody { scope, def, at, completes, declared }
    }

    /// Creates the type whose scope [`Self::open_type`] opened.
    pub(super) fn close_type(&mut self, name: &Name, inside: &OpenBody, kind: TypeKind) -> TypeId {
        let id = self.named(kind, self.scope, name.text.clone(), inside.at);
        self.type_defs[id] = Some(inside.def);
        self.definitions[inside.def].ty = Some(id);
        if let Some(forward) = inside.completes
            && let TypeKind::ForwardStruct { definition } | TypeKind::ForwardUnion { definition } =
                &mut self.spec.types[forward].kind
        {
            *definition = Some(id);
        }
        if inside.declared {
            let names = &mut self.scopes.get_mut(self.scope).names;
            names.insert(name.text.clone(), id);
        }
        self.adopt(inside.scope, id);
        id
    }

    /// Makes `parent` the parent of the types declared in its scope.
    pub(super) fn adopt(&mut self, scope: ScopeId, parent: TypeId) {
        for &ty in self.scopes.get(scope).names.values() {
            let ty = &mut self.spec.types[ty];
            if matches!(
                ty.kind,
                TypeKind::Struct { .. }
                    | TypeKind::Union { .. }
                    | TypeKind::Enum { .. }
                    | TypeKind::Exception { .. }
            ) {
                ty.parent = Some(parent);
            }
        }
    }

    /// The members of a struct, exception or ids, in the current scope.
    pub(super) fn members(&mut self, items: &'a [Item], kind: DefKind) -> Vec<TypeId> {
        let mut members = Vec::new();
        self.for_each(items, |this, item| match item {
            Item::Member { ty, declarators, ptr } => {
                let base = this.type_ref(ty);
                for declarator in declarators {
                    let ty = this.declared_type(base, declarator);
                    let member = TypeKind::StructMember { ty };
                    let node = this.src(*ptr);
                    if let Some(id) = this.member(member, kind, &declarator.name, node) {
                        members.push(id);
                    }
                }
            }
            Item::Pragma(pragma) => this.pragma(pragma),
            _ => {}
        });
        members
    }

    pub(super) fn member(
        &mut self,
        kind: TypeKind,
        def: DefKind,
        name: &Name,
        node: Src,
    ) -> Option<TypeId> {
        let at = self.src(name.ptr);
        let scope = self.scope;
        // A member may have the name of its struct.
        if let Some(clash @ (Clash::Name(_) | Clash::Scope(_))) =
            self.scopes.clash(scope, &name.text, false)
        {
            self.report_clash(scope, &name.text, at, clash);
            return None;
        }
        let id = self.named(kind, scope, name.text.clone(), at);
        self.define(def, &name.text, at, node, Some(id));
        let names = &mut self.scopes.get_mut(scope).names;
        names.insert(name.text.clone(), id);
        Some(id)
    }

    fn enumeration(&mut self, name: &Name, enumerators: &'a [Name], node: Src) -> TypeId {
        let at = self.src(name.ptr);
        let def = self.define(DefKind::Enum, &name.text, at, node, None);
        // The enum follows its enumerators in the order of creation, but they refer to it.
        let id = TypeId::from(self.spec.types.len() + enumerators.len());
        let mut values = Vec::with_capacity(enumerators.len());
        for (value, enumerator) in (0..).zip(enumerators) {
            let at = self.src(enumerator.ptr);
            let kind = TypeKind::Enumerator { enumeration: id, value };
            let value = self.named(kind, self.scope, enumerator.text.clone(), at);
            let container = self.container.replace(def);
            self.define(DefKind::Enumerator, &enumerator.text, at, at, Some(value));
            self.container = container;
            self.declare(self.scope, enumerator, value);
            values.push(value);
        }
        let kind = TypeKind::Enum { enumerators: values };
        let created = self.named(kind, self.scope, name.text.clone(), at);
        debug_assert_eq!(created, id);
        self.type_defs[created] = Some(def);
        self.definitions[def].ty = Some(created);
        self.declare(self.scope, name, created);
        created
    }
}

/// A struct, union or exception whose body is being read.
pub(super) struct OpenBody {
    pub(super) scope: ScopeId,
    pub(super) def: DefId,
    at: Src,
    /// The forward declaration that it completes.
    completes: Option<TypeId>,
    /// True if its name was accepted.
    declared: bool,
}
