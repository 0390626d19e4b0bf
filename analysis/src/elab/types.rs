//! Types where they are used, and the relations between types (language reference, section 6).

use crate::finding::role::Role;
use dotgen_syntax::suggestion::nearest_keyword;
use rustc_hash::FxHashSet;
use smol_str::SmolStr;

use super::{context::Elaborator, foreign, words};
use crate::{
    finding::{
        Finding, Near,
        names::{NameProblem, Noun, SearchedScope},
        values::ValueProblem,
    },
    item_tree::{Declarator, Expr, Name, Path, TypeRef, TypeRefKind},
    model::{Missing, Spec, Src, TypeId, TypeKind},
};

/// The place of use of a type, as far as forward declarations are concerned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TypeUse {
    /// The contents of the type must be known.
    Value,
    /// As the element of a sequence or optional.
    Element,
}

impl<'a> Elaborator<'a> {
    /// The type object of a type specifier.
    pub(super) fn type_ref(&mut self, ty: &'a TypeRef) -> TypeId {
        self.type_ref_for(ty, TypeUse::Value)
    }

    fn type_ref_for(&mut self, ty: &'a TypeRef, usage: TypeUse) -> TypeId {
        let at = self.src(ty.ptr);
        match &ty.kind {
            TypeRefKind::Base(base) => self.anonymous(base.clone(), at),
            TypeRefKind::String { bound } => {
                let bound = bound.as_ref().map(|bound| self.size(bound, "bound"));
                self.sized(bound, at, |bound| TypeKind::String { bound })
            }
            TypeRefKind::Sequence { element, bound } => {
                let element = self.type_ref_for(element, TypeUse::Element);
                let bound = bound.as_ref().map(|bound| self.size(bound, "bound"));
                self.sized(bound, at, |bound| TypeKind::Sequence { element, bound })
            }
            TypeRefKind::Optional { element } => {
                let element = self.type_ref_for(element, TypeUse::Element);
                self.anonymous(TypeKind::Optional { element }, at)
            }
            TypeRefKind::Fixed => {
                self.error(at, ValueProblem::FixedType);
                self.unknown(at)
            }
            TypeRefKind::Named(path) => self.named_type(path, usage),
            TypeRefKind::Inline(decl) => self.type_decl(decl),
            TypeRefKind::Missing => self.unknown(at),
        }
    }

    fn named_type(&mut self, path: &'a Path, usage: TypeUse) -> TypeId {
        let at = self.src(path.ptr);
        let Some(ty) = self.resolve_path(path) else {
            self.report_unresolved(path, true);
            self.record_unresolved(Missing::Name {
                name: words::path_text(path).into(),
                constant: false,
            });
            return self.opaque_type(path, at);
        };
        // The reference compiler accepts any type object of the name.
        if matches!(
            self.spec.ty(ty).kind,
            TypeKind::Const { .. }
                | TypeKind::Enumerator { .. }
                | TypeKind::Event
                | TypeKind::PauseEvent
                | TypeKind::Port { .. }
                | TypeKind::Remote { .. }
        ) {
            let what = words::describe(&self.spec, ty);
            let mut diagnostic = Finding::new(
                NameProblem::NotAType { path: words::path_text(path).into(), what },
                at,
            );
            if let Some(place) = self.type_place(ty) {
                diagnostic = diagnostic.related(place, Role::Declared);
            }
            self.report(diagnostic);
        }
        let last = self.resolve_alias(ty);
        match &self.spec.ty(last).kind {
            TypeKind::Exception { members } if members.is_empty() && usage == TypeUse::Value => {
                self.error(at, NameProblem::NoData { path: words::path_text(path).into() });
                self.unknown(at)
            }
            TypeKind::ForwardStruct { .. } | TypeKind::ForwardUnion { .. }
                if usage == TypeUse::Value =>
            {
                let mut diagnostic = Finding::new(
                    NameProblem::NotYetDefined { path: words::path_text(path).into() },
                    at,
                );
                if let Some(place) = self.type_place(last) {
                    diagnostic = diagnostic.related(place, Role::NotDefined);
                }
                self.report(diagnostic);
                self.unknown(at)
            }
            _ => ty,
        }
    }

