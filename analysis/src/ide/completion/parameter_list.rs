//! Lists of parameters: their kinds, and the types in them.

use super::names::{VisibleNames, qualifier};
use crate::{
    ide::context::{BodyKind, Context, FrameKind, Word},
    model::{Service, ServiceId, TypeId},
};

pub(super) const DIRECTIONS: &[&str] = &["in", "out", "inout"];
pub(super) const SOURCES: &[&str] = &["ids", "local", "port", "remote"];

/// Parameter lists.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(in crate::ide) enum List {
    /// Of a codel; `simple` ones have neither ports nor remotes.
    Codel {
        simple: bool,
    },
    Attribute,
    /// Of a function or activity.
    Service,
}

/// The kind of parameter list of a frame, if it is one.
pub(in crate::ide) fn list_kind(context: &Context, frame: usize) -> Option<List> {
    let place = context.frames.get(frame)?;
    let parent = context.frames.get(frame.checked_sub(1)?)?;
    if place.kind != FrameKind::Paren || !matches!(parent.kind, FrameKind::Body(_)) {
        return None;
    }
    let head = context.head(place);
    // Another parenthesis before it: the list has ended, this is an execution time.
    if head.iter().any(|word| word.is(")")) {
        return None;
    }
    match head {
        [first, _, ..] if first.is("attribute") => Some(List::Attribute),
        [first, _, ..] if first.is_any(&["function", "activity"]) => Some(List::Service),
        [first, _, ..] if first.is("validate") => Some(List::Codel { simple: true }),
        [first, rest @ ..] if first.is_any(&["codel", "async"]) => {
            Some(List::Codel { simple: !rest.iter().any(|word| word.is("<")) })
        }
        _ => None,
    }
}

/// The service around the cursor, as far as it is known.
pub(in crate::ide) fn service_around<'a>(
    names: &VisibleNames<'a, '_>,
    context: &Context,
) -> Option<(ServiceId, &'a Service)> {
    let (body, frame) = context.body();
    if !matches!(body, BodyKind::Attribute | BodyKind::Function | BodyKind::Activity) {
        return None;
    }
    let name = context.name_of(frame)?;
    let mut all = names.component()?.services.iter_enumerated();
    all.find(|(_, service)| service.name == name)
}

pub(super) fn walk(names: &VisibleNames<'_, '_>, mut ty: TypeId, steps: &[Word]) -> Option<TypeId> {
    let mut steps = steps.iter();
    while let Some(step) = steps.next() {
        match step.text.as_str() {
            "." => {}
            "[" => {
                ty = names.element(ty)?;
                steps.by_ref().find(|step| step.is("]"));
            }
            name => ty = names.members(ty).into_iter().find(|member| member.0 == name)?.1,
        }
    }
    Some(ty)
}

/// The type of a parameter with these first words, in the parameter list of a service.
pub(in crate::ide) fn parameter_type(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    frame: usize,
    words: &[Word],
) -> Option<TypeId> {
    let words = match words.iter().position(|word| word.is("=")) {
        Some(eq) => &words[..eq],
        None => words,
    };
    let (dir, rest) = words.split_first()?;
    if !dir.is_any(DIRECTIONS) {
        return None;
    }
    match list_kind(context, frame)? {
        List::Attribute => {
            let path = rest.iter().position(|word| word.is("::")).unwrap_or(rest.len());
            let ids = names.component()?.ids?;
            if path == 0 {
                return Some(ids);
            }
            walk(names, ids, &rest[..path])
        }
        List::Service => names.type_before_name(rest),
        List::Codel { .. } => None,
    }
}

impl VisibleNames<'_, '_> {
    /// The switch type of the union around the cursor.
    pub(super) fn switch_type(&self, context: &Context) -> Option<TypeId> {
        let head = context.head(context.top());
        let open = head.iter().position(|word| word.is("("))?;
        let close = head.iter().rposition(|word| word.is(")"))?;
        // The bracket is in the place of a name.
        self.type_before_name(head.get(open + 1..=close)?)
    }

    /// The named type before the name of a declaration: `m::t name`.
    pub(in crate::ide) fn type_before_name(&self, words: &[Word]) -> Option<TypeId> {
        let (name, path) = words.split_last()?;
        // The bound of a string does not affect its values.
        let bound = path
            .iter()
            .position(|word| word.is("<"))
            .filter(|_| path.last().is_some_and(|path| path.is(">")));
        let path = &path[..bound.unwrap_or(path.len())];
        let last = path.last()?;
        if name.is("]") {
            return None;
        }
        let (absolute, mut segments) = qualifier(&path[..path.len() - 1]);
        segments.push(last.text.clone());
        match self.resolve(absolute, &segments) {
            Some(found) => found.ty,
            None => self.base_type(&last.text),
        }
    }

    fn base_type(&self, word: &str) -> Option<TypeId> {
        use crate::model::TypeKind::*;
        let fits = |kind: &crate::model::TypeKind| match word {
            "boolean" => matches!(kind, Boolean),
            "double" => matches!(kind, Double),
            "float" => matches!(kind, Float),
            "octet" => matches!(kind, Octet),
            "short" => matches!(kind, Short | UnsignedShort),
            "long" => matches!(kind, Long | UnsignedLong | LongLong | UnsignedLongLong),
            "char" => matches!(kind, Char),
            "string" => matches!(kind, String { .. }),
            _ => false,
        };
        self.spec().types.position(|ty| fits(&ty.kind))
    }
}
