//! Paths of parameters: members and elements.

use super::PathParts;
use crate::{
    elab::{context::Elaborator, types},
    finding::codels::CodelProblem,
    item_tree::{Name, PathStep},
    model::{PathElement, Src, TypeId, TypeKind},
};

impl<'a> Elaborator<'a> {
    /// Follows the rest of a path from a type.
    pub(super) fn walk(
        &mut self,
        mut ty: TypeId,
        written: &PathParts<'a>,
        path: &mut Vec<PathElement>,
    ) -> Option<TypeId> {
        for (number, step) in written.rest.iter().enumerate() {
            let last = types::resolve_aliases(&self.spec, ty);
            let unknown = self.spec.ty(last).kind == TypeKind::Unknown;
            if unknown {
                self.lack_member(last, &written.rest[number..]);
            }
            match step {
                PathStep::Member(name) => {
                    if unknown {
                        return None;
                    }
                    let Some(member) = self.select(last, name) else {
                        if self.is_from_stand_in(last) {
                            self.lack_member(last, &written.rest[number..]);
                        } else {
                            self.report_no_member(ty, last, name, written.at);
                        }
                        return None;
                    };
                    if let Some(def) = self.type_defs[member] {
                        let at = self.src(name.ptr);
                        self.refer_as(at, def, written.access);
                    }
                    path.push(PathElement::Member(name.text.clone()));
                    ty = self.spec.member_type(member);
                }
                PathStep::Index(expr) => {
                    let number = self.non_negative_integer(expr, "index")?;
                    if unknown {
                        return None;
                    }
                    let Some((element, length)) = types::elements(&self.spec, last) else {
                        self.error(
                            written.at,
                            CodelProblem::NoElements {
                                ty: types::display(&self.spec, ty).into(),
                                number,
                            },
                        );
                        return None;
                    };
                    if let Some(length) = length
                        && number >= length
                    {
                        let ty = types::display(&self.spec, ty).into();
                        let kind = match length.checked_sub(1) {
                            Some(last) => CodelProblem::Beyond { number, length, ty, last },
                            None => CodelProblem::BeyondEmpty { number, ty },
                        };
                        self.error(written.at, kind);
                    }
                    path.push(PathElement::Index(number));
                    ty = element;
                }
            }
        }
        Some(ty)
    }

    fn select(&self, ty: TypeId, name: &Name) -> Option<TypeId> {
        match &self.spec.ty(ty).kind {
            TypeKind::Enum { enumerators } => enumerators
                .iter()
                .copied()
                .find(|enumerator| self.spec.ty(*enumerator).name.as_ref() == Some(&name.text)),
            _ => types::member_named(&self.spec, ty, &name.text),
        }
    }

    fn report_no_member(&mut self, ty: TypeId, last: TypeId, name: &Name, at: Src) {
        let members = types::members(&self.spec, last);
        let ty = types::display(&self.spec, ty).into();
        let (kind, near) = if let Some(members) = members {
            let names = members.iter().filter_map(|member| self.spec.ty(*member).name.as_deref());
            let near = self.near(self.src(name.ptr), &name.text, names);
            let name = name.text.clone();
            (CodelProblem::NoMember { ty, name }, near)
        } else {
            let name = name.text.clone();
            (CodelProblem::NoMembers { ty, name }, None)
        };

        self.unresolved(at, kind, near);
    }
}
