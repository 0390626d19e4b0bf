//! Default values of parameters, matched to the members of their types (language reference,
//! section 16).

use super::{
    context::Elaborator,
    convert::{convert, explain_misfit},
    property, types,
    value::Const,
};
use crate::finding::role::Role;
use crate::{
    finding::{
        Finding, Near,
        values::{CountedNoun, Purpose, ValueProblem},
    },
    item_tree::{self, Designator},
    model::{InitValue, Initializer, PathElement, Src, TypeId, TypeKind},
    release::Change,
};

impl<'a> Elaborator<'a> {
    /// The default value of a parameter; `None` if it does not fit the type, which was reported.
    pub(super) fn initializer(
        &mut self,
        init: &'a item_tree::Initializer,
        ty: TypeId,
    ) -> Option<Initializer> {
        let ty = self.spec.member_type(ty);
        if says_nothing(init) {
            return None;
        }
        let member = match &init.designator {
            Some(Designator::Member(name)) => Some(PathElement::Member(name.text.clone())),
            Some(Designator::Index(index)) => {
                Some(PathElement::Index(self.non_negative_integer(index, "index")?))
            }
            None => None,
        };
        self.fit(init, ty, member)
    }

    fn fit(
        &mut self,
        init: &'a item_tree::Initializer,
        ty: TypeId,
        member: Option<PathElement>,
    ) -> Option<Initializer> {
        let at = self.src(init.ptr);
        // The members of a stand-in are invented: no value is wrong for them.
        if init.value.is_some() && self.is_from_stand_in(ty) {
            return None;
        }
        let value = match &init.value {
            None => InitValue::Void,
            Some(item_tree::InitValue::Scalar(expr)) => {
                let value = self.eval(expr);
                if value == Const::Unknown || self.is_unknown(ty) {
                    return None;
                }
                let last = types::resolve_aliases(&self.spec, ty);
                let opaque = matches!(
                    self.spec.ty(last).kind,
                    TypeKind::Native | TypeKind::Any | TypeKind::Exception { .. }
                );
                if opaque && self.spec.release.has(Change::OpaqueInitializers) {
                    self.error(
                        at,
                        ValueProblem::NoDefault { ty: types::display(&self.spec, ty).into() },
                    );
                    return None;
                }
                if matches!(
                    self.spec.ty(last).kind,
                    TypeKind::Array { .. }
                        | TypeKind::Sequence { .. }
                        | TypeKind::Struct { .. }
                        | TypeKind::Union { .. }
                ) {
                    self.error(
                        at,
                        ValueProblem::NeedsBraces { ty: types::display(&self.spec, ty).into() },
                    );
                    return None;
                }
                match convert(&self.spec, &value, ty) {
                    Ok(converted) => {
                        self.check_string_length(&value, ty, at);
                        InitValue::Scalar(converted)
                    }
                    Err(misfit) => {
                        self.error(
                            at,
                            explain_misfit(&self.spec, misfit, &value, ty, Purpose::Default),
                        );
                        return None;
                    }
                }
            }
            Some(item_tree::InitValue::Compound(parts)) if parts.iter().all(says_nothing) => {
                InitValue::Void
            }
            Some(item_tree::InitValue::Compound(parts)) => {
                InitValue::Compound(self.compound(parts, ty, at)?)
            }
        };
        Some(Initializer {
            member,
            doc: init.doc.as_ref().and_then(property::text),
            value,
            ty,
            src: at,
        })
    }

    fn compound(
        &mut self,
        parts: &'a [item_tree::Initializer],
        ty: TypeId,
        at: Src,
    ) -> Option<Vec<Initializer>> {
        let last = types::resolve_aliases(&self.spec, ty);
        let mut said = parts.iter().filter(|part| !says_nothing(part));
        let first = said.next().map_or(at, |part| self.src(part.ptr));
        match &self.spec.ty(last).kind {
            TypeKind::Array { element, length } => {
                let (element, length) = (*element, Some(*length));
                self.elements(parts, element, length, first)
            }
            TypeKind::Sequence { element, bound } => {
                let (element, bound) = (*element, *bound);
                self.elements(parts, element, bound, first)
            }
            TypeKind::Struct { members } | TypeKind::Union { members, .. } => {
                let members = members.clone();
                self.parts(parts, ty, &members, first)
            }
            TypeKind::Unknown => None,
            _ => {
                self.error(
                    at,
                    ValueProblem::NeedsNoBraces { ty: types::display(&self.spec, ty).into() },
                );
                None
            }
        }
    }

