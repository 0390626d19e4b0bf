//! Values in expressions, and the types and members that they have.

use smol_str::SmolStr;

use super::{NameCategory, VisibleNames};
use crate::{
    elab::{DefKind, convert::holds, types::resolve_aliases},
    ide::{
        completion::{CompletionItem, Completions},
        context::Word,
    },
    model::{TypeId, TypeKind, Value},
};

/// The rank of items that are not proposed.
const NOT_PROPOSED: u8 = u8::MAX;

impl VisibleNames<'_, '_> {
    /// Everything that may be in an expression; values of the `expected` type first.
    pub(in crate::ide::completion) fn constants(
        &self,
        before: &[Word],
        expected: Option<TypeId>,
        out: &mut Completions,
    ) {
        if is_operand(before) {
            return;
        }
        let first = out.items.len();
        self.scoped(before, NameCategory::Constants, 3, out);
        let spec = self.spec();
        let resolved = expected.map(|ty| self.value_type(ty));
        for item in &mut out.items[first..] {
            let ty = item.definition.and_then(|id| self.elaborated.definition(id).ty);
            let of = match ty.map(|ty| &spec.ty(ty).kind) {
                Some(TypeKind::Enumerator { enumeration, .. }) => Some(*enumeration),
                Some(TypeKind::Const { ty, .. }) => Some(self.value_type(*ty)),
                _ => None,
            };
            let value = ty.and_then(|ty| match &spec.ty(ty).kind {
                TypeKind::Const { value, .. } => Some(value),
                _ => None,
            });
            let holds = |ty| value.is_none_or(|node| holds(spec, ty, node));
            match (resolved, of) {
                (Some(wanted), Some(of)) if self.same_type(wanted, of) && holds(wanted) => {
                    item.rank = 0;
                }
                // Other values do not convert.
                (Some(_), Some(_)) => item.rank = NOT_PROPOSED,
                _ => {}
            }
        }
        out.items.retain(|completion_item| completion_item.rank != NOT_PROPOSED);
        if before.last().is_some_and(|word| word.is("::")) {
            return;
        }
        let boolean = resolved.is_some_and(|ty| matches!(spec.ty(ty).kind, TypeKind::Boolean));
        if boolean || resolved.is_none() {
            out.keywords(&["TRUE", "FALSE"], if boolean { 0 } else { 6 });
        }
    }

    /// Constants that are numbers; with `whole`, only non-negative integers.
    pub(in crate::ide::completion) fn numbers(
        &self,
        before: &[Word],
        whole: bool,
        out: &mut Completions,
    ) {
        if is_operand(before) {
            return;
        }
        let first = out.items.len();
        self.scoped(before, NameCategory::Constants, 3, out);
        let spec = self.spec();
        let fits = |item: &CompletionItem| {
            let definition = self.elaborated.definition(item.definition?);
            // Names that are only the beginning of a path.
            let Some(TypeKind::Const { value, .. }) = definition.ty.map(|ty| &spec.ty(ty).kind)
            else {
                return Some(!matches!(definition.kind, DefKind::Enumerator));
            };
            Some(match value {
                Value::Uint(_) => true,
                Value::Int(number) => *number >= 0,
                Value::Float(number) => !whole && *number >= 0.0,
                _ => false,
            })
        };
        let mut index = 0;
        out.items.retain(|completion_item| {
            index += 1;
            index <= first || fits(completion_item).unwrap_or(true)
        });
    }

    /// A type without aliases and optionals.
    pub(in crate::ide) fn value_type(&self, id: TypeId) -> TypeId {
        resolve_aliases(self.spec(), id)
    }

    fn same_type(&self, a: TypeId, b: TypeId) -> bool {
        let number = |ty: TypeId| {
            let kind = &self.spec().ty(ty).kind;
            kind.integer().is_some() || matches!(kind, TypeKind::Float | TypeKind::Double)
        };
        a == b || number(a) && number(b) || self.spec().ty(a).kind == self.spec().ty(b).kind
    }

    /// Members of a struct, union, exception or ids, also of the elements of an array.
    pub(in crate::ide) fn members(&self, ty: TypeId) -> Vec<(SmolStr, TypeId)> {
        let spec = self.spec();
        let members = match &spec.ty(self.value_type(ty)).kind {
            TypeKind::Struct { members }
            | TypeKind::Union { members, .. }
            | TypeKind::Exception { members } => members.as_slice(),
            _ => return Vec::new(),
        };
        let named =
            members.iter().filter_map(|&member| Some((spec.ty(member).name.clone()?, member)));
        named.collect()
    }

    /// The type that `[n]` selects.
    pub(in crate::ide) fn element(&self, ty: TypeId) -> Option<TypeId> {
        match self.spec().ty(self.value_type(ty)).kind {
            TypeKind::Array { element, .. } | TypeKind::Sequence { element, .. } => Some(element),
            _ => None,
        }
    }
}

/// Returns true if an expression ends in an operand, so that an operator or nothing comes next.
fn is_operand(before: &[Word]) -> bool {
    use dotgen_syntax::SyntaxKind::*;
    let last = before.last().map(|word| word.kind);
    matches!(last, Some(INT | FLOAT | STRING | CHAR | IDENT | R_PAREN | R_CURLY | R_BRACK))
}