    /// The type object that a path names, with its references recorded.
    pub(super) fn resolve_path(&mut self, path: &'a Path) -> Option<TypeId> {
        let names: Vec<_> = path.segments.iter().map(|segment| &segment.text).collect();
        // Members are found only by paths into values, and hide no other name.
        let wanted = |ty: TypeId| {
            !matches!(
                self.spec.ty(ty).kind,
                TypeKind::StructMember { .. } | TypeKind::UnionMember { .. }
            )
        };
        let (ty, through) = self.scopes.lookup(self.scope, path.absolute, &names, wanted)?;
        for (segment, scope) in path.segments.iter().zip(through) {
            if let Some(def) = self.scopes.get(scope).def {
                self.refer(self.src(segment.ptr), def);
            }
        }
        if let Some(last) = path.segments.last() {
            self.refer_type(self.src(last.ptr), ty);
        }
        Some(ty)
    }

    /// Reports a path that names nothing. `types`: a type is expected, not a constant.
    pub(super) fn report_unresolved(&mut self, path: &Path, types: bool) {
        let names: Vec<_> = path.segments.iter().map(|segment| &segment.text).collect();
        let Some(last) = path.segments.last() else {
            return;
        };
        let wanted = |kind: &TypeKind| match kind {
            TypeKind::Const { .. } | TypeKind::Enumerator { .. } => !types,
            TypeKind::Event
            | TypeKind::PauseEvent
            | TypeKind::Port { .. }
            | TypeKind::Remote { .. }
            | TypeKind::StructMember { .. }
            | TypeKind::UnionMember { .. } => false,
            _ => types,
        };
        let noun = if types { Noun::Type } else { Noun::Constant };
        let (scope, followed) = self.scopes.follow(self.scope, path.absolute, &names);
        let token = |index: usize| path.segments.get(index).map_or(path.ptr, |segment| segment.ptr);
        let path_text = words::path_text(path);
        let standard = foreign::standard_type(path_text.trim_start_matches("::"));
        let (kind, near) = if let Some(ty) = standard.filter(|_| types) {
            let path = path_text.into();
            (NameProblem::Standard { path, ty }, None)
        } else if followed + 1 < names.len() {
            let missing = names[followed];
            let inner = self.scopes.get(scope);
            let candidates = inner.children.keys().map(SmolStr::as_str);
            let near = self.near(self.src(token(followed)), missing, candidates);
            let inside = match followed {
                0 => SearchedScope::Here,
                _ => SearchedScope::Scope(names[followed - 1].clone()),
            };
            let kind = NameProblem::UnknownScope {
                path: words::path_text(path).into(),
                noun,
                missing: missing.clone(),
                inside,
            };
            (kind, near)
        } else if names.len() > 1 || path.absolute {
            let inner = self.scopes.get(scope);
            let candidates = inner
                .names
                .iter()
                .filter(|(_, ty)| wanted(&self.spec.ty(**ty).kind))
                .map(|(name, _)| name.as_str());
            let near = self.near(self.src(last.ptr), &last.text, candidates);
            let path = words::path_text(path).into();
            (NameProblem::UnknownPath { noun, path }, near)
        } else {
            let near = self.near_visible(last, types, wanted);
            let name = last.text.clone();
            (NameProblem::Unknown { noun, name }, near)
        };
        let at = self.src(path.ptr);
        self.unresolved(at, kind, near);
    }

    /// The visible name that an unknown one means, or ours for a type or constant of another language.
    fn near_visible(
        &self,
        last: &Name,
        types: bool,
        wanted: impl Fn(&TypeKind) -> bool,
    ) -> Option<Near> {
        let candidates = self
            .scopes
            .visible(self.scope)
            .filter(|(_, ty)| wanted(&self.spec.ty(*ty).kind))
            .map(|(name, _)| name.as_str());
        let at = self.src(last.ptr);
        let foreign =
            if types { foreign::type_of(&last.text) } else { foreign::constant_of(&last.text) };
        let basic: &[&str] = if types { &foreign::TYPES } else { &[] };
        match foreign {
            Some(name) => Some(Near { plain: true, ..Near::new(at, name) }),
            None if types => {
                let candidates = candidates.chain(basic.iter().copied());
                self.near(at, &last.text, candidates)
            }
            // Constants are few, so that a name two edits away is meant.
            None => self.hint(at, || nearest_keyword(&last.text, candidates)),
        }
    }

