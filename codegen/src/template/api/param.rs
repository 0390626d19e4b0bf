//! Methods of parameters and of their default values.

use dotgen_analysis::model::{
    ComponentId, InitValue, Initializer, ParamSource, PathElement, TypeId, TypeKind,
};

use super::{Answer, AnswerResult, Model, method, undefined, wrong_args};
use crate::lang::{Anchor, inner, param_types, value_text};
use crate::template::Failure;
use crate::template::object::{Lookup, Object, ParamRef};

pub(super) const PARAM_METHODS: &[&str] = &[
    "name",
    "src",
    "direction",
    "member",
    "base",
    "type",
    "port",
    "remote",
    "param",
    "initializer",
    "loc",
    "class",
];

pub(super) const INITIALIZER_METHODS: &[&str] = &["member", "doc", "kind", "value", "loc", "class"];

pub(super) fn param(
    model: &Model<'_>,
    component: ComponentId,
    at: ParamRef,
    words: &[String],
) -> AnswerResult {
    let declaration = model.spec.param(component, at);
    let method = method(PARAM_METHODS, words, "name")?;
    let arguments = words.get(1..).unwrap_or_default();
    match method {
        "initializer" if arguments.len() > 1 => {
            return Err(wrong_args("$param initializer ?type?"));
        }
        "initializer" => {}
        "loc" if arguments.len() > 1 => return Err(wrong_args("$param loc ?element?")),
        "loc" => {}
        _ if arguments.is_empty() => {}
        _ => return Err(wrong_args("$param subcommand")),
    }
    let (base, ty) = param_types(model.spec, component, declaration);
    let object = matches!(declaration.source, ParamSource::Port(_) | ParamSource::Remote(_));
    let answer = match method {
        "name" => Some(Answer::pure(declaration.name.to_string())),
        "src" => Some(Answer::pure(declaration.source.word().into())),
        "direction" => Some(Answer::pure(declaration.dir.word().into())),
        "member" if object || declaration.path.is_empty() => Some(Answer::pure(String::new())),
        "member" => {
            let text = model.mapper().member_path(base, &declaration.path)?;
            Some(Answer::pure(text))
        }
        "base" => Some(model.type_handle(base)),
        "type" => Some(model.type_handle(ty)),
        "port" => match declaration.source {
            ParamSource::Port(port) => Some(model.handle(Object::Port(component, port))),
            _ => None,
        },
        "remote" => match declaration.source {
            ParamSource::Remote(remote) => Some(model.handle(Object::Remote(component, remote))),
            _ => None,
        },
        "param" => match (declaration.source, at) {
            (ParamSource::Local(Some(index)), ParamRef::Codel(codel, _)) => match codel.owner {
                dotgen_analysis::model::Owner::Service(service) => {
                    let param = ParamRef::Service(service, index);
                    Some(model.handle(Object::Param(component, param)))
                }
                dotgen_analysis::model::Owner::Task(_) => None,
            },
            _ => None,
        },
        "initializer" => initializer_of(model, component, at, arguments)?,
        "loc" => {
            let declared = matches!(at, ParamRef::Service(..) | ParamRef::Remote(..))
                && matches!(declaration.source, ParamSource::Local(_));
            let anchor = if declared { Anchor::Named(&declaration.name) } else { Anchor::Path };
            model.place_of(declaration.src, anchor, arguments)?
        }
        _ => Some(Answer::pure("parameter".into())),
    };
    answer.ok_or_else(|| undefined(method))
}

