//! Completion in default values.

use smol_str::SmolStr;

use super::{CompletionKind, Completions, names::VisibleNames};
use crate::{
    ide::{
        SymbolKind,
        context::{Context, Frame, FrameKind, Word},
        render,
    },
    model::{TypeId, TypeKind},
};

/// Between the braces of a compound.
pub(super) fn complete(names: &VisibleNames<'_, '_>, context: &Context, out: &mut Completions) {
    let ty = compound_type(names, context, context.frames.len() - 1);
    let words = context.current();
    match words {
        [] => {
            let Some(ty) = ty else {
                names.constants(words, None, out);
                return;
            };
            let given = given(context, context.top());
            for (i, (name, member)) in names.members(ty).into_iter().enumerate() {
                let used = given.contains(&name);
                let rank = if used { 6 } else { 0 };
                let value = value_snippet(names, member, 1);
                let item = out.snippet(format!(".{name} ="), format!(".{name} = {value}"), rank);
                item.kind = CompletionKind::Symbol(SymbolKind::Member);
                item.detail = Some(render::type_text(names.spec(), member));
                item.definition = names.definition_of(member);
                if i > 64 {
                    break;
                }
            }
            let next =
                names.element(ty).or_else(|| Some(names.members(ty).get(context.top().commas)?.1));
            value(names, words, next, out);
        }
        [dot] if dot.is(".") => {
            for (name, member) in ty.map(|ty| names.members(ty)).unwrap_or_default() {
                let item = out.add(name.as_str(), CompletionKind::Symbol(SymbolKind::Member), 0);
                item.detail = Some(render::type_text(names.spec(), member));
                item.definition = names.definition_of(member);
            }
        }
        _ => {
            let eq = words.iter().position(|word| word.is("="));
            let expected = ty.and_then(|ty| element_type(names, ty, words, context.top().commas));
            value(names, &words[eq.map_or(0, |eq| eq + 1)..], expected, out);
        }
    }
}

/// A value of a type.
pub(super) fn value(
    names: &VisibleNames<'_, '_>,
    before: &[Word],
    expected: Option<TypeId>,
    out: &mut Completions,
) {
    names.constants(before, expected, out);
    let Some(ty) = expected.filter(|_| before.is_empty()) else {
        return;
    };
    let members = names.members(ty);
    if !members.is_empty() {
        let all = members.iter().take(32).enumerate().map(|(i, (name, member))| {
            format!(".{name} = {}", value_snippet(names, *member, i + 1))
        });
        let all: Vec<String> = all.collect();
        out.snippet("{ … }", format!("{{ {} }}", all.join(", ")), 0);
    } else if names.element(ty).is_some() {
        out.snippet("{ … }", "{ $1 }", 0);
    }
}

/// A placeholder with a valid value.
fn value_snippet(names: &VisibleNames<'_, '_>, ty: TypeId, place: usize) -> String {
    let spec = names.spec();
    let value = match &spec.ty(names.value_type(ty)).kind {
        TypeKind::Boolean => "FALSE".to_owned(),
        TypeKind::Float | TypeKind::Double => "0.0".to_owned(),
        TypeKind::String { .. } | TypeKind::Char => "\"\"".to_owned(),
        TypeKind::Enum { enumerators } => {
            let first = enumerators.first().and_then(|enumerator| spec.full_name(*enumerator));
            first.unwrap_or_default()
        }
        TypeKind::Struct { .. }
        | TypeKind::Union { .. }
        | TypeKind::Array { .. }
        | TypeKind::Sequence { .. } => {
            return format!("{{ ${place} }}");
        }
        _ => "0".to_owned(),
    };
    format!("${{{place}:{value}}}")
}

/// The type that the braces of a frame initialize.
pub(in crate::ide) fn compound_type(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    frame: usize,
) -> Option<TypeId> {
    let place = context.frames.get(frame)?;
    let parent = context.frames.get(frame.checked_sub(1)?)?;
    let head = context.head(place);
    match parent.kind {
        FrameKind::Paren => super::parameter_list::parameter_type(names, context, frame - 1, head),
        FrameKind::Initializers => {
            let outer = compound_type(names, context, frame - 1)?;
            element_type(names, outer, head, parent.commas)
        }
        _ => None,
    }
}

/// The type of one element of a compound: the type of its designator, or by position.
pub(in crate::ide) fn element_type(
    names: &VisibleNames<'_, '_>,
    compound: TypeId,
    words: &[Word],
    commas: usize,
) -> Option<TypeId> {
    if let Some(element) = names.element(compound) {
        return Some(element);
    }
    let members = names.members(compound);
    match words {
        [dot, name, ..] if dot.is(".") => {
            let found = members.iter().find(|(text, _)| *text == name.text)?;
            Some(found.1)
        }
        _ => Some(members.get(commas)?.1),
    }
}

/// Members that already have a value between these braces.
fn given(context: &Context, frame: &Frame) -> Vec<SmolStr> {
    let words = &context.tokens[frame.open..];
    let designators =
        words.windows(3).filter(|window| window[0].is_any(&[",", "{"]) && window[1].is("."));
    designators.map(|designator| designator[2].text.clone()).collect()
}