    /// Wraps a type into the arrays of a declarator, the innermost dimension first.
    pub(super) fn declared_type(&mut self, base: TypeId, declarator: &'a Declarator) -> TypeId {
        let at = self.src(declarator.name.ptr);
        let lengths: Vec<Option<u64>> = declarator
            .dimensions
            .iter()
            .map(|dimension| self.size(dimension, "array size"))
            .collect();
        let mut element = base;
        for length in lengths.into_iter().rev() {
            element = match length {
                Some(length) => self.anonymous(TypeKind::Array { element, length }, at),
                None => self.unknown(at),
            };
        }
        element
    }

    /// A type with a bound, if it has one; unknown if the bound is.
    fn sized(
        &mut self,
        bound: Option<Option<u64>>,
        at: Src,
        kind: impl FnOnce(Option<u64>) -> TypeKind,
    ) -> TypeId {
        match bound {
            Some(None) => self.unknown(at),
            bound => self.anonymous(kind(bound.flatten()), at),
        }
    }

    /// The size of an array or a bound, with a warning if it is zero. `None` if it is not known, which was
    /// reported.
    fn size(&mut self, expr: &'a Expr, what: &'static str) -> Option<u64> {
        let at = self.src(expr.ptr);
        let size = self.non_negative_integer(expr, what)?;
        if size == 0 {
            self.error(at, ValueProblem::Zero { what });
        }
        if size > LARGEST_SIZE {
            self.error(at, ValueProblem::TooLarge { what, size });
        }
        Some(size)
    }
}

/// The largest size of an array and largest bound that the reference compiler accepts.
const LARGEST_SIZE: u64 = i32::MAX as u64;

/// The type behind aliases and `optional<>`.
pub(crate) fn resolve_aliases(spec: &Spec, mut ty: TypeId) -> TypeId {
    for _ in 0..=spec.types.len() {
        ty = spec.resolve_alias(ty);
        match spec.ty(ty).kind {
            TypeKind::Optional { element } => ty = element,
            _ => return ty,
        }
    }
    ty
}

/// Members of a struct, union or exception.
pub(crate) fn members(spec: &Spec, ty: TypeId) -> Option<&[TypeId]> {
    match &spec.ty(ty).kind {
        TypeKind::Struct { members }
        | TypeKind::Union { members, .. }
        | TypeKind::Exception { members } => Some(members),
        _ => None,
    }
}

pub(crate) fn member_named(spec: &Spec, ty: TypeId, name: &str) -> Option<TypeId> {
    let found = members(spec, ty)?;
    found.iter().copied().find(|member| spec.ty(*member).name.as_deref() == Some(name))
}

/// Returns true if two types are equal: aliases do not count, structs compare by their members. An unknown
/// type equals everything, since its error was reported.
pub(crate) fn equal(spec: &Spec, a: TypeId, b: TypeId) -> bool {
    equal_parts(spec, a, b, &mut FxHashSet::default())
}

/// Pairs of composite types that are equal unless a difference is found elsewhere. Each pair is compared only
/// once.
type ComparedPairs = FxHashSet<(TypeId, TypeId)>;