/// The default value of a parameter, or the part of it for a type.
fn initializer_of(
    model: &Model<'_>,
    component: ComponentId,
    at: ParamRef,
    arguments: &[String],
) -> Result<Option<Answer>, Failure> {
    let declaration = model.spec.param(component, at);
    Ok(match (arguments.first(), &declaration.init) {
        (None, Some(_)) => Some(model.handle(Object::Initializer(component, at, Vec::new()))),
        (None, None) => None,
        (Some(handle), init) => {
            let Some(Object::Type(ty)) = model.registry.object(handle) else {
                return Err(Failure::Error(format!("no such type \"{handle}\"")));
            };
            let mut path = Vec::new();
            let steps = 2 * model.spec.types.len();
            let found = init
                .as_ref()
                .is_some_and(|init| find_part(model, init, declaration.ty, *ty, &mut path, steps));
            if !found {
                return Err(Failure::Error("no initializer for type".into()));
            }
            Some(model.handle(Object::Initializer(component, at, path)))
        }
    })
}

/// Finds the part of a default value for a type inside the whole type.
fn find_part(
    model: &Model<'_>,
    init: &Initializer,
    of: TypeId,
    wanted: TypeId,
    path: &mut Vec<u32>,
    steps: usize,
) -> bool {
    if of == wanted {
        return true;
    }
    let Some(steps) = steps.checked_sub(1) else {
        return false;
    };
    let parts: &[Initializer] = match &init.value {
        InitValue::Compound(parts) => parts,
        _ => &[],
    };
    match &model.spec.ty(of).kind {
        TypeKind::Array { element, .. }
        | TypeKind::Sequence { element, .. }
        | TypeKind::Optional { element } => match parts.first() {
            Some(part) => {
                path.push(0);
                let found = find_part(model, part, *element, wanted, path, steps);
                if !found {
                    path.pop();
                }
                found
            }
            None => false,
        },
        TypeKind::Struct { members }
        | TypeKind::Union { members, .. }
        | TypeKind::Exception { members } => {
            for (index, part) in parts.iter().enumerate() {
                let Some(PathElement::Member(name)) = &part.member else {
                    continue;
                };
                let member = members
                    .iter()
                    .find(|member| model.spec.ty(**member).name.as_ref() == Some(name));
                let Some(member) = member else {
                    continue;
                };
                path.push(index as u32);
                if find_part(model, part, *member, wanted, path, steps) {
                    return true;
                }
                path.pop();
            }
            false
        }
        TypeKind::StructMember { .. }
        | TypeKind::Typedef { .. }
        | TypeKind::ForwardStruct { .. }
        | TypeKind::ForwardUnion { .. } => inner(model.spec, of)
            .is_some_and(|inner| find_part(model, init, inner, wanted, path, steps)),
        _ => false,
    }
}

pub(super) fn initializer(
    model: &Model<'_>,
    component: ComponentId,
    param: ParamRef,
    path: &[u32],
    words: &[String],
) -> AnswerResult {
    if words.len() > 1 {
        return Err(wrong_args("$initializer subcommand"));
    }
    let method = method(INITIALIZER_METHODS, words, "kind")?;
    let Some(initializer) = model.spec.initializer(component, param, path) else {
        return Err(undefined(method));
    };
    let answer = match method {
        "member" => initializer.member.as_ref().map(|member| {
            Answer::pure(match member {
                PathElement::Member(name) => name.to_string(),
                PathElement::Index(index) => index.to_string(),
            })
        }),
        "doc" => initializer.doc.clone().map(Answer::pure),
        "kind" => Some(Answer::pure(
            match &initializer.value {
                InitValue::Void => "void",
                InitValue::Scalar(value) => value.word(),
                InitValue::Compound(_) => "compound",
            }
            .into(),
        )),
        "value" => Some(match &initializer.value {
            InitValue::Void => Answer::pure(String::new()),
            InitValue::Scalar(value) => Answer::pure(value_text(model.spec, value)),
            InitValue::Compound(parts) => model.list((0..parts.len() as u32).map(|part| {
                let mut inside = path.to_vec();
                inside.push(part);
                Object::Initializer(component, param, inside)
            })),
        }),
        "loc" => model.location(initializer.src, Anchor::First),
        _ => Some(Answer::pure("initializer".into())),
    };
    answer.ok_or_else(|| undefined(method))
}