    /// The elements of an array or sequence. All problems are reported at the first initializer of the
    /// braces, as in the reference compiler.
    fn elements(
        &mut self,
        parts: &'a [item_tree::Initializer],
        element: TypeId,
        length: Option<u64>,
        first: Src,
    ) -> Option<Vec<Initializer>> {
        let mut fitted = Vec::with_capacity(parts.len());
        let mut complete = true;
        let mut position = 0u64;
        for part in parts.iter().filter(|part| !says_nothing(part)) {
            let here = self.src(part.ptr);
            match &part.designator {
                Some(Designator::Index(expr)) => match self.non_negative_integer(expr, "index") {
                    Some(index) => position = index,
                    None => complete = false,
                },
                Some(Designator::Member(name)) => {
                    self.report_part(
                        ValueProblem::ElementByName { name: name.text.clone() },
                        None,
                        first,
                        here,
                    );
                    return None;
                }
                None => {}
            }
            if let Some(length) = length.filter(|length| position >= *length) {
                self.report_part(ValueProblem::NoElement { position, length }, None, first, here);
                return None;
            }
            match self.fit(part, element, Some(PathElement::Index(position))) {
                Some(part) => fitted.push(part),
                None => complete = false,
            }
            position = position.saturating_add(1);
        }
        complete.then_some(fitted)
    }

    /// The members of a struct or union.
    fn parts(
        &mut self,
        parts: &'a [item_tree::Initializer],
        ty: TypeId,
        members: &[TypeId],
        first: Src,
    ) -> Option<Vec<Initializer>> {
        let mut fitted = Vec::with_capacity(parts.len());
        let mut complete = true;
        let mut position = 0;
        for part in parts.iter().filter(|part| !says_nothing(part)) {
            let here = self.src(part.ptr);
            match &part.designator {
                Some(Designator::Member(name)) => {
                    let named = |ty: &TypeId| self.spec.ty(*ty).name.as_ref() == Some(&name.text);
                    let Some(found) = members.iter().position(named) else {
                        let names = members
                            .iter()
                            .filter_map(|member| self.spec.ty(*member).name.as_deref());
                        let near = self.near(self.src(name.ptr), &name.text, names);

                        self.report_part(
                            ValueProblem::NoMember {
                                ty: types::display(&self.spec, ty).into(),
                                name: name.text.clone(),
                            },
                            near,
                            first,
                            here,
                        );
                        return None;
                    };
                    self.refer_type(self.src(name.ptr), members[found]);
                    position = found;
                }
                Some(Designator::Index(_)) => {
                    self.report_part(
                        ValueProblem::MemberByIndex { ty: types::display(&self.spec, ty).into() },
                        None,
                        first,
                        here,
                    );
                    return None;
                }
                None => {}
            }
            let Some(&member) = members.get(position) else {
                self.report_part(
                    ValueProblem::TooMany {
                        ty: types::display(&self.spec, ty).into(),
                        members: CountedNoun(members.len(), "member"),
                    },
                    None,
                    first,
                    here,
                );
                return None;
            };
            let (TypeKind::StructMember { ty } | TypeKind::UnionMember { ty, .. }) =
                &self.spec.ty(member).kind
            else {
                return None;
            };
            let (ty, name) = (*ty, self.spec.ty(member).name.clone().unwrap_or_default());
            match self.fit(part, ty, Some(PathElement::Member(name))) {
                Some(part) => fitted.push(part),
                None => complete = false,
            }
            position += 1;
        }
        complete.then_some(fitted)
    }

    fn report_part(&mut self, kind: ValueProblem, near: Option<Near>, first: Src, here: Src) {
        let mut diagnostic = Finding::new(kind, first).near(near);
        if here != first {
            diagnostic = diagnostic.related(here, Role::Initializer);
        }
        self.report(diagnostic);
    }
}

/// Returns true for empty braces. They fit every type, and in a list they are not counted.
fn says_nothing(init: &item_tree::Initializer) -> bool {
    init.designator.is_none()
        && matches!(&init.value, Some(item_tree::InitValue::Compound(parts))
            if parts.iter().all(says_nothing))
}