fn equal_parts(spec: &Spec, a: TypeId, b: TypeId, seen: &mut ComparedPairs) -> bool {
    let (a, b) = (spec.resolve_alias(a), spec.resolve_alias(b));
    if a == b {
        return true;
    }
    if members(spec, a).is_some() && !seen.insert((a, b)) {
        return true;
    }
    let mut all = |a: &[TypeId], b: &[TypeId]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| equal_parts(spec, *a, *b, seen))
    };
    use TypeKind as K;
    match (&spec.ty(a).kind, &spec.ty(b).kind) {
        (K::Unknown, _) | (_, K::Unknown) => true,
        (K::String { bound: a }, K::String { bound: b }) => a == b,
        (K::Array { .. }, K::Array { .. }) | (K::Sequence { .. }, K::Sequence { .. }) => {
            match (elements(spec, a), elements(spec, b)) {
                (Some((a, m)), Some((b, n))) => m == n && equal_element(spec, a, b, seen),
                _ => false,
            }
        }
        (K::Optional { element: a }, K::Optional { element: b }) => {
            equal_element(spec, *a, *b, seen)
        }
        (K::Struct { members: a }, K::Struct { members: b })
        | (K::Exception { members: a }, K::Exception { members: b }) => all(a, b),
        (K::Union { switch: s, members: a }, K::Union { switch: t, members: b }) => {
            all(&[*s], &[*t]) && all(a, b)
        }
        (K::Native, K::Native)
        | (K::Enum { .. }, K::Enum { .. })
        | (K::Enumerator { .. }, K::Enumerator { .. })
        | (K::Event, K::Event)
        | (K::PauseEvent, K::PauseEvent)
        | (K::Port { .. }, K::Port { .. })
        | (K::Remote { .. }, K::Remote { .. })
        | (K::ForwardStruct { .. }, K::ForwardStruct { .. })
        | (K::ForwardUnion { .. }, K::ForwardUnion { .. }) => {
            spec.full_name(a) == spec.full_name(b)
        }
        (
            K::Boolean
            | K::Octet
            | K::Char
            | K::Short
            | K::UnsignedShort
            | K::Long
            | K::UnsignedLong
            | K::LongLong
            | K::UnsignedLongLong
            | K::Float
            | K::Double
            | K::Any,
            _,
        ) => spec.ty(a).kind == spec.ty(b).kind,
        _ => false,
    }
}

/// Elements may be forward declarations, through which types can be recursive: these compare by name, before
/// aliases are resolved.
fn equal_element(spec: &Spec, a: TypeId, b: TypeId, seen: &mut ComparedPairs) -> bool {
    match (forward_target(spec, a), forward_target(spec, b)) {
        (None, None) => equal_parts(spec, a, b, seen),
        (a_target, b_target) => {
            let (a, b) = (a_target.unwrap_or(a), b_target.unwrap_or(b));
            a == b || spec.full_name(a) == spec.full_name(b)
        }
    }
}

/// The completion of a forward declaration.
fn forward_target(spec: &Spec, ty: TypeId) -> Option<TypeId> {
    match spec.ty(ty).kind {
        TypeKind::ForwardStruct { definition } | TypeKind::ForwardUnion { definition } => {
            Some(definition.unwrap_or(ty))
        }
        TypeKind::Typedef { ty } => forward_target(spec, ty),
        _ => None,
    }
}

/// Returns true if a type is or holds a native type.
pub(crate) fn has_native(spec: &Spec, ty: TypeId) -> bool {
    fn search(spec: &Spec, ty: TypeId, seen: &mut FxHashSet<TypeId>) -> bool {
        let ty = spec.resolve_alias(ty);
        match &spec.ty(ty).kind {
            TypeKind::Native => true,
            TypeKind::Array { element, .. }
            | TypeKind::Sequence { element, .. }
            | TypeKind::Optional { element } => search(spec, *element, seen),
            TypeKind::Struct { members }
            | TypeKind::Union { members, .. }
            | TypeKind::Exception { members } => {
                if !seen.insert(ty) {
                    return false;
                }
                members.iter().any(|member| search(spec, *member, seen))
            }
            _ => false,
        }
    }
    search(spec, ty, &mut FxHashSet::default())
}

/// The name of a type in messages.
pub(crate) fn display(spec: &Spec, ty: TypeId) -> String {
    let ty = spec.member_type(ty);
    match &spec.ty(ty).name {
        Some(name) => name.to_string(),
        None => spec.composed_text(ty, ", ", &|part| display(spec, part)),
    }
}

/// The number of elements of an array or bounded sequence, and their type.
pub(crate) fn elements(spec: &Spec, ty: TypeId) -> Option<(TypeId, Option<u64>)> {
    match spec.ty(ty).kind {
        TypeKind::Array { element, length } => Some((element, Some(length))),
        TypeKind::Sequence { element, bound } => Some((element, bound)),
        _ => None,
    }
}

/// The place of a type object.
pub(super) fn place(spec: &Spec, ty: TypeId) -> Src {
    spec.ty(ty).src
}
